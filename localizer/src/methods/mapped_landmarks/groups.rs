//! The constraint of sightings of which some may be wrong.
//!
//! The sightings of an image are dealt into groups. If at most q sightings are wrong, at most q groups have a wrong one. Of a group, all sightings
//! together bound the pose by their rows. So the truth is
//!
//! - in the boxes of all but q small groups: in the q-relaxed intersection of their boxes;
//! - in the box of all sightings but those of some q groups: in the union of these boxes over all choices of q groups.
//!
//! The first takes little time. The second is narrower, because each box follows from most of the sightings, and takes a program for each choice.

use std::sync::Arc;

use interval::{
    IntervalBox,
    contractor::{Contractor, Outcome, q_intersection, settle},
};

use crate::{
    PoseBox,
    graph::{PoseByRows, Stray},
};

use super::{
    ray::Optics,
    relate::{Points, Sight},
};

/// Numbers of sightings of a small group, the preferred one first: three bound the pose much better than two, but make fewer groups.
const SIZES: [usize; 2] = [3, 2];
/// Small groups, for each sighting that may be wrong, with which a size is preferred.
const GROUPS_FOR_EACH: usize = 3;
/// Groups beyond those that may have a wrong sighting, of which all but q are used together: for one wrong sighting five programs, for two fifteen.
const MORE_GROUPS: usize = 4;
/// Greatest number of wrong sightings with which choices of groups are left out.
const MOST_LEFT_OUT: usize = 2;
/// Greatest number of times that a box is contracted: rows that are made anew about a narrower box lose less.
const PASSES: usize = 3;
/// The box is contracted again where a coordinate has become narrower than this share of its width.
const WORTHWHILE: f64 = 0.8;

/// Contractor of the pose by sightings of which a number may be wrong.
pub(super) struct ByGroups {
    small: Vec<PoseByRows>,
    /// For each choice of groups that may have the wrong sightings, all others.
    without: Vec<PoseByRows>,
    most_wrong: usize,
}

impl ByGroups {
    /// The contractor of some sightings, of which at most `most_wrong` are wrong.
    pub(super) fn new(optics: &Arc<Optics>, stray: Stray, sights: &[Sight], most_wrong: usize) -> ByGroups {
        let n_of = |size: usize| sights.len() / size;
        let n_small = if most_wrong == 0 {
            1
        } else {
            SIZES.into_iter().map(n_of).find(|n| *n >= GROUPS_FOR_EACH * most_wrong).unwrap_or(n_of(SIZES[1]))
        };
        // Neighbours in the image go to different groups, so that each group looks in many directions.
        let mut by_column = sights.to_vec();
        by_column.sort_by(|a, b| a.at_px[0].total_cmp(&b.at_px[0]).then(a.landmark.cmp(&b.landmark)));
        let rows = |is_used: &dyn Fn(usize) -> bool| {
            let used = by_column.iter().enumerate().filter(|(at, _)| is_used(*at));
            let seen: Vec<Sight> = used.map(|(_, sight)| *sight).collect();
            PoseByRows { relations: Arc::new(Points { optics: Arc::clone(optics), seen }), stray }
        };
        let n_large = most_wrong + MORE_GROUPS;
        let has_choices = (1..=MOST_LEFT_OUT).contains(&most_wrong) && sights.len() >= n_large;
        let choices = if has_choices { choices(n_large, most_wrong) } else { Vec::new() };
        ByGroups {
            small: (0..n_small).map(|group| rows(&|at| at % n_small == group)).collect(),
            without: choices.iter().map(|choice| rows(&|at| !choice.contains(&(at % n_large)))).collect(),
            most_wrong,
        }
    }

    /// Whether the sightings say anything at all.
    pub(super) fn says_something(&self) -> bool {
        self.small.len() > self.most_wrong || !self.without.is_empty()
    }

    /// What the small groups alone leave of a box.
    pub(super) fn roughly(&self, domain: &PoseBox) -> PoseBox {
        let boxes: Vec<PoseBox> = self.small.iter().map(|group| group.pass(domain)).collect();
        domain.intersect(&q_intersection(&boxes, self.most_wrong))
    }

    fn pass(&self, domain: &PoseBox) -> PoseBox {
        let left = self.roughly(domain);
        if left.is_empty() || self.without.is_empty() {
            return left;
        }
        self.without.iter().fold(PoseBox::EMPTY, |hull, most| hull.hull(&most.pass(&left)))
    }
}

impl Contractor<3> for ByGroups {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let mut left = *domain;
        for _ in 0..PASSES {
            let before = left;
            left = self.pass(&left);
            if left.is_empty() || (0..3).all(|axis| left.width(axis) > WORTHWHILE * before.width(axis)) {
                break;
            }
        }
        settle(domain, left, "more sightings of an image than may be wrong exclude every pose")
    }
}

/// All choices of `most` of the numbers below `n`.
fn choices(n: usize, most: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..most {
        let longer = |choice: &Vec<usize>| {
            let first = choice.last().map_or(0, |last| last + 1);
            (first..n).map(|next| [&choice[..], &[next]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{
        PoseBox,
        graph::trial::{Draw, rounds},
        map::{Anchor, SpacePoint},
        methods::mapped_landmarks::trial::{True, around, boxed, homogeneous, is_within, look, walls},
    };

    /// Sights of a robot in a room, with boxes of their landmarks that hold them, and a box of its pose; of the sights, `n_wrong` show something
    /// else.
    fn trial(draw: &mut Draw, n_wrong: usize) -> (Arc<Optics>, Vec<Sight>, PoseBox, [f64; 3]) {
        let truth = True::new(draw, 0.2);
        let landmarks = walls(draw, 120);
        let turn_rad = draw.between(-3.0, 3.0);
        let at = truth.turned(draw, [0.5, -0.3], turn_rad);
        let mut sights: Vec<Sight> = look(&truth, draw, &at, &landmarks)
            .into_iter()
            .map(|seen| {
                let landmark = landmarks[seen.landmark.0 as usize];
                let axis = if landmark.x.abs() > landmark.y.abs() { 0 } else { 1 };
                let anchor = Anchor { from_m: [0.1, 0.2, 0.4], axis, is_positive: landmark[axis] > 0.0 };
                let value = homogeneous(&anchor, landmark).map(|one| around(draw, one, 0.002));
                let error_px = [truth.camera.error_px; 2];
                Sight { landmark: seen.landmark, point: SpacePoint { anchor, value }, at_px: seen.at_px, error_px }
            })
            .collect();
        sights.truncate(24);
        for sight in sights.iter_mut().take(n_wrong) {
            sight.at_px = sight.at_px.map(|at| at + draw.between(-40.0, 40.0));
        }
        let pose = boxed(draw, at.pose, [0.1, 0.1, 0.05]);
        (Arc::new(Optics::new(truth.camera, truth.body)), sights, pose, at.pose)
    }

    #[test]
    fn wrong_sightings_within_the_quota_leave_the_truth_in_the_box() {
        let mut draw = Draw::new(20_261_201);
        let mut narrower = 0;
        let n_rounds = rounds(30);
        for round in 0..n_rounds {
            let n_wrong = round % 4;
            let (optics, sights, pose, truth) = trial(&mut draw, n_wrong);
            assert!(sights.len() > 12, "{}", sights.len());
            let mut left = pose;
            ByGroups::new(&optics, Stray::default(), &sights, n_wrong).contract(&mut left);
            assert!(is_within(truth, &left), "round {round}: {truth:?} {left:?}");
            narrower += usize::from((0..3).all(|axis| left.width(axis) < 0.5 * pose.width(axis)));
        }
        assert!(3 * narrower >= 2 * n_rounds, "{narrower}");
    }

    #[test]
    fn the_choices_of_two_of_four_are_six() {
        assert_eq!(choices(4, 2), [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert_eq!(choices(5, 1).len(), 5);
    }

    #[test]
    fn no_more_groups_than_may_be_wrong_say_nothing() {
        let mut draw = Draw::new(20_261_202);
        let (optics, sights, pose, _) = trial(&mut draw, 0);
        let few = ByGroups::new(&optics, Stray::default(), &sights[..4], 2);
        assert!(!few.says_something());
        let mut left = pose;
        assert_eq!(few.contract(&mut left), Outcome::Feasible);
        assert_eq!(left, pose);
        assert!(ByGroups::new(&optics, Stray::default(), &sights, 2).says_something());
    }
}
