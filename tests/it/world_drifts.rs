//! Errors that are drawn anew for every reading: inside their bounds for every kind of distribution, at the ends of the bounds for a corner, and
//! always to one side for a drift.

use localizer::{Pose, Reading};
use sim::{
    devices::{Sensor, encoders::Encoder, flow::DrawnFlow},
    run::sensors::Sensors,
    scene::{Distribution, Encoders, Scene},
    truth::{
        Truth,
        randomness::{Repeated, stream},
    },
    world::Drawn,
};

use crate::world_setup::{flow_sensor, gyro_sensor, noise_and_bias_rad_per_s, range_sensor, scene};

fn at(time_s: f64, x_m: f64, heading_rad: f64) -> Truth {
    Truth { time_s, pose: Pose { x_m, y_m: 3.0, heading_rad }, ..Truth::default() }
}

#[test]
fn a_drift_keeps_to_one_side_or_goes_from_end_to_end() {
    let mut sides = Vec::new();
    for seed in 0..40 {
        let mut repeated = Repeated::new(Distribution::Drift, stream(seed, "test"));
        let first = repeated.one_way(0.3);
        assert!(first.abs() == 0.3 && (0..20).all(|_| repeated.one_way(0.3) == first));
        let turns: Vec<f64> = (0..20).map(|_| repeated.in_turn(0.2)).collect();
        assert!(turns.iter().all(|turn| turn.abs() == 0.2) && turns.windows(2).all(|pair| pair[0] == -pair[1]));
        sides.push(first);
        let mut corner = Repeated::new(Distribution::Corner, stream(seed, "test"));
        let ends: Vec<f64> = (0..40).map(|_| corner.one_way(0.3)).collect();
        assert!(ends.iter().all(|end| end.abs() == 0.3) && ends.contains(&0.3) && ends.contains(&-0.3));
    }
    assert!(sides.contains(&0.3) && sides.contains(&-0.3), "the seed chooses the side");
}

/// Readings that a range camera at rest makes of a landmark 2 m ahead: the error of the stamp, the error of the latency, and both image columns.
fn range_readings(errors: &str, column_noise_px: f64, seed: u64) -> Vec<[f64; 4]> {
    let camera = serde_json::json!({
        "column_step_px": 0.001, "match_step_px": 0.001, "column_noise_px": column_noise_px,
    });
    let scene = scene(serde_json::json!({
        "robot": { "errors": errors, "range_camera": camera }, "landmark": [{ "x_m": 3.5, "y_m": 3.0 }],
    }));
    let mut sensor = range_sensor(&scene, seed);
    let mut readings = Vec::new();
    for step in 0..10_000 {
        let truth = at(f64::from(step) * 0.001, 1.5, 0.0);
        let Some(observed) = sensor.observe(&truth, &[]) else { continue };
        let Reading::Range { measured_s, arrived_s, sightings } = observed.reading else { continue };
        let late_s = arrived_s - truth.time_s - 0.05;
        readings.push([measured_s - truth.time_s, late_s, sightings[0].left_px, sightings[0].right_px]);
    }
    readings
}

#[test]
fn stamps_latencies_and_columns_of_a_range_camera_go_as_the_errors_say() {
    for seed in 0..4 {
        for errors in ["uniform", "truncated_gaussian", "corner", "drift"] {
            let (noisy, exact) = (range_readings(errors, 0.3, seed), range_readings(errors, 0.0, seed));
            assert!(noisy.len() == 50);
            for ([stamp_s, late_s, left_px, right_px], [.., exact_left_px, exact_right_px]) in noisy.iter().zip(&exact)
            {
                assert!(stamp_s.abs() <= 0.0005 + 1e-9 && late_s.abs() <= 0.005 + 1e-9, "{errors}");
                let off_px = [left_px - exact_left_px, right_px - exact_right_px];
                assert!(off_px.iter().all(|off_px| off_px.abs() <= 0.302), "{errors}: {off_px:?}");
                if ["corner", "drift"].contains(&errors) {
                    assert!(stamp_s.abs() > 0.0005 - 1e-9 && late_s.abs() > 0.005 - 1e-9, "{errors}");
                    assert!(off_px.iter().all(|off_px| off_px.abs() >= 0.298), "{errors}: {off_px:?}");
                }
            }
            if errors == "drift" {
                let first = noisy[0];
                assert!(noisy.iter().all(|reading| (reading[0] - first[0]).abs() < 1e-9), "stamps on both sides");
                assert!(noisy.windows(2).all(|pair| pair[0][1] * pair[1][1] < 0.0), "latencies at one end");
                // The errors of the range camera's two views have opposite signs: the disparity is off by the sum of both, 0.6 px, and always to the
                // same side.
                let disparity_px = |reading: &[f64; 4]| reading[2] - reading[3];
                let off_px = disparity_px(&first) - disparity_px(&exact[0]);
                assert!((off_px.abs() - 0.6).abs() < 0.003, "{off_px}");
                assert!(noisy.iter().all(|reading| (disparity_px(reading) - disparity_px(&first)).abs() < 0.003));
            }
        }
    }
}

/// Noise and bias of a gyroscope at rest, for each reading.
fn gyro_errors(errors: &str, gyro: serde_json::Value, seed: u64, n: u32) -> Vec<[f64; 2]> {
    let scene = scene(serde_json::json!({ "robot": { "errors": errors, "gyro": gyro } }));
    let mut sensor = gyro_sensor(&scene, seed, &Drawn::draw(&scene, seed));
    let observed = (0..=n).filter_map(|step| sensor.observe(&at(f64::from(step) * 0.005, 1.5, 0.0), &[]));
    observed.map(|observed| noise_and_bias_rad_per_s(&observed).map(f64::to_degrees)).collect()
}

#[test]
fn noise_of_a_gyroscope_stands_at_its_bound_and_in_a_drift_always_pushes_one_way() {
    for seed in 0..6 {
        let corner = gyro_errors("corner", serde_json::json!({}), seed, 400);
        assert!(corner.iter().all(|[noise, _]| (noise.abs() - 0.03).abs() < 1e-12));
        assert!(corner.iter().any(|[noise, _]| *noise > 0.0) && corner.iter().any(|[noise, _]| *noise < 0.0));
        let drift = gyro_errors("drift", serde_json::json!({}), seed, 400);
        assert!(drift.iter().all(|error| *error == drift[0]) && (drift[0][0].abs() - 0.03).abs() < 1e-12);
    }
}

#[test]
fn what_pushes_one_way_keeps_to_the_band_over_spans_and_reaches_it() {
    let gyro = serde_json::json!({
        "angle_floor_deg": 0.02, "angle_deg_per_s": 0.0035, "bias_wander_deg_per_s2": 0.0005,
    });
    for (errors, seed) in ["corner", "drift"].into_iter().flat_map(|errors| (0..6).map(move |seed| (errors, seed))) {
        let read = gyro_errors(errors, gyro.clone(), seed, 20_000);
        let mut sums_deg = vec![0.0];
        for [noise, bias] in &read {
            assert!(noise.abs() <= 0.03 + 1e-12, "{errors}: noise beyond its own bound");
            // The bias of the first reading is the initial bias, except for how much it changed in half a period.
            sums_deg.push(sums_deg[sums_deg.len() - 1] + 0.005 * (noise + bias - read[0][1]));
        }
        let mut greatest = 0.0_f64;
        for from in (0..sums_deg.len()).step_by(50) {
            for to in (from + 1..sums_deg.len()).step_by(50) {
                let allowed_deg = 0.02 + 0.0035 * 0.005 * (to - from) as f64;
                greatest = greatest.max((sums_deg[to] - sums_deg[from]).abs() / allowed_deg);
            }
        }
        // The sum is taken from the bias of the first reading and not from the initial bias; the tolerance of 1e-3 allows for how much the bias
        // changed before the first reading, over 100 s.
        assert!(greatest < 1.0 + 1e-3, "{errors}, seed {seed}: {greatest} of the band");
        assert!(errors == "corner" || greatest > 0.99, "seed {seed}: only {greatest} of the band");
    }
}

#[test]
fn a_bias_that_drifts_goes_to_the_end_of_its_tolerance_and_back_as_fast_as_declared() {
    let gyro = serde_json::json!({ "bias_tolerance_deg_per_s": 0.02, "bias_wander_deg_per_s2": 0.001 });
    for (errors, seed) in ["corner", "drift"].into_iter().flat_map(|errors| (0..6).map(move |seed| (errors, seed))) {
        let bias: Vec<f64> = gyro_errors(errors, gyro.clone(), seed, 20_000).iter().map(|error| error[1]).collect();
        assert!(bias.iter().all(|bias| bias.abs() <= 0.02 + 1e-12));
        let fastest = bias.windows(2).map(|pair| (pair[1] - pair[0]).abs() / 0.005).fold(0.0, f64::max);
        assert!((fastest - 0.001).abs() < 1e-9, "{errors}: {fastest}");
        let [least, most] = [f64::min, f64::max].map(|of| bias.iter().copied().fold(0.0, of));
        assert!(errors == "corner" || (least < -0.0199 && most > 0.0199), "seed {seed}: {least} to {most}");
    }
}

/// Counts along the first axis of an exactly mounted flow sensor that faces along x, after it has moved 1 m forward and after it has moved back.
fn there_and_back(errors: &str, seed: u64) -> [i64; 2] {
    let scene = scene(serde_json::json!({ "robot": { "errors": errors, "flow": {} } }));
    let mut drawn = Drawn::draw(&scene, seed);
    drawn.devices.flow = Some(DrawnFlow { position_m: [-0.06, 0.0], yaw_rad: 0.0, scale: 1.0 });
    let mut sensor = flow_sensor(&scene, seed, &drawn);
    let mut counts = [0; 2];
    for step in 0..=4000 {
        let time_s = f64::from(step) * 0.001;
        let along_m = if time_s <= 2.0 { 0.5 * time_s } else { 2.0 - 0.5 * time_s };
        let Some(observed) = sensor.observe(&at(time_s, 1.5 + along_m, 0.0), &[]) else { continue };
        let Reading::Flow { counts: so_far, .. } = observed.reading else { continue };
        counts = [if step == 2000 { so_far[0] } else { counts[0] }, so_far[0]];
    }
    counts
}

#[test]
fn a_flow_sensor_that_drifts_counts_one_way_longer_than_the_way_back() {
    for seed in 0..8 {
        for errors in ["uniform", "corner"] {
            let [there, back] = there_and_back(errors, seed);
            assert!((there - 20_000).abs() <= 1 && back.abs() <= 1, "{there} {back}");
        }
        // By hand: the bound `flow.scale` of 0.3 % contains the calibration error of 0.1 %, so that the scale may drift by 0.3 % − 0.1 % of the
        // distance: 40 counts of 20 000 on the way there, and 40 more on the way back.
        let [there, back] = there_and_back("drift", seed);
        assert!(((there - 20_000).abs() - 40).abs() <= 1 && (back.abs() - 80).abs() <= 2, "{there} {back}");
    }
}

#[test]
fn at_a_corner_wheels_start_at_the_begin_or_the_end_of_a_tick() {
    let encoders = Encoders { ticks_per_turn: 1000, ..Encoders::default() };
    let turned = |share: f64| Truth { wheel_angle_rad: [share * 0.001 * std::f64::consts::TAU; 2], ..Truth::default() };
    let mut seen = Vec::new();
    for seed in 0..40 {
        for errors in [Distribution::Corner, Distribution::Drift] {
            let encoder = Encoder::new(&encoders, errors, seed);
            assert_eq!(encoder.latch(&turned(0.0)), [0, 0]);
            let [hardly, nearly] = [1e-9, 1.0 - 1e-9].map(|share| encoder.latch(&turned(share)));
            assert_eq!(hardly, nearly, "a tick between the ends of a tick");
            seen.push(hardly);
        }
    }
    for ticks in [[0, 0], [0, 1], [1, 0], [1, 1]] {
        assert!(seen.contains(&ticks), "{ticks:?} in no seed");
    }
}

/// Delay of each wheel reading of a robot that stands still.
fn lateness(errors: &str) -> Vec<f64> {
    let robot = serde_json::json!({ "errors": errors, "delivery": { "late_s": 0.1 }, "floor_camera": false });
    let scene: Scene = scene(serde_json::json!({ "robot": robot }));
    let mut sensors = Sensors::new(&scene, 7, &Drawn::draw(&scene, 7), None);
    let mut late = Vec::new();
    for step in 0..5000 {
        for observed in sensors.observe(&at(f64::from(step) * 0.001, 1.5, 0.0), &[], None).unwrap() {
            late.push([observed.reading.measured_s(), observed.reading.arrived_s() - observed.reading.measured_s()]);
        }
    }
    late.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // Wheel readings from the last part of the simulated time are left out, because those delayed by up to 0.1 s may not have arrived before the
    // simulation ends.
    late.into_iter().filter(|[measured_s, _]| *measured_s < 4.8).map(|[_, late_s]| late_s).collect()
}

#[test]
fn readings_are_late_by_nothing_or_by_all_that_is_declared() {
    let is_end = |late_s: &f64| late_s.abs() < 1e-9 || (late_s - 0.1).abs() < 1e-9;
    let (uniform, corner, drift) = (lateness("uniform"), lateness("corner"), lateness("drift"));
    assert!(uniform.iter().all(|late_s| (0.0..=0.1 + 1e-9).contains(late_s)) && !uniform.iter().all(is_end));
    assert!(corner.iter().all(is_end) && corner.windows(2).any(|pair| (pair[0] - pair[1]).abs() < 1e-9));
    assert!(drift.iter().all(is_end) && drift.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 0.05));
}
