//! Doubt after an assumption failed: what may have failed, how each hypothesis explains the readings, and when one of them is believed.
//!
//! An empty intersection proves that some assumption is false, but not which. Until that is known, several hypotheses are followed side by side, and
//! the estimate is the union of the poses that each of them leaves: if one of them is right, the true pose is in the union.
//!
//! - *Reading*: the reading that gave the contradiction is false, because of a wrong claim or a thing that is not where the map has it. Everything
//!   else holds.
//! - *Markers*: some of the markers seen lately are not where the map has them. Everything else holds, other markers in the same images included. There
//!   is one such hypothesis for each smallest set of markers without which nothing contradicts anything.
//! - *Motion*: wheels or flow sensor have broken their bounds since 0.6 s or more before the last reading that agreed, and perhaps still do.
//!   Since then reach (the robot's physical limits of motion) alone bounds the motion. If that explains nothing, longer times are asked.
//! - *Earlier motion*: wheels or flow sensor broke their bounds within one span of 0.6 s before that, and have kept them since.
//! - *Memory*: everything known before is false. Only a reading that names its place on the map is informative, as a marker's code is, and the latest
//!   such reading is believed.
//!
//! Each reading agrees with a hypothesis or contradicts it. It counts as a witness: the witness is the marker that the reading shows, or else the
//! reading itself, so that two readings of one misplaced marker count once. Two witnesses refute a hypothesis. A hypothesis is believed once two
//! witnesses agree with it and no other hypothesis puts the robot elsewhere. If it is *markers*, these markers are set aside for the rest of the drive.

use interval::{Interval, IntervalBox};

use crate::{Constraint, PoseBox, PoseUnion, method::Window};

use super::{
    Localizer, REMEMBER_S,
    heading_fixes::HeadingFixes,
    hypothesis::{Failed, Hypothesis, Witness, named},
    moves::{REACH, WHEELS},
    naming::Intersected,
    ring::{Explanation, Slot, joined, merged},
};

/// Pause after the methods have unlearnt what they learnt from recent readings. In this time they do not unlearn again, so that it shows whether the
/// first time was enough.
const UNLEARN_PAUSE_S: f64 = 2.0;
/// After a contradiction the methods take back what they learnt from recent readings. A further contradiction within this time is taken to have the
/// same cause, and the methods then take back twice as much time as before; one that comes later is taken to have a cause of its own.
const UNLEARN_CALM_S: f64 = 15.0;
/// Time after the end of a doubt in which a new contradiction is taken to have the same cause as that doubt, which then lasted for longer than was
/// assumed: the new doubt sets aside spans of motion that are twice as long.
const DOUBT_AGAIN_S: f64 = 5.0;
/// Number of sectors of heading per turn in which a robot that may be anywhere is searched for. There are several, because a contractor of poses
/// narrows headings only within a part of a turn.
const HEADINGS: usize = 8;
/// Greatest number of turns, spanned by the possible headings, up to which a wider span is searched in more sectors of heading; beyond it, the
/// sectors become wider instead.
const MOST_TURNS: f64 = 4.0;

/// What a reading says about each hypothesis on what failed; determined before the reading's constraint is applied.
pub(super) struct Evidence {
    stamp_s: f64,
    /// For each hypothesis on what failed, the reading's witnesses that tell something under it.
    witnesses: Vec<Vec<Witness>>,
    /// Whether the reading restricts the pose enough to count as support for a hypothesis.
    decides: bool,
    /// For each hypothesis on what failed, whether the motion by the wheels leads from its poses at the previous image to poses that the reading
    /// allows.
    agrees: Vec<bool>,
}

/// When earlier doubts about an assumption took place, and how much motion they set aside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubts {
    /// Time at which the last doubt about an assumption ended: poses before that time are not recomputed.
    pub(super) ended_s: f64,
    /// Length of the spans of motion that the last doubt set aside.
    pub(super) span_s: f64,
    /// Time at which the methods last unlearnt what they had learnt from recent readings, and how many seconds before it that began.
    unlearnt: (f64, f64),
}

impl Default for Doubts {
    fn default() -> Self {
        Doubts { ended_s: f64::NEG_INFINITY, span_s: 0.0, unlearnt: (0.0, 0.0) }
    }
}

impl Localizer {
    /// Begins a doubt: an assumption failed, perhaps some time ago, and it is not known which. Every hypothesis about what failed is followed from
    /// the stamp on from which it differs from what the localizer believed before.
    ///
    /// `contradicting_s` is the stamp of the constraint that left the pose union empty, if a constraint did.
    pub(super) fn begin_doubt(&mut self, contradicting_s: Option<f64>) {
        if self.is_doubted() {
            self.begin_anywhere();
            return;
        }
        self.note_contradiction(contradicting_s.map_or(Intersected::Known, Intersected::Constraint), None);
        let ended_s = self.doubts.ended_s;
        let is_again = self.now_s - ended_s < DOUBT_AGAIN_S;
        let least_s = if is_again { (2.0 * self.doubts.span_s).min(REMEMBER_S) } else { 0.0 };
        self.doubts.ended_s = f64::NEG_INFINITY;
        self.relies_on.retain(|assumption| !WHEELS.contains(assumption));
        self.relies_on.extend(
            REACH.iter().filter(|assumption| !self.relies_on.contains(assumption)).copied().collect::<Vec<_>>(),
        );
        let renewed_s = self.unlearn_deeper();
        let corrections = self.markers_that_explain(ended_s, contradicting_s);
        let agreeing = contradicting_s.map_or(self.ring.last(), |stamp_s| self.ring.earlier_than(stamp_s));
        let agreed_s = agreeing.map_or(self.now_s, |slot| slot.stamp_s);
        // From here on no heading is carried from an earlier fix to a later stamp: between them the motion may have been false.
        self.hypotheses = vec![Hypothesis::new(Failed::Memory)];
        let motion = self.motion_that_explains(agreed_s, least_s);
        self.doubts.span_s = motion.span_s;

        // The hypothesis of a false reading is followed from that reading on, or from the first constraint on that relied on something just unlearnt,
        // if that constraint is earlier.
        let reading = contradicting_s.map(|stamp_s| (Failed::Reading, stamp_s.min(renewed_s)));
        let unexplained = motion.explanations.is_empty().then_some((Failed::Motion, motion.since_s));
        let since: Vec<(Failed, f64)> =
            reading.into_iter().chain(unexplained).chain([(Failed::Memory, motion.since_s)]).collect();
        self.hypotheses = since.iter().map(|(failed, _)| Hypothesis::new(*failed)).collect();
        self.graph.forget_since(self.now_s - REMEMBER_S);
        self.ring.forget_relations();
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
        // Where several hypotheses are supported, the first of them is believed: that everything known was false only if the motion was not.
        let memory = self.hypotheses.len() - 1;
        for (index, explanation) in motion.explanations.into_iter().enumerate() {
            self.follow(memory + index, explanation);
        }
        for explanation in corrections {
            self.follow(self.hypotheses.len(), explanation);
        }
        self.drop_refuted();
        self.restart_integral();
        let explained = self.ring.before(self.now_s).and_then(|slot| self.explained_at(slot, self.now_s));
        self.answer(explained.unwrap_or_default());
        if self.current.is_empty() {
            self.begin_anywhere();
        }
    }

    /// Follows one more hypothesis, as the one with the given index.
    fn follow(&mut self, index: usize, (hypothesis, unions): Explanation) {
        self.hypotheses.insert(index, hypothesis);
        self.ring.iter_mut().zip(unions).for_each(|(slot, union)| slot.unions.insert(index, union));
    }

    /// Begins the doubt anew, with the robot anywhere in the room, because no hypothesis about what failed leaves any pose.
    fn begin_anywhere(&mut self) {
        let mut failed = vec![Failed::Motion, Failed::Memory];
        let mut unions = vec![self.anywhere(), PoseUnion::default()];
        if self.anywhere().is_empty() {
            // If no place in the room is wide enough for the robot's body, no pose is possible and nothing can be said about the pose.
            failed.truncate(1);
            unions.truncate(1);
        }
        self.hypotheses = failed.into_iter().map(Hypothesis::new).collect();
        self.graph.clear();
        self.answer(merged(&unions));
        self.ring.restart(Slot::anchor(self.now_s, unions));
        self.restart_integral();
    }

    /// Every position in the room with all headings that are possible, divided into sectors about the last known heading. The possible headings are a
    /// whole turn, or more if the robot can have turned farther since that heading was known.
    fn anywhere(&self) -> PoseUnion {
        let room = self.whole_room();
        let (known_s, known) = self.known_heading;
        let turned = known + self.wheels.reach_motion(known_s, self.now_s, &self.robot.reach)[2];
        let middle_rad = known.mid();
        let n_turns = ((turned - middle_rad).magnitude() / std::f64::consts::PI).max(1.0);
        if !n_turns.is_finite() || !middle_rad.is_finite() {
            return PoseUnion::single(room);
        }
        // Headings are real numbers, not wrapped to one turn. If the possible headings extend beyond one turn, there is one more sector, so that
        // equally many lie on both sides of the middle one.
        let n_aside = (n_turns.min(MOST_TURNS) * (HEADINGS / 2) as f64).ceil();
        let n_sectors = 2 * n_aside as usize + usize::from(n_turns > 1.0);
        let sector_rad = n_turns * std::f64::consts::PI / n_aside;
        let headings = (0..n_sectors).map(|sector| {
            let centre_rad = middle_rad + (sector as f64 - n_aside) * sector_rad;
            // Each sector of heading is 1e-9 rad wider on both sides, so that no heading falls between two sectors by rounding.
            Interval::centred(centre_rad, 0.5 * sector_rad + 1e-9)
        });
        let boxes = headings.map(|heading| IntervalBox::from([room[0], room[1], heading]));
        PoseUnion { branches: boxes.filter(|sector| !sector.is_empty()).collect() }
    }

    /// Union of all poses in the room that a constraint allows, if it claims to have seen a marker, whose place the map gives; empty for any other
    /// constraint.
    pub(super) fn located(&self, constraint: &Constraint) -> PoseUnion {
        if named(constraint).is_empty() {
            return PoseUnion::default();
        }
        self.anywhere().contracted(constraint.on_pose.as_ref())
    }

    /// Witnesses of a constraint: the things by whose fault alone it may be false. If it names one marker, or several that do not agree with each
    /// other, the witnesses are these markers; otherwise the witness is the reading. Markers of one reading that agree are not all misplaced: if such
    /// a reading is false, it is for a reason of its own, such as a body that leaned, and the next reading of the same markers is another witness.
    pub(super) fn witnesses(&self, constraint: &Constraint) -> Vec<Witness> {
        let named = named(constraint);
        let is_one_thing = named.len() == 1 || (named.len() > 1 && self.located(constraint).is_empty());
        if is_one_thing { named } else { vec![Witness::Reading(constraint.stamp_s)] }
    }

    /// What a constraint says about each hypothesis on what failed, before the constraint is applied; `None` while no assumption is doubted.
    pub(super) fn evidence(&self, constraint: &Constraint, witnesses: &[Witness]) -> Option<Evidence> {
        self.is_doubted().then(|| Evidence {
            stamp_s: constraint.stamp_s,
            witnesses: self.hypotheses.iter().map(|hypothesis| hypothesis.heard(witnesses)).collect(),
            decides: constraint.decides,
            agrees: (0..self.hypotheses.len())
                .map(|hypothesis| self.agrees_with_wheels(hypothesis, constraint))
                .collect(),
        })
    }

    /// Recomputes each hypothesis from `from_s` on with a newly stored reading, and weighs what the reading says about the hypothesis. Returns
    /// whether the reading contradicts every hypothesis.
    pub(super) fn weigh(&mut self, evidence: Evidence, from_s: f64) -> bool {
        let mut n_against = 0;
        let n_hypotheses = self.hypotheses.len();
        for hypothesis in 0..n_hypotheses {
            let witnesses = &evidence.witnesses[hypothesis];
            if witnesses.is_empty() {
                self.replay(hypothesis, from_s);
                continue;
            }
            let agrees = evidence.decides && evidence.agrees[hypothesis];
            if evidence.decides && !agrees {
                // The disagreement of the wheels with the reading is noted before the hypothesis is recomputed, because it makes the hypothesis
                // distrust the wheels: the robot's limits of motion may still allow poses to which the wheels do not lead.
                self.hypotheses[hypothesis].disagree();
            }
            let contradicting = self.replay(hypothesis, from_s);
            let is_lost = self.ring.at(evidence.stamp_s).is_none_or(|slot| slot.unions[hypothesis].is_empty());
            let weighed = &mut self.hypotheses[hypothesis];
            let is_against = contradicting.contains(&evidence.stamp_s);
            n_against += usize::from(is_against);
            if is_against && weighed.failed != Failed::Memory {
                weighed.contradict(witnesses);
            } else if agrees {
                weighed.agree(witnesses, evidence.stamp_s);
            } else if evidence.decides && weighed.failed == Failed::Memory && !is_lost {
                // Under the hypothesis that everything known was false, the reading by which the robot's place was found anew is the first witness in
                // support.
                weighed.note(witnesses);
            }
        }
        self.drop_refuted();
        self.end_doubt_when_decided();
        n_against == n_hypotheses
    }

    /// Drops hypotheses that leave no pose or that two witnesses (markers or readings) contradict; the last hypothesis stays, whatever contradicts
    /// it.
    fn drop_refuted(&mut self) {
        let is_empty = |hypothesis: usize| self.ring.last().is_some_and(|last| last.unions[hypothesis].is_empty());
        let mut dropped: Vec<usize> = Vec::new();
        for (index, hypothesis) in self.hypotheses.iter().enumerate() {
            // The hypothesis that everything known is false is kept: it leaves no pose until a reading shows a marker, whose place the map gives, and
            // it begins anew at any reading of markers that contradicts it.
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

    /// Ends the doubt about an assumption once two witnesses (markers or readings) support one hypothesis about what failed, and no other hypothesis
    /// puts the robot elsewhere.
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
        // To leave out readings assumes nothing, so that this is right whichever hypothesis is.
        let supported =
            self.hypotheses.iter().zip(&last.unions).filter(|(one, union)| one.is_supported() && !union.is_empty());
        self.set_aside.extend(supported.flat_map(|(one, _)| &one.misplaced));
        // If everything known before was false, so are the heading fixes and key frames of that time, and what was learnt from them.
        if hypothesis.failed == Failed::Memory {
            self.fixes.iter_mut().for_each(HeadingFixes::forget);
            self.earlier.forget_fixes();
            self.graph.clear();
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

    /// Whether, under one hypothesis, the motion by the wheels leads from the pose union at the last image before the constraint to poses that the
    /// constraint allows.
    fn agrees_with_wheels(&self, hypothesis: usize, constraint: &Constraint) -> bool {
        let Some(before) = self.ring.image_before(constraint.stamp_s) else { return false };
        self.carried(&before.unions[hypothesis], before.stamp_s, constraint.stamp_s, false)
            .is_some_and(|predicted| !self.hypotheses[hypothesis].contracted(&predicted, constraint).is_empty())
    }

    /// Lets the methods unlearn what they learnt in the last seconds. A push by less than the pose box's width may go unnoticed for a long time,
    /// while methods learn from false poses; so if unlearning was not enough, it goes twice as far back the next time. Returns the stamp of the first
    /// constraint that was recomputed, or infinity if none was.
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

    /// Lets the methods unlearn what they learnt since `since_s`, and recomputes the stored constraints that relied on it. Returns the stamp of the
    /// first of these constraints, or infinity if there is none.
    fn unlearn_since(&mut self, since_s: f64) -> f64 {
        let mut first_s = f64::INFINITY;
        self.go_back(since_s);
        self.tell_wheels_of_gyro();
        self.graph.forget_since(since_s);
        // Readings that are held were carried by a motion of the robot that may be false, and understood from poses that may be.
        self.windows.iter_mut().for_each(Window::clear);
        for method in &self.methods {
            let name = method.name();
            let Some(memory) = method.memory() else { continue };
            for slot in self.ring.iter_mut() {
                let hung = slot.constraint.as_mut().filter(|hung| hung.method == name);
                let Some(constraint) = hung else { continue };
                if let Some(on_pose) = constraint.shown.as_ref().and_then(|shown| memory.on_pose_again(shown)) {
                    constraint.on_pose = on_pose;
                    first_s = first_s.min(slot.stamp_s);
                }
            }
        }
        first_s
    }
}

/// A start whose heading is wider than half a turn, divided into equal sectors of heading, because a contractor of poses narrows headings only within a
/// part of a turn; any other start as it is.
pub(super) fn in_sectors(start: PoseBox) -> PoseUnion {
    let heading = start[2];
    let n_sectors = HEADINGS as f64 * heading.width() / std::f64::consts::TAU;
    if heading.width() <= std::f64::consts::PI || n_sectors > MOST_TURNS * HEADINGS as f64 {
        return PoseUnion::single(start);
    }
    // A whole turn is as many sectors as where a robot is searched for, though its width is rounded up.
    let n_sectors = (n_sectors - 1e-6).ceil();
    let sector_rad = heading.width() / n_sectors;
    let sectors = (0..n_sectors as usize).map(|sector| {
        let centre_rad = heading.lo() + (sector as f64 + 0.5) * sector_rad;
        let sector = Interval::centred(centre_rad, 0.5 * sector_rad + 1e-9);
        IntervalBox::from([start[0], start[1], sector.intersect(heading)])
    });
    PoseUnion { branches: sectors.collect() }
}
