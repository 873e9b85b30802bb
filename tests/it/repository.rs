use std::{
    fs,
    path::{Path, PathBuf},
};

use mdbook_driver::MDBook;
use serde_json::Value;
use sim::{
    loading::SceneFile,
    scene::{Scene, keys_markdown, schema_text},
};

use crate::command::{folder, root};

#[test]
fn every_scene_is_valid() {
    let scenes = SceneFile::load_all(&[root().join("scenes")]).unwrap_or_else(|error| panic!("failed to {error}"));
    assert!(!scenes.is_empty());
}

#[test]
fn every_scene_says_what_it_is_and_what_it_expects() {
    for file in SceneFile::load_all(&[root().join("scenes")]).unwrap() {
        assert!(!file.scene.description.is_empty(), "{} has no description", file.name);
        assert!(!file.scene.expect.limits.is_empty(), "{} expects nothing", file.name);
    }
}

#[test]
fn the_schema_file_is_up_to_date() {
    let committed = fs::read_to_string(root().join("scenes/schema.json")).unwrap();
    assert!(committed == schema_text(), "renew it: cargo run -p wherein-sim -- schema > scenes/schema.json");
}

#[test]
fn every_number_of_a_scene_has_a_range_or_none_on_purpose_and_a_default_inside() {
    // Scene keys that hold angles and coordinates need no range of values in the schema; a place outside of the room is refused by other checks.
    const FREE: [&str; 10] = [
        "rotation_deg",
        "yaw_deg",
        "waypoints_m",
        "corners_m",
        "x_m",
        "y_m",
        "unevenness_direction_deg",
        "tile",
        "from_m",
        "to_m",
    ];
    fn walk(name: &str, node: &Value) {
        let number = |key: &str| node.get(key).and_then(Value::as_f64);
        if matches!(node["type"].as_str(), Some("number" | "integer")) && !FREE.contains(&name) {
            let (least, most) = (number("minimum").or(number("exclusiveMinimum")), number("maximum"));
            assert!(least.is_some() && most.is_some(), "`{name}` has no range: {node}");
            if let Some(default) = number("default") {
                assert!(
                    least.unwrap() <= default && default <= most.unwrap(),
                    "`{name}` has its default outside its range"
                );
            }
        }
        match node {
            Value::Object(entries) => entries.iter().for_each(|(key, value)| {
                let name = if ["items", "anyOf", "oneOf"].contains(&key.as_str()) { name } else { key };
                walk(name, value);
            }),
            Value::Array(items) => items.iter().for_each(|item| walk(name, item)),
            _ => {}
        }
    }
    walk("", &serde_json::from_str(&schema_text()).unwrap());
}

/// Files of the book's pages, with its summary among them.
pub(crate) fn pages() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("docs/src")).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect()
}

#[test]
fn every_path_that_a_document_names_exists() {
    for document in
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].into_iter().map(|name| root().join(name)).chain(pages())
    {
        let text = fs::read_to_string(&document).unwrap();
        let document = document.display();
        for path in named_paths(&text) {
            assert!(root().join(&path).exists(), "{document} names `{}`, which does not exist", path.display());
        }
    }
}

/// Paths in a document's text: parts in `back quotes` or in (a link) that begin with a folder of the repository.
fn named_paths(text: &str) -> Vec<PathBuf> {
    const FOLDERS: [&str; 11] = [
        "localizer/",
        "sim/",
        "tests/",
        "scenes/",
        "scripts/",
        "experiments/",
        ".ci/",
        "docs/",
        "python/",
        "examples/",
        ".github/",
    ];
    let spans = text.split(['`', '(', ')', ' ', '\n']);
    spans
        .filter(|span| FOLDERS.iter().any(|folder| span.starts_with(folder)))
        // Only paths of existing files are checked: patterns and placeholders such as `*` and `<` stand for many files, and `experiments/out` holds
        // files that are not committed.
        .filter(|span| !span.contains(['*', '<', '…', '{']) && !span.starts_with("experiments/out"))
        // A link may lead to a heading of a file.
        .map(|span| Path::new(span.split('#').next().unwrap().trim_end_matches([',', '.', ':', ';', '\''])).to_owned())
        .collect()
}

#[test]
fn checkouts_have_the_line_ends_of_unix_and_files_that_are_no_texts_as_they_are() {
    let attributes = fs::read_to_string(root().join(".gitattributes")).unwrap();
    let says = |line: &str| attributes.lines().any(|stated| stated == line);
    assert!(says("* text=auto eol=lf"), "{attributes}");
    let mut n_binary = 0;
    let mut folders = vec![root().join("docs"), root().join("localizer"), root().join("sim"), root().join("tests")];
    while let Some(searched) = folders.pop() {
        for path in fs::read_dir(searched).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if std::str::from_utf8(&fs::read(&path).unwrap()).is_err() {
                n_binary += 1;
                let ending = path.extension().unwrap_or_default().display();
                assert!(says(&format!("*.{ending} binary")), "{}", path.display());
            }
        }
    }
    assert!(n_binary > 30, "{n_binary} files that are no texts");
}

#[test]
fn the_page_of_keys_is_that_of_the_schema() {
    let page = fs::read_to_string(root().join("docs/src/scene_keys.md")).unwrap();
    assert_eq!(page, keys_markdown(), "wherein schema --markdown > docs/src/scene_keys.md");
}

#[test]
fn every_page_of_the_book_is_in_its_summary() {
    let folder = root().join("docs/src");
    let summary = fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    for entry in fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let is_picture = name == "gallery" || name.ends_with(".svg");
        assert!(
            is_picture
                || ["SUMMARY.md", "all_results.csv"].contains(&name.as_str())
                || summary.contains(&format!("({name})")),
            "{name}"
        );
    }
}

#[test]
fn the_book_builds_and_what_its_pages_show_and_link_to_is_in_it() {
    let mut book = MDBook::load(root().join("docs")).unwrap();
    let built = folder("book");
    book.config.build.build_dir = built.clone();
    book.build().unwrap();
    let mut n_shown = 0;
    for page in pages().into_iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        let page = built.join(page.file_name().unwrap()).with_extension("html");
        let text = fs::read_to_string(&page).unwrap();
        let main = text.split("<main>").nth(1).unwrap().split("</main>").next().unwrap();
        for shown in ["src=\"", "href=\""].iter().flat_map(|attribute| main.split(attribute).skip(1)) {
            let link = shown.split('"').next().unwrap();
            if link.contains("://") {
                continue;
            }
            n_shown += 1;
            let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
            assert!(target.is_empty() || built.join(target).is_file(), "{}: {link}", page.display());
            if !anchor.is_empty() {
                let other = (!target.is_empty()).then(|| fs::read_to_string(built.join(target)).unwrap());
                let holds = other.as_ref().unwrap_or(&text).contains(&format!("id=\"{anchor}\""));
                assert!(holds, "{}: {link}", page.display());
            }
        }
    }
    assert!(n_shown > 10, "{n_shown} pictures and links within the book");
}

#[test]
fn every_contractor_is_in_the_book() {
    let text = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    let page = text("docs/src/contractors.md");
    let libraries = ["localizer/interval/src/contractor/mod.rs", "localizer/src/rigid_motion/mod.rs"].map(text);
    let lines = libraries.iter().flat_map(|library| library.lines());
    let shown = lines.filter_map(|line| line.strip_prefix("pub use ")?.split_once("::")?.1.strip_suffix(';'));
    // Public names of the contractor modules that need no row of their own in the book: a formula, a pair of boxes, the intersection, combinators that
    // users call as methods, and the network with its numbers and its error, which has a paragraph.
    let others = ["Expression", "Landmark", "q_intersection", "Fixpoint", "OnAxes", "Then", "Union"];
    let of_networks = ["ContractorId", "Network", "UnknownVariable", "VariableId"];
    for name in shown.flat_map(|names| names.trim_matches(['{', '}']).split(", ")) {
        let needs_no_row = others.contains(&name) || of_networks.contains(&name);
        assert!(needs_no_row || page.contains(&format!("| `{name}` |")), "{name}");
    }
}

#[test]
fn the_books_scenes_are_valid() {
    let page = fs::read_to_string(root().join("docs/src/ci.md")).unwrap();
    let scene = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    Scene::parse(scene, "ci.md").unwrap_or_else(|error| panic!("failed to {error}"));
}

#[test]
fn the_readme_shows_a_valid_scene() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let scene = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    Scene::parse(scene, "README.md").unwrap_or_else(|error| panic!("failed to {error}"));
}
