use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;
use sim::scene::{Scene, SceneFile, schema_text};

use crate::command::root;

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
    // Angles and coordinates are free; what is outside the room is refused elsewhere.
    const FREE: [&str; 9] =
        ["rotation_deg", "yaw_deg", "waypoints_m", "x_m", "y_m", "unevenness_direction_deg", "tile", "from_m", "to_m"];
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

#[test]
fn every_path_that_a_document_names_exists() {
    for document in ["README.md", "ARCHITECTURE.md", "docs/sweeps.md"] {
        let text = fs::read_to_string(root().join(document)).unwrap();
        for path in named_paths(&text) {
            assert!(root().join(&path).exists(), "{document} names `{}`, which does not exist", path.display());
        }
    }
}

#[test]
fn the_readme_holds_a_table_of_results() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let table: String = text
        .split("<!-- results:begin")
        .skip(1)
        .map(|piece| piece.split("<!-- results:end -->").next().unwrap())
        .collect();
    for row in ["papers/floor_vision_odometry |", "papers/floor_vision_odometry_paper_chain |", "odometry"] {
        assert!(table.contains(row), "make experiments writes a row of {row}");
    }
}

/// What stands in `back quotes` or in (a link) and begins with a folder of the repository.
fn named_paths(text: &str) -> Vec<PathBuf> {
    const FOLDERS: [&str; 9] =
        ["localizer/", "sim/", "tests/", "scenes/", "scripts/", "experiments/", "renders/gallery/", ".ci/", "docs/"];
    let spans = text.split(['`', '(', ')', ' ', '\n']);
    spans
        .filter(|span| FOLDERS.iter().any(|folder| span.starts_with(folder)))
        // Patterns and placeholders stand for many files, and experiments/out for what is not committed.
        .filter(|span| !span.contains(['*', '<', '…', '{']) && !span.starts_with("experiments/out"))
        .map(|span| Path::new(span.trim_end_matches([',', '.', ':', ';'])).to_owned())
        .collect()
}

#[test]
fn the_readme_shows_a_valid_scene() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let scene = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    Scene::parse(scene, "README.md").unwrap_or_else(|error| panic!("failed to {error}"));
}
