//! Speed on this machine beside what is aimed at on two cores without a GPU: medians, printed as a table.

#![allow(clippy::unwrap_used)]

use std::{hint::black_box, path::Path, time::Instant};

use localizer::Interval;
use sim::{
    render::Renderer,
    run::{RunOptions, RunRecord, run},
    scene::Scene,
};

fn main() {
    println!("{:<44} {:>10}   aim", "what", "median");
    intervals();
    runs();
}

/// One line: what was measured, its median, what is aimed at.
fn line(what: &str, median: f64, unit: &str, aim: &str) {
    println!("{what:<44} {median:>10.2} {unit}   {aim}");
}

fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn intervals() {
    const COUNT: usize = 4096;
    let operands: Vec<Interval> =
        (0..COUNT).map(|index| Interval::centred(0.5 + index as f64 / COUNT as f64, 1e-3)).collect();
    // 1.5 times what the design measured: 1.3, 2.2, 2.9 and 41 ns.
    line("Interval add", nanoseconds(&operands, |a, b| a + b), "ns", "≤ 2.0");
    line("Interval mul", nanoseconds(&operands, |a, b| a * b), "ns", "≤ 3.3");
    line("Interval div", nanoseconds(&operands, |a, b| a / b), "ns", "≤ 4.4");
    line("Interval sin", nanoseconds(&operands, |a, _| a.sin()), "ns", "≤ 62");
}

/// Median time of one operation on neighbours in `operands`.
fn nanoseconds(operands: &[Interval], operation: impl Fn(Interval, Interval) -> Interval) -> f64 {
    let mut results = vec![Interval::ZERO; operands.len() - 1];
    let mut pass = |_| {
        let began = Instant::now();
        for (result, pair) in results.iter_mut().zip(black_box(operands).windows(2)) {
            *result = operation(pair[0], pair[1]);
        }
        black_box(&results);
        began.elapsed().as_secs_f64() * 1e9 / results.len() as f64
    };
    median((0..101).map(&mut pass).collect())
}

fn runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut seen = Scene::load(&root.join("scenes/papers/floor_vision_odometry.toml")).unwrap();
    seen.duration_s = 20.0;
    let mut blind = seen.clone();
    blind.robot.floor_camera = None;
    let factor = |record: &RunRecord| record.truths.last().unwrap().time_s / record.timing.wall_s;

    let options = RunOptions::default();
    let without: Vec<f64> =
        (0..5).map(|seed| factor(&run(&blind, seed, None, &options, &mut |_| {}).unwrap())).collect();
    line("simulation without cameras", median(without), "× real time", "≥ 200");

    let mut renderer = Renderer::new().unwrap();
    let records: Vec<RunRecord> =
        (0..3).map(|seed| run(&seen, seed, Some(&mut renderer), &options, &mut |_| {}).unwrap()).collect();
    line(
        "simulation with the floor camera at 5 Hz",
        median(records.iter().map(factor).collect()),
        "× real time",
        "≥ 8",
    );
    let per_image = |stage: fn(&RunRecord) -> f64| {
        median(records.iter().map(|record| 1e3 * stage(record) / record.images.len() as f64).collect())
    };
    line("floor_tiles, an image of 640 × 480", per_image(|record| record.timing.vision_s), "ms", "≤ 3");
    line("rendering and sensor, an image of 640 × 480", per_image(|record| record.timing.render_s), "ms", "");
}
