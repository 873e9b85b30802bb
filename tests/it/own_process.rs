//! Localizers in processes of their own: what they are sent, how their answers are judged, and what becomes of those that misbehave.

use std::{
    collections::HashSet,
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

use mcap::MessageStream;
use serde_json::Value;
use sim::{
    loading::SceneFile,
    run::{RunOptions, RunRecord, run},
    scene::Scene,
    subject::IntervalLocalizer,
    world::Drawn,
};

use crate::command::{blind_scene, folder_of, outcome, root, wherein};

/// Devices without cameras, so that all kinds of readings occur that are numbers.
const DEVICES: &str =
    "[robot.gyro]\n[robot.flow]\n[robot.gnss]\n[robot.range_camera]\n[[landmark]]\nx_m = 2.6\ny_m = 1.4\n";

/// A process that answers, of the given kind, that the robot stands where it was started, until it misbehaves in place of its third answer.
fn still(answers: &str) -> String {
    format!("'{}' {answers}", env!("CARGO_BIN_EXE_own-localizer-under-test"))
}

/// Runs a scene with a command as the tested localizer; returns the exit code, standard error and the folder of the run.
fn tested(folder: &Path, command: &str, more: &[&str]) -> (i32, String, PathBuf) {
    let arguments = [&["run", "scene.toml", "--out", "out", "--subject", command], more].concat();
    let (code, _, said) = outcome(&mut wherein(folder, &arguments));
    (code, said, folder.join("out/scene/0"))
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

/// Numbers of a file in the format of TUM, line by line.
fn poses(run: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(run.join("estimate.tum")).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect()
}

/// Whether a program runs here. Where it is missing, a part of a test that needs it is left out, which is said even where the test passes: what is
/// written to standard error without a macro is not held back.
fn runs(program: &str) -> bool {
    let runs = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !runs {
        io::stderr().write_all(format!("LEFT OUT: there is no {program} here\n").as_bytes()).unwrap();
    }
    runs
}

#[test]
fn a_process_that_misbehaves_fails_the_run_and_names_time_and_reading() {
    let folder = folder_of("process_misdeeds", &[("scene.toml", &blind_scene(1.0, ""))]);
    let at_third = |misdeed: &str| (still(&format!("pose {misdeed}")), 0.02);
    // What a closed input shows as depends on whether it is closed before the first message is written or after.
    let cases = [
        (("exit 3".to_owned(), 0.0), "exit status: 3"),
        (("no/such/program".to_owned(), 0.0), "exit status: 127"),
        (("sleep 1000".to_owned(), 0.0), "no answer within 1 s"),
        (("cat /dev/zero".to_owned(), 0.0), "8388608 bytes without the end of a line"),
        (("exec 0<&-; sleep 1000".to_owned(), 0.0), "closed its standard input|no answer within 1 s"),
        (("exec 1>&-; sleep 1000".to_owned(), 0.0), "closed its standard output"),
        (("yes '{\"time_s\": 0, \"pose\": [0, 0, 0]}'".to_owned(), 0.01), "the past"),
        (at_third("exit"), "exit status: 7"),
        (at_third("abort"), "signal: 6|exit status: 134"),
        (at_third("hang"), "no answer within 1 s"),
        (at_third("garbage"), "`\\u{7}what?`, expected an answer in JSON"),
        (at_third("nan"), "not finite"),
        (at_third("lopsided"), "not symmetric"),
        (at_third("negative"), "negative eigenvalue"),
        (at_third("future"), "the future: `time_s` is 5, expected 0.02"),
        (at_third("past"), "the past: `time_s` is 0.01, expected 0.02"),
        (at_third("flood"), "8388608 bytes without the end of a line"),
    ];
    for ((command, time_s), reason) in cases {
        // Only a process that hangs is waited for; the others answer or end at once, but for the load of the machine.
        let limit_s = if reason.contains("no answer") { "1" } else { "20" };
        let (code, said, run) = tested(&folder, &command, &["--subject-timeout-s", limit_s]);
        assert_eq!(code, 1, "{command}: {said}");
        let summary = summary(&run);
        let failure = &summary["subject_failure"];
        let told = failure["reason"].as_str().unwrap();
        assert!(reason.split('|').any(|reason| told.contains(reason)), "{command}: {failure}");
        assert!((failure["time_s"].as_f64().unwrap() - time_s).abs() < 1e-9, "{command}: {failure}");
        // The wheels are read every 10 ms from 0 s on, and nothing else is.
        let number = (time_s / 0.01).round() + 1.0;
        assert_eq!(failure["reading"]["number"].as_f64().unwrap(), number, "{command}: {failure}");
        assert_eq!(failure["reading"]["device"], "wheels", "{command}: {failure}");
        assert!((failure["reading"]["measured_s"].as_f64().unwrap() - time_s).abs() < 0.005, "{command}: {failure}");
        // What was answered before is kept and judged.
        assert_eq!(poses(&run).len(), number as usize - 1, "{command}");
        assert_eq!(summary["verdict"]["passed"], false, "{command}");
        assert!(said.contains(told) && said.contains("the subject failed at 0.0"), "{command}: {said}");
        assert!(said.contains(&format!(" --subject-timeout-s {limit_s} --seed 0 ")), "{command}: {said}");
        let left: Vec<_> =
            fs::read_dir(run.parent().unwrap()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["0"], "{command}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn nothing_that_a_process_has_started_outlives_its_run() {
    let folder = folder_of("process_brood", &[("scene.toml", &blind_scene(1.0, ""))]);
    let (code, _, run) = tested(&folder, &still("pose brood"), &[]);
    let log = fs::read_to_string(run.join("subject.log")).unwrap();
    let id = log.trim().strip_prefix("brood ").unwrap();
    assert_eq!(code, 1);
    assert!(is_gone(id) && !is_gone("self"));
}

/// Whether a process is not there any more. One that has ended may still be listed, as a zombie, until its new parent looks.
#[cfg(target_os = "linux")]
fn is_gone(id: &str) -> bool {
    let state = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    state.is_empty() || state.contains(") Z ")
}

#[test]
#[cfg(target_os = "linux")]
fn nothing_that_a_process_has_started_outlives_a_run_that_is_killed() {
    let folder = folder_of("process_orphan", &[("scene.toml", &blind_scene(1.0, ""))]);
    // The process says who it is once it has started another one, and both hang.
    let command = "sleep 1000 & echo $$ $! > ids.new && mv ids.new ids; wait";
    let arguments = ["run", "scene.toml", "--out", "out", "--subject", command, "--subject-timeout-s", "300"];
    let mut run = wherein(&folder, &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let awaited = |is_there: &dyn Fn() -> bool| {
        (0..200).any(|_| {
            std::thread::sleep(Duration::from_millis(50));
            is_there()
        })
    };
    assert!(awaited(&|| folder.join("ids").exists()));
    let ids = fs::read_to_string(folder.join("ids")).unwrap();
    run.kill().unwrap();
    run.wait().unwrap();
    assert!(awaited(&|| ids.split_whitespace().all(is_gone)), "{ids}");
}

#[test]
fn each_kind_of_answer_reaches_the_judge() {
    let folder = folder_of("process_kinds", &[("scene.toml", &blind_scene(0.5, ""))]);
    for kind in ["pose", "gaussian", "samples", "boxes"] {
        let (code, said, run) = tested(&folder, &still(kind), &[]);
        assert_eq!(code, 0, "{kind}: {said}");
        let (summary, poses) = (summary(&run), poses(&run));
        assert_eq!(summary["subject"], still(kind).as_str());
        assert_eq!(summary["subject_failure"], Value::Null, "{kind}");
        assert_eq!(summary["containment"].is_object(), kind == "boxes", "{kind}");
        // Of these programs one tells the stamp of its newest reading, which is always 20 ms old.
        let age_s = summary["latency_s"]["mean"].as_f64();
        assert_eq!(age_s.map(|age_s| (1e3 * age_s).round()), (kind == "gaussian").then_some(20.0), "{kind}");
        // The start of the scene, at every step of 10 ms.
        assert!(poses.len() == 51 && poses.iter().all(|pose| (pose[1] - 0.6).abs() < 1e-9), "{kind}: {poses:?}");
    }
}

#[test]
fn a_process_is_started_anew_for_every_run_and_equal_runs_give_equal_files() {
    let folder = folder_of("process_anew", &[("scene.toml", &blind_scene(1.0, DEVICES))]);
    let command = format!("echo started >> starts; {}", still("gaussian"));
    for out in ["one", "two"] {
        let arguments = ["run", "scene.toml", "--seeds", "0..2", "--out", out, "--subject", &command];
        assert_eq!(outcome(&mut wherein(&folder, &arguments)).0, 0);
    }
    assert_eq!(fs::read_to_string(folder.join("starts")).unwrap().lines().count(), 4);
    for name in ["summary.json", "estimate.tum", "steps.csv"] {
        let [one, two] = ["one", "two"].map(|out| fs::read(folder.join(out).join("scene/0").join(name)).unwrap());
        assert!(one == two && !one.is_empty(), "{name}");
    }
}

#[test]
fn a_sweep_tests_a_process_too() {
    let folder = folder_of("process_sweep", &[("scene.toml", &blind_scene(0.5, ""))]);
    let sweep = |command: &str| {
        let arguments = ["sweep", "scene.toml", "--seeds", "0..2", "--out", "out", "--subject", command];
        outcome(&mut wherein(&folder, &arguments))
    };
    // A sweep takes up where an earlier one stopped, but for a command, which may have been changed since.
    for n_runs in [2, 4] {
        assert_eq!(sweep(&format!("echo started >> starts; {}", still("pose"))).0, 0);
        assert_eq!(fs::read_to_string(folder.join("starts")).unwrap().lines().count(), n_runs);
    }
    let (code, said, _) = sweep(&still("pose nan"));
    assert!(code == 1 && said.contains("the subject failed"), "{code}: {said}");
}

#[test]
fn a_mistyped_name_is_not_taken_for_a_command() {
    let folder = folder_of("process_name", &[("scene.toml", &blind_scene(0.5, ""))]);
    let (code, said, run) = tested(&folder, "interval", &[]);
    assert!(code == 2 && said.contains("no such localizer") && said.contains("intervals"), "{said}");
    assert!(!run.exists());
    for (subject, expected) in [
        ("ekf,", "expected motion=FACTOR or cues=FACTOR"),
        ("ekf,motion=0", "a number from 0.001 to 1000"),
        ("particles,cues=1e9", "a number from 0.001 to 1000"),
        ("ekf,noise=2", "expected motion=FACTOR or cues=FACTOR"),
        ("particles,motion=2,cues=1,motion=3", "`motion` is stated twice"),
        ("intervals,motion=2", "boxes have no standard deviations"),
    ] {
        let (code, said, run) = tested(&folder, subject, &[]);
        assert!(code == 2 && said.contains(expected) && !run.exists(), "{subject}: {said}");
    }
    let (code, said, _) = tested(&folder, "./x", &["--subject-timeout-s", "0"]);
    assert!(code == 2 && said.contains("seconds from 0.001"), "{said}");
}

/// Compares an example, which is dead reckoning by gyroscope, with the wheel odometry that every run computes for comparison.
fn checked_example(name: &str, command: &str) -> Vec<Vec<f64>> {
    let folder = folder_of(name, &[("scene.toml", &blind_scene(10.0, "[robot.gyro]\n"))]);
    let (code, said, run) = tested(&folder, command, &[]);
    assert_eq!(code, 0, "{said}");
    let (summary, poses) = (summary(&run), poses(&run));
    // The robot drives 1.9 m. The declared bounds on bias, slip and start allow some 5 cm; one that stood still would be off by a metre.
    let off_m = summary["error"]["position_m"]["max"].as_f64().unwrap();
    assert!(off_m < 0.05 && poses.last().unwrap()[1] > 2.0, "{name}: {off_m} m");
    assert!(!run.join("subject.log").exists());
    poses
}

#[test]
fn the_examples_in_python_and_cpp_answer_alike() {
    let examples = root().join("examples/own_localizer");
    let python = runs("python3")
        .then(|| checked_example("process_python", &format!("python3 '{}'", examples.join("odometry.py").display())));
    let cpp = runs("c++").then(|| {
        let folder = folder_of("process_cpp_build", &[]);
        let mut compiler = Command::new("c++");
        let built = compiler.args(["-std=c++17", "-O2", "-o", "odometry"]).current_dir(&folder);
        let (code, _, said) = outcome(built.arg(examples.join("odometry.cpp")));
        assert_eq!(code, 0, "{said}");
        checked_example("process_cpp", &format!("'{}'", folder.join("odometry").display()))
    });
    let (Some(python), Some(cpp)) = (python, cpp) else { return };
    assert_eq!(python.len(), cpp.len());
    for (one, other) in python.iter().flatten().zip(cpp.iter().flatten()) {
        assert!((one - other).abs() < 1e-9, "{one} in Python, {other} in C++");
    }
}

/// All numbers in a JSON value.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Number(number) => found.extend(number.as_f64()),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
        Value::Object(entries) => entries.values().for_each(|entry| numbers(entry, found)),
        _ => {}
    }
}

/// What the simulator alone knows of a run: all that a seed draws, and the true state at every step. Numbers that a person would write, such as 0, are
/// left out, because they may stand for something else.
fn known_to_the_simulator(record: &RunRecord, scene: &Scene) -> HashSet<u64> {
    let drawn = format!("{:?}", Drawn::draw(scene, record.seed));
    let of_seed =
        drawn.split(|c: char| !(c.is_ascii_alphanumeric() || ".-".contains(c))).filter_map(|word| word.parse().ok());
    let of_truth = record.truths.iter().flat_map(|truth| {
        let parts = [truth.wheel_angle_rad, truth.wheel_travel_m, truth.tilt_rad].concat();
        [truth.pose.to_array().to_vec(), truth.velocity.to_vec(), parts].concat()
    });
    // More than 8 significant digits are no coincidence.
    let is_long =
        |number: &f64| number.is_finite() && format!("{:e}", number.abs()).split('e').next().unwrap().len() > 9;
    of_seed.chain(of_truth).filter(is_long).map(f64::to_bits).collect()
}

#[test]
fn a_process_is_sent_every_reading_and_nothing_that_only_the_simulator_knows() {
    let text = blind_scene(2.0, DEVICES);
    let folder = folder_of("process_truth", &[("scene.toml", &text)]);
    let (code, said, _) = tested(&folder, &format!("tee got.mcap | {}", still("pose")), &[]);
    assert_eq!(code, 0, "{said}");
    let got = fs::read(folder.join("got.mcap")).unwrap();
    let scene = SceneFile::load(&folder.join("scene.toml")).unwrap().scene;
    let record = run(&scene, 0, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let secret = known_to_the_simulator(&record, &scene);
    assert!(secret.len() > 1000, "{}", secret.len());
    let (mut sent, mut topics, mut text) = (Vec::new(), HashSet::new(), String::new());
    // The stream is a complete MCAP file, which a reader of others reads to its end.
    for message in MessageStream::new(&got).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), ("jsonschema", "json"));
        let content: Value = serde_json::from_slice(&message.data).unwrap();
        numbers(&content, &mut sent);
        text += &content.to_string();
        topics.insert(message.channel.topic.clone());
        // Each message has what its schema requires, and nothing that the schema does not name.
        let schema: Value = serde_json::from_slice(&schema.data).unwrap();
        let named: HashSet<&String> = schema["properties"].as_object().unwrap().keys().collect();
        assert_eq!(named, content.as_object().unwrap().keys().collect(), "{}", message.channel.topic);
    }
    for topic in ["setup", "start", "wheels", "gyro", "flow", "range", "other", "ask"] {
        assert!(topics.contains(&format!("/wherein/{topic}")), "{topics:?}");
    }
    let leaked: Vec<f64> = sent.iter().copied().filter(|number| secret.contains(&number.to_bits())).collect();
    assert!(leaked.is_empty(), "{leaked:?}");
    assert!(!text.contains("true") && !text.contains("seed") && !text.contains("drawn"));
    // The control: a true pose in the stream would have been found, in JSON and in bytes.
    let true_x_m = record.truths[100].pose.x_m;
    assert!(secret.contains(&true_x_m.to_bits()) && !got.windows(8).any(|bytes| bytes == true_x_m.to_le_bytes()));
    let asked = sent.iter().filter(|number| **number == 1.23).count();
    assert!(asked >= 1, "the time 1.23 s is asked for");
}

#[test]
fn the_page_of_the_protocol_names_every_topic_and_every_key() {
    let page = fs::read_to_string(root().join("docs/src/own_localizer_process.md")).unwrap();
    let folder = folder_of("process_page", &[("scene.toml", &blind_scene(0.5, DEVICES))]);
    tested(&folder, &format!("tee got.mcap | {}", still("pose")), &[]);
    let got = fs::read(folder.join("got.mcap")).unwrap();
    let mut n_keys = 0;
    let mut names = |name: &str| {
        n_keys += 1;
        assert!(page.contains(&format!("`{name}`")), "the page does not name `{name}`");
    };
    for message in MessageStream::new(&got).unwrap().map(Result::unwrap) {
        names(&message.channel.topic);
        keys(&serde_json::from_slice(&message.data).unwrap(), &mut names);
    }
    assert!(n_keys > 100);
}

/// Calls `take` for every key in a JSON value.
fn keys(value: &Value, take: &mut impl FnMut(&str)) {
    match value {
        Value::Object(entries) => entries.iter().for_each(|(key, entry)| {
            take(key);
            keys(entry, take);
        }),
        Value::Array(items) => items.iter().for_each(|item| keys(item, take)),
        _ => {}
    }
}
