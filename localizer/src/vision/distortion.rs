//! Brown and Conrady's lens: what it adds to the picture of a pinhole.
//!
//! Coefficients k1, k2, p1, p2, k3 and points in focal lengths from the principal point, x right and y down. The lens puts what a
//! pinhole shows at x to D(x) = x + b(x) (Brown, *Decentering distortion of lenses*, 1966, in OpenCV's order).

/// b(x): x·(k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2x²), and likewise for y with p1 and p2 exchanged.
pub(crate) fn bend([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [f64; 2]) -> [f64; 2] {
    let square = x * x + y * y;
    let radial = square * (k1 + square * (k2 + square * k3));
    [
        x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    ]
}

/// ∂D/∂x as `[∂u/∂x, ∂u/∂y = ∂v/∂x, ∂v/∂y]`: D is the gradient of a function, so that the matrix is symmetric.
///
/// Where it is positive definite all over a convex region, no two points of the region have one image.
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

#[cfg(test)]
mod tests {
    use super::*;

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
