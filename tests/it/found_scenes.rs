use std::{fs, path::PathBuf, sync::mpsc, thread, time::Duration};

use sim::scene::Scene;

use crate::command::{folder, outcome, root, wherein};

/// Time limit after which a run counts as one that never ends, on any machine: the slowest run takes seconds.
const PATIENCE: Duration = Duration::from_secs(400);

/// Every scene of `scenes/found`, which holds scenes that once made something fail.
fn found() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("scenes/found")).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    files.sort();
    files
}

/// The seeds in a scene's line `# seeds: 0 1 2`; seed 0 if there is no such line.
fn seeds(text: &str) -> Vec<u64> {
    let stated = text.lines().find_map(|line| line.strip_prefix("# seeds:"));
    stated.map_or_else(|| vec![0], |listed| listed.split_whitespace().map(|seed| seed.parse().unwrap()).collect())
}

#[test]
fn seeds_are_read_from_a_comment() {
    assert_eq!(seeds("# what it showed\n# seeds: 3 14\nduration_s = 1.0\n"), [3, 14]);
    assert_eq!(seeds("# what it showed\n"), [0]);
}

#[test]
fn every_scene_that_broke_something_says_what_it_showed() {
    for path in found() {
        let text = fs::read_to_string(&path).unwrap();
        let first = text.lines().next().unwrap_or_default();
        assert!(
            first.starts_with("# ") && first.len() > 20,
            "{}: the first line has to say what it showed",
            path.display()
        );
    }
}

/// Longest simulated time of scenes that are run with every other test.
const SHORT_S: f64 = 10.0;

#[test]
fn every_short_scene_that_broke_something_keeps_its_promise_now() {
    keep_their_promise("found_short", |simulated_s| simulated_s <= SHORT_S);
}

#[test]
#[ignore = "takes minutes: make test-long"]
fn every_long_scene_that_broke_something_keeps_its_promise_now() {
    keep_their_promise("found_long", |simulated_s| simulated_s > SHORT_S);
}

/// Runs those scenes that broke something whose simulated time is wanted.
fn keep_their_promise(name: &str, is_wanted: impl Fn(f64) -> bool) {
    let out = folder(name);
    for path in found() {
        let text = fs::read_to_string(&path).unwrap();
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("failed to {error}"));
        if !is_wanted(scene.simulated_s()) {
            continue;
        }
        for seed in seeds(&text) {
            let (file, seed) = (path.display().to_string(), seed.to_string());
            let mut command = wherein(&out, &["run", &file, "--seed", &seed, "--out", "out"]);
            let (sender, receiver) = mpsc::channel();
            thread::spawn(move || sender.send(outcome(&mut command)));
            let ended = receiver.recv_timeout(PATIENCE);
            let (code, _, errors) = ended.unwrap_or_else(|cause| panic!("{file} --seed {seed}: {cause}"));
            assert_eq!(code, 0, "{file} --seed {seed}: {errors}");
        }
    }
}
