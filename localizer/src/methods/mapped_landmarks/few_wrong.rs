//! The constraint of sightings of which a few may be wrong, as a contractor and as rows of the graph of key frames.

use std::sync::{Arc, OnceLock};

use interval::{
    IntervalBox,
    contractor::{Contractor, Outcome, settle},
};

use crate::{
    PoseBox,
    graph::{DespiteWrong, Relations, Stray},
};

use super::{
    anywhere::{anywhere, is_vague, may_be_seen},
    ray::Optics,
    relate::{Points, Sight},
};

/// Greatest number of times that a box is contracted: rows that are made anew about a narrower box lose less, and a wrong sighting relaxes them less.
const PASSES: usize = 4;
/// Least number of right sightings with which poses are searched in a wide box.
const FEWEST_ANYWHERE: usize = 5;
/// The box is contracted again where a coordinate has become narrower than this share of its width.
const WORTHWHILE: f64 = 0.8;

/// Why a box of poses is empty.
const EXCLUDED: &str = "more sightings of an image than may be wrong exclude every pose";

/// Sightings of an image, of which a number may be wrong.
#[derive(Clone)]
pub(super) struct FewWrong {
    sights: Vec<Points>,
    most_wrong: usize,
    stray: Stray,
    /// A wide box of poses, with what the sightings leave of it: it is needed again each time that readings are gone through anew.
    found: OnceLock<(PoseBox, Vec<PoseBox>)>,
}

impl FewWrong {
    /// Some sightings, of which at most `most_wrong` are wrong.
    pub(super) fn new(optics: &Arc<Optics>, stray: Stray, sights: &[Sight], most_wrong: usize) -> FewWrong {
        let alone = |sight: &Sight| Points { optics: Arc::clone(optics), seen: vec![*sight] };
        // Neighbours in the image are left out in different programs, so that each looks in many directions.
        let mut by_column = sights.to_vec();
        by_column.sort_by(|a, b| a.at_px[0].total_cmp(&b.at_px[0]).then(a.landmark.cmp(&b.landmark)));
        FewWrong { sights: by_column.iter().map(alone).collect(), most_wrong, stray, found: OnceLock::new() }
    }

    /// Boxes that hold all poses of a wide box from which the picture can have been taken.
    fn anywhere(&self, domain: &PoseBox) -> Vec<PoseBox> {
        let contract = |part: &mut PoseBox| {
            self.contract(part);
        };
        anywhere(domain, |part| self.may_show(part), contract)
    }

    /// Whether no more sightings than may be wrong exclude all poses of a box.
    fn may_show(&self, part: &PoseBox) -> bool {
        let shown = self.stray.around(part);
        let seen = self.sights.iter().flat_map(|one| one.seen.iter().map(|sight| (&*one.optics, sight)));
        seen.filter(|(optics, sight)| !may_be_seen(optics, sight, &shown)).take(self.most_wrong + 1).count()
            <= self.most_wrong
    }

    /// Whether so many sightings agree that they tell where the robot is, of all places: chance does not make the greater part of them agree.
    pub(super) fn tells_anywhere(&self) -> bool {
        self.sights.len() >= self.most_wrong + FEWEST_ANYWHERE
    }

    /// Whether two sightings are right at least: one alone gives two equations for three coordinates of the pose.
    pub(super) fn says_something(&self) -> bool {
        self.sights.len() >= self.most_wrong + 2
    }

    /// The picture of the teaching drive that the sightings are compared with.
    pub(super) fn view(&self) -> Option<usize> {
        let mut views = self.sights.iter().flat_map(|one| &one.seen).filter_map(|sight| sight.view);
        views.next().map(|view| view.sight.picture)
    }

    /// The program of the sightings for a picture from a pose within a box; `None` where they exclude every such pose.
    pub(super) fn program(&self, shown: &PoseBox) -> Option<DespiteWrong> {
        let items: Vec<&dyn Relations> = self.sights.iter().map(|one| one as &dyn Relations).collect();
        DespiteWrong::new(shown, &items, self.most_wrong)
    }

    /// What the sightings' rows, made once about the middle of a box of poses, leave of the box.
    pub(super) fn pass(&self, domain: &PoseBox) -> PoseBox {
        let shown = self.stray.around(domain);
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let Some(bounds) = self.program(&shown).and_then(|program| program.bounds(&axes)) else {
            return PoseBox::EMPTY;
        };
        let left = self.stray.around(&PoseBox::from([bounds[0], bounds[1], bounds[2]])).intersect(domain);
        if left.is_empty() { PoseBox::EMPTY } else { left }
    }
}

impl Contractor<3> for FewWrong {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        if !self.says_something() {
            return Outcome::Feasible;
        }
        if is_vague(domain) {
            let hull = self.branches(domain).iter().fold(PoseBox::EMPTY, |hull, branch| hull.hull(branch));
            return settle(domain, hull, EXCLUDED);
        }
        let mut left = *domain;
        for _ in 0..PASSES {
            let before = left;
            left = self.pass(&left);
            if left.is_empty() || (0..3).all(|axis| left.width(axis) > WORTHWHILE * before.width(axis)) {
                break;
            }
        }
        settle(domain, left, EXCLUDED)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if !is_vague(domain) || !self.tells_anywhere() {
            let mut left = *domain;
            let is_left = is_vague(domain) || self.contract(&mut left) == Outcome::Feasible;
            return if is_left { vec![left] } else { Vec::new() };
        }
        let (searched, found) = self.found.get_or_init(|| (*domain, self.anywhere(domain)));
        if !domain.is_subset_of(searched) {
            return self.anywhere(domain);
        }
        found.iter().map(|one| one.intersect(domain)).filter(|one| !one.is_empty()).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) mod tests {
    use std::f64::consts::PI;

    use interval::Interval;

    use super::*;
    use crate::{
        graph::trial::{Draw, rounds},
        map::{Anchor, SpacePoint},
        methods::mapped_landmarks::trial::{True, around, boxed, homogeneous, is_within, look, walls},
    };

    /// Sights of a robot in a room, with boxes of their landmarks that hold them, and a box of its pose; of the sights, `n_wrong` show something
    /// else.
    pub(in super::super) fn trial(draw: &mut Draw, n_wrong: usize) -> (Arc<Optics>, Vec<Sight>, PoseBox, [f64; 3]) {
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
                Sight {
                    landmark: seen.landmark,
                    point: SpacePoint { anchor, value },
                    at_px: seen.at_px,
                    error_px,
                    view: None,
                }
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
            FewWrong::new(&optics, Stray::default(), &sights, n_wrong).contract(&mut left);
            assert!(is_within(truth, &left), "round {round}: {truth:?} {left:?}");
            narrower += usize::from((0..3).all(|axis| left.width(axis) < 0.5 * pose.width(axis)));
        }
        assert!(3 * narrower >= 2 * n_rounds, "{narrower}");
    }

    #[test]
    fn a_picture_tells_where_in_a_hall_and_facing_where_it_was_taken() {
        let mut draw = Draw::new(20_261_206);
        let hall = PoseBox::from([Interval::new(-5.0, 5.0), Interval::new(-5.0, 5.0), Interval::new(-PI, PI)]);
        for round in 0..4 {
            let n_wrong = round % 2;
            let (optics, sights, _, truth) = trial(&mut draw, n_wrong);
            let sights = FewWrong::new(&optics, Stray::default(), &sights, n_wrong);
            let found = sights.branches(&hall);
            assert!(found.iter().any(|one| is_within(truth, one)), "round {round}: {truth:?} {found:?}");
            let area_m2: f64 = found.iter().map(|one| one.width(0) * one.width(1)).sum();
            assert!(found.len() <= 3 && area_m2 < 0.5, "round {round}: {found:?}");
            // A part of the hall without the truth is excluded, where no other place looks the same.
            let beyond = PoseBox::from([hall[0], hall[1], Interval::centred(truth[2] + PI, 1.5)]);
            assert!(FewWrong::new(&optics, Stray::default(), &[], 0).branches(&beyond) == [beyond]);
            assert!(sights.anywhere(&beyond).is_empty(), "round {round}");
        }
    }

    #[test]
    fn hardly_more_sightings_than_may_be_wrong_say_nothing() {
        let mut draw = Draw::new(20_261_202);
        let (optics, sights, pose, _) = trial(&mut draw, 0);
        let few = FewWrong::new(&optics, Stray::default(), &sights[..3], 2);
        assert!(!few.says_something());
        let mut left = pose;
        assert_eq!(few.contract(&mut left), Outcome::Feasible);
        assert_eq!(left, pose);
        assert!(FewWrong::new(&optics, Stray::default(), &sights, 2).says_something());
    }
}
