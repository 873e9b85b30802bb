//! What leans do that is not linear in them: to headings, to directions, and to what a camera that looks down sees.
//!
//! A lean is a turn about a level axis, T(a). Everything here holds for any leans that the function takes, not for small ones alone.

use interval::Interval;

/// Greatest difference between two ways to tell the heading of a body that leans by up to `lean_rad`: the direction of its forward axis
/// seen from above, as in Rz(heading)·Ry(pitch)·Rx(roll), and the turn about the vertical that a lean alone is left of.
///
/// A lean by λ about an axis at α from forward turns forward, seen from above, by δ with tan δ = (1 − cos λ)·sin 2α /
/// (1 + cos λ + (1 − cos λ)·cos 2α), at most (1 − cos λ)/(2·√cos λ): about λ²/4. Half a turn from a quarter turn of lean on.
pub(super) fn heading_off_rad(lean_rad: f64) -> f64 {
    let cos = Interval::point(lean_rad).cos();
    if cos.lo() <= 0.0 { Interval::PI.hi() } else { ((1.0 - cos) / (cos.sqrt() * 2.0)).atan().hi() }
}

/// Greatest turn about the vertical in two leans, one after the other, that are together by up to `lean_rad`: T(a)·T(b) = Rz(δ)·T(c).
///
/// In quaternions tan(δ/2) = r·sin α/(1 − r·cos α) with r = tan(|a|/2)·tan(|b|/2) and α between the axes, at most r/√(1 − r²), so that
/// sin(δ/2) ≤ r; of one sum r is greatest where both are alike: about lean²/8. |c| ≤ |a| + |b| as the vertical's way is no shorter.
pub(super) fn twist_of_two_rad(lean_rad: f64) -> f64 {
    let half = (Interval::point(lean_rad) * 0.25).tan();
    if half.hi() >= 1.0 { Interval::PI.hi() } else { (half.sqr().asin() * 2.0).hi() }
}

/// Greatest turn about the vertical in a lean by up to `lean_rad` about an axis that is itself tipped by up to `tipped_rad` from level:
/// tan(δ/2) = tan(lean/2)·sin(tip).
pub(super) fn twist_of_tipped_rad(lean_rad: f64, tipped_rad: f64) -> f64 {
    let half = (Interval::point(lean_rad) * 0.5).tan() * Interval::point(tipped_rad).sin().abs();
    (half.atan() * 2.0).hi()
}

/// What mount and body, leaning, do to the plane through an optical centre and a line on the floor below it.
///
/// The line's image tells the plane's normal (cos ψ, sin ψ, ρ) but for the leans, with ρ the distance of the line from the point below
/// the camera over the height. A turn of the camera turns the normal: what is left of it in the level plane tells the line's direction,
/// its elevation ε, tan ε = ρ, the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeaningPlane {
    /// Greatest |ρ| as seen.
    slope: Interval,
    mount: Lean,
    body: Lean,
    /// Greatest elevation of the normal after the mount's lean, and after both.
    mounted_rad: Interval,
    leaning_rad: Interval,
}

/// The greatest of some leans.
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

    /// Greatest turn, seen from above, of a vector at an elevation of up to ε with tan ε = `slope`; `None` where it may be any.
    ///
    /// With the axis at α from the vector's direction: across it the vector comes to lie by sin λ·tan ε·cos α and (1 − cos λ)·sin α·cos α
    /// at most, along it at cos λ − sin λ·tan ε at least, of its own level length.
    fn turn(&self, slope: Interval) -> Option<Interval> {
        let along = self.cos - self.sin * slope;
        (along.lo() > 0.0).then(|| ((self.sin * slope + (1.0 - self.cos) * 0.5) / along).atan())
    }
}

impl LeaningPlane {
    /// Of a line as far out as `slope` of the height; `None` where the leans may turn it beyond the horizon.
    pub(super) fn new(slope: f64, mount_rad: f64, body_rad: f64) -> Option<Self> {
        let (slope, mount, body) = (Interval::point(slope), Lean::of(mount_rad), Lean::of(body_rad));
        let mounted_rad = slope.atan() + mount.angle_rad;
        let leaning_rad = mounted_rad + body.angle_rad;
        let plane = LeaningPlane { slope, mount, body, mounted_rad, leaning_rad };
        (leaning_rad.cos().lo() > 0.0 && leaning_rad.hi() < Interval::PI.lo() * 0.5).then_some(plane)
    }

    /// Greatest turn of the line, seen from above, against its image.
    pub(super) fn turn_rad(&self) -> Option<f64> {
        Some((self.mount.turn(self.slope)? + self.body.turn(self.mounted_rad.tan())?).hi())
    }

    /// Greatest shift of the line against what its image tells, along its own normal: n(ψ′)·P − n(ψ′)·a − ρ·h for a camera h above a
    /// body that leans about its origin, the camera a from it, and rises or sinks by up to `heave_m`.
    ///
    /// With the normal N after the mount's lean and N′ after both, of elevations e and e′, the line lies at (N·(a, h) + N′·z heave)/|N′
    /// level|. Less n(ψ′)·a and ρ·h that is (N − N′)·a, at most |a|·(sin e·sin λ + cos e·(1 − cos λ))/cos e′ for a body's lean of λ; then
    /// h·(tan e − tan ε), and h·sin e·(1/cos e′ − 1/cos e), which grow with e and e′; and tan e′·heave.
    pub(super) fn shift_m(&self, height_m: f64, arm_m: f64, heave_m: f64) -> f64 {
        let (sin, cos) = (self.mounted_rad.sin(), self.mounted_rad.cos());
        let leaning_cos = self.leaning_rad.cos();
        let by_mount = (self.mounted_rad.tan() - self.slope) * height_m;
        let by_body = sin * (1.0 / leaning_cos - 1.0 / cos) * height_m;
        let by_arm = (sin * self.body.sin + cos * (1.0 - self.body.cos)) / leaning_cos * arm_m;
        (by_mount + by_body + by_arm + self.leaning_rad.tan() * heave_m).hi()
    }
}

/// What leans of mount and body do to a point of the floor that a camera sees, at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeaningSight {
    /// Distance from the point below the camera, with the mount's lean.
    pub(super) distance_m: Interval,
    /// How far the mount's lean shifts it.
    pub(super) by_mount_m: Interval,
    body: Lean,
    height_m: f64,
}

impl LeaningSight {
    /// Of a point that a camera without errors sees up to `distance_m` from the point below it; `None` where it may see the horizon.
    ///
    /// A ray turned by up to μ at ε from the vertical meets the floor within h·(tan(ε + μ) − tan ε) of where it did.
    pub(super) fn new(distance_m: f64, height_m: f64, mount_rad: f64, body_rad: f64) -> Option<Self> {
        let (nominal_m, body) = (Interval::point(distance_m), Lean::of(body_rad));
        let off_rad = (nominal_m / height_m).atan() + Interval::point(mount_rad);
        if (off_rad + body.angle_rad).hi() >= Interval::PI.lo() * 0.5 {
            return None;
        }
        let distance_m = off_rad.tan() * height_m;
        Some(LeaningSight { distance_m, by_mount_m: distance_m - nominal_m, body, height_m })
    }

    /// How far lean and heave of the body shift the point along a direction in which it lies `along_m` from the point below the camera;
    /// it is up to `arm_m` from the robot origin. A heading told by the forward axis turns it, besides, by [`heading_off_rad`].
    ///
    /// With the body the point q comes to q′, |q′ − q| ≤ |q|·(1 − cos λ) seen from above and |q|·sin λ + heave high, and from there along its
    /// ray back to the floor: the ray goes h·cos λ − p·sin λ down, at least, while it goes along + h·sin λ + p·(1 − cos λ) aside, at most.
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

    /// The turn about the vertical that a lean alone is left of.
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
