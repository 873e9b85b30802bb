//! Pose of a camera from three points (P3P; paper 5, Eqs. 10 to 15): finds all solutions.
//!
//! The algorithm is Lambda Twist (M. Persson, K. Nordberg, ECCV 2018): by one real root of a cubic, the three quadrics λᵀMλ = a of Eq. (10)
//! are reduced to a pair of planes; each plane leaves a quadratic equation. Every solution is refined by Newton's method on Eq. (10) itself
//! and kept only if it satisfies that equation, so that there are no wrong roots.

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
/// Greatest number of Newton steps in the refinement of the points' distances. Newton's method converges quadratically, except at double roots, where
/// each step only halves the error.
const MOST_STEPS: usize = 24;

/// All camera poses from which three points of the world are seen in the directions `rays` (of any length); none if the points lie on a line.
pub fn solve(rays: &[Vector3<f64>; 3], points_m: &[Vector3<f64>; 3]) -> Vec<CameraPose> {
    let rays = rays.map(|ray| ray / ray.norm());
    let sides = [points_m[0] - points_m[1], points_m[0] - points_m[2], points_m[1] - points_m[2]];
    let across = sides[0].cross(&sides[1]);
    let world = Matrix3::from_columns(&[sides[0], sides[1], across]);
    let Some(inverse) = world.try_inverse() else { return Vec::new() };
    let triangle = Triangle {
        squares: sides.map(|side| side.norm_squared()),
        cosines: [rays[0].dot(&rays[1]), rays[0].dot(&rays[2]), rays[1].dot(&rays[2])],
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

/// Known quantities of the P3P equations, Eq. (10): the squared sides 12, 13, 23 of the triangle of points and the
/// cosines of the angles between the rays 12, 13, 23.
struct Triangle {
    squares: [f64; 3],
    cosines: [f64; 3],
}

impl Triangle {
    /// All solutions of the P3P equations for the distances, all positive, from the camera to the three points.
    fn distances(&self) -> Vec<Vector3<f64>> {
        let mut found: Vec<Vector3<f64>> = Vec::with_capacity(4);
        for ratio in self.sharpest_roots() {
            for start in self.on_planes(ratio) {
                let Some(distances) = self.polished(start) else { continue };
                let is_new = |other: &Vector3<f64>| (other - distances).norm() > 1e-7 * distances.norm();
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
    fn sharpest_roots(&self) -> Vec<f64> {
        let ([a12, a13, a23], [c12, c13, c23]) = (self.squares, self.cosines);
        let blob = c12 * c23 * c13 - 1.0;
        let [s12, s13, s23] = [c12, c13, c23].map(|cosine| 1.0 - cosine * cosine);
        let cubic = a13 * (a23 * s13 - a13 * s23);
        let square = 2.0 * blob * a23 * a13 + a13 * (2.0 * a12 + a13) * s23 + a23 * (a23 - a12) * s13;
        let linear = a23 * (a13 - a23) * s12 - a12 * a12 * s23 - 2.0 * a12 * (blob * a23 + a13 * s23);
        let constant = a12 * (a12 * s23 - a23 * s12);
        let mut roots = real_roots(cubic, square, linear, constant);
        let slope = |g: f64| ((3.0 * cubic * g + 2.0 * square) * g + linear).abs();
        roots.sort_by(|a, b| slope(*b).total_cmp(&slope(*a)));
        roots
    }

    /// Candidate distances of the three points on the two planes into which the degenerate quadric D₁ + g D₂ decomposes.
    fn on_planes(&self, g: f64) -> Vec<Vector3<f64>> {
        let ([a12, a13, a23], [c12, c13, c23]) = (self.squares, self.cosines);
        let (b12, b13, b23) = (-2.0 * c12, -2.0 * c13, -2.0 * c23);
        let off = 0.5 * b23 * (a13 * g - a12);
        #[rustfmt::skip]
        let quadric = Matrix3::new(
            a23 * (1.0 - g), 0.5 * a23 * b12, -0.5 * a23 * b13 * g,
            0.5 * a23 * b12, a23 - a12 + a13 * g, off,
            -0.5 * a23 * b13 * g, off, g * (a13 - a23) - a12,
        );
        let Some((vectors, values)) = eigen_with_zero(&quadric) else { return Vec::new() };
        let slope = (-values[1] / values[0]).max(0.0).sqrt();
        let mut found = Vec::with_capacity(4);
        for s in [slope, -slope] {
            // From the plane (v₀ − s v₁)·λ = 0 follows λ₁ = w₀ λ₂ + w₁ λ₃.
            let normal = vectors[0] - s * vectors[1];
            let (w0, w1) = (-normal[1] / normal[0], -normal[2] / normal[0]);
            // With the ratio of distances τ = λ₃/λ₂, the quadrics 12 and 13 together give a τ² + b τ + c = 0.
            let a = (a13 - a12) * w1 * w1 - a12 * b13 * w1 - a12;
            let b = a13 * b12 * w1 - a12 * b13 * w0 - 2.0 * w0 * w1 * (a12 - a13);
            let c = (a13 - a12) * w0 * w0 + a13 * b12 * w0 + a13;
            for ratio in quadratic_roots(a, b, c) {
                let square = a23 / (ratio * (b23 + ratio) + 1.0);
                if ratio > 0.0 && square > 0.0 {
                    let second = square.sqrt();
                    let third = ratio * second;
                    found.push(Vector3::new(w0 * second + w1 * third, second, third));
                }
            }
        }
        found
    }

    /// Refines distances by Newton's method on Eq. (10); `None` if the iteration does not end in a positive solution.
    fn polished(&self, mut distances: Vector3<f64>) -> Option<Vector3<f64>> {
        let [c12, c13, c23] = self.cosines;
        let mut least = f64::INFINITY;
        let mut best = distances;
        for _ in 0..MOST_STEPS {
            let [d1, d2, d3] = [distances[0], distances[1], distances[2]];
            let residual = Vector3::new(
                d1 * d1 + d2 * d2 - 2.0 * d1 * d2 * c12 - self.squares[0],
                d1 * d1 + d3 * d3 - 2.0 * d1 * d3 * c13 - self.squares[1],
                d2 * d2 + d3 * d3 - 2.0 * d2 * d3 * c23 - self.squares[2],
            );
            let size = (0..3).fold(0.0f64, |size, k| size.max(residual[k].abs() / self.squares[k]));
            if size < least {
                (least, best) = (size, distances);
            }
            if size < 1e-15 {
                break;
            }
            // Half of the Jacobian matrix of the P3P equations, with rows for the pairs of points 12, 13 and 23.
            let (j11, j12) = (d1 - d2 * c12, d2 - d1 * c12);
            let (j21, j23) = (d1 - d3 * c13, d3 - d1 * c13);
            let (j32, j33) = (d2 - d3 * c23, d3 - d2 * c23);
            let determinant = -j11 * j23 * j32 - j12 * j21 * j33;
            if determinant == 0.0 || !determinant.is_finite() {
                break;
            }
            let half = 0.5 * residual / determinant;
            // The Newton step uses the cofactors of the matrix [[j11, j12, 0], [j21, 0, j23], [0, j32, j33]].
            let step = Vector3::new(
                -j23 * j32 * half[0] - j12 * j33 * half[1] + j12 * j23 * half[2],
                -j21 * j33 * half[0] + j11 * j33 * half[1] - j11 * j23 * half[2],
                j21 * j32 * half[0] - j11 * j32 * half[1] - j12 * j21 * half[2],
            );
            if step.norm() <= 1e-16 * distances.norm() {
                break;
            }
            distances -= step;
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
    let (mean, spread) = (0.5 * (p + q), (0.5 * (p - q)).hypot(r));
    let large = if mean > 0.0 { mean + spread } else { mean - spread };
    // The product of the two eigenvalues is the determinant; dividing it by the larger one avoids cancellation.
    let small = if large == 0.0 { 0.0 } else { (p * q - r * r) / large };
    let (u, v) = if (large - p).abs() > (large - q).abs() { (r, large - p) } else { (large - q, r) };
    let length = u.hypot(v);
    let (u, v) = if length > 0.0 { (u / length, v / length) } else { (1.0, 0.0) };
    Some(([first * u + second * v, second * u - first * v], [large, small]))
}

/// Real roots of a x² + b x + c. A double root is returned twice, also when rounding has made the discriminant slightly negative.
fn quadratic_roots(a: f64, b: f64, c: f64) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    // A discriminant just below 0 means two solutions that coincide but for rounding; Newton's method decides later whether they are solutions.
    if discriminant < -1e-7 * b * b {
        return Vec::new();
    }
    let root = discriminant.max(0.0).sqrt();
    let q = -0.5 * (b + if b > 0.0 { root } else { -root });
    [q / a, c / q].into_iter().filter(|root| root.is_finite()).collect()
}

/// Real roots of a cubic, by the trigonometric formula or by radicals, then refined by Newton's method.
fn real_roots(cubic: f64, square: f64, linear: f64, constant: f64) -> Vec<f64> {
    let scale = square.abs().max(linear.abs()).max(constant.abs());
    if cubic.abs() < 1e-14 * scale {
        return quadratic_roots(square, linear, constant);
    }
    let (b, c, d) = (square / cubic, linear / cubic, constant / cubic);
    // With x = t − b/3 the cubic becomes t³ + p t + q = 0.
    let third = b / 3.0;
    let p = c - b * third;
    let q = (2.0 * third * third - c) * third + d;
    let discriminant = 0.25 * q * q + p * p * p / 27.0;
    let roots = if discriminant > 0.0 {
        let sum = -0.5 * q - discriminant.sqrt().copysign(q);
        let first = sum.cbrt();
        let other = if first == 0.0 { 0.0 } else { -p / (3.0 * first) };
        vec![first + other]
    } else {
        let radius = (-p / 3.0).max(0.0).sqrt();
        let cosine = if radius == 0.0 { 0.0 } else { (-0.5 * q / (radius * radius * radius)).clamp(-1.0, 1.0) };
        let angle = cosine.acos() / 3.0;
        (0..3).map(|k| 2.0 * radius * (angle - std::f64::consts::TAU / 3.0 * f64::from(k)).cos()).collect()
    };
    let polish = |t: f64| {
        let mut x = t - third;
        for _ in 0..3 {
            let value = ((x + b) * x + c) * x + d;
            let slope = (3.0 * x + 2.0 * b) * x + c;
            if slope == 0.0 {
                break;
            }
            x -= value / slope;
        }
        x
    };
    roots.into_iter().map(polish).filter(|root| root.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Unit};

    use super::*;
    use crate::vision::synthetic::Random;

    /// A random camera pose with three random points in front of the camera, drawn at random from the ranges that Persson and Nordberg use in their
    /// paper on P3P.
    fn problem(random: &mut Random) -> ([Vector3<f64>; 3], [Vector3<f64>; 3], CameraPose) {
        let mut normal = || Vector3::new(random.normal(), random.normal(), random.normal());
        let axis = Unit::new_normalize(normal());
        let translation_m = normal();
        let rotation = Rotation3::from_axis_angle(&axis, random.between(-3.1, 3.1)).into_inner();
        let mut ray = || Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 1.0);
        let rays = [ray(), ray(), ray()];
        let seen = rays.map(|ray| ray * random.between(0.1, 10.0));
        let points_m = seen.map(|point| rotation.transpose() * (point - translation_m));
        (rays, points_m, CameraPose { rotation, translation_m })
    }

    #[test]
    fn the_true_pose_is_found_and_every_solution_is_one() {
        let rounds = std::env::var("WHEREIN_P3P_PROBLEMS").ok().and_then(|text| text.parse().ok()).unwrap_or(100_000);
        let mut random = Random::new(5);
        let (mut missed, mut wrong, mut repeated, mut counts) = (0, 0, 0, [0usize; 5]);
        for _ in 0..rounds {
            let (rays, points_m, truth) = problem(&mut random);
            let poses = solve(&rays, &points_m);
            let distance = |pose: &CameraPose| {
                (pose.rotation - truth.rotation).abs().sum() + (pose.translation_m - truth.translation_m).abs().sum()
            };
            missed += usize::from(!poses.iter().any(|pose| distance(pose) < 1e-6));
            counts[poses.len().min(4)] += 1;
            for (idx, pose) in poses.iter().enumerate() {
                let is_right = (0..3).all(|k| {
                    let seen = pose.rotation * points_m[k] + pose.translation_m;
                    seen.z > 0.0 && (seen / seen.z - rays[k]).norm() < 1e-6
                });
                let is_rigid = (pose.rotation.transpose() * pose.rotation - Matrix3::identity()).norm() < 1e-6
                    && pose.rotation.determinant() > 0.0;
                wrong += usize::from(!is_right || !is_rigid);
                repeated += usize::from(poses[..idx].iter().any(|other| {
                    (other.rotation - pose.rotation).abs().sum()
                        + (other.translation_m - pose.translation_m).abs().sum()
                        < 1e-6
                }));
            }
        }
        println!("{rounds} problems: {missed} missed, {wrong} wrong, {repeated} repeated, solutions {counts:?}");
        assert_eq!(wrong, 0);
        // Required is that 9 999 985 of 10⁷ problems are solved: 1.5 in a million may fail.
        assert!(missed as f64 <= (1.5e-6 * rounds as f64).max(1.0), "{missed} of {rounds}");
    }

    #[test]
    fn solving_takes_under_a_microsecond_or_two() {
        let mut random = Random::new(6);
        let problems: Vec<_> = (0..2000).map(|_| problem(&mut random)).collect();
        let mut micros: Vec<f64> = problems
            .chunks(20)
            .map(|chunk| {
                let start = std::time::Instant::now();
                let count: usize = chunk.iter().map(|(rays, points_m, _)| solve(rays, points_m).len()).sum();
                let micros = start.elapsed().as_secs_f64() * 1e6 / chunk.len() as f64;
                if count == 0 { f64::INFINITY } else { micros }
            })
            .collect();
        micros.sort_by(f64::total_cmp);
        println!("median {:.2} µs, best {:.2} µs", micros[micros.len() / 2], micros[0]);
        // The best time is tested, because the machine may be busy; the limit is ten times what a quiet machine takes.
        assert!(micros[0] < 10.0);
    }

    #[test]
    fn points_in_a_line_have_no_pose() {
        let point = |x: f64| Vector3::new(x, 0.0, 0.0);
        let ray = |x: f64| Vector3::new(x, 0.0, 1.0);
        assert!(solve(&[ray(0.0), ray(0.1), ray(0.2)], &[point(0.0), point(1.0), point(2.0)]).is_empty());
    }
}
