use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use sim::{
    campaign::{cases::from_csv, sweep::Sweep},
    loading::SceneTemplate,
};

use crate::command::{blind_scene, folder, outcome, root, wherein};

/// Text of a scene file: a push of 0.1 m within 0.2 s breaks the bound on slip, and half of the cases of the sweep below expect narrower boxes
/// than there are.
const PUSHED: &str = "[[event]]\nkind = \"push\"\nat_s = 0.5\ndisplacement_m = [0.0, 0.1]\nlasts_s = 0.2\n\
                      [expect]\nunsound = 0\navailability_min = 0.4\n";

/// Sweeps over two declared widths, two frictions and two seeds into `out`, and asserts that the exit code is 1; returns the folder and the
/// output.
fn swept(name: &str, more: &[&str]) -> (PathBuf, String) {
    let folder = folder(name);
    fs::write(folder.join("scene.toml"), blind_scene(1.0, PUSHED)).unwrap();
    let mut sweep = vec!["sweep", "scene.toml", "--vary", "localizer.declared_width_m=0.001,1", "--out", "out"];
    sweep.extend(["--vary", "floor.friction=0.5,0.8", "--seeds", "0..2"]);
    sweep.extend(more);
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &sweep));
    assert_eq!(code, 1, "{stdout}{stderr}");
    (folder, stdout)
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

/// Rows of `results.csv`, each with its fields by the name of the column.
fn rows(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let (names, rows) = from_csv(&read(folder, "out/results.csv")).unwrap();
    rows.into_iter().map(|row| names.iter().cloned().zip(row).collect()).collect()
}

fn number(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap()
}

/// Texts of the cells in the body of an HTML table with this id, row by row.
fn table(html: &str, id: &str) -> Vec<Vec<String>> {
    let body = html.split(&format!("<tbody id=\"{id}\">")).nth(1).unwrap().split("</tbody>").next().unwrap();
    let text = |cell: &str| cell.split_once('>').unwrap().1.split("</td>").next().unwrap().to_owned();
    body.split("<tr>").skip(1).map(|row| row.split("<td").skip(1).map(text).collect()).collect()
}

#[test]
fn the_page_is_one_file_that_runs_nothing_and_fetches_nothing() {
    let (folder, _) = swept("report_alone", &[]);
    let html = read(&folder, "out/report.html");
    for refused in ["<script", "javascript:", "http:", "https:", "//", "@import", "url(", "<link", "<iframe", " onload"]
    {
        let found = html.find(refused).map(|at| &html[at.saturating_sub(40)..(at + 40).min(html.len())]);
        assert_eq!(found, None, "`{refused}`");
    }
    assert!(html.contains("width=device-width") && html.contains("prefers-color-scheme: dark"));
    assert!(html.len() < 3_000_000);
}

#[test]
fn the_verdict_comes_before_everything_else() {
    let (folder, stdout) = swept("report_verdict", &[]);
    let html = read(&folder, "out/report.html");
    let at = |part: &str| html.find(part).unwrap_or_else(|| panic!("`{part}` is missing"));
    assert!(at("✕ Failed") < at("<dl") && at("<dl") < at("<h2"));
    assert!(at("Of 8 cases, 4 missed an expectation.") < at("<dl"));
    assert!(stdout.contains("FAILED: Of 8 cases, 4 missed an expectation."), "{stdout}");
    assert!(
        read(&folder, "out/summary.md").starts_with("## ❌ failed: scene\n\nOf 8 cases, 4 missed an expectation.\n")
    );
}

#[test]
fn the_numbers_of_the_page_and_of_the_summary_are_those_of_the_csv() {
    let (folder, _) = swept("report_numbers", &[]);
    let html = read(&folder, "out/report.html");
    let rows = rows(&folder);
    let percent = |share: f64| if share >= 1.0 { "100".to_owned() } else { format!("{:.2}", share * 1e2) };
    let each = table(&html, "cases");
    assert_eq!((each.len(), rows.len()), (8, 8));
    for (told, row) in each.iter().zip(&rows) {
        assert_eq!(told[0], row["set.localizer.declared_width_m"]);
        assert_eq!(told[1..3], [row["set.floor.friction"].clone(), row["seed"].clone()]);
        assert_eq!(told[3], if row["passed"] == "true" { "passed" } else { "FAILED" });
        let share = number(row, "containment.contained") / number(row, "containment.checks");
        assert!(share < 1.0, "the push is to be seen");
        assert_eq!(told[4], percent(share));
        let width_m = number(row, "width.x_m.mean").max(number(row, "width.y_m.mean"));
        assert_eq!(told[5], format!("{:.1}", 1e3 * width_m));
        assert_eq!(told[6], format!("{:.2}", 1e3 * number(row, "error.position_m.mean")));
        assert_eq!(told[7], row["blame"]);
    }
    let markdown = read(&folder, "out/summary.md");
    // Both seeds of a combination run equally long, so that the combination's figures are plain means of the two rows.
    for (told, pair) in table(&html, "combinations").iter().zip(rows.chunks(2)) {
        let mean = |name: &str| (number(&pair[0], name) + number(&pair[1], name)) / 2.0;
        let figures = [
            percent(mean("containment.contained") / mean("containment.checks")),
            format!("{:.1}", 1e3 * mean("width.x_m.mean").max(mean("width.y_m.mean"))),
            format!("{:.2}", 1e3 * mean("error.position_m.mean")),
            percent(mean("availability")),
        ];
        assert_eq!(told[3..], figures);
        let keys = [&pair[0]["set.localizer.declared_width_m"], &pair[0]["set.floor.friction"]];
        let passed = if pair[0]["passed"] == "true" { "2/2" } else { "0/2" };
        let line = format!("| {} | {} | {passed} | {} |\n", keys[0], keys[1], figures.join(" | "));
        assert!(markdown.contains(&line), "`{line}` is missing in:\n{markdown}");
    }
}

#[test]
fn tables_for_people_have_eight_columns_and_others_by_name() {
    let (folder, printed) = swept("report_columns_chosen", &["--columns", "goals,available"]);
    let headings =
        |summary: &str| summary.lines().find(|line| line.starts_with("| ")).unwrap().matches('|').count() - 1;
    let html = read(&folder, "out/report.html");
    // Two keys and how many passed, then the two figures that were asked for; a drive without errands has no share of goals reached.
    assert_eq!(table(&html, "combinations")[0].len(), 5);
    assert_eq!(table(&html, "all_figures")[0].len(), 7);
    assert_eq!(table(&html, "combinations")[0][3], "");
    assert!(printed.contains("--columns all shows"), "{printed}");
    assert_eq!(headings(&read(&folder, "out/summary.md")), 5);
    let again = |columns: &[&str]| outcome(&mut wherein(&folder, &[&["report", "out"], columns].concat()));
    assert_eq!(again(&["--columns", "all"]).0, 1);
    assert!(
        headings(&read(&folder, "out/summary.md")) == 7 && !read(&folder, "out/report.html").contains("all_figures")
    );
    assert_eq!(again(&[]).0, 1);
    assert!(headings(&read(&folder, "out/summary.md")) <= 8);
    let html = read(&folder, "out/report.html");
    assert!(["combinations", "cases"].iter().all(|id| table(&html, id)[0].len() <= 8), "{html}");
    let (code, _, refusal) = again(&["--columns", "width,eror"]);
    assert_eq!(code, 2);
    assert!(refusal.contains("unknown column `eror`") && refusal.contains("contained, width, error"), "{refusal}");
}

#[test]
fn many_keys_share_a_column_so_that_figures_have_room() {
    let more =
        ["floor.friction=0.5,0.8", "start.tolerance_m=0.01,0.02", "duration_s=0.5,1", "bounds.slip_ratio=0.01,0.02"];
    let folder = folder("report_many_keys");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let mut sweep = vec!["sweep", "scene.toml", "--vary", "localizer.declared_width_m=0.9,1", "--out", "out"];
    more.iter().for_each(|varied| sweep.extend(["--vary", varied]));
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &sweep));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let html = read(&folder, "out/report.html");
    let first = &table(&html, "combinations")[0];
    assert_eq!(first[0], "declared_width_m=0.9 friction=0.5 tolerance_m=0.01 duration_s=0.5 slip_ratio=0.01");
    assert!(first[1] == "1/1" && first[2] == "100" && first.len() <= 8, "{first:?}");
    assert_eq!(
        table(&html, "cases")[31][0],
        first[0]
            .replace("0.9 ", "1 ")
            .replace("0.5 t", "0.8 t")
            .replace("0.01 d", "0.02 d")
            .replace("0.5 s", "1 s")
            .replace("o=0.01", "o=0.02")
    );
    assert!(stdout.lines().next().unwrap().trim_start().starts_with("settings"), "{stdout}");
}

#[test]
fn every_column_is_documented() {
    let (folder, _) = swept("report_columns", &[]);
    let documented = fs::read_to_string(root().join("docs/src/sweeps.md")).unwrap();
    let (names, _) = from_csv(&read(&folder, "out/results.csv")).unwrap();
    for name in names {
        let family = name.split('.').next().unwrap();
        let is_there = documented.contains(&format!("`{family}`")) || documented.contains(&format!("`{family}."));
        assert!(is_there, "docs/src/sweeps.md does not say what `{name}` is");
    }
}

#[test]
fn the_example_sweep_is_valid() {
    let sweep = Sweep::load(&root().join("docs/ci/light_and_slip.toml")).unwrap().unwrap();
    let variations = sweep.variations(&SceneTemplate::load(&sweep.scene).unwrap()).unwrap();
    assert_eq!((variations.len(), sweep.seeds), (9, 0..5));
}

/// The shell recipe `docs/ci/sweep.sh` is called twice: the first call makes the results with which the second one compares its own.
#[cfg(unix)]
#[test]
fn the_shell_recipe_ends_with_the_gravest_code() {
    let folder = folder("report_recipe");
    fs::write(folder.join("scene.toml"), blind_scene(0.5, "[expect]\nunsound = 0\n")).unwrap();
    let program = wherein(Path::new("."), &[]).get_program().to_owned();
    let recipe = |arguments: &[&str]| {
        let mut command = Command::new(root().join("docs/ci/sweep.sh"));
        outcome(command.args(arguments).env("WHEREIN", &program).current_dir(&folder))
    };
    let (code, stdout, stderr) = recipe(&["scene.toml", "accepted"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(folder.join("accepted/junit.xml").exists());
    let (code, stdout, stderr) = recipe(&["scene.toml", "again", "accepted/results.csv"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("not distinguishable"), "{stdout}");
    fs::write(folder.join("scene.toml"), blind_scene(0.5, "[expect]\ncontainment.checks = 1\n")).unwrap();
    assert_eq!(recipe(&["scene.toml", "missed", "accepted/results.csv"]).0, 1);
    assert_eq!(recipe(&["no scene.toml", "out", "accepted/results.csv"]).0, 2);
}

#[test]
fn the_command_beside_a_failed_case_replays_it() {
    let (folder, stdout) = swept("report_replay", &[]);
    let replay = stdout.lines().find_map(|line| line.trim().strip_prefix("replay: ")).unwrap();
    assert!(read(&folder, "out/report.html").contains(&replay.replace('&', "&amp;")), "{replay}");
    assert!(read(&folder, "out/summary.md").contains(replay), "{replay}");
    let (code, _, stderr) = outcome(Command::new("sh").arg("-c").arg(replay).current_dir(&folder));
    assert_eq!(code, 1, "{stderr}");
    let seed = replay.split(" --seed ").nth(1).unwrap().split(' ').next().unwrap();
    let summary: serde_json::Value =
        serde_json::from_str(&read(&folder, &format!("renders/scene/{seed}/summary.json"))).unwrap();
    let digest = summary["digest"]["estimates"].as_str().unwrap();
    let same = rows(&folder).into_iter().filter(|row| row["digest.estimates"] == digest && row["seed"] == seed);
    assert!(same.count() > 0, "the replay estimated otherwise than the sweep");
}

#[test]
fn junit_tells_when_where_how_far_why_and_how_to_replay() {
    let (folder, _) = swept("report_junit", &["--junit", "junit.xml"]);
    let xml = read(&folder, "junit.xml");
    assert!(xml.contains("<testsuite name=\"scene\" tests=\"8\" skipped=\"0\" errors=\"0\" failures=\"4\">"), "{xml}");
    let failed = rows(&folder).into_iter().find(|row| row["passed"] == "false").unwrap();
    let message = format!(
        "first outside at {:.2} s: {} by {:.3} mm, bound broken: {}",
        number(&failed, "first_failure_s"),
        failed["first_failure_axis"].strip_suffix("_m").unwrap(),
        1e3 * number(&failed, "first_failure_margin"),
        failed["blame"]
    );
    assert!(xml.contains(&format!("<failure message=\"{message}\"")), "`{message}` is missing in:\n{xml}");
    assert!(xml.contains("availability is ") && xml.contains("\nreplay: "), "{xml}");
}

#[test]
fn github_gets_annotations_and_a_summary_and_nobody_else_does() {
    let folder = folder("report_github");
    fs::write(folder.join("scene.toml"), blind_scene(0.5, "[expect]\ncontainment.checks = 1\n")).unwrap();
    let run = ["run", "scene.toml", "--seed", "3", "--set", "floor.friction=0.5"];
    let (_, _, stderr) = outcome(wherein(&folder, &run).env("GITHUB_ACTIONS", "false"));
    assert!(!stderr.contains("::error"), "{stderr}");
    fs::write(folder.join("summary.md"), "of an earlier step\n").unwrap();
    let mut on_github = wherein(&folder, &run);
    on_github.env("GITHUB_ACTIONS", "true").env("GITHUB_STEP_SUMMARY", folder.join("summary.md"));
    let (code, _, stderr) = outcome(&mut on_github);
    assert_eq!(code, 1);
    let line = "::error file=scene.toml,title=scene floor.friction=0.5 seed 3::containment.checks is 51, expected 1%0Areplay: ";
    assert!(stderr.lines().any(|found| found.starts_with(line)), "{stderr}");
    // A sweep's file names its scene by a path from the folder of the sweep's file.
    fs::create_dir_all(folder.join("sweeps")).unwrap();
    fs::write(folder.join("sweeps/dark.toml"), "scene = \"../scene.toml\"\nseeds = \"3..4\"\n").unwrap();
    let mut sweep = wherein(&folder, &["sweep", "sweeps/dark.toml", "--out", "out"]);
    let (_, _, stderr) = outcome(sweep.env("GITHUB_ACTIONS", "true").env_remove("GITHUB_STEP_SUMMARY"));
    assert!(stderr.contains("::error file=scene.toml,"), "{stderr}");
    let summary = read(&folder, "summary.md");
    assert!(summary.starts_with("of an earlier step\n## ❌ failed"), "{summary}");
}

#[test]
fn frames_of_failures_are_left_by_failed_cases_alone() {
    let folder = folder("report_frames");
    let scene = blind_scene(0.5, "[floor.tiles]\n[expect]\navailability_min = 0.4\n");
    fs::write(folder.join("scene.toml"), scene.replace("floor_camera = false", "floor_camera = true")).unwrap();
    let widths = "localizer.declared_width_m=0.001,1";
    let sweep = ["sweep", "scene.toml", "--vary", widths, "--frames", "failures", "--out", "out"];
    let (code, _, stderr) = outcome(&mut wherein(&folder, &sweep));
    assert_eq!(code, 1, "{stderr}");
    for row in rows(&folder) {
        let names = fs::read_dir(folder.join("out/cases").join(&row["case"])).unwrap();
        let pictures = names.filter(|name| name.as_ref().unwrap().path().extension().is_some_and(|kind| kind == "png"));
        // The true pose was never outside of the boxes. The frames that a failed case leaves are then those of the image at which the box was widest:
        // the image and its explanation, two files.
        assert_eq!(pictures.count(), if row["passed"] == "true" { 0 } else { 2 });
    }
    assert!(read(&folder, "out/report.html").contains("data:image/jpeg;base64,"));
}
