//! Contradictions about cameras: exposures that do not fit between two images, and black levels that leave no grey levels for light.

use crate::{
    loading::parse::Contradiction,
    scene::{CeilingCamera, FloorCamera, ForwardCamera, LensKeys, Scene, Sensor, SensorModel},
};
use localizer::reading::Camera;

/// Tolerance for rounding when times are compared: sums like 0.0335 + 479 · 10⁻⁵ are not exact, and nobody states a period that finely.
const ROUNDING_S: f64 = 1e-9;

/// Keys that all cameras have in common.
struct Keys<'a> {
    name: &'static str,
    camera: Camera,
    sensor: &'a Sensor,
    model: SensorModel,
    lens: &'a LensKeys,
    height_px: u32,
}

/// All contradictions in `scene` about its cameras' exposures and black levels.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let robot = &scene.robot;
    let floor = robot.floor_camera.as_ref().map(Keys::floor);
    let forward = robot.forward_camera.as_ref().map(Keys::forward);
    let ceiling = robot.ceiling_camera.as_ref().map(Keys::ceiling);
    for keys in floor.into_iter().chain(forward).chain(ceiling) {
        let problems = [exposure_problem(&keys), black_level_problem(&keys), period_problem(scene, &keys)];
        found.extend(
            problems
                .into_iter()
                .flatten()
                .map(|(key, expected)| Contradiction { key: format!("robot.{}_camera.{key}", keys.name), expected }),
        );
    }
    if let Some(camera) = &robot.forward_camera
        && let Some(turning_s) = camera.turning_exposure_s
        && turning_s > camera.sensor_model().longest_exposure_s
    {
        let longest_s = camera.sensor_model().longest_exposure_s;
        let expected = format!("expected at most the longest exposure, which is {longest_s}");
        found.push(Contradiction { key: "robot.forward_camera.turning_exposure_s".to_owned(), expected });
    }
}

fn exposure_problem(keys: &Keys) -> Option<(&'static str, String)> {
    let (fixed_s, longest_s) = keys.sensor.exposure_s.zip(keys.sensor.longest_exposure_s)?;
    let expected = || format!("expected at most `longest_exposure_s`, which is {longest_s}");
    (fixed_s > longest_s).then(|| ("sensor.exposure_s", expected()))
}

fn black_level_problem(keys: &Keys) -> Option<(&'static str, String)> {
    let greatest = keys.model.bits.greatest_level();
    let expected = || {
        let bits = keys.model.bits.bits();
        format!("leaves no level for light, expected less than {greatest}, the greatest level of {bits} bits")
    };
    (keys.model.black_level >= f64::from(greatest)).then(|| ("sensor.black_level", expected()))
}

/// Checks that one image is read out before the next is exposed, as in sensors whose rows share their circuits.
fn period_problem(scene: &Scene, keys: &Keys) -> Option<(&'static str, String)> {
    let timing = scene.robot.camera_timing(keys.camera)?;
    let (period_s, exposure_s) = (timing.period_s, keys.model.longest_exposure_s);
    if timing.longest_s <= period_s + ROUNDING_S {
        return None;
    }
    if exposure_s > period_s + ROUNDING_S || keys.lens.row_time_s == 0.0 {
        let key = if keys.model.is_fixed { "sensor.exposure_s" } else { "sensor.longest_exposure_s" };
        let expected = format!(
            "{exposure_s} s is longer than the camera's `period_s`, expected at most {period_s}, from image to image"
        );
        return Some((key, expected));
    }
    let most_s = (period_s - exposure_s).max(0.0) / f64::from(keys.height_px - 1);
    let expected = format!(
        "{} rows after an exposure of up to {exposure_s} s take longer than the camera's `period_s`, {period_s}, expected at most {most_s:.3e}",
        keys.height_px
    );
    Some(("lens.row_time_s", expected))
}

impl Keys<'_> {
    fn floor(camera: &FloorCamera) -> Keys<'_> {
        Keys {
            name: "floor",
            camera: Camera::Floor,
            sensor: &camera.sensor,
            model: camera.sensor_model(),
            lens: &camera.lens,
            height_px: camera.height_px,
        }
    }

    fn forward(camera: &ForwardCamera) -> Keys<'_> {
        Keys {
            name: "forward",
            camera: Camera::Forward,
            sensor: &camera.sensor,
            model: camera.sensor_model(),
            lens: &camera.lens,
            height_px: camera.height_px,
        }
    }

    fn ceiling(camera: &CeilingCamera) -> Keys<'_> {
        Keys {
            name: "ceiling",
            camera: Camera::Ceiling,
            sensor: &camera.sensor,
            model: camera.sensor_model(),
            lens: &camera.lens,
            height_px: camera.height_px,
        }
    }
}
