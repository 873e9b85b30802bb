use super::*;

/// A `geometry_msgs/PoseStamped` at this stamp, with the frame `f` and the pose (0, 0, 0), in CDR by hand.
fn pose_message(stamp_s: i32) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend(stamp_s.to_le_bytes());
    bytes.extend([0, 0, 0, 0, 2, 0, 0, 0, b'f', 0, 0, 0]);
    let numbers = [0.0_f64, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

/// What is gathered of poses with these stamps and times of logging, in seconds.
fn gathered(times_s: &[(i32, i64)]) -> Gathered {
    let keys = Log { clock_tolerance_s: 1.5, ..Log::default() };
    let mut gathered = Gathered::default();
    for (stamp_s, logged_s) in times_s {
        let (data, logged_ns) = (pose_message(*stamp_s), logged_s * 1_000_000_000);
        let kind = "geometry_msgs/PoseStamped";
        let message = RawMessage { topic: "/t", kind, encoding: "cdr", logged_ns, data: &data };
        if !gathered.take(message, Role::Truth, &Manner { keys: &keys, receiver: None, scanner: None }) {
            break;
        }
    }
    gathered.check_stamps(&BTreeMap::from([("/t".to_owned(), Role::Truth)]), &keys);
    gathered
}

fn stamps_s(gathered: &Gathered) -> Vec<i64> {
    gathered.truth.iter().map(|one| one.stamp_ns / 1_000_000_000).collect()
}

#[test]
fn where_the_time_of_logging_goes_back_the_log_ends() {
    let gathered = gathered(&[(1, 101), (2, 102), (3, 103), (4, 99), (5, 100)]);
    assert_eq!(stamps_s(&gathered), [1, 2, 3]);
    let set_back = SetBack { topic: "/t".to_owned(), logged_ns: 103_000_000_000, by_s: 4.0 };
    assert_eq!(gathered.set_back, Some(set_back));
}

#[test]
fn a_file_may_hold_one_topic_after_the_other() {
    let keys = Log::default();
    let mut gathered = Gathered::default();
    for topic in ["/one", "/two"] {
        for at_s in 1..=9_i64 {
            let (data, logged_ns, kind) =
                (pose_message(at_s as i32), at_s * 1_000_000_000, "geometry_msgs/PoseStamped");
            let message = RawMessage { topic, kind, encoding: "cdr", logged_ns, data: &data };
            assert!(
                gathered.take(message, Role::Truth, &Manner { keys: &keys, receiver: None, scanner: None }),
                "{topic} {at_s}"
            );
        }
    }
    assert_eq!((gathered.truth.len(), gathered.set_back), (18, None));
}

#[test]
fn another_clock_is_no_false_stamp_but_one_that_jumps_is() {
    // The clock of the stamps is 100 s behind; one stamp is 50 s off, and one message came late but in time.
    let gathered = gathered(&[(1, 101), (52, 102), (4, 104), (3, 104), (5, 105)]);
    assert_eq!(stamps_s(&gathered), [1, 3, 4, 5]);
    let topic = &gathered.topics["/t"];
    assert_eq!((topic.n_messages, topic.account.n_dropped(), topic.n_out_of_order), (5, 1, 1));
    assert_eq!(topic.account.dropped["its stamp is false"].logged_ns, [102_000_000_000; 2]);
}

#[test]
fn stamps_that_stay_off_are_by_a_clock_that_was_set() {
    let times_s = |before: i32, after: i32| -> Vec<(i32, i64)> {
        (0..12).map(|at| (at + if at < 5 { before } else { after }, i64::from(at) + 100)).collect()
    };
    let step = |times_s: &[(i32, i64)]| gathered(times_s).topics["/t"].clock_step.clone();
    let set = |by_s: f64| Some(ClockStep { logged_ns: 105_000_000_000, by_s: Some(by_s) });
    // Set forward by a minute or back by 9 s, with most messages after the step, whose clock then counts as the usual one.
    assert_eq!((step(&times_s(0, 60)), step(&times_s(9, 0))), (set(60.0), set(-9.0)));
    // With most messages before the step.
    let late: Vec<(i32, i64)> = (0..12).map(|at| (at + if at < 9 { 0 } else { 60 }, i64::from(at) + 100)).collect();
    assert_eq!(step(&late), Some(ClockStep { logged_ns: 109_000_000_000, by_s: Some(60.0) }));
    // A single false stamp is none, nor are two that are off by different times, nor one clock throughout.
    let mut single = times_s(0, 0);
    (single[3].0, single[7].0, single[8].0) = (70, 40, 90);
    assert_eq!((step(&single), step(&times_s(7, 7))), (None, None));
    // A clock that stands from the sixth message on, one that stands throughout, and one that goes twice as fast: stamps and times of logging differ by
    // ever more, and only about the usual difference, which is the median, are they near it.
    let stands = |from: i32| (0..24).map(|at| (at.min(from), i64::from(at) + 100)).collect::<Vec<_>>();
    let fast: Vec<(i32, i64)> = (0..24).map(|at| (2 * at, i64::from(at) + 100)).collect();
    for times_s in [stands(15), stands(0), fast] {
        assert_eq!(step(&times_s).map(|found| found.by_s), Some(None), "{times_s:?}");
    }
}

#[test]
fn a_position_whose_covariance_allows_more_than_is_declared_is_none() {
    let datum = Datum { latitude_deg: 45.0, longitude_deg: 9.0, altitude_m: 0.0, x_axis_deg: 0.0, sigmas: 3.0 };
    let receiver = Gnss { fixed_tolerance_m: 0.03, floating_tolerance_m: 0.6, ..Gnss::default() };
    let of = |status: i8, deviation_m: f64| {
        let mut covariance_m2 = [0.0; 9];
        covariance_m2[4] = deviation_m * deviation_m;
        let (latitude_deg, longitude_deg) = (45.0, 9.0);
        let covariance_m2 = Some(covariance_m2);
        messages::SatelliteFix { status, latitude_deg, longitude_deg, altitude_m: 0.0, covariance_m2 }
    };
    let is_used = |status, deviation_m| position(&of(status, deviation_m), &datum, &receiver).is_ok();
    assert!(is_used(2, 0.0099) && !is_used(2, 0.0101) && is_used(0, 0.0101) && !is_used(0, 0.21) && !is_used(-1, 0.0));
    assert!(!is_used(2, f64::NAN));
    // The east counts as the north does.
    let mut to_the_east = of(2, 0.0);
    to_the_east.covariance_m2 = Some([0.0101 * 0.0101, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(position(&to_the_east, &datum, &receiver).is_err());
}

#[test]
fn only_corrections_from_the_ground_make_a_fixed_position() {
    let datum = Datum { latitude_deg: 45.0, longitude_deg: 9.0, altitude_m: 0.0, x_axis_deg: 0.0, sigmas: 0.0 };
    let (latitude_deg, longitude_deg, altitude_m, covariance_m2) = (45.0, 9.0, 0.0, None);
    let is_fixed = |status| {
        let fix = messages::SatelliteFix { status, latitude_deg, longitude_deg, altitude_m, covariance_m2 };
        position(&fix, &datum, &Gnss::default()).map(|position| position.is_fixed)
    };
    assert_eq!([0, 1, 2].map(is_fixed), [Ok(false), Ok(false), Ok(true)]);
}

#[test]
fn a_turn_rate_about_an_axis_that_points_down_is_negative() {
    let axes = [UpAxis::X, UpAxis::Y, UpAxis::Z, UpAxis::MinusX, UpAxis::MinusY, UpAxis::MinusZ];
    let rates = axes.map(|up| about_vertical([1.0, 2.0, 3.0], up));
    assert_eq!(rates, [1.0, 2.0, 3.0, -1.0, -2.0, -3.0]);
}

#[test]
fn a_scan_whose_least_and_greatest_range_hold_no_distance_is_dropped_and_one_without_a_greatest_is_not() {
    let of = |between_m: [f64; 2]| {
        let scan =
            messages::LaserScan { first_rad: 0.0, step_rad: 0.1, step_s: 0.0, between_m, distances_m: vec![1.0, 20.0] };
        scan_of(scan, 0.0, &Scanner::default()).map(|scan| scan.distances_m)
    };
    assert_eq!(of([0.1, 10.0]), Ok(vec![Some(1.0), None]));
    assert_eq!(of([0.0, f64::INFINITY]), Ok(vec![Some(1.0), Some(20.0)]));
    for between_m in [[0.1, f64::NAN], [f64::NAN, 10.0], [10.0, 0.1], [0.0, 0.0]] {
        let Err((reason, detail)) = of(between_m) else { panic!("{between_m:?} is read") };
        assert_eq!(reason, "its least and greatest range hold no distance");
        assert!(detail.contains("`range_max`"), "{detail}");
    }
    let in_one_direction = messages::LaserScan {
        first_rad: 0.0,
        step_rad: 0.0,
        step_s: 0.0,
        between_m: [0.1, 10.0],
        distances_m: vec![1.0, 2.0],
    };
    let Err((reason, detail)) = scan_of(in_one_direction, 0.0, &Scanner::default()) else {
        panic!("beams in one direction are read")
    };
    assert!(reason.contains("one direction") && detail.contains("`angle_increment` is 0"), "{reason}: {detail}");
}
