//! Benchmark of a long drive: whether the memory of the localizer, and its time for a step, grow with the length of the drive.
//!
//! Paper 3's loop goes on for 1000 s, which are 100 000 steps, with up to 100 key frames and 36 landmarks that no map gives. What
//! the localizer allocates and frees while it takes in readings is counted apart from everything else in the process.

#![allow(clippy::unwrap_used)]

use std::{path::Path, time::Instant};

use localizer::{PoseBox, Reading};
use peak_alloc::PeakAlloc;
use sim::{
    run::{RunOptions, run},
    scene::Scene,
    subject::{Answer, IntervalLocalizer, Subject},
};

/// Length of the drive, in seconds.
const LENGTH_S: f64 = 1000.0;
/// Time after which 100 key frames are full, in seconds. Growth is measured from then on.
const FULL_S: f64 = 250.0;
/// Number of spans of which the mean time for a step is printed.
const N_SPANS: usize = 4;

/// The allocator, which knows how many bytes are in use.
#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// A localizer whose memory and time are measured.
struct Measured {
    subject: IntervalLocalizer,
    /// Time of each wheel reading, bytes held by the localizer after it, and seconds that it took with all readings since the one before.
    steps: Vec<(f64, f64, f64)>,
    bytes: f64,
    now_s: f64,
}

impl Subject for Measured {
    fn start(&mut self, start: &PoseBox) {
        self.subject.start(start);
    }

    fn observe(&mut self, reading: &Reading) {
        let (began, before) = (Instant::now(), ALLOCATOR.current_usage());
        self.subject.observe(reading);
        // What the localizer hands over after each reading is not what it holds.
        drop(self.subject.accounts());
        self.bytes += ALLOCATOR.current_usage() as f64 - before as f64;
        self.now_s += began.elapsed().as_secs_f64();
        if let Reading::Wheels { measured_s, .. } = reading {
            self.steps.push((*measured_s, self.bytes, std::mem::take(&mut self.now_s)));
        }
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        self.subject.estimate_at(time_s)
    }
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut scene = Scene::load(&root.join("scenes/papers/rigid_transform_loop.toml")).unwrap();
    scene.duration_s = LENGTH_S;
    let steps = Vec::with_capacity((LENGTH_S * 110.0) as usize);
    let mut measured = Measured { subject: IntervalLocalizer::of(&scene), steps, bytes: 0.0, now_s: 0.0 };
    let record = run(&scene, 0, &mut measured, None, &RunOptions::default(), &mut |_| {}).unwrap();
    let contained = record.estimates.iter().zip(&record.truths).filter(|(one, truth)| one.pose.contains(truth.pose));
    println!("{} of {} steps contain the truth", contained.count(), record.truths.len());
    println!("{:>16} {:>12} {:>12} {:>14}", "from … to, s", "mean, ms", "longest, ms", "memory, MB");
    for span in 0..N_SPANS {
        let [from_s, to_s] = [span, span + 1].map(|end| FULL_S + (LENGTH_S - FULL_S) * end as f64 / N_SPANS as f64);
        let steps = measured.steps.iter().filter(|(time_s, ..)| (from_s..to_s).contains(time_s));
        let (n_steps, most_bytes, sum_s, longest_s) = steps
            .fold((0, 0.0_f64, 0.0, 0.0_f64), |(n, most, sum, longest), step| {
                (n + 1, most.max(step.1), sum + step.2, longest.max(step.2))
            });
        let (mean_ms, longest_ms) = (1e3 * sum_s / f64::from(n_steps), 1e3 * longest_s);
        println!("{from_s:>7} … {to_s:>6} {mean_ms:>12.3} {longest_ms:>12.2} {:>14.3}", most_bytes / 1e6);
    }
}
