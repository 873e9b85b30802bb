//! The constraint of sightings of which a few may be wrong, as a contractor and as rows of the graph of key frames.
//!
//! Single sightings are wrong where something else looks like a landmark. All sightings of a thing are wrong together where it has moved since it was
//! mapped, and then they agree with each other on a pose that is wrong. Where that is declared to be possible, the picture is solved once without each
//! thing, and the poses of all solutions stay.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{Arc, OnceLock},
};

use interval::{
    Interval, IntervalBox,
    contractor::{Contractor, Outcome, settle},
};

use crate::{
    PoseBox,
    graph::{DespiteWrong, Relations, Stray, Variable, choices},
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

/// The functions x, y and heading of a pose.
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Why a box of poses is empty.
const EXCLUDED: &str = "more sightings of an image than may be wrong exclude every pose";

/// How many of some sightings may be wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MostWrong {
    /// Number of single sightings.
    pub(super) items: usize,
    /// Number of things of which all sightings may be wrong in addition, since they may have moved.
    pub(super) things: usize,
}

impl From<usize> for MostWrong {
    /// So many single sightings and no thing.
    fn from(items: usize) -> MostWrong {
        MostWrong { items, things: 0 }
    }
}

/// Programs of which the truth satisfies one at least.
pub(super) struct Alternatives(Vec<DespiteWrong>);

impl Alternatives {
    /// Bounds of linear functions of the pose; `None` where no pose satisfies any of the programs.
    fn bounds(&self, functions: &[[f64; 3]]) -> Option<Vec<Interval>> {
        hull(self.0.iter().filter_map(|program| program.bounds(functions)))
    }

    /// Bounds of linear functions of the pose and of other quantities of the sightings; `None` where nothing satisfies any of the programs.
    pub(super) fn bounds_of_all(&self, functions: &[Vec<(Variable, f64)>]) -> Option<Vec<Interval>> {
        hull(self.0.iter().filter_map(|program| program.bounds_of_all(functions)))
    }

    /// Rows of the pose alone: for each the coefficients of x, y and heading and the half width of its sides.
    pub(super) fn on_pose(&self) -> Vec<([f64; 3], f64)> {
        self.0.iter().flat_map(|program| program.on_pose.iter().copied()).collect()
    }
}

/// For each place the hull of the bounds at it; `None` of none.
pub(super) fn hull(bounds: impl Iterator<Item = Vec<Interval>>) -> Option<Vec<Interval>> {
    bounds.reduce(|hull, bounds| hull.into_iter().zip(bounds).map(|(a, b)| a.hull(b)).collect())
}

/// Sightings of an image, of which a number may be wrong.
#[derive(Clone)]
pub(super) struct FewWrong {
    sights: Vec<Points>,
    most_wrong: MostWrong,
    stray: Stray,
    /// A wide box of poses, with what the sightings leave of it: it is needed again each time that readings are gone through anew.
    found: OnceLock<(PoseBox, Vec<PoseBox>)>,
}

impl FewWrong {
    /// Some sightings, of which at most `most_wrong` are wrong.
    pub(super) fn new(
        optics: &Arc<Optics>,
        stray: Stray,
        sights: &[Sight],
        most_wrong: impl Into<MostWrong>,
    ) -> FewWrong {
        let alone = |sight: &Sight| Points { optics: Arc::clone(optics), seen: vec![*sight] };
        // Neighbours in the image are left out in different programs, so that each looks in many directions.
        let mut by_column = sights.to_vec();
        by_column.sort_by(|a, b| a.at_px[0].total_cmp(&b.at_px[0]).then(a.landmark.cmp(&b.landmark)));
        let (sights, most_wrong) = (by_column.iter().map(alone).collect(), most_wrong.into());
        FewWrong { sights, most_wrong, stray, found: OnceLock::new() }
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
        let mut excluding = seen.filter(|(optics, sight)| !may_be_seen(optics, sight, &shown)).map(|(_, sight)| sight);
        if self.most_wrong.things == 0 {
            return excluding.nth(self.most_wrong.items).is_none();
        }
        n_without(excluding, self.most_wrong.things) <= self.most_wrong.items
    }

    /// Whether so many sightings agree that they tell where the robot is, of all places: chance does not make the greater part of them agree.
    pub(super) fn tells_anywhere(&self) -> bool {
        self.n_at_least() >= self.most_wrong.items + FEWEST_ANYWHERE
    }

    /// Whether two sightings are right at least: one alone gives two equations for three coordinates of the pose.
    pub(super) fn says_something(&self) -> bool {
        self.n_at_least() >= self.most_wrong.items + 2
    }

    /// Number of the sightings without those of the things that may be wrong, whichever these are.
    fn n_at_least(&self) -> usize {
        n_without(self.seen(), self.most_wrong.things)
    }

    fn seen(&self) -> impl Iterator<Item = &Sight> {
        self.sights.iter().flat_map(|one| &one.seen)
    }

    /// The picture of the teaching drive that the sightings are compared with.
    pub(super) fn view(&self) -> Option<usize> {
        let mut views = self.seen().filter_map(|sight| sight.view);
        views.next().map(|view| view.sight.picture)
    }

    /// The programs of the sightings for a picture from a pose within a box, one for each choice of things that are wrong; `None` where they exclude
    /// every such pose.
    pub(super) fn program(&self, shown: &PoseBox) -> Option<Alternatives> {
        let things = things_of(self.seen());
        let chosen = choices(things.len(), self.most_wrong.things.min(things.len())).into_iter();
        let without = |choice: Vec<usize>| {
            let wrong: Vec<u32> = choice.into_iter().map(|at| things[at]).collect();
            self.program_without(&wrong, shown)
        };
        let programs: Vec<DespiteWrong> = chosen.filter_map(without).collect();
        (!programs.is_empty()).then_some(Alternatives(programs))
    }

    /// The program of the sightings without those of some things.
    fn program_without(&self, things: &[u32], shown: &PoseBox) -> Option<DespiteWrong> {
        let is_of_them = |one: &Points| one.seen.iter().any(|sight| sight.thing.is_some_and(|at| things.contains(&at)));
        let items: Vec<&dyn Relations> =
            self.sights.iter().filter(|one| !is_of_them(one)).map(|one| one as &dyn Relations).collect();
        DespiteWrong::new(shown, &items, self.most_wrong.items)
    }

    /// The things that are not where the map has them, whatever the pose within a box from which the picture was taken: without the sightings of such
    /// a thing some pose is left, and with them none is, whichever other things are left out in its place. Of the things that the picture shows, as
    /// many may be wrong as are declared, and one if none is.
    pub(super) fn contradicting(&self, shown: &PoseBox) -> Vec<u32> {
        let things = things_of(self.seen());
        let most_wrong = self.most_wrong.things.max(1);
        if things.len() <= most_wrong {
            return Vec::new();
        }
        let leaves_poses = |wrong: &Vec<u32>| {
            self.program_without(wrong, shown).is_some_and(|program| program.bounds(&AXES).is_some())
        };
        let chosen = choices(things.len(), most_wrong).into_iter();
        let possible: Vec<Vec<u32>> =
            chosen.map(|choice| choice.into_iter().map(|at| things[at]).collect()).filter(leaves_poses).collect();
        let is_wrong = |thing: &u32| possible.iter().all(|wrong| wrong.contains(thing));
        if possible.is_empty() { Vec::new() } else { things.into_iter().filter(is_wrong).collect() }
    }

    /// What the sightings' rows, made once about the middle of a box of poses, leave of the box.
    pub(super) fn pass(&self, domain: &PoseBox) -> PoseBox {
        let shown = self.stray.around(domain);
        let Some(bounds) = self.program(&shown).and_then(|program| program.bounds(&AXES)) else {
            return PoseBox::EMPTY;
        };
        let left = self.stray.around(&PoseBox::from([bounds[0], bounds[1], bounds[2]])).intersect(domain);
        if left.is_empty() { PoseBox::EMPTY } else { left }
    }
}

/// The things that some sightings show, in the order of their numbers.
pub(super) fn things_of<'a>(sights: impl Iterator<Item = &'a Sight>) -> Vec<u32> {
    let things: BTreeSet<u32> = sights.filter_map(|sight| sight.thing).collect();
    things.into_iter().collect()
}

/// Number of some sightings without those of so many things, of which most are.
fn n_without<'a>(sights: impl Iterator<Item = &'a Sight>, n_things: usize) -> usize {
    let mut n_of_things: BTreeMap<u32, usize> = BTreeMap::new();
    let mut n_all = 0;
    for sight in sights {
        n_all += 1;
        sight.thing.into_iter().for_each(|thing| *n_of_things.entry(thing).or_default() += 1);
    }
    let mut n_of_things: Vec<usize> = n_of_things.into_values().collect();
    n_of_things.sort_unstable_by(|a, b| b.cmp(a));
    n_all - n_of_things.iter().take(n_things).sum::<usize>()
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
pub(super) mod tests;
