use std::{collections::BTreeSet, fs, path::Path};

use localizer::bounds;
use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, wherein};

/// A push to the left, which breaks several bounds, and a change of friction on a region.
const EVENTS: &str = "[[floor.region]]\nname = \"oil\"\nx_m = [1.0, 2.0]\ny_m = [0.5, 1.5]\nfriction = 0.5\n\
                      [[event]]\nkind = \"push\"\nat_s = 0.5\ndisplacement_m = [-0.05, 0.1]\nlasts_s = 0.2\n\
                      [[event]]\nkind = \"friction\"\nat_s = 1.0\nregion = \"oil\"\nfriction = 0.2\n\
                      [expect]\nbound_broken = 0\n";

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_report_tells_every_event_and_every_broken_bound_with_its_unit() {
    let folder = folder("incidents");
    fs::write(folder.join("scene.toml"), blind_scene(2.0, EVENTS)).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--out", "out"]));
    assert_eq!(code, 1, "{stderr}");
    assert_eq!(outcome(&mut wherein(&folder, &["report", "out"])).0, 1);
    let html = fs::read_to_string(folder.join("out/report.html")).unwrap();
    let summary = summary(&folder.join("out/scene/0"));
    // The robot stands at (0.6, 0.6), within the tolerance of its start, until it drives off.
    let events = summary["events"].as_array().unwrap();
    assert_eq!(events.len(), 2, "{events:?}");
    let place = |event: &Value| [&event["x_m"], &event["y_m"]].map(|at| at.as_f64().unwrap());
    assert!(place(&events[0]).iter().all(|at| (0.4..0.9).contains(at)), "{events:?}");
    for (event, told) in events.iter().zip([
        "0.50 s to 0.70 s: pushed 0.05 m back and 0.1 m to the left, robot at (",
        "1.00 s: friction on oil changes to 0.2, robot at (",
    ]) {
        let [x_m, y_m] = place(event);
        assert!(html.contains(&format!("<li>{told}{x_m:.2} m, {y_m:.2} m)</li>")), "{told}");
        assert!(html.contains("<rect class=\"event\"") && html.contains(&format!("<title>{told}")));
    }
    let violations = summary["violations"].as_array().unwrap();
    let broken: BTreeSet<&str> = violations.iter().map(|one| one["bound"].as_str().unwrap()).collect();
    assert!(broken.len() > 1, "the push breaks several bounds: {broken:?}");
    let table = html.split("<tbody class=\"broken\">").nth(1).unwrap().split("</tbody>").next().unwrap();
    for name in broken {
        let row = table.split("<tr>").find(|row| row.contains(&format!(">{name}<"))).unwrap();
        let unit = bounds::ALL.iter().find(|bound| bound.name == name).unwrap().unit;
        let shown: Vec<&str> = row.split("<td>").skip(1).map(|cell| cell.split("</td>").next().unwrap()).collect();
        assert_eq!(shown.len(), 2, "a declared and a greatest value: {row}");
        let has_unit =
            |value: &&str| unit == "1" || value.ends_with(&format!(" {unit}")) || value.ends_with(&format!(" m{unit}"));
        assert!(shown.iter().all(has_unit) && row.contains(" s to "), "{row} in {unit}");
        assert!(stderr.contains(&format!("  {name} broken at ")), "the terminal names {name}, too:\n{stderr}");
    }
}

#[test]
fn of_two_pushes_each_breaks_the_bounds_at_its_own_time() {
    let folder = folder("two_pushes");
    let push =
        |at_s: f64| format!("[[event]]\nkind = \"push\"\nat_s = {at_s}\ndisplacement_m = [0.0, 0.05]\nlasts_s = 0.2\n");
    fs::write(folder.join("scene.toml"), blind_scene(4.0, &(push(0.5) + &push(2.5)))).unwrap();
    outcome(&mut wherein(&folder, &["run", "scene.toml", "--out", "out"]));
    let summary = summary(&folder.join("out/scene/0"));
    let violations = summary["violations"].as_array().unwrap();
    let spans = |bound: &str| -> Vec<[f64; 2]> {
        let of_it = violations.iter().filter(|one| one["bound"] == bound);
        of_it.map(|one| ["from_s", "to_s"].map(|end| one[end].as_f64().unwrap())).collect()
    };
    for bound in ["reach.acceleration", "wheels.side_slip"] {
        let spans = spans(bound);
        assert!(spans.len() >= 2, "{bound}: {spans:?}");
        // The robot has come to rest on its wheels a second after each push, and nothing is broken until the next one.
        assert!(spans.iter().all(|[from_s, to_s]| *to_s < 1.7 || *from_s > 2.4), "{bound}: {spans:?}");
        assert!(spans.windows(2).all(|pair| pair[0][1] < pair[1][0]), "{bound}: {spans:?}");
    }
}

#[test]
fn bounds_that_break_in_a_run_that_passes_are_told() {
    let folder = folder("broken_all_the_same");
    let told = |name: &str, more: &str| {
        fs::write(
            folder.join(name),
            blind_scene(2.0, more)
                .replace("floor_camera = false", "floor_camera = false\n[robot.base]\nwheel_wear = [0.01, 0.0]"),
        )
        .unwrap();
        let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["run", name, "--seeds", "0..2"]));
        assert_eq!(code, 0, "{stderr}");
        stdout
    };
    let worn = told("worn.toml", "");
    // A wheel that is worn by 1 % exceeds the tolerance of 0.2 % four to six times, as its radius is also drawn within it.
    let line = worn.lines().find(|line| line.starts_with("worn: bounds were broken in 2 runs that passed")).unwrap();
    let times = line.split("wheels.radius ").nth(1).unwrap().split(' ').next().unwrap();
    assert!((4.0..=6.0).contains(&times.parse::<f64>().unwrap()), "{line}");
    // Where the scene has an event, a broken bound is no surprise.
    let push = "[[event]]\nkind = \"push\"\nat_s = 1.5\ndisplacement_m = [0.0, 0.001]\nlasts_s = 0.4\n";
    assert!(!told("pushed.toml", push).contains("bounds were broken"));
}
