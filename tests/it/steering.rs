//! A car with a steering encoder: what the encoder reads, what the steering tells the localizer, the blame for an encoder whose zero is off, and
//! what is refused.

use std::f64::consts::TAU;

use localizer::{Estimate, Pose, Reading, localizer::Account, motion::steering::DEVICE};
use serde_json::json;
use sim::{
    devices::Observation,
    judge::Verdict,
    loading::SceneFile,
    run::{RunOptions, RunRecord, Witness, run, run_witnessed},
    scene::{Distribution, Gyro, Robot, Scene, SceneError, SteeringEncoder},
    subject::IntervalLocalizer,
    truth::Truth,
    world::World,
};

use crate::{
    command::root,
    judging::verdict_of,
    world_setup::{command, hold, nominal, scene},
};

/// The drive of `scenes/car_steering.toml`, through curves without a gyroscope, with something changed.
fn car(change: impl Fn(&mut Scene)) -> Scene {
    let mut scene = SceneFile::load_all(&[root().join("scenes/car_steering.toml")]).unwrap().remove(0).scene;
    change(&mut scene);
    scene
}

fn driven(scene: &Scene, seed: u64) -> (RunRecord, Verdict) {
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}

/// Widths of the box around the estimate at the end of a drive.
fn widths(record: &RunRecord) -> [f64; 3] {
    let hull = record.estimates.last().unwrap().pose.hull();
    [0, 1, 2].map(|axis| hull[axis].width())
}

#[test]
fn a_longer_wheelbase_makes_the_circle_wider() {
    let keys = json!({
        "room": { "width_m": 40.0, "depth_m": 40.0 },
        "start": { "x_m": 20.0, "y_m": 20.0, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
        "robot": { "mass_kg": 10.0, "body_radius_m": 0.6,
                   "base": { "kind": "ackermann", "wheel_radius_m": 0.1, "track_m": 0.4 } },
    });
    let scene = scene(keys);
    let mut drawn = nominal(&scene);
    drawn.base.wheelbase_m = 0.55;
    let mut world = World::new(&scene, &drawn);
    let motion = command(0.1, 0.1);
    let before = hold(&mut world, motion, 3.0);
    let after = hold(&mut world, motion, 10.0);
    // The command asks for a circle of 1 m, for which a car with the nominal wheelbase of 0.5 m steers by atan 0.5.
    assert!((after.steering_rad.tan() - 0.5).abs() < 1e-9, "{}", after.steering_rad);
    let gone_m = |truth: &Truth| 0.5 * (truth.wheel_travel_m[0] + truth.wheel_travel_m[1]);
    let circle_m = (gone_m(&after) - gone_m(&before)) / (after.pose.heading_rad - before.pose.heading_rad);
    // The front wheels alone would drive a circle of 1.1 m. The rear wheels, whose motors are driven for the nominal wheelbase, pull it towards 1 m.
    assert!((1.05..1.1).contains(&circle_m), "radius {circle_m} m");
}

/// Keeps the truth behind each reading of the steering encoder, with its ticks.
#[derive(Default)]
struct Readings(Vec<(Truth, f64)>);

impl Witness for Readings {
    fn start(&mut self, _offset_s: f64, _station: Option<usize>) {}
    fn sense(&mut self, observation: &Observation) {
        if let Reading::Other { device, numbers, .. } = &observation.reading
            && device == DEVICE
        {
            self.0.push((observation.truth, numbers[0]));
        }
    }
    fn account(&mut self, _reading: &Reading, _accounts: &[Account]) {}
    fn step(&mut self, _truth: &Truth, _estimate: &Estimate, _odometry: Pose) {}
}

#[test]
fn readings_are_the_nearest_ticks_and_zero_and_scale_lie_at_their_corners() {
    let mut signs = [[false; 2]; 2];
    for seed in 0..12 {
        let scene = car(|scene| {
            (scene.duration_s, scene.robot.errors) = (7.0, Distribution::Corner);
            scene.robot.steering_encoder.as_mut().unwrap().ticks_per_turn = 1000;
        });
        let mut readings = Readings::default();
        let record = run_witnessed(
            &scene,
            seed,
            &mut IntervalLocalizer::of(&scene),
            None,
            &RunOptions::default(),
            &mut readings,
            &mut |_| {},
        )
        .unwrap();
        let drawn = record.drawn.devices.steering_encoder.unwrap();
        assert!((drawn.zero_rad.abs() - 0.05_f64.to_radians()).abs() < 1e-12, "{drawn:?}");
        assert!(((drawn.scale - 1.0).abs() - 0.002).abs() < 1e-12, "{drawn:?}");
        signs[0][usize::from(drawn.zero_rad > 0.0)] = true;
        signs[1][usize::from(drawn.scale > 1.0)] = true;
        // Every 5 ms from the start on; the car is steered by more than 5° meanwhile.
        assert_eq!(readings.0.len(), 1401);
        let most_rad = readings.0.iter().map(|(truth, _)| truth.steering_rad.abs()).fold(0.0, f64::max);
        assert!(most_rad > 5.0_f64.to_radians(), "{most_rad}");
        for (truth, ticks) in &readings.0 {
            let read_rad = drawn.scale * truth.steering_rad + drawn.zero_rad;
            assert!(ticks.fract() == 0.0 && (read_rad - ticks * TAU / 1000.0).abs() <= 0.5 * TAU / 1000.0 + 1e-12);
        }
    }
    assert_eq!(signs, [[true; 2]; 2]);
}

#[test]
fn the_steering_tells_a_cars_heading_better_than_its_rear_wheels() {
    for seed in 100..103 {
        let scene = car(|_| {});
        let (with, verdict) = driven(&scene, seed);
        assert!(verdict.verdict.passed, "{seed}: {:?}", verdict.verdict.failed);
        let (without, _) = driven(&car(|scene| scene.robot.steering_encoder = None), seed);
        let (with, without) = (widths(&with), widths(&without));
        assert!((0..3).all(|axis| with[axis] < 0.6 * without[axis]), "{seed}: {with:?} beside {without:?}");
    }
}

#[test]
fn beside_a_gyroscope_the_steering_makes_no_box_wider() {
    // Both are led by the true pose, so that they drive alike.
    let scene = car(|scene| (scene.duration_s, scene.robot.gyro) = (10.0, Some(Gyro::default())));
    let with = driven(&scene, 7).0;
    let alone = Scene { robot: Robot { steering_encoder: None, ..scene.robot.clone() }, ..scene.clone() };
    let mut told = IntervalLocalizer::of(&alone);
    let again = run(&scene, 7, &mut told, None, &RunOptions::default(), &mut |_| {}).unwrap();
    assert_eq!(with.truths.last(), again.truths.last());
    for (both, one) in with.estimates.iter().zip(&again.estimates) {
        let [both, one] = [both, one].map(|estimate| estimate.pose.hull());
        assert!((0..3).all(|axis| both[axis].width() <= one[axis].width() * (1.0 + 1e-9)), "{both:?} {one:?}");
    }
}

#[test]
fn errors_at_the_ends_of_their_bounds_and_readings_that_are_lost_or_late_keep_the_truth_in_the_box() {
    for errors in [Distribution::Corner, Distribution::Drift] {
        for seed in 0..5 {
            let scene = car(|scene| {
                scene.robot.errors = errors;
                if seed % 2 == 0 {
                    let delivery = &mut scene.robot.delivery;
                    (delivery.dropped_share, delivery.late_s, delivery.stamp_tolerance_s) = (0.2, 0.03, 0.001);
                }
            });
            let verdict = driven(&scene, seed).1;
            let containment = verdict.containment.as_ref().unwrap();
            assert_eq!(containment.contained, containment.checks, "{errors:?} {seed}: {containment:?}");
            let is_of_steering =
                |bound: &str| bound.starts_with("steering_encoder") || bound.starts_with("wheels.steering");
            let broken = verdict.violations.iter().find(|broken| is_of_steering(&broken.bound));
            assert!(broken.is_none(), "{errors:?} {seed}: {broken:?}");
        }
    }
}

#[test]
fn an_encoder_whose_zero_is_displaced_is_to_blame_by_what_it_should_have_been() {
    for seed in 0..10 {
        let scene = car(|scene| scene.robot.steering_encoder.as_mut().unwrap().zero_shift_deg = -1.0);
        let verdict = driven(&scene, seed).1;
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!((containment.unsound, containment.perception), (0, 0), "{seed}: {containment:?}");
        assert!(containment.bound_broken > 0, "{seed}: {containment:?}");
        let first = containment.first_failure.as_ref().unwrap();
        assert_eq!(first.blame, "steering_encoder.zero", "{seed}: {first:?}");
        assert!(first.because.contains("moved back to its bound"), "{first:?}");
    }
}

/// What is changed of what a scene states of its steering encoder.
type Change = fn(&mut SteeringEncoder);

#[test]
fn bounds_on_steering_that_are_declared_too_narrow_are_broken_and_to_blame() {
    let narrow: [(&str, Change); 2] = [
        ("wheels.steering_rate", |encoder| encoder.rate_deg_per_s = 5.0),
        ("wheels.steering_slip", |encoder| {
            (encoder.slip_share, encoder.slip_deg_per_m, encoder.slip_floor_deg) = (0.0, 0.0, 0.0);
        }),
    ];
    for (bound, narrow) in narrow {
        let verdict = driven(&car(|scene| narrow(scene.robot.steering_encoder.as_mut().unwrap())), 3).1;
        assert!(verdict.violations.iter().any(|broken| broken.bound == bound), "{bound}: {:?}", verdict.violations);
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!((containment.unsound, containment.perception), (0, 0), "{bound}: {containment:?}");
    }
}

#[test]
fn a_steering_encoder_is_refused_on_a_base_that_steers_nothing_and_with_a_period_that_cannot_be_sampled() {
    let text = |base: &str, encoder: &str| {
        format!(
            "duration_s = 1.0\n[room]\nwidth_m = 12.0\ndepth_m = 8.0\n[floor]\n[start]\nx_m = 2.0\ny_m = 2.0\n\
             [robot]\nbody_radius_m = 0.55\n{encoder}\n[robot.base]\nkind = \"{base}\"\ntrack_m = 0.4\n\
             [[route.waypoint]]\nx_m = 9.0\ny_m = 2.0\n"
        )
    };
    for (base, encoder, said) in [
        (
            "differential",
            "steering_encoder = true",
            ["robot.steering_encoder", "true", "the base steers nothing, expected `false`"],
        ),
        (
            "differential",
            "steering_encoder.period_s = 0.02",
            ["robot.steering_encoder", "car.toml", "the base steers nothing"],
        ),
        (
            "ackermann",
            "steering_encoder.period_s = 0.0015",
            ["robot.steering_encoder.period_s", "0.0015", "multiple of 0.001"],
        ),
        (
            "ackermann",
            "steering_encoder.zero_tolerance_deg = -1.0",
            ["robot.steering_encoder.zero_tolerance_deg", "-1.0", "0"],
        ),
    ] {
        let error = Scene::parse(&text(base, encoder), "car.toml").unwrap_err();
        assert!(matches!(error, SceneError::Invalid { .. }), "{error}");
        let message = error.to_string();
        ["car.toml"]
            .iter()
            .chain(&said)
            .for_each(|part| assert!(message.contains(part), "{part:?} missing in: {message}"));
    }
    assert!(Scene::parse(&text("differential", "steering_encoder = false"), "car.toml").is_ok());
    assert!(Scene::parse(&text("ackermann", "steering_encoder = true"), "car.toml").is_ok());
}
