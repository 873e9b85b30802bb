//! Lens distortion by Brown and Conrady's model: the difference between the image of a lens and that of a pinhole.
//!
//! The coefficients are k1, k2, p1, p2, k3; points are in focal lengths from the principal point, x right and y down. The lens shows at
//! D(x) = x + b(x) what a pinhole shows at x (Brown, *Decentering distortion of lenses*, 1966, in OpenCV's order). The inverse has no
//! closed form; for a box of image points it is enclosed by an interval Newton step.

use interval::{Dual, Interval};

/// Displacement b(x) of an image point by the lens: x·(k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2x²), and likewise
/// for y with p1 and p2 exchanged.
pub(crate) fn bend([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [f64; 2]) -> [f64; 2] {
    let square = x * x + y * y;
    let radial = square * (k1 + square * (k2 + square * k3));
    [
        x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    ]
}

/// Slopes of the lens distortion D, ∂D/∂x, as `[∂u/∂x, ∂u/∂y = ∂v/∂x, ∂v/∂y]`. D is the gradient of a function, so that this matrix is symmetric.
///
/// Where the matrix is positive definite all over a convex region, no two points of the region have the same image.
pub(crate) fn slopes([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [f64; 2]) -> [f64; 3] {
    let square = x * x + y * y;
    let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
    let growth = 2.0 * (k1 + square * (2.0 * k2 + square * 3.0 * k3));
    [
        radial + x * x * growth + 2.0 * p1 * y + 6.0 * p2 * x,
        x * y * growth + 2.0 * p1 * x + 2.0 * p2 * y,
        radial + y * y * growth + 6.0 * p1 * y + 2.0 * p2 * x,
    ]
}

/// Enclosure of the inverse lens distortion D⁻¹ over a box of image points: where a pinhole shows what the lens shows in that box, and the slopes of
/// D⁻¹ there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unbent {
    /// Enclosure of the inverse lens distortion D⁻¹ over a box of image points: the points at which a pinhole shows what the lens shows there.
    pub(crate) at: [Interval; 2],
    /// Slopes of the inverse lens distortion D⁻¹ over a box of image points, in the order in which [`slopes`] gives ∂D:
    /// the inverse of a symmetric matrix is symmetric.
    pub(crate) slopes: [Interval; 3],
}

/// Greatest number of Newton steps from a point in the lens's image to the point of the pinhole's image; each step doubles the correct digits.
const NEWTON_STEPS: usize = 30;
/// Greatest number of times that the trial box is widened because it does not contain the result of a Newton step from it. If more are needed, the
/// lens is about to fold (to show two points at one place).
const WIDENINGS: usize = 12;

/// Inverse lens distortion D⁻¹ over a box of image points. `None` where the lens folds (shows two points at one place) or is so close to folding that
/// this cannot be ruled out.
///
/// Let x₀ be near D⁻¹ of the box's middle, X a box around x₀, and J the slopes over X. If N = x₀ − J⁻¹·(D(x₀) − y) lies within X for all points y of
/// the given box, then for each y there is exactly one x in X with D(x) = y, and that x lies in N (Neumaier, *Interval methods for systems of
/// equations*, 1990, theorem 5.1.7). By the mean value theorem the rows of J belong to two different points, so that its inverse is formed without
/// using the symmetry.
pub(crate) fn unbent(distortion: [f64; 5], seen: [Interval; 2]) -> Option<Unbent> {
    if seen.iter().any(|at| !at.is_bounded() || at.is_empty()) {
        return None;
    }
    if distortion == [0.0; 5] {
        return Some(Unbent { at: seen, slopes: [Interval::ONE, Interval::ZERO, Interval::ONE] });
    }
    let middle = unbent_point(distortion, seen.map(Interval::mid))?;
    let start = middle.map(Interval::point);
    let bent = bend_over(distortion, start);
    let off = [0, 1].map(|axis| seen[axis] - start[axis] - bent[axis]);
    let mut within = start.map(|at| at.inflate(1e-12));
    for _ in 0..WIDENINGS {
        let step = newton(slopes_over(distortion, within), off)?;
        let next = [0, 1].map(|axis| start[axis] + step[axis]);
        if (0..2).all(|axis| next[axis].is_subset_of(within[axis])) {
            let [a, mixed, b] = slopes_over(distortion, next);
            let determinant = a * b - mixed.sqr();
            return Some(Unbent { at: next, slopes: [b / determinant, -mixed / determinant, a / determinant] });
        }
        // The trial box is widened by a tenth more than required, so that a box that is only just too small contains the result of the next Newton
        // step.
        within = [0, 1].map(|axis| next[axis].hull(within[axis]).inflate(0.1 * next[axis].radius()));
    }
    None
}

/// Inverse lens distortion of an image point whose two coordinates depend on some parameters: each is given as an interval of values and intervals of
/// slopes by the parameters. The slopes of the result follow from the chain rule.
pub(crate) fn unbent_models<const K: usize>(distortion: [f64; 5], seen: [Dual<K>; 2]) -> Option<[Dual<K>; 2]> {
    let Unbent { at, slopes: [a, mixed, b] } = unbent(distortion, seen.map(|model| model.value))?;
    let row = |value: Interval, by_x: Interval, by_y: Interval| Dual {
        value,
        slopes: std::array::from_fn(|k| by_x * seen[0].slopes[k] + by_y * seen[1].slopes[k]),
    };
    Some([row(at[0], a, mixed), row(at[1], mixed, b)])
}

/// Inverse lens distortion D⁻¹ of a single image point, in ordinary floating-point numbers. The Newton iteration starts at the point itself and gives
/// up at a fold of the lens.
pub(crate) fn unbent_point(distortion: [f64; 5], seen: [f64; 2]) -> Option<[f64; 2]> {
    let mut at = seen;
    for _ in 0..NEWTON_STEPS {
        let bent = bend(distortion, at);
        let [u, v] = [0, 1].map(|axis| at[axis] + bent[axis] - seen[axis]);
        let [a, mixed, b] = slopes(distortion, at);
        let determinant = a * b - mixed * mixed;
        if !(determinant > 0.0 && a > 0.0) {
            return None;
        }
        let step = [(b * u - mixed * v) / determinant, (a * v - mixed * u) / determinant];
        at = [at[0] - step[0], at[1] - step[1]];
        if step[0].hypot(step[1]) < 1e-14 {
            break;
        }
    }
    Some(at)
}

/// One interval Newton step: encloses the solutions x of J·x = `[u, v]` for every matrix J whose rows lie in the given intervals. `None` where J may
/// be singular or may reverse the orientation.
fn newton([a, mixed, b]: [Interval; 3], [u, v]: [Interval; 2]) -> Option<[Interval; 2]> {
    let determinant = a * b - mixed * mixed;
    let is_regular = determinant.lo() > 0.0 && a.lo() > 0.0;
    is_regular.then(|| [(b * u - mixed * v) / determinant, (a * v - mixed * u) / determinant])
}

/// Enclosure of the displacement [`bend`] over a box of image points.
pub(crate) fn bend_over([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [Interval; 2]) -> [Interval; 2] {
    let square = x.sqr() + y.sqr();
    let radial = square * (square * (square * k3 + k2) + k1);
    [
        x * radial + x * y * (2.0 * p1) + (square + x.sqr() * 2.0) * p2,
        y * radial + (square + y.sqr() * 2.0) * p1 + x * y * (2.0 * p2),
    ]
}

/// Enclosure of [`slopes`] over a box of image points.
pub(crate) fn slopes_over([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [Interval; 2]) -> [Interval; 3] {
    let square = x.sqr() + y.sqr();
    let radial = square * (square * (square * k3 + k2) + k1) + 1.0;
    let growth = (square * (square * k3 * 3.0 + 2.0 * k2) + k1) * 2.0;
    [
        radial + x.sqr() * growth + y * (2.0 * p1) + x * p2 * 6.0,
        x * y * growth + x * (2.0 * p1) + y * (2.0 * p2),
        radial + y.sqr() * growth + y * p1 * 6.0 + x * (2.0 * p2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BARREL: [f64; 5] = [-0.25, 0.06, 0.001, -0.002, 0.0];

    #[test]
    fn whatever_bends_into_a_box_is_enclosed_with_the_slopes_there() {
        let mut random = crate::vision::synthetic::Random::new(71);
        let mut widest: f64 = 0.0;
        for _ in 0..10_000 {
            let at = [random.between(-0.9, 0.9), random.between(-0.7, 0.7)];
            let bent = bend(BARREL, at);
            let radius = [0.0, 0.001, 0.012][(random.unit() * 3.0) as usize];
            let corner =
                |random: &mut crate::vision::synthetic::Random| [-1.0, 1.0, 0.3][(random.unit() * 3.0) as usize];
            let seen = [0, 1].map(|axis| {
                let off = radius * corner(&mut random);
                Interval::centred(at[axis] + bent[axis] - off, radius).inflate(1e-15)
            });
            let found = unbent(BARREL, seen).unwrap_or_else(|| panic!("nothing at {at:?}"));
            let [a, mixed, b] = slopes(BARREL, at);
            let determinant = a * b - mixed * mixed;
            let holds = |interval: Interval, value: f64| interval.inflate(1e-12).contains(value);
            assert!(holds(found.at[0], at[0]) && holds(found.at[1], at[1]), "{at:?} {found:?}");
            let inverse = [b / determinant, -mixed / determinant, a / determinant];
            assert!((0..3).all(|k| holds(found.slopes[k], inverse[k])), "{at:?} {inverse:?} {found:?}");
            if radius == 0.001 {
                widest = widest.max(found.at[0].width().max(found.at[1].width()));
            }
        }
        // By hand, for the lens of this test: the inverse distortion stretches by at most 1/(1 − 3·0.25·1.3 + 5·0.06·1.69) = 1.9, both along the
        // radius and across it.
        assert!(widest < 2.2 * 0.002, "{widest}");
    }

    #[test]
    fn nothing_is_told_beyond_a_fold() {
        // By hand, for a lens with k1 = −0.25 only: the distorted radius r·(1 − 0.25·r²) is greatest at r = 2/√3 = 1.155, where it is 0.770.
        let lens = [-0.25, 0.0, 0.0, 0.0, 0.0];
        let at = |r: f64| unbent(lens, [Interval::centred(r, 0.001), Interval::ZERO]);
        assert!(at(0.70).is_some() && at(0.78).is_none() && at(1.5).is_none());
    }

    #[test]
    fn slopes_are_the_differences_of_neighbours() {
        let distortion = [-0.25, 0.06, 0.001, -0.002, 0.01];
        let seen = |[x, y]: [f64; 2]| {
            let [u, v] = bend(distortion, [x, y]);
            [x + u, y + v]
        };
        for [x, y] in [[0.0, 0.0], [0.7, -0.3], [-0.9, 0.6]] {
            let step = 1e-5;
            let apart = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|axis| (b[axis] - a[axis]) / (2.0 * step));
            let [uu, vu] = apart(seen([x - step, y]), seen([x + step, y]));
            let [uv, vv] = apart(seen([x, y - step]), seen([x, y + step]));
            let found = slopes(distortion, [x, y]);
            for (expected, found) in [(uu, found[0]), (uv, found[1]), (vu, found[1]), (vv, found[2])] {
                assert!((expected - found).abs() < 1e-8, "{expected} {found}");
            }
        }
    }
}
