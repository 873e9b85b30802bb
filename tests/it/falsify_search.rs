use std::{
    fs,
    io::Write,
    process::{Output, Stdio},
    thread,
    time::Duration,
};

use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, rounds, wherein};

/// Exit code, JSON output and error output of a search for failing scenes that writes into the folder `out`.
fn searched(place: &std::path::Path, more: &[&str]) -> (i32, Value, String) {
    let (code, output, errors) = outcome(&mut wherein(place, &[&["falsify", "--json", "--out", "out"], more].concat()));
    (code, serde_json::from_str(&output).unwrap_or_else(|error| panic!("{error}: {output}{errors}")), errors)
}

#[test]
fn a_search_goes_on_where_it_stopped_and_sums_up_all_of_it() {
    let place = folder("falsify_resumed");
    let part = ["--seed", "1", "--without-cameras", "--tries", "0"];
    let (_, first, errors) = searched(&place, &[&part[..], &["--cases", "0..4"]].concat());
    assert!(errors.contains("4 cases run"), "{errors}");
    // The incomplete last line that a killed process leaves in the search's journal must not count as a case.
    let journal = fs::read_dir(place.join("out")).unwrap().map(|entry| entry.unwrap().path());
    let journal = journal.into_iter().find(|path| path.to_string_lossy().contains("journal_")).unwrap();
    fs::OpenOptions::new().append(true).open(journal).unwrap().write_all(b"{\"case\":4,\"run_s").unwrap();
    let (_, second, errors) = searched(&place, &[&part[..], &["--cases", "0..6", "--jobs", "1"]].concat());
    assert!(errors.contains("2 cases run") && errors.contains("4 recorded earlier"), "{errors}");
    assert_eq!((&first["summary"]["runs"], &second["summary"]["runs"]), (&Value::from(4), &Value::from(6)));
    // The same search in one go, with more workers, has to give the same summary.
    let whole = folder("falsify_whole");
    let (_, whole, _) = searched(&whole, &[&part[..], &["--cases", "0..6", "--jobs", "3"]].concat());
    assert_eq!(whole["summary"], second["summary"]);
}

#[test]
fn a_search_by_time_begins_at_once_and_ends_with_its_time() {
    // The search must not list all four billion possible cases before it runs the first.
    let place = folder("falsify_minutes");
    let (code, told, errors) = searched(&place, &["--seed", "3", "--without-cameras", "--minutes", "0.05"]);
    assert!(code == 0 && told["summary"]["runs"].as_u64().unwrap() > 0, "{code} {told} {errors}");
}

#[test]
fn a_process_that_nobody_waits_for_ends() {
    let place = folder("falsify_orphan");
    let text = blind_scene(30_000.0, "[localizer]\nmethods = []\n");
    let mut command = wherein(&place, &["falsify", "--probe", "0"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    write!(input, "{}\n{text}", text.len()).unwrap();
    input.flush().unwrap();
    // Simulating ten hours of driving takes minutes, so that the process is still busy after 0.3 s.
    thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it waits for the end of its input");
    drop(input);
    thread::sleep(Duration::from_secs(5));
    let ended = child.try_wait().unwrap();
    let _ = child.kill();
    assert_eq!(ended.and_then(|status| status.code()), Some(2));
}

#[test]
fn what_a_process_tells_of_a_scene_ends_with_the_run() {
    let place = folder("falsify_probe");
    for (text, told) in [(blind_scene(1.0, "[localizer]\nmethods = []\n"), "ran"), ("[room]\n".to_owned(), "refused")] {
        let mut command = wherein(&place, &["falsify", "--probe", "0"]);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut input = child.stdin.take().unwrap();
        write!(input, "{}\n{text}", text.len()).unwrap();
        input.flush().unwrap();
        let status = child.wait().unwrap();
        let Output { stdout, .. } = child.wait_with_output().unwrap();
        let last: Value =
            serde_json::from_slice(stdout.split(|byte| *byte == b'\n').rfind(|line| !line.is_empty()).unwrap())
                .unwrap();
        assert!(status.success() && last.get(told).is_some(), "{last}");
    }
}

/// The case is a run with a witness. A search that does not ask for witnesses has a journal of its own.
#[test]
fn a_search_for_witnesses_draws_scenes_of_which_they_can_be_checked() {
    let place = folder("falsify_witnesses");
    let part = ["--seed", "9002", "--without-cameras", "--cases", "0..1", "--tries", "0"];
    let (code, with, errors) = searched(&place, &[&part[..], &["--wish", "witness_outside"]].concat());
    assert_eq!((code, &with["summary"]["with_witnesses"]), (0, &Value::from(1)), "{errors}");
    let (_, without, errors) = searched(&place, &part);
    assert_eq!(without["summary"]["with_witnesses"], 0);
    assert!(errors.contains("0 recorded earlier"), "{errors}");
}

#[test]
fn what_cannot_be_searched_is_told_with_code_2() {
    let place = folder("falsify_refused");
    for (wrong, told) in
        [(["--cases", "5..5"], "A less than B"), (["--minutes", "0"], "above 0"), (["--wish", "luck"], "perception")]
    {
        let (code, _, errors) = outcome(&mut wherein(&place, &[&["falsify"], &wrong[..]].concat()));
        assert!(code == 2 && errors.contains(told), "{wrong:?}: {errors}");
    }
}

/// A search that must find no failing scene among random ones: about a minute on two cores at its full length, whose numbers of cases were fixed
/// before the first run.
#[test]
fn random_scenes_keep_the_promise() {
    let place = folder("falsify_random");
    for (profile, cases) in
        [("--without-cameras", rounds("0..30", "0..100")), ("--with-cameras", rounds("0..2", "0..5"))]
    {
        let (code, told, errors) = searched(&place, &["--seed", "2026", profile, "--cases", cases]);
        assert_eq!(code, 0, "{profile}: {told:#}\n{errors}");
    }
}
