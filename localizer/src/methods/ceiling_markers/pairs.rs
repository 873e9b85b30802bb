//! Heading from pairs of marker dots that share their errors.
//!
//! Take the vector from one dot to another, b in the apparent frame and w in the world. The heading is the angle between the two: θ = arg w
//! − arg b. Errors that the dots share, above all the height of the marker, change b along its own direction and hardly across, so they
//! cost the angle next to nothing; as errors of each dot alone they would cost as much as the pixel errors do. A shift of all dots does not
//! enter at all.

use interval::Interval;

use super::ray::{BODY_TILT, MOUNT_TILT, N_PARAMETERS, SeenDot, is_own};

/// Share of the longest distance between two marker dots. A pair of dots nearer to each other than that is left out: it tells nothing about
/// the heading that longer pairs do not tell better.
const SHORTEST: f64 = 0.5;

/// Apparent headings that all long pairs of dots allow, up to whole turns; `None` when no pair decides, empty when pairs contradict each
/// other.
pub(super) fn heading(dots: &[SeenDot], is_one_marker: bool) -> Option<Interval> {
    let pairs = || (0..dots.len()).flat_map(|second| (0..second).map(move |first| (&dots[first], &dots[second])));
    let length_m = |(first, second): (&SeenDot, &SeenDot)| {
        let [x, y] = [0, 1].map(|axis| (second.in_world_m[axis] - first.in_world_m[axis]).mid());
        x.hypot(y)
    };
    let longest_m = pairs().map(length_m).fold(0.0, f64::max);
    let mut known: Option<Interval> = None;
    for (first, second) in pairs().filter(|pair| length_m(*pair) >= SHORTEST * longest_m) {
        let Some(turned) = heading_of_pair(first, second, is_one_marker) else { continue };
        known = Some(known.map_or(turned, |known| same_turn(known, turned)));
    }
    known
}

/// Intersection of two intervals of headings, each narrower than half a turn, after `other` is moved by whole turns to lie next to `known`.
pub(super) fn same_turn(known: Interval, other: Interval) -> Interval {
    let turns = ((known.mid() - other.mid()) / std::f64::consts::TAU).round();
    known.intersect(other + turns * (2.0 * Interval::PI))
}

fn heading_of_pair(first: &SeenDot, second: &SeenDot, is_one_marker: bool) -> Option<Interval> {
    let in_world = [0, 1].map(|axis| second.in_world_m[axis] - first.in_world_m[axis]);
    let middle = [0, 1].map(|axis| second.sight.middle_m[axis] - first.sight.middle_m[axis]);
    // Coordinate frame with one axis along the vector b from one marker dot to another, and one axis across it.
    let frame = Frame::along(middle.map(Interval::mid))?;
    let [mut along, mut across] = frame.components(middle);
    let grow = |sum: Interval, by: Interval| sum.inflate(by.hi());
    let shared = |k: usize| [0, 1].map(|axis| second.sight.slopes[axis][k] - first.sight.slopes[axis][k]);
    let deviation = |dot: &SeenDot, k: usize| dot.sight.deviations[k].magnitude();
    for k in (0..N_PARAMETERS).filter(|k| !BODY_TILT.contains(k) && !MOUNT_TILT.contains(k)) {
        let terms: Vec<([Interval; 2], f64)> = if is_own(k, is_one_marker) {
            [first, second].map(|dot| ([0, 1].map(|axis| dot.sight.slopes[axis][k]), deviation(dot, k))).to_vec()
        } else {
            vec![(shared(k), deviation(first, k))]
        };
        for (slopes, deviation) in terms {
            let [by_along, by_across] = frame.components(slopes);
            along = grow(along, by_along.abs() * deviation);
            across = grow(across, by_across.abs() * deviation);
        }
    }
    for [a, b] in [BODY_TILT, MOUNT_TILT] {
        let [along_a, across_a] = frame.components(shared(a));
        let [along_b, across_b] = frame.components(shared(b));
        let radius = deviation(first, a);
        along = grow(along, along_a.hypot(along_b) * radius);
        across = grow(across, across_a.hypot(across_b) * radius);
    }
    let world_frame = Frame::along(in_world.map(Interval::mid))?;
    let [world_along, world_across] = world_frame.components(in_world);
    let turn = |along: Interval, across: Interval| (along.lo() > 0.0).then(|| across.atan2(along));
    Some(world_frame.angle() + turn(world_along, world_across)? - frame.angle() - turn(along, across)?)
}

/// Coordinate axes along and across a vector. The vector need not have unit length, as only angles are computed from the components.
struct Frame([Interval; 2]);

impl Frame {
    fn along(vector: [f64; 2]) -> Option<Frame> {
        (vector[0].hypot(vector[1]) > 0.0).then(|| Frame(vector.map(Interval::point)))
    }

    fn components(&self, [x, y]: [Interval; 2]) -> [Interval; 2] {
        let Frame([c, s]) = self;
        [*c * x + *s * y, *c * y - *s * x]
    }

    fn angle(&self) -> Interval {
        let Frame([x, y]) = self;
        // Where the vector points towards the cut of the arc tangent, the opposite vector is used and half a turn is added.
        if x.hi() < 0.0 { (-*y).atan2(-*x) + Interval::PI } else { y.atan2(*x) }
    }
}
