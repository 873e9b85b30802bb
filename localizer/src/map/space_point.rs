//! A landmark in space as a ray with a bounded inverse depth.

use interval::Interval;

/// The point and the world axis from which a landmark's ray is counted. All numbers are exact by definition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Point of the world: x, y and z.
    pub from_m: [f64; 3],
    /// World axis along which depths are counted: x (0), y (1) or z (2).
    pub axis: usize,
    /// Whether depths are counted towards greater coordinates.
    pub is_positive: bool,
}

/// A landmark L in homogeneous form: with the anchor A, its axis k and the two axes i and j that follow it cyclically,
///
/// (L − A)·ρ = d,   d_k = ±1,   d_i = α,   d_j = β,
///
/// so that ρ is the inverse of the depth along the axis, and α and β are the slopes of the ray. A landmark at infinite depth has ρ = 0. Nothing is
/// divided by ρ where the landmark is used.
///
/// Source: J. Civera, A. J. Davison, J. M. M. Montiel, "Inverse depth parametrization for monocular SLAM", IEEE Transactions on Robotics 24 (2008),
/// whose angles are slopes here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// Where the ray begins.
    pub anchor: Anchor,
    /// Intervals of α, β and ρ.
    pub value: [Interval; 3],
}

impl Anchor {
    /// The two axes that follow the anchor's axis cyclically: those of α and β.
    pub fn sides(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// 1 or −1: the direction in which depths are counted.
    pub fn sign(&self) -> f64 {
        if self.is_positive { 1.0 } else { -1.0 }
    }
}

impl SpacePoint {
    /// Box of the landmark in the world; `None` where its depth may be infinite.
    pub fn place_m(&self) -> Option<[Interval; 3]> {
        let [alpha, beta, rho] = self.value;
        (rho.lo() > 0.0).then(|| {
            let mut place_m = self.anchor.from_m.map(Interval::point);
            let [i, j] = self.anchor.sides();
            place_m[self.anchor.axis] += rho.recip() * self.anchor.sign();
            place_m[i] += alpha / rho;
            place_m[j] += beta / rho;
            place_m
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_box_of_a_landmark_is_the_one_worked_out_by_hand() {
        // From (1, 2, 3) against y: a depth of 4 m, and per metre of depth 0.5 m along z and −0.25 m along x.
        let anchor = Anchor { from_m: [1.0, 2.0, 3.0], axis: 1, is_positive: false };
        let point = SpacePoint { anchor, value: [0.5, -0.25, 0.25].map(Interval::point) };
        let place_m = point.place_m().unwrap();
        for (side, expected) in place_m.into_iter().zip([0.0, -2.0, 5.0]) {
            assert!(side.contains(expected) && side.width() < 1e-12, "{side} {expected}");
        }
        let far = SpacePoint { value: [Interval::point(0.5), Interval::ZERO, Interval::new(0.0, 0.1)], ..point };
        assert_eq!(far.place_m(), None);
    }
}
