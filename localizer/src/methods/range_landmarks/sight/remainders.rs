//! What tilts do to sightings: each kind alone, for a sensor and a landmark that are made for it.

use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::graph::{
    Constant,
    trial::{Draw, camera, reach, rounds, tilt},
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

/// Checks that the rows of a sighting hold, in which a landmark appears at the given place ahead and to the left of the sensor, of which `by_mount_m` is
/// what the tilt of the mount alone makes. Truly the landmark is 1 m ahead of it, and all but tilts is exactly known.
fn assert_holds(sensor: &Sensor, [ahead_m, left_m]: [f64; 2], by_mount_m: [f64; 2]) {
    let landmark = LandmarkId(1);
    let left_px = sensor.camera.centre_px - 400.0 * left_m / ahead_m;
    let sighting = Sighting { landmark, left_px, right_px: left_px - 400.0 * 0.12 / ahead_m };
    let sightings = Sightings::new(sensor, &[sighting], Arc::new(RightCodes::new(1, true)), &[]);
    let mut domain = Domain::default();
    let start = PoseBox::from([Interval::ZERO; 3]);
    sightings.quantities(0, &start).into_iter().for_each(|(variable, value)| domain.put(variable, value));
    (0..3).for_each(|axis| domain.put(Variable::Pose(0, axis), Interval::ZERO));
    [1.0, 0.0].into_iter().enumerate().for_each(|(axis, at)| {
        domain.put(Variable::Landmark(landmark, axis), Interval::point(at));
        domain.put(Variable::Constant(Constant::RangePosition(axis)), Interval::ZERO);
    });
    domain.put(Variable::Constant(Constant::RangeYaw), Interval::ZERO);
    domain.put(Variable::Constant(Constant::RangeFocal), Interval::point(400.0));
    domain.put(Variable::Constant(Constant::RangeBaseline), Interval::point(0.12));
    let deviation = |variable: Variable| match variable {
        Variable::TiltedLandmark(_, axis) => {
            assert!(domain.value(variable).contains(by_mount_m[axis]), "{variable:?}");
            by_mount_m[axis]
        }
        _ => 0.0,
    };
    let rows = sightings.rows(0, &domain);
    assert_eq!(rows.len(), 3);
    for row in rows {
        let value = row.value_at(deviation);
        assert!(row.sides.inflate(1e-12).contains(value), "{ahead_m}, {left_m}: {value} not in {}", row.sides);
    }
}

#[test]
fn a_tilted_sensor_sees_a_landmark_at_its_own_height_nearer() {
    // Tilted by 0.1 rad about its left axis, the sensor sees the landmark cos 0.1 = 0.995 m ahead, by 5 mm too near.
    let ahead_m = 0.1_f64.cos();
    assert_holds(&sensor(0.0, 0.1, 0.0), [ahead_m, 0.0], [0.0; 2]);
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
        let by_tilt_m = height_m * sin;
        assert_holds(&sensor(0.0, 0.1, 0.3), [cos + by_tilt_m, 0.0], [by_tilt_m, 0.0]);
        assert_holds(&sensor(0.0, 0.1, 0.3), [1.0, by_tilt_m], [0.0, by_tilt_m]);
        // A tilt of the body does the same, but in another way at each sighting.
        assert_holds(&sensor(0.1, 0.0, 0.3), [cos + by_tilt_m, 0.0], [0.0; 2]);
        assert_holds(&sensor(0.1, 0.0, 0.3), [1.0, by_tilt_m], [0.0; 2]);
    }
    let tilted_m = sensor(0.0, 0.1, 0.3).tilt_displacement([Interval::point(cos + 0.3 * sin), Interval::ZERO]);
    assert!(tilted_m.is_some_and(|tilted_m| tilted_m < 0.3 * sin + 0.011), "{tilted_m:?}");
}

#[test]
fn what_the_mount_alone_makes_is_the_same_at_each_sighting_and_the_rest_is_enclosed() {
    let mut draw = Draw::new(20_261_130);
    let mut nearest = 0.0_f64;
    for round in 0..rounds(100_000) {
        let (body_rad, mount_rad) = (draw.size(1e-4, 0.1), draw.size(1e-4, 0.1));
        let mut sensor = sensor(draw.or_zero(body_rad), draw.or_zero(mount_rad), draw.or_zero(0.3));
        let heave_m = draw.size(1e-5, 0.02);
        sensor.body.heave_m = draw.or_zero(heave_m);
        let position_m = [draw.between(-0.4, 0.4), draw.between(-0.4, 0.4)];
        sensor.camera.position_m = position_m.map(Interval::point);
        let mount = tilt(&mut draw, sensor.camera.tilt_rad).0;
        let lean = tilt(&mut draw, sensor.body.tilt_rad).0;
        // The sensor is on the body, which leans about the origin of the robot frame and heaves.
        let mounted = Vector3::new(position_m[0], position_m[1], sensor.camera.height_m);
        let heave_m = draw.within(Interval::centred(0.0, sensor.body.heave_m));
        let rises_m = (lean * mounted).z + heave_m - sensor.camera.height_m;
        let height_m = draw.within(Interval::centred(0.0, sensor.camera.height_span_m));
        let (away_m, towards) = (draw.size(0.3, 6.0), draw.between(-3.0, 3.0));
        let landmark = Vector3::new(away_m * towards.cos(), away_m * towards.sin(), height_m - rises_m);
        let seen = mount.inverse() * (lean.inverse() * landmark);
        let by_mount = mount.inverse() * Vector3::new(0.0, 0.0, height_m);
        // The heading is that of the forward axis of the body.
        let ahead = lean * Vector3::x();
        let turned = Rotation3::new(Vector3::new(0.0, 0.0, -ahead.y.atan2(ahead.x)));
        let truly = turned * landmark;
        let left_m = (seen - by_mount - truly).xy().norm();
        let blur_m: f64 = sensor.blur_m([seen.x, seen.y].map(Interval::point)).unwrap().iter().sum();
        assert!(left_m <= blur_m + 1e-11, "round {round}: {left_m} of {blur_m}, {sensor:?}");
        assert!(by_mount.xy().norm() <= sensor.mount_displacement_m() + 1e-12, "round {round}");
        if blur_m > 1e-6 {
            nearest = nearest.max(left_m / blur_m);
        }
    }
    assert!(nearest > 0.9, "{nearest}");
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
