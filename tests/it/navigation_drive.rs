//! Tests of driving errands: control laws worked out by hand, wrong estimates, blocked paths, and what a run reports about its errands.

use std::f64::consts::{FRAC_PI_2, PI};

use interval::Interval;
use localizer::{Estimate, Pose, PoseUnion, Status};
use sim::{
    base::DriveCommand,
    devices::scanner::Fan,
    driver::{ErrandDriver, ErrandLog, Outcome, bearing},
    judge::{Verdict, distance_to_way_m},
    place::Bystander,
    run::{Clearance, RunOptions, RunRecord, run, sensors::Sensors},
    scene::Scene,
    subject::IntervalLocalizer,
    truth::Truth,
    world::{Drawn, World},
};

use crate::judging::verdict_of;
use crate::world_setup::{estimate, hold, nominal, scene};

/// A scene with the plain room of 8 × 6 m, the given goals as errands, and further keys.
fn errands(goals_m: &[[f64; 2]], more: serde_json::Value) -> Scene {
    let errands: Vec<_> = goals_m.iter().map(|at_m| serde_json::json!({ "x_m": at_m[0], "y_m": at_m[1] })).collect();
    let mut keys = serde_json::json!({ "errand": errands, "robot": { "floor_camera": null }, "duration_s": 60.0 });
    for (key, value) in more.as_object().into_iter().flatten() {
        keys[key] = value.clone();
    }
    keys["robot"]["floor_camera"] = serde_json::json!(false);
    scene(keys)
}

/// Drives the robot on its errands for `lasts_s`; `see` makes the estimate that the driver gets from the true state.
fn drive_by(scene: &Scene, lasts_s: f64, mut see: impl FnMut(&Truth, usize) -> Estimate) -> (Vec<Truth>, ErrandDriver) {
    let (mut world, mut driver) = (World::new(scene, &nominal(scene)), ErrandDriver::new(scene, &[]));
    let mut truths = vec![world.truth()];
    for step in 0..(lasts_s * 100.0) as usize {
        let command = driver.command(&see(&world.truth(), step), None, step as f64 * 0.01);
        truths.push(hold(&mut world, command, 0.01));
    }
    (truths, driver)
}

fn judged(scene: &Scene, seed: u64) -> (RunRecord, Verdict) {
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}

fn distance_m(truth: &Truth, place_m: [f64; 2]) -> f64 {
    (truth.pose.x_m - place_m[0]).hypot(truth.pose.y_m - place_m[1])
}

#[test]
fn the_bearing_is_that_of_the_papers_equations_in_every_quadrant() {
    let robot = |heading_rad: f64| Pose { x_m: 1.0, y_m: 1.0, heading_rad };
    let cases = [
        // Four cases: the goal is ahead of the robot; to its left, which requires a left turn by a right angle; to its right; behind it.
        (FRAC_PI_2, [1.0, 3.0], 0.0, 2.0),
        (FRAC_PI_2, [-1.0, 1.0], -FRAC_PI_2, 2.0),
        (FRAC_PI_2, [4.0, 1.0], FRAC_PI_2, 3.0),
        (FRAC_PI_2, [1.0, -3.0], PI, 4.0),
        // The goal lies straight behind the robot. The paper's arctangent of the quotient, without regard to the quadrant, would give a bearing of 0
        // here.
        (0.25 * PI, [-2.0, -2.0], PI, 3.0 * 2.0_f64.sqrt()),
        // In the last two cases the robot's heading is not wrapped to one turn: it has made two full turns and a bit, or one full turn back and a
        // bit.
        (4.0 * PI + 0.1, [2.0, 1.0], 0.1, 1.0),
        (-2.0 * PI - 0.1, [2.0, 1.0], -0.1, 1.0),
    ];
    for (heading_rad, place_m, off_rad, distance_m) in cases {
        let found = bearing(robot(heading_rad), place_m);
        let is_off = (found.off_rad - off_rad).abs() < 1e-12 || (off_rad == PI && (found.off_rad + PI).abs() < 1e-12);
        assert!(is_off && (found.distance_m - distance_m).abs() < 1e-12, "{found:?} of {place_m:?} at {heading_rad}");
    }
}

#[test]
fn both_followers_turn_to_the_goal_first_and_end_there() {
    for follower in ["turn_then_drive", "pure_pursuit"] {
        let goal_m = [1.5, 5.0];
        let scene = errands(&[goal_m], serde_json::json!({ "navigation": { "follower": follower } }));
        let (truths, driver) = drive_by(&scene, 25.0, |truth, _| estimate(truth));
        // The goal lies to the robot's left: before the robot drives, it turns in place, with its left wheel going backwards.
        let turning = &truths[100];
        assert!(turning.velocity[2] > 0.1 && distance_m(turning, [1.5, 3.0]) < 0.01, "{follower}: {turning:?}");
        assert!(distance_m(&truths[2500], goal_m) < 0.05, "{follower} ended at {:?}", truths[2500].pose);
        assert!(truths[2500].velocity.iter().all(|speed| speed.abs() < 1e-6));
        let log = driver.into_log(25.0);
        assert_eq!((log.errands[0].outcome, log.errands[0].plans), (Outcome::Reached, 1), "{follower}");
        let way_m = &log.legs[0].corners_m;
        let farthest_m =
            truths.iter().map(|truth| distance_to_way_m([truth.pose.x_m, truth.pose.y_m], way_m)).fold(0.0, f64::max);
        assert!(farthest_m < 0.05, "{follower} strayed by {farthest_m} m");
    }
}

#[test]
fn a_pause_is_kept_and_errands_are_done_in_order() {
    let mut scene = errands(&[[3.0, 3.0], [3.0, 4.5]], serde_json::json!({}));
    scene.errands[0].pause_s = 4.0;
    let (truths, driver) = drive_by(&scene, 40.0, |truth, _| estimate(truth));
    let log = driver.into_log(40.0);
    let [first, second] = log.errands.as_slice() else { panic!("{log:?}") };
    let arrived_s = first.ended_s.unwrap();
    assert!((second.began_s.unwrap() - arrived_s - 4.0).abs() < 0.03, "{log:?}");
    let at = |time_s: f64| &truths[(time_s * 100.0).round() as usize];
    assert!(distance_m(at(arrived_s + 0.5), [3.0, 3.0]) < 0.05 && distance_m(at(arrived_s + 3.5), [3.0, 3.0]) < 0.05);
    assert!(distance_m(&truths[4000], [3.0, 4.5]) < 0.05);
}

#[test]
fn the_driver_arrives_where_its_estimate_says_and_not_where_the_truth_is() {
    let goal_m = [5.0, 3.5];
    let scene = errands(&[goal_m], serde_json::json!({}));
    let (truths, driver) = drive_by(&scene, 30.0, |truth, _| {
        let mut seen = *truth;
        seen.pose.y_m += 0.4;
        estimate(&seen)
    });
    let log = driver.into_log(30.0);
    assert_eq!(log.errands[0].outcome, Outcome::Reached);
    // The robot believes that it is 0.4 m farther to the left than it is, so that it ends 0.4 m to the right of the goal.
    assert!(distance_m(&truths[3000], [goal_m[0], goal_m[1] - 0.4]) < 0.05, "{:?}", truths[3000].pose);
}

/// An estimate whose box has a given width and is centred on the truth.
fn wide(truth: &Truth, width_m: f64) -> Estimate {
    let seen = estimate(truth);
    let mut hull = seen.pose.hull();
    hull[0] = Interval::centred(truth.pose.x_m, 0.5 * width_m);
    hull[1] = Interval::centred(truth.pose.y_m, 0.5 * width_m);
    Estimate { pose: PoseUnion::single(hull), ..seen }
}

#[test]
fn a_wide_box_slows_the_robot_down_in_proportion() {
    let scene = errands(&[[6.5, 3.0]], serde_json::json!({ "navigation": { "speed_m_per_s": 0.4, "margin_m": 0.1 } }));
    let fastest = |width_m: f64| {
        let (truths, _) = drive_by(&scene, 10.0, |truth, _| wide(truth, width_m));
        truths.iter().map(|truth| truth.velocity[0]).fold(0.0, f64::max)
    };
    // Four widths of the estimated box and the speed that the robot may drive at each. Half of the box is at most the safety margin of 0.1 m: full
    // speed. Half of it is twice the margin: half speed. Half of it is four and a half times the margin: a quarter of the speed. It is very wide: the
    // robot stands.
    for (width_m, speed_m_per_s) in [(0.19, 0.4), (0.4, 0.2), (0.9, 0.1), (4.0, 0.0)] {
        assert!((fastest(width_m) - speed_m_per_s).abs() < 0.01, "{} m/s in a box of {width_m} m", fastest(width_m));
    }
}

#[test]
fn a_robot_in_doubt_stands_then_looks_around_and_goes_on_when_sure() {
    let scene = errands(&[[6.5, 3.0]], serde_json::json!({}));
    let (truths, driver) = drive_by(&scene, 40.0, |truth, step| {
        let status = if (500..1500).contains(&step) { Status::Recovering } else { Status::Sound };
        Estimate { status, ..estimate(truth) }
    });
    assert!(truths[500].velocity[0] > 0.3);
    let stood_m = distance_m(&truths[1500], [truths[700].pose.x_m, truths[700].pose.y_m]);
    assert!(truths[700].velocity.iter().all(|speed| speed.abs() < 1e-3) && stood_m < 0.01, "moved by {stood_m} m");
    let turned_rad = |from: usize, to: usize| truths[to].pose.heading_rad - truths[from].pose.heading_rad;
    assert!(turned_rad(700, 990).abs() < 1e-3 && turned_rad(1000, 1500) > 0.5, "turned by {}", turned_rad(1000, 1500));
    assert_eq!(driver.into_log(40.0).errands[0].outcome, Outcome::Reached);
}

#[test]
fn without_a_pose_the_driver_stands() {
    let scene = errands(&[[6.5, 3.0]], serde_json::json!({}));
    let mut driver = ErrandDriver::new(&scene, &[]);
    for step in 0..800 {
        let nowhere = Estimate { pose: PoseUnion::default(), ..estimate(&Truth::default()) };
        assert_eq!(driver.command(&nowhere, None, f64::from(step) * 0.01), DriveCommand::default());
    }
}

/// The scan that the driver is given after the sensors have observed the world, if one has arrived.
fn scan(sensors: &mut Sensors, truth: &Truth, people: &[Bystander]) -> Option<Fan> {
    sensors.observe(truth, people, None).unwrap();
    sensors.look_out()
}

#[test]
fn beams_end_where_geometry_says() {
    let keys = serde_json::json!({
        "robot": { "scanner": {
            "field_deg": 180.0, "beams": 3, "range_m": 4.0, "height_m": 0.3, "tolerance_m": 0.0,
            "position_tolerance_m": 0.0, "angle_tolerance_deg": 0.0,
        } },
        "furniture": [
            { "x_m": 3.5, "y_m": 3.0, "size_m": [1.0, 0.5] },
            { "x_m": 2.0, "y_m": 3.0, "size_m": [0.2, 0.5], "height_m": 0.2 },
        ],
    });
    let scene = errands(&[[6.5, 3.0]], keys);
    let mut sensors = Sensors::new(&scene, 0, &nominal(&scene), None);
    let truth = Truth { pose: Pose { x_m: 1.5, y_m: 3.0, heading_rad: 0.0 }, ..Truth::default() };
    let person = Bystander {
        place_m: [1.5, 4.2],
        radius_m: 0.25,
        height_m: 1.7,
        heading_rad: 0.0,
        walked_m: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    let fan = scan(&mut sensors, &truth, &[person]).unwrap();
    let found: Vec<(f64, Option<f64>)> = fan.beams.iter().map(|beam| (beam.bearing_rad, beam.distance_m)).collect();
    // Beams of the scanner: the one to the right ends at the wall at y = 0; the one ahead passes over the lower box and ends at the face of
    // the other box at x = 3; the one to the left ends at the person's front.
    for ((bearing_rad, distance_m), (at_rad, at_m)) in
        found.into_iter().zip([(-FRAC_PI_2, 3.0), (0.0, 1.5), (FRAC_PI_2, 0.95)])
    {
        assert!(
            (bearing_rad - at_rad).abs() < 1e-9 && (distance_m.unwrap() - at_m).abs() < 1e-9,
            "{bearing_rad}: {distance_m:?}"
        );
    }
    assert_eq!(scan(&mut sensors, &Truth { time_s: 0.02, ..truth }, &[]), None, "not due before 0.05 s");
    // The scanner's beam ahead points to the far wall, whose distance of 6.5 m is beyond the scanner's range, so that it reports no distance.
    let away = Truth { time_s: 0.05, pose: Pose { y_m: 4.0, ..truth.pose }, ..truth };
    assert_eq!(scan(&mut sensors, &away, &[]).unwrap().beams[1].distance_m, None);
}

#[test]
fn clearance_is_measured_from_the_bodys_edge() {
    let scene = errands(
        &[[6.5, 3.0]],
        serde_json::json!({ "furniture": [{ "x_m": 4.0, "y_m": 3.0, "size_m": [1.0, 1.0], "rotation_deg": 45 }] }),
    );
    let truth = Truth { pose: Pose { x_m: 2.0, y_m: 3.0, heading_rad: 1.0 }, ..Truth::default() };
    let person = Bystander {
        place_m: [2.0, 5.0],
        radius_m: 0.25,
        height_m: 1.7,
        heading_rad: 0.0,
        walked_m: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    let room = Clearance::of(&scene, &truth, &[person]);
    // The robot is 2 m from the centre of the piece of furniture, a square turned by 45° whose nearest corner is at x = 4 − √½; the robot's body
    // reaches 0.25 m from its own centre.
    assert!((room.walls_m - 1.75).abs() < 1e-12 && (room.people_m - 1.5).abs() < 1e-12, "{room:?}");
    assert!((room.furniture_m - (2.0 - 0.5_f64.sqrt() - 0.25)).abs() < 1e-12, "{room:?}");
    assert_eq!(room.least_m(), room.furniture_m);
}

/// A scene with a goal straight ahead, behind a box that the map does not show.
fn blocked(scanner: bool, room_depth_m: f64) -> Scene {
    let middle_m = 0.5 * room_depth_m;
    errands(
        &[[6.0, middle_m]],
        serde_json::json!({
            "room": { "width_m": 8.0, "depth_m": room_depth_m },
            "start": { "x_m": 1.5, "y_m": middle_m, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
            "robot": { "scanner": scanner },
            "navigation": { "give_up_s": 12.0 },
            "furniture": [{ "x_m": 3.6, "y_m": middle_m, "size_m": [0.4, 0.8], "mapped": false }],
        }),
    )
}

#[test]
fn a_box_off_the_map_is_waited_for_and_driven_round() {
    let (record, verdict) = judged(&blocked(true, 6.0), 61);
    let errand = &record.errands.as_ref().unwrap().errands[0];
    assert!(errand.outcome == Outcome::Reached && errand.detours >= 1, "{errand:?}");
    assert!(errand.waited_s >= 2.9, "waited {} s of the 3 that it should", errand.waited_s);
    assert_eq!((verdict.metrics["collisions"], verdict.metrics["goals_reached"]), (0.0, 1.0));
    assert!(verdict.metrics["clearance_furniture_least_m"] > 0.02, "{:?}", verdict.metrics);
    assert!(record.truths.last().unwrap().time_s < 59.0, "the run ends with its errands");
}

/// Drives errands with true poses as estimates and the scans of the scanner. Returns the errands' log and
/// the least clearance of the robot.
pub(crate) fn drive_looking_out(scene: &Scene, seed: u64) -> (ErrandLog, f64) {
    let drawn = nominal(scene);
    let (mut world, mut driver) = (World::new(scene, &drawn), ErrandDriver::new(scene, &[]));
    let mut sensors = Sensors::new(scene, seed, &drawn, None);
    let (mut least_m, mut time_s) = (f64::INFINITY, 0.0);
    for step in 0..(scene.duration_s * 100.0) as usize {
        time_s = step as f64 * 0.01;
        if driver.is_done(time_s) {
            break;
        }
        let fan = scan(&mut sensors, &world.truth(), &world.people());
        let command = driver.command(&estimate(&world.truth()), fan.as_ref(), time_s);
        let truth = hold(&mut world, command, 0.01);
        least_m = least_m.min(Clearance::of(scene, &truth, &world.people()).least_m());
    }
    (driver.into_log(time_s), least_m)
}

#[test]
fn a_way_that_stays_blocked_is_given_up_in_time() {
    // Only 0.3 m are left between the box and the wall, too little for the robot to pass, so that the goal cannot be reached.
    let mut scene = blocked(true, 1.4);
    scene.duration_s = 150.0;
    let (log, least_m) = drive_looking_out(&scene, 62);
    let errand = &log.errands[0];
    assert_eq!(errand.outcome, Outcome::Blocked, "{errand:?}");
    assert!((12.0..12.1).contains(&errand.waited_s), "{errand:?}");
    assert!(errand.ended_s.unwrap() < 100.0 && least_m > 0.02, "{errand:?}, {least_m} m");
}

#[test]
fn without_a_scanner_a_box_off_the_map_is_run_into_and_counted() {
    let (_, verdict) = judged(&blocked(false, 6.0), 63);
    assert!(verdict.metrics["collisions"] >= 1.0, "{:?}", verdict.metrics);
    assert!(verdict.metrics["clearance_furniture_least_m"] <= 0.002);
}

#[test]
fn nobody_is_run_into_and_nobody_waits_for_ever() {
    // Three walks of a person that the robot must not run into: across its path, along the path towards the robot, and standing in the path.
    for (seed, walk) in
        [[[4.0, 1.0], [4.0, 5.0]], [[6.5, 3.0], [1.5, 3.0]], [[4.0, 3.0], [4.0, 3.0]]].into_iter().enumerate()
    {
        let scene = errands(
            &[[6.5, 3.0], [1.5, 3.1]],
            serde_json::json!({ "robot": { "scanner": true }, "person": [{ "waypoints_m": walk }], "duration_s": 180.0 }),
        );
        let (log, least_m) = drive_looking_out(&scene, seed as u64);
        assert!(log.errands.iter().all(|errand| errand.outcome == Outcome::Reached), "{walk:?} {log:?}");
        assert!(least_m > 0.03, "{least_m} m, {walk:?}");
    }
}

#[test]
fn a_robot_makes_way_for_somebody_who_waits_for_it() {
    // In a room only 1.4 m deep nobody can pass. A person comes towards the robot and turns back only at x = 3, so that the robot has to make way.
    let keys = serde_json::json!({
        "room": { "width_m": 8.0, "depth_m": 1.4 },
        "start": { "x_m": 2.2, "y_m": 0.7, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
        "robot": { "scanner": true },
        "person": [{ "waypoints_m": [[4.4, 0.7], [3.0, 0.7], [7.5, 0.7]], "speed_m_per_s": 0.4 }],
        "duration_s": 180.0,
    });
    let (log, least_m) = drive_looking_out(&errands(&[[3.6, 0.7]], keys), 66);
    assert!(log.errands[0].outcome == Outcome::Reached && least_m > 0.03, "{log:?}, {least_m} m");
}

#[test]
fn random_goals_follow_the_seed_and_can_be_reached() {
    let keys = |n: usize| {
        serde_json::json!({
            "navigation": { "random_goals": n },
            "furniture": [{ "x_m": 5.0, "y_m": 3.0, "size_m": [0.1, 6.0] }],
        })
    };
    let scene = errands(&[], keys(40));
    let goals_m = Drawn::draw(&scene, 7).goals_m;
    assert_eq!(goals_m.len(), 40);
    assert_eq!(goals_m, Drawn::draw(&scene, 7).goals_m);
    assert_ne!(goals_m, Drawn::draw(&scene, 8).goals_m);
    // Goals must be within reach: none lies behind the wall at x = 5, or nearer to that wall than the body's radius and the planner's safety margin.
    for pair in goals_m.windows(2) {
        assert!(pair[1][0] < 4.95 - 0.33 && pair[1][0] > 0.33, "{pair:?}");
        assert!((pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]) >= 1.0, "{pair:?}");
    }
    let spread = |axis: usize| {
        goals_m.iter().map(|at| at[axis]).fold(0.0, f64::max) - goals_m.iter().map(|at| at[axis]).fold(9.0, f64::min)
    };
    assert!(spread(0) > 3.0 && spread(1) > 4.0, "{goals_m:?}");
    let (record, verdict) = judged(&errands(&[[3.0, 2.0]], keys(2)), 9);
    assert_eq!(record.errands.as_ref().unwrap().errands.len(), 3);
    assert_eq!(verdict.metrics["errands"], 3.0);
}

#[test]
fn the_same_seed_drives_the_same_errands() {
    let drive = || {
        let (record, _) = judged(&blocked(true, 6.0), 64);
        (record.readings_digest.clone(), format!("{:?}", record.errands), format!("{:?}", record.truths.last()))
    };
    assert_eq!(drive(), drive());
}

#[test]
fn arrivals_are_held_against_the_truth() {
    let (mut record, verdict) = judged(&errands(&[[3.0, 3.0]], serde_json::json!({})), 65);
    assert_eq!(verdict.metrics["arrivals_off"], 0.0, "{:?}", verdict.metrics);
    let scene = errands(&[[3.0, 3.0]], serde_json::json!({}));
    // The true poses of the record are moved by half a metre, as though the robot's estimate had been wrong by that much when the robot stopped at
    // its goal.
    for truth in &mut record.truths {
        truth.pose.y_m += 0.5;
    }
    let verdict = verdict_of(&scene, &record);
    assert_eq!(verdict.metrics["arrivals_off"], 1.0);
    assert!((verdict.metrics["arrival_error_greatest_m"] - 0.5).abs() < 0.05, "{:?}", verdict.metrics);
    assert!((verdict.metrics["path_deviation_p95_m"] - 0.5).abs() < 0.05, "{:?}", verdict.metrics);
}

#[test]
fn the_distance_from_a_way_is_that_of_its_nearest_piece() {
    let way_m = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
    for (place_m, distance_m) in
        [([1.0, 0.3], 0.3), ([-3.0, -4.0], 5.0), ([2.5, 0.5], 0.5), ([2.0, 3.0], 2.0), ([1.8, 0.4], 0.2)]
    {
        assert!((distance_to_way_m(place_m, &way_m) - distance_m).abs() < 1e-12, "{place_m:?}");
    }
}
