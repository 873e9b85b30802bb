//! The localizer. It keeps a ring of slots, each with the pose union at one stamp of the recent past; predicts the pose from wheel readings; applies
//! the constraint from each image or other reading at that reading's own stamp; and gives an account of what came of it.

mod account;
mod after_turn;
mod base_clock;
mod carrying;
mod doubt;
mod heading_fixes;
mod hypothesis;
mod learning;
mod moves;
mod naming;
mod observed;
mod relating;
mod ring;
mod slip;

use interval::Interval;

use crate::{
    Constraint, Map, Method, PoseBox, PoseUnion, Reading, RobotModel,
    bounds::Assumption,
    method::{Context, Memory},
    motion::{Agreement, Motion, SlipExcess, WheelHistory, WheelIntegral, agree, moved_union, reach_motion},
    reading::LandmarkId,
};

pub use account::Account;
use base_clock::BASE_STAMP;
use doubt::Doubts;
use heading_fixes::HeadingFixes;
use hypothesis::{Failed, Hypothesis};
use moves::{REACH, apart_s, assumptions, memory_s, motion_between, motion_history};
pub use naming::Contradiction;
use naming::{Intersected, Naming};
pub use observed::{Dropped, Observed};
use relating::Graph;
pub use relating::PoseWidth;
use ring::{Ring, Slot};
use slip::CertifiedSlip;

/// Age, in seconds, up to which a reading's stamp is accepted: an older reading is refused, and stored pose unions are recomputed no further back.
const REMEMBER_S: f64 = 3.0;
/// Time difference below which two times count as the same instant: periods are decimal numbers, which binary stamps represent only nearly.
const SAME_S: f64 = 1e-9;
/// Whether an estimate relies on its declared assumptions alone, or one of these is doubted because of a contradiction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No assumption is doubted.
    Sound,
    /// An empty intersection proved that an assumption failed, but not which. The pose union grows by the robot's physical limits of motion until
    /// enough readings agree on the pose.
    Recovering,
}

/// The estimate of the pose at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The instant that the estimate is for.
    pub time_s: f64,
    /// Union of boxes of which at least one contains the robot's pose.
    pub pose: PoseUnion,
    /// Whether an assumption is doubted.
    pub status: Status,
    /// The declared bounds that the estimate relies on.
    pub relies_on: Vec<Assumption>,
    /// The latest contradiction between readings whose names were found: bounds of which not all can be true.
    pub contradicting: Option<Contradiction>,
}

/// Turns sensor readings into estimates of the pose.
pub struct Localizer {
    map: Map,
    robot: RobotModel,
    methods: Vec<Box<dyn Method>>,
    wheels: WheelHistory,
    ring: Ring,
    /// Motion by the wheels, integrated since the stamp of the latest stored pose union.
    integral: Option<WheelIntegral>,
    current: PoseUnion,
    /// Time of the latest pose estimate that was not empty, and the interval of its headings.
    known_heading: (f64, Interval),
    now_s: f64,
    /// Hypotheses about which assumption failed; every stored slot has a pose union for each of them. Unless an assumption is doubted there is one
    /// hypothesis: that nothing failed.
    hypotheses: Vec<Hypothesis>,
    /// When the last doubt about an assumption ended, and how far back it reached.
    doubts: Doubts,
    /// Time spans in which wheels and flow sensor contradicted each other, which proves that the wheels slipped.
    slip: CertifiedSlip,
    /// Earliest stamp of a gyroscope or flow reading that arrived after poses at later stamps had been predicted without it; infinite if there is
    /// none.
    stale_s: f64,
    relies_on: Vec<Assumption>,
    /// Heading fixes (headings known at single stamps) from which the gyroscope's bias is learnt; `None` if the bias is not learnt.
    fixes: Option<HeadingFixes>,
    /// Key frames of the drive, with what relates them.
    graph: Graph,
    /// The names of the latest contradiction, and the work on them.
    naming: Naming,
    /// The wheel encoders' latest count, and the time since which they have had that count.
    at_rest: Option<(f64, [i64; 2])>,
    /// Greatest error of the stamps of wheels, gyroscope and flow sensor.
    base_stamp_error_s: f64,
}

impl Localizer {
    /// A localizer for a robot whose pose at time 0 is within the box `start`.
    pub fn new(map: Map, robot: RobotModel, methods: Vec<Box<dyn Method>>, start: PoseBox) -> Self {
        let mut localizer = Localizer {
            wheels: motion_history(&robot),
            slip: CertifiedSlip::new(memory_s(&robot)),
            known_heading: (0.0, start[2]),
            relies_on: assumptions(&robot),
            graph: Graph::new(&robot),
            map,
            robot,
            methods,
            ring: Ring::new(REMEMBER_S),
            integral: None,
            current: PoseUnion::default(),
            now_s: 0.0,
            hypotheses: vec![Hypothesis::new(Failed::Nothing)],
            doubts: Doubts::default(),
            stale_s: f64::INFINITY,
            fixes: None,
            naming: Naming::default(),
            at_rest: None,
            base_stamp_error_s: 0.0,
        };
        localizer.begin_at(start);
        localizer
    }

    /// Restarts the localizer for a robot whose pose is within the box `start`, with the clock set back to 0: nothing is kept but what the methods
    /// have learnt.
    pub fn restart(&mut self, start: PoseBox) {
        self.wheels = motion_history(&self.robot);
        self.ring = Ring::new(REMEMBER_S);
        self.graph.clear();
        self.naming = Naming::default();
        self.integral = None;
        self.at_rest = None;
        self.now_s = 0.0;
        self.hypotheses = vec![Hypothesis::new(Failed::Nothing)];
        self.doubts = Doubts::default();
        self.slip = CertifiedSlip::new(memory_s(&self.robot));
        self.stale_s = f64::INFINITY;
        self.relies_on = assumptions(&self.robot);
        self.memories().for_each(|memory| memory.clock_set_back());
        self.begin_at(start);
        self.begin_fixes();
    }

    /// Announces the time spans of the coming drive in which the wheels slip by more than declared. They are known only when a run is simulated again
    /// to find the cause of a failure.
    pub fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.wheels.expect_slip(excesses);
    }

    fn begin_at(&mut self, start: PoseBox) {
        self.known_heading = (0.0, start[2]);
        self.current = self.inside_room(PoseUnion::single(start));
        self.ring.push(Slot::anchor(0.0, vec![self.current.clone()]));
    }

    /// Processes one sensor reading; readings have to come in order of arrival. Returns what became of it: for each method that used the reading an
    /// account of what came of it, or why the reading was dropped.
    pub fn observe(&mut self, reading: &Reading) -> Observed {
        if !reading.is_finite() {
            return Observed::dropped(Dropped::NotFinite);
        }
        match reading {
            Reading::Wheels { measured_s, ticks, .. } => Observed::of_motion(Some(self.roll(*measured_s, *ticks))),
            Reading::Gyro { measured_s, rate_rad_per_s, .. } => {
                let is_new = self.wheels.push_rate(*measured_s, *rate_rad_per_s);
                self.note_late(*measured_s);
                if let Some(fixes) = &mut self.fixes {
                    fixes.read(*measured_s, *rate_rad_per_s);
                }
                Observed::of_motion(is_new)
            }
            Reading::Flow { measured_s, counts, blind_periods, .. } => {
                let is_new = self.wheels.push_flow(*measured_s, *counts, *blind_periods);
                self.note_late(*measured_s);
                Observed::of_motion(is_new)
            }
            Reading::Camera { .. } | Reading::Range { .. } | Reading::Other { .. } => self.look(reading),
        }
    }

    /// The pose estimate at the time of the latest wheel reading.
    pub fn estimate(&self) -> Estimate {
        let status = if self.is_doubted() { Status::Recovering } else { Status::Sound };
        let mut relies_on = self.relies_on.clone();
        if self.base_stamp_error_s > 0.0 {
            relies_on.push(BASE_STAMP);
            relies_on.extend(REACH.into_iter().filter(|assumption| !self.relies_on.contains(assumption)));
        }
        let contradicting = self.naming.latest.clone();
        Estimate { time_s: self.now_s, pose: self.in_true_time(&self.current), status, relies_on, contradicting }
    }

    /// The pose estimate at a given instant. If the latest wheel reading is older, as when readings come late, the pose is carried on by the motion
    /// that the wheels can have made since. If it is much older, or while the wheels are doubted, only the robot's physical limits of motion (its
    /// reach) bound that motion.
    pub fn estimate_at(&self, time_s: f64) -> Estimate {
        let mut estimate = self.estimate();
        if time_s <= self.now_s + SAME_S {
            return estimate;
        }
        // The time since the latest wheel reading is rounded up to whole microseconds: the same instant, counted from another time zero, differs in
        // its last digits, by which the estimate shall not differ.
        let span_s = ((time_s - self.now_s) * 1e6).ceil() * 1e-6;
        let motion = self.wheels.reach_motion(self.now_s, self.now_s + span_s, &self.robot.reach);
        let within_reach = self.inside_room(moved_union(&estimate.pose, &motion));
        let rolled = self.ring.before(self.now_s).and_then(|slot| self.explained_at(slot, self.now_s + span_s));
        // Rounding the time up carries the pose up to 1 µs past the requested instant. The motion that is possible in 1 µs at the robot's greatest
        // speed and turn rate is added, so that the boxes hold at that instant.
        let rounded = reach_motion(1e-6, &self.robot.reach);
        let both = rolled.map(|rolled| self.in_true_time(&moved_union(&rolled, &rounded)).common(&within_reach));
        // If the prediction by the wheels and that by the limits of motion have no pose in common, wheels or gyroscope are wrong, which the next
        // wheel reading will show. Until then the limits of motion alone are used.
        estimate.pose = both.filter(|both| !both.is_empty()).unwrap_or(within_reach);
        estimate.time_s = time_s;
        let reach: Vec<Assumption> =
            REACH.into_iter().filter(|assumption| !estimate.relies_on.contains(assumption)).collect();
        estimate.relies_on.extend(reach);
        estimate
    }

    /// Takes in a wheel reading and predicts the pose union up to its stamp. Returns whether the reading is newer than those before.
    fn roll(&mut self, time_s: f64, ticks: [i64; 2]) -> bool {
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
        self.work_on_graph();
        self.work_on_names();
        true
    }

    /// Notes that a gyroscope or flow reading arrived after poses at later stamps had been predicted, so that they are predicted again with it.
    fn note_late(&mut self, measured_s: f64) {
        if self.ring.last().is_some_and(|last| measured_s < last.stamp_s - SAME_S) {
            self.stale_s = self.stale_s.min(measured_s);
        }
    }

    /// Predicts the current pose union from the latest stored union whose stamp is not after the latest wheel reading. Without an integral since that
    /// stamp the wheel readings in memory begin later, and bound only a part of the motion.
    fn predict(&mut self) {
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
            self.graph.clear();
            self.ring.forget_relations();
            self.replay_all(from_s - slip::UNSEEN_S);
        }
    }

    /// Stores the present pose union as a slot without an image if the latest slot is older than [`apart_s`]. The additive part of the slip bound is
    /// then counted afresh from the new slot.
    fn anchor_when_due(&mut self) {
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

    /// Lets every method read an image or other reading, and applies the resulting constraints at the reading's own stamp.
    fn look(&mut self, reading: &Reading) -> Observed {
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
            let constraint = if constraint.heading_only { self.on_a_reading(constraint) } else { constraint };
            let (hung_s, relations) = (constraint.stamp_s, constraint.relations.clone());
            let device = device(reading, constraint.method);
            let mut account = self.hang(constraint, device, prior.clone());
            let fixed = self.ring.at(hung_s).map_or(Interval::EMPTY, |slot| slot.merged().hull()[2]);
            if hung_s != stamp_s {
                account.posterior = self.union_at(stamp_s).unwrap_or_default();
            }
            account.landmarks = self.learn(idx, &account.posterior);
            let contradicts = |memory: &mut dyn Memory| memory.take_contradiction();
            let is_sound =
                self.learn_heading(hung_s, fixed) && !self.methods[idx].memory_mut().is_some_and(contradicts);
            if !is_sound && !self.is_doubted() {
                self.begin_doubt(None);
            }
            let posterior = self.ring.at(hung_s).map(Slot::merged).unwrap_or_default();
            self.relate(hung_s, &posterior, relations);
            accounts.push(account);
        }
        Observed::used(accounts)
    }

    /// The constraint that a method makes of a reading; `prior` encloses the pose at its stamp.
    fn constrain(&mut self, method: usize, reading: &Reading, prior: &PoseUnion) -> Option<Constraint> {
        let twist = self.wheels.twist(reading.measured_s(), &self.robot.wheels);
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
        self.methods[method].constrain(reading, &Context { prior, twist: &twist, motion: &motion })
    }

    /// Lets a method learn from the reading that it constrained last, unless an assumption is doubted; returns the landmarks that it knows then.
    fn learn(&mut self, method: usize, posterior: &PoseUnion) -> Vec<(LandmarkId, [Interval; 2])> {
        let is_doubted = self.is_doubted();
        let (wheels, robot, slip, doubt_ended_s) = (&self.wheels, &self.robot, &self.slip, self.doubts.ended_s);
        let Some(memory) = self.methods[method].memory_mut() else { return Vec::new() };
        if !is_doubted {
            memory.learn(posterior, &|from_s, to_s| {
                motion_between(wheels, robot, slip, false, [from_s, to_s]).filter(|_| from_s >= doubt_ended_s)
            });
        }
        memory.landmarks()
    }

    /// The landmarks that all methods have learnt.
    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.landmarks()).collect()
    }

    /// What the methods keep from one reading to the next.
    fn memories(&mut self) -> impl Iterator<Item = &mut dyn Memory> {
        self.methods.iter_mut().filter_map(|method| method.memory_mut())
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

    /// Sets the current pose union; unless the union is empty, its heading becomes the last known heading.
    fn answer(&mut self, union: PoseUnion) {
        let heading = union.hull()[2];
        if !heading.is_empty() {
            self.known_heading = (self.now_s, heading);
        }
        self.current = union;
    }

    fn restart_integral(&mut self) {
        self.integral = self
            .ring
            .last()
            .and_then(|last| self.wheels.integrate_from(last.stamp_s, &self.robot.wheels, &self.robot.reach));
    }

    /// Whether an assumption is doubted.
    fn is_doubted(&self) -> bool {
        self.hypotheses[0].failed != Failed::Nothing
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
