//! Benchmark of the operations of interval arithmetic on one core.

use std::hint::black_box;
use std::time::{Duration, Instant};

use interval::Interval;

fn main() {
    arithmetic();
}

/// Measures the throughput of interval operations over arrays, as contractors (operators that shrink boxes by a constraint) use them; loads and
/// stores are part of the times.
fn arithmetic() {
    let operands: Vec<Interval> =
        (0..1024).map(|idx| Interval::centred(f64::from(idx * 7919 % 1024) * 0.01 - 5.12, 0.15)).collect();
    let reversed: Vec<Interval> = operands.iter().rev().copied().collect();
    let positive: Vec<Interval> = reversed.iter().map(|x| *x + 6.0).collect();
    time("add", |(out, (a, b))| *out = *a + *b, &operands, &reversed);
    time("multiply", |(out, (a, b))| *out = *a * *b, &operands, &reversed);
    time("divide", |(out, (a, b))| *out = *a / *b, &operands, &positive);
    time("sine", |(out, (a, _))| *out = a.sin(), &operands, &reversed);
}

type Operands<'a> = (&'a mut Interval, (&'a Interval, &'a Interval));

fn time(name: &str, operation: impl Fn(Operands), a: &[Interval], b: &[Interval]) {
    let mut results = vec![Interval::ZERO; a.len()];
    let per_array = nanoseconds(|| {
        results.iter_mut().zip(black_box(a).iter().zip(black_box(b))).for_each(&operation);
        black_box(&results);
    });
    println!("{name:24} {:8.2} ns", per_array / a.len() as f64);
}

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
