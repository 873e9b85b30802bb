//! Histories made by hand: one keeps every bound, and for each bound another breaks it by a hair.

mod codes;
mod drive;
mod flow;
mod images;
mod walls;

use std::f64::consts::TAU;

use interval::Interval;
use localizer::{Pose, bounds};

use super::{
    ReadingLog,
    history::{History, Looker, Quantity},
    kind::Kind,
    perceived::{MISPERCEIVED, Perceived},
    readings::Readings,
    search::{TRUTH_SLACK, check, search},
};
use crate::{
    run::{RunOptions, run_witnessed},
    scene::Distribution,
    subject::IntervalLocalizer,
};
use drive::{Drive, N_STEPS, SPEED_M_PER_S, STEP_S, TURN_RAD_PER_S, scene};

/// Share by which a value is put beyond its bound, far above rounding.
const HAIR: f64 = 1e-6;

#[test]
fn a_history_without_errors_keeps_every_bound() {
    assert_eq!(Drive::on_circle(&[50, 100]).broken_by(|_| {}), None);
}

#[test]
fn a_history_with_more_false_claims_than_declared_is_refused() {
    let history = Drive::on_circle(&[]).history;
    let of = |exceeded_s: &[f64]| Perceived { exceeded_s: exceeded_s.to_vec() }.check(&history, 0.0);
    assert!(of(&[]).is_ok());
    let broken = of(&[0.4, 0.6]).unwrap_err();
    assert_eq!((broken.bound, broken.time_s, broken.value), (MISPERCEIVED, 0.4, Interval::point(2.0)));
}

#[test]
fn a_constant_a_hair_beyond_its_bound_is_refused_by_name() {
    let drive = Drive::on_circle(&[50]);
    let camera = drive.robot.range_camera.clone().unwrap();
    let gyro = drive.robot.gyro.unwrap();
    let cases = [
        (Quantity::WheelRadius(1), drive.robot.wheels.radius_m[1].hi(), bounds::WHEELS_RADIUS),
        (Quantity::Track, drive.robot.wheels.track_m.hi(), bounds::WHEELS_TRACK),
        (Quantity::GyroBias, gyro.bias_rad_per_s.hi(), bounds::GYRO_BIAS),
        (Quantity::GyroScale, gyro.scale.hi(), bounds::GYRO_SCALE),
        (Quantity::RangePosition(0), camera.position_m[0].hi(), bounds::RANGE_CAMERA_POSITION),
        (Quantity::RangeYaw, camera.yaw_rad.hi(), bounds::RANGE_CAMERA_YAW),
        (Quantity::RangeTilt(1), camera.tilt_rad, bounds::RANGE_CAMERA_TILT),
        (Quantity::RangeFocal, camera.focal_px.hi(), bounds::RANGE_CAMERA_FOCAL),
        (Quantity::RangeBaseline, camera.baseline_m.hi(), bounds::RANGE_CAMERA_BASELINE),
        (Quantity::Landmark(7, 2), camera.height_m + camera.height_span_m, bounds::RANGE_CAMERA_HEIGHT_SPAN),
        (Quantity::BodyTilt(50, 0), drive.robot.body.tilt_rad, bounds::BODY_TILT),
        (Quantity::Heave(50), drive.robot.body.heave_m, bounds::BODY_HEAVE),
    ];
    for (quantity, greatest, bound) in cases {
        let put = |value: f64| {
            move |history: &mut History| {
                history.quantities.insert(quantity, value);
            }
        };
        assert_eq!(drive.broken_by(put(greatest * (1.0 + HAIR))), Some(bound), "{quantity:?}");
        // Within its own bound a constant may break that of the readings, but never its own.
        assert_ne!(drive.broken_by(put(greatest * (1.0 - HAIR))), Some(bound), "{quantity:?}");
    }
    // Both components of a tilt are within the bound, and their vector is not.
    let both = drive.broken_by(|history| {
        for axis in 0..2 {
            history.quantities.insert(Quantity::RangeTilt(axis), 0.8 * camera.tilt_rad);
        }
    });
    assert_eq!(both, Some(bounds::RANGE_CAMERA_TILT));
}

/// Moves the robot along (0) or across (1) its heading at every stamp from `from` to `to`, by a distance that grows linearly to `by_m` and stays.
fn pushed(history: &mut History, axis: usize, from: usize, to: usize, by_m: f64) {
    for stamp in from..history.poses.len() {
        let share = ((stamp - from) as f64 / (to - from) as f64).min(1.0);
        let heading_rad = history.poses[(from + to) / 2].heading_rad;
        let direction =
            if axis == 0 { [heading_rad.cos(), heading_rad.sin()] } else { [-heading_rad.sin(), heading_rad.cos()] };
        history.poses[stamp].x_m += share * by_m * direction[0];
        history.poses[stamp].y_m += share * by_m * direction[1];
    }
}

#[test]
fn slip_a_hair_beyond_its_bound_over_one_window_is_refused_and_less_is_not() {
    // Without looks, so that no sighting has a say. The window of 0.2 s is 20 steps.
    let drive = Drive::on_circle(&[]);
    let wheels = &drive.robot.wheels;
    let track_m = wheels.track_m.mid();
    let slowest_m = (SPEED_M_PER_S - 0.5 * track_m * TURN_RAD_PER_S) * 20.0 * STEP_S;
    let most_m = wheels.slip_ratio * slowest_m + wheels.slip_floor_m;
    // The direction of the push is that of the window's middle. At its ends it is 0.03 rad off, which takes 5e-4 of it.
    let push = |by_m: f64| drive.broken_by(|history| pushed(history, 0, 60, 80, by_m));
    assert_eq!(push(most_m * 1.001), Some(bounds::WHEELS_SLIP));
    assert_eq!(push(-most_m * 1.001), Some(bounds::WHEELS_SLIP));
    assert_eq!(push(most_m * 0.999), None);

    let rolled_m = SPEED_M_PER_S * 20.0 * STEP_S;
    let most_m = wheels.side_slip_ratio * rolled_m + wheels.side_slip_floor_m;
    let push = |by_m: f64| drive.broken_by(|history| pushed(history, 1, 60, 80, by_m));
    assert_eq!(push(most_m * 1.001), Some(bounds::WHEELS_SIDE_SLIP));
    assert_eq!(push(most_m * 0.999), None);
    // Over twice the window the same push is allowed, and twice as much is refused.
    assert_eq!(drive.broken_by(|history| pushed(history, 1, 60, 100, most_m * 1.9)), None);
    assert_eq!(drive.broken_by(|history| pushed(history, 1, 60, 100, most_m * 2.01)), Some(bounds::WHEELS_SIDE_SLIP));
}

#[test]
fn a_wheel_that_turned_by_more_than_a_tick_than_it_counted_is_refused() {
    let drive = Drive::on_circle(&[]);
    let tick_rad = TAU / drive.robot.wheels.ticks_per_turn;
    // The phase is free within a tick, so that 0.9 ticks at one stamp may be too much for the others, and 1.1 ticks always are.
    assert_eq!(
        drive.broken_by(|history| history.wheel_angle_rad[70][0] += 1.1 * tick_rad),
        Some("ticks of the wheels")
    );
}

/// Turns the robot on the spot at every stamp, as a function of the stamp's time.
fn turned(history: &mut History, by_rad: impl Fn(f64) -> f64) {
    for (pose, time_s) in history.poses.iter_mut().zip(&history.stamps_s) {
        pose.heading_rad += by_rad(*time_s);
    }
}

#[test]
fn gyroscope_noise_a_hair_beyond_its_bounds_is_refused() {
    let drive = Drive::on_circle(&[]);
    let gyro = drive.robot.gyro.unwrap();
    let broken_by = |by_rad: &dyn Fn(f64) -> f64| {
        let mut changed = drive.history.clone();
        turned(&mut changed, by_rad);
        drive.gyro().check(&changed, 0.0).err().map(|broken| broken.bound)
    };
    // One reading of 10 ms is off; the angle it makes is far below the bound on the angle.
    let jump_rad = gyro.noise_rad_per_s * STEP_S;
    assert!(jump_rad < gyro.angle_floor_rad);
    assert_eq!(broken_by(&|time_s| if time_s > 0.905 { jump_rad * 1.0001 } else { 0.0 }), Some(bounds::GYRO_NOISE));
    assert_eq!(broken_by(&|time_s| if time_s > 0.905 { jump_rad * 0.9999 } else { 0.0 }), None);
    // A steady rate from 0.5 s to 1.5 s: the floor and one second of growth are the most.
    let most_rad = gyro.angle_floor_rad + gyro.angle_rad_per_s;
    assert!(most_rad < gyro.noise_rad_per_s);
    let ramp = |rate: f64| move |time_s: f64| rate * (time_s - 0.5).clamp(0.0, 1.0);
    assert_eq!(broken_by(&ramp(most_rad * 1.0001)), Some(bounds::GYRO_ANGLE));
    assert_eq!(broken_by(&ramp(-most_rad * 1.0001)), Some(bounds::GYRO_ANGLE));
    assert_eq!(broken_by(&ramp(most_rad * 0.9999)), None);
}

#[test]
fn a_column_a_hair_outside_its_cell_is_refused() {
    let drive = Drive::on_circle(&[50]);
    let camera = drive.robot.range_camera.clone().unwrap();
    // A change of the yaw by δ moves a column u by f·(1 + u²/f²)·δ, to first order.
    let sighting = drive.range().looks[0].sightings[0];
    let focal_px = camera.focal_px.mid();
    let most_slope = [sighting.left_px, sighting.right_px]
        .map(|column_px| focal_px * (1.0 + ((column_px - camera.centre_px) / focal_px).powi(2)));
    let other = drive.range().looks[0].sightings[1];
    let slopes = [other.left_px, other.right_px]
        .map(|column_px| focal_px * (1.0 + ((column_px - camera.centre_px) / focal_px).powi(2)));
    let slope = most_slope.into_iter().chain(slopes).fold(0.0, f64::max);
    let most_rad = 0.5 * camera.step_px[0] / slope;
    assert!(most_rad < camera.yaw_rad.hi());
    let yawed = |by_rad: f64| {
        drive.broken_by(|history| {
            history.quantities.insert(Quantity::RangeYaw, by_rad);
        })
    };
    assert_eq!(yawed(most_rad * 1.002), Some(bounds::RANGE_CAMERA_COLUMNS));
    assert_eq!(yawed(-most_rad * 1.002), Some(bounds::RANGE_CAMERA_COLUMNS));
    assert_eq!(yawed(most_rad * 0.998), None);
    // An instant that is farther from the stamp than declared.
    let late = drive.broken_by(|history| {
        let instant_s = history.stamps_s[50] + camera.stamp_error_s * 1.0001;
        history.quantities.insert(Quantity::Instant(Looker::Range, 50), instant_s);
    });
    assert_eq!(late, Some(bounds::RANGE_CAMERA_STAMP));
}

#[test]
fn motion_beyond_its_bounds_is_refused() {
    let drive = Drive::on_circle(&[]);
    let check_motion = |change: &dyn Fn(&mut History)| {
        let mut changed = drive.history.clone();
        change(&mut changed);
        drive.motion().check(&changed, 0.0).err().map(|broken| broken.bound)
    };
    let reach = drive.robot.reach;
    assert_eq!(check_motion(&|history| history.poses[0].x_m += 1e-9), Some("start"));
    let too_far_m = (reach.speed_m_per_s + SPEED_M_PER_S) * STEP_S;
    assert_eq!(check_motion(&|history| pushed(history, 0, 60, 61, too_far_m)), Some(bounds::REACH_SPEED));
    let too_much_rad = (reach.turn_rate_rad_per_s - TURN_RAD_PER_S) * STEP_S * 1.0001;
    let turn =
        |by_rad: f64| move |history: &mut History| turned(history, |time_s| if time_s > 0.5 { by_rad } else { 0.0 });
    assert_eq!(check_motion(&turn(too_much_rad)), Some(bounds::REACH_TURN_RATE));
    assert_eq!(check_motion(&turn(too_much_rad * 0.999)), None);
    let mut by_wall = drive.motion();
    by_wall.room_m[0] = Interval::new(2.0 - drive.robot.body.clearance_m + 1e-9, 5.0);
    assert_eq!(by_wall.check(&drive.history, 0.0).unwrap_err().bound, bounds::ROOM_WALLS);
    // A wheel's travel that changes its speed by more than declared, with wheels whose slip is hardly bounded.
    let mut wheels = drive.wheels();
    wheels.model.slip_floor_m = 1.0;
    wheels.model.side_slip_floor_m = 1.0;
    let mut jerked = drive.history.clone();
    pushed(&mut jerked, 0, 60, 61, reach.acceleration_m_per_s2 * STEP_S * STEP_S * 1.01);
    assert_eq!(wheels.check(&jerked, 0.0).unwrap_err().bound, bounds::REACH_ACCELERATION);
}

/// The truth of a run with every error at an end of its tolerance, at two instants of it.
#[test]
fn the_truth_of_a_corner_run_is_a_witness_of_itself() {
    for errors in [Distribution::Corner, Distribution::Uniform] {
        let mut scene = scene();
        scene.duration_s = 3.0;
        scene.robot.errors = errors;
        let mut log = ReadingLog::default();
        let mut subject = IntervalLocalizer::of(&scene);
        let options = RunOptions::default();
        let record = run_witnessed(&scene, 3, &mut subject, None, &options, &mut log, &mut |_| {}).unwrap();
        let readings = Readings::of(&scene, &record, &log);
        for step in [120, 300] {
            let (truth, kinds) = readings.until(record.truths[step].time_s).unwrap();
            assert_eq!(check(&truth, &kinds, TRUTH_SLACK), Ok(()), "{errors:?}");
            assert!(truth.stamps_s.len() > step && kinds.len() == 5);
        }
    }
}

/// Two seconds of wheels alone with a known start: the distance along x is off by 0.2 % of radius, 0.5 % of slip, 0.1 mm for each of ten windows
/// and a tick of 0.03 mm, so that with 0.4 m the farthest histories are 2·(0.0008 + 0.002 + 0.001 + 0.00003) m apart. None can be farther; the search
/// finds nearly that.
#[test]
fn the_farthest_witnesses_of_a_straight_drive_are_where_its_bounds_say() {
    let mut drive = Drive::on_circle(&[]);
    for (stamp, pose) in drive.history.poses.iter_mut().enumerate() {
        *pose = Pose { x_m: 1.0 + SPEED_M_PER_S * stamp as f64 * STEP_S, y_m: 1.0, heading_rad: 0.0 };
        let angle_rad = (pose.x_m - 1.0) / drive.robot.wheels.radius_m[0].mid();
        drive.history.wheel_angle_rad[stamp] = [angle_rad; 2];
    }
    let wheels = &drive.robot.wheels;
    let way_m = SPEED_M_PER_S * N_STEPS as f64 * STEP_S;
    let tick_m = TAU * wheels.radius_m[0].mid() / wheels.ticks_per_turn;
    let radius_share = wheels.radius_m[0].radius() / wheels.radius_m[0].mid();
    let most_m =
        way_m * (radius_share * (1.0 + wheels.slip_ratio) + wheels.slip_ratio) + 10.0 * wheels.slip_floor_m + tick_m;
    let kinds: Vec<Box<dyn Kind>> = vec![Box::new(drive.motion()), Box::new(drive.wheels())];
    let found = search(&drive.history, &kinds, [0.05, 0.05, 0.1]).unwrap();
    let width_m = found.spanned[0].width();
    assert!(width_m < 2.0 * most_m && width_m > 0.95 * 2.0 * most_m, "{width_m} of {}", 2.0 * most_m);
}
