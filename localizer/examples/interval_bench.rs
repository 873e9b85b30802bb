//! Times the arithmetic and the planar problem of paper 3 on one core; `make bench` prints it.
//!
//! Landmarks (3, 2), (−2, 3), (−3, −2.5), (2.5, −3), pose (1, 0.5, 0.4), all coordinates known to ±0.1 m in both frames, with errors as
//! in the issue; prior ±3 m, ±3 m, ±3.14 rad. Codac, when Python can import it, solves the same problem in `bench_codac.py`.

use std::hint::black_box;
use std::time::Instant;

use localizer::contractor::{LinearPose, RigidPlanar};
use localizer::{Contractor, Interval, IntervalBox, paving};

/// Best of several runs: other work on the machine only ever adds time.
fn nanoseconds(n: usize, mut work: impl FnMut(usize)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..9 {
        let start = Instant::now();
        for idx in 0..n {
            work(idx);
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / n as f64);
    }
    best
}

/// Throughput over arrays, as contractors use it; the loads and stores are part of it.
fn arithmetic() {
    let operands: Vec<Interval> =
        (0..1024).map(|idx| Interval::centred(f64::from(idx * 7919 % 1024) * 0.01 - 5.12, 0.15)).collect();
    let mut results = vec![Interval::ZERO; 1024];
    let mut time = |name: &str, operation: fn(&[Interval], &[Interval], &mut [Interval])| {
        let shifted: Vec<Interval> = operands.iter().rev().copied().collect();
        let per_call = nanoseconds(2000, |_| {
            operation(black_box(&operands), black_box(&shifted), &mut results);
            black_box(&results);
        });
        println!("{name:24} {:8.2} ns", per_call / 1024.0);
    };
    time("add", |a, b, out| out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (a, b))| *out = *a + *b));
    time("multiply", |a, b, out| out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (a, b))| *out = *a * *b));
    time("divide", |a, b, out| out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (a, b))| *out = *a / (*b + 6.0)));
    time("sine", |a, _, out| out.iter_mut().zip(a).for_each(|(out, a)| *out = a.sin()));
}

/// The landmark boxes of the problem, in the first frame and in the second.
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

fn planar_problem() {
    let landmarks = landmarks();
    let prior =
        IntervalBox::new([Interval::centred(0.0, 3.0), Interval::centred(0.0, 3.0), Interval::centred(0.0, 3.14)]);
    let motion = RigidPlanar::new(&landmarks);
    let typical =
        IntervalBox::new([Interval::centred(1.1, 0.5), Interval::centred(0.4, 0.5), Interval::centred(0.45, 0.2)]);
    let pass = nanoseconds(100_000, |_| {
        let mut domain = black_box(typical);
        motion.contract(&mut domain);
        black_box(domain);
    });
    println!("forward-backward pass    {:8.3} µs (asked: at most 0.5)", pass * 1e-3);
    let axes = [0, 1, 2];
    let sivia = nanoseconds(20, |_| {
        let motion = RigidPlanar::new(black_box(&landmarks));
        black_box(paving::cover(&motion, prior, &axes, 0.05));
    });
    let coarse = paving::cover(&motion, prior, &axes, 0.05);
    println!("SIVIA ε = 0.05           {:8.3} ms (asked: at most 0.20), {} boxes", sivia * 1e-6, coarse.len());
    for n_slices in [0, 8, 16, 32] {
        let one_shot = nanoseconds(20_000, |_| {
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

fn widths(pose: &IntervalBox<3>) -> String {
    format!("x {:.4} m, y {:.4} m, heading {:.4} rad", pose.width(0), pose.width(1), pose.width(2))
}

fn main() {
    arithmetic();
    planar_problem();
}
