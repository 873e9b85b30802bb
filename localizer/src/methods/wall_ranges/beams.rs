//! What the beams of one scan say about a box of poses.

use std::sync::Arc;

use interval::{
    Interval, IntervalBox,
    contractor::q_intersection,
    linear_program::{LinearProgram, Solver, certified_minimum},
};

use crate::PoseBox;

use super::face::{Face, dot};

/// A beam that met something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    /// Direction of the beam from robot forward, counter-clockwise, by the nominal mount.
    pub(super) bearing: Interval,
    /// True distance from the scanner to what the beam met.
    pub(super) distance: Interval,
    /// Greatest distance, seen from above, by which the lean of the beam shortens it.
    pub(super) shortened_m: f64,
}

/// The beams of one scan among the walls of a map, as seen from the nominal mount of the scanner on the robot.
pub(super) struct Beams {
    pub(super) faces: Arc<[Face]>,
    /// Greatest distance of any point of a wall from its place on the map.
    pub(super) placement_m: f64,
    /// Nominal position of the scanner in the robot frame.
    pub(super) mount_m: [f64; 2],
    pub(super) beams: Vec<Beam>,
    /// Greatest number of the beams that may end elsewhere than at a mapped wall; `None` where it is not known.
    pub(super) most_wrong: Option<usize>,
}

/// A point that moves with the robot, as seen in a box of poses: less the robot's position, it is `middle` at the middle heading, and changes with
/// the heading by `slope`.
#[derive(Clone, Copy)]
struct Lever {
    middle: [Interval; 2],
    slope: [Interval; 2],
    shift: Interval,
}

impl Lever {
    /// Interval of the point's place, measured along a unit vector.
    fn place(&self, at: &PoseBox, turn: Interval, along: [Interval; 2]) -> Interval {
        let lever = dot(along, self.middle) + turn * dot(along, self.slope);
        dot(along, [at[0], at[1]]) + lever + self.shift
    }

    /// The poses of a box in which the point's place, measured along a unit vector, is within a range. `middle` is the heading at which the lever
    /// was taken.
    fn within(&self, at: &PoseBox, middle: Interval, along: [Interval; 2], range: Interval) -> PoseBox {
        let rest = range - dot(along, self.middle) - self.shift;
        let slope = dot(along, self.slope);
        let mut left = *at;
        for axis in 0..2 {
            if !along[axis].contains_zero() {
                let others = along[1 - axis] * left[1 - axis] + (left[2] - middle) * slope;
                left[axis] = left[axis].intersect((rest - others) / along[axis]);
            }
        }
        if !slope.contains_zero() {
            let turn = (rest - dot(along, [left[0], left[1]])) / slope;
            left[2] = left[2].intersect(turn + middle);
        }
        left
    }
}

/// Greatest number of times that a box is contracted by the same beams.
const MOST_PASSES: usize = 4;
/// Width of a heading interval up to which the beams are linearised in the heading together.
const WIDEST_ROW_RAD: f64 = 0.2;
/// Share of a width by which a pass must narrow a box for another pass to be worth its time.
const WORTH_ANOTHER: f64 = 0.1;

impl Beams {
    /// The part of a box of poses that the beams leave.
    pub(super) fn contracted(&self, domain: &PoseBox) -> PoseBox {
        let mut left = *domain;
        for _ in 0..MOST_PASSES {
            let before = left;
            left = self.by_rows(&self.pass(&before));
            let is_narrower = |axis: usize| left.width(axis) < (1.0 - WORTH_ANOTHER) * before.width(axis);
            if left.is_empty() || !(0..3).any(is_narrower) {
                break;
            }
        }
        left
    }

    /// The box that a linear program leaves of the poses of a box: that no beam passes through a wall, linearised in the heading about the middle of
    /// the box, as one row for each beam and wall. Two beams that slant to either side of a wall's normal tell how far the wall is whatever the
    /// heading, which neither of them tells by itself.
    fn by_rows(&self, domain: &PoseBox) -> PoseBox {
        if domain.is_empty() || domain.width(2) > WIDEST_ROW_RAD {
            return *domain;
        }
        let middle = Interval::point(domain[2].mid());
        let turn = domain[2] - middle;
        let (eye, ends) = (self.eye(domain[2], middle), self.ends(domain[2], middle));
        let centre = [0, 1].map(|axis| Interval::point(domain[axis].mid()));
        let deviations = [domain[0] - centre[0], domain[1] - centre[1], turn];
        let Ok(mut program) = LinearProgram::new(deviations.to_vec()) else { return *domain };
        for end in &ends {
            for face in self.faces.iter().filter(|face| self.bounds(face, &eye, end, domain, turn)) {
                let [normal, slope] = [face.normal, [-end.middle[1], end.middle[0]]];
                let coefficients = [normal[0], normal[1], dot(normal, slope)];
                let row = coefficients.map(Interval::mid);
                // By Taylor's theorem the lever at the heading θ₀ + δ is that at θ₀, plus δ times its slope there, less δ²/2 times the lever at some
                // heading between.
                let bent = turn.sqr() * 0.5 * dot(normal, [end.slope[1], -end.slope[0]]);
                let constant = dot(normal, centre) + dot(normal, end.middle) + end.shift - bent;
                let rounded = (0..3).fold(Interval::ZERO, |sum, axis| {
                    sum + (coefficients[axis] - Interval::point(row[axis])) * deviations[axis]
                });
                let least = Interval::point(self.line(face)) - constant - rounded;
                let terms = [(0, row[0]), (1, row[1]), (2, row[2])];
                if program.add_row(&terms, Interval::new(least.lo(), f64::INFINITY)).is_err() {
                    return *domain;
                }
            }
        }
        if program.n_rows() == 0 {
            return *domain;
        }
        let mut solver = Solver::new(&program);
        let mut least = |axis: usize, sign: f64| {
            let cost = [(axis, sign)];
            let duals = solver.minimise(&cost);
            certified_minimum(&program, &cost, &duals)
        };
        let range = |least: f64, most: f64| if least <= most { Interval::new(least, most) } else { Interval::EMPTY };
        let [x, y, heading] = [0, 1, 2].map(|axis| range(least(axis, 1.0), -least(axis, -1.0)));
        let left = [x + centre[0], y + centre[1], heading + middle];
        IntervalBox::new([0, 1, 2].map(|axis| domain[axis].intersect(left[axis])))
    }

    /// The least distance along a wall's normal, from the world's origin, that a point before the true wall may have.
    fn line(&self, face: &Face) -> f64 {
        (face.offset - Interval::point(self.placement_m)).lo()
    }

    /// Whether a wall bounds the poses of a box by the beam that ends at `end`: the scanner is certainly in front of it, the whole beam beside no end
    /// of it, and at some pose the beam would end behind it.
    ///
    /// A beam that reached behind the wall's line would then have passed through the wall. Each point of the true wall is within the placement of its
    /// place on the map.
    fn bounds(&self, face: &Face, eye: &Lever, end: &Lever, at: &PoseBox, turn: Interval) -> bool {
        // Most beams stay before most walls.
        if end.place(at, turn, face.normal).lo() >= self.line(face) {
            return false;
        }
        let around = Interval::point(self.placement_m);
        let is_in_front = eye.place(at, turn, face.normal).lo() > (face.offset + around).hi();
        let beside = eye.place(at, turn, face.along).hull(end.place(at, turn, face.along));
        let [from, to] = [(face.ends[0] + around).hi(), (face.ends[1] - around).lo()];
        is_in_front && from <= beside.lo() && beside.hi() <= to
    }

    /// The part of a box of poses that each beam by itself leaves.
    pub(super) fn pass(&self, domain: &PoseBox) -> PoseBox {
        if domain.is_empty() {
            return IntervalBox::EMPTY;
        }
        let heading = domain[2];
        let middle = Interval::point(heading.mid());
        let (eye, ends) = (self.eye(heading, middle), self.ends(heading, middle));
        let mut left = *domain;
        for end in &ends {
            left = self.before_walls(&left, &eye, end, middle);
            if left.is_empty() {
                return left;
            }
        }
        let Some(q) = self.most_wrong.filter(|most| *most < ends.len()) else { return left };
        let boxes: Vec<PoseBox> = ends.iter().map(|end| self.at_a_wall(&left, &eye, end, middle)).collect();
        left.intersect(&q_intersection(&boxes, q))
    }

    /// The scanner as a point that moves with the robot.
    fn eye(&self, heading: Interval, middle: Interval) -> Lever {
        let [forward, left] = self.mount_m.map(Interval::point);
        let turned = |heading: Interval| {
            let (sin, cos) = (heading.sin(), heading.cos());
            [cos * forward - sin * left, sin * forward + cos * left]
        };
        let over = turned(heading);
        Lever { middle: turned(middle), slope: [-over[1], over[0]], shift: Interval::ZERO }
    }

    /// The ends of the beams as points that move with the robot.
    fn ends(&self, heading: Interval, middle: Interval) -> Vec<Lever> {
        let eye = self.eye(heading, middle);
        let end = |beam: &Beam| {
            let [at_middle, over] = [middle, heading].map(|heading| {
                let direction = heading + beam.bearing;
                [beam.distance * direction.cos(), beam.distance * direction.sin()]
            });
            Lever {
                middle: [0, 1].map(|axis| eye.middle[axis] + at_middle[axis]),
                slope: [eye.slope[0] - over[1], eye.slope[1] + over[0]],
                shift: around(beam.shortened_m),
            }
        };
        self.beams.iter().map(end).collect()
    }

    /// The poses of a box at which the beam that ends at `end` passes through no wall.
    fn before_walls(&self, domain: &PoseBox, eye: &Lever, end: &Lever, middle: Interval) -> PoseBox {
        let mut left = *domain;
        for face in self.faces.iter() {
            if self.bounds(face, eye, end, &left, left[2] - middle) {
                left = end.within(&left, middle, face.normal, Interval::new(self.line(face), f64::INFINITY));
                if left.is_empty() {
                    return IntervalBox::EMPTY;
                }
            }
        }
        left
    }

    /// Whether a wall may show its front to the scanner at some pose of a box. The ends of the straight true wall are each within the placement of
    /// their places on the map, so that beyond an end its line departs from the mapped one by more.
    fn may_show(&self, face: &Face, eye: &Lever, domain: &PoseBox, turn: Interval) -> bool {
        let beside = eye.place(domain, turn, face.along);
        let beyond = (face.ends[0] - beside).max(beside - face.ends[1]).max(Interval::ZERO);
        let length = face.ends[1] - face.ends[0];
        let departs = Interval::point(self.placement_m) * (Interval::ONE + beyond * 2.0 / length);
        (eye.place(domain, turn, face.normal) - face.offset + departs).hi() >= 0.0
    }

    /// A box around the poses of a box at which the beam that ends at `end` ends at the front of a mapped wall.
    fn at_a_wall(&self, domain: &PoseBox, eye: &Lever, end: &Lever, middle: Interval) -> PoseBox {
        let turn = domain[2] - middle;
        let mut hull = IntervalBox::EMPTY;
        for face in self.faces.iter() {
            let around = around(self.placement_m);
            let (across, length) = (face.offset + around, face.ends[0].hull(face.ends[1]) + around);
            let is_possible = !end.place(domain, turn, face.normal).is_disjoint_from(across)
                && !end.place(domain, turn, face.along).is_disjoint_from(length)
                && self.may_show(face, eye, domain, turn);
            if is_possible {
                let across_it = end.within(domain, middle, face.normal, across);
                hull = hull.hull(&end.within(&across_it, middle, face.along, length));
            }
        }
        hull
    }
}

/// The interval from −`radius` to `radius`.
fn around(radius: f64) -> Interval {
    Interval::new(-radius, radius)
}
