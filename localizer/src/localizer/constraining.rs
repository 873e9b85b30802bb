//! Constraints: methods read an image or another reading, and their constraints are applied at the reading's own stamp.

use std::sync::Arc;

use interval::Interval;

use crate::{
    Constraint, PoseUnion, Reading,
    method::{Context, Memory, Restricts, Shown},
    reading::LandmarkId,
};

use super::{
    Account, Dropped, Localizer, Observed,
    moves::{motion_between, stray_about},
    naming,
    relating::Relating,
    ring::Slot,
};

impl Localizer {
    /// Lets every method read an image or other reading, and applies the resulting constraints at the reading's own stamp.
    pub(super) fn look(&mut self, reading: &Reading) -> Observed {
        let stamp_s = reading.measured_s();
        if !self.methods.iter().any(|method| method.reads(reading)) {
            return Observed::dropped(Dropped::UnknownDevice);
        }
        let Some(prior) = self.union_at(stamp_s) else {
            return Observed::dropped(Dropped::for_want_of_pose(stamp_s, self.now_s, self.doubts.ended_s));
        };
        let mut accounts = Vec::new();
        for idx in 0..self.methods.len() {
            if !self.methods[idx].reads(reading) {
                continue;
            }
            let Some(constraint) = self.constrain(idx, reading, &prior) else {
                accounts.push(Account::absent(self.methods[idx].name(), prior.clone()));
                continue;
            };
            let constraint = match constraint.restricts {
                Restricts::Heading => self.on_a_reading(constraint),
                Restricts::Pose => constraint,
            };
            let (hung_s, source, shown) = (constraint.stamp_s, constraint.method, constraint.shown.clone());
            let relations = constraint.relations.clone();
            let device = device(reading, constraint.method);
            let mut account = self.hang(constraint, device, prior.clone());
            let fixed = self.ring.at(hung_s).map_or(Interval::EMPTY, |slot| slot.merged().hull()[2]);
            if hung_s != stamp_s {
                account.posterior = self.union_at(stamp_s).unwrap_or_default();
            }
            account.landmarks = self.learn(idx, shown.as_ref(), &account.posterior);
            let contradicts = |memory: &mut dyn Memory| memory.take_contradiction();
            let is_sound =
                self.learn_heading(hung_s, fixed) && !self.methods[idx].memory_mut().is_some_and(contradicts);
            if !is_sound && !self.is_doubted() {
                self.begin_doubt(None);
            }
            let posterior = self.ring.at(hung_s).map(Slot::merged).unwrap_or_default();
            self.relate(hung_s, &posterior, relations.map(|relations| Relating { source, relations, shown }));
            accounts.push(account);
        }
        Observed::used(accounts)
    }

    /// The constraint that a method makes of a reading and of its earlier ones that are held; `prior` encloses the pose at the reading's stamp. What the
    /// reading showed is held for later ones.
    fn constrain(&mut self, method: usize, reading: &Reading, prior: &PoseUnion) -> Option<Constraint> {
        let stamp_s = reading.measured_s();
        let twist = self.wheels.twist(stamp_s, &self.robot.wheels);
        let (wheels, robot, is_doubted) = (&self.wheels, &self.robot, self.is_doubted());
        let (slip, fixes, doubt_ended_s) = (&self.slip, &self.fixes, self.doubts.ended_s);
        let motion = |from_s: f64, to_s: f64| {
            // For a time span that began during a doubt or before it, the wheels are not used, because their bounds may be the assumption that
            // failed.
            let doubted = is_doubted || from_s < doubt_ended_s;
            let motion = motion_between(wheels, robot, slip, doubted, [from_s, to_s]);
            let Some(fixes) = fixes else { return motion };
            // With heading fixes, gyroscope readings are remembered for longer than wheel readings. For a span that only they cover, the limits
            // of motion bound the displacement, and the gyroscope gives the turn.
            let mut motion = motion.unwrap_or_else(|| wheels.reach_motion(from_s, to_s, &robot.reach));
            let turn =
                if doubted { fixes.turn_if_pushed(from_s, to_s, &robot.reach) } else { fixes.turn(from_s, to_s) };
            motion[2] = motion[2].intersect(turn?);
            Some(motion)
        };
        let earlier = self.windows[method].carried_to(stamp_s, &motion);
        let stray = |stamp_s, error_s| stray_about(wheels, robot, slip, doubt_ended_s, [stamp_s, error_s]);
        let (earlier, set_aside) = (earlier.as_slice(), self.set_aside.as_slice());
        let context = Context { prior, twist: &twist, motion: &motion, stray: &stray, earlier, set_aside };
        let constraint = self.methods[method].constrain(reading, &context)?;
        if let Some(shown) = constraint.shown.as_ref().filter(|_| constraint.is_held) {
            self.windows[method].hold(stamp_s, Arc::clone(shown));
        }
        Some(constraint)
    }

    /// Lets a method learn from what a reading showed; returns the landmarks that it knows then.
    fn learn(
        &mut self,
        method: usize,
        shown: Option<&Shown>,
        posterior: &PoseUnion,
    ) -> Vec<(LandmarkId, [Interval; 2])> {
        let is_doubted = self.is_doubted();
        let Some(memory) = self.methods[method].memory_mut() else { return Vec::new() };
        if let Some(shown) = shown {
            memory.learn(shown, Some(posterior).filter(|_| !is_doubted));
        }
        memory.landmarks()
    }

    /// The landmarks that all methods have learnt.
    pub(super) fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.landmarks()).collect()
    }

    /// Stores a constraint in a slot at its stamp, and recomputes all stored pose unions from there on. `prior` is the pose union at the stamp before
    /// the constraint is applied.
    fn hang(&mut self, mut constraint: Constraint, device: &'static str, prior: PoseUnion) -> Account {
        let stamp_s = constraint.stamp_s;
        if self.is_doubted() {
            // While an assumption is doubted, the earlier readings behind a constraint were carried by the robot's limits of motion alone, which are
            // not doubted. So the whole constraint is used, not only the part from its own reading.
            constraint.by_itself = None;
        }
        let mut account = Account::of(&constraint, prior);
        for assumption in &constraint.relies_on {
            if !self.relies_on.contains(assumption) {
                self.relies_on.push(assumption);
            }
        }
        let witnesses = self.witnesses(&constraint);
        let evidence = self.evidence(&constraint, &witnesses);
        let unions = vec![PoseUnion::default(); self.hypotheses.len()];
        self.ring.insert(Slot {
            stamp_s,
            unions,
            constraint: Some(constraint),
            related: None,
            witnesses,
            device,
            narrows: [false; 3],
        });
        let from_s = stamp_s.min(self.stale_s);
        self.stale_s = f64::INFINITY;
        account.emptied = match evidence {
            None => self.replay_all(from_s),
            Some(evidence) => self.weigh(evidence, from_s),
        };
        // Old slots are removed only after the new slot was predicted from the slot before it, because that slot may be older than the time for which
        // slots are kept.
        self.ring.forget();
        account.posterior = self.ring.at(stamp_s).map(Slot::merged).unwrap_or_default();
        let (before, after) = (account.prior.hull(), account.posterior.hull());
        if let Some(slot) = self.ring.iter_mut().find(|slot| slot.stamp_s == stamp_s && slot.constraint.is_some()) {
            slot.narrows = [0, 1, 2].map(|axis| naming::is_narrower(after[axis], before[axis]));
        }
        self.restart_integral();
        self.predict();
        account
    }
}

/// Name of the device that a reading is of, as in the names of bounds. For a device of no kind of its own it is the name of the method that reads it.
fn device(reading: &Reading, method: &'static str) -> &'static str {
    match reading {
        Reading::Wheels { .. } => "wheels",
        Reading::Gyro { .. } => "gyro",
        Reading::Flow { .. } => "flow",
        Reading::Range { .. } => "range_camera",
        Reading::Camera { camera, .. } => camera.device(),
        Reading::Other { .. } => method,
    }
}
