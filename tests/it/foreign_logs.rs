//! The logs are those of scripts/foreign_logs, which the Python package rosbags wrote from plain arrays of numbers. The robot's wheels slip by 0.3 %
//! there, and its gyroscope has a bias of 0.05°/s.

use std::{fs, path::Path};

use serde_json::Value;
use sim::{
    artefacts::log::{LogError, LogReplay, replay_log},
    loading::SceneFile,
    subject::SubjectChoice,
};

use crate::command::{folder, folder_of, outcome, root, rounds, wherein};

fn logs() -> std::path::PathBuf {
    root().join("tests/logs")
}

/// The robot's file of this name, with pieces of its text replaced by others.
fn robot(name: &str, changes: &[(&str, &str)]) -> SceneFile {
    let path = logs().join(name);
    let mut text = fs::read_to_string(&path).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{name} has no `{from}`");
        text = text.replace(from, to);
    }
    let beside = folder_of(&format!("log_{name}_{}", fingerprint(&text)), &[(name, &text)]);
    SceneFile::load(&beside.join(name)).unwrap_or_else(|error| panic!("failed to {error}"))
}

fn fingerprint(text: &str) -> u64 {
    // Tests run side by side, and each change of a file needs a folder of its own.
    text.bytes()
        .fold(1_469_598_103_934_665_603, |sum: u64, byte| (sum ^ u64::from(byte)).wrapping_mul(1_099_511_628_211))
}

fn replayed(robot: &SceneFile, log: &str) -> Result<LogReplay, LogError> {
    replay_log(robot, &logs().join(log), &SubjectChoice::default())
}

fn summary_of(robot: &SceneFile, log: &str) -> Value {
    replayed(robot, log).unwrap_or_else(|error| panic!("{log}: failed to {error}")).summary
}

fn assert_holds_the_truth(summary: &Value, at_least: u64) {
    let containment = &summary["containment"];
    assert_eq!(containment["checks"], containment["contained"], "{containment}");
    assert!(containment["checks"].as_u64().unwrap() >= at_least, "{containment}");
}

fn message_of(result: Result<LogReplay, LogError>) -> String {
    match result {
        Ok(replay) => panic!("the log is not refused:\n{}", replay.text),
        Err(error) => format!("failed to {error}"),
    }
}

#[test]
fn bags_of_either_storage_and_compression_give_the_same_readings_and_hold_the_truth() {
    let robot = robot("wheels.toml", &[]);
    let one = summary_of(&robot, "wheels_mcap");
    assert_holds_the_truth(&one, 30);
    // By the script: 3 s of wheels 50 times a second and of the gyroscope 100 times.
    assert_eq!(one["log"]["topics"]["/joint_states"]["messages"], 151);
    assert_eq!(one["log"]["topics"]["/imu/data"]["messages"], 301);
    assert_eq!(one["log"]["topics"]["/scan"]["read_as"], Value::Null);
    assert_eq!(one["verdict"]["failed"], Value::Array(Vec::new()));
    // The digests of readings and estimates are of every bit of them.
    for log in
        ["wheels_sqlite", "wheels_mcap_chunk_zstd", "wheels_mcap/wheels_mcap.mcap", "wheels_sqlite/wheels_sqlite.db3"]
    {
        let other = summary_of(&robot, log);
        for digest in ["readings", "estimates"] {
            assert_eq!(one["digest"][digest], other["digest"][digest], "{digest} of {log}");
        }
    }
}

#[test]
fn odometry_with_a_law_of_its_error_takes_the_place_of_wheels() {
    let robot =
        robot("odometry.toml", &[("gnss = {", "# gnss = {"), (r#"methods = ["gnss_positions"]"#, "methods = []")]);
    for log in ["odometry_sqlite_zstd", "odometry_mcap_message_zstd"] {
        let summary = summary_of(&robot, log);
        assert_holds_the_truth(&summary, 20);
        assert!(summary["log"]["sideways_odometry_m"].as_f64().unwrap() < 0.01, "{summary:#}");
    }
    // The odometry's ways are 0.3 % too long. A law that allows less than that is broken, and the true poses show it.
    let tight = self::robot(
        "odometry.toml",
        &[
            ("gnss = {", "# gnss = {"),
            (r#"methods = ["gnss_positions"]"#, "methods = []"),
            ("floor_m = 0.001, share = 0.01, m_per_s = 0.0005", "floor_m = 0.0, share = 0.0005, m_per_s = 0.0"),
            ("tolerance_m = 0.001, tolerance_deg = 0.05", "tolerance_m = 0.0002, tolerance_deg = 0.01"),
        ],
    );
    let summary = summary_of(&tight, "odometry_sqlite_zstd");
    let slip = summary["bounds"].as_array().unwrap().iter().find(|one| one["bound"] == "wheels.slip").unwrap();
    assert!(slip["exceeded"].as_u64().unwrap() > 0, "{slip}");
    assert!(summary["verdict"]["failed"].to_string().contains("wheels.slip exceeded"), "{}", summary["verdict"]);
}

#[test]
fn a_gyroscope_whose_bias_exceeds_its_bound_is_named_and_one_within_is_not() {
    let exceeded = |bias_deg_per_s: &str| {
        let changes = [
            ("bias_tolerance_deg_per_s = 0.1", bias_deg_per_s),
            ("noise_deg_per_s = 0.05", "noise_deg_per_s = 0.021, angle_floor_deg = 0.01, scale_tolerance = 0.0"),
            ("tolerance_deg = 0.05 }", "tolerance_deg = 0.01 }"),
        ];
        let summary = summary_of(&robot("wheels.toml", &changes), "disorderly");
        let bias = summary["bounds"].as_array().unwrap().iter().find(|one| one["bound"] == "gyro.bias").cloned();
        bias.unwrap()["exceeded"].as_u64().unwrap()
    };
    assert_eq!(exceeded("bias_tolerance_deg_per_s = 0.06"), 0);
    assert!(exceeded("bias_tolerance_deg_per_s = 0.02") > 0);
}

#[test]
fn the_disorder_of_real_logs_is_told_with_topic_and_time_and_the_boxes_hold_the_truth() {
    let replay = replayed(&robot("wheels.toml", &[]), "disorderly").unwrap();
    let summary = &replay.summary;
    assert_holds_the_truth(summary, 100);
    let topics = &summary["log"]["topics"];
    let dropped = |topic: &str, reason: &str| {
        let found = &topics[topic]["dropped_by_reason"][reason];
        assert!(found.is_object(), "{topic} has no `{reason}`: {:#}", topics[topic]);
        (found["count"].as_u64().unwrap(), found["first_s"].as_f64().unwrap())
    };
    // The times at which scripts/foreign_logs makes each disorder.
    let near = |(count, at_s): (u64, f64), counts: std::ops::RangeInclusive<u64>, about_s: f64| {
        assert!(counts.contains(&count) && (at_s - about_s).abs() < 0.02, "{count} at {at_s} s, expected {about_s} s");
    };
    near(dropped("/joint_states", "a number in it is not finite"), 1..=2, 3.0);
    near(dropped("/imu/data", "its stamp is false"), 4..=6, 6.0);
    near(dropped("/imu/data", "its frame is another one"), 1..=1, 7.0);
    near(dropped("/imu/data", "its stamp is that of another message"), 1..=1, 9.0);
    near(dropped("/ground_truth", "it does not decode"), 1..=1, 2.0);
    assert_eq!(topics["/joint_states"]["out_of_order"], 1);
    let gap = &topics["/imu/data"]["gaps_s"][0];
    assert!((gap[0].as_f64().unwrap() - 4.0).abs() < 0.02 && (gap[1].as_f64().unwrap() - 5.2).abs() < 0.02, "{gap}");
    let jump = &summary["log"]["jumps_of_wheels_s"][0];
    assert!((jump[0].as_f64().unwrap() - 8.0).abs() < 0.03, "{jump}");
    for part in ["no message from 3.9", "its frame is another one: `other_imu`", "a jump from 7.9"] {
        assert!(replay.text.contains(part), "`{part}` is missing in:\n{}", replay.text);
    }
}

#[test]
fn satellite_positions_narrow_the_boxes_and_bad_ones_are_dropped() {
    let with = summary_of(&robot("odometry.toml", &[]), "satellites");
    assert_holds_the_truth(&with, 50);
    let without =
        summary_of(&robot("odometry.toml", &[(r#"methods = ["gnss_positions"]"#, "methods = []")]), "satellites");
    let width_m = |summary: &Value| summary["width"]["x_m"]["max"].as_f64().unwrap();
    assert!(width_m(&with) < width_m(&without), "{} {}", width_m(&with), width_m(&without));
    let dropped = &with["log"]["topics"]["/fix"]["dropped_by_reason"];
    // Of the 31 positions in 6 s seven have no fix, each second one, and one has a standard deviation of 1 m.
    assert_eq!(dropped["it has no fix"]["count"], 7);
    assert_eq!(dropped["its covariance allows more than is declared"]["count"], 1);
    assert_eq!(with["methods"]["gnss_positions"]["constraints"], 23);
    let fixed = with["bounds"].as_array().unwrap().iter().find(|one| one["bound"] == "gnss.fixed").unwrap();
    assert_eq!((fixed["exceeded"].as_u64(), fixed["compared"].as_u64()), (Some(0), Some(23)), "{fixed}");
}

#[test]
fn scans_of_a_room_narrow_the_boxes_whatever_stands_in_it() {
    let scans = robot("scans.toml", &[]);
    let with = summary_of(&scans, "scans");
    assert_holds_the_truth(&with, 50);
    // Scans begin every 0.2 s up to 5.8 s; the first comes before the second reading of the wheels and is used with it.
    assert_eq!(with["methods"]["wall_ranges"]["constraints"], 30, "{}", with["methods"]);
    let without = summary_of(&robot("scans.toml", &[(r#"methods = ["wall_ranges"]"#, "methods = []")]), "scans");
    let width_m = |summary: &Value, axis: &str| summary["width"][axis]["max"].as_f64().unwrap();
    for axis in ["x_m", "y_m"] {
        assert!(width_m(&with, axis) < 0.5 * width_m(&without, axis), "{axis}: {} {}", with["width"], without["width"]);
    }
    // The leg of the table is on no map: most beams end at walls, and no share above that is right.
    let share = |wrong: f64| {
        robot("scans.toml", &[("[log]", &format!("[localizer.wall_ranges]\nwrong_share = {wrong}\n\n[log]"))])
    };
    assert_holds_the_truth(&summary_of(&share(0.2), "scans"), 50);
}

#[test]
fn a_scanner_that_measures_less_exactly_than_declared_is_named() {
    // The script's distances are off by up to 10 mm, evenly. True poses are known to 1 mm and 0.05°.
    let range = |tolerance_m: f64| {
        let declared = format!("tolerance_m = {tolerance_m}\nposition_tolerance_m = 0.0\nangle_tolerance_deg = 0.0");
        let exact = [
            ("tolerance_m = 0.011", declared.as_str()),
            ("[log]", "[localizer.wall_ranges]\nplacement_tolerance_m = 0.0\n[log]"),
        ];
        let replay = replayed(&robot("scans.toml", &exact), "scans").unwrap();
        let bounds = replay.summary["bounds"].as_array().unwrap();
        bounds.iter().find(|one| one["bound"] == "scanner.range").unwrap().clone()
    };
    for (tolerance_m, is_exceeded) in [(0.011, false), (0.004, true)] {
        let range = range(tolerance_m);
        println!("{range}");
        assert!(range["compared"].as_u64().unwrap() > 500, "{range}");
        assert_eq!(range["exceeded"].as_u64().unwrap() > 10, is_exceeded, "{range}");
        assert!((0.004..0.0101).contains(&range["at_least"].as_f64().unwrap()), "{range}");
    }
}

#[test]
fn filters_are_told_the_walls_of_logged_scans_and_what_their_distributions_are_worth() {
    let by = |subject: &str, changes: &[(&str, &str)]| {
        let choice: SubjectChoice = subject.parse().unwrap();
        replay_log(&robot("scans.toml", changes), &logs().join("scans"), &choice).unwrap()
    };
    for subject in ["ekf", "particles"] {
        let error_m = |replay: &LogReplay| replay.summary["error"]["position_m"]["mean"].as_f64().unwrap();
        let with = by(subject, &[]);
        let without = by(subject, &[(r#"methods = ["wall_ranges"]"#, "methods = []")]);
        assert!(error_m(&with) < error_m(&without), "{subject}: {} and {}", error_m(&with), error_m(&without));
        assert!(with.passed && with.text.contains("truth in its 95 % regions at"), "{}", with.text);
    }
}

#[test]
fn a_declared_start_that_does_not_hold_the_true_pose_is_named_whoever_localizes() {
    let elsewhere = robot("scans.toml", &[("start = { x_m = 1.0", "start = { x_m = 1.4")]);
    for subject in ["intervals", "ekf"] {
        let replay = replay_log(&elsewhere, &logs().join("scans"), &subject.parse().unwrap()).unwrap();
        assert!(!replay.passed, "{subject}");
        assert!(
            replay.text.contains("the declared start does not hold the true pose at 0 s: x_m is"),
            "{}",
            replay.text
        );
    }
}

#[test]
fn a_scan_whose_beams_are_measured_one_after_the_other_needs_a_stamp_tolerance_of_half_its_time() {
    let dropped = |summary: &Value| {
        summary["log"]["topics"]["/scan"]["dropped_by_reason"]["its beams are measured over a longer time than declared"]
            ["count"]
            .as_u64()
    };
    let instant = replayed(&robot("scans.toml", &[]), "scans_sweeping").unwrap();
    assert_eq!(dropped(&instant.summary), Some(20));
    assert!(instant.text.contains("its beams are measured over 0.0200 s"), "{}", instant.text);
    let sweeping = robot("scans.toml", &[("tolerance_m = 0.011", "tolerance_m = 0.011\nstamp_tolerance_s = 0.0101")]);
    let summary = summary_of(&sweeping, "scans_sweeping");
    assert_eq!((dropped(&summary), summary["methods"]["wall_ranges"]["constraints"].as_u64()), (None, Some(20)));
    assert_holds_the_truth(&summary, 30);
}

#[test]
fn a_position_half_a_metre_beside_what_its_covariance_allows_is_named_and_leaves_the_truth_in_the_boxes() {
    let replay = replayed(&robot("odometry.toml", &[]), "outlier").unwrap();
    assert_holds_the_truth(&replay.summary, 50);
    assert!(!replay.passed);
    let found = replay.summary["contradictions"].as_array().unwrap();
    let at_outlier = |one: &Value| {
        one["time_s"] == 4.4 && one["bounds"].as_array().unwrap().iter().any(|bound| bound == "gnss.fixed")
    };
    assert!(found.len() == 1 && at_outlier(&found[0]), "{found:?}");
    // The true poses tell it too: the noise of at most 10 mm comes on top of the 0.5 m.
    let fixed = replay.summary["bounds"].as_array().unwrap().iter().find(|one| one["bound"] == "gnss.fixed").unwrap();
    assert_eq!((fixed["exceeded"].as_u64(), fixed["from_s"].as_f64()), (Some(1), Some(4.4)), "{fixed}");
    let at_least_m = fixed["at_least"].as_f64().unwrap();
    assert!((0.485..0.515).contains(&at_least_m), "{at_least_m}");
}

#[test]
fn images_of_either_message_type_locate_the_robot_on_its_tiles() {
    let robot = robot("tiles.toml", &[]);
    for log in ["tiles_png", "tiles_rgb"] {
        let summary = summary_of(&robot, log);
        assert_holds_the_truth(&summary, 20);
        assert!(
            summary["methods"]["floor_tiles"]["constraints"].as_u64().unwrap() >= 4,
            "{log}: {}",
            summary["methods"]
        );
        assert_eq!(summary["verdict"]["failed"], Value::Array(Vec::new()), "{log}");
        let at_fix_m = summary["width"]["at_fix"]["x_m"]["mean"].as_f64().unwrap();
        assert!(at_fix_m < 0.02, "{log}: {at_fix_m} m wide after an image");
    }
}

#[test]
fn a_lens_that_is_not_the_declared_one_is_named_and_can_be_taken_from_the_log() {
    let wrong = ("footprint_width_m = 0.48", "footprint_width_m = 0.5");
    let summary = summary_of(&robot("tiles.toml", &[wrong]), "tiles_rgb");
    let failed = summary["verdict"]["failed"].to_string();
    // 320 px over 0.5 m from 0.25 m: 160 px instead of 166.67 px.
    assert!(failed.contains("floor_camera lens: focal_u_px is 166.666667 in the log, where 160.000000"), "{failed}");
    let taken = robot("tiles.toml", &[wrong, ("[log]\n", "[log]\nlens_from_camera_info = true\n")]);
    let summary = summary_of(&taken, "tiles_rgb");
    assert_holds_the_truth(&summary, 20);
    assert_eq!(summary["verdict"]["failed"], Value::Array(Vec::new()));
    let bare = summary_of(&robot("tiles.toml", &[]), "tiles_bare");
    let dropped = &bare["log"]["topics"]["/camera/image_raw"]["dropped_by_reason"]["its image is not read"];
    assert!(dropped["first"].as_str().unwrap().contains("`bayer_rggb8`"), "{dropped}");
    let other_size = summary_of(&robot("tiles.toml", &[("height_px = 240", "height_px = 200")]), "tiles_rgb");
    let dropped = &other_size["log"]["topics"]["/camera/image_raw"]["dropped_by_reason"]["its image is not read"];
    assert!(
        dropped["first"].as_str().unwrap().contains("320 × 240 pixels, where the floor_camera has 320 × 200"),
        "{dropped}"
    );
}

#[test]
fn without_truth_bounds_that_cannot_all_be_true_are_named() {
    // The wheels are taken to be 20 % farther apart than they are, so that wheels and gyroscope turn differently.
    let changes = [("track_m = 0.33", "track_m = 0.4"), ("truth = {", "# truth = {")];
    let replay = replayed(&robot("wheels.toml", &changes), "disorderly").unwrap();
    assert!(!replay.passed && replay.summary["containment"].is_null());
    let found = replay.summary["contradictions"].as_array().unwrap();
    assert!(!found.is_empty(), "{}", replay.text);
    let bounds: Vec<&str> =
        found.iter().flat_map(|one| one["bounds"].as_array().unwrap()).filter_map(Value::as_str).collect();
    assert!(bounds.iter().any(|bound| bound.starts_with("wheels.")), "{bounds:?}");
}

#[test]
fn an_unknown_start_is_the_whole_room_and_a_filter_may_take_the_localizers_place() {
    let robot = robot("odometry.toml", &[("[log]\n", "[log]\nstart_is_known = false\n")]);
    let summary = summary_of(&robot, "satellites");
    assert_holds_the_truth(&summary, 50);
    let filter: SubjectChoice = "ekf".parse().unwrap();
    let by_filter =
        replay_log(&self::robot("odometry.toml", &[]), &logs().join("satellites"), &filter).unwrap().summary;
    assert_eq!((by_filter["subject"].as_str(), by_filter["containment"].is_null()), (Some("ekf"), true));
    assert!(by_filter["error"]["position_m"]["mean"].as_f64().unwrap() < 0.05, "{}", by_filter["error"]);
}

#[test]
fn what_cannot_be_replayed_is_refused_with_file_key_and_what_was_expected() {
    let wheels = || robot("wheels.toml", &[]);
    let cases = [
        (
            robot(
                "wheels.toml",
                &[
                    ("[log]", "[[station]]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 0.0\n[expect]"),
                    ("truth = {", "# truth = {"),
                ],
            ),
            "wheels_mcap",
            "`log` is missing, expected a table `[log]`",
        ),
        (wheels(), "no_such_log", "no_such_log: "),
        (wheels(), "wheels.toml", "wheels.toml: it begins as none of these, expected an MCAP file"),
        (
            robot("wheels.toml", &[("[log]\n", "[log]\ntopics = { joints = \"/wheels\" }\n")]),
            "wheels_mcap",
            "is `/wheels`, which the log does not have, expected one of `/ground_truth`, `/imu/data`, `/joint_states`",
        ),
        (
            robot("wheels.toml", &[("[log]\n", "[log]\ntopics = { imu = \"/scan\" }\n")]),
            "wheels_mcap",
            "`log.topics.imu` of ",
        ),
        (
            robot("wheels.toml", &[("[log]\n", "[log]\njoints = { left = \"wheel_l\" }\n")]),
            "wheels_mcap",
            "151 times it has no position of the wheels' joints: `wheel_l` and `right_wheel_joint` are not among `camera_pan`",
        ),
        (
            robot(
                "tiles.toml",
                &[("[log]\n", "[log]\nlens_from_camera_info = true\ntopics = { floor_camera = \"/scan\" }\n")],
            ),
            "tiles_rgb",
            "which the log does not have",
        ),
        (
            robot("tiles.toml", &[("[log]\n", "[log]\nlens_from_camera_info = true\n")]),
            "tiles_bare",
            "no message of type sensor_msgs/CameraInfo tells the lens of the floor camera",
        ),
    ];
    for (robot, log, expected) in cases {
        let message = message_of(replayed(&robot, log));
        assert!(message.contains(expected), "`{expected}` is missing in: {message}");
    }
}

#[test]
fn true_poses_by_another_clock_and_broken_ones_are_refused() {
    let with_tum = |name: &str, text: &str| {
        let file = fs::read_to_string(logs().join("wheels.toml")).unwrap();
        let file = file.replace("topic = \"/ground_truth\"", "tum = \"truth.tum\"");
        let folder = folder_of(name, &[("robot.toml", &file), ("truth.tum", text)]);
        replayed(&SceneFile::load(&folder.join("robot.toml")).unwrap(), "wheels_mcap")
    };
    let message = message_of(with_tum("tum_clock", "0.0 1 1 0 0 0 0 1\n1.0 1 1 0 0 0 0 1\n"));
    assert!(message.contains("expected times of one clock"), "{message}");
    let message = message_of(with_tum("tum_short", "# time x y z qx qy qz qw\n0.0 1 1 0 0 0 1\n"));
    assert!(message.contains("truth.tum") && message.contains("line 2: 7 numbers, expected eight"), "{message}");
    // The first stamp of the logs; the robot stands at its start, so that later true poses are outside of the boxes.
    let standing: String =
        (0..=30).map(|step| format!("{:.1} 1 1 0 0 0 0 1\n", 1_780_000_000.2 + 0.1 * f64::from(step))).collect();
    let replay = with_tum("tum_standing", &standing).unwrap();
    assert!(!replay.passed && replay.summary["containment"]["outside"].as_u64().unwrap() > 10, "{}", replay.text);
    assert_eq!(replay.summary["containment"]["first_outside"]["axis"], "x_m");
}

#[test]
fn a_bag_that_is_not_closed_or_of_another_kind_is_told_or_refused() {
    let folder = folder("log_bags");
    let copied = |name: &str, description: Option<&str>| {
        let bag = folder.join(name);
        fs::create_dir_all(&bag).unwrap();
        fs::copy(logs().join("wheels_sqlite/wheels_sqlite.db3"), bag.join("wheels_sqlite.db3")).unwrap();
        if let Some(text) = description {
            fs::write(bag.join("metadata.yaml"), text).unwrap();
        }
        bag
    };
    let robot = robot("wheels.toml", &[]);
    let replay = |bag: &Path| replay_log(&robot, bag, &SubjectChoice::default());
    let open = replay(&copied("open", None)).unwrap();
    assert!(open.text.contains("damage: metadata.yaml is missing"), "{}", open.text);
    let described = fs::read_to_string(logs().join("wheels_sqlite/metadata.yaml")).unwrap();
    let other = described.replace("wheels_sqlite.db3", "other.db3");
    assert!(message_of(replay(&copied("other", Some(&other)))).contains("other.db3"));
    let unknown = described.replace("compression_format: ''", "compression_format: lz9");
    assert_ne!(unknown, described);
    let message = message_of(replay(&copied("unknown", Some(&unknown))));
    assert!(message.contains("`compression_format` is `lz9`, of which only `zstd` is read"), "{message}");
    // A bag that a recorder still writes to has its latest messages in a file beside it.
    let open = copied("writing", Some(&described));
    fs::write(open.join("wheels_sqlite.db3-wal"), [1]).unwrap();
    let message = message_of(replay(&open));
    assert!(message.contains("write-ahead log"), "{message}");
    let ros1 = folder.join("old.bag");
    fs::write(&ros1, "#ROSBAG V2.0\n").unwrap();
    let message = message_of(replay(&ros1));
    assert!(message.contains("a bag of ROS 1, which `rosbags-convert`"), "{message}");
}

/// Replays a damaged copy of a log's file, which may be refused or reported, but must not end the program.
fn replay_bytes(robot: &SceneFile, path: &Path, bytes: &[u8]) -> Option<LogReplay> {
    fs::write(path, bytes).unwrap();
    replay_log(robot, path, &SubjectChoice::default()).ok()
}

#[test]
fn a_file_that_is_cut_short_at_any_byte_is_refused_or_reported() {
    let robot = robot("wheels.toml", &[("gyro = {", "gyro = false #")]);
    let folder = folder("log_cut");
    for (name, ending, step) in [("tiny_mcap", "mcap", 23), ("tiny_sqlite", "db3", 59)] {
        let whole = fs::read(logs().join(name).join(format!("{name}.{ending}"))).unwrap();
        let path = folder.join(format!("cut.{ending}"));
        let (mut n_reported, mut n_refused) = (0, 0);
        for length in (0..whole.len()).step_by(step).chain(0..64) {
            match replay_bytes(&robot, &path, &whole[..length]) {
                Some(replay) if replay.text.contains("damage: ") => n_reported += 1,
                // What stands after the last message, such as an index, may be missing without harm.
                Some(replay) => assert_eq!(replay.summary["log"]["topics"]["/joint_states"]["messages"], 6, "{length}"),
                None => n_refused += 1,
            }
        }
        assert!(n_reported > 10 && n_refused > 10, "{name}: {n_reported} reported, {n_refused} refused");
    }
}

#[test]
fn a_byte_that_is_changed_anywhere_ends_no_program() {
    let robot = robot("wheels.toml", &[("gyro = {", "gyro = false #")]);
    let folder = folder("log_changed");
    for (name, ending, step) in [("tiny_mcap", "mcap", rounds(31, 11)), ("tiny_sqlite", "db3", rounds(121, 41))] {
        let whole = fs::read(logs().join(name).join(format!("{name}.{ending}"))).unwrap();
        let path = folder.join(format!("changed.{ending}"));
        // In the first pages of a database, and in the first records of an MCAP file, every byte matters.
        for place in (0..200).chain((200..whole.len()).step_by(step)) {
            for change in [0xff, 0x80] {
                let mut changed = whole.clone();
                changed[place] ^= change;
                replay_bytes(&robot, &path, &changed);
            }
        }
    }
}

#[test]
fn a_chunk_with_false_lengths_ends_no_program() {
    let robot = robot("wheels.toml", &[]);
    let path = folder("log_lengths").join("changed.mcap");
    for name in ["wheels_mcap", "wheels_mcap_chunk_zstd"] {
        let whole = fs::read(logs().join(name).join(format!("{name}.mcap"))).unwrap();
        // Behind the chunk's header stand the records' lengths, of eight bytes each: one of the first is replaced by the greatest number that there
        // is.
        for place in (0..400).chain((400..whole.len() - 8).step_by(rounds(2999, 251))) {
            let mut changed = whole.clone();
            changed[place..place + 8].fill(0xff);
            replay_bytes(&robot, &path, &changed);
        }
    }
}

#[test]
fn a_device_without_a_reading_in_the_log_is_told() {
    let robot = robot("tiles.toml", &[]);
    let replay = replayed(&robot, "wheels_mcap").unwrap_or_else(|error| panic!("failed to {error}"));
    assert_eq!(replay.summary["log"]["without_readings"], serde_json::json!(["floor_camera"]));
    assert!(
        replay.text.contains("`robot.floor_camera` is described, and the log has no reading of it"),
        "{}",
        replay.text
    );
}

#[test]
fn a_damaged_chunk_is_told_with_the_times_of_its_messages() {
    let folder = folder("log_chunk");
    let mut bytes = fs::read(logs().join("wheels_mcap_chunk_zstd/wheels_mcap_chunk_zstd.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0xff;
    let path = folder.join("damaged.mcap");
    fs::write(&path, bytes).unwrap();
    // The bag has one chunk, so that nothing is left of it; the message says why.
    let message = message_of(replay_log(&robot("wheels.toml", &[]), &path, &SubjectChoice::default()));
    assert!(message.contains("a chunk of messages that were logged from 1780000000.1"), "{message}");
}

#[test]
fn the_command_writes_a_folder_that_a_report_opens_and_ends_with_the_codes_it_promises() {
    let folder = folder("log_command");
    let (robot, log) = (logs().join("wheels.toml"), logs().join("wheels_mcap"));
    let (robot, log) = (robot.to_str().unwrap(), log.to_str().unwrap());
    let (code, text, stderr) = outcome(&mut wherein(&folder, &["replay", "--robot", robot, log, "--out", "out"]));
    assert_eq!(code, 0, "{stderr}{text}");
    assert!(text.contains("nothing speaks against what is declared"), "{text}");
    let first = fs::read(folder.join("out/wheels_mcap/summary.json")).unwrap();
    for file in ["boxes.csv", "estimate.tum", "truth.tum", "map.png", "timing.json"] {
        assert!(folder.join("out/wheels_mcap").join(file).is_file(), "{file}");
    }
    let (code, json, _) = outcome(&mut wherein(&folder, &["replay", "--robot", robot, log, "--out", "out", "--json"]));
    assert_eq!((code, json.as_bytes() == first), (0, true), "the same log gives the same bytes");
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["report", "out"]));
    assert_eq!(code, 0, "{stderr}");
    let page = fs::read_to_string(folder.join("out/report.html")).unwrap();
    for part in ["wheels_mcap", "/joint_states: ", "wheels.slip: kept", "replay --robot ", "<dt>outside</dt>"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("<dt>unsound</dt>"), "no cause is known for what is outside in a log");
    let filtered = ["replay", "--robot", robot, log, "--out", "filtered", "--subject", "ekf"];
    let (_, text, stderr) = outcome(&mut wherein(&folder, &filtered));
    assert!(text.contains("mean NEES "), "{stderr}{text}");
    let summary = fs::read_to_string(folder.join("filtered/wheels_mcap/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert!(summary["distribution"]["checks"].as_u64().unwrap() > 20 && summary["containment"].is_null(), "{summary}");
    assert!(summary["distribution"]["nees"]["mean"].as_f64().unwrap() < 30.0);
    // What a process wrote to its standard error is kept, so that its author sees why it failed.
    let broken = ["replay", "--robot", robot, log, "--out", "broken", "--subject", "echo 'no such device' >&2; exit 3"];
    let (code, text, stderr) = outcome(&mut wherein(&folder, &broken));
    assert_eq!(code, 1, "{stderr}{text}");
    assert_eq!(fs::read_to_string(folder.join("broken/wheels_mcap/subject.log")).unwrap(), "no such device\n");
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["replay", "--robot", robot, "none.mcap"]));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("failed to read log none.mcap"), "{stderr}");
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["replay", log]));
    assert_eq!(code, 2, "{stderr}");
}
