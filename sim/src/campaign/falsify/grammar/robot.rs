//! Gives the robot of a scene drawn at random its devices, periods at which these can be sampled, and declared bounds wide enough for the robot to
//! keep.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Dice, Draws, rounded},
    scene::{BaseKind, Bounds, CameraKeys, Flow, Gyro, Robot, RobotPreset},
};
use localizer::reading::Camera;

use super::{
    car, drive,
    tables::{meaning, number, table},
};

/// Probability with which a robot has each of the devices that need no rendered images. The cameras are listed apart.
const FITTED: [(&str, f64); 5] =
    [("gyro", 0.65), ("flow", 0.5), ("range_camera", 0.55), ("point_camera", 0.4), ("scanner", 0.3)];

/// Probability with which a robot has each of its three cameras, in scenes that have rendered cameras at all.
const CAMERAS: [(&str, Camera, f64); 3] = [
    ("floor_camera", Camera::Floor, 0.5),
    ("forward_camera", Camera::Forward, 0.35),
    ("ceiling_camera", Camera::Ceiling, 0.4),
];

/// Completes the tables `[robot]` and `[bounds]` of a drawn scene, and returns the robot with all its default values.
pub(super) fn settle(scene: &mut Table, draws: &Draws, room_m: [f64; 2], has_cameras: bool) -> Robot {
    let robot = table(scene, "robot");
    let mut dice = draws.dice("devices that are fitted");
    for (name, share) in FITTED {
        fit(robot, name, dice.chance(share));
    }
    let mut cameras = CAMERAS.map(|(_, _, share)| has_cameras && dice.chance(share));
    if has_cameras && cameras == [false; 3] {
        cameras[dice.whole(0, 2) as usize] = true;
    }
    for ((name, ..), is_fitted) in CAMERAS.iter().zip(cameras) {
        fit(robot, name, is_fitted);
    }
    for device in ["encoders", "gyro", "flow", "steering_encoder"] {
        if let Some(Value::Table(device)) = robot.get_mut(device)
            && let Some(period_s) = number(device, "period_s")
        {
            // Devices are sampled at steps of the physics, so that a period is a multiple of 1 ms.
            let steps = (period_s / 0.001).round().max(1.0);
            device.insert("period_s".to_owned(), Value::Float(rounded(0.001 * steps, 6)));
        }
    }
    if let Some(Value::Table(gyro)) = robot.get_mut("gyro") {
        settle_gyro(gyro);
    }
    if let Some(Value::Table(flow)) = robot.get_mut("flow") {
        settle_flow(flow);
    }
    if let Some(Value::Table(camera)) = robot.get_mut("range_camera")
        && let (Some(least_m), Some(greatest_m)) = (number(camera, "least_range_m"), number(camera, "greatest_range_m"))
        && least_m >= greatest_m
    {
        camera.remove("least_range_m");
    }
    settle_images(robot, draws);
    car::settle(robot, draws, room_m, drive::has_route(draws));
    let fitted: Robot = meaning(robot).unwrap_or_default();
    settle_bounds(table(scene, "bounds"), draws, &fitted);
    fitted
}

/// Fits a device to the robot or removes it, whether or not the robot's preset has such a device.
fn fit(robot: &mut Table, name: &str, is_fitted: bool) {
    if is_fitted {
        table(robot, name);
    } else {
        robot.insert(name.to_owned(), Value::Boolean(false));
    }
}

/// Declares a tolerance for the scale of the optical flow sensor that covers the sum of all errors of scale that the scene draws at random, and 2 %
/// more for their products.
fn settle_flow(flow: &mut Table) {
    let Some(meant) = meaning::<Flow>(flow) else { return };
    let drawn = 1.02 * (meant.calibration_tolerance + meant.surface_tolerance + meant.noise_tolerance);
    // A flow sensor with an error of scale of nearly 100 % says nothing about motion, so that the keys that state such large errors are removed.
    if drawn > 0.8 {
        for key in ["calibration_tolerance", "surface_tolerance", "noise_tolerance"] {
            flow.remove(key);
        }
    } else if drawn > meant.scale_tolerance {
        flow.insert("scale_tolerance".to_owned(), Value::Float(rounded(drawn + 0.001, 4)));
    }
}

fn settle_gyro(gyro: &mut Table) {
    let wanders = ["bias_instability_deg_per_h", "rate_random_walk_deg_per_h_per_sqrt_h"];
    let is_restless = wanders.iter().any(|key| number(gyro, key).is_some_and(|value| value > 0.0));
    if is_restless && number(gyro, "bias_wander_deg_per_s2").unwrap_or(0.0) == 0.0 {
        gyro.insert("bias_wander_deg_per_s2".to_owned(), Value::Float(0.001));
    }
    if number(gyro, "angle_deg_per_s").is_some() && !gyro.contains_key("angle_floor_deg") {
        gyro.remove("angle_deg_per_s");
    }
    let (Some(walk_deg), Some(meant)) = (number(gyro, "angle_random_walk_deg_per_sqrt_h"), meaning::<Gyro>(gyro))
    else {
        return;
    };
    let least = 3.01 * meant.deviation_deg_per_s(walk_deg);
    if meant.noise_deg_per_s < least {
        gyro.insert("noise_deg_per_s".to_owned(), Value::Float(rounded(least, 4)));
    }
}

/// Lengthens the period of a camera so that each exposure ends before the next image is due, and puts the principal point of the ceiling camera
/// inside the image.
fn settle_images(robot: &mut Table, draws: &Draws) {
    for (name, ..) in CAMERAS {
        let Some(Value::Table(camera)) = robot.get_mut(name) else { continue };
        if name == "ceiling_camera" {
            let mut dice = draws.dice("optical axis of the ceiling camera");
            let size_px =
                [("width_px", 640.0), ("height_px", 480.0)].map(|(key, usual)| number(camera, key).unwrap_or(usual));
            let axis_px = size_px.map(|extent| Value::Float(rounded(extent * dice.uniform(0.45, 0.55), 4)));
            camera.insert("principal_point_px".to_owned(), Value::Array(axis_px.to_vec()));
        }
        if let Some(Value::Table(sensor)) = camera.get_mut("sensor")
            && sensor.contains_key("exposure_s")
        {
            sensor.remove("longest_exposure_s");
        }
        bend(camera, &mut draws.dice(&format!("barrel of the {name}")));
        camera.remove("turning_exposure_s").filter(|_| draws.dice("turning exposure").chance(0.3)).map(|exposure| {
            // The exposure in turns is limited to 2 ms, as it must not exceed the sensor's longest exposure, which is longer than that in every
            // preset.
            let exposure_s = exposure.as_float().unwrap_or(0.002).min(0.002);
            camera.insert("turning_exposure_s".to_owned(), Value::Float(exposure_s))
        });
    }
    let Some(meant) = meaning::<Robot>(robot) else { return };
    for (name, camera, _) in CAMERAS {
        if let Some(timing) = meant.camera(camera).map(CameraKeys::timing)
            && timing.longest_s > timing.period_s
            && let Some(Value::Table(camera)) = robot.get_mut(name)
        {
            camera.insert("period_s".to_owned(), Value::Float(rounded(1.2 * timing.longest_s, 3)));
        }
    }
}

/// Gives some cameras a lens as distorted as cheap wide ones are: k1 between -0.3 and -0.1, and k2 near k1², with which the image is not folded over.
fn bend(camera: &mut Table, dice: &mut Dice) {
    let (is_bent, k1, share) = (dice.chance(0.15), dice.uniform(-0.3, -0.1), dice.uniform(0.8, 1.5));
    if is_bent {
        let bent = [k1, share * k1 * k1, 0.0, 0.0, 0.0].map(|value| Value::Float(rounded(value, 3)));
        table(camera, "lens").insert("distortion".to_owned(), Value::Array(bent.to_vec()));
    }
}

/// Draws the declared bounds on motion that emerges from the physics. The bounds on the robot's speed, turn rate and acceleration (`reach_…`) are
/// multiples of the greatest values that the scene states for the robot. Bounds on slip, tilt and heave are never narrower than their defaults. They
/// are at least five times as wide for half of the P3-DX robots, on which the defaults were measured, and for all other robots.
fn settle_bounds(bounds: &mut Table, draws: &Draws, robot: &Robot) {
    let usual = Bounds::default();
    let is_p3dx = robot.preset == RobotPreset::P3dx && robot.base.kind == BaseKind::Differential;
    let is_usual = is_p3dx && draws.dice("robot as it is").chance(0.5);
    let mut state = |key: &str, least: f64, most: f64| {
        let mut dice: Dice = draws.dice(&format!("bounds.{key}"));
        bounds.insert(key.to_owned(), Value::Float(rounded(dice.log_uniform(least, most), 3)));
    };
    // The declared bounds on motion are wider than the limits of the motors, as a push or a carpet can move the robot faster.
    state("reach_speed_m_per_s", 1.4 * robot.max_speed_m_per_s, 4.0 * robot.max_speed_m_per_s);
    state("reach_turn_rate_rad_per_s", 1.6 * robot.max_turn_rate_rad_per_s, 4.0 * robot.max_turn_rate_rad_per_s);
    state("reach_acceleration_m_per_s2", 6.0 * robot.max_acceleration_m_per_s2, 60.0 * robot.max_acceleration_m_per_s2);
    let narrowest = if is_usual { 1.0 } else { 5.0 };
    for (key, value, widest) in [
        ("slip_ratio", usual.slip_ratio, 60.0),
        ("slip_floor_m", usual.slip_floor_m, 100.0),
        ("side_slip_ratio", usual.side_slip_ratio, 60.0),
        ("side_slip_floor_m", usual.side_slip_floor_m, 100.0),
        ("body_tilt_deg", usual.body_tilt_deg, 60.0),
        ("body_heave_m", usual.body_heave_m, 1_000.0),
    ] {
        state(key, narrowest * value, widest * value);
    }
    if bounds.contains_key("rest_turn_deg") {
        bounds.insert(
            "rest_turn_deg".to_owned(),
            Value::Float(rounded(draws.dice("bounds.rest_turn_deg").log_uniform(0.05, 5.0), 3)),
        );
    }
}
