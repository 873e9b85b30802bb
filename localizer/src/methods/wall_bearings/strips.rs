//! The poses at which an image edge may be an edge of the map, as strips of the plane for each heading, and how many of them agree.

use interval::{Interval, IntervalBox, contractor::q_intersection};

use crate::PoseBox;

/// A pair of an image edge and an upright edge of the map, seen from a place that moves with the robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Direction in which the image edge is seen, counter-clockwise from robot forward.
    pub(super) bearing: Interval,
    /// Place from which it is seen, in the robot frame.
    pub(super) eye_m: [Interval; 2],
    /// Place of the edge on the map, world x and y.
    pub(super) post_m: [f64; 2],
    /// Greatest distance of the true edge from that place.
    pub(super) placement_m: f64,
}

impl Strip {
    /// The part of a box of poses from which the edge of the map may be seen as the image edge; `None` where the heading is not known well enough
    /// to say anything.
    ///
    /// Let the edge be at P, the robot at t with the heading θ, the eye at t + R(θ)·a, and β the bearing. With ψ = θ + β the edge lies in the
    /// direction (cos ψ, sin ψ) from the eye, so that (−sin ψ, cos ψ)·(P − t) = a_y cos β − a_x sin β. For ψ = ψ₀ + δ with fixed ψ₀, and
    /// d = P − t, the left side is cos δ·(u·d) − sin δ·(w·d), where w = (cos ψ₀, sin ψ₀) and u = (−sin ψ₀, cos ψ₀).
    fn contracted(&self, domain: &PoseBox) -> PoseBox {
        let point = Interval::point;
        let middle = point(domain[2].mid());
        let course = middle + point(self.bearing.mid());
        let delta = (domain[2] - middle) + (self.bearing - point(self.bearing.mid()));
        if delta.magnitude() > WIDEST_DELTA_RAD {
            return *domain;
        }
        let (sin, cos) = (course.sin(), course.cos());
        let (across, along) = ([-sin, cos], [cos, sin]);
        let far = |left: &PoseBox, axis: usize| point(self.post_m[axis]) - left[axis];
        let dot = |left: &PoseBox, unit: [Interval; 2]| unit[0] * far(left, 0) + unit[1] * far(left, 1);
        let lever = self.bearing.cos() * self.eye_m[1] - self.bearing.sin() * self.eye_m[0];
        let offset = lever.inflate(self.placement_m) / delta.cos();
        let mut left = *domain;
        // The edge is before the eye. The eye is no farther from the robot's origin than the lengths of its coordinates together.
        let reach = self.eye_m[0].magnitude() + self.eye_m[1].magnitude() + self.placement_m;
        let ahead = dot(&left, along);
        if ahead.hi() + reach < 0.0 {
            return IntervalBox::EMPTY;
        }
        let turned = ahead * delta.tan();
        for axis in 0..2 {
            if across[axis].mignitude() > LEAST_PART {
                let other = across[1 - axis] * far(&left, 1 - axis);
                let distance = (offset + turned - other) / across[axis];
                left[axis] = left[axis].intersect(point(self.post_m[axis]) - distance);
            }
        }
        if left.is_empty() {
            return IntervalBox::EMPTY;
        }
        let ahead = dot(&left, along);
        if ahead.lo() > 0.0 {
            let turn = ((dot(&left, across) - offset) / ahead).atan();
            let heading = turn + middle - (self.bearing - point(self.bearing.mid()));
            left[2] = left[2].intersect(heading);
        }
        if left.is_empty() { IntervalBox::EMPTY } else { left }
    }

    /// Whether the edge of the map may be seen as the image edge from some pose of a box.
    pub(super) fn is_possible(&self, domain: &PoseBox) -> bool {
        !self.contracted(domain).is_empty()
    }
}

/// Greatest deviation of the direction of sight, either way, from its middle with which a strip is used.
const WIDEST_DELTA_RAD: f64 = 0.5;
/// Least component of a strip's unit normal along an axis for the strip to bound that axis.
const LEAST_PART: f64 = 1e-3;
/// Greatest width of a slice of the heading in which the place is bounded.
const SLICE_RAD: f64 = 0.003;
/// Greatest number of slices of the heading.
const MOST_SLICES: f64 = 16.0;
/// Number of times that a box is contracted as a whole before it is cut.
const PASSES: usize = 3;
/// Parts of the width of a box into which its place is cut along each axis, and least size of such a part.
const PARTS: f64 = 12.0;
const SMALLEST_M: f64 = 0.004;
/// Greatest number of parts of one slice, together for all boxes of a union.
const MOST_PARTS: usize = 160;

/// Sightings that are counted together: each is true of a pose if one of its strips holds the pose.
#[derive(Clone, Debug, Default)]
pub(super) struct Sightings {
    pub(super) each: Vec<Vec<Strip>>,
    /// Greatest number of them that may be false.
    pub(super) most_wrong: usize,
}

impl Sightings {
    /// The part of a box in which all but the number of sightings that may be wrong can be true.
    fn pass(&self, domain: &PoseBox) -> PoseBox {
        if self.most_wrong >= self.each.len() || domain.is_empty() {
            return *domain;
        }
        let one = |strips: &Vec<Strip>| {
            strips.iter().fold(IntervalBox::EMPTY, |hull: PoseBox, strip| hull.hull(&strip.contracted(domain)))
        };
        let boxes: Vec<PoseBox> = self.each.iter().map(one).collect();
        domain.intersect(&q_intersection(&boxes, self.most_wrong))
    }

    /// The hull of what the sightings leave of a box: the heading is cut into slices and the place into parts, so that slanting strips count, too.
    pub(super) fn contracted(&self, domain: &PoseBox, n_boxes: usize) -> PoseBox {
        let mut left = *domain;
        for _ in 0..PASSES {
            left = self.pass(&left);
        }
        if left.is_empty() || self.most_wrong >= self.each.len() {
            return left;
        }
        let n_slices = (left.width(2) / SLICE_RAD).ceil().clamp(1.0, MOST_SLICES);
        let most_parts = MOST_PARTS / n_boxes.max(1);
        let size_m = (left.width(0).max(left.width(1)) / PARTS).max(SMALLEST_M);
        let at = |index: f64| left[2].lo() + (left[2].hi() - left[2].lo()) * (index / n_slices);
        let slices = (0..n_slices as usize).map(|index| {
            let [from, to] = [index as f64, index as f64 + 1.0].map(at);
            let to = if index as f64 + 1.0 >= n_slices { left[2].hi() } else { to };
            let slice = IntervalBox::new([left[0], left[1], Interval::new(from, to).intersect(left[2])]);
            self.hull_of_parts(slice, size_m, most_parts)
        });
        slices.fold(IntervalBox::EMPTY, |hull: PoseBox, slice| hull.hull(&slice))
    }

    /// The hull of the parts of a slice that are left. A part that lies within what is already known to be left is not looked at.
    fn hull_of_parts(&self, slice: PoseBox, size_m: f64, most_parts: usize) -> PoseBox {
        let mut pending = std::collections::VecDeque::from([slice]);
        let mut hull = IntervalBox::EMPTY;
        for _ in 0..most_parts {
            let Some(part) = pending.pop_front() else { break };
            if part.is_subset_of(&hull) {
                continue;
            }
            let part = self.pass(&part);
            let axis = usize::from(part.width(1) > part.width(0));
            if part.is_empty() {
                continue;
            }
            if part.width(axis) <= size_m {
                hull = hull.hull(&part);
            } else {
                let (low, high) = part.bisect(axis);
                pending.extend([low, high]);
            }
        }
        pending.iter().fold(hull, |hull, part| hull.hull(part))
    }
}
