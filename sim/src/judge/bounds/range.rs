//! The range camera against what was drawn and what was true.

use std::collections::BTreeMap;

use localizer::{bounds, reading::LandmarkId};

use crate::{
    run::RunRecord,
    scene::{MethodName, RangeCamera, Scene},
};

use super::{Monitor, constant};

/// The difference of two times of minutes has lost some digits.
const ROUNDING_S: f64 = 1e-9;

/// The bounds of the range camera.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (Some(camera), Some(mount)) = (&scene.robot.range_camera, &record.drawn.range_camera) else {
        return Vec::new();
    };
    if !scene.localizer.methods.contains(&MethodName::RangeLandmarks) {
        return Vec::new();
    }
    let position_error_m =
        (mount.position_m[0] - camera.forward_m).abs().max((mount.position_m[1] - camera.left_m).abs());
    let farthest_m =
        scene.landmarks.iter().map(|landmark| (landmark.height_m - camera.height_m).abs()).fold(0.0, f64::max);
    let focal_error_px = (mount.focal_px - camera.focal_px).abs();
    let baseline_error_m = (mount.baseline_m - camera.baseline_m).abs();
    let yaw_error_rad = (mount.yaw_rad - camera.yaw_deg.to_radians()).abs();
    let tilt_rad = mount.tilt_rad[0].hypot(mount.tilt_rad[1]);
    let mut all = vec![
        constant(record, bounds::RANGE_CAMERA_FOCAL, camera.focal_px * camera.focal_tolerance, focal_error_px),
        constant(
            record,
            bounds::RANGE_CAMERA_BASELINE,
            camera.baseline_m * camera.baseline_tolerance,
            baseline_error_m,
        ),
        constant(record, bounds::RANGE_CAMERA_POSITION, camera.position_tolerance_m, position_error_m),
        constant(record, bounds::RANGE_CAMERA_YAW, camera.yaw_tolerance_deg.to_radians(), yaw_error_rad),
        constant(record, bounds::RANGE_CAMERA_TILT, camera.tilt_tolerance_deg.to_radians(), tilt_rad),
        constant(record, bounds::RANGE_CAMERA_HEIGHT_SPAN, camera.height_span_m, farthest_m),
    ];
    let (mut stamp, mut latency) =
        (Monitor::new(bounds::RANGE_CAMERA_STAMP), Monitor::new(bounds::RANGE_CAMERA_LATENCY));
    for reading in record.images.iter().filter(|reading| reading.method == "range_landmarks") {
        let span_s = [reading.truth.time_s, reading.arrived_s];
        stamp.watch(span_s, camera.stamp_tolerance_s, (reading.measured_s - reading.truth.time_s).abs());
        let late_s = reading.arrived_s - reading.truth.time_s - camera.latency_s;
        latency.watch(span_s, camera.latency_tolerance_s + ROUNDING_S, late_s.abs());
    }
    let mut columns = Monitor::new(bounds::RANGE_CAMERA_COLUMNS);
    for (span_s, noise_px) in &record.motion_sensors.range_noise_px {
        columns.watch(*span_s, camera.column_noise_px, *noise_px);
    }
    all.extend([stamp, latency, columns]);
    all.extend(wrong_codes(record, camera));
    all
}

/// Codes given wrongly: how many in a reading, and how many right uses of a code are missing between two wrong ones; none is the bound.
fn wrong_codes(record: &RunRecord, camera: &RangeCamera) -> [Monitor; 2] {
    let (q_items, wrong_spacing) = (camera.q_items, camera.wrong_spacing);
    let (mut items, mut spacing) =
        (Monitor::new(bounds::RANGE_LANDMARKS_Q_ITEMS), Monitor::new(bounds::RANGE_LANDMARKS_WRONG_SPACING));
    // Right uses of each code since its last wrong one.
    let mut right_since: BTreeMap<LandmarkId, usize> = BTreeMap::new();
    let (mut drive_began_s, mut before_s) = (0.0, 0.0);
    // Bounds are on the order in which readings were taken; in which they arrive is another matter.
    let mut readings: Vec<_> = record.images.iter().filter(|reading| reading.method == "range_landmarks").collect();
    readings.sort_by(|a, b| a.truth.time_s.total_cmp(&b.truth.time_s));
    for reading in readings {
        let span_s = [reading.truth.time_s, reading.arrived_s];
        // Put elsewhere, a robot starts with sensors that remember nothing.
        let began_s = record.restarts.iter().filter_map(|index| record.truths.get(*index)).map(|truth| truth.time_s);
        let latest_s = began_s.take_while(|began_s| *began_s <= reading.truth.time_s).fold(0.0, f64::max);
        if latest_s > drive_began_s {
            drive_began_s = latest_s;
            right_since.clear();
        }
        // What the run ended before it arrived may have used any code rightly.
        if reading.truth.time_s - before_s > 1.5 * camera.period_s {
            right_since.clear();
        }
        before_s = reading.truth.time_s;
        let n_wrong = reading.codes.iter().filter(|(_, is_own)| !is_own).count();
        items.watch(span_s, q_items as f64, n_wrong as f64);
        for (code, is_own) in &reading.codes {
            if *is_own {
                right_since.entry(*code).and_modify(|count| *count += 1);
            // Where no match is said to be wrong, nothing is said of how far apart wrong ones are.
            } else if let Some(count) = right_since.insert(*code, 0).filter(|_| q_items > 0) {
                spacing.watch(span_s, 0.0, wrong_spacing.saturating_sub(count) as f64);
            }
        }
    }
    [items, spacing]
}
