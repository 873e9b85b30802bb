//! Branches of the latest key frame's pose. What is not linear in the rows of a program grows with the box of the pose, so that each branch of a pose
//! union has a program of its own, and the pose is in the union of what the programs leave. Where a reading keeps what it found about one box of the
//! pose, such as which joints it shows, there is one program about the whole box.

use interval::{Interval, IntervalBox};

use crate::{
    PoseBox, PoseUnion,
    graph::{Hull, KeyFrames, Place, Related, Variable, WIDEST_RAD},
    reading::LandmarkId,
};

use super::ring::without_overlaps;

/// Greatest number of branches of a pose that have programs of their own. They are solved one after the other, each in some twenty wheel readings.
const MOST: usize = 4;

/// The work on the programs of the latest key frame, one for each branch of its pose.
pub(super) struct Branches {
    /// All key frames as they were when the work began.
    frames: KeyFrames,
    /// The time at which it began, and the places of landmarks that were known then.
    known: (f64, Vec<(LandmarkId, Place)>),
    /// The quantities to be bounded, those of the latest key frame's pose first.
    wanted: Vec<Variable>,
    /// The branches whose programs are not made yet.
    left: Vec<PoseBox>,
    /// Whether there is a single program, about the whole box of the key frame's pose.
    is_whole: bool,
    /// The programs that are solved.
    solved: Vec<Hull>,
}

/// The branches of a pose union that programs can be made for, none of which overlaps another: at most [`MOST`], of which no heading is wider than
/// [`WIDEST_RAD`]. `None` where the union has others. A union that has too many, all about the same heading, is replaced by its hull.
pub(super) fn for_programs(union: &PoseUnion) -> Option<Vec<PoseBox>> {
    let is_narrow = |pose: &PoseBox| pose[2].width() <= WIDEST_RAD;
    let hull = union.hull();
    let branches = without_overlaps(union.branches.clone());
    if branches.len() <= MOST && branches.iter().all(is_narrow) {
        return Some(branches);
    }
    Some(vec![hull]).filter(|_| is_narrow(&hull))
}

impl Branches {
    /// The programs for the quantities `wanted` of all key frames, about the branches of a union that holds the latest one's pose.
    pub(super) fn new(
        frames: KeyFrames,
        known: (f64, Vec<(LandmarkId, Place)>),
        wanted: Vec<Variable>,
        union: &PoseUnion,
    ) -> Branches {
        let pose = frames.latest_pose().unwrap_or(PoseBox::EMPTY);
        let is_wide = pose[2].width() > WIDEST_RAD;
        let branches = for_programs(&union.common(&PoseUnion::single(pose))).filter(|_| frames.is_found_anew());
        let branches = branches.unwrap_or_default();
        let is_whole = branches.len() < 2 && !is_wide;
        let left = if is_whole { vec![pose] } else { branches };
        Branches { frames, known, wanted, left, is_whole, solved: Vec::new() }
    }

    /// The program of the next branch; `None` where a quantity of it is not bounded.
    pub(super) fn next_program(&mut self) -> Option<Related> {
        let branch = self.left.pop()?;
        self.frames.within(&branch).related(&self.known.1).ok()
    }

    /// No bounds yet of the quantities by the program of a branch.
    pub(super) fn hull(&self, related: Related) -> Hull {
        Hull::new(related, self.wanted.clone())
    }

    /// Takes in the solved program of a branch. Returns whether it was the last one.
    pub(super) fn take(&mut self, hull: Hull) -> bool {
        self.solved.push(hull);
        self.left.is_empty()
    }

    /// The time at which all that the programs rely on was known.
    pub(super) fn known_s(&self) -> f64 {
        self.known.0
    }

    /// Number of the key frame whose pose the programs bound.
    pub(super) fn number(&self) -> Option<usize> {
        self.wanted.first().and_then(|variable| variable.frame())
    }

    /// The programs that leave a pose, with their bounds.
    fn possible(&self) -> impl Iterator<Item = (&Hull, Vec<Interval>)> {
        self.solved.iter().filter_map(|hull| Some((hull, hull.bounds()?)))
    }

    /// What is left of each branch; none where the rows contradict each other in every branch.
    pub(super) fn poses(&self) -> PoseUnion {
        let pose = |(_, bounds): (&Hull, Vec<Interval>)| {
            Some(IntervalBox::from([*bounds.first()?, *bounds.get(1)?, *bounds.get(2)?]))
        };
        PoseUnion { branches: self.possible().filter_map(pose).collect() }
    }

    /// Bounds of the quantities, whichever branch the pose is in.
    pub(super) fn bounds(&self) -> Vec<(Variable, Interval)> {
        let hull = |variable: Variable| {
            let of_branch = |(hull, bounds): (&Hull, Vec<Interval>)| {
                let at = hull.wanted().position(|one| one == variable);
                at.map_or(Interval::ENTIRE, |at| bounds[at])
            };
            (variable, self.possible().map(of_branch).fold(Interval::EMPTY, Interval::hull))
        };
        self.wanted.iter().copied().map(hull).collect()
    }

    /// The program of the only branch that leaves a pose, if there is just one.
    pub(super) fn only(&self) -> Option<&Hull> {
        let mut possible = self.possible();
        possible.next().filter(|_| possible.next().is_none()).map(|(hull, _)| hull)
    }

    /// The program of the only branch that leaves a pose, if there is just one.
    pub(super) fn into_only(mut self) -> Option<Hull> {
        self.solved.retain(|hull| hull.bounds().is_some());
        self.solved.pop().filter(|_| self.solved.is_empty())
    }

    /// The program about the whole box of the key frame's pose, if there is a single one. Only its rows and boxes say by themselves which bounds
    /// contradict each other.
    pub(super) fn into_whole(mut self) -> Option<Related> {
        self.solved.pop().filter(|_| self.is_whole).map(Hull::into_related)
    }
}
