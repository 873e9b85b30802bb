use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
};

use sim::{campaign::cases::from_csv, loading::SceneFile};

use crate::{command::root, repository::pages};

/// Documents for people outside of the book, as paths from the root of the repository.
const DOCUMENTS: [&str; 9] = [
    "README.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "localizer/README.md",
    "localizer/interval/README.md",
    "sim/README.md",
    "python/README.md",
];

/// Every document for people with its text, those outside of the book first.
pub(crate) fn documents() -> Vec<(PathBuf, String)> {
    let paths = DOCUMENTS.into_iter().map(|path| root().join(path)).chain(pages());
    paths
        .map(|path| (path.clone(), fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"))))
        .collect()
}

/// The lines of a document outside of its code blocks, each with its number.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut is_code = false;
    let lines = text.lines().enumerate().filter(|(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.map(|(idx, line)| (idx + 1, line)).collect()
}

/// The text of a document without its code blocks, and without what stands in `back quotes`.
fn without_code(text: &str) -> String {
    let prose: Vec<&str> = prose(text).into_iter().map(|(_, line)| line).collect();
    prose.join("\n").split('`').step_by(2).collect()
}

/// The targets of a document's links and pictures: what stands in parentheses directly after a bracket.
fn link_targets(text: &str) -> Vec<String> {
    let mut targets = Vec::new();
    for rest in without_code(text).split("](").skip(1) {
        targets.extend(rest.split_once(')').map(|(target, _)| target.to_owned()));
    }
    targets
}

/// The anchors of a document's headings, as mdBook and the hosts of repositories make them: small letters, digits, `_` and `-`, with `-` for blanks.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text)
        .into_iter()
        .filter_map(|(_, line)| line.split_once("# ").filter(|(level, _)| level.trim_matches('#').is_empty()));
    let of_name = |letter: &char| letter.is_alphanumeric() || "_- ".contains(*letter);
    headings
        .map(|(_, name)| name.trim().to_lowercase().chars().filter(of_name).collect::<String>().replace(' ', "-"))
        .collect()
}

/// The cells of each row of the tables in a text, each with the heading of its column.
fn table_rows(text: &str) -> Vec<BTreeMap<&str, &str>> {
    let mut rows = Vec::new();
    let mut heads: Vec<&str> = Vec::new();
    for line in text.lines() {
        let Some(line) = line.strip_prefix('|').and_then(|line| line.trim_end().strip_suffix('|')) else {
            heads.clear();
            continue;
        };
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        if heads.is_empty() {
            heads = cells;
        } else if !cells.iter().all(|cell| cell.trim_matches([':', '-']).is_empty()) {
            rows.push(heads.iter().copied().zip(cells).collect());
        }
    }
    rows
}

#[test]
fn every_link_of_a_document_leads_to_a_file_and_a_heading_of_it() {
    let mut n_links = 0;
    for (document, text) in documents() {
        for target in link_targets(&text) {
            n_links += 1;
            let shown = format!("{}: {target}", document.display());
            assert!(!target.is_empty() && !target.contains(char::is_whitespace), "{shown}");
            if target.contains("://") {
                assert!(target.starts_with("https://") || target.starts_with("ws://"), "{shown}");
                continue;
            }
            let (path, anchor) =
                target.split_once('#').map_or((target.as_str(), None), |(path, anchor)| (path, Some(anchor)));
            let to = if path.is_empty() { document.clone() } else { document.parent().unwrap().join(path) };
            assert!(to.exists(), "{shown}");
            if let Some(anchor) = anchor {
                let there = anchors(&fs::read_to_string(&to).unwrap());
                assert!(there.contains(anchor), "{shown} is none of {there:?}");
            }
        }
    }
    assert!(n_links > 150, "{n_links} links");
}

#[test]
fn what_registries_show_of_a_package_links_to_nothing_of_the_repository() {
    let packages: Vec<_> = DOCUMENTS.into_iter().filter(|path| path.ends_with("/README.md")).collect();
    assert_eq!(packages.len(), 4, "{packages:?}");
    for path in packages {
        let text = fs::read_to_string(root().join(path)).unwrap();
        for target in link_targets(&text) {
            assert!(target.contains("://") || target.starts_with('#'), "{path}: {target}");
        }
    }
}

#[test]
fn links_and_headings_are_found_outside_of_code_only() {
    let text = "# A `b`, c_d!\n[e](f.md#g) and ![h](i.png), `[j](k)`\n```\n# l\n[m](n)\n```\n## 2. Two  (paper 1)\n[o\np](#q)\n";
    assert_eq!(link_targets(text), ["f.md#g", "i.png", "#q"]);
    assert_eq!(anchors(text).into_iter().collect::<Vec<_>>(), ["2-two--paper-1", "a-b-c_d"]);
}

#[test]
fn every_experiment_has_a_row_among_all_results() {
    let results = fs::read_to_string(root().join("docs/src/all_results.csv")).unwrap();
    let shown: BTreeSet<&str> =
        results.lines().filter_map(|line| line.strip_prefix("runs,")?.split(',').next()).collect();
    let list = fs::read_to_string(root().join("experiments/list")).unwrap();
    let paths = list.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(' ').nth(2).unwrap());
    for path in paths {
        let files = SceneFile::load_all(&[root().join(path)]).unwrap();
        for file in files {
            let name = file.path.strip_prefix(root().join("scenes")).unwrap().with_extension("");
            let name = name.to_str().unwrap();
            assert!(shown.contains(name), "{name} of `experiments/list` is not in all_results.csv");
        }
    }
}

#[test]
fn every_figure_of_a_run_is_explained() {
    let pages = ["docs/src/sweeps.md", "docs/src/papers.md"].map(|page| fs::read_to_string(root().join(page)).unwrap());
    for name in sim::judge::metric_names() {
        assert!(pages.iter().any(|page| page.contains(&format!("`{name}`"))), "`{name}` is in neither page");
    }
}

#[test]
fn the_readme_has_at_most_1500_words() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let n_words = text.split_whitespace().count();
    assert!(n_words <= 1500, "{n_words} words: move long sections and tables into the book");
}

#[test]
fn the_readme_shows_one_picture_one_table_and_a_loop_in_python() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    assert_eq!(text.matches("![").count(), 1);
    assert_eq!(text.lines().filter(|line| line.starts_with("| :-")).count(), 1);
    let python = text.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    assert!(python.lines().count() <= 10, "{python}");
}

/// The lines of the book's file of all results, each with its cells by the name of the column.
fn all_results() -> Vec<BTreeMap<String, String>> {
    let (names, rows) = from_csv(&fs::read_to_string(root().join("docs/src/all_results.csv")).unwrap()).unwrap();
    rows.into_iter().map(|row| names.iter().cloned().zip(row).collect()).collect()
}

#[test]
fn the_readmes_table_has_the_figures_of_all_results() {
    let all = all_results();
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let rows = table_rows(&readme);
    assert!(rows.len() >= 5, "{rows:?}");
    for row in rows {
        let scene = row["scene"];
        let mine =
            |line: &str| all.iter().filter(|row| row["scene"] == scene && row["line"] == line).collect::<Vec<_>>();
        let run = mine("runs").into_iter().find(|row| row["run"].ends_with("seeds"));
        let run = run.unwrap_or_else(|| panic!("{scene} has no row of all seeds"));
        let odometry = mine("baseline").into_iter().find(|row| row["run"] == "odometry");
        let expected = [
            ("runs", run["run"].trim_end_matches(" seeds").to_owned()),
            ("steps", run["checks"].clone()),
            ("truth in the box, %", run["contained"].clone()),
            ("error x / y, mm", run["rmse"].clone()),
            ("error heading, °", run["rmse_heading"].clone()),
            ("width, mm / °", format!("{} / {}", run["width"], run["width_heading"])),
            ("odometry x / y, mm", odometry.map_or(String::new(), |row| row["rmse"].clone())),
        ];
        assert_eq!(row.len(), expected.len() + 1);
        for (column, value) in expected {
            assert_eq!(row[column], value, "{scene}, {column}: scripts/best_rows renews the table");
        }
    }
}

/// The tables of the book are excerpts of the file with all results, so that whoever runs some of the experiments anew cannot forget one of the two.
#[test]
fn the_books_tables_of_results_are_of_all_results() {
    let all = all_results();
    let mut n_rows = 0;
    for page in ["docs/src/flat.md", "docs/src/papers.md"] {
        let page = fs::read_to_string(root().join(page)).unwrap();
        for piece in page.split("<!-- results:begin").skip(1) {
            let block = piece.split("<!-- results:end -->").next().unwrap();
            for row in table_rows(block) {
                let run = ["run", "method", "baseline"].iter().find_map(|name| row.get(name)).unwrap();
                let is_of = |one: &&BTreeMap<String, String>| one["scene"] == row["scene"] && one["run"] == **run;
                let found = all.iter().find(is_of).unwrap_or_else(|| panic!("{row:?} is not among all results"));
                assert!(row.values().all(|cell| found.values().any(|value| value == cell)), "{row:?}, {found:?}");
                n_rows += 1;
            }
        }
    }
    let n_runs = all.iter().filter(|one| one["line"] == "runs").count();
    assert!(n_rows >= n_runs, "{n_rows} rows of {n_runs} scenes");
}

#[test]
fn tables_for_people_have_at_most_eight_columns() {
    let mut n_rows = 0;
    for (document, text) in documents() {
        for line in text.lines().map(str::trim).filter(|line| line.starts_with('|')) {
            let n_columns = line.replace("\\|", "").matches('|').count() - 1;
            assert!(n_columns <= 8, "{}: {line}", document.display());
            n_rows += 1;
        }
    }
    assert!(n_rows > 500, "{n_rows} rows");
}

/// The sentences of a document with at least eight words, links reduced to their text.
fn sentences(text: &str) -> BTreeSet<String> {
    let paragraphs = without_code(text).replace("\n- ", "\n\n");
    let mut sentences = BTreeSet::new();
    for paragraph in paragraphs.split("\n\n").filter(|paragraph| !paragraph.trim_start().starts_with(['|', '<', '#'])) {
        let words: Vec<&str> = paragraph.split_whitespace().collect();
        let ends = |word: &&str| word.ends_with(['.', '?', ':']);
        for sentence in words.split_inclusive(ends).filter(|sentence| sentence.len() >= 8) {
            sentences.insert(sentence.join(" ").replace(['[', ']', '*'], ""));
        }
    }
    sentences
}

#[test]
fn no_sentence_of_the_readme_stands_in_another_document_too() {
    let documents = documents();
    let (readme, others) = documents.split_first().unwrap();
    let ours = sentences(&readme.1);
    assert!(ours.len() > 10, "{ours:?}");
    for (document, text) in others {
        let twice: Vec<_> = sentences(text).intersection(&ours).cloned().collect();
        assert!(twice.is_empty(), "{}: {twice:?}", document.display());
    }
}

/// The targets of `make` that a text names, in `make target` or in a line of a code block.
fn make_targets(text: &str) -> BTreeSet<String> {
    let pieces = text.split(['\n', '`']).map(|piece| piece.trim_start().trim_start_matches("- "));
    // In a workflow the command, or the name of a step, stands after a key.
    let commands = pieces.map(|piece| piece.trim_start_matches("run: ").trim_start_matches("name: "));
    let named = commands.filter_map(|command| command.strip_prefix("make "));
    let targets = named.filter_map(|arguments| arguments.split_whitespace().find(|argument| !argument.contains('=')));
    let is_target = |target: &&str| target.chars().all(|letter| letter.is_ascii_lowercase() || letter == '-');
    targets.filter(is_target).map(str::to_owned).collect()
}

#[test]
fn every_make_target_that_a_document_or_a_workflow_names_is_in_the_makefile() {
    let makefile = fs::read_to_string(root().join("Makefile")).unwrap();
    let has =
        |target: &str| makefile.lines().any(|line| line.strip_prefix(target).is_some_and(|rest| rest.starts_with(':')));
    let workflows = fs::read_dir(root().join(".github/workflows")).unwrap().map(|entry| entry.unwrap().path());
    let workflows: Vec<_> = workflows.map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect();
    let n_in_workflows = workflows.iter().map(|(_, text)| make_targets(text).len()).sum::<usize>();
    assert!(n_in_workflows >= 8, "{n_in_workflows} targets in workflows");
    for (document, text) in documents().into_iter().chain(workflows) {
        for target in make_targets(&text) {
            assert!(has(&target), "{}: make {target}", document.display());
        }
    }
    assert!(has("test") && !has("tes"), "targets are compared as a whole");
}

#[test]
fn continuous_integration_runs_every_check_that_takes_no_hour() {
    let workflow = fs::read_to_string(root().join(".github/workflows/ci.yml")).unwrap();
    let run = make_targets(&workflow);
    for target in ["lint", "test", "test-python", "test-ray", "msrv", "features", "deny", "package"] {
        assert!(run.contains(target), "make {target} is not in {run:?}");
    }
}

#[test]
fn the_book_begins_with_the_first_hour() {
    let summary = fs::read_to_string(root().join("docs/src/SUMMARY.md")).unwrap();
    assert_eq!(link_targets(&summary).first().map(String::as_str), Some("first_hour.md"));
}
