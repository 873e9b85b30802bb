//! A convex polygon that can be cut by half-planes.

use interval::Interval;

/// Relative amount by which a cut of the polygon keeps more than the half-plane: a fraction of the coordinates' size, far more than rounding in the
/// cut can lose.
const SLACK: f64 = 1e-12;

/// Greatest number of corners of a polygon. A cut that would leave more corners is left out; the polygon then stays a little larger than it
/// could be.
const MOST_CORNERS: usize = 32;

/// A convex polygon, given by its corners in counter-clockwise order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polygon {
    corners: Vec<[f64; 2]>,
}

impl Polygon {
    pub(super) fn rectangle([x, y]: [Interval; 2]) -> Self {
        let [x, y] = [x, y].map(|side| side.inflate(SLACK));
        Polygon { corners: vec![[x.lo(), y.lo()], [x.hi(), y.lo()], [x.hi(), y.hi()], [x.lo(), y.hi()]] }
    }

    pub(super) fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        self.corners.iter().copied()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Enclosure of one coordinate of the polygon's points.
    pub(super) fn side(&self, axis: usize) -> Interval {
        self.corners().fold(Interval::EMPTY, |side, corner| side.hull(Interval::point(corner[axis])))
    }

    /// The part of the polygon where x + slope·y ≤ bound.
    pub(super) fn below(&self, slope: f64, bound: f64) -> Polygon {
        self.cut(|[x, y]| bound + SLACK * (1.0 + x.abs() + (slope * y).abs()) - (x + slope * y))
    }

    /// The part of the polygon where x + slope·y ≥ bound.
    pub(super) fn above(&self, slope: f64, bound: f64) -> Polygon {
        self.cut(|[x, y]| x + slope * y + SLACK * (1.0 + x.abs() + (slope * y).abs()) - bound)
    }

    /// The part of the polygon where the function `inside` is not negative. The function is linear, but for a small slack against rounding.
    fn cut(&self, inside: impl Fn([f64; 2]) -> f64) -> Polygon {
        let mut corners = Vec::new();
        for (idx, &corner) in self.corners.iter().enumerate() {
            let next = self.corners[(idx + 1) % self.corners.len()];
            let (here, there) = (inside(corner), inside(next));
            if here >= 0.0 {
                corners.push(corner);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                let share = here / (here - there);
                corners.push([0, 1].map(|axis| corner[axis] + share * (next[axis] - corner[axis])));
            }
        }
        if corners.len() > MOST_CORNERS.max(self.corners.len()) {
            return self.clone();
        }
        Polygon { corners }
    }

    /// The polygon widened along x: all points that are at most `reach` away along x from a point of this polygon.
    pub(super) fn wider(&self, reach: f64) -> Polygon {
        let n = self.corners.len();
        let mut corners = Vec::with_capacity(n + 2);
        for (idx, corner) in self.corners().enumerate() {
            let rises = [corner[1] - self.corners[(idx + n - 1) % n][1], self.corners[(idx + 1) % n][1] - corner[1]];
            // With the corners in counter-clockwise order, edges of the polygon's right side rise and those of its left side fall. A corner between
            // a rising and a falling edge is moved in both directions along x.
            for rise in rises.into_iter().filter(|rise| *rise != 0.0) {
                let moved = [corner[0] + reach.copysign(rise), corner[1]];
                if corners.last() != Some(&moved) {
                    corners.push(moved);
                }
            }
        }
        Polygon { corners }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square with its corner at (2, 2) cut off.
    fn house() -> Polygon {
        Polygon::rectangle([Interval::new(0.0, 2.0); 2]).below(1.0, 3.0)
    }

    /// The part of a horizontal line that is in a polygon, computed from the polygon's edges.
    fn slice(polygon: &Polygon, y: f64) -> Interval {
        let n = polygon.corners.len();
        let crossings = (0..n).filter_map(|idx| {
            let ([ax, ay], [bx, by]) = (polygon.corners[idx], polygon.corners[(idx + 1) % n]);
            ((ay < y) != (by < y)).then(|| ax + (y - ay) / (by - ay) * (bx - ax))
        });
        crossings.fold(Interval::EMPTY, |slice, x| slice.hull(Interval::point(x)))
    }

    #[test]
    fn half_planes_leave_what_is_on_both_sides_and_nothing_else() {
        let cut = house().above(-0.5, -0.25);
        for step in 0..10_000 {
            // The test points' coordinates are irrational, so that no test point is on an edge.
            let [x, y] = [step % 100, step / 100].map(|at| f64::from(at) * 0.03 - 0.2_f64.sqrt());
            let expected = Interval::new((0.5 * y - 0.25).max(0.0), (3.0 - y).min(2.0));
            let is_in = (0.0..=2.0).contains(&y) && expected.contains(x);
            assert_eq!(slice(&cut, y).contains(x), is_in, "{x} {y}");
            let is_near = (0.0..=2.0).contains(&y) && expected.inflate(0.5).contains(x);
            assert_eq!(slice(&cut.wider(0.5), y).contains(x), is_near, "{x} {y}");
        }
        assert!(house().below(1.0, -0.1).is_empty());
        assert_eq!(house().below(1.0, 4.1), house());
    }

    #[test]
    fn corners_do_not_grow_without_end() {
        let mut polygon = Polygon::rectangle([Interval::new(-2.0, 2.0); 2]);
        for step in 0..1000 {
            let slope = (f64::from(step) * 0.0031 - 1.55).tan();
            polygon = polygon.below(slope, (1.0 + slope * slope).sqrt());
        }
        assert!(polygon.corners.len() <= MOST_CORNERS);
        // All half-planes are tangent to the unit circle, so the circle is still in the polygon.
        let side = polygon.side(1);
        assert!(side.contains(1.0) && side.contains(-1.0));
    }
}
