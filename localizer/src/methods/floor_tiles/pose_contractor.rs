//! Contractor on the robot's pose, made from all joints of one image of the floor.

use std::sync::Arc;

use interval::contractor::{Contractor, Outcome};
use interval::{Interval, IntervalBox};

use super::{Geometry, joint::Joint};

/// Contractor on the pose that assumes that all but at most `q_items` of the seen lines are joints of the tile grid.
///
/// It is sound: the heading is cut into slices, each slice keeps the grid positions that all but q lines allow, and the hull of the slices
/// is returned; [`Contractor::branches`] keeps nothing between two tiles or two quadrants. It is optimal up to the slices' width for one
/// line of each family.
pub(super) struct TileJoints {
    joints: Vec<Joint>,
    geometry: Arc<Geometry>,
    q_items: usize,
}

/// Box of poses in the grid frame, with only a slice of heading.
#[derive(Clone, Copy)]
struct GridBox {
    position: [Interval; 2],
    heading: Interval,
}

impl TileJoints {
    pub(super) fn new(joints: Vec<Joint>, geometry: Arc<Geometry>, q_items: usize) -> Self {
        TileJoints { joints, geometry, q_items }
    }

    /// Headings that all but q lines of the image allow, as disjoint intervals inside `heading`.
    fn headings(&self, heading: Interval) -> Vec<Interval> {
        let mut found = Vec::new();
        if !is_cut(heading) {
            return vec![heading];
        }
        // With at most q lines wrong, one of any q + 1 lines is right: the union of the headings that they allow holds the true heading.
        for joint in self.joints.iter().take(self.q_items + 1) {
            let (first, last) = joint.families(heading, &self.geometry);
            found.extend((first..=last).map(|family| joint.heading(family, &self.geometry).intersect(heading)));
        }
        if self.joints.len() <= self.q_items {
            return vec![heading];
        }
        disjoint(found)
    }

    /// Robot positions along the grid axis `axis` that all but q lines of the image allow, as disjoint intervals inside the box.
    fn places(&self, grid: &GridBox, axis: usize) -> Vec<Interval> {
        let lines: Vec<Interval> =
            self.joints.iter().filter_map(|joint| self.ahead(joint, grid.heading, axis)).collect();
        if lines.len() <= self.q_items {
            return vec![grid.position[axis]];
        }
        let mut found = Vec::new();
        for ahead in lines.iter().take(self.q_items + 1) {
            found.extend(self.periods(*ahead, grid.position[axis], axis));
        }
        disjoint(found)
    }

    /// Distance from the robot origin to the joint along `axis`, if the line belongs to that axis's family at every heading of the slice.
    fn ahead(&self, joint: &Joint, heading: Interval, axis: usize) -> Option<Interval> {
        let (first, last) = joint.families(heading, &self.geometry);
        (first == last && first.rem_euclid(2) as usize == axis).then(|| joint.ahead(first, heading, &self.geometry))
    }

    /// Positions of the robot origin along a grid axis, E·i + phase ± laying − ahead, for every joint i that gives one inside `place`.
    fn periods(&self, ahead: Interval, place: Interval, axis: usize) -> Vec<Interval> {
        let grid = &self.geometry.grid;
        let origin = (Interval::point(grid.phase_m[axis]) - ahead).inflate(grid.laying_m);
        if origin.is_empty() || place.is_empty() {
            return Vec::new();
        }
        let index = (place - origin) / grid.edge_m[axis];
        let (first, last) = (index.lo().ceil(), index.hi().floor());
        // Beyond 10¹⁵ a double cannot count single joints any more.
        if !(first.abs() < 1e15 && last.abs() < 1e15) || last - first > MOST_PERIODS {
            return vec![place];
        }
        (first as i64..=last as i64)
            .map(|i| (origin + Interval::point(grid.edge_m[axis]) * (i as f64)).intersect(place))
            .collect()
    }

    /// Contracts a box with one slice of heading; `None` when more than q lines of the image contradict the slice.
    fn slice(&self, grid: &GridBox) -> Option<GridBox> {
        let mut wrong = 0;
        let mut allowed: [Vec<Interval>; 2] = [Vec::new(), Vec::new()];
        for joint in &self.joints {
            let (first, last) = joint.families(grid.heading, &self.geometry);
            if first > last {
                wrong += 1;
                continue;
            }
            if first < last {
                // The slice of headings is too wide to tell which family of joints the line belongs to, so that the line says nothing yet.
                continue;
            }
            let axis = first.rem_euclid(2) as usize;
            let places = self.periods(joint.ahead(first, grid.heading, &self.geometry), grid.position[axis], axis);
            match places.into_iter().reduce(Interval::hull) {
                Some(hull) if !hull.is_empty() => allowed[axis].push(hull),
                _ => wrong += 1,
            }
        }
        let left = self.q_items.checked_sub(wrong)?;
        let position = [0, 1].map(|axis| all_but(left, &allowed[axis], grid.position[axis]));
        (!position[0].is_empty() && !position[1].is_empty()).then_some(GridBox { position, heading: grid.heading })
    }

    /// Contracts a world box slice by slice of its heading; empty when no slice is left.
    fn slices(&self, domain: &IntervalBox<3>, grid: &GridBox) -> IntervalBox<3> {
        if !is_cut(grid.heading) {
            return self.slice(grid).map_or(IntervalBox::EMPTY, |kept| self.to_world(&kept, domain));
        }
        let n_slices = (grid.heading.width() / SLICE_RAD).ceil().clamp(1.0, MOST_SLICES) as usize;
        let step = grid.heading.width() / n_slices as f64;
        let mut hull = IntervalBox::EMPTY;
        for slice in 0..n_slices {
            let lo = grid.heading.lo() + slice as f64 * step;
            let hi = if slice + 1 == n_slices { grid.heading.hi() } else { lo + step };
            let heading = Interval::new(lo, hi.max(lo)).inflate(1e-12).intersect(grid.heading);
            if let Some(kept) = self.slice(&GridBox { position: grid.position, heading }) {
                hull = hull.hull(&self.to_world(&kept, domain));
            }
        }
        hull
    }

    /// Whether all but q lines can be joints of this room when they are seen from poses of the box.
    fn joints_stay_in_room(&self, domain: &IntervalBox<3>) -> bool {
        self.joints.iter().filter(|joint| joint.leaves_room(domain, &self.geometry)).count() <= self.q_items
    }

    /// Position of a world box in the grid frame, which is turned by γ: the position is turned by −γ.
    fn to_grid(&self, domain: &IntervalBox<3>) -> [Interval; 2] {
        let angle = Interval::point(self.geometry.grid.rotation_rad);
        let (cos, sin) = (angle.cos(), angle.sin());
        [domain[0] * cos + domain[1] * sin, domain[1] * cos - domain[0] * sin]
    }

    /// Box of the grid frame in the world frame (turned by γ), restricted to `domain`.
    fn to_world(&self, grid: &GridBox, domain: &IntervalBox<3>) -> IntervalBox<3> {
        let angle = Interval::point(self.geometry.grid.rotation_rad);
        let (cos, sin) = (angle.cos(), angle.sin());
        let [x, y] = [grid.position[0] * cos - grid.position[1] * sin, grid.position[0] * sin + grid.position[1] * cos];
        IntervalBox::from([x.intersect(domain[0]), y.intersect(domain[1]), grid.heading.intersect(domain[2])])
    }
}

/// Width of the slices of heading. A line of 0.4 m, seen to 0.3 px, leaves an interval of headings open that is a few slices wide.
const SLICE_RAD: f64 = 0.001;
/// Greatest number of slices of one interval of headings. More are not worth their time; wider headings are narrowed by the next
/// contraction.
const MOST_SLICES: f64 = 16.0;
/// Greatest number of tiles that a position interval may span to be cut into branches.
const MOST_PERIODS: f64 = 200.0;
/// Greatest number of branches from one box. If there would be more, the box is too wide to be cut and its position is left as it is.
const MOST_BRANCHES: usize = 512;

/// Whether headings are cut into families and slices. They are not when the interval spans more turns than matter, or lies so far from zero
/// that doubles there are farther apart than slices. Such headings come from recovery, which does not know how often the robot has turned.
fn is_cut(heading: Interval) -> bool {
    heading.width() < WIDEST_RAD && heading.magnitude() < FARTHEST_RAD
}

/// Widest interval of headings that is cut, a little more than fifteen turns: what a robot may have turned since its heading was last known
/// is less.
const WIDEST_RAD: f64 = 100.0;
/// Greatest heading that is cut: doubles of this size are 10⁻⁷ apart.
const FARTHEST_RAD: f64 = 1e9;

impl Contractor<3> for TileJoints {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        *domain = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        if domain.is_empty() { Outcome::Empty("floor_tiles.joints") } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if domain.is_empty() {
            return Vec::new();
        }
        let position = self.to_grid(domain);
        let mut branches = Vec::new();
        for heading in self.headings(domain[2]) {
            let grid = GridBox { position, heading };
            let (across, along) = (self.places(&grid, 0), self.places(&grid, 1));
            if across.len() * along.len() > MOST_BRANCHES {
                branches.push(IntervalBox::from([domain[0], domain[1], heading]));
                continue;
            }
            for &x in &across {
                for &y in &along {
                    let kept = self.slices(domain, &GridBox { position: [x, y], heading });
                    if !kept.is_empty() && self.joints_stay_in_room(&kept) {
                        branches.push(kept);
                    }
                }
            }
        }
        branches
    }
}

/// Hull of the points of the interval `place` that all but `left` of the given intervals contain.
fn all_but(left: usize, intervals: &[Interval], place: Interval) -> Interval {
    if left >= intervals.len() {
        return place;
    }
    if left == 0 {
        return intervals.iter().fold(place, |kept, &interval| kept.intersect(interval));
    }
    let needed = intervals.len() - left;
    let supported = |point: f64| intervals.iter().filter(|interval| interval.contains(point)).count() >= needed;
    // The first and the last point that enough intervals contain are ends of intervals.
    let lo =
        intervals.iter().map(|interval| interval.lo()).filter(|&point| supported(point)).fold(f64::INFINITY, f64::min);
    let hi = intervals
        .iter()
        .map(|interval| interval.hi())
        .filter(|&point| supported(point))
        .fold(f64::NEG_INFINITY, f64::max);
    if lo > hi { Interval::EMPTY } else { Interval::new(lo, hi).intersect(place) }
}

/// Union of some intervals, as disjoint intervals in rising order.
fn disjoint(mut intervals: Vec<Interval>) -> Vec<Interval> {
    intervals.retain(|interval| !interval.is_empty());
    intervals.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
    let mut merged: Vec<Interval> = Vec::new();
    for interval in intervals {
        match merged.last_mut() {
            Some(last) if interval.lo() <= last.hi() => *last = last.hull(interval),
            _ => merged.push(interval),
        }
    }
    merged
}
