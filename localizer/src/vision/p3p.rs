//! Pose of a camera from three points (P3P; paper 5, Eqs. 10 to 15): finds all solutions.
//!
//! The algorithm is Lambda Twist (M. Persson, K. Nordberg, ECCV 2018): by one real root of a cubic, the three quadrics λᵀMλ = a of Eq. (10)
//! are reduced to a pair of planes; each plane leaves a quadratic equation. Every solution is refined by Newton's method on Eq. (10) itself
//! and kept only if it satisfies that equation, so that there are no wrong roots.

#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

/// Pose of the camera as a rigid motion: `point_in_camera = rotation · point_in_world + translation_m` (Eq. 15).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// Rotation from the world frame to the camera frame (`camera_from_world`).
    pub rotation: Matrix3<f64>,
    /// Origin of the world in the camera frame.
    pub translation_m: Vector3<f64>,
}

/// Greatest residual of the P3P equations, Eq. (10) of paper 5, that a solution may have, relative to the squared sides of the triangle of points.
const RESIDUAL: f64 = 1e-10;
/// Length of a Newton step, relative to the distances, below which it is the last one: the next step would be about the square of it, below rounding.
/// Only at double roots the next step would be half as long, and these are not known better than to the square root of the rounding error, 1e-8.
const LAST_STEP: f64 = 1e-9;
/// Greatest number of Newton steps in the refinement of the points' distances. Newton's method converges quadratically, except at double roots, where
/// each step only halves the error.
const MOST_STEPS: usize = 24;

/// All camera poses from which three points of the world are seen in the directions `rays` (of any length); none if the points lie on a line.
pub fn solve(rays: &[Vector3<f64>; 3], points_m: &[Vector3<f64>; 3]) -> Vec<CameraPose> {
    let rays = rays.map(|ray| ray * (1.0 / ray.norm()));
    let sides = [points_m[0] - points_m[1], points_m[0] - points_m[2], points_m[1] - points_m[2]];
    let across = sides[0].cross(&sides[1]);
    let world = Matrix3::from_columns(&[sides[0], sides[1], across]);
    let Some(inverse) = world.try_inverse() else { return Vec::new() };
    // For unit vectors 1 − cos γ = |r − r'|²/2, which is exact for small angles too, where the cosine is rounded to almost 1.
    let versine = |a: usize, b: usize| 0.5 * (rays[a] - rays[b]).norm_squared();
    let triangle = Triangle {
        squares: sides.map(|side| side.norm_squared()),
        versines: [versine(0, 1), versine(0, 2), versine(1, 2)],
    };
    let mut poses = Vec::with_capacity(4);
    for distances in triangle.distances() {
        let seen = [0, 1, 2].map(|k| rays[k] * distances[k]);
        let (first, second) = (seen[0] - seen[1], seen[0] - seen[2]);
        let rotation = Matrix3::from_columns(&[first, second, first.cross(&second)]) * inverse;
        poses.push(CameraPose { rotation, translation_m: seen[0] - rotation * points_m[0] });
    }
    poses
}

/// Known quantities of the P3P equations, Eq. (10): the squared sides 12, 13, 23 of the triangle of points and the versines 1 − cos γ of the angles
/// between the rays 12, 13, 23.
///
/// With versines the equation of a pair of points reads (d − d')² + 2dd'(1 − cos γ) = a. Its terms are positive and no greater than the squared side
/// a, so that nothing cancels when a small triangle is far away, as d² + d'² − 2dd' cos γ does.
struct Triangle {
    squares: [f64; 3],
    versines: [f64; 3],
}

impl Triangle {
    /// All solutions of the P3P equations for the distances, all positive, from the camera to the three points.
    fn distances(&self) -> Vec<Vector3<f64>> {
        let mut found: Vec<Vector3<f64>> = Vec::with_capacity(4);
        for ratio in self.sharpest_roots() {
            for start in self.on_planes(ratio) {
                let Some(distances) = self.polished(start) else { continue };
                let is_new =
                    |other: &Vector3<f64>| (other - distances).norm_squared() > 1e-14 * distances.norm_squared();
                if found.iter().all(is_new) {
                    found.push(distances);
                }
            }
            // Each real root of the cubic leads to the same camera poses; another root is tried only if the previous one gave none.
            if !found.is_empty() {
                break;
            }
        }
        found
    }

    /// Real roots g of det(D₁ + g D₂) = 0, the cubic of the P3P solver, the root with the greatest slope first.
    fn sharpest_roots(&self) -> impl Iterator<Item = f64> {
        let ([a12, a13, a23], [v12, v13, v23]) = (self.squares, self.versines);
        // cos γ₁₂ cos γ₁₃ cos γ₂₃ − 1, and sin² γ of the three angles.
        let blob = v12 * (v13 + v23) + v13 * v23 - v12 * v13 * v23 - (v12 + v13 + v23);
        let [s12, s13, s23] = self.versines.map(|versine| versine * (2.0 - versine));
        let cubic = a13 * (a23 * s13 - a13 * s23);
        let square = 2.0 * blob * a23 * a13 + a13 * (2.0 * a12 + a13) * s23 + a23 * (a23 - a12) * s13;
        let linear = a23 * (a13 - a23) * s12 - a12 * a12 * s23 - 2.0 * a12 * (blob * a23 + a13 * s23);
        let constant = a12 * (a12 * s23 - a23 * s12);
        let mut roots = real_roots(cubic, square, linear, constant);
        let slope = |g: f64| ((3.0 * cubic * g + 2.0 * square) * g + linear).abs();
        for other in 1..3 {
            if slope(roots[other]) > slope(roots[0]) {
                roots.swap(0, other);
            }
        }
        let polish = move |g: f64| polished_root([cubic, square, linear, constant], g);
        roots.into_iter().filter(|root| root.is_finite()).map(polish)
    }

    /// Candidate distances of the three points on the two planes into which the degenerate quadric D₁ + g D₂ decomposes.
    fn on_planes(&self, g: f64) -> impl Iterator<Item = Vector3<f64>> {
        let ([a12, a13, a23], v23) = (self.squares, self.versines[2]);
        let [c12, c13, c23] = self.versines.map(|versine| 1.0 - versine);
        let off = c23 * (a12 - a13 * g);
        #[rustfmt::skip]
        let quadric = Matrix3::new(
            a23 * (1.0 - g), -a23 * c12, a23 * c13 * g,
            -a23 * c12, a23 - a12 + a13 * g, off,
            a23 * c13 * g, off, g * (a13 - a23) - a12,
        );
        let planes = eigen_with_zero(&quadric).map(|(vectors, values)| {
            let slope = (-values[1] / values[0]).max(0.0).sqrt();
            [vectors[0] - slope * vectors[1], vectors[0] + slope * vectors[1]]
        });
        planes.into_iter().flatten().flat_map(move |normal| {
            // From the plane normal·λ = 0 follows λ₁ = w₀ λ₂ + w₁ λ₃.
            let (w0, w1) = (-normal[1] / normal[0], -normal[2] / normal[0]);
            // With the ratio of distances τ = λ₃/λ₂, the quadrics 12 and 13 together give a τ² + b τ + c = 0.
            let a = (a13 - a12) * w1 * w1 + 2.0 * a12 * c13 * w1 - a12;
            let b = -2.0 * a13 * c12 * w1 + 2.0 * a12 * c13 * w0 - 2.0 * w0 * w1 * (a12 - a13);
            let c = (a13 - a12) * w0 * w0 - 2.0 * a13 * c12 * w0 + a13;
            quadratic_roots(a, b, c).into_iter().filter_map(move |ratio| {
                let square = a23 / ((1.0 - ratio) * (1.0 - ratio) + 2.0 * ratio * v23);
                let second = square.sqrt();
                let third = ratio * second;
                (ratio > 0.0 && square > 0.0).then(|| Vector3::new(w0 * second + w1 * third, second, third))
            })
        })
    }

    /// Refines distances by Newton's method on Eq. (10); `None` if the iteration does not end in a positive solution.
    fn polished(&self, mut distances: Vector3<f64>) -> Option<Vector3<f64>> {
        let ([a12, a13, a23], [v12, v13, v23]) = (self.squares, self.versines);
        let per_square = self.squares.map(|square| 1.0 / square);
        let mut least = f64::INFINITY;
        let mut best = distances;
        let mut is_last = false;
        for _ in 0..=MOST_STEPS {
            let [d1, d2, d3] = [distances[0], distances[1], distances[2]];
            let (e12, e13, e23) = (d1 - d2, d1 - d3, d2 - d3);
            let residual = [
                e12 * e12 + 2.0 * d1 * d2 * v12 - a12,
                e13 * e13 + 2.0 * d1 * d3 * v13 - a13,
                e23 * e23 + 2.0 * d2 * d3 * v23 - a23,
            ];
            let size = (0..3).fold(0.0f64, |size, k| size.max(residual[k].abs() * per_square[k]));
            if size < least {
                (least, best) = (size, distances);
            }
            if is_last {
                break;
            }
            // Half of the Jacobian matrix of the P3P equations, with rows for the pairs of points 12, 13 and 23.
            let (j11, j12) = (e12 + d2 * v12, d1 * v12 - e12);
            let (j21, j23) = (e13 + d3 * v13, d1 * v13 - e13);
            let (j32, j33) = (e23 + d3 * v23, d2 * v23 - e23);
            let determinant = -j11 * j23 * j32 - j12 * j21 * j33;
            if determinant == 0.0 || !determinant.is_finite() {
                break;
            }
            let half = residual.map(|residual| 0.5 * residual / determinant);
            // The Newton step uses the cofactors of the matrix [[j11, j12, 0], [j21, 0, j23], [0, j32, j33]].
            let step = Vector3::new(
                -j23 * j32 * half[0] - j12 * j33 * half[1] + j12 * j23 * half[2],
                -j21 * j33 * half[0] + j11 * j33 * half[1] - j11 * j23 * half[2],
                j21 * j32 * half[0] - j11 * j32 * half[1] - j12 * j21 * half[2],
            );
            distances -= step;
            is_last = step.norm_squared() <= LAST_STEP * LAST_STEP * distances.norm_squared();
        }
        (least < RESIDUAL && best.iter().all(|distance| *distance > 0.0)).then_some(best)
    }
}

/// Eigenvectors and eigenvalues of a symmetric matrix with determinant 0, without the eigenvalue zero; the one with the larger magnitude first.
fn eigen_with_zero(m: &Matrix3<f64>) -> Option<([Vector3<f64>; 2], [f64; 2])> {
    // The eigenvector of the eigenvalue 0 is the cross product of two rows; the longest cross product is the most accurate.
    let rows = [m.row(0).transpose(), m.row(1).transpose(), m.row(2).transpose()];
    let crosses = [rows[0].cross(&rows[1]), rows[0].cross(&rows[2]), rows[1].cross(&rows[2])];
    let longest = crosses.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let null = longest.try_normalize(0.0)?;
    // In a basis of the plane orthogonal to that eigenvector, a 2 × 2 eigenvalue problem remains.
    let least = null.iamin();
    let first = null.cross(&Vector3::ith(least, 1.0)).normalize();
    let second = null.cross(&first);
    let (p, q, r) = ((m * first).dot(&first), (m * second).dot(&second), (m * first).dot(&second));
    let (mean, spread) = (0.5 * (p + q), (0.25 * (p - q) * (p - q) + r * r).sqrt());
    let large = if mean > 0.0 { mean + spread } else { mean - spread };
    // The product of the two eigenvalues is the determinant; dividing it by the larger one avoids cancellation.
    let small = if large == 0.0 { 0.0 } else { (p * q - r * r) / large };
    let (u, v) = if (large - p).abs() > (large - q).abs() { (r, large - p) } else { (large - q, r) };
    let length = (u * u + v * v).sqrt();
    let (u, v) = if length > 0.0 { (u / length, v / length) } else { (1.0, 0.0) };
    Some(([first * u + second * v, second * u - first * v], [large, small]))
}

/// Real roots of a x² + b x + c; NaN for those that do not exist. A double root is returned twice, also when rounding has made the discriminant
/// slightly negative.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    // A discriminant just below 0 means two solutions that coincide but for rounding; Newton's method decides later whether they are solutions.
    if discriminant < -1e-7 * b * b {
        return [f64::NAN; 2];
    }
    let root = discriminant.max(0.0).sqrt();
    let q = -0.5 * (b + if b > 0.0 { root } else { -root });
    [q / a, c / q]
}

/// Real roots of a cubic, by the trigonometric formula or by radicals; NaN for those that do not exist.
fn real_roots(cubic: f64, square: f64, linear: f64, constant: f64) -> [f64; 3] {
    let scale = square.abs().max(linear.abs()).max(constant.abs());
    if cubic.abs() < 1e-14 * scale {
        let [first, second] = quadratic_roots(square, linear, constant);
        return [first, second, f64::NAN];
    }
    let (b, c, d) = (square / cubic, linear / cubic, constant / cubic);
    // With x = t − b/3 the cubic becomes t³ + p t + q = 0.
    let third = b / 3.0;
    let p = c - b * third;
    let q = (2.0 * third * third - c) * third + d;
    let discriminant = 0.25 * q * q + p * p * p / 27.0;
    if discriminant > 0.0 {
        let sum = -0.5 * q - discriminant.sqrt().copysign(q);
        let first = sum.cbrt();
        let other = if first == 0.0 { 0.0 } else { -p / (3.0 * first) };
        return [first + other - third, f64::NAN, f64::NAN];
    }
    let radius = (-p / 3.0).max(0.0).sqrt();
    let cosine = if radius == 0.0 { 0.0 } else { (-0.5 * q / (radius * radius * radius)).clamp(-1.0, 1.0) };
    // The roots are 2 r cos(φ − 2πk/3), with φ a third of the angle and k = 0, 1, 2.
    let (sin, cos) = (cosine.acos() / 3.0).sin_cos();
    let side = 3.0f64.sqrt() * sin;
    [2.0 * cos, side - cos, -side - cos].map(|unit| radius * unit - third)
}

/// A root of a cubic, refined by Newton's method.
fn polished_root([cubic, square, linear, constant]: [f64; 4], mut x: f64) -> f64 {
    for _ in 0..3 {
        let value = ((cubic * x + square) * x + linear) * x + constant;
        let slope = (3.0 * cubic * x + 2.0 * square) * x + linear;
        if value.abs() <= 1e-14 * (slope * x).abs() {
            break;
        }
        x -= value / slope;
    }
    x
}
