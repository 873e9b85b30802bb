//! Tests of the satellite navigation receiver: its positions against geometry worked out by hand, and drives that use them and keep the
//! truth.

use interval::Interval;
use localizer::{
    Method, Pose, PoseBox, PoseUnion, Reading, Status, bounds,
    method::{Context, Window},
    methods::gnss_positions::{GnssPositions, Position},
    robot::RobotModel,
};
use nalgebra::{Rotation2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim::{
    devices::{
        Sensor,
        gnss::{DrawnGnss, GnssSensor},
    },
    judge::{AxisWidth, FixWidth, Verdict, post_steps},
    loading::SceneFile,
    run::{RunOptions, RunRecord, run},
    scene::{Distribution, Gnss, Reception, Scene, Station},
    subject::IntervalLocalizer,
    truth::Truth,
};

use crate::{
    command::{folder, outcome, root, scene_text, wherein},
    judging::verdict_of,
};

fn yard() -> Scene {
    SceneFile::load_all(&[root().join("scenes/gnss.toml")]).unwrap().remove(0).scene
}

fn judged(scene: &Scene, seed: u64) -> (RunRecord, Verdict) {
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}

/// Positions that the receiver of the yard scene reports on a robot that stands at a pose for a given time, each with its time.
fn positions(scene: &Scene, truth: Truth, lasts_s: f64) -> Vec<(f64, Position)> {
    let mount = DrawnGnss { position_m: [-0.15, 0.1] };
    let mut sensor = GnssSensor::new(scene.robot.gnss.as_ref().unwrap(), &mount, scene, 3);
    let steps = (0..=(lasts_s * 1000.0) as usize).map(|step| step as f64 * 0.001);
    steps
        .filter_map(|time_s| {
            let observed = sensor.observe(&Truth { time_s, ..truth }, &[])?;
            let Reading::Other { device, numbers, .. } = observed.reading else { panic!() };
            assert_eq!(device, "gnss");
            Some((time_s, Position::of(&numbers).unwrap()))
        })
        .collect()
}

#[test]
fn a_position_is_that_of_the_antenna_turned_with_the_robot_and_tipped_with_it() {
    let mut scene = yard();
    scene.robot.gnss.as_mut().unwrap().fixed_tolerance_m = 0.0;
    // The antenna is 0.15 m behind and 0.1 m left of the robot's origin. At a heading of 90°, back is −y and left is −x. When the robot is rolled to
    // the right by 0.1 rad, an antenna 0.6 m up moves to the right.
    let pose = Pose { x_m: 3.0, y_m: 2.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    let level = positions(&scene, Truth { pose, ..Truth::default() }, 1.0);
    assert_eq!(level.len(), 10);
    for (_, told) in level {
        assert!((told.at_m[0] - 2.9).abs() < 1e-12 && (told.at_m[1] - 1.85).abs() < 1e-12 && told.is_fixed, "{told:?}");
    }
    let tipped = positions(&scene, Truth { pose, tilt_rad: [0.1, 0.0], ..Truth::default() }, 0.1)[0].1;
    let right_m = 0.6 * 0.1_f64.sin() + 0.1 * (1.0 - 0.1_f64.cos());
    assert!((tipped.at_m[0] - (2.9 + right_m)).abs() < 1e-12, "{tipped:?}");
}

#[test]
fn errors_keep_to_what_their_grade_allows_and_reach_it_at_corners() {
    let mut scene = yard();
    let open = Truth { pose: Pose { x_m: 3.0, y_m: 2.0, heading_rad: 0.0 }, ..Truth::default() };
    let trees = Truth { pose: Pose { x_m: 3.0, y_m: 6.0, heading_rad: 0.0 }, ..Truth::default() };
    for errors in [Distribution::Uniform, Distribution::Corner, Distribution::Drift] {
        scene.robot.errors = errors;
        for (truth, tolerance_m, is_fixed) in [(open, 0.01, true), (trees, 0.5, false)] {
            let told = positions(&scene, truth, 39.0);
            let off_m = told.iter().flat_map(|(_, told)| {
                assert_eq!(told.is_fixed, is_fixed);
                [told.at_m[0] - (truth.pose.x_m - 0.15), told.at_m[1] - (truth.pose.y_m + 0.1)].map(f64::abs)
            });
            let most_m = off_m.fold(0.0, f64::max);
            assert!(most_m <= tolerance_m + 1e-12 && most_m > 0.5 * tolerance_m, "{errors:?}: {most_m}");
            assert!(errors == Distribution::Uniform || most_m > tolerance_m - 1e-9, "{errors:?}: {most_m}");
        }
    }
}

#[test]
fn the_worst_of_time_and_place_says_what_is_received() {
    let mut scene = yard();
    let at = |x_m: f64, y_m: f64| Truth { pose: Pose { x_m, y_m, heading_rad: 0.0 }, ..Truth::default() };
    assert!(positions(&scene, at(10.0, 2.0), 5.0).is_empty(), "in the barn");
    let told = positions(&scene, at(3.0, 2.0), 50.0);
    assert!(told.iter().all(|(time_s, told)| told.is_fixed && !(40.0..46.0).contains(time_s)));
    assert!(told.iter().any(|(time_s, _)| *time_s > 46.0) && told.len() > 400);
    scene.robot.gnss.as_mut().unwrap().outages[0].leaves = Reception::Floating;
    assert!(positions(&scene, at(10.0, 2.0), 45.0).is_empty(), "floating by time, nothing by place");
    let told = positions(&scene, at(3.0, 2.0), 50.0);
    assert!(told.iter().all(|(time_s, told)| told.is_fixed != (40.0..46.0).contains(time_s)));
}

/// The localization method for positions of a satellite navigation receiver on the scene's robot, and the model of that robot, whose body may lean by
/// up to half a degree.
fn method(scene: &Scene) -> (GnssPositions, RobotModel) {
    let robot = scene.robot_model();
    let receiver = localizer::methods::gnss_positions::ReceiverModel {
        position_m: [Interval::centred(-0.15, 0.001), Interval::centred(0.1, 0.001)],
        height_m: 0.6,
        fixed_m: 0.01,
        floating_m: 0.5,
        stamp_error_s: 0.002,
    };
    (GnssPositions::new(receiver, &robot), robot)
}

#[test]
fn floating_positions_within_five_seconds_of_each_other_end_no_doubt_together() {
    let (mut method, _) = method(&yard());
    let prior = PoseUnion::single(PoseBox::from([Interval::new(0.0, 12.0), Interval::new(0.0, 8.0), Interval::ZERO]));
    let mut decides = |stamp_s: f64, is_fixed: bool| {
        let reading = at_stamp(stamp_s, Position { at_m: [6.0, 4.0], is_fixed });
        method.constrain(&reading, &Context::at_rest(&prior)).unwrap().decides
    };
    assert!(decides(0.0, false) && !decides(0.1, false) && !decides(4.9, false) && decides(5.1, false));
    assert!(!decides(5.2, false) && decides(5.3, true) && decides(5.4, true) && !decides(9.9, false));
}

#[test]
fn no_pose_that_keeps_every_bound_is_lost() {
    let mut scene = yard();
    scene.bounds.body_tilt_deg = 5.0;
    let (fresh, robot) = method(&scene);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut n_narrower = 0;
    for _ in 0..20_000 {
        // The antenna's place on the robot and the reported position are off within their bounds; each error is at a corner of its bound
        // every other time.
        let mut within = |most: f64| {
            if rng.random() { most * [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-most..=most) }
        };
        let heading_rad = within(10.0);
        let pose = Pose { x_m: 6.0 + within(3.0), y_m: 4.0 + within(3.0), heading_rad };
        let (lean_rad, toward_rad) = (within(robot.body.tilt_rad), within(std::f64::consts::PI));
        let truth =
            Truth { pose, tilt_rad: [lean_rad * toward_rad.cos(), lean_rad * toward_rad.sin()], ..Truth::default() };
        // The reported position was measured up to 2 ms after its time stamp. Within these the robot has moved as far as its limits of speed and turn
        // rate allow.
        let late_s = 0.002;
        let moved = Truth {
            pose: Pose {
                x_m: pose.x_m + late_s * robot.reach.speed_m_per_s * toward_rad.cos(),
                y_m: pose.y_m + late_s * robot.reach.speed_m_per_s * toward_rad.sin(),
                heading_rad: heading_rad + late_s * robot.reach.turn_rate_rad_per_s * within(1.0),
            },
            ..truth
        };
        let place = nalgebra::Point3::new(-0.15 + within(0.001), 0.1 + within(0.001), 0.6);
        let antenna = moved.world_from_body() * place;
        let is_fixed = within(1.0) > 0.0;
        let tolerance_m = if is_fixed { 0.01 } else { 0.5 };
        let told = Position { at_m: [antenna.x + within(tolerance_m), antenna.y + within(tolerance_m)], is_fixed };
        let mut method = fresh.clone();
        let reading = at_stamp(0.0, told);
        let prior = PoseBox::from([
            Interval::centred(pose.x_m + within(0.5), 0.501),
            Interval::centred(pose.y_m + within(0.5), 0.501),
            Interval::centred(heading_rad + within(0.3), 0.301),
        ]);
        let constraint = method.constrain(&reading, &Context::at_rest(&PoseUnion::single(prior))).unwrap();
        let grade = if is_fixed { bounds::GNSS_FIXED } else { bounds::GNSS_FLOATING };
        assert!(constraint.relies_on.contains(&grade) && constraint.relies_on.contains(&bounds::BODY_TILT));
        let mut domain = prior;
        constraint.on_pose.contract(&mut domain);
        assert!(domain.contains(&pose.to_array()), "{pose:?} {told:?} {domain:?}");
        n_narrower += usize::from(domain.width(0) < 0.5 * prior.width(0));
    }
    assert!(n_narrower > 5_000, "{n_narrower}");
}

/// Satellite navigation reading of a position with a given stamp.
fn at_stamp(measured_s: f64, told: Position) -> Reading {
    Reading::Other { measured_s, arrived_s: measured_s, device: "gnss".to_owned(), numbers: told.numbers() }
}

#[test]
fn positions_held_and_carried_by_the_motion_since_tell_the_heading_and_lose_no_truth() {
    let scene = yard();
    let (fresh, _) = method(&scene);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..2_000 {
        let mut method = fresh.clone();
        let mut pose = Pose { x_m: 5.0, y_m: 4.0, heading_rad: rng.random_range(-3.0..3.0) };
        // The drive is made up by hand: each step turns the robot and then moves it straight on. The method is given each motion to within
        // 0.003 m and 0.003 rad.
        let steps: Vec<[f64; 2]> = (0..4).map(|_| [rng.random_range(-0.5..0.5), rng.random_range(0.2..0.6)]).collect();
        let mut poses = vec![pose];
        for [turn_rad, way_m] in &steps {
            let heading_rad = pose.heading_rad + turn_rad;
            let (sin, cos) = heading_rad.sin_cos();
            pose = Pose { x_m: pose.x_m + way_m * cos, y_m: pose.y_m + way_m * sin, heading_rad };
            poses.push(pose);
        }
        let motion = |from_s: f64, to_s: f64| {
            let (from, to) = (poses[from_s.round() as usize], poses[to_s.round() as usize]);
            let way = Rotation2::new(-from.heading_rad) * Vector2::new(to.x_m - from.x_m, to.y_m - from.y_m);
            let turn_rad = to.heading_rad - from.heading_rad;
            Some(PoseBox::from([way.x, way.y, turn_rad].map(|value| Interval::centred(value, 0.003))))
        };
        let mut width_rad = Vec::new();
        let mut window = Window::new(method.n_earlier());
        for (index, pose) in poses.iter().enumerate() {
            let lever = Rotation2::new(pose.heading_rad) * Vector2::new(-0.15, 0.1);
            let mut off_m = || 0.01 * [-1.0, 1.0][rng.random_range(0..2)];
            let told = Position { at_m: [pose.x_m + lever.x + off_m(), pose.y_m + lever.y + off_m()], is_fixed: true };
            let prior = PoseBox::from([
                Interval::centred(pose.x_m, 1.0),
                Interval::centred(pose.y_m, 1.0),
                Interval::centred(pose.heading_rad + 0.2, 0.5),
            ]);
            let reading = at_stamp(index as f64, told);
            let prior_union = PoseUnion::single(prior);
            let earlier = window.carried_to(index as f64, &motion);
            let context = Context { motion: &motion, earlier: &earlier, ..Context::at_rest(&prior_union) };
            let constraint = method.constrain(&reading, &context).unwrap();
            window.hold(index as f64, constraint.shown.unwrap());
            let mut domain = prior;
            constraint.on_pose.contract(&mut domain);
            assert!(domain.contains(&pose.to_array()), "{index}: {pose:?} {domain:?}");
            width_rad.push(domain.width(2));
        }
        // The heading is found from positions about a metre apart. It cannot be narrower than errors of four centimetres in position at most and the
        // effect of the lean allow over that distance.
        assert!(width_rad[4] < 0.25 && width_rad[4] < 0.5 * width_rad[0], "{width_rad:?}");
    }
}

#[test]
fn numbers_that_tell_no_position_are_passed_over() {
    let (mut method, _) = method(&yard());
    let prior = PoseUnion::single(PoseBox::from([Interval::centred(0.0, 1.0); 3]));
    for numbers in [
        vec![],
        vec![1.0, 2.0],
        vec![1.0, f64::NAN, 1.0],
        vec![1.0, f64::INFINITY, 1.0],
        vec![1.0, 2.0, 0.5],
        vec![1.0; 4],
    ] {
        let reading = Reading::Other { measured_s: 0.0, arrived_s: 0.0, device: "gnss".to_owned(), numbers };
        assert!(method.constrain(&reading, &Context::at_rest(&prior)).is_none(), "{reading:?}");
    }
    let other = Reading::Other { measured_s: 0.0, arrived_s: 0.0, device: "sonar".to_owned(), numbers: vec![1.0; 3] };
    assert!(!method.reads(&other));
}

#[test]
fn a_drive_by_positions_keeps_the_truth_through_trees_a_barn_and_an_outage() {
    for errors in [Distribution::Uniform, Distribution::Corner, Distribution::Drift] {
        for seed in 0..2 {
            let mut scene = yard();
            scene.robot.errors = errors;
            let (record, verdict) = judged(&scene, seed);
            let containment = verdict.containment.as_ref().unwrap();
            assert_eq!(containment.contained, containment.checks, "{errors:?} {seed}: {containment:?}");
            assert!(verdict.violations.is_empty(), "{:?}", verdict.violations);
            // With good reception, after some driving, the box of the position is twice a centimetre wide, the error of the reported position, plus
            // what the uncertainties of the antenna's place and of the lean add.
            let in_the_open = record.estimates.iter().zip(&record.truths).filter(|(_, truth)| {
                (8.0..39.0).contains(&truth.time_s) && truth.pose.y_m < 5.0 && truth.pose.x_m < 8.5
            });
            let widest_m = in_the_open.map(|(estimate, _)| estimate.pose.hull().width(0)).fold(0.0, f64::max);
            assert!(widest_m > 0.02 && widest_m < 0.2, "{errors:?} {seed}: {widest_m}");
        }
    }
}

#[test]
fn the_heading_is_told_by_the_way_between_positions() {
    let mut scene = yard();
    (scene.duration_s, scene.start.tolerance_deg) = (12.0, 60.0);
    let (record, verdict) = judged(&scene, 1);
    assert_eq!(verdict.containment.as_ref().unwrap().contained, 1201);
    let width_rad = record.estimates.last().unwrap().pose.hull().width(2);
    assert!(width_rad < 0.1, "{}", width_rad.to_degrees());
}

#[test]
fn a_localizer_told_half_the_error_or_no_lever_arm_loses_the_truth_or_knows_that_something_is_wrong() {
    let mut scene = yard();
    (scene.duration_s, scene.robot.errors) = (8.0, Distribution::Corner);
    let changes: [fn(&mut Gnss); 2] =
        [|gnss| gnss.fixed_tolerance_m = 0.005, |gnss| (gnss.forward_m, gnss.left_m) = (0.0, 0.0)];
    for (index, change) in changes.into_iter().enumerate() {
        let mut told = scene.clone();
        change(told.robot.gnss.as_mut().unwrap());
        let mut subject = IntervalLocalizer::of(&told);
        let record = run(&scene, 2, &mut subject, None, &RunOptions::default(), &mut |_| {}).unwrap();
        let mut steps = record.truths.iter().zip(&record.estimates);
        let is_wrong =
            steps.any(|(truth, estimate)| !estimate.pose.contains(truth.pose) || estimate.status == Status::Recovering);
        assert!(is_wrong, "change {index}");
    }
}

#[test]
fn keys_out_of_their_ranges_are_refused_with_what_was_expected() {
    let text = scene_text("gnss.toml");
    let changes = [
        ("lasts_s = 6.0", "lasts_s = 0.0", "`robot.gnss.outages[0].lasts_s"),
        ("size_m = [12.0, 2.8]", "size_m = [12.0, -2.8]", "`robot.gnss.shadows[0].size_m"),
        ("leaves = \"floating\"", "leaves = \"poor\"", "`robot.gnss.shadows[0].leaves"),
        ("[robot.gnss]\n", "[robot.gnss]\nperiod_s = 0.001\n", "`robot.gnss.period_s"),
        ("gyro = true", "gyro = true\ngnss = false", "gnss"),
    ];
    for (index, (from, to, named)) in changes.into_iter().enumerate() {
        let place = folder(&format!("gnss_refused_{index}"));
        assert!(text.contains(from), "{from}");
        std::fs::write(place.join("scene.toml"), text.replace(from, to)).unwrap();
        let (code, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml"]));
        assert!(code == 2 && errors.contains(named), "{from}: {code} {errors}");
    }
    let place = folder("gnss_without_a_receiver");
    let without = text.replace("forward_m = -0.15\nleft_m = 0.1\nheight_m = 0.6\n", "");
    let head = without.split("[robot.gnss]").next().unwrap();
    let tail = without.split("\n[localizer]").nth(1).unwrap();
    std::fs::write(place.join("scene.toml"), format!("{head}\n[localizer]{tail}")).unwrap();
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml"]));
    assert!(
        code == 2 && errors.contains("`gnss_positions` among them, expected `robot.gnss` for it to read"),
        "{errors}"
    );
}

#[test]
fn a_lever_arm_turns_the_same_way_by_hand_as_in_the_simulator() {
    // The expected position of the antenna is computed here with a rotation in the plane, independently of the simulator's own transform.
    let pose = Pose { x_m: 3.0, y_m: 2.0, heading_rad: 0.7 };
    let lever = Rotation2::new(0.7) * Vector2::new(-0.15, 0.1);
    let mut scene = yard();
    scene.robot.gnss.as_mut().unwrap().fixed_tolerance_m = 0.0;
    let told = positions(&scene, Truth { pose, ..Truth::default() }, 0.1)[0].1;
    assert!((told.at_m[0] - 3.0 - lever.x).abs() < 1e-12 && (told.at_m[1] - 2.0 - lever.y).abs() < 1e-12);
}

#[test]
fn a_drive_at_a_station_waits_for_a_position() {
    let mut scene = yard();
    scene.robot.gnss.as_mut().unwrap().period_s = 1.5;
    scene.route = None;
    scene.stations = vec![Station { x_m: 3.0, y_m: 2.0, heading_deg: 30.0, tolerance_m: None, tolerance_deg: None }];
    let (record, verdict) = judged(&scene, 0);
    let last = record.estimates.last().unwrap();
    assert!(last.time_s > 1.5 && last.time_s < 2.0, "{}", last.time_s);
    // The start is known to ±0.5 m. A fixed position is right to ±1 cm, and the heading of ±20° leaves the antenna's lever arm of 0.18 m open by
    // 2 · 0.18 m · sin 20° = 0.12 m across.
    let width_m = last.pose.hull()[0].width();
    assert!(width_m < 0.2, "{width_m}");
    assert_eq!(verdict.containment.unwrap().contained, record.estimates.len());
}

#[test]
fn a_drive_is_bounded_once_more_by_what_was_read_later() {
    let mut scene = yard();
    scene.duration_s = 20.0;
    let (alone, _) = judged(&scene, 5);
    assert!(alone.post_localized.is_none());
    scene.localizer.post_window = Some(30);
    let (record, verdict) = judged(&scene, 5);
    let post = verdict.post_localization.unwrap();
    assert!(post.checks >= 15 && post.contained == post.checks && !post.contradictory, "{post:?}");
    // At the start the heading is known to 20°; the way that follows tells it.
    let first = &post_steps(&record)[0];
    assert!(first.pose[2].width() < 0.2 * first.real_time[2].width(), "{first:?}");
    let narrower = |of: fn(&FixWidth) -> &AxisWidth, least: f64| {
        of(&post.width).mean < least * of(&post.real_time_width).mean && of(&post.width).mean > 0.0
    };
    assert!(narrower(|width| &width.x_m, 0.95) && narrower(|width| &width.y_m, 0.95), "{post:?}");
    assert!(narrower(|width| &width.heading_rad, 0.8), "{post:?}");
}

#[test]
fn a_window_of_one_key_frame_and_a_robot_that_makes_no_way_are_not_looked_back_at() {
    let refusal = |text: &str| Scene::parse(text, "scene.toml").unwrap_err().to_string();
    let text = scene_text("gnss.toml").replace("[localizer]", "[localizer]\npost_window = 1");
    let error = refusal(&text);
    assert!(error.contains("localizer.post_window = 1") && error.contains("from 2 to 1000"), "{error}");
    let mut stations: toml::Table = text.replace("post_window = 1", "post_window = 9").parse().unwrap();
    stations.remove("route").unwrap();
    let station = toml::Table::from_iter(
        [("x_m", 2.0), ("y_m", 2.0), ("heading_deg", 0.0)].map(|(key, at_m)| (key.to_owned(), at_m.into())),
    );
    stations.insert("station".to_owned(), toml::Value::Array(vec![station.into()]));
    let error = refusal(&stations.to_string());
    assert!(error.contains("localizer.post_window") && error.contains("`[route]` or errands"), "{error}");
}
