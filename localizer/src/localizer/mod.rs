//! The localizer. It keeps a ring of slots, each with the pose union at one stamp of the recent past; predicts the pose from wheel readings; applies
//! the constraint from each image or other reading at that reading's own stamp; and gives an account of what came of it.

mod account;
mod after_turn;
mod base_clock;
mod bounding;
mod branches;
mod carrying;
mod constraining;
mod doubt;
mod false_motion;
mod heading_fixes;
mod hypothesis;
mod learning;
mod misplaced;
mod moves;
mod naming;
mod observed;
mod post;
mod predicting;
mod relating;
mod ring;
mod slip;
mod unlearning;

use interval::Interval;

use crate::{
    Map, Method, PoseBox, PoseUnion, Reading, RobotModel,
    bounds::Assumption,
    markers::MarkerId,
    method::{Memory, Window},
    motion::{SlipExcess, WheelHistory, WheelIntegral, moved_union, reach_motion, steering},
};

pub use account::Account;
use base_clock::BASE_STAMP;
use bounding::Graph;
pub use bounding::PoseWidth;
use doubt::{Doubts, in_sectors};
use heading_fixes::HeadingFixes;
use hypothesis::{Failed, Hypothesis};
use moves::{REACH, assumptions, memory_s, motion_history};
pub use naming::Contradiction;
use naming::Naming;
pub use observed::{Dropped, Observed};
pub use post::PostLocalized;
use ring::{Ring, Slot};
use slip::CertifiedSlip;
use unlearning::EarlierKnowledge;

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
    /// For each method, its latest readings of which it makes constraints together with the next one.
    windows: Vec<Window>,
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
    /// Markers that doubts showed not to be where the map has them: their readings are left out for the rest of the drive.
    set_aside: Vec<MarkerId>,
    /// Time spans in which wheels and flow sensor contradicted each other, which proves that the wheels slipped.
    slip: CertifiedSlip,
    /// Earliest stamp of a gyroscope or flow reading that arrived after poses at later stamps had been predicted without it; infinite if there is
    /// none.
    stale_s: f64,
    relies_on: Vec<Assumption>,
    /// What was known at earlier times, to go back to.
    earlier: EarlierKnowledge,
    /// Heading fixes (headings known at single stamps) from which the gyroscope's bias is learnt; `None` if the bias is not learnt.
    fixes: Option<HeadingFixes>,
    /// Key frames of the drive, with what relates them.
    graph: Graph,
    /// Number of key frames of a window in which the poses of the drive are bounded once more at its end; `None` if that is not asked for.
    post_window: Option<usize>,
    /// The names of the latest contradiction, and the work on them.
    naming: Naming,
    /// The wheel encoders' latest count, and the time since which they have had that count.
    at_rest: Option<(f64, [i64; 2])>,
    /// Greatest error of the stamps of wheels, gyroscope, flow sensor and steering encoder.
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
            windows: methods.iter().map(|method| Window::new(method.n_earlier())).collect(),
            map,
            robot,
            methods,
            ring: Ring::new(REMEMBER_S),
            integral: None,
            current: PoseUnion::default(),
            now_s: 0.0,
            hypotheses: vec![Hypothesis::new(Failed::Nothing)],
            doubts: Doubts::default(),
            set_aside: Vec::new(),
            stale_s: f64::INFINITY,
            earlier: EarlierKnowledge::default(),
            fixes: None,
            post_window: None,
            naming: Naming::default(),
            at_rest: None,
            base_stamp_error_s: 0.0,
        };
        if localizer.memories().any(|memory| memory.keeps_drive()) {
            localizer.graph.frames.keep_all();
        }
        localizer.begin_at(start);
        localizer.begin_knowledge();
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
        self.set_aside.clear();
        self.slip = CertifiedSlip::new(memory_s(&self.robot));
        self.stale_s = f64::INFINITY;
        self.relies_on = assumptions(&self.robot);
        self.windows.iter_mut().for_each(Window::clear);
        self.memories().for_each(|memory| memory.clock_set_back());
        self.begin_at(start);
        self.begin_fixes();
        self.begin_knowledge();
    }

    /// Announces the time spans of the coming drive in which the wheels slip by more than declared. They are known only when a run is simulated again
    /// to find the cause of a failure.
    pub fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.wheels.expect_slip(excesses);
    }

    fn begin_at(&mut self, start: PoseBox) {
        self.known_heading = (0.0, start[2]);
        self.current = self.inside_room(in_sectors(start));
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
            Reading::Other { measured_s, device, numbers, .. }
                if device == steering::DEVICE && self.robot.steering.is_some() =>
            {
                let is_new = numbers.first().and_then(|ticks| self.wheels.push_steering(*measured_s, *ticks));
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

    /// What the methods keep from one reading to the next.
    fn memories(&mut self) -> impl Iterator<Item = &mut dyn Memory> {
        self.methods.iter_mut().filter_map(|method| method.memory_mut())
    }

    /// Whether an assumption is doubted.
    fn is_doubted(&self) -> bool {
        self.hypotheses[0].failed != Failed::Nothing
    }
}
