use interval::Interval;
use nalgebra::Matrix3;

use super::{
    super::{
        cues::scan_trial::{SIDES, lines_of, room, scan},
        mean_of,
    },
    resampling::{N_SAMPLES, low_variance, n_by_kld},
    *,
};

/// Samples of a start known to half a metre along either axis and to 0.3 rad, with a gyroscope's bias of 0.01 rad/s.
fn start() -> Cloud {
    let mut cloud = Cloud::new(stream(1, "a cloud"));
    let side = Interval::centred(0.0, 0.5);
    let constants = Constants { bias_rad_per_s: 0.01, ..Constants::default() };
    cloud.draw_start(&PoseBox::from([side, side, Interval::centred(0.0, 0.3)]), &constants);
    cloud
}

/// Weighted mean and standard deviation of a quantity of the samples, and the number of its values.
fn spread(cloud: &Cloud, of: impl Fn(&Sample) -> f64) -> (f64, f64, usize) {
    let mean = cloud.mean_of(&of);
    let mut values: Vec<u64> = cloud.samples.iter().map(|sample| of(sample).to_bits()).collect();
    values.sort_unstable();
    values.dedup();
    (mean, cloud.mean_of(&|sample| (of(sample) - mean).powi(2)).sqrt(), values.len())
}

#[test]
fn a_position_to_the_millimetre_leaves_many_samples_that_are_spread_as_it_says() {
    let mut cloud = start();
    let (x_m, y_m, sigma_m) = (0.2, -0.1, 0.001);
    cloud.weigh(&|sample| {
        -0.5 * ((sample.pose[0] - x_m).powi(2) + (sample.pose[1] - y_m).powi(2)) / (sigma_m * sigma_m)
    });
    for (axis, by_hand_m) in [x_m, y_m].into_iter().enumerate() {
        let (mean_m, spread_m, n_values) = spread(&cloud, |sample| sample.pose[axis]);
        assert!((mean_m - by_hand_m).abs() < 0.3 * sigma_m, "{mean_m}");
        assert!((0.75..1.3).contains(&(spread_m / sigma_m)) && n_values > 200, "{spread_m} of {n_values} values");
    }
    // The position tells neither the heading nor the bias, whose standard deviations stay as they were but for what chance makes of some drawings.
    for (name, sigma, (mean, spread, n_values)) in [
        ("heading", 0.1, spread(&cloud, |sample| sample.pose[2])),
        ("bias", 0.01, spread(&cloud, |sample| sample.errors.bias_rad_per_s)),
    ] {
        assert!(mean.abs() < sigma && (0.5..1.6).contains(&(spread / sigma)), "{name}: {mean}, {spread}");
        assert!(n_values > 200, "{name}: {n_values} values");
    }
}

#[test]
fn drawing_samples_anew_keeps_what_a_pose_tells_of_a_mount() {
    for seed in 0..10 {
        // Half of the variance of 5 cm and 5 cm, 35 mm, is that of what the antenna does not tell. The first measurement leaves the offspring of a few
        // samples: by a narrow kernel they stay apart, and some of these clouds are as narrow as 11 mm.
        for of_robot_m in spread_along_an_antenna_seen(seed) {
            assert!((0.018..0.06).contains(&of_robot_m), "cloud {seed}: {of_robot_m} m");
        }
    }
}

/// Standard deviations along x and y of the samples of a robot whose antenna is seen once, and then its heading twenty times.
fn spread_along_an_antenna_seen(seed: u64) -> [f64; 2] {
    let antenna = Mounted::Antenna as usize;
    let mut constants = Constants::default();
    constants.mounts[antenna] = [0.05, 0.05, 0.0];
    let mut cloud = Cloud::new(stream(seed, "a cloud"));
    let side = Interval::centred(0.0, 0.15);
    cloud.draw_start(&PoseBox::from([side, side, Interval::centred(0.0, 0.3)]), &constants);
    // The antenna is seen to be at the origin to 2 mm, so that either the robot or the antenna on it is off by some centimetres.
    let seen = |sample: &Sample| [0, 1].map(|axis| sample.pose[axis] + sample.errors.mounts[antenna][axis]);
    cloud.weigh(&|sample| -0.5 * seen(sample).map(|m| (m / 0.002).powi(2)).iter().sum::<f64>());
    // Headings alone are measured then, which tell nothing of the place, each so well that the samples are drawn anew.
    for heading_rad in [0.01, -0.01].repeat(10) {
        cloud.weigh(&|sample| -0.5 * ((sample.pose[2] - heading_rad) / 0.005).powi(2));
    }
    [0, 1].map(|axis| {
        let (_, of_antenna_m, n_values) = spread(&cloud, |sample| seen(sample)[axis]);
        assert!(of_antenna_m < 0.004 && n_values > 100, "cloud {seed}, axis {axis}: {of_antenna_m} m");
        spread(&cloud, |sample| sample.pose[axis]).1
    })
}

/// A cloud known to a centimetre, at the origin.
fn dense() -> Cloud {
    let mut cloud = Cloud::new(stream(2, "a cloud"));
    let side = Interval::centred(0.0, 0.03);
    cloud.draw_start(&PoseBox::from([side; 3]), &Constants::default());
    cloud
}

#[test]
fn a_measurement_far_off_is_as_likely_from_anywhere_and_moves_no_sample() {
    let known = Known { tiles: None, wall_directions_rad: &[], floor_plan: None, area_m2: 96.0, scale: 1.0 };
    let position = Seen::Position { in_robot_m: [0.0; 2], in_world_m: [0.2, 0.0], sigma_m: 0.01 };
    let covariance = Matrix3::from_diagonal_element(1e-4);
    let marker = Seen::Pose { pose: [0.2, 0.0, 0.0], covariance };
    // A share of 0.05 of the measurements is wrong: anywhere in 96 m², and a pose turned in any way. 10 and 20 standard deviations off a right one
    // has at most e^−50 of its peak.
    for (seen, anywhere) in [(&position, 96.0), (&marker, 96.0 * 2.0 * PI)] {
        let likelihood = likelihood(seen, &known, 0.0).unwrap();
        for x_m in [0.1, 0.0] {
            let log = likelihood([x_m, 0.0, 0.0]);
            assert!((log - (0.05 / anywhere).ln()).abs() < 1e-9, "{log} at {x_m} m");
        }
        let mut cloud = dense();
        let before = cloud.mean_of(&|sample| sample.pose[0]);
        cloud.weigh(&|sample| likelihood(sample.pose));
        let moved_m = cloud.mean_of(&|sample| sample.pose[0]) - before;
        assert!(moved_m.abs() < 1e-4, "{moved_m} m");
    }
}

/// A filter in a yard with a satellite receiver, in which the robot is near (2, 2) and looks along x.
fn filter() -> ParticleFilter {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 12.0\ndepth_m = 8.0\n[start]\nx_m = 2.0\ny_m = 2.0\ntolerance_m = 0.5\n\
                [robot]\nfloor_camera = false\n[robot.gnss]\nforward_m = 0.0\nleft_m = 0.0\nheight_m = 0.6\n\
                [localizer]\nmethods = [\"gnss_positions\"]\n[[route.waypoint]]\nx_m = 4.0\ny_m = 2.0\n";
    let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    ParticleFilter::of(&scene, FilterNoise::default(), "pf".to_owned())
}

fn position(x_m: f64, y_m: f64, sigma_m: f64) -> Seen {
    Seen::Position { in_robot_m: [0.0; 2], in_world_m: [x_m, y_m], sigma_m }
}

/// Steps straight ahead at 1 m/s.
fn drive(filter: &mut ParticleFilter, tenths: std::ops::RangeInclusive<i32>) {
    for tenth in tenths {
        let stamp_s = 0.1 * f64::from(tenth);
        filter.step(&Step { stamp_s, span_s: 0.1, rolled_m: [0.1; 2], turned: None, flowed_m: None });
    }
}

fn mean_at(filter: &ParticleFilter, time_s: f64) -> Pose {
    let Answer::Samples(samples) = filter.estimate_at(time_s) else { panic!("no samples") };
    mean_of(&samples)
}

#[test]
fn a_late_position_is_compared_with_where_the_robot_was() {
    let [mut in_time, mut late] = [(); 2].map(|()| filter());
    drive(&mut in_time, 1..=2);
    in_time.weigh(0.2, Mounted::Antenna, &position(2.3, 2.05, 0.01));
    drive(&mut in_time, 3..=5);
    drive(&mut late, 1..=5);
    // A position that tells little brings the samples to the present.
    late.weigh(0.5, Mounted::Antenna, &position(2.5, 2.0, 2.0));
    late.weigh(0.2, Mounted::Antenna, &position(2.3, 2.05, 0.01));
    // At 0.2 s the robot was at (2.3, 2.05), and has driven 0.3 m since.
    for (name, filter) in [("in time", in_time), ("late", late)] {
        let Pose { x_m, y_m, .. } = mean_at(&filter, 0.5);
        assert!((x_m - 2.6).abs() < 0.005 && (y_m - 2.05).abs() < 0.005, "{name}: {x_m} {y_m}");
    }
}

/// Standard deviation of what slip and the error of its radius add to the way of one wheel, over that way.
fn wheel_sigma(filter: &ParticleFilter) -> f64 {
    let wheels = &filter.robot.wheels;
    let radius = 0.5 * wheels.radius_m[0].width() / wheels.radius_m[0].mid();
    SIGMAS_OF_BOUND * wheels.slip_ratio.hypot(radius)
}

#[test]
fn slip_that_lasts_spreads_the_samples_along_the_way_as_its_integral_does() {
    let mut filter = filter();
    let before = spread(&filter.cloud, |sample| sample.pose[0]).1;
    drive(&mut filter, 1..=100);
    filter.carry(filter.odometry.latest());
    // The integral of a first-order Gauss–Markov process over 10 of its lengths of 1 m has the variance 2·(10 − 1 + e⁻¹⁰)·σ² m², by either wheel for
    // half of the way. Each step adds the floor of its window.
    let wheels = &filter.robot.wheels;
    let floor_m = SIGMAS_OF_BOUND * wheels.slip_floor_m * (0.1 / wheels.slip_window_s * 100.0).sqrt();
    let by_hand_m = (0.5 * (18.0 * wheel_sigma(&filter).powi(2) + floor_m.powi(2)) + before * before).sqrt();
    let spread_m = spread(&filter.cloud, |sample| sample.pose[0]).1;
    assert!((0.8..1.3).contains(&(spread_m / by_hand_m)), "{spread_m} m, by hand {by_hand_m} m");
}

#[test]
fn turning_without_a_gyroscope_spreads_the_headings_by_the_errors_of_track_and_wheels() {
    let mut filter = filter();
    let track_m = filter.robot.wheels.track_m.mid();
    filter.robot.wheels.track_m = Interval::centred(track_m, 0.06 * track_m);
    filter.odometry = Odometry::new(&filter.robot, filter.tuning);
    let before = spread(&filter.cloud, |sample| sample.pose[2]).1;
    // Turns on the spot, ten metres by each wheel.
    for hundredth in 1..=100 {
        let rolled_m = [-0.1, 0.1];
        filter.step(&Step { stamp_s: 0.1 * f64::from(hundredth), span_s: 0.1, rolled_m, turned: None, flowed_m: None });
    }
    filter.carry(filter.odometry.latest());
    let wheels = &filter.robot.wheels;
    let floor_m = SIGMAS_OF_BOUND * wheels.slip_floor_m * (0.1 / wheels.slip_window_s * 100.0).sqrt();
    let by_wheels_m2 = 2.0 * (18.0 * wheel_sigma(&filter).powi(2) + floor_m.powi(2));
    let by_track_rad = SIGMAS_OF_BOUND * 0.06 * 20.0 / track_m;
    let by_hand_rad = (by_wheels_m2 / track_m.powi(2) + by_track_rad.powi(2) + before * before).sqrt();
    let spread_rad = spread(&filter.cloud, |sample| sample.pose[2]).1;
    // Without the error of the track a tenth of it would be left.
    assert!(by_track_rad > 0.9 * by_hand_rad, "{by_track_rad} of {by_hand_rad} rad");
    assert!((0.8..1.25).contains(&(spread_rad / by_hand_rad)), "{spread_rad} rad, by hand {by_hand_rad} rad");
}

#[test]
fn poses_a_tile_apart_are_not_drawn_together() {
    let mut cloud = dense();
    let half_m = 0.15;
    for (index, sample) in cloud.samples.iter_mut().enumerate() {
        sample.pose[0] += if index % 2 == 0 { half_m } else { -half_m };
    }
    // Only the heading is measured, so that the samples are drawn anew and nothing tells the two places apart.
    for heading_rad in [0.01, -0.01, 0.01, -0.01] {
        cloud.weigh(&|sample| -0.5 * ((sample.pose[2] - heading_rad) / 0.005).powi(2));
    }
    let ahead: Vec<f64> = cloud.samples.iter().map(|sample| sample.pose[0]).filter(|x_m| *x_m > 0.0).collect();
    let mean_m = ahead.iter().sum::<f64>() / ahead.len() as f64;
    assert!((mean_m - half_m).abs() < 0.012, "{mean_m} m");
    let share = ahead.len() as f64 / cloud.samples.len() as f64;
    assert!((0.2..0.8).contains(&share), "{share}");
}

#[test]
fn slip_that_lasts_is_learnt_from_positions_and_is_known_after_them() {
    let mut filter = filter();
    let share = 1.0 + 2.0 * wheel_sigma(&filter);
    for tenth in 1..=40 {
        drive(&mut filter, tenth..=tenth);
        let stamp_s = 0.1 * f64::from(tenth);
        filter.weigh(stamp_s, Mounted::Antenna, &position(2.0 + share * stamp_s, 2.0, 0.002));
    }
    let at_m = mean_at(&filter, 4.0).x_m;
    drive(&mut filter, 41..=43);
    let gone_m = mean_at(&filter, 4.3).x_m - at_m;
    // The wheels rolled 0.3 m, the robot went farther by their slip. Filters that take slip for noise would have learnt nothing of it.
    let learnt = (gone_m / 0.3 - 1.0) / (share - 1.0);
    assert!((0.25..1.2).contains(&learnt), "{learnt} of the slip");
}

#[test]
fn the_error_of_a_mount_is_learnt_where_the_pose_is_known() {
    let mut filter = filter();
    filter.constants.mounts[Mounted::Antenna as usize] = [0.05, 0.05, 0.0];
    // The robot is known to stand within 3 mm of (2, 2) and to look along x; its antenna is seen a decimetre ahead of where it should be.
    let side = |middle: f64| Interval::centred(middle, 0.003);
    filter.begin(&PoseBox::from([side(2.0), side(2.0), side(0.0)]));
    (0..5).for_each(|_| filter.weigh(0.0, Mounted::Antenna, &position(2.1, 2.0, 0.002)));
    let pose = mean_at(&filter, 0.0);
    assert!((pose.x_m - 2.0).abs() < 0.005 && (pose.y_m - 2.0).abs() < 0.005, "{pose:?}");
    let mount =
        [0, 1].map(|axis| filter.cloud.mean_of(&|sample| sample.errors.mounts[Mounted::Antenna as usize][axis]));
    assert!((mount[0] - 0.1).abs() < 0.01 && mount[1].abs() < 0.01, "{mount:?}");
}

#[test]
fn samples_that_were_carried_away_unseen_are_drawn_from_measured_positions() {
    let mut filter = filter();
    for (x_m, y_m) in [(2.1, 2.0), (5.0, 3.0)] {
        (0..20).for_each(|_| filter.weigh(0.0, Mounted::Antenna, &position(x_m, y_m, 0.02)));
        let mean = mean_at(&filter, 0.0);
        assert!((mean.x_m - x_m).abs() < 0.02 && (mean.y_m - y_m).abs() < 0.02, "{mean:?} at ({x_m}, {y_m})");
    }
}

#[test]
fn low_variance_resampling_draws_each_sample_as_often_as_its_weight_says() {
    // Steps of 1 from 0.5 on: 0.5, 1.5, 2.5, 3.5 along the sums 1, 1, 4.
    assert_eq!(low_variance(&[1.0, 0.0, 3.0], 4.0, 4, 0.5), [0, 2, 2, 2]);
    assert_eq!(low_variance(&[1.0, 1.0], 2.0, 6, 0.1), [0, 0, 0, 1, 1, 1]);
}

#[test]
fn the_number_of_samples_is_that_of_kld_sampling() {
    // Eq. 8 of Fox (2003) for k = 101 bins, ε = 0.05 and z = 2.326: 1000·(1 − 1/450 + √(1/450)·2.326)³ = 1000·1.10743³ = 1358.2.
    assert_eq!(n_by_kld(101), 1359);
    assert_eq!((n_by_kld(1), n_by_kld(1_000_000)), (N_SAMPLES[0], N_SAMPLES[1]));
}

#[test]
fn scans_draw_the_samples_to_where_they_were_made_and_not_closer_than_walls_may_be_off() {
    let (scene, pose) = (room(""), [2.03, 1.48, 0.01]);
    let (lines, _) = lines_of(&scene, &scan(pose, SIDES, 0.0, 0.0));
    let mut filter = ParticleFilter::of(&scene, FilterNoise::default(), "pf".to_owned());
    // As many scans as are used on a way of a metre.
    (0..33).for_each(|_| filter.weigh(0.0, Mounted::Scanner, &Seen::Lines(lines.clone())));
    let mean = mean_at(&filter, 0.0);
    let off = [mean.x_m - pose[0], mean.y_m - pose[1], mean.heading_rad - pose[2]];
    assert!(off[0].abs() < 0.01 && off[1].abs() < 0.01 && off[2].abs() < 0.005, "{off:?}");
    // Walls and plan are off by 4 mm each, as one standard deviation; two opposite walls have half of that variance in common.
    for axis in 0..2 {
        let (_, spread_m, _) = spread(&filter.cloud, |sample| sample.pose[axis]);
        assert!((0.0015..0.01).contains(&spread_m), "axis {axis}: {spread_m} m");
    }
}

#[test]
fn a_line_before_a_wall_is_as_likely_from_anywhere() {
    let (pose, scene) = ([2.0, 1.5, 0.0], room(""));
    let (lines, plan) = lines_of(&scene, &scan(pose, SIDES, 0.5, 0.0));
    let known = Known { tiles: None, wall_directions_rad: &[], floor_plan: Some(&plan), area_m2: 24.0, scale: 1.0 };
    // A share of 0.5 of the lines is furniture, anywhere within 5 m before a wall and turned in any way by half a turn.
    let furniture = (0.5 / (5.0 * PI)).ln();
    let n_walls = lines.iter().filter(|line| plan.met(line, pose).is_some_and(|met| met.off_m.abs() < 0.1)).count();
    assert_eq!(n_walls + 1, lines.len());
    for line in &lines {
        let is_wall = plan.met(line, pose).is_some_and(|met| met.off_m.abs() < 0.1);
        let seen = Seen::Lines(vec![*line]);
        let likelihood = likelihood(&seen, &known, 0.0).unwrap();
        let [there, beside] = [pose, [2.02, 1.52, 0.0]].map(&likelihood);
        assert_eq!(is_wall, there > furniture + 1.0, "{there} {furniture}");
        assert!(if is_wall { there > beside + 0.1 } else { (there - beside).abs() < 1e-4 }, "{there} {beside}");
        assert!(is_wall || (there - furniture).abs() < 0.01, "{there} {furniture}");
    }
}

#[test]
fn a_wall_is_as_likely_as_its_own_place_and_the_plans_allow_that_last_for_a_metre() {
    let (pose, scene) = ([2.0, 1.5, 0.0], room(""));
    let (lines, plan) = lines_of(&scene, &scan(pose, SIDES, 0.0, 0.0));
    let known = Known { tiles: None, wall_directions_rad: &[], floor_plan: Some(&plan), area_m2: 24.0, scale: 1.0 };
    // The wall at x = 0, 4 m long, which is seen as a whole: half-way along it, its two ends have half of their variance in common. Place and turn of
    // the wall and of the plan, whose farthest corner is 3.6 m from its middle, are a third of 12 mm off, and a metre has 33 scans.
    let line = lines.iter().find(|line| line.middle_m[0] < -1.9).unwrap();
    let placed_m2 = 33.3 * 0.004_f64.powi(2);
    let place_m = (1.5 * placed_m2 + line.sigma[1].powi(2)).sqrt();
    let turn_rad = (placed_m2 * (2.0 / 4.0_f64.powi(2) + 1.0 / (3.0_f64.powi(2) + 2.0_f64.powi(2)))
        + line.sigma[0].powi(2))
    .sqrt();
    let seen = Seen::Lines(vec![*line]);
    let likelihood = likelihood(&seen, &known, 0.0).unwrap();
    for off_m in [0.0, 0.02, 0.05] {
        let off = -0.5 * (off_m / place_m).powi(2);
        let expected = (0.5 * off.exp() / (2.0 * PI * place_m * turn_rad) + 0.5 / (5.0 * PI)).ln();
        let found = likelihood([pose[0] + off_m, pose[1], pose[2]]);
        assert!((found - expected).abs() < 0.03, "{off_m} m: {found}, expected {expected}");
    }
}
