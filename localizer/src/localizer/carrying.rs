//! Prediction of the pose unions of slots (the stamped entries of the localizer's ring), and their recomputation when a reading about the past
//! arrives.

use interval::{Interval, IntervalBox};

use crate::{PoseBox, PoseUnion, motion::moved_union};

use super::{
    Localizer, REMEMBER_S,
    hypothesis::Failed,
    moves::motion_between,
    ring::{self, Slot},
};

impl Localizer {
    /// Pose union at a past stamp; `None` if the stamp is older than the localizer remembers, or lies before the end of the last doubt (the time in
    /// which it was not known which assumption had failed).
    pub(super) fn union_at(&self, stamp_s: f64) -> Option<PoseUnion> {
        if stamp_s < self.doubts.ended_s.max(self.now_s - REMEMBER_S) {
            return None;
        }
        self.explained_at(self.ring.before(stamp_s)?, stamp_s)
    }

    /// Pose union of a stored slot, carried to a later stamp by the robot's motion. It is merged from the pose unions of all hypotheses about which
    /// assumption failed.
    pub(super) fn explained_at(&self, slot: &Slot, stamp_s: f64) -> Option<PoseUnion> {
        let carried: Option<Vec<PoseUnion>> =
            (0..self.hypotheses.len()).map(|hypothesis| self.carried_of(hypothesis, slot, stamp_s)).collect();
        Some(ring::merged(&carried?))
    }

    /// The pose union that one hypothesis about what failed has in a stored slot, carried to a later stamp by the robot's motion.
    pub(super) fn carried_of(&self, hypothesis: usize, slot: &Slot, stamp_s: f64) -> Option<PoseUnion> {
        let by_reach_s = self.hypotheses[hypothesis].by_reach_s();
        self.carried_past(&slot.unions[hypothesis], [slot.stamp_s, stamp_s], by_reach_s)
    }

    /// A pose union carried from one stamp to a later one by the motion that the wheels give before and after the span `by_reach_s`. Within that span,
    /// and where the remembered wheel readings do not cover the time, the robot's limits of speed and turn rate bound the motion.
    pub(super) fn carried_past(
        &self,
        union: &PoseUnion,
        [from_s, to_s]: [f64; 2],
        by_reach_s: [f64; 2],
    ) -> Option<PoseUnion> {
        self.wheels.latest()?;
        let [reach_from_s, reach_to_s] = by_reach_s.map(|cut_s| cut_s.max(from_s).min(to_s));
        let parts_s = [[from_s, reach_from_s], [reach_from_s, reach_to_s], [reach_to_s, to_s]];
        let mut carried = union.clone();
        for (part, [from_s, to_s]) in parts_s.into_iter().enumerate().filter(|(_, [from_s, to_s])| from_s < to_s) {
            let rolled = self.carried(&carried, from_s, to_s, part == 1);
            carried = rolled.or_else(|| self.carried(&carried, from_s, to_s, true))?;
        }
        Some(carried)
    }

    /// A pose union carried from one stamp to a later one by the motion that the wheels give, or, while the wheels are doubted after a contradiction,
    /// by the robot's limits of speed and turn rate; `None` if the remembered wheel readings do not cover the time between.
    pub(super) fn carried(&self, union: &PoseUnion, from_s: f64, to_s: f64, doubted: bool) -> Option<PoseUnion> {
        let (earliest_s, latest_s) = (self.wheels.earliest_s()?, self.wheels.latest()?.time_s);
        if doubted {
            let motion = self.wheels.reach_motion(from_s, to_s, &self.robot.reach);
            return Some(self.inside_room(moved_union(union, &motion)));
        }
        if to_s == from_s {
            return Some(union.clone());
        }
        match motion_between(&self.wheels, &self.robot, &self.slip, false, [from_s, to_s]) {
            Some(motion) => Some(self.as_fixed_before(self.inside_room(moved_union(union, &motion)), to_s)),
            // The wheel readings in memory begin after the earlier stamp, as when the first ones of a drive were lost; the robot's limits of speed and
            // turn rate bound the motion up to the first of them.
            None if from_s < earliest_s && earliest_s <= to_s => {
                let begun = self.carried(union, from_s, earliest_s, true)?;
                self.carried(&begun, earliest_s, to_s, false)
            }
            // The later stamp is far ahead of the wheel readings, which give the motion up to the last of them; the robot's limits of speed and turn
            // rate bound the motion from there on.
            None if to_s > latest_s.max(from_s) => {
                let known = self.carried(union, from_s, latest_s.max(from_s), false)?;
                self.carried(&known, latest_s.max(from_s), to_s, true)
            }
            None => None,
        }
    }

    /// Recomputes the pose union of every stored slot from `from_s` on, for every hypothesis about what failed. Returns whether a constraint thereby
    /// shows that an assumption failed; always `false` while an assumption is doubted already.
    pub(super) fn replay_all(&mut self, from_s: f64) -> bool {
        if self.is_doubted() {
            (0..self.hypotheses.len()).for_each(|hypothesis| {
                self.replay(hypothesis, from_s);
            });
            return false;
        }
        let contradiction = self.replay(0, from_s).first().copied();
        if contradiction.is_some() {
            self.begin_doubt(contradiction);
        }
        contradiction.is_some()
    }

    /// Recomputes, for one hypothesis about what failed, the pose union in every stored slot from `from_s` on. Returns the stamps of the constraints
    /// that leave no pose; they are not applied. The hypothesis that everything known is false begins anew with the poses that such a constraint
    /// allows in the room, if it shows a marker. Under the hypothesis that nothing failed, the recomputation stops at the first of them.
    pub(super) fn replay(&mut self, hypothesis: usize, from_s: f64) -> Vec<f64> {
        let failed = self.hypotheses[hypothesis].failed;
        let mut contradicting = Vec::new();
        let Some(first) = self.ring.index_at(from_s.max(self.doubts.ended_s)) else { return contradicting };
        for index in first.max(1)..self.ring.len() {
            let (before, slot) = (&self.ring[index - 1], &self.ring[index]);
            let Some(predicted) = self.carried_of(hypothesis, before, slot.stamp_s) else { continue };
            let contracted = match &slot.constraint {
                Some(constraint) if failed == Failed::Memory && predicted.is_empty() => self.located(constraint),
                Some(constraint) if !self.hypotheses[hypothesis].disbelieves(&slot.witnesses) => {
                    self.hypotheses[hypothesis].contracted(&predicted, constraint)
                }
                _ => predicted.clone(),
            };
            let contracted = match (failed, &slot.related) {
                (Failed::Nothing, Some(related)) => contracted.common(related),
                _ => contracted,
            };
            if contracted.is_empty() && !(predicted.is_empty() && failed != Failed::Nothing) {
                contradicting.push(slot.stamp_s);
                let anew = match (failed, &slot.constraint) {
                    (Failed::Nothing, _) => return contradicting,
                    (Failed::Memory, Some(constraint)) => self.located(constraint),
                    _ => PoseUnion::default(),
                };
                self.ring[index].unions[hypothesis] = if anew.is_empty() { predicted } else { anew };
            } else {
                self.ring[index].unions[hypothesis] = contracted;
            }
        }
        contradicting
    }

    /// The part of a pose union in which the robot's body does not overlap a wall.
    pub(super) fn inside_room(&self, union: PoseUnion) -> PoseUnion {
        let room = self.whole_room();
        let mut branches: Vec<PoseBox> = union.branches.iter().map(|branch| branch.intersect(&room)).collect();
        branches.retain(|branch| !branch.is_empty());
        PoseUnion { branches }.without_repeats()
    }

    pub(super) fn whole_room(&self) -> PoseBox {
        let keep_m = self.robot.body.clearance_m;
        let [x, y] = self.map.room_m.map(|range| Interval::new(range.lo() + keep_m, range.hi() - keep_m));
        IntervalBox::from([x, y, Interval::ENTIRE])
    }
}
