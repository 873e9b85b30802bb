//! Records a gyroscope at rest, 20 times for two hours, for `scripts/allan`, which analyses the records with an external package.
//!
//! Writes each record as little-endian 64-bit floating-point numbers in rad/s, and `expected.txt` with the values that the scene sets.
#![allow(clippy::unwrap_used)]

use std::{env, fs, path::Path};

use localizer::Reading;
use sim::{devices::Device, scene::Scene, truth::Truth};

const ANGLE_RANDOM_WALK_DEG_PER_SQRT_H: f64 = 0.3;
const BIAS_INSTABILITY_DEG_PER_H: f64 = 8.0;
const RATE_RANDOM_WALK_DEG_PER_H_PER_SQRT_H: f64 = 20.0;
const PERIOD_S: f64 = 0.05;
const N_RECORDS: u64 = 20;
const RECORD_S: f64 = 7200.0;

fn main() {
    let folder = env::args().nth(1).unwrap();
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).unwrap();
    let scene = Scene::parse(&scene_text(), "allan.toml").unwrap();
    for seed in 0..N_RECORDS {
        let gyro = scene.robot.gyro.as_ref().unwrap();
        let mut sensor = gyro.sensor(&gyro.draw(scene.robot.errors, seed), &scene, seed).unwrap();
        let rates = (0..=(RECORD_S / PERIOD_S) as u64).filter_map(|step| {
            let truth = Truth { time_s: step as f64 * PERIOD_S, ..Truth::default() };
            match sensor.observe(&truth, &[])?.reading {
                Reading::Gyro { rate_rad_per_s, .. } => Some(rate_rad_per_s),
                _ => None,
            }
        });
        let bytes: Vec<u8> = rates.flat_map(f64::to_le_bytes).collect();
        fs::write(folder.join(format!("{seed}.f64")), bytes).unwrap();
    }
    let expected = format!(
        "period_s {PERIOD_S}\nangle_random_walk {ANGLE_RANDOM_WALK_DEG_PER_SQRT_H}\n\
         bias_instability {BIAS_INSTABILITY_DEG_PER_H}\nrate_random_walk {RATE_RANDOM_WALK_DEG_PER_H_PER_SQRT_H}\n"
    );
    fs::write(folder.join("expected.txt"), expected).unwrap();
}

/// A scene with a robot at rest, with bounds on the gyroscope's errors too wide to clip them noticeably.
fn scene_text() -> String {
    format!(
        "[room]\nwidth_m = 3.0\ndepth_m = 3.0\n[start]\nx_m = 1.5\ny_m = 1.5\nheading_deg = 0\n[[station]]\nx_m = 1.5\ny_m = 1.5\nheading_deg = 0\n\
         [robot]\nfloor_camera = false\n[robot.gyro]\nperiod_s = {PERIOD_S}\nnoise_deg_per_s = 0.2\n\
         angle_random_walk_deg_per_sqrt_h = {ANGLE_RANDOM_WALK_DEG_PER_SQRT_H}\n\
         bias_instability_deg_per_h = {BIAS_INSTABILITY_DEG_PER_H}\n\
         rate_random_walk_deg_per_h_per_sqrt_h = {RATE_RANDOM_WALK_DEG_PER_H_PER_SQRT_H}\n\
         bias_wander_deg_per_s2 = 0.05\nbias_tolerance_deg_per_s = 0.2\n"
    )
}
