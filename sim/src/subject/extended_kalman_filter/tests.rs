use interval::Interval;
use localizer::reading::LandmarkId;
use nalgebra::{DMatrix, DVector};

use super::*;

/// A yard with a satellite receiver and a gyroscope.
pub(super) fn yard() -> Scene {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 12.0\ndepth_m = 8.0\n[start]\nx_m = 2.0\ny_m = 2.0\ntolerance_m = 0.5\n\
                tolerance_deg = 20.0\n[robot]\nfloor_camera = false\ngyro = true\n[robot.gnss]\nforward_m = -0.15\nleft_m = 0.1\n\
                height_m = 0.6\n[localizer]\nmethods = [\"gnss_positions\"]\n[[route.waypoint]]\nx_m = 4.0\ny_m = 2.0\n";
    Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

pub(super) fn filter(scene: &Scene) -> ExtendedKalmanFilter {
    ExtendedKalmanFilter::of(scene, FilterNoise::default(), "ekf".to_owned())
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
pub(super) fn wide() -> Belief {
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
fn a_measurement_beyond_three_standard_deviations_is_left_out() {
    // The residual has the variance 4 + 1, so that the gate is at 3·√5 = 6.708.
    for (residual_m, is_used) in [(6.7, true), (6.72, false), (-6.72, false)] {
        let used = wide().update(&[vec![(0, 1.0)]], &DVector::from_element(1, residual_m), &DMatrix::identity(1, 1));
        assert_eq!(used, is_used, "{residual_m}");
    }
}

#[test]
fn an_error_that_lasts_is_forgotten_over_a_metre_while_its_variance_stays() {
    let filter = filter(&yard());
    let mut belief = filter.belief.clone();
    let [slip, ..] = filter.layout.slip;
    let variance = belief.covariance[(slip, slip)];
    // Known exactly, and related to x as closely as can be.
    let x_m2 = belief.covariance[(0, 0)];
    belief.mean[slip] = 0.01;
    belief.covariance[(slip, slip)] = 0.0;
    belief.covariance[(0, slip)] = 1e-4;
    belief.covariance[(slip, 0)] = 1e-4;
    (0..10).for_each(|_| belief.change(&filter.layout, 0.1));
    assert!((belief.mean[slip] - 0.01 / std::f64::consts::E).abs() < 1e-15, "{}", belief.mean[slip]);
    assert!((belief.covariance[(slip, slip)] - variance * (1.0 - (-2.0_f64).exp())).abs() < 1e-12 * variance);
    assert!((belief.covariance[(0, slip)] - 1e-4 / std::f64::consts::E).abs() < 1e-17);
    assert_eq!((belief.covariance[(0, slip)], belief.covariance[(0, 0)]), (belief.covariance[(slip, 0)], x_m2));
    belief.change(&filter.layout, 100.0);
    assert!((belief.covariance[(slip, slip)] - variance).abs() < 1e-12 * variance && belief.mean[slip].abs() < 1e-15);
}

#[test]
fn counts_of_the_flow_sensor_err_by_one_rounding_a_window_and_more_where_the_robot_may_have_turned_back() {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 6.0\ndepth_m = 6.0\n[start]\nx_m = 1.0\ny_m = 3.0\n[robot]\nfloor_camera = false\n\
                flow = true\n[localizer]\nmethods = []\n[[route.waypoint]]\nx_m = 3.0\ny_m = 3.0\n";
    let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let filter = filter(&scene);
    let flow = filter.robot.flow.unwrap();
    let (window_s, tuning) = (filter.robot.wheels.slip_window_s, FilterNoise::default());
    let variance_m2 = |span_s: f64, flowed_m: f64| {
        let step =
            Step { stamp_s: 1.0, span_s, rolled_m: [flowed_m; 2], turned: None, flowed_m: Some([flowed_m, 0.0]) };
        moved::Moved::of(&step, &filter.belief.mean, &filter.layout, &filter.robot, &tuning).noise[(0, 0)]
    };
    // A third of half a count, squared, for a whole window; a tenth of it for a step of a tenth of the window.
    let rounding_m2 = (0.5 * flow.quantisation_counts * flow.metres_per_count.mid() / 3.0).powi(2);
    for share in [1.0, 0.1] {
        let got_m2 = variance_m2(share * window_s, 0.01);
        assert!((got_m2 - share * rounding_m2).abs() < 1e-9 * rounding_m2, "{got_m2} {rounding_m2}");
    }
    let more_m2 = variance_m2(window_s, 0.5 * flow.back_and_forth_m) - rounding_m2;
    assert!((more_m2 - (flow.back_and_forth_m / 3.0).powi(2)).abs() < 1e-9 * more_m2, "{more_m2}");
    assert!((variance_m2(window_s, 0.0) - rounding_m2).abs() < 1e-9 * rounding_m2);
}

#[test]
fn wheels_that_turn_further_than_the_floor_goes_by_are_explained_by_all_that_can_make_it_so() {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 6.0\ndepth_m = 6.0\n[start]\nx_m = 1.0\ny_m = 3.0\n[robot]\nfloor_camera = false\n\
                gyro = true\nflow = true\n[localizer]\nmethods = []\n[[route.waypoint]]\nx_m = 3.0\ny_m = 3.0\n";
    let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let mut filter = filter(&scene);
    let per_tick_m = scene.robot_model().wheels.metres_per_tick(0).mid();
    let per_count_m = scene.robot_model().flow.unwrap().metres_per_count.mid();
    // Four metres straight ahead by the flow sensor; the wheels turn 0.4 % further.
    for step in 0..=1000 {
        let (time_s, way_m) = (0.01 * f64::from(step), 0.004 * f64::from(step));
        filter.observe(&Reading::Gyro { measured_s: time_s, arrived_s: time_s, rate_rad_per_s: 0.0 });
        let counts = [(way_m / per_count_m) as i64, 0];
        filter.observe(&Reading::Flow { measured_s: time_s, arrived_s: time_s, counts, blind_periods: 0 });
        let ticks = [(1.004 * way_m / per_tick_m) as i64; 2];
        filter.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks });
    }
    let (layout, belief) = (&filter.layout, &filter.belief);
    let ([left, right, _], [left_slip, right_slip, _]) = (layout.wheels, layout.slip);
    let [scale, change, _] = layout.flow.unwrap();
    let share = |places: &[usize]| places.iter().map(|place| belief.mean[*place]).sum::<f64>();
    let by_wheels = 1.004 * (1.0 + 0.5 * share(&[left, right, left_slip, right_slip]));
    let by_flow = 1.0 + share(&[scale, change]);
    // What is left of the 0.4 % is put down to the windows' own noise: ticks, and the floor of the slip's bound.
    assert!((by_wheels - by_flow).abs() < 1e-3, "{by_wheels} by the wheels, {by_flow} by the flow sensor");
    // Each of the errors that are possible has its share, the constant ones and those of the moment.
    for (place, turns_further) in [(left, true), (left_slip, true), (right_slip, true), (scale, false), (change, false)]
    {
        let more = belief.mean[place] * if turns_further { -1.0 } else { 1.0 };
        assert!(more > 1e-5, "{more} at {place}: {}", belief.mean);
    }
    let went_m = belief.mean[0] - 1.0;
    assert!((went_m - 4.0).abs() < 0.02 && (went_m - 4.0 * by_flow).abs() < 0.01, "{went_m}");
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
    assert_eq!(filter.belief.things, [belief::Thing::Landmark(7)]);
    let moved_m = filter.belief.mean[0] - 3.0;
    assert!((0.35..0.4).contains(&moved_m), "{moved_m} m, between 0.35 m by the landmark and 0.4 m by the wheels");
}

#[test]
fn the_gate_widens_with_the_number_of_components() {
    // Standard deviations of the residual: √(4 + 5) = 3 and √(4 + 12) = 4 m, √(0.01 + 0.03) = 0.2 rad. As much of χ² as
    // lies within three standard deviations of a Gaussian, 99.73 %, is below 11.83 with two degrees of freedom and below 14.16 with three.
    let noise = [5.0, 12.0, 0.03];
    for (residual, is_used) in [
        (vec![6.0, 4.0 * 7.8_f64.sqrt()], true),
        (vec![6.0, 4.0 * 7.9_f64.sqrt()], false),
        (vec![6.0, 8.0, 0.2 * 6.1_f64.sqrt()], true),
        (vec![6.0, 8.0, 0.2 * 6.2_f64.sqrt()], false),
    ] {
        let rows: Vec<_> = (0..residual.len()).map(|axis| vec![(axis, 1.0)]).collect();
        let noise = DMatrix::from_diagonal(&DVector::from_column_slice(&noise[..residual.len()]));
        assert_eq!(wide().update(&rows, &DVector::from_vec(residual.clone()), &noise), is_used, "{residual:?}");
    }
}

/// A step of a robot that stands still while its gyroscope reads this rate.
fn standing(robot: &RobotModel, stamp_s: f64, span_s: f64, rate_rad_per_s: f64) -> Step {
    let turned = Some((rate_rad_per_s * span_s, span_s / robot.gyro.unwrap().period_s));
    Step { stamp_s, span_s, rolled_m: [0.0; 2], turned, flowed_m: None }
}

#[test]
fn wheels_that_stand_still_tell_the_bias_of_the_gyroscope() {
    let ExtendedKalmanFilter { layout, mut belief, mut robot, tuning, .. } = filter(&yard());
    let gyro = robot.gyro.as_mut().unwrap();
    (gyro.noise_rad_per_s, gyro.bias_wander_rad_per_s2, gyro.scale) = (0.0, 0.0, Interval::point(1.0));
    robot.wheels.slip_window_s = 0.995;
    let [bias, scale] = layout.gyro.unwrap();
    let (bias_rad_per_s, heading_rad) = (belief.mean[bias], belief.mean[2]);
    let (bias2, scale2) = (belief.covariance[(bias, bias)], belief.covariance[(scale, scale)]);
    // In the window of 1 s the gyroscope turns by half a standard deviation of its bias.
    let off_rad = 0.5 * bias2.sqrt();
    for step in 1..=100 {
        let step = standing(&robot, 0.01 * f64::from(step), 0.01, bias_rad_per_s + off_rad);
        belief.step(&step, &layout, &robot, &tuning);
    }
    // Variances of the turn by the gyroscope, and by two wheels that are each known to their slip's floor and to a tick.
    let by_gyro = bias2 + off_rad.powi(2) * scale2;
    let [floor_m, tick_m] =
        [robot.wheels.slip_floor_m, robot.wheels.metres_per_tick(0).mid()].map(|bound_m| bound_m / 3.0);
    let by_wheels = 2.0 * (floor_m.powi(2) + tick_m.powi(2)) / robot.wheels.track_m.mid().powi(2);
    let told = off_rad / (by_gyro + by_wheels);
    let [turned_rad, learnt] = [belief.mean[2] - heading_rad, belief.mean[bias] - bias_rad_per_s];
    assert!((turned_rad - told * by_wheels).abs() < 1e-6 * off_rad, "{turned_rad}");
    assert!((learnt - told * bias2).abs() < 1e-6 * off_rad && learnt > 0.0, "{learnt}");
}

#[test]
fn the_bias_of_the_gyroscope_becomes_less_certain_as_it_wanders() {
    let ExtendedKalmanFilter { layout, mut belief, mut robot, tuning, .. } = filter(&yard());
    robot.gyro.as_mut().unwrap().bias_wander_rad_per_s2 = 3e-4;
    robot.wheels.slip_window_s = 1e9;
    let [bias, _] = layout.gyro.unwrap();
    let start = belief.covariance[(bias, bias)];
    for second in 1..=100 {
        belief.step(&standing(&robot, f64::from(second), 1.0, 0.0), &layout, &robot, &tuning);
    }
    // A third of the bound is 1e-4, the square of which adds up over 100 s.
    assert!((belief.covariance[(bias, bias)] - start - 1e-6).abs() < 1e-12);
}

/// A step of a robot that drives at 1.1 m/s and turns by 1 rad/s.
fn driving(filter: &ExtendedKalmanFilter, stamp_s: f64, span_s: f64) -> What {
    let turned = Some((span_s, span_s / filter.robot.gyro.unwrap().period_s));
    What::Step(Step { stamp_s, span_s, rolled_m: [span_s, 1.2 * span_s], turned, flowed_m: None })
}

fn at(x_m: f64, y_m: f64) -> Seen {
    Seen::Position { in_robot_m: [-0.15, 0.1], in_world_m: [x_m, y_m], sigma_m: 0.01 }
}

fn assert_same(one: &Belief, other: &Belief) {
    assert!((&one.mean - &other.mean).amax() < 1e-12, "{} {}", one.mean, other.mean);
    assert!((&one.covariance - &other.covariance).amax() < 1e-12);
}

#[test]
fn a_late_position_counts_at_its_own_stamp_within_a_step() {
    let [mut in_time, mut late] = [(); 2].map(|()| filter(&yard()));
    for (stamp_s, span_s) in [(0.1, 0.1), (0.15, 0.05)] {
        in_time.apply(driving(&in_time, stamp_s, span_s));
    }
    in_time.apply(What::Seen(Mounted::Antenna, at(2.1, 2.1)));
    in_time.apply(driving(&in_time, 0.2, 0.05));
    for stamp_s in [0.1, 0.2] {
        late.apply(driving(&late, stamp_s, 0.1));
    }
    late.insert(0.15, Mounted::Antenna, at(2.1, 2.1));
    assert_same(&in_time.belief, &late.belief);
}

#[test]
fn a_position_that_arrives_after_a_later_one_leaves_that_in_its_place() {
    let [mut in_order, mut overtaken] = [(); 2].map(|()| filter(&yard()));
    for filter in [&mut in_order, &mut overtaken] {
        for stamp_s in [0.1, 0.2, 0.3] {
            filter.apply(driving(filter, stamp_s, 0.1));
        }
    }
    for stamp_s in [0.05, 0.15] {
        in_order.insert(stamp_s, Mounted::Antenna, at(2.0 + stamp_s, 2.1));
    }
    for stamp_s in [0.15, 0.05] {
        overtaken.insert(stamp_s, Mounted::Antenna, at(2.0 + stamp_s, 2.1));
    }
    assert_same(&in_order.belief, &overtaken.belief);
}
