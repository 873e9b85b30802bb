//! Bound on the normals of all lines that pass near enough to most of a number of given points.

use interval::Interval;

/// Set of unit normals in (u, v): all normals within an angle of a middle one, or any normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normals {
    middle: [Interval; 2],
    /// Greatest turn of a normal from the middle one, up to a quarter turn, as a normal and its opposite count as the same.
    off_rad: f64,
}

impl Normals {
    /// Set of all unit normals in the image plane.
    pub(super) fn any() -> Normals {
        Normals { middle: [Interval::ONE, Interval::ZERO], off_rad: Interval::PI.hi() * 0.5 }
    }

    /// Normals of every line that passes all but a share of the points `[u, v, bound]` within their bounds. The points are listed along the
    /// line.
    ///
    /// With n points that may be wrong, at least one of the first n + 1 points is right, and so is one of the last n + 1: the line runs
    /// from the neighbourhood of the one to that of the other.
    pub(super) fn of(points_px: &[[f64; 3]], share_wrong: f64) -> Normals {
        // The number of points that may be wrong is a hair more than the product, so that rounding can only allow one more.
        let n_right = (share_wrong * points_px.len() as f64 + 1e-9).floor() as usize + 1;
        let Some(last) = points_px.len().checked_sub(n_right).filter(|&last| last >= n_right) else {
            return Normals::any();
        };
        let (first, last) = (&points_px[..n_right], &points_px[last..]);
        let middle =
            |part: &[[f64; 3]]| [0, 1].map(|axis| part.iter().map(|point| point[axis]).sum::<f64>() / n_right as f64);
        let ([u0, v0], [u1, v1]) = (middle(first), middle(last));
        let way = [Interval::point(u1) - u0, Interval::point(v1) - v0];
        let length_px = way[0].hypot(way[1]);
        if length_px.lo() <= 0.0 {
            return Normals::any();
        }
        let normal = [-way[1] / length_px, way[0] / length_px];
        // Places at which the line passes each of the points, in coordinates along and across the direction from the middle of the first
        // points to the middle of the last.
        let feet = |part: &[[f64; 3]]| {
            part.iter().fold([Interval::EMPTY; 2], |[along, across], &[u, v, bound_px]| {
                let (u, v) = (Interval::point(u) - u0, Interval::point(v) - v0);
                [
                    along.hull((u * normal[1] - v * normal[0]).inflate(bound_px)),
                    across.hull((u * normal[0] + v * normal[1]).inflate(bound_px)),
                ]
            })
        };
        let ([from_along, from_across], [to_along, to_across]) = (feet(first), feet(last));
        let along = to_along - from_along;
        if along.is_empty() || along.lo() <= 0.0 {
            return Normals::any();
        }
        Normals { middle: normal, off_rad: ((to_across - from_across).abs() / along).atan().hi() }
    }

    /// Greatest length of the product of a symmetric matrix `[a, mixed, b]` with one of the normals.
    pub(super) fn longest(&self, [a, mixed, b]: [Interval; 3]) -> f64 {
        self.most(|[u, v]| (a * u + mixed * v).hypot(mixed * u + b * v))
    }

    /// Greatest distance of a place from the origin along one of the normals, in either direction.
    pub(super) fn farthest(&self, [x, y]: [Interval; 2]) -> f64 {
        self.most(|[u, v]| (x * u + y * v).abs())
    }

    /// Greatest value of a seminorm over the normals. For n·cos δ + t·sin δ, with t a quarter turn from n, the seminorm is at most its
    /// value for n plus sin δ times its value for t.
    fn most(&self, seminorm: impl Fn([Interval; 2]) -> Interval) -> f64 {
        let [u, v] = self.middle;
        let aside = Interval::point(self.off_rad).min(Interval::PI * 0.5).sin().abs();
        (seminorm([u, v]) + aside * seminorm([-v, u])).hi()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    #[test]
    fn every_line_near_enough_to_most_points_has_one_of_the_normals() {
        let mut random = Random::new(91);
        let mut widest: f64 = 0.0;
        for _ in 0..10_000 {
            let (angle, offset) = (random.between(-3.2, 3.2), random.between(-50.0, 50.0));
            let normal = [angle.cos(), angle.sin()];
            let bound_px = random.between(0.1, 3.0);
            let points: Vec<[f64; 3]> = (0..40)
                .map(|step| {
                    let along = -40.0 + 2.0 * f64::from(step);
                    // One fifth of the points, all at one end of the line, are off by up to 3 px more than their bound and pull the middle
                    // aside.
                    let off = if step < 8 {
                        bound_px + random.between(0.0, 3.0)
                    } else {
                        bound_px * random.between(-1.0, 1.0)
                    };
                    let across = offset + off;
                    [across * normal[0] - along * normal[1], across * normal[1] + along * normal[0], bound_px]
                })
                .collect();
            let normals = Normals::of(&points, 0.2);
            let [u, v] = normals.middle.map(Interval::mid);
            let off_rad = (u * normal[1] - v * normal[0]).abs().min(1.0).asin();
            assert!(off_rad <= normals.off_rad + 1e-9, "{off_rad} {normals:?}");
            widest = widest.max(normals.off_rad);
        }
        // By hand, for bounds of 3 px: the foot of the line lies from −6 to 9 px across at one end and from −6 to 6 px at the other, and
        // the feet are at least 46 − 6 px apart along the line.
        assert!(widest < (16.0_f64 / 40.0).atan(), "{widest}");
    }

    #[test]
    fn too_few_or_too_short_points_leave_any_normal() {
        let points = [[0.0, 0.0, 0.3], [1.0, 0.0, 0.3], [0.5, 0.0, 2.0]];
        for points in [&points[..0], &points[..1], &points[1..]] {
            assert!(Normals::of(points, 0.0).off_rad > 1.57, "{points:?}");
        }
        // By hand: the diagonal matrix of 2 and 1 gives a normal a length of at most 2, which is bounded by the sum 3; a place at a
        // distance of 3 has the distance 3 along some normal.
        assert!((2.0..3.001).contains(&Normals::any().longest([Interval::point(2.0), Interval::ZERO, Interval::ONE])));
        assert!((3.0..4.3).contains(&Normals::any().farthest([Interval::point(3.0), Interval::ZERO])));
    }
}
