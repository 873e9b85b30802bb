use interval::Interval;
use localizer::reading::LandmarkId;
use nalgebra::{DMatrix, DVector};

use super::*;

/// A yard with a satellite receiver and a gyroscope.
fn yard() -> Scene {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 12.0\ndepth_m = 8.0\n[start]\nx_m = 2.0\ny_m = 2.0\ntolerance_m = 0.5\n\
                tolerance_deg = 20.0\n[robot]\nfloor_camera = false\ngyro = true\n[robot.gnss]\nforward_m = -0.15\nleft_m = 0.1\n\
                height_m = 0.6\n[localizer]\nmethods = [\"gnss_positions\"]\n[[route.waypoint]]\nx_m = 4.0\ny_m = 2.0\n";
    Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

fn filter(scene: &Scene) -> ExtendedKalmanFilter {
    ExtendedKalmanFilter::of(scene, Tuning::default(), "ekf".to_owned())
}

fn position(measured_s: f64, arrived_s: f64) -> Reading {
    let numbers = vec![2.1 + 0.2 * measured_s, 2.2, 1.0];
    Reading::Other { measured_s, arrived_s, device: "gnss".to_owned(), numbers }
}

/// The filter after a second of wheels and gyroscope, with positions that arrive late by the given time.
fn driven(late_s: f64) -> ExtendedKalmanFilter {
    let mut filter = filter(&yard());
    for step in 0..=100_i64 {
        let time_s = 0.01 * step as f64;
        for half in [0.0, 0.005] {
            let measured_s = time_s - half;
            filter.observe(&Reading::Gyro { measured_s, arrived_s: time_s, rate_rad_per_s: 0.2 });
        }
        filter.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [20 * step, 21 * step] });
        // One position is of the stamp of a reading of the wheels, the other from between two.
        for measured_s in [0.3, 0.4037] {
            let arrived_s = measured_s + late_s;
            if (time_s - 0.01..time_s).contains(&(arrived_s - 1e-9)) {
                filter.observe(&position(measured_s, arrived_s));
            }
        }
    }
    filter
}

#[test]
fn a_late_position_changes_the_belief_as_one_in_time_does() {
    let (in_time, late) = (driven(0.0), driven(0.35));
    assert!((&in_time.belief.mean - &late.belief.mean).amax() < 1e-12, "{} {}", in_time.belief.mean, late.belief.mean);
    assert!((&in_time.belief.covariance - &late.belief.covariance).amax() < 1e-12);
    // Both positions were used: without them the start's tolerance of half a metre would remain.
    assert!(late.belief.covariance[(0, 0)].sqrt() < 0.02, "{}", late.belief.covariance[(0, 0)].sqrt());
}

/// A belief that the robot is within 6 m of the origin along either axis: with a standard deviation of 2 m.
fn wide() -> Belief {
    let filter = filter(&yard());
    let side = Interval::centred(0.0, 6.0);
    Belief::start(&filter.layout, &PoseBox::from([side, side, Interval::centred(0.0, 0.3)]))
}

#[test]
fn a_measurement_weighs_as_the_variances_say() {
    // With the variance 4 of the belief and 1 of the measurement the gain is 4/5 and the variance left is 4/5.
    let mut belief = wide();
    assert!(belief.update(&[vec![(0, 1.0)]], &DVector::from_element(1, 1.0), &DMatrix::identity(1, 1)));
    assert!((belief.mean[0] - 0.8).abs() < 1e-12 && (belief.covariance[(0, 0)] - 0.8).abs() < 1e-12);
    assert!((belief.covariance[(1, 1)] - 4.0).abs() < 1e-12);
}

#[test]
fn a_measurement_beyond_the_99_percent_quantile_is_left_out() {
    // The residual has the variance 4 + 1; the quantile of χ² with one degree of freedom is 6.635, so that the gate is at √33.17 = 5.76.
    for (residual_m, is_used) in [(5.7, true), (5.8, false), (-5.8, false)] {
        let used = wide().update(&[vec![(0, 1.0)]], &DVector::from_element(1, residual_m), &DMatrix::identity(1, 1));
        assert_eq!(used, is_used, "{residual_m}");
    }
}

#[test]
fn a_landmark_that_is_seen_again_ties_the_pose_to_where_it_was_first_seen() {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 6.0\ndepth_m = 6.0\n[start]\nx_m = 3.0\ny_m = 3.0\n[robot]\n\
                floor_camera = false\n[robot.range_camera]\n[localizer]\nmethods = [\"range_landmarks\"]\n[[landmark]]\nx_m = 5.0\ny_m = 3.0\n[[route.waypoint]]\nx_m = 3.5\ny_m = 3.0\n";
    let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let mut filter = filter(&scene);
    let camera = scene.robot_model().range_camera.unwrap();
    // A landmark 2 m straight ahead of the camera, seen before and after a drive of 0.4 m by the wheels that really was one of 0.35 m.
    let sighting = |ahead_m: f64| {
        let disparity_px = camera.focal_px.mid() * camera.baseline_m.mid() / ahead_m;
        localizer::reading::Sighting {
            landmark: LandmarkId(7),
            left_px: camera.centre_px,
            right_px: camera.centre_px - disparity_px,
        }
    };
    let seen = |filter: &mut ExtendedKalmanFilter, measured_s: f64, ahead_m: f64| {
        let sightings = vec![sighting(ahead_m)];
        filter.observe(&Reading::Range { measured_s, arrived_s: measured_s, sightings });
    };
    let per_tick_m = scene.robot_model().wheels.metres_per_tick(0).mid();
    let mut ticks = 0.0;
    for step in 0..=200 {
        let time_s = 0.01 * f64::from(step);
        ticks += if (50..150).contains(&step) { 0.004 / per_tick_m } else { 0.0 };
        filter.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [ticks as i64; 2] });
        if step % 20 == 10 && !(50..150).contains(&step) {
            seen(&mut filter, time_s, if step < 50 { 2.0 } else { 1.65 });
        }
    }
    assert_eq!(filter.belief.landmarks, [7]);
    let moved_m = filter.belief.mean[0] - 3.0;
    assert!((0.35..0.4).contains(&moved_m), "{moved_m} m, between 0.35 m by the landmark and 0.4 m by the wheels");
}
