//! Benchmark of the contractors for a planar pose from matched landmarks, on the problem of paper 3 (Mustafa et al., CSCS 2015) and on one core.
//! `make bench` prints the times.
//!
//! The landmarks are at (3, 2), (−2, 3), (−3, −2.5), (2.5, −3) and the pose is (1, 0.5, 0.4), in metres and radians. All coordinates of
//! landmarks are known to ±0.1 m in both frames, with the errors listed in `landmarks`; the prior of the pose is ±3 m, ±3 m, ±3.14 rad. Where
//! Python can import the interval library Codac, `rigid_motion_codac.py` solves the same problem for comparison.

use std::hint::black_box;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use interval::{Interval, IntervalBox, contractor::Contractor, paving};
use localizer::rigid_motion::{LinearPose, RigidPlanar};

/// Nanoseconds that one call of `work` takes: the best of many short windows, because other work on the machine only ever adds time.
fn nanoseconds(mut work: impl FnMut()) -> f64 {
    let mut window = |n_calls: u32| {
        let start = Instant::now();
        (0..n_calls).for_each(|_| work());
        start.elapsed()
    };
    let mut n_calls = 1;
    while window(n_calls) < Duration::from_micros(200) {
        n_calls *= 2;
    }
    let best = (0..400).map(|_| window(n_calls)).min().unwrap_or_default();
    best.as_secs_f64() * 1e9 / f64::from(n_calls)
}

/// The landmarks of the benchmark problem: for each one its box in the world frame and its box in the robot frame.
fn landmarks() -> Vec<([Interval; 2], [Interval; 2])> {
    let places = [[3.0, 2.0], [-2.0, 3.0], [-3.0, -2.5], [2.5, -3.0]];
    let errors_a = [[0.5, -0.3], [-0.7, 0.2], [0.1, 0.6], [-0.4, -0.5]];
    let errors_b = [[-0.2, 0.4], [0.6, -0.6], [0.3, 0.1], [-0.5, 0.7]];
    let (x, y, heading) = (1.0, 0.5, 0.4f64);
    let radius = 0.1;
    (0..4)
        .map(|idx| {
            let [a_x, a_y] = places[idx];
            let (across, along) = (a_x - x, a_y - y);
            let b_x = heading.cos() * across + heading.sin() * along;
            let b_y = heading.cos() * along - heading.sin() * across;
            let around = |value: f64, error: f64| Interval::centred(value + radius * error, radius);
            (
                [around(a_x, errors_a[idx][0]), around(a_y, errors_a[idx][1])],
                [around(b_x, errors_b[idx][0]), around(b_y, errors_b[idx][1])],
            )
        })
        .collect()
}

#[allow(clippy::approx_constant, reason = "the problem's prior is ±3.14, not ±π")]
fn planar_problem() {
    let landmarks = landmarks();
    let prior =
        IntervalBox::new([Interval::centred(0.0, 3.0), Interval::centred(0.0, 3.0), Interval::centred(0.0, 3.14)]);
    let motion = RigidPlanar::new(&landmarks);
    let typical =
        IntervalBox::new([Interval::centred(1.1, 0.5), Interval::centred(0.4, 0.5), Interval::centred(0.45, 0.2)]);
    let pass = nanoseconds(|| {
        let mut domain = black_box(typical);
        motion.contract(&mut domain);
        black_box(domain);
    });
    println!("forward-backward pass    {:8.3} µs (goal: at most 0.5)", pass * 1e-3);
    let axes = [0, 1, 2];
    let sivia = nanoseconds(|| {
        let motion = RigidPlanar::new(black_box(&landmarks));
        black_box(paving::cover(&motion, prior, &axes, 0.05));
    });
    let coarse = paving::cover(&motion, prior, &axes, 0.05);
    println!("SIVIA ε = 0.05           {:8.3} ms (goal: at most 0.20), {} boxes", sivia * 1e-6, coarse.len());
    match codac(&landmarks) {
        Some(seconds) => {
            println!("Codac, same problem      {:8.3} ms ({:.0} times as long)", seconds * 1e3, seconds * 1e9 / sivia)
        }
        None => println!("Codac, same problem      not measured: Python cannot import codac"),
    }
    for n_slices in [0, 8, 16, 32] {
        let one_shot = nanoseconds(|| {
            let pose = LinearPose { motion: RigidPlanar::new(black_box(&landmarks)), n_slices };
            let mut domain = prior;
            pose.contract(&mut domain);
            black_box(domain);
        });
        let mut domain = prior;
        LinearPose { motion: motion.clone(), n_slices }.contract(&mut domain);
        println!("one shot, {n_slices:2} slices      {:8.3} µs  {}", one_shot * 1e-3, widths(&domain));
    }
    let fine = paving::cover(&motion, prior, &axes, 0.0125);
    println!("widths, SIVIA ε = 0.05              {}", widths(&paving::hull(&coarse)));
    println!("widths, SIVIA ε = 0.0125            {} ({} boxes)", widths(&paving::hull(&fine)), fine.len());
}

/// Seconds that the Python library Codac takes to pave the same problem; `None` when `$PYTHON` (or `python3`) cannot import it.
fn codac(landmarks: &[([Interval; 2], [Interval; 2])]) -> Option<f64> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/rigid_motion_codac.py");
    let python = std::env::var("PYTHON").unwrap_or("python3".into());
    let mut child = Command::new(python).arg(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    let mut input = child.stdin.take()?;
    for (a, b) in landmarks {
        let bounds = [a[0], a[1], b[0], b[1]].map(|x| format!("{:?} {:?}", x.lo(), x.hi()));
        writeln!(input, "{}", bounds.join(" ")).ok()?;
    }
    drop(input);
    let output = child.wait_with_output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn widths(pose: &IntervalBox<3>) -> String {
    format!("x {:.4} m, y {:.4} m, heading {:.4} rad", pose.width(0), pose.width(1), pose.width(2))
}

fn main() {
    planar_problem();
}
