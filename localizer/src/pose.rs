//! Planar poses, boxes of poses and unions of boxes. Heading lives on the real line and is never wrapped.

use std::cmp::Ordering;

use interval::{Interval, IntervalBox};

/// A pose in the plane: `world_from_robot`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// World x of the robot origin.
    pub x_m: f64,
    /// World y of the robot origin.
    pub y_m: f64,
    /// Angle from world x to robot x, counter-clockwise, unwrapped.
    pub heading_rad: f64,
}

/// A box of poses, in the order x, y, heading (metres, metres, radians).
pub type PoseBox = IntervalBox<3>;

/// Disjunction of pose boxes: the pose is in at least one of them. No branch means that an assumption failed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseUnion {
    /// Non-empty boxes, in a fixed order.
    pub branches: Vec<PoseBox>,
}

impl Pose {
    /// `[x_m, y_m, heading_rad]`.
    pub fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.heading_rad]
    }
}

impl PoseUnion {
    /// A union of one box, or of none if the box is empty.
    pub fn single(pose: PoseBox) -> Self {
        PoseUnion { branches: if pose.is_empty() { Vec::new() } else { vec![pose] } }
    }

    /// Whether no pose is left.
    pub fn is_empty(&self) -> bool {
        self.branches.is_empty()
    }

    /// Smallest box around all branches; the empty box if there is none.
    pub fn hull(&self) -> PoseBox {
        self.branches.iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch))
    }

    /// Branches that a union has at most once it was thinned: more are no help to anybody, and what is done with each pair of them takes longer
    /// than readings take to come. A floor of 4 m × 3 m of tiles of 33 cm, all places and quadrants open, has some 430.
    pub const MOST_BRANCHES: usize = 512;

    /// The union without branches that lie inside another one. Where there are more than [`PoseUnion::MOST_BRANCHES`], neighbours become their
    /// hull first; the next constraint may part them again.
    pub fn without_repeats(self) -> Self {
        let branches = self.thinned();
        let mut kept: Vec<PoseBox> = Vec::with_capacity(branches.len());
        for branch in branches {
            if kept.iter().any(|other| branch.is_subset_of(other)) {
                continue;
            }
            kept.retain(|other| !other.is_subset_of(&branch));
            kept.push(branch);
        }
        PoseUnion { branches: kept }
    }

    /// The branches, or at most [`PoseUnion::MOST_BRANCHES`] hulls of them: of those next to each other by heading, then y, then x.
    fn thinned(mut self) -> Vec<PoseBox> {
        let together = self.branches.len().div_ceil(PoseUnion::MOST_BRANCHES);
        if together <= 1 {
            return self.branches;
        }
        self.branches.sort_by(|one, other| {
            let [one, other] = [one, other].map(|branch| [2, 1, 0].map(|axis: usize| branch[axis].lo()));
            one.iter()
                .zip(&other)
                .map(|(one, other)| one.total_cmp(other))
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        });
        let hull = |some: &[PoseBox]| some.iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        self.branches.chunks(together).map(hull).collect()
    }

    /// Encloses the poses that are in both unions: exactly, every branch of one with every branch of the other, unless there are more than
    /// [`PoseUnion::MOST_PAIRS`] of them. Then each branch of this union is cut to the hull of what the other has of it, so that two unions of
    /// hundreds of branches that lie over each other do not come to hundreds of thousands.
    pub fn common(&self, other: &PoseUnion) -> Self {
        let shared = |one: &PoseBox| {
            let parts = other.branches.iter().map(|other| one.intersect(other)).filter(|part| !part.is_empty());
            parts.collect::<Vec<PoseBox>>()
        };
        let is_few = self.branches.len().saturating_mul(other.branches.len()) <= PoseUnion::MOST_PAIRS;
        let branches = self.branches.iter().flat_map(|one| match is_few {
            true => shared(one),
            false => PoseUnion::single(PoseUnion { branches: shared(one) }.hull()).branches,
        });
        PoseUnion { branches: branches.collect() }.without_repeats()
    }

    /// Pairs of branches up to which [`PoseUnion::common`] keeps all their parts: 64 branches with 64. What repeats itself among them is sought in
    /// pairs of parts, 16 million at most.
    pub const MOST_PAIRS: usize = 4096;

    /// Whether some branch contains the pose.
    pub fn contains(&self, pose: Pose) -> bool {
        self.branches.iter().any(|branch| branch.contains(&pose.to_array()))
    }
}

/// `[x, y, heading]` of a box, by name.
pub fn components(pose: &PoseBox) -> (Interval, Interval, Interval) {
    (pose[0], pose[1], pose[2])
}

#[cfg(test)]
mod tests {
    use interval::Interval;

    use super::*;

    /// Squares of 2 m whose corners lie 1 cm apart along a diagonal, so that each lies over most others.
    fn staggered(count: usize, first_m: f64) -> PoseUnion {
        let square = |index: usize| {
            let low_m = first_m + 0.01 * index as f64;
            PoseBox::from([low_m, -low_m, 0.0].map(|low| Interval::new(low, low + 2.0)))
        };
        PoseUnion { branches: (0..count).map(square).collect() }
    }

    #[test]
    fn what_two_unions_have_in_common_has_no_more_branches_than_the_first_when_there_are_hundreds() {
        let (one, other) = (staggered(150, 0.0), staggered(150, 0.005));
        let common = one.common(&other);
        assert!(common.branches.len() <= 150, "{}", common.branches.len());
        for step in 0..4000 {
            let at = f64::from(step) * 1e-3;
            for off_m in [0.0, 0.3, 1.0, 1.9] {
                let pose = Pose { x_m: at + off_m, y_m: 1.0 - at, heading_rad: at };
                assert!(!one.contains(pose) || !other.contains(pose) || common.contains(pose), "{pose:?}");
            }
        }
    }

    #[test]
    fn a_union_of_thousands_is_thinned_and_loses_no_pose() {
        let scattered = (0..5000).map(|index| {
            let at_m = 0.1 * f64::from(index);
            PoseBox::from([at_m, -at_m, 0.0].map(|low| Interval::new(low, low + 0.01)))
        });
        let all = PoseUnion { branches: scattered.collect() };
        let thinned = all.clone().without_repeats();
        assert!(thinned.branches.len() <= PoseUnion::MOST_BRANCHES, "{}", thinned.branches.len());
        assert!(all.branches.iter().all(|branch| thinned.branches.iter().any(|other| branch.is_subset_of(other))));
    }

    #[test]
    fn what_two_small_unions_have_in_common_is_exact() {
        let (one, other) = (staggered(3, 0.0), staggered(3, 1.5));
        let common = one.common(&other);
        for branch in &common.branches {
            let is_of_both = one.branches.iter().any(|one| branch.is_subset_of(one))
                && other.branches.iter().any(|other| branch.is_subset_of(other));
            assert!(is_of_both, "{branch:?}");
        }
    }
}
