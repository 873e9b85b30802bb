use std::fs;

use crate::command::{folder_of, outcome, root, wherein};

/// What the page shows in code blocks of one language, each with the text before it.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<(&'a str, &'a str)> {
    let fence = format!("```{language}\n");
    let starts = page.match_indices(&fence).map(|(at, _)| at);
    starts.map(|at| (&page[..at], page[at + fence.len()..].split("```").next().unwrap())).collect()
}

#[test]
fn every_command_of_the_first_hour_ends_as_the_page_says() {
    let page = fs::read_to_string(root().join("docs/src/first_hour.md")).unwrap();
    let scenes = blocks(&page, "toml");
    let named = scenes.iter().map(|(before, scene)| {
        let (_, name) = before.rsplit_once("ut this into `").expect("the page says into which file a scene is put");
        (name.split('`').next().unwrap(), *scene)
    });
    let place = folder_of("first_hour", &named.collect::<Vec<_>>());
    let commands: Vec<&str> =
        blocks(&page, "sh").into_iter().flat_map(|(_, block)| block.lines()).filter(|line| !line.is_empty()).collect();
    assert!(scenes.len() == 2 && commands.len() >= 8, "{commands:?}");
    for line in commands {
        // A command that does not end with 0 says so in its comment.
        let (command, comment) = line.split_once(" #").unwrap_or((line, ""));
        let expected = comment.trim().strip_prefix("exit code ").map_or(0, |code| code.parse().unwrap());
        let arguments: Vec<&str> = command.split_whitespace().collect();
        assert_eq!(arguments[0], "wherein", "{line}");
        let (code, stdout, stderr) = outcome(&mut wherein(&place, &arguments[1..]));
        assert_eq!(code, expected, "{line}\n{stdout}\n{stderr}");
    }
    // What the page says to look at is there, and says what the page says.
    let figure = place.join("renders/x/0/figure_00020.png");
    let report = fs::read_to_string(place.join("renders/report.html")).unwrap();
    assert!(figure.is_file() && place.join("sweeps/x/report.html").is_file());
    assert!(report.contains("wheels.side_slip"), "the push breaks the bound that the page names");
    let summary = |run: &str| -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(place.join(run).join("summary.json")).unwrap()).unwrap()
    };
    let pushed = summary("renders/pushed/0");
    assert_eq!(pushed["containment"]["first_failure"]["blame"], "wheels.side_slip");
    assert!(!pushed["contradictions"].as_array().unwrap().is_empty(), "the localizer notices the push");
    assert_eq!(summary("filtered/x/0")["subject"], "ekf");
    for seed in 0..2 {
        assert!(summary(&format!("renders/x/{seed}"))["availability"].as_f64().unwrap() >= 0.95);
    }
}
