//! Which normals a line may have that is near enough to most of some points.

use interval::Interval;

/// Unit normals in (u, v): those within an angle of one, or any.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normals {
    middle: [Interval; 2],
    /// Greatest turn from the middle, up to a quarter turn: a normal and its opposite are one.
    off_rad: f64,
}

impl Normals {
    /// Every normal.
    pub(super) fn any() -> Normals {
        Normals { middle: [Interval::ONE, Interval::ZERO], off_rad: Interval::PI.hi() * 0.5 }
    }

    /// Those of every line that passes all but a share of the points `[u, v, bound]`, listed along it, within their bounds.
    ///
    /// Of the first n + 1 points one is right at least, with n that may be wrong, and so is one of the last n + 1: the line runs from the one
    /// to the other.
    pub(super) fn of(points_px: &[[f64; 3]], share_wrong: f64) -> Normals {
        // A hair more than the product, so that rounding can only allow one more wrong point.
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
        // In coordinates along and across the way between the middles: a foot of the line near each of the points.
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

    /// The greatest length that a symmetric matrix `[a, mixed, b]` gives one of the normals.
    pub(super) fn longest(&self, [a, mixed, b]: [Interval; 3]) -> f64 {
        self.most(|[u, v]| (a * u + mixed * v).hypot(mixed * u + b * v))
    }

    /// The greatest distance of a place from the origin along one of the normals, either way.
    pub(super) fn farthest(&self, [x, y]: [Interval; 2]) -> f64 {
        self.most(|[u, v]| (x * u + y * v).abs())
    }

    /// The greatest value of a seminorm: of n·cos δ + t·sin δ, t a quarter turn from n, it is no greater than of n and sin δ times that of t.
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
                    // A fifth is off by up to 3 px more, one end all of it: they pull the middle aside.
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
        // By hand: of 3 px of bound, a foot at one end lies from −6 to 9 px, at the other from −6 to 6, 46 px less 6 apart.
        assert!(widest < (16.0_f64 / 40.0).atan(), "{widest}");
    }

    #[test]
    fn too_few_or_too_short_points_leave_any_normal() {
        let points = [[0.0, 0.0, 0.3], [1.0, 0.0, 0.3], [0.5, 0.0, 2.0]];
        for points in [&points[..0], &points[..1], &points[1..]] {
            assert!(Normals::of(points, 0.0).off_rad > 1.57, "{points:?}");
        }
        // By hand: a matrix of 2 and 1 is 2 long at most, allowed for as the sum; a place 3 away is seen 3 away along some normal.
        assert!((2.0..3.001).contains(&Normals::any().longest([Interval::point(2.0), Interval::ZERO, Interval::ONE])));
        assert!((3.0..4.3).contains(&Normals::any().farthest([Interval::point(3.0), Interval::ZERO])));
    }
}
