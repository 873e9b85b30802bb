//! An assumption failed: what may have failed, how each hypothesis explains the readings, and when one of them is believed.
//!
//! An empty intersection proves that something assumed is false, but not what. While that is open, three hypotheses are followed side by
//! side, and the answer is the union of what they leave: if one of them is right, the true pose is in it.
//!
//! - *Reading*: the reading that contradicted is false, a wrong claim or a thing that is not where the map has it. All else stands.
//! - *Motion*: wheels or flow sensor broke their bounds in the last second or seconds. Since then reach alone tells the way.
//! - *Memory*: what was known is false from its beginning. Only what names its place on the map tells anything, as a marker's code does,
//!   and the latest such reading is believed.
//!
//! Each reading agrees with a hypothesis or contradicts it. Two witnesses that have nothing in common end one; with two that agree, and no
//! other hypothesis elsewhere, one is believed.

use interval::{Interval, IntervalBox};

use crate::{Constraint, PoseUnion};

use super::{
    Localizer, REMEMBER_S,
    carrying::contract_union,
    hypothesis::{Failed, Hypothesis, Witness, named},
    moves::{REACH, WHEELS},
    ring::{Slot, merged},
};

/// What was unlearnt gets so long to show whether it was enough.
const UNLEARN_PAUSE_S: f64 = 2.0;
/// A contradiction so long after the last one has a cause of its own.
const UNLEARN_CALM_S: f64 = 15.0;
/// A doubt goes back at least so far: what was hung since may already have been cut by the assumption that failed.
const DOUBT_S: f64 = 1.0;
/// A contradiction so soon after the last doubt has its cause, which was farther back than was thought: it goes back twice as far.
const DOUBT_AGAIN_S: f64 = 5.0;
/// A robot that may be anywhere is looked for in so many sectors of heading: contractors of poses narrow headings only within a part of a turn.
const HEADINGS: usize = 8;
/// Beyond so many turns sectors are wider.
const MOST_TURNS: f64 = 4.0;

/// What a reading that is about to be hung tells of each hypothesis.
pub(super) struct Evidence {
    stamp_s: f64,
    witnesses: Vec<Witness>,
    /// Whether it tells enough to make a hypothesis believed.
    decides: bool,
    /// For each hypothesis, whether the wheels lead from the image before to what the reading allows.
    agrees: Vec<bool>,
}

/// Doubts gone by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubts {
    /// When the last one ended: what was settled then is not gone over again.
    pub(super) ended_s: f64,
    /// How far back it went.
    depth_s: f64,
    /// When methods unlearnt last, and how far back.
    unlearnt: (f64, f64),
}

impl Default for Doubts {
    fn default() -> Self {
        Doubts { ended_s: f64::NEG_INFINITY, depth_s: 0.0, unlearnt: (0.0, 0.0) }
    }
}

impl Localizer {
    /// An assumption failed, perhaps some time ago: every hypothesis is followed from where it parts from what was believed.
    ///
    /// `contradicting_s` is the stamp of the constraint that left nothing, if it was one.
    pub(super) fn begin_doubt(&mut self, contradicting_s: Option<f64>) {
        if self.is_doubted() {
            self.begin_anywhere();
            return;
        }
        let is_again = self.now_s - self.doubts.ended_s < DOUBT_AGAIN_S;
        let depth_s = if is_again { (2.0 * self.doubts.depth_s).min(REMEMBER_S) } else { 0.0 }.max(DOUBT_S);
        self.doubts = Doubts { depth_s, ended_s: f64::NEG_INFINITY, ..self.doubts };
        self.relies_on.retain(|assumption| !WHEELS.contains(assumption));
        self.relies_on.extend(
            REACH.iter().filter(|assumption| !self.relies_on.contains(assumption)).copied().collect::<Vec<_>>(),
        );
        let renewed_s = self.unlearn_deeper();
        let doubtful_s = self.now_s - depth_s;
        self.ring.drop_anchors_after(doubtful_s);

        // What stood on what is unlearnt is gone over again.
        let reading = contradicting_s.map(|stamp_s| (Failed::Reading, stamp_s.min(renewed_s)));
        let since: Vec<(Failed, f64)> =
            reading.into_iter().chain([(Failed::Motion, doubtful_s), (Failed::Memory, doubtful_s)]).collect();
        self.hypotheses = since.iter().map(|(failed, _)| Hypothesis::new(*failed)).collect();
        for slot in self.ring.iter_mut() {
            let believed = std::mem::take(&mut slot.unions[0]);
            slot.unions = since
                .iter()
                .map(|(failed, _)| if *failed == Failed::Memory { PoseUnion::default() } else { believed.clone() })
                .collect();
        }
        if let Some(doubted) = contradicting_s.and_then(|stamp_s| self.ring.at(stamp_s)) {
            self.hypotheses[0].contradict(&doubted.witnesses);
        }
        for (hypothesis, (_, from_s)) in since.into_iter().enumerate() {
            for stamp_s in self.replay(hypothesis, from_s) {
                let Some(against) = self.ring.at(stamp_s).filter(|slot| slot.constraint.is_some()) else { continue };
                self.hypotheses[hypothesis].contradict(&against.witnesses);
            }
        }
        self.drop_refuted();
        self.restart_integral();
        let explained = self.ring.before(self.now_s).and_then(|slot| self.explained_at(slot, self.now_s));
        self.answer(explained.unwrap_or_default());
        if self.current.is_empty() {
            self.begin_anywhere();
        }
    }

    /// No hypothesis leaves anything: the robot may be anywhere in the room.
    fn begin_anywhere(&mut self) {
        let mut failed = vec![Failed::Motion, Failed::Memory];
        let mut unions = vec![self.anywhere(), PoseUnion::default()];
        if self.anywhere().is_empty() {
            // A room that has no place for the robot: nothing can be said.
            failed.truncate(1);
            unions.truncate(1);
        }
        self.hypotheses = failed.into_iter().map(Hypothesis::new).collect();
        self.answer(merged(&unions));
        self.ring.restart(Slot::anchor(self.now_s, unions));
        self.restart_integral();
    }

    /// Any place in the room, in sectors of the headings about those last known: a whole turn, and as far as the robot can have turned since.
    fn anywhere(&self) -> PoseUnion {
        let room = self.whole_room();
        let (known_s, known) = self.known_heading;
        let turned = known + self.wheels.reach_motion(known_s, self.now_s, &self.robot.reach)[2];
        let middle_rad = known.mid();
        let n_turns = ((turned - middle_rad).magnitude() / std::f64::consts::PI).max(1.0);
        if !n_turns.is_finite() || !middle_rad.is_finite() {
            return PoseUnion::single(room);
        }
        // Headings count turns. What reaches beyond one has a sector more, so that as much lies on both sides of the middle one.
        let n_aside = (n_turns.min(MOST_TURNS) * (HEADINGS / 2) as f64).ceil();
        let n_sectors = 2 * n_aside as usize + usize::from(n_turns > 1.0);
        let sector_rad = n_turns * std::f64::consts::PI / n_aside;
        let headings = (0..n_sectors).map(|sector| {
            let centre_rad = middle_rad + (sector as f64 - n_aside) * sector_rad;
            // A hair wider, so that no heading falls between two sectors by rounding.
            Interval::centred(centre_rad, 0.5 * sector_rad + 1e-9)
        });
        let boxes = headings.map(|heading| IntervalBox::from([room[0], room[1], heading]));
        PoseUnion { branches: boxes.filter(|sector| !sector.is_empty()).collect() }
    }

    /// Where a constraint that names its place on the map says that the robot is, whatever was known; nothing for any other.
    pub(super) fn located(&self, constraint: &Constraint) -> PoseUnion {
        if named(constraint).is_empty() {
            return PoseUnion::default();
        }
        contract_union(&self.anywhere(), constraint.on_pose.as_ref())
    }

    /// What a constraint bears witness of: the one marker that it names, or those that do not agree with each other; else the reading. Markers of one
    /// reading that agree are not all misplaced: if it is false, then for a reason of its own, such as a body that leaned, and the next
    /// reading of the same markers is another witness.
    pub(super) fn witnesses(&self, constraint: &Constraint) -> Vec<Witness> {
        let named = named(constraint);
        let is_one_thing = named.len() == 1 || (named.len() > 1 && self.located(constraint).is_empty());
        if is_one_thing { named } else { vec![Witness::Reading(constraint.stamp_s)] }
    }

    /// What a constraint that is about to be hung tells of each hypothesis; `None` without a doubt.
    pub(super) fn evidence(&self, constraint: &Constraint, witnesses: &[Witness]) -> Option<Evidence> {
        self.is_doubted().then(|| Evidence {
            stamp_s: constraint.stamp_s,
            witnesses: witnesses.to_vec(),
            decides: constraint.decides,
            agrees: (0..self.hypotheses.len())
                .map(|hypothesis| self.agrees_with_wheels(hypothesis, constraint))
                .collect(),
        })
    }

    /// Follows each hypothesis from `from_s` on with a reading hung, and weighs what it tells. Answers whether it contradicts them all.
    pub(super) fn weigh(&mut self, evidence: Evidence, from_s: f64) -> bool {
        let mut n_against = 0;
        let n_hypotheses = self.hypotheses.len();
        for hypothesis in 0..n_hypotheses {
            if self.hypotheses[hypothesis].disbelieves(&evidence.witnesses) {
                self.replay(hypothesis, from_s);
                continue;
            }
            let agrees = evidence.decides && evidence.agrees[hypothesis];
            if evidence.decides && !agrees {
                // Before it is followed: what the wheels do not lead to may still be within reach.
                self.hypotheses[hypothesis].disagree();
            }
            let contradicting = self.replay(hypothesis, from_s);
            let is_lost = self.ring.at(evidence.stamp_s).is_none_or(|slot| slot.unions[hypothesis].is_empty());
            let weighed = &mut self.hypotheses[hypothesis];
            let is_against = contradicting.contains(&evidence.stamp_s);
            n_against += usize::from(is_against);
            if is_against && weighed.failed != Failed::Memory {
                weighed.contradict(&evidence.witnesses);
            } else if agrees {
                weighed.agree(&evidence.witnesses, evidence.stamp_s);
            } else if evidence.decides && weighed.failed == Failed::Memory && !is_lost {
                // What found its place anew has its first witness in that.
                weighed.note(&evidence.witnesses);
            }
        }
        self.drop_refuted();
        self.end_doubt_when_decided();
        n_against == n_hypotheses
    }

    /// Drops what two witnesses contradict, and what no pose is left of; the last one stays, whatever speaks against it.
    fn drop_refuted(&mut self) {
        let is_empty = |hypothesis: usize| self.ring.last().is_some_and(|last| last.unions[hypothesis].is_empty());
        let mut dropped: Vec<usize> = Vec::new();
        for (index, hypothesis) in self.hypotheses.iter().enumerate() {
            // Memory is empty until something names its place, and begins anew at whatever contradicts it.
            let is_dead = hypothesis.failed != Failed::Memory && (hypothesis.is_refuted() || is_empty(index));
            let others_left = (0..self.hypotheses.len()).any(|other| {
                other != index && !dropped.contains(&other) && !is_empty(other) && !self.hypotheses[other].is_refuted()
            });
            if is_dead && others_left {
                dropped.push(index);
            }
        }
        for index in dropped.into_iter().rev() {
            self.hypotheses.remove(index);
            for slot in self.ring.iter_mut() {
                slot.unions.remove(index);
            }
        }
    }

    /// Believes what is left once one hypothesis has witnesses enough and no other is elsewhere.
    fn end_doubt_when_decided(&mut self) {
        let Some(last) = self.ring.last() else { return };
        let mut followed = self.hypotheses.iter().zip(&last.unions);
        let Some((hypothesis, believed)) = followed.find(|(one, union)| one.is_supported() && !union.is_empty()) else {
            return;
        };
        let is_elsewhere = |union: &PoseUnion| {
            !union.is_empty()
                && !union.branches.iter().any(|one| believed.branches.iter().any(|other| one.overlaps(other)))
        };
        if last.unions.iter().any(is_elsewhere) {
            return;
        }
        // What was false from its beginning has taught nothing.
        if let (Failed::Memory, Some(fixes)) = (hypothesis.failed, &mut self.fixes) {
            fixes.forget_since(f64::NEG_INFINITY);
        }
        self.doubts.ended_s = last.stamp_s;
        self.hypotheses = vec![Hypothesis::new(Failed::Nothing)];
        for slot in self.ring.iter_mut() {
            slot.unions = vec![joined(&slot.unions)];
        }
        self.relies_on.extend(
            WHEELS.iter().filter(|assumption| !self.relies_on.contains(assumption)).copied().collect::<Vec<_>>(),
        );
    }

    /// Whether the wheels lead from the last image's union to one that this constraint allows.
    fn agrees_with_wheels(&self, hypothesis: usize, constraint: &Constraint) -> bool {
        let Some(before) = self.ring.image_before(constraint.stamp_s) else { return false };
        self.carried(&before.unions[hypothesis], before.stamp_s, constraint.stamp_s, false)
            .is_some_and(|predicted| !contract_union(&predicted, constraint.on_pose.as_ref()).is_empty())
    }

    /// Lets the methods unlearn what they learnt in the last seconds. A push that hid in the width of a box may have been learnt from
    /// long before it showed: when that was not enough, twice as much is taken back. Answers from which stamp on constraints were made anew.
    fn unlearn_deeper(&mut self) -> f64 {
        let (latest_s, depth_s) = self.doubts.unlearnt;
        let since_s = self.now_s - latest_s;
        if since_s < UNLEARN_PAUSE_S && depth_s > 0.0 {
            return f64::INFINITY;
        }
        let depth_s = if since_s < UNLEARN_CALM_S { 2.0 * depth_s } else { 0.0 }.max(REMEMBER_S);
        self.doubts.unlearnt = (self.now_s, depth_s);
        self.unlearn_since(self.now_s - depth_s)
    }

    /// Lets the methods unlearn, and makes the constraints anew that stood on what they had learnt; answers the stamp of the first of them.
    fn unlearn_since(&mut self, since_s: f64) -> f64 {
        let mut first_s = f64::INFINITY;
        if let Some(fixes) = &mut self.fixes {
            fixes.forget_since(since_s);
        }
        self.tell_wheels_of_gyro();
        for method in &mut self.methods {
            method.forget_since(since_s);
            for slot in self.ring.iter_mut() {
                let hung = slot.constraint.as_mut().filter(|hung| hung.method == method.name());
                if let (Some(constraint), Some(on_pose)) = (hung, method.renewed(slot.stamp_s)) {
                    constraint.on_pose = on_pose;
                    first_s = first_s.min(slot.stamp_s);
                }
            }
        }
        first_s
    }
}

/// The branches of several unions, those that overlap made one.
fn joined(unions: &[PoseUnion]) -> PoseUnion {
    let mut branches = merged(unions).branches;
    if unions.len() == 1 {
        return PoseUnion { branches };
    }
    let mut index = 0;
    while index < branches.len() {
        match (index + 1..branches.len()).find(|&other| branches[index].overlaps(&branches[other])) {
            Some(other) => {
                branches[index] = branches[index].hull(&branches[other]);
                branches.remove(other);
            }
            None => index += 1,
        }
    }
    PoseUnion { branches }
}
