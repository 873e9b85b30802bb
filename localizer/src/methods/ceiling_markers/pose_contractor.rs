//! Contractor on the robot's pose, made from all markers of one image.

use interval::contractor::{Contractor, Outcome};
use interval::{Interval, IntervalBox};

use super::{group::Group, ray::SeenDot};

/// Contractor on the pose that assumes that all but at most `q_items` of the seen markers are what the map says.
///
/// It is sound: some choice of all but q markers is right, so the pose is in one of the boxes that the choices leave, and each of them is
/// kept. For each choice a box is contracted by every marker alone (whose dots share height and placement), by all markers together (whose
/// distances tell the heading), and then slice by slice of heading, so that the dependence between heading and position is kept.
pub(super) struct Markers {
    choices: Vec<Vec<Group>>,
    /// Error of the apparent heading, that is the yaw error of the camera's mount.
    yaw_error: Interval,
    /// Greatest difference between the pose at the image's stamp and the pose at its exposure, in metres and in radians.
    stamp: [f64; 2],
}

/// Number of slices into which an interval of headings is cut. Within one slice the dependence between heading and position is lost.
const SLICES: usize = 24;

impl Markers {
    /// Makes the contractor of an image's markers. `dots` holds the dots of each marker without the placement error, which is
    /// `placement_m`; `None` when leaving out `q_items` markers leaves none.
    pub(super) fn new(
        dots: &[Vec<SeenDot>],
        placement_m: f64,
        q_items: usize,
        yaw_error: Interval,
        stamp: [f64; 2],
    ) -> Option<Markers> {
        let n_right = dots.len().checked_sub(q_items).filter(|n_right| *n_right > 0)?;
        let choices = subsets(dots.len(), n_right).into_iter().map(|members| {
            let mut groups: Vec<Group> =
                members.iter().map(|marker| Group::new(&dots[*marker], true, placement_m)).collect();
            if members.len() > 1 {
                let placed =
                    |dot: &SeenDot| SeenDot { in_world_m: dot.in_world_m.map(|x| x.inflate(placement_m)), ..*dot };
                let all: Vec<SeenDot> = members.iter().flat_map(|marker| dots[*marker].iter().map(placed)).collect();
                groups.push(Group::new(&all, false, placement_m));
            }
            groups
        });
        Some(Markers { choices: choices.collect(), yaw_error, stamp })
    }

    /// Boxes of (x, y, apparent heading) at the exposure that remain of a given box when one choice of markers is taken to be right.
    fn choice(groups: &[Group], pose: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let mut branches = vec![*pose];
        // The group of the dots of all markers has the longest baselines; it is the last of the groups and is applied first.
        for group in groups.iter().rev() {
            branches = branches.iter().flat_map(|branch| group.branches(branch)).collect();
        }
        // In a second pass every group of dots uses what each single marker told about the heading.
        for group in groups.iter().rev() {
            branches = branches.iter().flat_map(|branch| group.branches(branch)).collect();
        }
        branches.iter().map(|branch| sliced(groups, branch)).filter(|branch| !branch.is_empty()).collect()
    }
}

/// Hull of the boxes that remain when a box is contracted slice by slice of its heading.
fn sliced(groups: &[Group], pose: &IntervalBox<3>) -> IntervalBox<3> {
    if !pose[2].width().is_finite() {
        // A slice of an interval of headings without an end would be no narrower than the interval, so there is nothing to cut.
        return groups.iter().fold(*pose, |part, group| if part.is_empty() { part } else { group.pass(&part) });
    }
    let step = pose[2].width() / SLICES as f64;
    let mut hull = IntervalBox::EMPTY;
    for slice in 0..SLICES {
        let lo = pose[2].lo() + slice as f64 * step;
        let hi = if slice + 1 == SLICES { pose[2].hi() } else { lo + step };
        // Slices overlap by a hair, so that rounding lets no heading fall between two of them.
        let heading = Interval::new(lo, hi.max(lo)).inflate(1e-12).intersect(pose[2]);
        let mut part = IntervalBox::new([pose[0], pose[1], heading]);
        for group in groups {
            part = group.pass(&part);
            if part.is_empty() {
                break;
            }
        }
        hull = hull.hull(&part);
    }
    hull
}

impl Contractor<3> for Markers {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        *domain = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        if domain.is_empty() { Outcome::Empty("ceiling_markers.dots") } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if domain.is_empty() {
            return Vec::new();
        }
        let [shift_m, turn_rad] = self.stamp;
        let at_exposure = IntervalBox::new([
            domain[0].inflate(shift_m),
            domain[1].inflate(shift_m),
            domain[2].inflate(turn_rad) + self.yaw_error,
        ]);
        let mut branches: Vec<IntervalBox<3>> = Vec::new();
        for found in self.choices.iter().flat_map(|groups| Markers::choice(groups, &at_exposure)) {
            let at_stamp = IntervalBox::new([
                found[0].inflate(shift_m),
                found[1].inflate(shift_m),
                (found[2] - self.yaw_error).inflate(turn_rad),
            ]);
            let kept = at_stamp.intersect(domain);
            if kept.is_empty() || branches.iter().any(|other| kept.is_subset_of(other)) {
                continue;
            }
            branches.retain(|other| !other.is_subset_of(&kept));
            branches.push(kept);
        }
        branches
    }
}

/// All subsets with `size` elements of the numbers below `n`, each in rising order.
fn subsets(n: usize, size: usize) -> Vec<Vec<usize>> {
    let all = (0u32..1 << n).filter(|bits| bits.count_ones() as usize == size);
    all.map(|bits| (0..n).filter(|number| bits & (1 << number) != 0).collect()).collect()
}
