//! Contradictions about cameras: exposures that do not fit between two images, shutters that a method does not allow for, and black levels that leave
//! no grey levels for light.

use crate::{
    loading::contradiction::Contradiction,
    scene::{CameraKeys, Scene, SharedKeys},
};
use localizer::reading::Camera;

/// Tolerance for rounding when times are compared: sums like 0.0335 + 479 · 10⁻⁵ are not exact, and nobody states a period that finely.
const ROUNDING_S: f64 = 1e-9;

/// All contradictions in `scene` about its cameras' exposures, shutters and black levels.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let shows_landmarks = scene.localizer.methods.iter().any(|name| scene.robot.shows_landmarks(*name));
    let row_time_s = scene.robot.forward_camera.as_ref().map_or(0.0, |camera| camera.lens.row_time_s);
    if shows_landmarks && row_time_s > 0.0 {
        let expected =
            "the method `mapped_landmarks` takes all rows of an image to be exposed at once, expected 0".to_owned();
        found.push(Contradiction { key: "robot.forward_camera.lens.row_time_s".to_owned(), expected });
    }
    for camera in Camera::ALL.into_iter().filter_map(|name| scene.robot.camera(name)) {
        let problems = [
            exposure_problem(camera),
            black_level_problem(camera),
            period_problem(camera),
            turning_exposure_problem(camera),
        ];
        found.extend(problems.into_iter().flatten().map(|(key, expected)| Contradiction {
            key: format!("robot.{}_camera.{key}", camera.name().as_str()),
            expected,
        }));
    }
}

fn turning_exposure_problem(camera: &dyn CameraKeys) -> Option<(&'static str, String)> {
    let longest_s = camera.sensor_model().longest_exposure_s;
    let is_too_long = camera.turning_exposure_s().is_some_and(|turning_s| turning_s > longest_s);
    let expected = || format!("expected at most the longest exposure, which is {longest_s}");
    is_too_long.then(|| ("turning_exposure_s", expected()))
}

fn exposure_problem(camera: &dyn CameraKeys) -> Option<(&'static str, String)> {
    let sensor = camera.shared().sensor;
    let (fixed_s, longest_s) = sensor.exposure_s.zip(sensor.longest_exposure_s)?;
    let expected = || format!("expected at most `longest_exposure_s`, which is {longest_s}");
    (fixed_s > longest_s).then(|| ("sensor.exposure_s", expected()))
}

fn black_level_problem(camera: &dyn CameraKeys) -> Option<(&'static str, String)> {
    let model = camera.sensor_model();
    let greatest = model.bits.greatest_level();
    let expected = || {
        let bits = model.bits.bits();
        format!("leaves no level for light, expected less than {greatest}, the greatest level of {bits} bits")
    };
    (model.black_level >= f64::from(greatest)).then(|| ("sensor.black_level", expected()))
}

/// Checks that one image is read out before the next is exposed, as in sensors whose rows share their circuits.
fn period_problem(camera: &dyn CameraKeys) -> Option<(&'static str, String)> {
    let (timing, model, SharedKeys { size_px: [_, height_px], lens, .. }) =
        (camera.timing(), camera.sensor_model(), camera.shared());
    let (period_s, exposure_s) = (timing.period_s, model.longest_exposure_s);
    if timing.longest_s <= period_s + ROUNDING_S {
        return None;
    }
    if exposure_s > period_s + ROUNDING_S || lens.row_time_s == 0.0 {
        let key = if model.is_fixed { "sensor.exposure_s" } else { "sensor.longest_exposure_s" };
        let expected = format!(
            "{exposure_s} s is longer than the camera's `period_s`, expected at most {period_s}, from image to image"
        );
        return Some((key, expected));
    }
    let most_s = (period_s - exposure_s).max(0.0) / f64::from(height_px - 1);
    let expected = format!(
        "{height_px} rows after an exposure of up to {exposure_s} s take longer than the camera's `period_s`, {period_s}, expected at most {most_s:.3e}"
    );
    Some(("lens.row_time_s", expected))
}
