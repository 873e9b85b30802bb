//! What tilts do to sightings: each kind alone, for a sensor and a landmark that are made for it.

use super::*;
use crate::graph::{
    Constant,
    trial::{camera, reach},
};

/// A sensor at the robot's origin that reads columns exactly, with the greatest tilts of body and mount and a height span.
fn sensor(body_rad: f64, mount_rad: f64, height_span_m: f64) -> Sensor {
    let exact = RangeCameraModel {
        focal_px: Interval::point(400.0),
        baseline_m: Interval::point(0.12),
        step_px: [0.0; 2],
        tilt_rad: mount_rad,
        height_span_m,
        ..camera()
    };
    Sensor { camera: exact, body: BodyModel { tilt_rad: body_rad, heave_m: 0.0, clearance_m: 0.1 }, reach: reach() }
}

/// Checks that the rows of a sighting hold, in which a landmark appears at the given place ahead and to the left of the sensor. Truly the landmark
/// is 1 m ahead of it, and all but tilts is exactly known, so that no term is left of the rows.
fn assert_holds(sensor: &Sensor, [ahead_m, left_m]: [f64; 2]) {
    let landmark = LandmarkId(1);
    let mut domain = Domain::default();
    (0..3).for_each(|axis| domain.put(Variable::Pose(0, axis), Interval::ZERO));
    [1.0, 0.0].into_iter().enumerate().for_each(|(axis, at)| {
        domain.put(Variable::Landmark(landmark, axis), Interval::point(at));
        domain.put(Variable::Constant(Constant::RangePosition(axis)), Interval::ZERO);
    });
    domain.put(Variable::Constant(Constant::RangeYaw), Interval::ZERO);
    domain.put(Variable::Constant(Constant::RangeFocal), Interval::point(400.0));
    domain.put(Variable::Constant(Constant::RangeBaseline), Interval::point(0.12));
    let left_px = sensor.camera.centre_px - 400.0 * left_m / ahead_m;
    let sighting = Sighting { landmark, left_px, right_px: left_px - 400.0 * 0.12 / ahead_m };
    let rows = Sightings::new(sensor, &[sighting], Arc::new(RightCodes::new(1, true))).rows(0, &domain);
    assert_eq!(rows.len(), 3);
    for row in rows {
        assert!(row.terms.is_empty() && row.sides.inflate(1e-12).contains(0.0), "{ahead_m}, {left_m}: {}", row.sides);
    }
}

#[test]
fn a_tilted_sensor_sees_a_landmark_at_its_own_height_nearer() {
    // Tilted by 0.1 rad about its left axis, the sensor sees the landmark cos 0.1 = 0.995 m ahead, by 5 mm too near.
    let ahead_m = 0.1_f64.cos();
    assert_holds(&sensor(0.0, 0.1, 0.0), [ahead_m, 0.0]);
    // 0.1² of the distance is allowed for, as two tilts may move it in any direction.
    let tilted_m = sensor(0.0, 0.1, 0.0).tilt_displacement([Interval::point(ahead_m), Interval::ZERO]);
    assert!(tilted_m.is_some_and(|tilted_m| tilted_m < 0.0102), "{tilted_m:?}");
}

#[test]
fn a_tilted_sensor_sees_a_landmark_above_or_below_it_displaced() {
    // The landmark is 0.3 m above the sensor or below it. Tilted by 0.1 rad about its left axis, the sensor sees it 0.3 m · sin 0.1 = 30 mm farther
    // or nearer, and 5 mm nearer besides; tilted about its forward axis, 30 mm to the side.
    let (sin, cos) = 0.1_f64.sin_cos();
    for height_m in [0.3, -0.3] {
        assert_holds(&sensor(0.0, 0.1, 0.3), [cos + height_m * sin, 0.0]);
        assert_holds(&sensor(0.0, 0.1, 0.3), [1.0, height_m * sin]);
        // A tilt of the body does the same.
        assert_holds(&sensor(0.1, 0.0, 0.3), [cos + height_m * sin, 0.0]);
    }
    let tilted_m = sensor(0.0, 0.1, 0.3).tilt_displacement([Interval::point(cos + 0.3 * sin), Interval::ZERO]);
    assert!(tilted_m.is_some_and(|tilted_m| tilted_m < 0.3 * sin + 0.011), "{tilted_m:?}");
}

#[test]
fn a_leaning_body_displaces_the_mount_by_its_height_and_by_its_place() {
    // The mount is 0.3 m high. A lean of 0.1 rad moves it by 0.3 m · sin 0.1 = 30 mm; and where it is 0.2 m ahead of the origin, a lean backward
    // moves it back by 0.2 m · (1 − cos 0.1) = 1 mm more.
    let (sin, cos) = 0.1_f64.sin_cos();
    let mut sensor = sensor(0.1, 0.0, 0.0);
    for position_m in [0.0, 0.2] {
        sensor.camera.position_m[0] = Interval::point(position_m);
        let shift_m = sensor.shift_m(&Stray::default());
        let moved_m = 0.3 * sin + position_m * (1.0 - cos);
        assert!((moved_m..=moved_m + 0.0011).contains(&shift_m), "{shift_m} for {moved_m}");
    }
}
