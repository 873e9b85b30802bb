//! Simple polygons on a plane, cut into convex pieces.

use nalgebra::{Vector2, vector};

/// Distance from a line between its neighbours up to which a corner counts as none.
const STRAIGHT_M: f64 = 1e-7;
/// Tolerance for rounding by which a point on a polygon's border counts as inside.
const ROUNDING_M: f64 = 1e-9;

/// A simple polygon, convex or not. Its corners go round counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polygon {
    corners: Vec<Vector2<f64>>,
    pieces: Vec<Piece>,
}

/// A convex piece of a polygon. Its corners, which go round counter-clockwise, are corners of the polygon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) corners: Vec<Vector2<f64>>,
    /// Whether the piece's side that begins at each corner is a side of the polygon, and not a cut between two pieces.
    pub(crate) is_side: Vec<bool>,
}

impl Polygon {
    /// The polygon with the given corners, in order in either direction. Corners on a straight line between their neighbours are left out.
    pub(crate) fn new(corners_m: &[[f64; 2]]) -> Polygon {
        let mut corners: Vec<Vector2<f64>> = corners_m.iter().map(|corner_m| Vector2::from(*corner_m)).collect();
        if doubled_area(&corners) < 0.0 {
            corners.reverse();
        }
        let count = corners.len();
        let bends = |index: &usize| {
            let [before, at, after] = [count - 1, 0, 1].map(|step| corners[(index + step) % count]);
            let along = after - before;
            (at - before).perp(&along).abs() > STRAIGHT_M * along.norm()
        };
        let corners: Vec<Vector2<f64>> = (0..count).filter(bends).map(|index| corners[index]).collect();
        let pieces = convex(&corners).into_iter().map(|piece| Piece::of(&corners, &piece)).collect();
        Polygon { corners, pieces }
    }

    /// Corners of the polygon, counter-clockwise.
    pub(crate) fn corners(&self) -> &[Vector2<f64>] {
        &self.corners
    }

    /// Convex pieces that make up the polygon.
    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Sides of the polygon from corner to corner, with the inside on their left.
    pub(crate) fn sides(&self) -> impl Iterator<Item = [Vector2<f64>; 2]> + '_ {
        sides(&self.corners)
    }

    /// Whether a point is inside the polygon or on its border.
    pub(crate) fn contains(&self, at: Vector2<f64>) -> bool {
        self.pieces.iter().any(|piece| piece.contains(at))
    }

    /// The nearest point that is about `inset_m` or more within the polygon, which is the given point itself where it is.
    pub(crate) fn nearest_within(&self, at: Vector2<f64>, inset_m: f64) -> Vector2<f64> {
        let count = self.corners.len();
        let of_side = |index: usize| {
            let [from, to] = [index, index + 1].map(|corner| self.corners[corner % count]);
            let way = to - from;
            let length_m = way.norm();
            let share = (at - from).dot(&way) / (length_m * length_m).max(f64::MIN_POSITIVE);
            (index, share, (at - from - way * share.clamp(0.0, 1.0)).norm())
        };
        let nearest = (0..count).map(of_side).min_by(|one, other| one.2.total_cmp(&other.2));
        let Some((index, share, away_m)) = nearest else { return at };
        if away_m >= inset_m && self.contains(at) {
            return at;
        }
        let [from, to] = [index, index + 1].map(|corner| self.corners[corner % count]);
        let way = to - from;
        let length_m = way.norm();
        // A point in a corner keeps its distance from both sides.
        let [least, most] = [index, index + 1].map(|corner| (self.off_corner_m(corner, inset_m) / length_m).min(0.5));
        from + way * share.clamp(least, 1.0 - most) + vector![-way.y, way.x] * (inset_m / length_m)
    }

    /// Distance along a side from a corner at which a point is `inset_m` away from the other side there; 0 where the polygon is not convex.
    fn off_corner_m(&self, index: usize, inset_m: f64) -> f64 {
        let count = self.corners.len();
        let [before, at, after] = [index + count - 1, index, index + 1].map(|corner| self.corners[corner % count]);
        let (back, on) = ((before - at).normalize(), (after - at).normalize());
        // The tangent of half of the angle between both sides, of which the cross product is the sine.
        let (sine, cosine) = (on.perp(&back), on.dot(&back));
        if sine <= 0.0 { 0.0 } else { inset_m * (1.0 + cosine) / sine }
    }

    /// How far the plane behind the line of a side is free of the polygon, beyond the side's start and beyond its end, as distances along the line:
    /// infinite where the polygon does not reach there, and 0 at corners at which it is not convex.
    pub(crate) fn free_beyond_m(&self, [from, to]: [Vector2<f64>; 2]) -> [f64; 2] {
        let along = (to - from).normalize();
        [(from, -along), (to, along)].map(|(end, outwards)| {
            let behind_m = |at: Vector2<f64>| along.perp(&(from - at)) - STRAIGHT_M;
            let beyond_m = |at: Vector2<f64>| outwards.dot(&(at - end)) + STRAIGHT_M;
            let corner = (0..self.corners.len()).find(|index| self.corners[*index] == end);
            if corner.is_some_and(|index| !self.is_convex_at(index)) {
                return 0.0;
            }
            // The part of each side of the polygon that is behind the line and beyond the end, as shares of its length.
            let reaches = self.sides().filter_map(|[one, other]| {
                let (mut low, mut high) = (0.0_f64, 1.0_f64);
                for [start, stop] in [[behind_m(one), behind_m(other)], [beyond_m(one), beyond_m(other)]] {
                    match (start > 0.0, stop > 0.0) {
                        (true, true) => {}
                        (false, false) => return None,
                        (true, false) => high = high.min(start / (start - stop)),
                        (false, true) => low = low.max(start / (start - stop)),
                    }
                }
                let nearest_m = [low, high].map(|share| beyond_m(one + (other - one) * share));
                (low < high).then(|| nearest_m[0].min(nearest_m[1]).max(0.0))
            });
            reaches.fold(f64::INFINITY, f64::min)
        })
    }

    fn is_convex_at(&self, index: usize) -> bool {
        let count = self.corners.len();
        let [before, at, after] = [index + count - 1, index, index + 1].map(|corner| self.corners[corner % count]);
        (at - before).perp(&(after - at)) > 0.0
    }

    /// Area of the polygon.
    pub(crate) fn area_m2(&self) -> f64 {
        doubled_area(&self.corners) / 2.0
    }

    /// The polygon with each point moved by `place`, which must keep shapes but may mirror them.
    pub(crate) fn moved(&self, place: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Polygon {
        Polygon::new(&self.corners.iter().map(|corner| place(*corner).into()).collect::<Vec<_>>())
    }
}

impl Piece {
    fn of(corners: &[Vector2<f64>], piece: &[usize]) -> Piece {
        let next = |at: usize| piece[(at + 1) % piece.len()];
        Piece {
            corners: piece.iter().map(|index| corners[*index]).collect(),
            is_side: (0..piece.len()).map(|at| next(at) == (piece[at] + 1) % corners.len()).collect(),
        }
    }

    /// Whether a point is in the piece or on its border.
    pub(crate) fn contains(&self, at: Vector2<f64>) -> bool {
        sides(&self.corners).all(|[from, to]| {
            let way = to - from;
            way.perp(&(at - from)) >= -ROUNDING_M * way.norm()
        })
    }

    /// Sides of the piece from corner to corner, with the inside on their left.
    pub(crate) fn sides(&self) -> impl Iterator<Item = [Vector2<f64>; 2]> + '_ {
        sides(&self.corners)
    }
}

fn sides(corners: &[Vector2<f64>]) -> impl Iterator<Item = [Vector2<f64>; 2]> + '_ {
    (0..corners.len()).map(|index| [corners[index], corners[(index + 1) % corners.len()]])
}

/// Twice the area of a polygon, which is negative if its corners go round clockwise.
fn doubled_area(corners: &[Vector2<f64>]) -> f64 {
    sides(corners).map(|[from, to]| from.perp(&to)).sum()
}

/// Cuts a polygon into convex pieces along diagonals, each by the indices of its corners: into triangles first, which are joined wherever the
/// result is convex (Hertel and Mehlhorn, Fast Triangulation of Simple Polygons, 1983).
fn convex(corners: &[Vector2<f64>]) -> Vec<Vec<usize>> {
    let mut pieces: Vec<Vec<usize>> = triangles(corners);
    let turns_left = |[one, at, other]: [usize; 3]| {
        let (before, after) = (corners[at] - corners[one], corners[other] - corners[at]);
        before.perp(&after) >= -ROUNDING_M * before.norm() * after.norm()
    };
    let is_convex =
        |piece: &[usize]| (0..piece.len()).all(|at| turns_left([0, 1, 2].map(|step| piece[(at + step) % piece.len()])));
    let mut first = 0;
    while first < pieces.len() {
        let joined = (first + 1..pieces.len()).find_map(|second| {
            let joined = joined(&pieces[first], &pieces[second])?;
            is_convex(&joined).then_some((second, joined))
        });
        match joined {
            Some((second, joined)) => {
                pieces[first] = joined;
                pieces.remove(second);
            }
            None => first += 1,
        }
    }
    pieces
}

/// Two pieces as one, without the side that they share; `None` if they share none.
fn joined(one: &[usize], other: &[usize]) -> Option<Vec<usize>> {
    let side = |piece: &[usize], at: usize| [piece[at], piece[(at + 1) % piece.len()]];
    let pairs = (0..one.len()).flat_map(|at| (0..other.len()).map(move |beside| (at, beside)));
    let shared = |(at, beside): &(usize, usize)| {
        let [from, to] = side(other, *beside);
        side(one, *at) == [to, from]
    };
    let (at, beside) = pairs.into_iter().find(shared)?;
    let rest = |piece: &[usize], at: usize, count: usize| -> Vec<usize> {
        (1..=count).map(|step| piece[(at + step) % piece.len()]).collect()
    };
    Some([rest(one, at, one.len()), rest(other, beside + 1, other.len() - 2)].concat())
}

/// Cuts a polygon into triangles, each by the indices of its corners: ears are cut off one after the other, that with the shortest cut first.
fn triangles(corners: &[Vector2<f64>]) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut found = Vec::new();
    while left.len() > 3 {
        let count = left.len();
        let around = |at: usize| [count - 1, 0, 1].map(|step| left[(at + step) % count]);
        let turn =
            |[before, at, after]: [usize; 3]| (corners[at] - corners[before]).perp(&(corners[after] - corners[at]));
        let is_ear = |at: &usize| {
            let ear = around(*at);
            turn(ear) > 0.0 && !left.iter().any(|other| !ear.contains(other) && is_in(corners, ear, corners[*other]))
        };
        let cut_m = |at: &usize| {
            let [before, _, after] = around(*at);
            (corners[after] - corners[before]).norm()
        };
        let shortest = |one: &usize, other: &usize| cut_m(one).total_cmp(&cut_m(other));
        // Every simple polygon has an ear. What rounding makes of one is cut where it turns most to the left.
        let ear = (0..count).filter(is_ear).min_by(shortest);
        let widest = || (0..count).max_by(|one, other| turn(around(*one)).total_cmp(&turn(around(*other))));
        let Some(at) = ear.or_else(widest) else { break };
        found.push(around(at).to_vec());
        left.remove(at);
    }
    if left.len() == 3 {
        found.push(left);
    }
    found
}

/// Whether a point is in a triangle or on its border.
fn is_in(corners: &[Vector2<f64>], triangle: [usize; 3], at: Vector2<f64>) -> bool {
    (0..3).all(|side| {
        let [from, to] = [side, (side + 1) % 3].map(|index| corners[triangle[index]]);
        (to - from).perp(&(at - from)) >= 0.0
    })
}

/// Whether two convex polygons have more than a point in common: no side of either has the other wholly on its far side (separating axes).
pub(super) fn overlap(one: &[Vector2<f64>], other: &[Vector2<f64>]) -> bool {
    let parts = |one: &[Vector2<f64>], other: &[Vector2<f64>]| {
        (0..one.len()).any(|index| {
            let side = one[(index + 1) % one.len()] - one[index];
            let beside = |corner: &Vector2<f64>| side.perp(&(corner - one[index]));
            let [own, others] = [one, other].map(|shape| {
                shape
                    .iter()
                    .map(beside)
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
            });
            own[1] <= others[0] || others[1] <= own[0]
        })
    };
    !parts(one, other) && !parts(other, one)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// A polygon around a point, whose corners are at any distance from it: most are not convex at several corners.
    fn star(rng: &mut ChaCha8Rng) -> Vec<[f64; 2]> {
        let count = rng.random_range(3..=64_u32);
        let turn = rng.random_range(0.0..TAU);
        let corner = |index: u32| {
            let angle = turn + TAU * (f64::from(index) + rng.random_range(0.0..0.8)) / f64::from(count);
            let away_m = rng.random_range(0.2..5.0);
            [3.0 + away_m * angle.cos(), -2.0 + away_m * angle.sin()]
        };
        (0..count).map(corner).collect()
    }

    /// A comb: a straight back, from which teeth of any length stand out, with right angles throughout.
    fn comb(rng: &mut ChaCha8Rng) -> Vec<[f64; 2]> {
        let mut corners_m = vec![[0.0, 0.0]];
        let count = rng.random_range(1..=15_u32);
        for tooth in 0..count {
            let [left_m, right_m] = [0.1, 0.9].map(|x_m| f64::from(tooth) + x_m);
            let (gap_m, long_m) = (rng.random_range(0.3..1.0), rng.random_range(1.5..4.0));
            corners_m.extend([[left_m, gap_m], [left_m, long_m], [right_m, long_m], [right_m, gap_m]]);
        }
        corners_m.push([f64::from(count), 0.0]);
        // The way round is clockwise, and any corner may come first.
        let first = rng.random_range(0..corners_m.len());
        corners_m.rotate_left(first);
        corners_m
    }

    /// Whether a point is in a polygon, by the number of its sides that a ray meets (Shimrat 1962).
    fn is_inside(corners_m: &[[f64; 2]], [x_m, y_m]: [f64; 2]) -> bool {
        let sides = (0..corners_m.len()).map(|index| [corners_m[index], corners_m[(index + 1) % corners_m.len()]]);
        let is_met = |[from, to]: &[[f64; 2]; 2]| {
            (from[1] > y_m) != (to[1] > y_m) && x_m < from[0] + (to[0] - from[0]) * (y_m - from[1]) / (to[1] - from[1])
        };
        sides.filter(is_met).count() % 2 == 1
    }

    #[test]
    fn the_pieces_of_a_polygon_are_convex_and_fill_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for round in 0..400 {
            let corners_m = if round % 2 == 0 { star(&mut rng) } else { comb(&mut rng) };
            let polygon = Polygon::new(&corners_m);
            let sum_m2: f64 = polygon.pieces().iter().map(|piece| doubled_area(&piece.corners) / 2.0).sum();
            let shoelace: f64 = (0..corners_m.len())
                .map(|index| {
                    let ([x0, y0], [x1, y1]) = (corners_m[index], corners_m[(index + 1) % corners_m.len()]);
                    (x0 - x1) * (y0 + y1) / 2.0
                })
                .sum();
            assert!((sum_m2 - shoelace.abs()).abs() < 1e-9 * sum_m2.max(1.0), "{corners_m:?}: {sum_m2}");
            assert!((polygon.area_m2() - shoelace.abs()).abs() < 1e-9 * sum_m2.max(1.0));
            for piece in polygon.pieces() {
                let count = piece.corners.len();
                for index in 0..count {
                    let [before, at, after] = [0, 1, 2].map(|step| piece.corners[(index + step) % count]);
                    let (one, other) = ((at - before).normalize(), (after - at).normalize());
                    assert!(one.perp(&other) > -1e-8, "{corners_m:?}: a piece is not convex at {at}");
                }
            }
            // Two cuts at each corner at which the polygon is not convex suffice, and no other is left.
            let n_inner = (0..polygon.corners().len()).filter(|index| !polygon.is_convex_at(*index)).count();
            assert!(polygon.pieces().len() <= 2 * n_inner + 1, "{corners_m:?}: {} pieces", polygon.pieces().len());
            let sides: usize =
                polygon.pieces().iter().map(|piece| piece.is_side.iter().filter(|is_side| **is_side).count()).sum();
            assert_eq!(sides, polygon.corners().len(), "{corners_m:?}: every side is one of one piece");
            for _ in 0..200 {
                let at_m = [rng.random_range(-2.0..15.0), rng.random_range(-7.0..5.0)];
                let to_border_m = polygon.sides().map(|side| away_m(side, at_m.into())).fold(f64::INFINITY, f64::min);
                if to_border_m < 1e-6 {
                    continue;
                }
                let inside = is_inside(&corners_m, at_m);
                assert_eq!(polygon.contains(at_m.into()), inside, "{at_m:?} in {corners_m:?}");
                let within = polygon.nearest_within(at_m.into(), 0.002);
                assert!(is_inside(&corners_m, within.into()), "{at_m:?} moved to {within} in {corners_m:?}");
                let moved_m = (within - Vector2::from(at_m)).norm();
                // In a sharp corner the place that is 2 mm away from both sides is far from the corner.
                let least_m = if inside { 0.0 } else { to_border_m };
                assert!(moved_m < least_m + 0.8, "{at_m:?} in {corners_m:?} moved by {moved_m} m");
                assert!(!inside || to_border_m < 0.002 || moved_m == 0.0, "{at_m:?} in {corners_m:?} moved");
            }
        }
    }

    fn away_m([from, to]: [Vector2<f64>; 2], at: Vector2<f64>) -> f64 {
        let way = to - from;
        (at - from - way * ((at - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0)).norm()
    }

    #[test]
    fn corners_on_a_straight_line_are_left_out_and_an_l_has_two_pieces() {
        let l = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0], [2.0, 4.0], [0.0, 4.0]];
        let polygon = Polygon::new(&l);
        assert_eq!((polygon.corners().len(), polygon.pieces().len()), (6, 2));
        let mirrored: Vec<[f64; 2]> = l.iter().rev().copied().collect();
        assert_eq!(Polygon::new(&mirrored).area_m2(), 12.0);
    }

    #[test]
    fn the_floor_behind_a_wall_is_free_up_to_the_next_arm_of_the_room() {
        // A U: the left arm is 5 m high, the right one 3 m.
        let u = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [4.0, 3.0], [4.0, 2.0], [2.0, 2.0], [2.0, 5.0], [0.0, 5.0]];
        let polygon = Polygon::new(&u);
        let free_m = |from: [f64; 2], to: [f64; 2]| polygon.free_beyond_m([from.into(), to.into()]);
        let far = f64::INFINITY;
        assert_eq!(free_m([0.0, 0.0], [6.0, 0.0]), [far, far]);
        assert_eq!(free_m([4.0, 2.0], [2.0, 2.0]), [0.0, 0.0], "between two corners at which the room is not convex");
        // The end wall of the right arm faces down: beyond its left end, 2 m on, is the left arm.
        let [right_m, left_m] = free_m([6.0, 3.0], [4.0, 3.0]);
        assert!(right_m == far && (left_m - 2.0).abs() < 1e-5, "{right_m}, {left_m}");
    }
}
