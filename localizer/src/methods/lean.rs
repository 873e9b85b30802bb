//! Nonlinear effects of leans of the body and of a camera's mount: on headings, on directions, and on what a camera that looks down sees.
//!
//! A lean is a turn about a level axis, written T(a). Every bound here holds for leans of any size that its function accepts, not for small
//! ones alone.

use interval::Interval;

/// Greatest difference between two definitions of the heading of a body that leans by up to `lean_rad`: the direction of its forward axis
/// seen from above, as in Rz(heading)·Ry(pitch)·Rx(roll), and the turn about the vertical that remains when the posture's lean T(a) is
/// taken off.
///
/// A lean by λ about an axis at the angle α from forward turns the forward axis, seen from above, by δ with
/// tan δ = (1 − cos λ)·sin 2α / (1 + cos λ + (1 − cos λ)·cos 2α), which is at most (1 − cos λ)/(2·√cos λ): about λ²/4. From a lean of a
/// quarter turn on, the bound is half a turn.
pub(super) fn heading_off_rad(lean_rad: f64) -> f64 {
    let cos = Interval::point(lean_rad).cos();
    if cos.lo() <= 0.0 { Interval::PI.hi() } else { ((1.0 - cos) / (cos.sqrt() * 2.0)).atan().hi() }
}

/// Greatest turn about the vertical in two successive leans whose angles add up to at most `lean_rad`: |δ| in T(a)·T(b) = Rz(δ)·T(c).
///
/// In quaternions tan(δ/2) = r·sin α/(1 − r·cos α) with r = tan(|a|/2)·tan(|b|/2) and α the angle between the axes. That is at most r/√(1 −
/// r²), so that sin(δ/2) ≤ r. For a given sum of the two angles r is greatest where they are equal: about lean²/8. The lean c obeys |c| ≤
/// |a| + |b|, as the path of the vertical axis through both leans is no shorter than the direct one.
pub(super) fn twist_of_two_rad(lean_rad: f64) -> f64 {
    let half = (Interval::point(lean_rad) * 0.25).tan();
    if half.hi() >= 1.0 { Interval::PI.hi() } else { (half.sqr().asin() * 2.0).hi() }
}

/// Greatest turn about the vertical in a rotation by up to `lean_rad` about an axis that is itself tipped by up to `tipped_rad` from level:
/// tan(δ/2) = tan(lean/2)·sin(tip).
pub(super) fn twist_of_tipped_rad(lean_rad: f64, tipped_rad: f64) -> f64 {
    let half = (Interval::point(lean_rad) * 0.5).tan() * Interval::point(tipped_rad).sin().abs();
    (half.atan() * 2.0).hi()
}

/// Bounds on how leans of the camera's mount and of the body move the plane through the optical centre and a line on the floor below.
///
/// The image of the line gives, apart from the leans, the plane's normal (cos ψ, sin ψ, ρ), with ρ the distance of the line from the point
/// below the camera over the camera's height. A rotation of the camera rotates the normal: the level part of the normal tells the line's
/// direction, and the normal's elevation ε, tan ε = ρ, the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeaningPlane {
    /// Greatest |ρ| of the floor line as seen: its distance from the floor point below the camera, divided by the camera's height.
    slope: Interval,
    mount: Lean,
    body: Lean,
    /// Greatest elevation of the normal of the plane through the optical centre and the floor line: `mounted_rad` after the mount's lean,
    /// `leaning_rad` after the leans of mount and body.
    mounted_rad: Interval,
    leaning_rad: Interval,
}

/// Greatest angle of a lean, with its sine and cosine.
#[derive(Clone, Copy, Debug)]
struct Lean {
    angle_rad: Interval,
    sin: Interval,
    cos: Interval,
}

impl Lean {
    fn of(angle_rad: f64) -> Lean {
        let angle_rad = Interval::point(angle_rad);
        Lean { angle_rad, sin: angle_rad.sin(), cos: angle_rad.cos() }
    }

    /// Greatest turn, seen from above, of a vector at an elevation of up to ε with tan ε = `slope`; `None` where the lean may turn it by
    /// any angle.
    ///
    /// Let the lean be by λ about an axis at the angle α from the vector's direction. In units of its own level length, the leaning
    /// vector's part across its old direction is at most sin λ·tan ε·cos α plus (1 − cos λ)·sin α·cos α, and its part along it is at least
    /// cos λ − sin λ·tan ε.
    fn turn(&self, slope: Interval) -> Option<Interval> {
        let along = self.cos - self.sin * slope;
        (along.lo() > 0.0).then(|| ((self.sin * slope + (1.0 - self.cos) * 0.5) / along).atan())
    }
}

impl LeaningPlane {
    /// Bounds for a line as far from the point below the camera as `slope` times the camera's height; `None` where the leans may turn the
    /// plane through the line beyond the horizon.
    pub(super) fn new(slope: f64, mount_rad: f64, body_rad: f64) -> Option<Self> {
        let (slope, mount, body) = (Interval::point(slope), Lean::of(mount_rad), Lean::of(body_rad));
        let mounted_rad = slope.atan() + mount.angle_rad;
        let leaning_rad = mounted_rad + body.angle_rad;
        let plane = LeaningPlane { slope, mount, body, mounted_rad, leaning_rad };
        (leaning_rad.cos().lo() > 0.0 && leaning_rad.hi() < Interval::PI.lo() * 0.5).then_some(plane)
    }

    /// Greatest angle, seen from above, by which the leans turn the floor line's direction against the direction that its image gives.
    pub(super) fn turn_rad(&self) -> Option<f64> {
        Some((self.mount.turn(self.slope)? + self.body.turn(self.mounted_rad.tan())?).hi())
    }

    /// Greatest shift of the floor line, along its own normal, against what its image gives: n(ψ′)·P − n(ψ′)·a − ρ·h, with P a point of the
    /// line, n(ψ′) the line's unit normal on the floor, and ρ the line's distance in camera heights by its image. The camera is at the
    /// height h and at the level distance a from the origin of a body that leans about that origin and rises or sinks by up to `heave_m`.
    ///
    /// Let the normal of the plane through camera and line be N after the mount's lean and N′ after both leans, with elevations e and e′.
    /// The line lies at (N·(a, h) + N′·z heave)/|N′ level|. Less n(ψ′)·a and ρ·h that leaves (N − N′)·a, at most |a|·(sin e·sin λ + cos
    /// e·(1 − cos λ))/cos e′ for a body's lean of λ; then h·(tan e − tan ε), with tan ε = ρ, and h·sin e·(1/cos e′ − 1/cos e), which grow
    /// with e and e′; and tan e′·heave.
    pub(super) fn shift_m(&self, height_m: f64, arm_m: f64, heave_m: f64) -> f64 {
        let (sin, cos) = (self.mounted_rad.sin(), self.mounted_rad.cos());
        let leaning_cos = self.leaning_rad.cos();
        let by_mount = (self.mounted_rad.tan() - self.slope) * height_m;
        let by_body = sin * (1.0 / leaning_cos - 1.0 / cos) * height_m;
        let by_arm = (sin * self.body.sin + cos * (1.0 - self.body.cos)) / leaning_cos * arm_m;
        (by_mount + by_body + by_arm + self.leaning_rad.tan() * heave_m).hi()
    }
}

/// Bounds on how far leans of the camera's mount and of the body shift a point of the floor that the camera sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeaningSight {
    /// Greatest distance of the seen floor point from the point below the camera, with the shift by the mount's lean included.
    pub(super) distance_m: Interval,
    /// Greatest shift of the seen floor point by the lean of the camera's mount.
    pub(super) by_mount_m: Interval,
    body: Lean,
    height_m: f64,
}

impl LeaningSight {
    /// Bounds for a floor point that a camera without errors sees up to `distance_m` from the point below the camera; `None` where the
    /// leaning camera may see the horizon.
    ///
    /// A ray at the angle ε from the vertical, turned by up to μ, meets the floor within h·(tan(ε + μ) − tan ε) of where it met the floor
    /// before.
    pub(super) fn new(distance_m: f64, height_m: f64, mount_rad: f64, body_rad: f64) -> Option<Self> {
        let (nominal_m, body) = (Interval::point(distance_m), Lean::of(body_rad));
        let off_rad = (nominal_m / height_m).atan() + Interval::point(mount_rad);
        if (off_rad + body.angle_rad).hi() >= Interval::PI.lo() * 0.5 {
            return None;
        }
        let distance_m = off_rad.tan() * height_m;
        Some(LeaningSight { distance_m, by_mount_m: distance_m - nominal_m, body, height_m })
    }

    /// Greatest shift of a floor point by the body's lean and heave, along a direction in which the point lies `along_m` from the point
    /// below the camera. The point is up to `arm_m` from the robot origin. A heading defined by the forward axis adds a turn of up to
    /// [`heading_off_rad`], which is included.
    ///
    /// Let q be the floor point from the robot origin and p its distance from the point below the camera. With the body the point q moves
    /// to q′: seen from above |q′ − q| ≤ |q|·(1 − cos λ), and q′ is up to |q|·sin λ + heave high. From there it is carried along its ray
    /// back to the floor: while the ray falls by at least h·cos λ − p·sin λ, it moves sideways by at most along + h·sin λ + p·(1 − cos λ),
    /// where along is `along_m` with the shift by the mount's lean.
    pub(super) fn by_body_m(&self, along_m: f64, arm_m: f64, heave_m: f64) -> f64 {
        let Lean { angle_rad, sin, cos } = self.body;
        let bent = 1.0 - cos;
        let down_m = cos * self.height_m - sin * self.distance_m;
        let aside_m = sin * self.height_m + bent * self.distance_m + (self.by_mount_m + along_m);
        let high_m = sin * arm_m + heave_m;
        (bent * arm_m + aside_m * high_m / down_m + Interval::point(heading_off_rad(angle_rad.hi())) * arm_m).hi()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, UnitQuaternion, Vector3};

    use super::*;
    use crate::vision::synthetic::Random;

    fn lean(random: &mut Random, most_rad: f64) -> Rotation3<f64> {
        let course = random.between(0.0, std::f64::consts::TAU);
        let size = if random.chance(0.7) { most_rad } else { most_rad * random.unit() };
        Rotation3::new(Vector3::new(course.cos(), course.sin(), 0.0) * size)
    }

    /// Turn about the vertical that remains of a rotation when its lean about a level axis is taken off.
    fn twist_rad(turn: Rotation3<f64>) -> f64 {
        let turn = UnitQuaternion::from_rotation_matrix(&turn);
        let twist = 2.0 * turn.k.atan2(turn.w);
        twist - std::f64::consts::TAU * (twist / std::f64::consts::TAU).round()
    }

    #[test]
    fn no_leans_turn_about_the_vertical_by_more_and_some_by_nearly_as_much() {
        let mut random = Random::new(81);
        for most_deg in [0.5_f64, 1.0, 3.0, 10.0, 30.0, 60.0] {
            let (most_rad, mut nearest) = (most_deg.to_radians(), [0.0_f64; 3]);
            let allowed = [heading_off_rad(most_rad), twist_of_two_rad(most_rad), twist_of_tipped_rad(most_rad, 0.4)];
            for _ in 0..10_000 {
                let forward = lean(&mut random, most_rad) * Vector3::x();
                let share = random.unit();
                let two = lean(&mut random, share * most_rad) * lean(&mut random, (1.0 - share) * most_rad);
                let (course, tip) = (random.between(0.0, std::f64::consts::TAU), random.between(-0.4, 0.4));
                let axis = Vector3::new(course.cos() * tip.cos(), course.sin() * tip.cos(), tip.sin());
                let tipped = Rotation3::new(axis * most_rad);
                let found = [forward.y.atan2(forward.x), twist_rad(two), twist_rad(tipped)].map(f64::abs);
                for k in 0..3 {
                    assert!(found[k] <= allowed[k] * (1.0 + 1e-6) + 1e-12, "{most_deg} deg: {found:?} {allowed:?}");
                    nearest[k] = nearest[k].max(found[k] / allowed[k]);
                }
            }
            assert!(nearest.iter().all(|&share| share > 0.9), "{most_deg} deg: {nearest:?}");
        }
    }
}
