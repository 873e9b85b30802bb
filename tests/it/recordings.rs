use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use mcap::{MessageStream, WriteOptions, Writer, read::LinearReader, records::Metadata, records::Record};
use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, scene_text, wherein};

/// Runs a scene of the repository with `flags`, after replacing `from` in the scene's text by `to`; returns the folder of the run.
fn recorded(place: &Path, scene: &str, [from, to]: [&str; 2], flags: &[&str]) -> PathBuf {
    let text = scene_text(scene);
    assert!(text.contains(from), "{scene} has no {from}");
    fs::write(place.join("scene.toml"), text.replace(from, to)).unwrap();
    let arguments = [&["run", "scene.toml", "--seed", "3", "--out", "out"], flags].concat();
    let (code, _, errors) = outcome(&mut wherein(place, &arguments));
    assert!(code < 2, "{errors}");
    place.join("out/scene/3")
}

fn recorded_blind(place: &Path, out: &str, flag: &str) -> PathBuf {
    fs::write(place.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let arguments = ["run", "scene.toml", flag, "--out", out];
    assert_eq!(outcome(&mut wherein(place, &arguments)).0, 0);
    place.join(out).join("scene/0")
}

/// Payloads of each topic's messages in the order of the recording, as the `mcap` crate reads them.
fn messages(recording: &Path) -> BTreeMap<String, Vec<Vec<u8>>> {
    let bytes = fs::read(recording).unwrap();
    let mut topics: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert_eq!(message.channel.message_encoding, "cdr");
        assert_eq!(message.channel.schema.as_ref().unwrap().encoding, "ros2msg");
        topics.entry(message.channel.topic.clone()).or_default().push(message.data.to_vec());
    }
    topics
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn rows(path: &Path, skipped: usize) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let numbers = |line: &str| line.split([' ', ',']).map(|field| field.parse().unwrap_or(f64::NAN)).collect();
    text.lines().skip(skipped).map(numbers).collect()
}

/// Writes a copy of an MCAP recording: each message goes through `change`, and the stated format becomes `format`.
fn altered(from: &Path, to: &Path, change: impl Fn(&str, &mut Vec<u8>), format: &str) {
    let bytes = fs::read(from).unwrap();
    let mut writer =
        Writer::with_options(fs::File::create(to).unwrap(), WriteOptions::new().compression(None)).unwrap();
    let mut attachments = Vec::new();
    for record in LinearReader::new(&bytes).unwrap() {
        match record.unwrap() {
            Record::Metadata(mut metadata) => {
                if let Some(value) = metadata.metadata.get_mut("format") {
                    *value = format.to_owned();
                }
                if metadata.name == "wherein" {
                    for message in MessageStream::new(&bytes).unwrap() {
                        let mut message = message.unwrap();
                        let mut data = message.data.to_vec();
                        change(&message.channel.topic, &mut data);
                        message.data = data.into();
                        writer.write(&message).unwrap();
                    }
                }
                writer.write_metadata(&Metadata { name: metadata.name, metadata: metadata.metadata }).unwrap();
            }
            Record::Attachment { header, data, .. } => {
                attachments.push(header.name.clone());
                let (name, media_type) = (header.name, header.media_type);
                writer.attach(&mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data }).unwrap();
            }
            _ => {}
        }
    }
    assert_eq!(attachments, ["scene.toml"]);
    writer.finish().unwrap();
}

/// Runs `wherein replay` with these arguments; returns the exit code, the output and the errors.
fn replayed(place: &Path, arguments: &[&str]) -> (i32, String, String) {
    outcome(&mut wherein(place, &[&["replay"], arguments].concat()))
}

fn assert_same_estimates(place: &Path, run: &Path, recording: &str) {
    let (code, output, errors) = replayed(place, &[run.join(recording).to_str().unwrap(), "--out", "again"]);
    assert_eq!(code, 0, "{output}{errors}");
    let summary: Value = serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap();
    let digest = summary["digest"]["estimates"].as_str().unwrap();
    assert!(output.contains(&format!("digest.estimates {digest}, recorded {digest}\n")), "{output}");
    for name in ["estimate.tum", "boxes.csv"] {
        assert_eq!(fs::read(place.join("again").join(name)).unwrap(), fs::read(run.join(name)).unwrap(), "{name}");
    }
}

#[test]
fn a_recording_holds_what_the_camera_gave_where_the_robot_was_and_every_box() {
    let place = folder("recording_holds");
    let run = recorded(
        &place,
        "tiles.toml",
        ["duration_s = 20.0", "duration_s = 0.5"],
        &["--record", "--frames", "every=100"],
    );
    let topics = messages(&run.join("recording.mcap"));

    // The grey levels of an image are the last field of its recorded message, so that the message must end with the pixels of the image file.
    let picture = image::open(run.join("image_00000.png")).unwrap().into_luma8();
    let recorded = &topics["/floor_camera/image"][0];
    assert!(recorded.ends_with(picture.as_raw()));
    for topic in ["/floor_camera/camera_info", "/wherein/image_stamp"] {
        assert_eq!(topics[topic].len(), topics["/floor_camera/image"].len(), "{topic}");
    }

    // Bytes of a `/truth` message after the encapsulation header: time 8, "world" 4 + 6, padding 2, "true_robot" 4 + 11, padding 5, then x and y.
    let truths = rows(&run.join("truth.tum"), 0);
    assert_eq!(topics["/truth"].len(), truths.len());
    for (message, row) in topics["/truth"].iter().zip(&truths) {
        assert_eq!([f64_at(message, 44), f64_at(message, 52)], [row[1], row[2]]);
    }

    // Bytes of an `/wherein/estimate` message: time 8, soundness 1, padding 3, count 4, then the bounds of one box after the other.
    let boxes: Vec<f64> = rows(&run.join("boxes.csv"), 1).into_iter().flat_map(|row| row[3..9].to_vec()).collect();
    let bounds = topics["/wherein/estimate"]
        .iter()
        .flat_map(|message| (20..message.len()).step_by(8).map(|at| f64_at(message, at)));
    assert_eq!(bounds.collect::<Vec<f64>>(), boxes);
    assert_eq!(topics["/boxes"].len(), truths.len().div_ceil(5));
    assert!(!place.join("out/scene").read_dir().unwrap().any(|entry| entry.unwrap().file_name() != "3"));
}

#[test]
fn a_replay_of_images_gives_the_same_estimates() {
    let place = folder("replay_floor");
    let run = recorded(&place, "tiles.toml", ["duration_s = 20.0", "duration_s = 1.0"], &["--record"]);
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn a_replay_of_images_in_the_dark_gives_the_same_headings() {
    let place = folder("replay_dark");
    let run = recorded(&place, "dark/walls.toml", ["duration_s = 60.0", "duration_s = 1.2"], &["--record"]);
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn a_recording_is_replayed_through_the_localizer_that_the_user_names() {
    let place = folder("replay_subject");
    let changed = ["duration_s = 20.0", "duration_s = 1.0"];
    let run = recorded(&place, "tiles.toml", changed, &["--record", "--subject", "ekf"]);
    let recording = run.join("recording.mcap");
    let replay = |subject: &str| {
        replayed(&place, &[recording.to_str().unwrap(), "--subject", subject, "--out", &format!("by {subject}")])
    };
    let (code, output, errors) = replay("ekf");
    assert!(code == 0 && output.contains("equal to the recorded ones bit for bit"), "{output}{errors}");
    let answers = |subject: &str| fs::read(place.join(format!("by {subject}")).join("estimate.tum")).unwrap();
    assert_eq!(answers("ekf"), fs::read(run.join("estimate.tum")).unwrap());
    for subject in ["ekf,motion=2", "particles", "intervals"] {
        let (code, output, errors) = replay(subject);
        let told = format!("estimates of {subject}, on the readings of a drive that tested ekf\n");
        assert!(code == 0 && output.contains(&told), "{output}{errors}");
        assert_ne!(answers(subject), answers("ekf"), "{subject}");
    }
    // The filter's pose is in the boxes of the same readings.
    let boxes = rows(&place.join("by intervals/boxes.csv"), 1);
    let last = boxes.last().unwrap();
    let pose = rows(&run.join("estimate.tum"), 0).pop().unwrap();
    assert!((last[3]..=last[4]).contains(&pose[1]) && (last[5]..=last[6]).contains(&pose[2]), "{pose:?} {last:?}");

    let (code, output, errors) = replay("exit 3");
    assert!(code == 1 && output.contains("the subject failed at 0.00 s"), "{output}{errors}");
}

#[test]
fn a_replay_of_a_doubt_gives_the_same_recovery() {
    let place = folder("replay_doubt");
    let run = recorded(&place, "broken/push_25cm.toml", ["duration_s = 30.0", "duration_s = 10.0"], &["--record"]);
    assert!(fs::read_to_string(run.join("boxes.csv")).unwrap().contains(",recovering,"));
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn a_replay_of_the_flow_sensor_gives_the_same_estimates() {
    let place = folder("replay_flow");
    let run =
        recorded(&place, "papers/dark_carpet_flow.toml", ["duration_s = 872.0", "duration_s = 8.0"], &["--record"]);
    assert!(messages(&run.join("recording.mcap"))["/wherein/flow"].len() > 100);
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn a_replay_of_stations_gives_the_same_estimates() {
    let place = folder("replay_stations");
    let run = recorded(&place, "stations.toml", ["description", "description"], &["--record"]);
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn a_replay_of_range_camera_and_gyroscope_learns_the_same_landmarks() {
    let place = folder("replay_range");
    let run =
        recorded(&place, "papers/rigid_transform_loop.toml", ["duration_s = 195.0", "duration_s = 20.0"], &["--ros2"]);
    let topics = messages(&run.join("rosbag2/rosbag2_0.mcap"));
    assert!(topics["/wherein/range"].len() > 10 && topics["/wherein/gyro"].len() > 100);
    assert_same_estimates(&place, &run, "rosbag2/rosbag2_0.mcap");
}

#[test]
fn a_replay_of_a_device_without_a_type_of_its_own_gives_the_same_estimates() {
    let place = folder("replay_gnss");
    let run = recorded(&place, "gnss.toml", ["duration_s = 60.0", "duration_s = 10.0"], &["--record"]);
    assert!(messages(&run.join("recording.mcap"))["/wherein/other"].len() > 50);
    assert_same_estimates(&place, &run, "recording.mcap");
}

#[test]
fn equal_runs_leave_equal_recordings() {
    let place = folder("recording_equal");
    for (flag, path) in
        [("--record", "recording.mcap"), ("--ros2", "rosbag2/rosbag2_0.mcap"), ("--ros2", "rosbag2/metadata.yaml")]
    {
        let [one, other] = ["one", "other"].map(|out| fs::read(recorded_blind(&place, out, flag).join(path)).unwrap());
        assert!(one == other, "{path}");
    }
}

#[test]
fn a_run_is_recorded_in_both_forms_at_once() {
    let place = folder("recording_both");
    fs::write(place.join("scene.toml"), blind_scene(0.5, "")).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&place, &["run", "scene.toml", "--record", "--ros2"]));
    assert_eq!(code, 0, "{stderr}");
    let run = place.join("renders/scene/0");
    let counted = |path: &str| messages(&run.join(path)).into_values().map(|all| all.len()).sum::<usize>();
    assert!(counted("recording.mcap") > 50 && counted("rosbag2/rosbag2_0.mcap") > 50);
    // A bag is named by its folder, as ROS 2 does.
    let bag = run.join("rosbag2").display().to_string();
    let estimate = run.join("boxes.csv").display().to_string();
    assert_eq!(replayed(&place, &[&bag]).0, 0);
    assert_eq!(outcome(&mut wherein(&place, &["judge", &bag, "--estimate", &estimate])).0, 0);
    let (code, _, stderr) = replayed(&place, &["."]);
    assert!(code == 2 && stderr.contains("a folder with 0 files that end in .mcap"), "{stderr}");
}

#[test]
fn other_ticks_are_told_by_the_replay_and_its_exit_code() {
    let place = folder("replay_other");
    let recording = recorded_blind(&place, "out", "--record").join("recording.mcap");
    altered(&recording, &place.join("same.mcap"), |_, _| {}, "1");
    assert_eq!(replayed(&place, &["same.mcap"]).0, 0);
    // In a wheel message the ticks of the left wheel follow the encapsulation header and two times. Here they are doubled.
    let one_more = |topic: &str, data: &mut Vec<u8>| {
        if topic == "/wherein/wheels" {
            let ticks = i64::from_le_bytes(data[20..28].try_into().unwrap());
            data[20..28].copy_from_slice(&(ticks * 2).to_le_bytes());
        }
    };
    altered(&recording, &place.join("other.mcap"), one_more, "1");
    let (code, output, _) = replayed(&place, &["other.mcap"]);
    assert!(code == 1 && output.contains("differ from the recorded ones"), "{output}");
}

#[test]
fn another_scenes_localizer_may_answer_differently() {
    let place = folder("replay_scene");
    let recording = recorded_blind(&place, "out", "--record").join("recording.mcap");
    fs::write(place.join("wider.toml"), blind_scene(1.0, "[bounds]\nslip_ratio = 0.2\n")).unwrap();
    let (code, output, errors) = replayed(&place, &[recording.to_str().unwrap(), "--scene", "wider.toml"]);
    assert!(code == 0 && output.contains("differ from the recorded ones"), "{output}{errors}");
}

#[test]
fn what_is_no_whole_recording_of_this_format_is_refused_and_nothing_is_written() {
    let place = folder("replay_refusals");
    let recording = recorded_blind(&place, "out", "--record").join("recording.mcap");
    let whole = fs::read(&recording).unwrap();
    for length in [20, whole.len() / 3, whole.len() - 1000, whole.len() - 1] {
        fs::write(place.join(format!("cut_{length}.mcap")), &whole[..length]).unwrap();
    }
    altered(&recording, &place.join("future.mcap"), |_, _| {}, "99");
    altered(
        &recording,
        &place.join("short_message.mcap"),
        |topic, data| data.truncate(if topic == "/wherein/wheels" { 22 } else { data.len() }),
        "1",
    );
    let mut flipped = whole.clone();
    flipped[whole.len() / 3] ^= 1;
    fs::write(place.join("flipped.mcap"), flipped).unwrap();
    fs::write(place.join("text.mcap"), "no recording at all").unwrap();
    fs::write(place.join("empty.mcap"), "").unwrap();
    let mut foreign = Writer::new(fs::File::create(place.join("foreign.mcap")).unwrap()).unwrap();
    foreign.finish().unwrap();
    drop(foreign);
    let cut = |length: usize| format!("cut_{length}.mcap");
    let cases = [
        (cut(20), "it is cut short"),
        (cut(whole.len() / 3), "it is cut short"),
        (cut(whole.len() - 1000), "it is cut short"),
        (cut(whole.len() - 1), "it is cut short"),
        ("empty.mcap".to_owned(), "it is cut short"),
        ("future.mcap".to_owned(), "its format is `99`, expected `1`"),
        ("short_message.mcap".to_owned(), "a message of /wherein/wheels is not what its topic promises"),
        ("flipped.mcap".to_owned(), "expected an MCAP file"),
        ("text.mcap".to_owned(), "expected an MCAP file"),
        ("foreign.mcap".to_owned(), "the metadata `wherein_format` is missing"),
        ("nowhere.mcap".to_owned(), "No such file"),
        ("out".to_owned(), "a folder with 0 files that end in .mcap"),
    ];
    for (name, expected) in cases {
        let (code, output, errors) = replayed(&place, &[&name, "--out", "replayed"]);
        assert_eq!((code, output.as_str()), (2, ""), "{name}: {errors}");
        assert!(
            errors.starts_with("wherein: failed to read recording ") && errors.contains(expected),
            "{name}: {errors}"
        );
        assert!(errors.contains(&name) && !place.join("replayed").exists(), "{name}: {errors}");
    }
}
