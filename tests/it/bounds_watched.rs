//! Tests that every bound that an estimate relies on is checked against the truth, and that every bound checked is relied on. An unchecked bound
//! could be broken unnoticed, and one that no estimate relies on would excuse failures that have nothing to do with it.

use std::collections::BTreeSet;

use localizer::bounds;
use sim::{
    judge::watched,
    loading::SceneFile,
    render::Renderer,
    run::{RunOptions, run},
    scene::{Reception, Scene},
    subject::IntervalLocalizer,
};

use crate::command::root;

/// Two sets for a short run of a scene of the repository: the bounds that its estimates rely on, and those that the judge checks.
fn named(path: &str, duration_s: f64, change: impl Fn(&mut Scene)) -> [BTreeSet<&'static str>; 2] {
    let mut scene = SceneFile::load_all(&[root().join("scenes").join(path)]).unwrap().remove(0).scene;
    scene.duration_s = duration_s;
    change(&mut scene);
    let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
    let record =
        run(&scene, 1, &mut IntervalLocalizer::of(&scene), renderer.as_mut(), &RunOptions::default(), &mut |_| {})
            .unwrap();
    let relied_on = record.estimates.iter().flat_map(|estimate| estimate.relies_on.iter().copied()).collect();
    [relied_on, watched(&scene, &record)]
}

#[test]
fn every_bound_relied_on_is_watched_and_every_watched_one_relied_on() {
    // The runs together rely on every bound. The first ones use the four methods of a home (floor tiles, ceiling markers, wall directions,
    // landmarks), the distances of walls, upright edges of walls, landmarks in space, the gyroscope, a car's steering and satellite navigation;
    // others learn the gyroscope's errors with and without a declared bound on its angle and at rest, and use the flow sensor.
    let runs = [
        named("home.toml", 1.0, |_| {}),
        named("home_ranges.toml", 1.0, |_| {}),
        named("home_bearings.toml", 1.0, |_| {}),
        named("tiles.toml", 0.5, |scene| scene.robot.delivery.stamp_tolerance_s = 0.0005),
        named("dark/carpet.toml", 1.0, |_| {}),
        named("landmarks/teach.toml", 1.0, |_| {}),
        named("landmarks/room_teach.toml", 3.0, |_| {}),
        named("car_steering.toml", 1.0, |_| {}),
        named("gnss.toml", 2.0, |scene| {
            let outage = &mut scene.robot.gnss.as_mut().unwrap().outages[0];
            (outage.at_s, outage.leaves) = (1.0, Reception::Floating);
        }),
        named("dark/carpet.toml", 1.0, |scene| {
            scene.localizer.learns_gyro = true;
            scene.bounds.rest_turn_deg = Some(0.1);
            scene.robot.gyro.as_mut().unwrap().angle_floor_deg = None;
        }),
    ];
    for [relied_on, watched] in &runs {
        let unwatched: Vec<_> = relied_on.difference(watched).collect();
        assert!(unwatched.is_empty(), "relied on and not watched: {unwatched:?}");
    }
    let all = |which: usize| runs.iter().flat_map(|names| names[which].iter().copied()).collect::<BTreeSet<_>>();
    let unused: Vec<_> = all(1).difference(&all(0)).copied().collect::<Vec<_>>();
    assert!(unused.is_empty(), "watched and not relied on: {unused:?}");
    let table: BTreeSet<&str> = bounds::ALL.iter().map(|bound| bound.name).collect();
    let unnamed: Vec<_> = all(0).difference(&table).copied().collect();
    let idle: Vec<_> = table.difference(&all(0)).copied().collect();
    assert!(unnamed.is_empty() && idle.is_empty(), "not in the table: {unnamed:?}; in it and not relied on: {idle:?}");
}

#[test]
fn a_bound_told_wider_is_told() {
    let scenes = ["home.toml", "dark/carpet.toml", "car_steering.toml", "papers/rigid_transform_wrong_matches.toml"];
    let mut untold = BTreeSet::new();
    for path in scenes {
        let scene = SceneFile::load_all(&[root().join("scenes").join(path)]).unwrap().remove(0).scene;
        let model =
            |scene: &Scene| format!("{:?} {:?} {:?}", scene.map(), scene.robot_model(), scene.bounds.rest_turn_deg);
        let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
        let short = Scene { duration_s: 0.2, ..scene.clone() };
        let record =
            run(&short, 1, &mut IntervalLocalizer::of(&short), renderer.as_mut(), &RunOptions::default(), &mut |_| {})
                .unwrap();
        // The bound on the angle error that the gyroscope accumulates is infinite where a scene does not declare it. It cannot be made wider then,
        // and is left out.
        let bounds_angle = scene.robot.gyro.as_ref().is_some_and(|gyro| gyro.angle_floor_deg.is_some());
        for bound in watched(&scene, &record).into_iter().filter(|bound| bounds_angle || *bound != bounds::GYRO_ANGLE) {
            let mut wider = scene.clone();
            wider.widen(bound, 0.0, 100.0);
            if model(&wider) == model(&scene) {
                untold.insert(bound);
            }
        }
    }
    assert!(untold.is_empty(), "{untold:?}");
}
