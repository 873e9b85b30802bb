//! Tilts about level axes as first-order models, written as Cayley vectors, which need no trigonometry.

use interval::{Dual, Interval};

/// Vector v after the tilt T(a), with a the horizontal Cayley vector tan(α/2)·axis: T(a) v = v + 2 (a × v + a × (a × v))/(1 + |a|²).
pub(super) fn tilted<const N: usize>(v: [Dual<N>; 3], [a, b]: [Dual<N>; 2]) -> [Dual<N>; 3] {
    // The cross product a × v for a = (a, b, 0).
    let cross = |v: &[Dual<N>; 3]| [b * v[2], -(a * v[2]), a * v[1] - b * v[0]];
    let once = cross(&v);
    let twice = cross(&once);
    let one = Dual::constant(Interval::ONE);
    let factor = Dual::constant(Interval::point(2.0)) / (one + square(a) + square(b));
    [0, 1, 2].map(|k| v[k] + factor * (once[k] + twice[k]))
}

fn square<const N: usize>(a: Dual<N>) -> Dual<N> {
    let product = a * a;
    Dual { value: a.value.sqr(), ..product }
}
