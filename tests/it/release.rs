use std::fs;

use toml::{Table, Value};

use crate::command::root;

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The manifests of the workspace's crates, each with its folder.
fn manifests() -> Vec<(String, Table)> {
    let workspace: Table = text("Cargo.toml").parse().unwrap();
    let members = workspace["workspace"]["members"].as_array().unwrap().iter().map(|member| member.as_str().unwrap());
    members.map(|member| (member.to_owned(), text(&format!("{member}/Cargo.toml")).parse().unwrap())).collect()
}

/// What the workspace states for all of its crates.
fn shared() -> Table {
    let workspace: Table = text("Cargo.toml").parse().unwrap();
    workspace["workspace"]["package"].as_table().unwrap().clone()
}

/// The text of a key of the table `[package]`.
fn stated<'a>(package: &'a Value, key: &str) -> &'a str {
    package.get(key).and_then(Value::as_str).unwrap_or_default()
}

/// Whether a crate is meant for a registry.
fn is_published(package: &Value) -> bool {
    package.get("publish").and_then(Value::as_bool).unwrap_or(true)
}

#[test]
fn every_crate_says_what_it_is_and_takes_version_and_licence_from_the_workspace() {
    for (folder, manifest) in manifests() {
        let package = &manifest["package"];
        assert!(stated(package, "description").len() > 20, "{folder}");
        for key in ["version", "edition", "rust-version", "license"] {
            let from_workspace = package.get(key).and_then(|value| value.get("workspace")).and_then(Value::as_bool);
            assert_eq!(from_workspace, Some(true), "{folder}: {key}");
        }
    }
}

#[test]
fn every_published_crate_has_what_a_registry_shows() {
    let mut published = Vec::new();
    for (folder, manifest) in manifests() {
        let package = &manifest["package"];
        if !is_published(package) {
            continue;
        }
        let n_of = |key: &str| package.get(key).and_then(Value::as_array).map_or(0, Vec::len);
        assert!((1..=5).contains(&n_of("keywords")) && (1..=5).contains(&n_of("categories")), "{folder}");
        for file in [stated(package, "readme"), "LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(!file.is_empty() && root().join(&folder).join(file).is_file(), "{folder}: {file}");
        }
        published.push(stated(package, "name").to_owned());
    }
    assert_eq!(published, ["wherein-interval", "wherein-localizer", "wherein-sim"]);
}

#[test]
fn crates_depend_on_each_other_by_the_workspaces_version() {
    let workspace: Table = text("Cargo.toml").parse().unwrap();
    let shared = shared();
    let mut n_paths = 0;
    for (name, dependency) in workspace["workspace"]["dependencies"].as_table().unwrap() {
        if dependency.get("path").is_some() {
            n_paths += 1;
            assert_eq!(dependency.get("version"), Some(&shared["version"]), "{name}");
        }
    }
    assert_eq!(n_paths, 3);
}

#[test]
fn the_licences_are_those_that_the_crates_state() {
    assert_eq!(shared()["license"].as_str(), Some("MIT OR Apache-2.0"));
    let (mit, apache) = (text("LICENSE-MIT"), text("LICENSE-APACHE"));
    assert!(mit.starts_with("MIT License\n") && mit.contains("the Wherein developers"), "{mit}");
    assert!(mit.contains("THE SOFTWARE IS PROVIDED \"AS IS\"") && apache.contains("Apache License"));
    assert!(apache.contains("Version 2.0, January 2004") && apache.contains("END OF TERMS AND CONDITIONS"));
    for (folder, manifest) in manifests() {
        if is_published(&manifest["package"]) {
            assert_eq!(text(&format!("{folder}/LICENSE-MIT")), mit, "{folder}");
            assert_eq!(text(&format!("{folder}/LICENSE-APACHE")), apache, "{folder}");
        }
    }
}

#[test]
fn the_wheel_states_and_holds_the_licences_of_the_crates() {
    let python: Table = text("python/pyproject.toml").parse().unwrap();
    assert_eq!(python["project"]["license"], shared()["license"]);
    let files = python["project"]["license-files"].as_array().unwrap();
    assert_eq!(files.iter().filter_map(Value::as_str).collect::<Vec<_>>(), ["LICENSE-MIT", "LICENSE-APACHE"]);
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        assert_eq!(text(&format!("python/{file}")), text(file), "python/{file}");
    }
}

#[test]
fn the_citation_names_the_version_and_every_paper_of_the_book() {
    let citation = text("CITATION.cff");
    let version = shared()["version"].as_str().unwrap().to_owned();
    assert!(citation.lines().any(|line| line == format!("version: {version}")), "{version}");
    let page = text("docs/src/the_five_papers.md");
    let dois: Vec<&str> = page.split("https://doi.org/").skip(1).map(|rest| rest.split(')').next().unwrap()).collect();
    assert_eq!(dois.len(), 5, "{dois:?}");
    for doi in dois {
        assert!(citation.contains(&format!("doi: {doi}\n")), "{doi}");
    }
}

#[test]
fn the_changelog_has_unreleased_changes_first_and_the_newest_release_is_not_newer_than_the_crates() {
    let changelog = text("CHANGELOG.md");
    let mut headings = changelog.lines().filter_map(|line| line.strip_prefix("## "));
    assert_eq!(headings.next(), Some("[Unreleased]"));
    let numbers = |version: &str| -> Vec<u64> { version.split('.').map(|number| number.parse().unwrap()).collect() };
    let version = shared()["version"].as_str().unwrap().to_owned();
    if let Some(newest) = headings.next() {
        let newest = newest.trim_start_matches('[').split(']').next().unwrap();
        assert!(numbers(newest) <= numbers(&version), "{newest} is released, the crates have {version}");
    }
}

#[test]
fn the_oldest_compiler_is_the_one_that_workflows_check() {
    let oldest = shared()["rust-version"].as_str().unwrap().to_owned();
    let makefile = text("Makefile");
    assert!(makefile.lines().any(|line| line == format!("MSRV = {oldest}")), "Makefile: MSRV = {oldest}");
    assert!(text("CONTRIBUTING.md").contains(&format!("Rust {oldest}")), "CONTRIBUTING.md: Rust {oldest}");
}

#[test]
fn whatever_builds_keeps_to_the_lock() {
    let workflows = ["ci", "pages", "release", "wheels"].map(|name| format!(".github/workflows/{name}.yml"));
    let others =
        ["Makefile", "Containerfile", "scripts/python", "scripts/release", "scripts/container"].map(str::to_owned);
    let commands = ["bench", "build", "check", "clippy", "doc", "fetch", "install", "package", "run", "test"];
    let mut n_commands = 0;
    for path in workflows.into_iter().chain(others) {
        let text = text(&path);
        for line in text.lines().map(str::trim).filter(|line| !line.starts_with(['#', '@'])) {
            let builds = |command: &&str| line.contains(&format!("cargo {command} "));
            if commands.iter().any(builds) || line.contains("maturin\" build") {
                n_commands += 1;
                assert!(line.contains(" --locked "), "{path}: {line}");
            }
        }
    }
    assert!(n_commands > 30, "{n_commands}");
}

/// The instructions of Containerfile, with lines that go on joined.
fn instructions() -> Vec<String> {
    let joined = text("Containerfile").replace("\\\n", " ");
    joined.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}

#[test]
fn the_image_is_built_by_a_compiler_that_is_new_enough_on_the_system_that_it_runs_on() {
    let base = |name: &str| {
        let begin = format!("ARG {name}=");
        let line = instructions().into_iter().find(|line| line.starts_with(&begin)).unwrap();
        line.rsplit(':').next().unwrap().to_owned()
    };
    let (rust, debian) = (base("RUST_IMAGE"), base("BASE_IMAGE"));
    let (compiler, built_on) = rust.split_once("-slim-").unwrap();
    assert_eq!(debian, format!("{built_on}-slim"), "a program that was linked on another system may not run");
    let numbers = |version: &str| -> Vec<u32> { version.split('.').map(|number| number.parse().unwrap()).collect() };
    let oldest = shared()["rust-version"].as_str().unwrap().to_owned();
    assert!(numbers(compiler) >= numbers(&oldest), "{compiler} builds the image, {oldest} is the oldest");
}

#[test]
fn the_image_runs_the_command_as_a_user_without_rights_and_copies_what_it_is_given() {
    let instructions = instructions();
    let of = |name: &'static str| instructions.iter().filter(move |line| line.split(' ').next() == Some(name));
    assert_eq!(of("ENTRYPOINT").collect::<Vec<_>>(), ["ENTRYPOINT [\"wherein\"]"]);
    assert_eq!(of("USER").collect::<Vec<_>>(), ["USER wherein"]);
    // What is copied has to be let through by .containerignore, and so has every crate of the workspace.
    let let_through = text(".containerignore");
    let has = |path: &str| let_through.lines().any(|line| line == format!("!{}", path.split('/').next().unwrap()));
    let copied = of("COPY").filter(|line| !line.contains("--from") && !line.starts_with("COPY . "));
    let mut n_copied = 0;
    for path in copied.flat_map(|line| line.split(' ').skip(1)).filter(|path| !path.starts_with('/')) {
        n_copied += 1;
        assert!(root().join(path).exists() && has(path), "{path}");
    }
    assert!(n_copied >= 5, "{n_copied}");
    manifests().iter().for_each(|(folder, _)| assert!(has(folder), "{folder}"));
}

#[test]
fn a_job_of_kubernetes_runs_as_the_user_of_the_image_and_may_write_into_its_volume() {
    let after = |text: &str, key: &str| -> u32 {
        let rest = text.split_once(key).unwrap_or_else(|| panic!("found no {key}")).1;
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let user = after(&text("Containerfile"), "useradd --create-home --uid ");
    let job = text("docs/ci/kubernetes_job.yml");
    for key in ["runAsUser: ", "runAsGroup: ", "fsGroup: "] {
        assert_eq!(after(&job, key), user, "{key}");
    }
    assert!(user != 0 && job.contains("runAsNonRoot: true"));
}

#[test]
fn every_feature_is_in_the_books_table_with_its_default_and_is_checked_alone() {
    let (page, makefile) = (text("docs/src/install.md"), text("Makefile"));
    let mut n_features = 0;
    for (folder, manifest) in manifests() {
        let Some(features) = manifest.get("features").filter(|_| is_published(&manifest["package"])) else { continue };
        let features = features.as_table().unwrap();
        let name = stated(&manifest["package"], "name");
        let defaults = features.get("default").and_then(Value::as_array).cloned().unwrap_or_default();
        let check = format!("\tcargo check --locked -p {name} --no-default-features");
        assert!(makefile.lines().any(|line| line == check), "{check}");
        for feature in features.keys().filter(|feature| *feature != "default") {
            n_features += 1;
            let is_default = if defaults.iter().any(|name| name.as_str() == Some(feature)) { "yes" } else { "no" };
            let row = format!("| `{name}` | `{feature}` | {is_default} | ");
            assert!(page.lines().any(|line| line.starts_with(&row)), "{folder}: {row}");
            let alone = format!("{check} --features {feature}");
            assert!(makefile.lines().any(|line| line == alone), "{alone}");
        }
    }
    assert_eq!(n_features, page.matches("| `wherein-").count());
}
