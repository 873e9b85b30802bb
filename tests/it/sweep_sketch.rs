use std::{
    fs,
    path::{Path, PathBuf},
};

use sim::campaign::{
    cases::Results,
    report::{Group, Overview},
    sketch::Sketch,
    sweep::read_plan,
};

use crate::command::{blind_scene, folder, outcome, wherein};

/// Sweeps over two frictions and two declared widths, of which one is missed, with three seeds each: in one part, or in the parts of two machines.
fn swept(name: &str) -> PathBuf {
    let folder = folder(name);
    let pushed = "[[event]]\nkind = \"push\"\nat_s = 0.5\ndisplacement_m = [0.0, 0.1]\nlasts_s = 0.2\n\
                  [expect]\nunsound = 0\navailability_min = 0.4\n";
    fs::write(folder.join("scene.toml"), blind_scene(1.0, pushed)).unwrap();
    for more in [&["--out", "whole"][..], &["--out", "one", "--shard", "1/2"], &["--out", "other", "--shard", "2/2"]] {
        let sweep = ["sweep", "scene.toml", "--seeds", "0..3"];
        let vary = ["--vary", "floor.friction=0.5,0.8", "--vary", "localizer.declared_width_m=0.001,1"];
        let (code, stdout, stderr) = outcome(&mut wherein(&folder, &[&sweep[..], &vary, more].concat()));
        assert_eq!(code, 1, "{stdout}{stderr}");
    }
    folder
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

/// The part of a text between two others.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    text.split_once(begin).unwrap_or_else(|| panic!("no `{begin}`")).1.split_once(end).unwrap().0
}

#[test]
fn the_report_of_the_parts_tables_has_the_figures_of_the_report_of_all_cases() {
    let folder = swept("sketch_parts");
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["report", "one", "other", "--out", "sketched"]));
    assert_eq!(code, 1, "{stdout}{stderr}");
    let [whole, sketched] = ["whole", "sketched"].map(|name| read(&folder, &format!("{name}/report.html")));
    for (begin, end) in [("<dl class=\"figures\">", "</dl>"), ("<tbody id=\"combinations\">", "</tbody>")] {
        assert_eq!(between(&whole, begin, end), between(&sketched, begin, end));
    }
    let [whole, sketched] = ["whole", "sketched"].map(|name| read(&folder, &format!("{name}/summary.md")));
    assert!(sketched.starts_with(whole.lines().next().unwrap()), "{sketched}");
    assert!(sketched.contains("Of 12 cases, 6 missed an expectation.") && !whole.contains("sketches"), "{sketched}");
    assert!(sketched.contains("is made of sketches: ") && stdout.contains("is made of sketches: "), "{stdout}");
}

#[test]
fn the_worst_case_of_the_parts_is_told_with_the_files_of_its_run() {
    let folder = swept("sketch_worst");
    outcome(&mut wherein(&folder, &["report", "one", "other", "--out", "sketched"]));
    let [whole, sketched] = ["whole", "sketched"].map(|name| read(&folder, &format!("{name}/report.html")));
    let first = |page: &str| between(page, "<article>", "</article>").to_owned();
    assert!(first(&whole).contains("slip") && first(&whole).contains("scene.toml"), "{}", first(&whole));
    assert_eq!(first(&whole), first(&sketched));
}

#[test]
fn tables_alone_are_enough_for_a_report() {
    let folder = swept("sketch_tables");
    fs::create_dir_all(folder.join("tables")).unwrap();
    for part in ["one", "other"] {
        fs::copy(folder.join(part).join("results.csv"), folder.join(format!("tables/{part}.csv"))).unwrap();
    }
    let report = ["report", "tables/one.csv", "tables/other.csv", "--out", "sketched"];
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &report));
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(stdout.contains("FAILED: Of 12 cases, 6 missed an expectation."), "{stdout}");
    assert!(stdout.contains("first outside at 0."), "{stdout}");
    assert!(!folder.join("sketched/results.csv").exists());
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["report", "one", "other"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("report on 2 folders: expected one, or --out"), "{stderr}");
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["report", "tables", "--out", "sketched"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("find a table of results in tables: expected results.parquet or results.csv"), "{stderr}");
}

#[test]
fn a_sweep_read_in_pieces_has_the_figures_of_the_sweep_read_at_once_and_leaves_tables() {
    let folder = swept("sketch_pieces").join("whole");
    let plan = read_plan(&folder).unwrap().unwrap();
    // As if one case had never run.
    fs::remove_dir_all(folder.join("cases").join(&plan.cases[7])).unwrap();
    let at_once = Overview::of(&Results::read(&folder).unwrap());
    let sketch = Sketch::of_sweep(&folder, &plan, &|_| true).unwrap();
    let (in_pieces, kept) = sketch.finish(Some(plan));
    let again = Sketch::of_tables(std::slice::from_ref(&folder)).unwrap().0.finish(None).0;
    assert_eq!(fs::read_dir(folder.join("results")).unwrap().count(), 1);
    assert_eq!(kept.cases.len(), 12);
    for overview in [in_pieces, again] {
        let counts = |one: &Overview| [one.n_passed, one.n_missed, one.n_failed, one.n_missing];
        assert_eq!(counts(&overview), counts(&at_once));
        assert_eq!((&overview.keys, overview.groups.len()), (&at_once.keys, 4));
        // The order in which figures are added up is the same for a single piece, so that even rounding is the same.
        let shown = |group: &Group| overview.measures().map(|measure| measure.of(&group.figures)).collect::<Vec<_>>();
        for (group, expected) in overview.groups.iter().zip(&at_once.groups) {
            assert_eq!((group.n_cases, group.n_passed), (expected.n_cases, expected.n_passed));
            assert_eq!((&group.settings, shown(group)), (&expected.settings, shown(expected)));
        }
        let spreads = overview.sketched.unwrap().spreads;
        let (_, widths) = spreads.iter().find(|(measure, _)| measure.name == "width").unwrap();
        assert!(widths.is_sorted() && widths[0] < widths[6], "{widths:?}");
    }
}

/// The verdict of a report on parts into the folder `sketched`, and its exit code with all that it prints.
fn reported(folder: &Path, parts: &[&str]) -> (i32, String, String) {
    outcome(&mut wherein(folder, &[&["report"], parts, &["--out", "sketched"]].concat()))
}

/// Copies the table of a part into another folder, with each line as `change` makes it.
fn copy_table(folder: &Path, part: &str, to: &str, change: impl Fn(usize, &str) -> String) {
    fs::create_dir_all(folder.join(to)).unwrap();
    let table = read(folder, &format!("{part}/results.csv"));
    let lines: String = table.lines().enumerate().map(|(number, line)| change(number, line) + "\n").collect();
    fs::write(folder.join(to).join("results.csv"), lines).unwrap();
}

#[test]
fn the_cases_that_no_part_has_are_named_as_missing() {
    let folder = swept("sketch_missing");
    let (code, stdout, stderr) = reported(&folder, &["one"]);
    assert_eq!(code, 2, "{stdout}{stderr}");
    assert!(stdout.contains("FAILED: Of 12 cases, 4 missed an expectation, 6 are missing."), "{stdout}");
    let missing: Vec<&str> = stdout.lines().filter_map(|line| line.strip_prefix("MISSING ")).collect();
    // The first part has every other case, from the first on; three seeds follow each other.
    assert_eq!(missing.len(), 6, "{stdout}");
    assert_eq!(missing[0], "floor.friction=0.5 localizer.declared_width_m=0.001 seed 1");
    assert!(read(&folder, "sketched/summary.md").contains("### Not run"));
    // The report on the part alone leaves rows of the missing cases in the part's table.
    assert_eq!(outcome(&mut wherein(&folder, &["report", "one"])).0, 2);
    assert!(read(&folder, "one/results.csv").contains(",missing,"));
    let (code, stdout, _) = reported(&folder, &["one", "other"]);
    assert!(code == 1 && stdout.contains("FAILED: Of 12 cases, 6 missed an expectation."), "{stdout}");
}

#[test]
fn no_case_is_counted_twice() {
    let folder = swept("sketch_twice");
    for parts in [&["one", "one", "other"][..], &["one", "whole"], &["whole/results.csv", "other/results.csv"]] {
        let (code, stdout, stderr) = reported(&folder, parts);
        assert!(code == 1 && stdout.contains("FAILED: Of 12 cases, 6 missed an expectation."), "{stdout}{stderr}");
    }
    // Tables alone, of a sweep and of runs that have no names.
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..2", "--out", "runs"])).0, 0);
    assert!(outcome(&mut wherein(&folder, &["report", "runs"])).1.contains("All 2 cases met"));
    for (part, told) in [("whole", "Of 12 cases, 6 missed"), ("runs", "All 2 cases met")] {
        let copy = format!("{part}_table");
        copy_table(&folder, part, &copy, |_, line| line.to_owned());
        let (_, stdout, stderr) = reported(&folder, &[&copy, &copy, part]);
        assert!(stdout.contains(told), "{stdout}{stderr}");
    }
}

#[test]
fn a_case_that_failed_in_one_part_and_ran_in_another_counts_as_run() {
    let folder = swept("sketch_retried");
    copy_table(&folder, "one", "retried", |number, line| match number {
        1 => line.replace(",done,false,", ",failed,,").replace(",done,true,", ",failed,,"),
        _ => line.to_owned(),
    });
    fs::copy(folder.join("one/sweep.json"), folder.join("retried/sweep.json")).unwrap();
    let (code, stdout, _) = reported(&folder, &["retried", "other"]);
    assert!(code == 2 && stdout.contains(" missed an expectation, 1 could not run."), "{stdout}");
    for parts in [["retried", "one", "other"], ["one", "other", "retried"]] {
        let (code, stdout, _) = reported(&folder, &parts);
        assert!(code == 1 && stdout.contains("FAILED: Of 12 cases, 6 missed an expectation."), "{stdout}");
    }
}

#[test]
fn parts_of_different_sweeps_are_not_reported_on_together() {
    let folder = swept("sketch_different");
    let sweep = ["sweep", "scene.toml", "--seeds", "0..2", "--out", "without_keys"];
    assert_eq!(outcome(&mut wherein(&folder, &sweep)).0, 0);
    let (code, stdout, stderr) = reported(&folder, &["one", "without_keys"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    let told = "wherein: failed to report on one and without_keys: their sweeps differ in what varies: ";
    assert!(stderr.starts_with(told), "{stderr}");
    copy_table(&folder, "without_keys", "table", |_, line| line.to_owned());
    let (code, stdout, stderr) = reported(&folder, &["one", "table"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(stderr.contains("report on one and table/results.csv: the table has the case "), "{stderr}");
    // A table that is older than the plan beside it has none of its cases.
    fs::copy(folder.join("one/sweep.json"), folder.join("table/sweep.json")).unwrap();
    let (code, stdout, _) = reported(&folder, &["table"]);
    assert!(code == 2 && stdout.contains("Of 12 cases, 12 are missing."), "{stdout}");
}

#[test]
fn cases_of_combinations_that_are_not_listed_are_counted() {
    let folder = folder("sketch_unlisted");
    let rows: String = (0..1003).map(|n| format!("{n:020x},x,{n},0,done,true\n")).collect();
    let table = format!("case,scene,set.floor.friction,seed,status,passed\n{rows}");
    fs::write(folder.join("results.csv"), table).unwrap();
    let (code, stdout, stderr) = reported(&folder, &["results.csv"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("There are too many combinations to list all: 3 cases are of other ones"), "{stdout}");
    assert!(stdout.contains("All 1003 cases"), "{stdout}");
}
