//! Planar poses, boxes of poses and unions of boxes. Headings are real numbers and are never wrapped to one turn.

use std::{cmp::Ordering, f64::consts::TAU};

use interval::{Interval, IntervalBox, contractor::Contractor};

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

/// Union of pose boxes (its branches): the robot's pose is in at least one of them. A union without branches means that an assumption failed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseUnion {
    /// Non-empty boxes of the union, in a fixed order.
    pub branches: Vec<PoseBox>,
}

impl Pose {
    /// The pose as an array `[x_m, y_m, heading_rad]`.
    pub fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.heading_rad]
    }
}

impl PoseUnion {
    /// A union of one box, or of none if the box is empty.
    pub fn single(pose: PoseBox) -> Self {
        PoseUnion { branches: if pose.is_empty() { Vec::new() } else { vec![pose] } }
    }

    /// Whether the union has no branch, so that no pose is left.
    pub fn is_empty(&self) -> bool {
        self.branches.is_empty()
    }

    /// Smallest box around all branches; the empty box if there is no branch.
    pub fn hull(&self) -> PoseBox {
        self.branches.iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch))
    }

    /// Greatest number of branches (boxes) of a pose union in which neighbouring branches were replaced by their hulls to make them fewer. More are
    /// of no practical use, and computing with each pair of them takes longer than the time between readings. A floor of 4 m × 3 m with tiles of 33
    /// cm gives some 430 branches while all tiles and all quadrants of heading are possible.
    pub const MOST_BRANCHES: usize = 512;

    /// The union without the branches that lie inside another branch. If there are more than [`PoseUnion::MOST_BRANCHES`] branches, neighbouring ones
    /// are first replaced by their hull, which a later constraint may cut into separate branches again.
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

    /// The union's branches; if there are more than [`PoseUnion::MOST_BRANCHES`], neighbouring branches are replaced by their hulls, so that
    /// at most that many remain. Neighbours are those next to each other when sorted by heading, then y, then x.
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

    /// The union with each of its boxes contracted; where the contractor splits a box into several, all of them are kept.
    pub(crate) fn contracted(&self, contractor: &dyn Contractor<3>) -> Self {
        PoseUnion { branches: self.branches.iter().flat_map(|branch| contractor.branches(branch)).collect() }
            .without_repeats()
    }

    /// Encloses the poses that are in both unions. The result is exact, every branch of one union intersected with every branch of the other,
    /// unless there are more than [`PoseUnion::MOST_PAIRS`] pairs. Then each branch of this union is cut to the hull of its intersections with the
    /// other union, so that two overlapping unions of hundreds of branches do not give hundreds of thousands of branches.
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

    /// Greatest number of pairs of branches, one from each of two unions, for which [`PoseUnion::common`] keeps the intersection of every pair; 4096
    /// pairs are those of two unions of 64 branches. To find intersections that lie inside others, they are compared in pairs, at most 16 million
    /// times.
    pub const MOST_PAIRS: usize = 4096;

    /// Whether at least one box of the union contains the given pose with its heading turned by any number of whole turns, for a pose whose heading is
    /// wrapped or counted from another time. Whole turns are rounded outwards, so that a pose on the face of a box counts as contained.
    pub fn contains_modulo_turn(&self, pose: Pose) -> bool {
        let whole_turn = Interval::PI * 2.0;
        self.branches.iter().any(|branch| {
            let at = Interval::point(pose.heading_rad);
            // Whole numbers of turns that may bring the heading into the branch: with one more at either end, rounding misses none.
            let (fewest, most) = ((branch[2].lo() - pose.heading_rad) / TAU, (branch[2].hi() - pose.heading_rad) / TAU);
            let in_place = branch[0].contains(pose.x_m) && branch[1].contains(pose.y_m);
            in_place
                && (most - fewest >= 1.0 || {
                    let n_turns = [fewest.floor(), fewest.ceil(), most.ceil()];
                    n_turns.iter().any(|n| !(at + whole_turn * *n).intersect(branch[2]).is_empty())
                })
        })
    }

    /// Whether at least one box of the union contains the given pose.
    pub fn contains(&self, pose: Pose) -> bool {
        self.branches.iter().any(|branch| branch.contains(&pose.to_array()))
    }
}

/// The intervals x, y and heading of a pose box, as a tuple.
pub fn components(pose: &PoseBox) -> (Interval, Interval, Interval) {
    (pose[0], pose[1], pose[2])
}

#[cfg(test)]
mod tests {
    use interval::Interval;

    use super::*;

    /// A union of overlapping boxes, in x and y squares with 2 m sides, each displaced from the one before by 1 cm in x and by −1 cm in y, so that
    /// each overlaps most others.
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
    fn a_heading_may_be_told_modulo_a_turn() {
        let box_of = |low_rad, high_rad| {
            PoseUnion::single(PoseBox::from([
                Interval::new(0.0, 1.0),
                Interval::new(0.0, 1.0),
                Interval::new(low_rad, high_rad),
            ]))
        };
        let at = |heading_rad| Pose { x_m: 0.5, y_m: 0.5, heading_rad };
        // After three turns to the left and a little, the wrapped heading is 0.1 rad.
        let turned = box_of(18.9, 19.0);
        assert!(
            turned.contains_modulo_turn(at(0.1))
                && turned.contains_modulo_turn(at(0.1 - TAU))
                && turned.contains(at(18.95))
        );
        assert!(!turned.contains_modulo_turn(at(0.0)) && !turned.contains_modulo_turn(at(0.2)));
        assert!(!turned.contains_modulo_turn(Pose { x_m: 1.5, ..at(0.1) }));
        // Across the seam of wrapped headings, and where every heading is possible.
        let seam = box_of(3.1, 3.2);
        assert!(
            seam.contains_modulo_turn(at(-3.1))
                && seam.contains_modulo_turn(at(3.15))
                && !seam.contains_modulo_turn(at(-3.0))
        );
        assert!(box_of(-10.0, 10.0).contains_modulo_turn(at(1000.0)));
        // Headings on the face of a box, however many turns away, are held.
        for turns in -1000..1000 {
            let away = box_of(TAU * f64::from(turns), TAU * f64::from(turns) + 0.5);
            assert!(
                away.contains_modulo_turn(at(0.0))
                    && away.contains_modulo_turn(at(0.25))
                    && !away.contains_modulo_turn(at(-0.01))
            );
        }
        assert!(!PoseUnion::default().contains_modulo_turn(at(0.0)));
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
