//! The ring of stamped pose unions: predict, hang, contract, account.

mod account;
mod after_turn;
mod base_clock;
mod doubt;
mod heading_fixes;
mod learning;
mod moves;
mod ring;
mod slip;

use crate::{
    Constraint, Interval, IntervalBox, Map, Method, PoseBox, PoseUnion, Reading, RobotModel,
    contractor::Contractor,
    method::Assumption,
    motion::{Agreement, WheelHistory, WheelIntegral, agree, moved_union},
};

pub use account::Account;
use base_clock::BASE_STAMP;
use doubt::Doubt;
use heading_fixes::HeadingFixes;
use moves::{REACH, assumptions, motion_between, motion_history};
use ring::{Ring, Slot};
use slip::CertifiedSlip;

/// How far back stamps may lie: a reading older than this is refused, and readings are gone over again no further back.
const REMEMBER_S: f64 = 3.0;
/// Times closer than this are the same instant: periods are decimal, stamps binary.
const SAME_S: f64 = 1e-9;
/// Whether the estimate stands on its declared assumptions alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No assumption is doubted.
    Sound,
    /// An empty intersection certified that an assumption failed; the union grows by reach until enough images agree.
    Recovering,
}

/// The answer at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The time it speaks of.
    pub time_s: f64,
    /// The pose is in one of these boxes.
    pub pose: PoseUnion,
    /// Whether an assumption is doubted.
    pub status: Status,
    /// The declared bounds it stands on.
    pub relies_on: Vec<Assumption>,
}

/// From readings to estimates.
pub struct Localizer {
    map: Map,
    robot: RobotModel,
    methods: Vec<Box<dyn Method>>,
    wheels: WheelHistory,
    ring: Ring,
    /// The wheels since the ring's last slot.
    integral: Option<WheelIntegral>,
    current: PoseUnion,
    now_s: f64,
    doubt: Option<Doubt>,
    /// When wheels and flow sensor had nothing in common.
    slip: CertifiedSlip,
    /// When methods unlearnt last, and how far back.
    unlearnt: (f64, f64),
    relies_on: Vec<Assumption>,
    /// Where the gyroscope's bias is learnt: what is known of it and of headings before.
    fixes: Option<HeadingFixes>,
    /// The encoders' latest count, and since when it has been.
    at_rest: Option<(f64, [i64; 2])>,
    /// Greatest error of the stamps of wheels, gyroscope and flow sensor.
    base_stamp_error_s: f64,
}

impl Localizer {
    /// A localizer that knows its start within `start` at time 0.
    pub fn new(map: Map, robot: RobotModel, methods: Vec<Box<dyn Method>>, start: PoseBox) -> Self {
        let mut localizer = Localizer {
            wheels: motion_history(&robot),
            relies_on: assumptions(&robot),
            map,
            robot,
            methods,
            ring: Ring::new(REMEMBER_S),
            integral: None,
            current: PoseUnion::default(),
            now_s: 0.0,
            doubt: None,
            slip: CertifiedSlip::default(),
            unlearnt: (0.0, 0.0),
            fixes: None,
            at_rest: None,
            base_stamp_error_s: 0.0,
        };
        localizer.begin_at(start);
        localizer
    }

    /// The robot was put within `start` and the clock set back to 0: nothing carries over but what the methods have learnt.
    pub fn restart(&mut self, start: PoseBox) {
        self.wheels = motion_history(&self.robot);
        self.ring = Ring::new(REMEMBER_S);
        self.integral = None;
        self.at_rest = None;
        self.now_s = 0.0;
        self.doubt = None;
        self.slip = CertifiedSlip::default();
        self.unlearnt = (0.0, 0.0);
        self.relies_on = assumptions(&self.robot);
        self.methods.iter_mut().for_each(|method| method.clock_set_back());
        self.begin_at(start);
        self.begin_fixes();
    }

    fn begin_at(&mut self, start: PoseBox) {
        self.current = self.inside_room(PoseUnion::single(start));
        self.ring.push(Slot { stamp_s: 0.0, union: self.current.clone(), constraint: None });
    }

    /// Takes in one reading; readings come in order of arrival. Answers with an account of each method that read an image.
    pub fn observe(&mut self, reading: &Reading) -> Vec<Account> {
        match reading {
            Reading::Wheels { measured_s, ticks, .. } => {
                self.roll(*measured_s, *ticks);
                Vec::new()
            }
            Reading::Gyro { measured_s, rate_rad_per_s, .. } => {
                self.wheels.push_rate(*measured_s, *rate_rad_per_s);
                if let Some(fixes) = &mut self.fixes {
                    fixes.read(*measured_s, *rate_rad_per_s);
                }
                Vec::new()
            }
            Reading::Flow { measured_s, counts, blind_periods, .. } => {
                self.wheels.push_flow(*measured_s, *counts, *blind_periods);
                Vec::new()
            }
            Reading::Camera { .. } | Reading::Range { .. } => self.look(reading),
        }
    }

    /// The answer as of the latest wheel reading.
    pub fn estimate(&self) -> Estimate {
        let status = if self.doubt.is_some() { Status::Recovering } else { Status::Sound };
        let mut relies_on = self.relies_on.clone();
        if self.base_stamp_error_s > 0.0 {
            relies_on.push(BASE_STAMP);
            relies_on.extend(REACH.into_iter().filter(|assumption| !self.relies_on.contains(assumption)));
        }
        Estimate { time_s: self.now_s, pose: self.in_true_time(&self.current), status, relies_on }
    }

    /// The answer at an instant: where the latest wheel reading is older, as when readings come late, reach bounds the rest.
    pub fn estimate_at(&self, time_s: f64) -> Estimate {
        let mut estimate = self.estimate();
        if time_s <= self.now_s + SAME_S {
            return estimate;
        }
        // Whole microseconds: the same instant counted from another zero has other last digits.
        let span_s = ((time_s - self.now_s) * 1e6).ceil() * 1e-6;
        let motion = self.wheels.reach_motion(self.now_s, self.now_s + span_s, &self.robot.reach);
        estimate.pose = self.inside_room(moved_union(&estimate.pose, &motion));
        estimate.time_s = time_s;
        let reach: Vec<Assumption> =
            REACH.into_iter().filter(|assumption| !estimate.relies_on.contains(assumption)).collect();
        estimate.relies_on.extend(reach);
        estimate
    }

    /// Predicts up to a wheel reading.
    fn roll(&mut self, time_s: f64, ticks: [i64; 2]) {
        if !self.wheels.push(time_s, ticks) {
            return;
        }
        self.now_s = time_s;
        let Some(sample) = self.wheels.latest().copied() else { return };
        if let Some(integral) = &mut self.integral {
            self.wheels.advance(integral, &sample, &self.robot.wheels, &self.robot.reach);
        } else {
            self.restart_integral();
        }
        self.predict();
        self.anchor_when_due();
        self.learn_at_rest(time_s, ticks);
    }

    /// Sets the current union from the last slot.
    fn predict(&mut self) {
        // A slot ahead of the wheels says nothing of now; the next reading will pass it.
        let Some(last) = self.ring.last().filter(|last| last.stamp_s <= self.now_s) else { return };
        let rolled = self.integral.as_ref().map(|integral| integral.motion(&self.robot.wheels));
        let motion = match (rolled, self.doubt) {
            (Some(rolled), None) => {
                let flow = self.wheels.flow_motion(last.stamp_s, self.now_s, &self.robot.wheels, &self.robot.reach);
                if let Agreement::SlipCertified(_) = agree(&rolled, flow.as_ref()) {
                    self.slip.certify([last.stamp_s, self.now_s]);
                }
                self.slip.motion([last.stamp_s, self.now_s], Some(rolled), flow, &self.wheels, &self.robot)
            }
            _ => None,
        };
        // Without wheels to trust, or without their history since the slot, reach is all there is.
        let motion = motion.unwrap_or_else(|| self.wheels.reach_motion(last.stamp_s, self.now_s, &self.robot.reach));
        let predicted = moved_union(&last.union, &motion);
        self.current = self.inside_room(predicted);
        if self.current.is_empty() {
            // No place in the room fits what the wheels told: they are the first to be doubted.
            self.begin_doubt();
        }
    }

    /// Opens a slot when no image has for two slip windows, so that the slip bound is counted afresh.
    fn anchor_when_due(&mut self) {
        let due = self
            .ring
            .last()
            .is_some_and(|last| self.now_s - last.stamp_s > 2.0 * self.robot.wheels.slip_window_s + 1e-6);
        if due {
            let union = self.as_fixed_before(self.current.clone(), self.now_s);
            if union.is_empty() {
                self.begin_doubt();
                return;
            }
            self.ring.push(Slot { stamp_s: self.now_s, union, constraint: None });
            self.restart_integral();
        }
    }

    /// Lets every method read an image and hangs what they answer on the image's own stamp.
    fn look(&mut self, reading: &Reading) -> Vec<Account> {
        let stamp_s = reading.measured_s();
        let Some(prior) = self.union_at(stamp_s) else { return Vec::new() };
        let twist = self.wheels.twist(stamp_s, &self.robot.wheels);
        let mut accounts = Vec::new();
        for idx in 0..self.methods.len() {
            if !self.methods[idx].reads(reading) {
                continue;
            }
            let (wheels, robot, doubted) = (&self.wheels, &self.robot, self.doubt.is_some());
            let (slip, fixes) = (&self.slip, &self.fixes);
            self.methods[idx].carry_to(stamp_s, &|from_s, to_s| {
                let motion = motion_between(wheels, robot, slip, doubted, [from_s, to_s]);
                let Some(fixes) = fixes else { return motion };
                // Headings are remembered for longer than places.
                let mut motion = motion.unwrap_or_else(|| wheels.reach_motion(from_s, to_s, &robot.reach));
                let turn =
                    if doubted { fixes.turn_if_pushed(from_s, to_s, &robot.reach) } else { fixes.turn(from_s, to_s) };
                motion[2] = motion[2].intersect(turn?);
                Some(motion)
            });
            let Some(constraint) = self.methods[idx].constrain(reading, &prior, &twist) else {
                accounts.push(Account::absent(self.methods[idx].name(), prior.clone()));
                continue;
            };
            let heading_only = self.methods[idx].tells_heading_only();
            let constraint = if heading_only { self.on_a_reading(constraint) } else { constraint };
            let hung_s = constraint.stamp_s;
            let mut account = self.hang(constraint, prior.clone());
            let fixed = self.ring.at(hung_s).map_or(Interval::EMPTY, |slot| slot.union.hull()[2]);
            if hung_s != stamp_s {
                account.posterior = self.union_at(stamp_s).unwrap_or_default();
            }
            if self.doubt.is_none() {
                let (wheels, robot, slip) = (&self.wheels, &self.robot, &self.slip);
                self.methods[idx].learn(&account.posterior, &|from_s, to_s| {
                    motion_between(wheels, robot, slip, false, [from_s, to_s])
                });
            }
            account.landmarks = self.methods[idx].landmarks();
            self.learn_heading(hung_s, fixed);
            if self.methods[idx].take_contradiction() && self.doubt.is_none() {
                self.begin_doubt();
            }
            accounts.push(account);
        }
        accounts
    }

    /// What is known of the pose at a past stamp; `None` when it lies outside of the memory or after the last wheel reading.
    fn union_at(&self, stamp_s: f64) -> Option<PoseUnion> {
        let slot = self.ring.before(stamp_s)?;
        self.carried(&slot.union, slot.stamp_s, stamp_s, self.doubt.is_some())
    }

    /// A union carried from one stamp to a later one, by reach when the wheels are doubted.
    fn carried(&self, union: &PoseUnion, from_s: f64, to_s: f64, doubted: bool) -> Option<PoseUnion> {
        let latest_s = self.wheels.latest()?.time_s;
        if !doubted && to_s > latest_s.max(from_s) {
            // An image that overtook the wheels: they tell the way so far, reach bounds the rest.
            let known = self.carried(union, from_s, latest_s.max(from_s), false)?;
            return self.carried(&known, latest_s.max(from_s), to_s, true);
        }
        let motion = if doubted {
            self.wheels.reach_motion(from_s, to_s, &self.robot.reach)
        } else if to_s == from_s {
            return Some(union.clone());
        } else {
            motion_between(&self.wheels, &self.robot, &self.slip, false, [from_s, to_s])?
        };
        let moved = self.inside_room(moved_union(union, &motion));
        Some(if doubted { moved } else { self.as_fixed_before(moved, to_s) })
    }

    /// Hangs a constraint on its stamp, where `prior` was known, and brings every later slot up to date.
    fn hang(&mut self, constraint: Constraint, prior: PoseUnion) -> Account {
        let stamp_s = constraint.stamp_s;
        let mut account = Account::of(&constraint, prior);
        for assumption in &constraint.relies_on {
            if !self.relies_on.contains(assumption) {
                self.relies_on.push(assumption);
            }
        }
        // What says nothing neither ends a doubt nor prolongs it.
        let agrees = constraint.decides.then(|| self.agrees_with_wheels(&constraint));
        self.ring.insert(Slot { stamp_s, union: PoseUnion::default(), constraint: Some(constraint) });
        if let Some((doubt, agrees)) = self.doubt.as_mut().zip(agrees) {
            doubt.agreeing = if agrees { doubt.agreeing + 1 } else { 0 };
        }
        account.emptied = !self.replay(stamp_s);
        if account.emptied {
            self.begin_doubt();
        } else {
            self.end_doubt_when_supported();
        }
        account.posterior = self.ring.at(stamp_s).map(|slot| slot.union.clone()).unwrap_or_default();
        self.restart_integral();
        self.predict();
        account
    }

    /// Recomputes every slot from `from_s` on. Answers whether each constraint left something; stops at the first that does not,
    /// unless the wheels are doubted already: then a constraint that contradicts even reach is left out.
    fn replay(&mut self, from_s: f64) -> bool {
        let doubted = self.doubt.is_some();
        let Some(first) = self.ring.index_at(from_s) else { return true };
        for index in first.max(1)..self.ring.len() {
            let (before, slot) = (&self.ring[index - 1], &self.ring[index]);
            let Some(predicted) = self.carried(&before.union, before.stamp_s, slot.stamp_s, doubted) else { continue };
            let contracted = match &slot.constraint {
                Some(constraint) => contract_union(&predicted, constraint.on_pose.as_ref()),
                None => predicted.clone(),
            };
            if !contracted.is_empty() {
                self.ring[index].union = contracted;
            } else if doubted {
                self.ring[index].union = predicted;
            } else {
                return false;
            }
        }
        true
    }

    fn restart_integral(&mut self) {
        self.integral = self
            .ring
            .last()
            .and_then(|last| self.wheels.integrate_from(last.stamp_s, &self.robot.wheels, &self.robot.reach));
    }

    /// The part of a union in which the body does not stand in a wall.
    fn inside_room(&self, union: PoseUnion) -> PoseUnion {
        let room = self.whole_room();
        let mut branches: Vec<PoseBox> = union.branches.iter().map(|branch| branch.intersect(&room)).collect();
        branches.retain(|branch| !branch.is_empty());
        PoseUnion { branches }.without_repeats()
    }

    fn whole_room(&self) -> PoseBox {
        let keep_m = self.robot.body.clearance_m;
        let [x, y] = self.map.room_m.map(|range| Interval::new(range.lo() + keep_m, range.hi() - keep_m));
        IntervalBox::from([x, y, Interval::ENTIRE])
    }
}

/// Every branch, contracted and cut.
fn contract_union(union: &PoseUnion, contractor: &(dyn Contractor<3> + Send + Sync)) -> PoseUnion {
    PoseUnion { branches: union.branches.iter().flat_map(|branch| contractor.branches(branch)).collect() }
        .without_repeats()
}
