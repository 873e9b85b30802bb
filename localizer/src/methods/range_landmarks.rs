//! `range_landmarks`, after paper 3 (Mustafa et al., CSCS 2015): bounds the pose by coded landmarks whose places no map gives.
//!
//! **Constraint.** A landmark at a in the world and at b in the robot frame has a = t + R(θ)·b, with t the robot's position and θ its
//! heading: the paper's Eq. (16) solved for a. The world frame is that of the start pose: the first reading says where the landmarks are,
//! and each later pose is solved against the landmarks, never against the pose before. The box of a landmark's place only ever shrinks, so
//! that poses stay as narrow as their own view of the landmarks allows, however long the drive.
//!
//! **Soundness.** A landmark's box is the intersection of t + R(θ)·b over boxes that contain the true t, θ and b.
//!
//! **Wrong correspondences.** At most `q_items` sightings of a reading are attributed to the wrong landmark: the pose set is what all but
//! that many sightings allow. The place of a landmark is learnt from windows of `wrong_spacing + 1` consecutive sightings with its code, of
//! which at most one is wrong, hence from their 1-relaxed intersection: the places that all but one sighting allow. A sighting that says
//! nothing, because the landmark may be at infinity, counts as one that allows every place; a reading that is not learnt from ends all
//! windows. Consecutive means measured one after the other, in whatever order the readings arrive (`in_order`). With a `wrong_spacing` of 0
//! every sighting may be wrong, and no landmark is ever learnt.
//!
//! A sighting whose code may be wrong relates nothing by itself. Of `wrong_spacing + 1` consecutive sightings with one code, carried to the latest by
//! the robot's motion, all but one are right, which tells where that reading surely shows the landmark (`agreed`); and some codes are certainly right
//! (`codes`).
//!
//! **Contradiction.** As long as the declared bounds hold, the place learnt before and the place learnt from the latest window overlap,
//! whichever of the matches are wrong. Where they do not overlap, nothing of the reading is learnt, and the localizer is notified.
//!
//! **Loop closure.** What a reading relates goes to the graph of key frames, which bounds poses and landmarks together: what is known at the end of a
//! loop reaches the loop's middle.
//!
//! **Source.** M. Mustafa et al., CSCS 2015, section IV; multi-frame contraction against the first frame, as its section II asks, by the graph.

mod agreed;
mod atlas;
mod codes;
mod in_order;
mod sight;
mod solver;

use std::{collections::BTreeMap, sync::Arc};

use interval::Interval;
use interval::contractor::Outcome;

use crate::{
    PoseUnion, Reading, RobotModel, bounds,
    bounds::Assumption,
    graph::{Columns, Stray, Variable},
    method::{Claim, Constraint, Context, Knowledge, Memory, Method, OnPose, Shown},
    quota::Quota,
    reading::{LandmarkId, Sighting},
};

use agreed::{Use, agreed_columns};
use atlas::Atlas;
use codes::{CodeUses, RightCodes};
use in_order::{InOrder, Learnt};
use sight::Sightings;
pub use sight::{Seen, Sensor};
pub use solver::{Freedom, PoseFromLandmarks, Solver};

/// Declared bounds that a constraint from range landmarks relies on.
const RELIES_ON: [Assumption; 14] = [
    bounds::RANGE_CAMERA_FOCAL,
    bounds::RANGE_CAMERA_BASELINE,
    bounds::RANGE_CAMERA_POSITION,
    bounds::RANGE_CAMERA_YAW,
    bounds::RANGE_CAMERA_TILT,
    bounds::RANGE_CAMERA_HEIGHT_SPAN,
    bounds::RANGE_CAMERA_STAMP,
    bounds::RANGE_CAMERA_LATENCY,
    bounds::RANGE_CAMERA_COLUMNS,
    bounds::BODY_TILT,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
    bounds::RANGE_LANDMARKS_Q_ITEMS,
    bounds::RANGE_LANDMARKS_WRONG_SPACING,
];

/// Greatest number of earlier readings that tell the columns of landmarks with possibly wrong codes. The robot's motion since tells less and less of
/// older ones.
const MOST_EARLIER: usize = 8;

/// Method that localizes the robot by coded landmarks which are on no map and whose places are learnt.
pub struct RangeLandmarks {
    sensor: Sensor,
    q_items: usize,
    freedom: Freedom,
    solver: Solver,
    atlas: Atlas,
    /// Readings of landmarks that wait until all readings measured before them have been handled.
    in_order: InOrder,
    /// The latest uses of each landmark's code, which tell what codes are certainly right.
    code_uses: CodeUses,
    /// Numbers of the latest uses of each landmark's code, which follow each other where the uses do.
    n_uses: BTreeMap<LandmarkId, usize>,
    /// Whether, since the localizer last asked for contradictions, a reading contradicted what was known about the landmarks.
    contradicts: bool,
}

/// What was known at a time.
struct Known {
    atlas: Atlas,
    /// Number of codes that had been found to be right.
    n_right: usize,
}

/// What one reading showed.
struct Shows {
    stamp_s: f64,
    arrived_s: f64,
    seen: Vec<Seen>,
    uses: Vec<Use>,
    /// How far the robot can have gone within the error of the reading's stamp; nowhere where that is not asked for.
    stray: Stray,
    codes: Arc<RightCodes>,
}

impl RangeLandmarks {
    /// Makes the range-landmark method for a robot; `None` if the robot has no range camera.
    pub fn new(robot: &RobotModel, freedom: Freedom, solver: Solver) -> Option<Self> {
        let camera = robot.range_camera.as_ref()?;
        Some(RangeLandmarks {
            sensor: Sensor::new(robot)?,
            q_items: camera.q_items,
            atlas: Atlas::new(camera.q_items, camera.wrong_spacing),
            freedom,
            solver,
            in_order: InOrder::new(camera),
            code_uses: CodeUses::new(camera.q_items, camera.wrong_spacing),
            n_uses: BTreeMap::new(),
            contradicts: false,
        })
    }

    /// Ends all windows of consecutive sightings, because a reading is missing from the sequence. A window is a number of consecutive
    /// sightings with one landmark's code, of which at most one is wrong.
    fn interrupt(&mut self) {
        self.atlas.interrupt();
        self.code_uses.interrupt();
        self.part_uses();
    }

    /// Sees to it that no later use of a code counts as consecutive to one before.
    fn part_uses(&mut self) {
        let wrong_spacing = self.sensor.camera.wrong_spacing;
        self.n_uses.values_mut().for_each(|n_uses| *n_uses += wrong_spacing);
    }

    /// Learns landmarks from the next reading in the order of measurement.
    fn take_in(&mut self, learnt: Learnt) {
        let place = |seen: &Seen| (seen.landmark, in_world(&learnt.posterior, seen));
        let places: Vec<_> = learnt.seen.iter().map(place).collect();
        let is_wrong = |&(landmark, place): &(LandmarkId, [Interval; 2])| {
            let known = self.atlas.place(landmark);
            (landmark, known.is_some_and(|known| (0..2).any(|axis| !known[axis].overlaps(place[axis]))))
        };
        let codes: Vec<(LandmarkId, bool)> = places.iter().map(is_wrong).collect();
        if let Outcome::Empty(_) = self.atlas.learn(&places) {
            self.contradicts = true;
            self.interrupt();
            return;
        }
        self.code_uses.take_in(&codes, &learnt.codes);
    }

    /// The next use of a landmark's code.
    fn used(&mut self, sighting: &Sighting) -> Use {
        let n_uses = self.n_uses.entry(sighting.landmark).or_default();
        *n_uses += 1;
        let columns = Columns::of(&self.sensor.camera, sighting);
        Use { landmark: sighting.landmark, number: *n_uses, columns }
    }

    /// Whether the readings' relations are used: where the heading is known beforehand, as in the paper's simpler tables, or another solver is to be
    /// compared, they are not.
    fn relates(&self) -> bool {
        self.freedom == Freedom::Full && self.solver == Solver::OneShot
    }

    /// Whether landmarks are related although codes may be wrong.
    fn relates_despite_wrong(&self) -> bool {
        self.relates() && self.q_items > 0
    }

    /// Pairs of a landmark's box in the world and its box in the robot frame, for each sighting of a landmark whose place is known.
    fn pairs(&self, seen: &[Seen]) -> Vec<([Interval; 2], [Interval; 2])> {
        let bounded = seen.iter().filter(|seen| seen.is_bounded());
        bounded.filter_map(|seen| Some((self.atlas.place(seen.landmark)?, seen.in_robot_m))).collect()
    }
}

impl Method for RangeLandmarks {
    fn name(&self) -> &'static str {
        "range_landmarks"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn n_earlier(&self) -> usize {
        let is_known = self.relates_despite_wrong() && self.in_order.is_by_arrival();
        if is_known { self.sensor.camera.wrong_spacing.min(MOST_EARLIER) } else { 0 }
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Range { measured_s, arrived_s, sightings } = reading else { return None };
        if sightings.is_empty() {
            return None;
        }
        let seen: Vec<Seen> = sightings.iter().map(|one| self.sensor.seen(one)).collect();
        let codes = Arc::new(RightCodes::new(sightings.len(), self.q_items == 0));
        let uses: Vec<Use> = sightings.iter().map(|one| self.used(one)).collect();
        let pairs = self.pairs(&seen);
        let decides = pairs.len() >= 2 + self.q_items;
        let claim = |seen: &Seen| Claim::Landmark { landmark: seen.landmark, in_robot_m: seen.in_robot_m };
        let claims: Vec<Claim> = seen.iter().filter(|seen| seen.is_bounded()).map(claim).collect();
        if claims.is_empty() {
            // The reading is not learnt from, which leaves a gap in the sequence of consecutive readings.
            self.in_order.push(*measured_s, None);
            return None;
        }
        let (mut stray, mut despite_wrong) = (Stray::default(), Vec::new());
        if self.relates_despite_wrong() {
            stray = (context.stray)(*measured_s, self.sensor.camera.stamp_error_s);
            despite_wrong = agreed_columns(&self.sensor, (*measured_s, &stray), &uses, context.earlier);
        }
        let relations = || Arc::new(Sightings::new(&self.sensor, sightings, codes.clone(), &despite_wrong)) as _;
        let relations = self.relates().then(relations);
        let on_pose = PoseFromLandmarks::new(pairs, self.q_items, self.freedom, self.solver);
        let (stamp_s, arrived_s) = (*measured_s, *arrived_s);
        Some(Constraint {
            relies_on: RELIES_ON.to_vec(),
            claims,
            quota: Quota::of_each(self.q_items),
            decides,
            relations,
            shown: Some(Arc::new(Shows { stamp_s, arrived_s, seen, uses, stray, codes })),
            is_held: self.n_earlier() > 0,
            ..Constraint::new(self.name(), *measured_s, on_pose)
        })
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

impl Memory for RangeLandmarks {
    fn learn(&mut self, shown: &Shown, posterior: Option<&PoseUnion>) {
        let Some(Shows { stamp_s, arrived_s, seen, codes, .. }) = shown.downcast_ref() else { return };
        let learnt = |posterior: &PoseUnion| Learnt {
            posterior: posterior.clone(),
            seen: seen.clone(),
            codes: Arc::clone(codes),
        };
        let is_doubted = posterior.is_none();
        self.in_order.push(*stamp_s, posterior.filter(|posterior| !posterior.is_empty()).map(learnt));
        if is_doubted {
            // At the end of a doubt readings may be left out.
            self.part_uses();
            return;
        }
        for (_, learnt) in self.in_order.take(*arrived_s) {
            match learnt {
                Some(learnt) => self.take_in(learnt),
                None => self.interrupt(),
            }
        }
    }

    fn take_contradiction(&mut self) -> bool {
        std::mem::take(&mut self.contradicts)
    }

    fn learns_landmarks(&self) -> bool {
        self.relates()
    }

    fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        for &(variable, bound) in bounds {
            if let Variable::Landmark(landmark, axis) = variable {
                let place = std::array::from_fn(|at| if at == axis { bound } else { Interval::ENTIRE });
                self.contradicts |= self.atlas.narrow(landmark, place) != Outcome::Feasible;
            }
        }
    }

    fn on_pose_again(&self, shown: &Shown) -> Option<OnPose> {
        let Shows { seen, .. } = shown.downcast_ref()?;
        Some(Box::new(PoseFromLandmarks::new(self.pairs(seen), self.q_items, self.freedom, self.solver)))
    }

    fn knowledge(&self) -> Option<Knowledge> {
        Some(Arc::new(Known { atlas: self.atlas.clone(), n_right: self.code_uses.n_found() }))
    }

    fn go_back(&mut self, known: &Knowledge) {
        self.in_order.miss_all();
        if let Some(Known { atlas, n_right }) = known.downcast_ref() {
            self.atlas.clone_from(atlas);
            self.code_uses.go_back(*n_right);
        }
        self.interrupt();
    }

    fn clock_set_back(&mut self) {
        self.in_order.settle();
        self.interrupt();
    }

    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        self.atlas.places()
    }
}

/// Hull of a landmark's possible places in the world, given where it is seen in the robot frame and a union of boxes for the robot's pose.
fn in_world(poses: &PoseUnion, seen: &Seen) -> [Interval; 2] {
    poses.branches.iter().fold([Interval::EMPTY; 2], |hull, pose| {
        let place = seen.in_world(pose);
        [hull[0].hull(place[0]), hull[1].hull(place[1])]
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{
        PoseBox,
        graph::trial::{camera, robot},
        robot::RangeCameraModel,
    };

    /// The method for a range camera of whose codes one in a reading and one of three in a row may be wrong.
    fn method(camera: RangeCameraModel) -> RangeLandmarks {
        let camera = RangeCameraModel { q_items: 1, wrong_spacing: 2, ..camera };
        let robot = RobotModel { range_camera: Some(camera), ..robot() };
        RangeLandmarks::new(&robot, Freedom::Full, Solver::OneShot).unwrap()
    }

    /// What a reading of landmark 1 shows, and the number of this use of its code.
    fn read(method: &mut RangeLandmarks, stamp_s: f64) -> (Shown, usize) {
        let sightings = vec![Sighting { landmark: LandmarkId(1), left_px: 329.5, right_px: 305.5 }];
        let reading = Reading::Range { measured_s: stamp_s, arrived_s: stamp_s, sightings };
        let here = PoseUnion::single(PoseBox::from([Interval::ZERO; 3]));
        let shown = method.constrain(&reading, &Context::at_rest(&here)).unwrap().shown.unwrap();
        let number = shown.downcast_ref::<Shows>().unwrap().uses[0].number;
        (shown, number)
    }

    #[test]
    fn no_use_counts_as_consecutive_to_one_across_a_doubt_or_a_reading_that_is_missing() {
        let mut method = method(camera());
        let here = PoseUnion::single(PoseBox::from([Interval::ZERO; 3]));
        let (shown, first) = read(&mut method, 1.0);
        method.learn(&shown, Some(&here));
        let (shown, second) = read(&mut method, 1.1);
        assert_eq!(second, first + 1);
        method.learn(&shown, None);
        let (shown, after_doubt) = read(&mut method, 1.2);
        assert!(after_doubt - second > 2, "{second}, {after_doubt}");
        method.learn(&shown, Some(&here));
        let (_, next) = read(&mut method, 1.3);
        method.interrupt();
        let (_, after_gap) = read(&mut method, 1.4);
        assert!(after_gap - next > 2, "{next}, {after_gap}");
    }

    #[test]
    fn readings_that_may_overtake_each_other_are_not_counted_in_a_row() {
        assert_eq!(method(camera()).n_earlier(), 2);
        // Readings are measured every 0.1 s, and one may overtake another.
        let late = RangeCameraModel { latency_s: Interval::new(0.0, 0.2), ..camera() };
        assert_eq!(method(late).n_earlier(), 0);
        let all_right = RobotModel { range_camera: Some(camera()), ..robot() };
        assert_eq!(RangeLandmarks::new(&all_right, Freedom::Full, Solver::OneShot).unwrap().n_earlier(), 0);
    }
}
