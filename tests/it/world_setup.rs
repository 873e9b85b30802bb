//! Scenes and drives that the tests of the simulated world share.

use interval::Interval;
use localizer::{Estimate, PoseBox, PoseUnion, Reading, Status, bounds};
use sim::{
    base::DriveCommand,
    devices::{Observation, flow::FlowSensor, gyro::GyroSensor, range_camera::RangeCameraSensor},
    driver::Driver,
    scene::Scene,
    truth::Truth,
    world::{Drawn, World},
};

/// Scene of a P3-DX in an 8 × 6 m room that faces along world x from (1.5, 3), with more keys of the scene's top level.
pub(crate) fn scene(more: serde_json::Value) -> Scene {
    let mut scene = serde_json::json!({
        "floor": {},
        "room": { "width_m": 8.0, "depth_m": 6.0 },
        "start": { "x_m": 1.5, "y_m": 3.0, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        scene[key] = value.clone();
    }
    serde_json::from_value(scene).expect("the test's own scene is valid")
}

/// A world in which wheel radii and track are exactly nominal.
pub(crate) fn nominal_world(scene: &Scene) -> World {
    World::new(scene, &nominal(scene))
}

/// Draws of a scene's errors with start, wheel radii and track exactly nominal.
pub(crate) fn nominal(scene: &Scene) -> Drawn {
    let mut drawn = Drawn::draw(scene, 0);
    drawn.start = scene.nominal_start();
    drawn.base.wheel_radius_m = [scene.robot.base.wheel_radius_m; 2];
    drawn.base.track_m = scene.robot.base.track_m;
    drawn
}

/// A commanded motion of the middle of the axle.
pub(crate) fn command(speed_m_per_s: f64, turn_rad_per_s: f64) -> DriveCommand {
    DriveCommand { speed_m_per_s, turn_rad_per_s }
}

/// Steps a world under one constant drive command and returns the last true state.
pub(crate) fn hold(world: &mut World, command: DriveCommand, lasts_s: f64) -> Truth {
    for _ in 0..(lasts_s * 1000.0).round() as usize {
        world.step(command);
    }
    world.truth()
}

/// Accelerates the robot at 0.5 m/s² up to a speed and turn rate.
pub(crate) fn gather_speed(world: &mut World, speed_m_per_s: f64, turn_rad_per_s: f64) {
    let lasts_s = 2.0 * speed_m_per_s;
    let n_steps = (lasts_s * 1000.0).round() as usize;
    for step in 0..n_steps {
        let share = step as f64 / n_steps as f64;
        world.step(command(share * speed_m_per_s, share * turn_rad_per_s));
    }
}

/// Estimate of a localizer that is right to within a millimetre and a milliradian, for a true state.
pub(crate) fn estimate(truth: &Truth) -> Estimate {
    let pose = truth.pose;
    let pose = PoseBox::from([
        Interval::centred(pose.x_m, 0.001),
        Interval::centred(pose.y_m, 0.001),
        Interval::centred(pose.heading_rad, 0.001),
    ]);
    Estimate {
        time_s: truth.time_s,
        pose: PoseUnion::single(pose),
        status: Status::Sound,
        relies_on: Vec::new(),
        contradicting: None,
    }
}

/// Drives the scene's route by estimates that are right to within a millimetre and a milliradian; returns the true state every 10 ms.
pub(crate) fn drive(scene: &Scene, drawn: &Drawn, lasts_s: f64) -> Vec<Truth> {
    let mut world = World::new(scene, drawn);
    let mut driver = Driver::new(scene);
    let mut truths = vec![world.truth()];
    for step in 0..(lasts_s * 100.0).round() as usize {
        let command = driver.command(&estimate(&world.truth()), step as f64 * 0.01);
        truths.push(hold(&mut world, command, 0.01));
    }
    truths
}

/// The scene's gyroscope, with its calibration errors as drawn.
pub(crate) fn gyro_sensor(scene: &Scene, seed: u64, drawn: &Drawn) -> GyroSensor {
    GyroSensor::new(scene.robot.gyro.as_ref().unwrap(), &drawn.devices.gyro.unwrap(), scene, seed)
}

/// The scene's flow sensor, with its mounting errors as drawn.
pub(crate) fn flow_sensor(scene: &Scene, seed: u64, drawn: &Drawn) -> FlowSensor {
    FlowSensor::new(scene.robot.flow.as_ref().unwrap(), &drawn.devices.flow.unwrap(), scene, seed)
}

/// The scene's range camera, with its mounting errors as drawn.
pub(crate) fn range_sensor(scene: &Scene, seed: u64) -> RangeCameraSensor {
    let mount = Drawn::draw(scene, seed).devices.range_camera.unwrap();
    RangeCameraSensor::new(scene.robot.range_camera.as_ref().unwrap(), &mount, scene, seed)
}

/// Noise and bias, with their signs, of one reading of a gyroscope at rest: the rate is their sum, and the observation holds their absolute
/// values, which the gyroscope's bounds limit.
pub(crate) fn noise_and_bias_rad_per_s(observed: &Observation) -> [f64; 2] {
    let Reading::Gyro { rate_rad_per_s, .. } = observed.reading else { panic!("{observed:?}") };
    let size = |bound| observed.true_value(bound).unwrap();
    let sizes = [size(bounds::GYRO_NOISE), size(bounds::GYRO_BIAS)];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let off = |[noise, bias]: &[f64; 2]| (noise + bias - rate_rad_per_s).abs();
    let pairs = signs.map(|signs: [f64; 2]| [signs[0] * sizes[0], signs[1] * sizes[1]]);
    pairs.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}
