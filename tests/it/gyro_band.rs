//! Tests of a gyroscope whose Gaussian noise is not redrawn when it exceeds its bound, and of the band over time spans that the noise keeps
//! to except by bad luck.

use localizer::{Pose, bounds};
use sim::{
    devices::{Sensor, gyro::GyroCuts},
    run::{RunOptions, run},
    scene::Scene,
    subject::IntervalLocalizer,
    truth::Truth,
    world::Drawn,
};

use crate::{
    judging::verdict_of,
    world_setup::{gyro_sensor, noise_and_bias_rad_per_s, scene},
};

/// Scene with a gyroscope at 200 Hz whose white noise of 0.005 °/s/√Hz is not redrawn when it exceeds its bound, and whose band is the
/// given floor plus 0.005 °/s.
fn noisy(floor_deg: f64) -> Scene {
    let gyro = serde_json::json!({
        "bias_tolerance_deg_per_s": 0.0, "scale_tolerance": 0.0, "noise_deg_per_s": 0.6, "noise_redrawn": false,
        "angle_random_walk_deg_per_sqrt_h": 0.3, "angle_floor_deg": floor_deg, "angle_deg_per_s": 0.005,
    });
    let start = serde_json::json!({ "x_m": 1.5, "y_m": 3.0, "tolerance_m": 0.1, "tolerance_deg": 1.0 });
    let robot = serde_json::json!({ "gyro": gyro, "floor_camera": false });
    scene(serde_json::json!({ "robot": robot, "start": start, "duration_s": 20.0, "localizer": { "methods": [] } }))
}

/// Time until the accumulated noise of a gyroscope at rest leaves its band, up to a longest time, and the greatest noise of a reading until
/// then.
fn lasts_s(scene: &Scene, seed: u64, longest_s: f64) -> (f64, f64) {
    let floor_rad = scene.robot.gyro.as_ref().unwrap().angle_floor_deg.unwrap().to_radians();
    let mut sensor = gyro_sensor(scene, seed, &Drawn::draw(scene, seed));
    let mut greatest_rad_per_s = 0.0_f64;
    for step in 0.. {
        let time_s = f64::from(step) * 0.005;
        let truth = Truth { time_s, pose: Pose { x_m: 1.5, y_m: 3.0, heading_rad: 0.0 }, ..Truth::default() };
        if let Some(observed) = sensor.observe(&truth, &[]) {
            greatest_rad_per_s = greatest_rad_per_s.max(observed.true_value(bounds::GYRO_NOISE).unwrap());
            if observed.true_value(bounds::GYRO_ANGLE).unwrap() > floor_rad || time_s > longest_s {
                return (time_s, greatest_rad_per_s);
            }
        }
    }
    unreachable!("steps end with the longest time")
}

#[test]
fn a_gyroscope_leaves_its_band_as_seldom_as_the_closed_form_says() {
    // The greatest excess of the accumulated noise over the band's rate r, over all spans up to a time, is a Brownian motion with drift −r,
    // reflected at 0. It reaches a after (σ²/2r²)·(e^k − 1 − k) on average, with k = 2ra/σ² (Karlin and Taylor 1981, section 15.3); the
    // band has two sides, which halves that. With σ = 0.005 °/√s and r = 0.005 °/s, a floor of 0.015° has k = 6 and lasts 0.5·396.4/2 =
    // 99.1 s.
    let scene = noisy(0.015);
    let mean_s = (0..300).map(|seed| lasts_s(&scene, seed, 1e5).0).sum::<f64>() / 300.0;
    // The formula holds for continuous noise. The simulated noise is only seen at 200 Hz, so that its sum gets 0.58·σ·√T = 0.0002° farther before it
    // is noticed to have left the band: k = 6.08, 8 % longer. The mean of 300 draws scatters by 6 %.
    assert!((90.0..130.0).contains(&mean_s), "{mean_s} s on average");
}

#[test]
fn a_floor_that_fails_once_in_a_million_hours_holds_for_hours() {
    // By the formula for the mean time until the noise leaves its band, with k = 24: 0.5·e^24/2 = 6.6e9 s, 1.8 million hours.
    let scene = noisy(0.06);
    for seed in 0..4 {
        let (time_s, greatest_rad_per_s) = lasts_s(&scene, seed, 3600.0);
        assert!(time_s > 3600.0, "seed {seed} leaves its band after {time_s} s");
        // 0.6 °/s is 8.5 standard deviations of the noise of one gyroscope reading: none of the 720 000 readings comes near it, and the greatest one
        // is beyond 4 deviations.
        assert!((4.0 * 0.0707..0.6).contains(&greatest_rad_per_s.to_degrees()), "{}", greatest_rad_per_s.to_degrees());
    }
}

/// Errors of the readings of a gyroscope at rest, in their order, either as drawn or cut to the bounds `gyro.angle` and `gyro.noise`.
fn errors_rad_per_s(scene: &Scene, n_readings: usize, is_cut: bool) -> Vec<f64> {
    let mut drawn = Drawn::draw(scene, 1);
    drawn.devices.gyro.as_mut().unwrap().cuts = GyroCuts { noise: is_cut, angle: is_cut };
    let bias_rad_per_s = drawn.devices.gyro.unwrap().bias_rad_per_s;
    let mut sensor = gyro_sensor(scene, 1, &drawn);
    let at = |step: usize| Truth { time_s: step as f64 * 0.005, ..Truth::default() };
    let read = (0..=n_readings).filter_map(|step| sensor.observe(&at(step), &[]));
    read.map(|read| noise_and_bias_rad_per_s(&read).iter().sum::<f64>() - bias_rad_per_s).collect()
}

#[test]
fn noise_cut_to_its_bounds_keeps_the_band_over_every_span_and_stays_as_drawn_until_it_leaves_it() {
    let mut scene = noisy(0.002);
    // The bound on the noise of one gyroscope reading is about three standard deviations, so that single readings are cut to it as well. The bias
    // wanders too, and its change uses a part of the band that limits the accumulated angle error.
    let gyro = scene.robot.gyro.as_mut().unwrap();
    (gyro.noise_deg_per_s, gyro.bias_tolerance_deg_per_s, gyro.bias_wander_deg_per_s2) = (0.2, 0.01, 0.003);
    gyro.rate_random_walk_deg_per_h_per_sqrt_h = 600.0;
    let (drawn, cut) = (errors_rad_per_s(&scene, 4000, false), errors_rad_per_s(&scene, 4000, true));
    let [floor_rad, rate_rad_per_s] = [0.002_f64, 0.005].map(f64::to_radians);
    // Sums of the gyroscope's errors up to every time, and the greatest amount by which the sum over any span leaves the band.
    let beyond_rad = |errors: &[f64]| {
        let mut sums_rad = vec![0.0];
        sums_rad.extend(errors.iter().scan(0.0, |sum, error| {
            *sum += 0.005 * error;
            Some(*sum)
        }));
        let spans = (0..sums_rad.len()).flat_map(|end| (0..end).map(move |start| (start, end)));
        let left_rad = |(start, end): (usize, usize)| {
            (sums_rad[end] - sums_rad[start]).abs() - floor_rad - rate_rad_per_s * 0.005 * (end - start) as f64
        };
        spans.map(left_rad).fold(f64::NEG_INFINITY, f64::max)
    };
    assert!(beyond_rad(&drawn) > 0.5 * floor_rad, "{}", beyond_rad(&drawn));
    assert!(beyond_rad(&cut) < 1e-9 * floor_rad, "{}", beyond_rad(&cut));
    // The sum of the cut errors reaches the edge of the band: the cut took off no more than necessary.
    assert!(beyond_rad(&cut) > -1e-9, "{}", beyond_rad(&cut));
    let first = drawn.iter().zip(&cut).position(|(drawn, cut)| drawn != cut).unwrap();
    assert!(beyond_rad(&drawn[..first]) <= 0.0 && first > 0);
    assert!(beyond_rad(&drawn[..=first]) > 0.0 || drawn[first].abs() > 0.19_f64.to_radians(), "reading {first}");
}

#[test]
fn a_run_that_leaves_its_band_has_a_broken_bound() {
    for (floor_deg, is_broken) in [(0.002, true), (0.06, false)] {
        let scene = noisy(floor_deg);
        let record =
            run(&scene, 1, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
        let verdict = verdict_of(&scene, &record);
        let named = verdict.violations.iter().any(|violation| violation.bound == "gyro.angle");
        assert_eq!(named, is_broken, "{:?}", verdict.violations);
        if let Some(broken) = verdict.violations.iter().find(|violation| violation.bound == "gyro.angle") {
            // The judge must report that the bound on the gyroscope's accumulated error is broken from the reading on at which the noise leaves its
            // band, and not from the start of the run. The robot stands still.
            let left_s = lasts_s(&scene, 1, 20.0).0;
            assert!(left_s > 0.1 && (broken.from_s - left_s).abs() < 0.006, "{broken:?}, left at {left_s} s");
        }
        assert_eq!(verdict.containment.as_ref().unwrap().unsound, 0);
    }
}
