//! Faults that make boxes 30 % too small exclude witnesses: histories other than the truth that keep every declared bound on the same readings.
//!
//! The truth seldom lies near a face of a box, since not all errors can be at their worst in one drive. Witnesses lie as near to the faces as the
//! readings leave open, so that a containment test with them notices smaller faults than one with the truth.

use interval::{Interval, IntervalBox};
use localizer::{
    Estimate, Localizer, Method, Pose, PoseBox, Reading,
    localizer::Account,
    methods::{
        ceiling_markers::CeilingMarkers,
        floor_tiles::{Chain, FloorTiles},
        range_landmarks::{Freedom, RangeLandmarks, Solver},
    },
};
use sim::{
    campaign::sharpness::{Instant, N_INSTANTS, ReadingLog, Sharpness, measure},
    devices::Observation,
    loading::SceneTemplate,
    render::Renderer,
    run::{RunOptions, Witness, run_witnessed},
    scene::{Distribution, Scene},
    subject::IntervalLocalizer,
    truth::Truth,
};

use crate::{
    command::root,
    corner_runs::{TooSmall, too_small},
    witnesses::demand_witnesses,
};

/// What a fault leaves of each width.
const LEFT: f64 = 0.7;

/// Keeps the readings of a run, and the estimates that a faulty localizer makes of them.
struct Faulty {
    log: ReadingLog,
    localizer: Localizer,
    estimates: Vec<Estimate>,
}

impl Witness for Faulty {
    fn start(&mut self, offset_s: f64, station: Option<usize>) {
        self.log.start(offset_s, station);
    }

    fn sense(&mut self, observation: &Observation) {
        self.log.sense(observation);
        self.localizer.observe(&observation.reading);
    }

    fn account(&mut self, reading: &Reading, accounts: &[Account]) {
        self.log.account(reading, accounts);
    }

    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose) {
        self.log.step(truth, estimate, odometry);
        self.estimates.push(self.localizer.estimate_at(truth.time_s));
    }
}

fn scene(path: &str, keys: &[&str]) -> Scene {
    let keys: Vec<_> = keys.iter().map(|key| key.parse().unwrap()).collect();
    SceneTemplate::load(&root().join("scenes").join(path)).unwrap().with(&keys).unwrap().scene
}

/// Asserts that witnesses of a run are in all boxes as they are, outside of some of those that are 30 % too small along one axis, whichever it is, and
/// outside of some boxes of a localizer by the same method whose boxes and rows are 30 % too small. Returns what was found.
fn assert_noticed(scene: &Scene, seed: u64, method: &dyn Fn() -> Box<dyn Method>) -> Sharpness {
    let faulty: Box<dyn Method> = Box::new(TooSmall { method: method(), left: LEFT, rows_left: Some(LEFT) });
    let localizer = Localizer::new(scene.map(), scene.robot_model(), vec![faulty], scene.start_box())
        .with_base_clock(scene.robot.delivery.stamp_tolerance_s);
    let mut beside = Faulty { log: ReadingLog::default(), localizer, estimates: Vec::new() };
    let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
    let (mut subject, options) = (IntervalLocalizer::of(scene), RunOptions::default());
    let record =
        run_witnessed(scene, seed, &mut subject, renderer.as_mut(), &options, &mut beside, &mut |_| {}).unwrap();
    let found = measure(scene, "scene", &record, &beside.log, N_INSTANTS, &mut |_| {}).unwrap();
    let hull_in = |estimates: &[Estimate], instant: &Instant| -> PoseBox {
        let at = estimates.partition_point(|estimate| estimate.time_s < instant.time_s - 0.005);
        estimates[at].pose.hull()
    };
    let whole = |instant: &Instant| instant.are_witnesses_in(&hull_in(&record.estimates, instant));
    assert!(found.instants.iter().all(|instant| instant.in_box && whole(instant)), "{found:?}");
    let is_lost = |narrowed: &dyn Fn(&Instant) -> PoseBox| {
        found.instants.iter().any(|instant| !instant.are_witnesses_in(&narrowed(instant)))
    };
    for axis in 0..3 {
        let along = |instant: &Instant| too_small(&hull_in(&record.estimates, instant), &[axis], LEFT);
        assert!(is_lost(&along), "axis {axis}: {found:?}");
        // By hand: the fault leaves 0.7 of each half width, and the farthest witness is farther from the middle.
        assert!(found.power(axis).unwrap() > LEFT && found.power(axis).unwrap() <= 1.0);
    }
    let by_fault = |instant: &Instant| -> PoseBox {
        let hull = hull_in(&beside.estimates, instant);
        // An empty intersection begins a doubt, and what is doubted may be anywhere.
        if hull.is_empty() { IntervalBox::from([Interval::ENTIRE; 3]) } else { hull }
    };
    assert!(is_lost(&by_fault), "by the method: {found:?}");
    found
}

#[test]
fn tiles_with_boxes_30_percent_too_small_exclude_witnesses() {
    let scene = scene("tiles.toml", &["duration_s=3", "robot.errors=corner"]);
    let method = || FloorTiles::new(&scene.map(), &scene.robot_model(), Chain::Direct).unwrap();
    demand_witnesses(&assert_noticed(&scene, 2, &|| Box::new(method())), 2.0);
}

#[test]
fn markers_with_boxes_30_percent_too_small_exclude_witnesses() {
    let mut scene = crate::ceiling_runs::scene("");
    scene.robot.errors = Distribution::Corner;
    let method = || CeilingMarkers::new(&scene.map(), &scene.robot_model()).unwrap();
    demand_witnesses(&assert_noticed(&scene, 2, &|| Box::new(method())), 2.5);
}

#[test]
fn landmarks_with_boxes_30_percent_too_small_exclude_witnesses() {
    let scene = scene("papers/rigid_transform_loop.toml", &["duration_s=9", "robot.errors=drift"]);
    let method = || RangeLandmarks::new(&scene.robot_model(), Freedom::Full, Solver::OneShot).unwrap();
    assert_noticed(&scene, 2, &|| Box::new(method()));
}
