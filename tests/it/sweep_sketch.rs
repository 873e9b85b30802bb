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
    let again = Sketch::of_tables(std::slice::from_ref(&folder)).unwrap().finish(None).0;
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
