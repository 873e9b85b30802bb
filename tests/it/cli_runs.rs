use std::{fs, process::Command};

use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, wherein};

#[test]
fn met_expectations_end_with_code_0_and_a_table() {
    let folder = folder("met");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "[expect]\nunsound = 0\n")).unwrap();
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "2..5"]));
    assert_eq!(code, 0, "{stderr}");
    for part in ["seed 2", "seed 3", "seed 4", "3 seeds", "3/3 passed", "odometry"] {
        assert!(stdout.contains(part), "`{part}` is missing in:\n{stdout}");
    }
    assert!(!stdout.contains("seed 5"), "--seeds is half open");
}

#[test]
fn a_missed_expectation_ends_with_code_1_and_a_command_that_replays_it() {
    let folder = folder("missed");
    let scenes = folder.join("its own place");
    fs::create_dir(&scenes).unwrap();
    fs::write(scenes.join("a scene.toml"), blind_scene(1.0, "[expect]\ncontainment.checks = 1\n")).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(
        &folder,
        &["run", "its own place", "--seed", "6", "--out", "my results", "--adapter", "my card"],
    ));
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("FAILED a scene seed 6"), "{stderr}");
    assert!(stderr.contains("containment.checks is "), "{stderr}");
    let replay = stderr.lines().find_map(|line| line.trim().strip_prefix("replay: ")).unwrap();
    assert!(replay.contains(" '--adapter=my card' run "), "{replay}");
    if cfg!(unix) {
        let (code, _, again) = outcome(Command::new("sh").arg("-c").arg(replay).current_dir(&folder));
        assert_eq!(code, 1, "{again}");
        assert!(again.contains("FAILED a scene seed 6"), "{again}");
    }
}

#[test]
fn equal_seeds_give_equal_summaries_in_two_processes_and_others_do_not() {
    let folder = folder("equal");
    fs::write(folder.join("scene.toml"), blind_scene(2.0, "")).unwrap();
    for out in ["one", "two"] {
        assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..2", "--out", out])).0, 0);
    }
    let read = |place: &str| fs::read_to_string(folder.join(place)).unwrap();
    for file in ["summary.json", "boxes.csv", "truth.tum", "estimate.tum"] {
        assert_eq!(read(&format!("one/scene/1/{file}")), read(&format!("two/scene/1/{file}")), "{file}");
    }
    let digest = |seed: u64, name: &str| -> Value {
        let summary: Value = serde_json::from_str(&read(&format!("one/scene/{seed}/summary.json"))).unwrap();
        summary["digest"][name].clone()
    };
    for name in ["truth", "readings", "estimates"] {
        assert_eq!(digest(0, name).as_str().unwrap().len(), 64, "a SHA-256 has 64 hexadecimal digits");
        assert_ne!(digest(0, name), digest(1, name), "{name}");
    }
    assert_eq!(digest(0, "scene"), digest(1, "scene"));
}

#[test]
fn json_is_the_summaries_as_recorded() {
    let folder = folder("json");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..2", "--json"]));
    assert_eq!(code, 0);
    let printed: Vec<Value> = serde_json::from_str(&stdout).unwrap();
    let recorded = |seed: u64| -> Value {
        let text = fs::read_to_string(folder.join(format!("renders/scene/{seed}/summary.json"))).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    assert_eq!(printed, [recorded(0), recorded(1)]);
}

#[test]
fn resume_runs_only_what_is_not_recorded_for_the_same_scene() {
    let folder = folder("resume");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let run = || assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..2", "--resume"])).0, 0);
    // Two runs are told apart by their wall-clock times.
    let timing = |seed: u64| fs::read_to_string(folder.join(format!("renders/scene/{seed}/timing.json"))).unwrap();
    run();
    let first = [timing(0), timing(1)];
    fs::remove_dir_all(folder.join("renders/scene/1")).unwrap();
    run();
    assert_eq!(timing(0), first[0], "seed 0 was run again");
    assert_ne!(timing(1), first[1], "seed 1 was not run again");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "[floor]\nfriction = 0.7\n")).unwrap();
    run();
    assert_ne!(timing(0), first[0], "another scene was taken for the same");
}

#[test]
fn a_run_replaces_what_an_earlier_one_left() {
    let folder = folder("replace");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let left = folder.join("renders/scene/0");
    fs::create_dir_all(&left).unwrap();
    fs::write(left.join("figure_00000.png"), "of an earlier run").unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml"])).0, 0);
    let mut names: Vec<String> =
        fs::read_dir(&left).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["boxes.csv", "estimate.tum", "steps.csv", "summary.json", "timing.json", "truth.tum"]);
    assert_eq!(fs::read_dir(folder.join("renders/scene")).unwrap().count(), 1, "something was left beside the run");
}

#[test]
fn a_table_goes_between_the_markers_of_a_document() {
    let folder = folder("table");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    fs::write(folder.join("page.md"), "before\n<!-- results:begin -->\nold\n<!-- results:end -->\nafter\n").unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..3"])).0, 0);
    assert_eq!(outcome(&mut wherein(&folder, &["table", "renders", "--into", "page.md"])).0, 0);
    let page = fs::read_to_string(folder.join("page.md")).unwrap();
    assert!(page.starts_with("before\n<!-- results:begin -->\n"), "{page}");
    assert!(page.ends_with("<!-- results:end -->\nafter\n"), "{page}");
    assert!(page.contains("| scene | 3 seeds |") && !page.contains("old"), "{page}");
}

#[test]
fn a_printed_table_has_eight_columns_and_more_by_name() {
    let folder = folder("columns");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let printed = |arguments: &[&str]| {
        let (code, table, _) = outcome(&mut wherein(&folder, arguments));
        assert_eq!(code, 0, "{table}");
        table
    };
    let n_columns = |table: &str| table.lines().next().unwrap().matches('|').count() - 1;
    let usual = printed(&["run", "scene.toml", "--seeds", "0..2"]);
    // In a line of text, columns are two blanks apart.
    let row = usual.lines().find(|line| line.contains("seed 1")).unwrap();
    assert!(row.trim().split("  ").filter(|cell| !cell.trim().is_empty()).count() <= 8, "{row}");
    assert!(row.contains("passed") && usual.contains("--columns all shows up to"), "{usual}");
    let all = printed(&["run", "scene.toml", "--seeds", "0..2", "--columns", "all"]);
    assert!(all.contains("checks") && !usual.contains("checks") && !all.contains("--columns"), "{all}");
    assert_eq!(n_columns(&printed(&["table", "renders"])), 8);
    assert!(n_columns(&printed(&["table", "renders", "--columns", "all"])) > 12);
    let named = printed(&["table", "renders", "--columns", "verdict,scene,checks"]);
    assert!(named.starts_with("| verdict | scene | checks |\n"), "{named}");
    let (code, _, refusal) = outcome(&mut wherein(&folder, &["table", "renders", "--columns", "scene,check"]));
    assert_eq!(code, 2);
    assert!(refusal.contains("unknown column `check`") && refusal.contains("checks, contained"), "{refusal}");
}

#[test]
fn a_marker_that_names_beginnings_takes_those_scenes_and_keeps_a_table_of_none() {
    let folder = folder("tables");
    for name in ["left", "right"] {
        fs::write(folder.join(format!("{name}.toml")), blind_scene(1.0, "")).unwrap();
        assert_eq!(outcome(&mut wherein(&folder, &["run", &format!("{name}.toml"), "--seeds", "0..2"])).0, 0);
    }
    let block = |names: &str| format!("<!-- results:begin {names} -->\nold\n<!-- results:end -->\n");
    let page = [block("right elsewhere"), block("le"), block("papers")].concat();
    fs::write(folder.join("page.md"), page).unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["table", "renders", "--into", "page.md"])).0, 0);
    let page = fs::read_to_string(folder.join("page.md")).unwrap();
    let blocks: Vec<&str> = page.split("<!-- results:end -->").collect();
    assert!(blocks[0].starts_with("<!-- results:begin right elsewhere -->\n"), "{page}");
    assert!(blocks[0].contains("| right | 2 seeds |") && !blocks[0].contains("| left |"), "{page}");
    assert!(blocks[1].contains("| left | 2 seeds |") && !blocks[1].contains("| right |"), "{page}");
    assert_eq!(blocks[2], "\n<!-- results:begin papers -->\nold\n");
}

#[test]
fn a_marker_names_columns_and_a_csv_file_has_all_of_them() {
    let folder = folder("marked_columns");
    for name in ["left", "right"] {
        fs::write(folder.join(format!("{name}.toml")), blind_scene(1.0, "")).unwrap();
        let out = ["run", &format!("{name}.toml"), "--seeds", "0..2", "--out", name];
        assert_eq!(outcome(&mut wherein(&folder, &out)).0, 0);
    }
    let page = |columns: &str| format!("<!-- results:begin --columns={columns} -->\n<!-- results:end -->\n");
    fs::write(folder.join("page.md"), page("scene,checks,width")).unwrap();
    let table = |run: &str| outcome(&mut wherein(&folder, &["table", run, "--into", "page.md", "--csv", "all.csv"]));
    assert_eq!(table("left").0, 0);
    let told = fs::read_to_string(folder.join("page.md")).unwrap();
    assert!(told.contains("| scene | checks | width, mm |\n") && told.contains("| baseline |"), "{told}");
    // Lines of other scenes stay in the CSV file, and those of the same scene are written anew.
    assert_eq!(table("right").0, 0);
    assert_eq!(table("right").0, 0);
    let told = fs::read_to_string(folder.join("page.md")).unwrap();
    assert!(told.contains("| left | ") && told.contains("| right | "), "{told}");
    let csv = fs::read_to_string(folder.join("all.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().map(|line| line.split(",2 seeds").next().unwrap()).collect();
    assert!(lines[0].starts_with("line,scene,localizer,run,checks,") && lines[0].ends_with(",verdict"), "{csv}");
    assert_eq!(
        lines.iter().filter(|line| line.starts_with("runs,")).collect::<Vec<_>>(),
        [&"runs,left,", &"runs,right,"]
    );

    // No other file is overwritten.
    fs::write(folder.join("notes.md"), "mine\n").unwrap();
    let (code, _, refusal) = outcome(&mut wherein(&folder, &["table", "left", "--csv", "notes.md"]));
    assert!(code == 2 && refusal.contains("notes.md") && refusal.contains("expected a first line"), "{refusal}");
    assert_eq!(fs::read_to_string(folder.join("notes.md")).unwrap(), "mine\n");

    fs::write(folder.join("page.md"), page("scene,check")).unwrap();
    let (code, _, refusal) = table("left");
    assert_eq!(code, 2);
    assert!(refusal.contains("page.md") && refusal.contains("unknown column `check`"), "{refusal}");
    assert_eq!(fs::read_to_string(folder.join("page.md")).unwrap(), page("scene,check"));
}

#[test]
fn a_document_without_markers_is_refused_and_left_alone() {
    let folder = folder("markers");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    fs::write(folder.join("page.md"), "nothing to fill in\n").unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml"])).0, 0);
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["table", "renders", "--into", "page.md"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("page.md") && stderr.contains("<!-- results:begin -->"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.join("page.md")).unwrap(), "nothing to fill in\n");
}

#[test]
fn two_scenes_of_one_name_are_refused() {
    let folder = folder("same_name");
    for place in ["a", "b"] {
        fs::create_dir(folder.join(place)).unwrap();
        fs::write(folder.join(place).join("scene.toml"), blind_scene(1.0, "")).unwrap();
    }
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "a", "b"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("both are scenes named `scene`"), "{stderr}");
}

#[test]
fn help_teaches_by_example() {
    let (code, stdout, _) = outcome(&mut wherein(&folder("help"), &["run", "--help"]));
    assert_eq!(code, 0);
    for part in ["--seeds <A..B>", "summary.json", "unsound"] {
        assert!(stdout.contains(part), "`{part}` is missing in:\n{stdout}");
    }
}

#[test]
fn a_seed_below_zero_is_refused_as_a_value_and_not_as_an_argument() {
    let folder = folder("seed_below_zero");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let of_one = [&["run", "scene.toml"][..], &["check", "scene.toml"], &["render", "scene.toml"], &["falsify"]];
    for command in of_one.into_iter().chain([&["sharpness", "scene.toml"][..]]) {
        let (code, _, stderr) = outcome(&mut wherein(&folder, &[command, &["--seed", "-1"]].concat()));
        assert_eq!(code, 2, "{stderr}");
        let expected = "invalid value '-1' for '--seed <N>': expected a whole number of at least 0";
        assert!(stderr.contains(expected), "{command:?}: {stderr}");
    }
    for command in [["run", "scene.toml", "--seeds"], ["sweep", "scene.toml", "--seeds"]] {
        let (code, _, stderr) = outcome(&mut wherein(&folder, &[&command[..], &["-3..2"]].concat()));
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains("invalid value '-3..2' for '--seeds <A..B>'"), "{stderr}");
    }
}
