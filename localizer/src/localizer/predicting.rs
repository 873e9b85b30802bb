//! Prediction: from a stored pose union on, the motion by wheels, gyroscope and flow sensor gives the pose union at each wheel reading.

use crate::{
    PoseUnion,
    motion::{Agreement, Motion, agree, moved_union},
};

use super::{
    Localizer, SAME_S,
    moves::{REACH, apart_s},
    naming::Intersected,
    ring::Slot,
    slip,
};

impl Localizer {
    /// Takes in a wheel reading and predicts the pose union up to its stamp. Returns whether the reading is newer than those before.
    pub(super) fn roll(&mut self, time_s: f64, ticks: [i64; 2]) -> bool {
        let is_first = self.wheels.latest().is_none();
        let before_s = self.wheels.latest().map_or(0.0, |before| before.time_s);
        if !self.wheels.push(time_s, ticks) {
            return false;
        }
        if is_first && time_s > SAME_S {
            // The motion up to the first wheel reading that came is known by the robot's limits of speed and turn rate alone.
            self.relies_on
                .extend(REACH.into_iter().filter(|bound| !self.relies_on.contains(bound)).collect::<Vec<_>>());
        }
        self.now_s = time_s;
        let Some(sample) = self.wheels.latest().copied() else { return false };
        if let Some(integral) = &mut self.integral {
            self.wheels.advance(integral, &sample, &self.robot.wheels, &self.robot.reach);
        } else {
            self.restart_integral();
        }
        // Poses at the stamps of readings that arrived before this wheel reading were predicted from the earlier wheel reading by the robot's limits
        // of speed and turn rate. This wheel reading gives the motion up to those stamps, so that the poses are predicted again.
        if self.ring.first_after(before_s).is_some_and(|overtook_s| overtook_s <= time_s) {
            self.replay_all(before_s);
        }
        self.predict();
        self.anchor_when_due();
        self.learn_at_rest(time_s, ticks);
        self.keep_knowledge();
        self.work_on_graph();
        self.work_on_names();
        true
    }

    /// Notes that a gyroscope or flow reading arrived after poses at later stamps had been predicted, so that they are predicted again with it.
    pub(super) fn note_late(&mut self, measured_s: f64) {
        if self.ring.last().is_some_and(|last| measured_s < last.stamp_s - SAME_S) {
            self.stale_s = self.stale_s.min(measured_s);
        }
    }

    /// Predicts the current pose union from the latest stored union whose stamp is not after the latest wheel reading. Without an integral since that
    /// stamp the wheel readings in memory begin later, and bound only a part of the motion.
    pub(super) fn predict(&mut self) {
        let last_s = self.ring.last().map(|last| last.stamp_s).filter(|last_s| *last_s <= self.now_s);
        let last_s = last_s.filter(|_| self.integral.is_some());
        let motion = last_s.filter(|_| !self.is_doubted()).map(|last_s| self.motion_since_last_slot(last_s));
        let predicted = match (motion, self.ring.last()) {
            (Some(motion), Some(last)) if !self.is_doubted() => {
                Some(self.inside_room(moved_union(&last.unions[0], &motion)))
            }
            _ => self.ring.before(self.now_s).and_then(|slot| self.explained_at(slot, self.now_s)),
        };
        let Some(predicted) = predicted else { return };
        self.answer(predicted);
        if self.current.is_empty() {
            // No pose in the room fits the motion by the wheels. As no constraint contradicts, the doubt begins without the hypothesis that a reading
            // is false.
            self.begin_doubt(None);
        }
    }

    /// Motion since the stamp of the latest stored pose union, which is not after the latest wheel reading. The wheels' part comes from an integral
    /// that every wheel reading continues.
    fn motion_since_last_slot(&mut self, stamp_s: f64) -> Motion {
        let span_s = [stamp_s, self.now_s];
        let wheels = self.wheels.model_over(span_s, &self.robot.wheels);
        let rolled = self.integral.as_ref().map(|integral| integral.motion(&wheels));
        let motion = rolled.and_then(|rolled| {
            let flow = self.wheels.flow_motion(stamp_s, self.now_s, &self.robot.wheels, &self.robot.reach);
            if let Agreement::SlipCertified(_) = agree(&rolled, flow.as_ref()) {
                self.certify_slip(span_s);
            }
            self.slip.motion(span_s, Some(rolled), flow, &self.wheels, &self.robot)
        });
        // If the wheels are not trusted, or their readings since the stored pose union's stamp are missing, only the robot's limits of speed and turn
        // rate bound the motion.
        motion.unwrap_or_else(|| self.wheels.reach_motion(stamp_s, self.now_s, &self.robot.reach))
    }

    /// Excludes the wheels from a time span in which they contradict the flow sensor and so are seen to slip, and from some time before it in which
    /// they may have slipped unnoticed. The poses of that time are predicted again.
    fn certify_slip(&mut self, [from_s, now_s]: [f64; 2]) {
        if self.slip.certify([from_s, now_s]) {
            self.note_contradiction(Intersected::WheelsAndFlow, None);
            self.graph.forget_since(from_s - slip::UNSEEN_S);
            self.ring.forget_relations();
            self.replay_all(from_s - slip::UNSEEN_S);
        }
    }

    /// Stores the present pose union as a slot without an image if the latest slot is older than [`apart_s`]. The additive part of the slip bound is
    /// then counted afresh from the new slot.
    pub(super) fn anchor_when_due(&mut self) {
        let due = self.ring.last().is_some_and(|last| self.now_s - last.stamp_s > apart_s(&self.robot) + 1e-6);
        if !due {
            return;
        }
        let unions: Vec<PoseUnion> = if self.is_doubted() {
            let Some(last) = self.ring.last() else { return };
            (0..self.hypotheses.len())
                .map(|hypothesis| self.carried_of(hypothesis, last, self.now_s).unwrap_or_default())
                .collect()
        } else {
            vec![self.as_fixed_before(self.current.clone(), self.now_s)]
        };
        if unions.iter().all(PoseUnion::is_empty) {
            self.begin_doubt(None);
            return;
        }
        let anchor = Slot::anchor(self.now_s, unions);
        let union = anchor.merged();
        self.ring.push(anchor);
        self.restart_integral();
        self.relate(self.now_s, &union, None);
    }

    /// Sets the current pose union; unless the union is empty, its heading becomes the last known heading.
    pub(super) fn answer(&mut self, union: PoseUnion) {
        let heading = union.hull()[2];
        if !heading.is_empty() {
            self.known_heading = (self.now_s, heading);
        }
        self.current = union;
    }

    pub(super) fn restart_integral(&mut self) {
        self.integral = self
            .ring
            .last()
            .and_then(|last| self.wheels.integrate_from(last.stamp_s, &self.robot.wheels, &self.robot.reach));
    }
}
