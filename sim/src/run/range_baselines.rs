//! Baselines for the method `range_landmarks`: point methods (which give a pose without bounds) on the same readings, and the same pose problems
//! given to every interval solver.

use std::{collections::BTreeMap, time::Instant};

use interval::{Interval, IntervalBox, paving};
use localizer::{
    Claim, Pose, PoseBox,
    baselines::{
        GatedIcp, RansacMap, SOLVERS, WeightedPoint, WeightedPose, closest_points, least_squares, printed_table_iv,
        solve,
    },
    localizer::Account,
    reading::LandmarkId,
    rigid_motion::Landmark,
    robot::{RangeCameraModel, WheelModel},
};

/// Name of least squares with known correspondences.
pub(super) const LEAST_SQUARES: &str = "least_squares";
/// Name of iterative closest point without correspondences.
pub(super) const CLOSEST_POINTS: &str = "closest_points";
/// Name of weighted least squares over the correspondences that agree with each other.
pub(super) const RANSAC: &str = "ransac";
/// Name of iterative closest point with a predicted pose and a gate on the matches.
pub(super) const GATED_ICP: &str = "gated_icp";
/// Name of the formulas in paper 3's Table IV as printed.
pub(super) const TABLE_IV_PRINTED: &str = "table_iv_printed";

/// Interval, in readings of a drive, at which the problem of finding the pose from one reading is given to the interval solvers. With more
/// problems, set inversion would take most of a drive's computing time.
const EVERY: usize = 10;

/// Distance by which the prior box that a solver is given extends beyond the localizer's box on each side, along x and y. The solver's box is
/// then about as wide as after a kidnapping to a corner of the next room.
const PRIOR_M: f64 = 0.5;
/// Angle by which the prior box that a solver is given extends beyond the localizer's box on each side, in heading. See `PRIOR_M`.
const PRIOR_RAD: f64 = 0.5;

/// Results of point methods (which give a pose without bounds) and of interval solvers on the range readings of one run.
#[derive(Clone, Debug, Default)]
pub struct RangeBaselines {
    /// Pose by least squares with known correspondences, at each step; empty when nothing was measured.
    pub svd: Vec<Pose>,
    /// Pose by iterative closest point without correspondences, at each step.
    pub icp: Vec<Pose>,
    /// Pose by weighted least squares over the correspondences that agree with each other, at each step.
    pub ransac: Vec<Pose>,
    /// Pose by iterative closest point with a predicted pose and a gate on the matches, at each step.
    pub gated_icp: Vec<Pose>,
    /// Answers of each interval solver, by its name, and those of the formulas in the paper's Table IV as printed.
    pub solvers: BTreeMap<&'static str, Answers>,
    n_readings: usize,
    with_codes: PointMap,
    without_codes: PointMap,
    agreeing: Tracked<RansacMap>,
    gated: Tracked<GatedIcp>,
    boxes: BTreeMap<LandmarkId, [Interval; 2]>,
}

/// Answers of one interval solver to the pose problems of a run.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// Number of pose problems given to the interval solver.
    pub problems: usize,
    /// Number of answers that hold the true pose in one of their boxes.
    pub contained: usize,
    /// Smallest boxes around each of the solver's answers; empty answers are left out.
    pub hulls: Vec<PoseBox>,
    /// Wall-clock time that the solver took.
    pub spent_s: f64,
}

/// A map of points and the robot's pose in that map, carried on by odometry between readings.
#[derive(Clone, Debug, Default)]
struct PointMap {
    places: BTreeMap<LandmarkId, [f64; 2]>,
    /// Pose at the last reading, and the pose by odometry at the same time.
    fixed: Option<[Pose; 2]>,
}

/// A map of points with covariances and the robot's pose in that map, carried on by odometry between readings.
#[derive(Clone, Debug, Default)]
struct Tracked<M> {
    map: M,
    /// Pose at the last reading, and the pose by odometry at the same time.
    fixed: Option<(WeightedPose, Pose)>,
}

/// What point methods (which give a pose without bounds) are given besides the reading: the same values as the localizer.
pub(super) struct Told<'a> {
    /// Where the drive starts, as the localizer is given it: `start_box` is the box of possible poses, `start` the middle of that box.
    pub(super) start: Pose,
    pub(super) start_box: &'a PoseBox,
    pub(super) camera: &'a RangeCameraModel,
    pub(super) wheels: &'a WheelModel,
}

impl RangeBaselines {
    /// Gives a reading to all point methods (which give a pose without bounds), and now and then to the interval solvers. `odometry` is the pose
    /// by odometry at the reading's stamp, `truth` the true pose.
    pub(super) fn observe(&mut self, account: &Account, told: &Told<'_>, odometry: Pose, truth: Pose, every_one: bool) {
        let start = told.start;
        let seen: Vec<(LandmarkId, [Interval; 2])> = account
            .claims
            .iter()
            .filter_map(|claim| match claim {
                Claim::Landmark { landmark, in_robot_m } => Some((*landmark, *in_robot_m)),
                Claim::FloorJoint { .. }
                | Claim::WallLine { .. }
                | Claim::UprightLine { .. }
                | Claim::WallUpright { .. }
                | Claim::SpacePoint { .. }
                | Claim::Marker { .. }
                | Claim::WallPoint { .. } => None,
            })
            .collect();
        self.with_codes.fix(&seen, start, odometry, |map, points, _| {
            let pairs = points.iter().filter_map(|(code, b)| Some((*map.get(code)?, *b))).collect::<Vec<_>>();
            least_squares(&pairs)
        });
        self.without_codes.fix(&seen, start, odometry, |map, points, guess| {
            let places: Vec<[f64; 2]> = map.values().copied().collect();
            let view: Vec<[f64; 2]> = points.iter().map(|(_, b)| *b).collect();
            (places.len() >= 2).then(|| closest_points(&places, &view, guess))
        });
        let baseline_m = told.camera.baseline_m.mid();
        let weighted = |(code, b): &(LandmarkId, [Interval; 2])| (*code, WeightedPoint::of_stereo(*b, baseline_m));
        let view: Vec<(LandmarkId, WeightedPoint)> = seen.iter().map(weighted).collect();
        self.agreeing.fix(told, odometry, |map, predicted| map.fix(&view, predicted));
        let nameless: Vec<WeightedPoint> = view.iter().map(|(_, point)| *point).collect();
        self.gated.fix(told, odometry, |map, predicted| map.fix(&nameless, predicted));
        if account.quota.items == 0 && (every_one || self.n_readings.is_multiple_of(EVERY)) {
            self.put_to_solvers(&seen, &account.posterior.hull(), truth);
        }
        self.n_readings += 1;
        self.boxes = account.landmarks.iter().copied().collect();
    }

    /// The poses of each point method by its name, at the last steps of the run; none before the first reading.
    pub(super) fn named(&self) -> Vec<(&'static str, &Vec<Pose>)> {
        let all = [
            (LEAST_SQUARES, &self.svd),
            (CLOSEST_POINTS, &self.icp),
            (RANSAC, &self.ransac),
            (GATED_ICP, &self.gated_icp),
        ];
        all.into_iter().filter(|(_, poses)| !poses.is_empty()).collect()
    }

    /// Forgets the poses but keeps the maps, because the robot was put at another place.
    pub(super) fn restart(&mut self) {
        self.with_codes.fixed = None;
        self.without_codes.fixed = None;
        self.agreeing.fixed = None;
        self.gated.fixed = None;
    }

    /// Adds the pose that each point method gives at a step.
    pub(super) fn step(&mut self, odometry: Pose) {
        if self.n_readings > 0 {
            self.svd.push(self.with_codes.pose(odometry));
            self.icp.push(self.without_codes.pose(odometry));
            self.ransac.push(self.agreeing.pose(odometry));
            self.gated_icp.push(self.gated.pose(odometry));
        }
    }

    fn put_to_solvers(&mut self, seen: &[(LandmarkId, [Interval; 2])], posterior: &PoseBox, truth: Pose) {
        let pairs: Vec<Landmark> = seen.iter().filter_map(|(code, b)| Some((*self.boxes.get(code)?, *b))).collect();
        if pairs.len() < 2 || posterior.is_empty() {
            return;
        }
        let prior = IntervalBox::from([
            posterior[0].inflate(PRIOR_M),
            posterior[1].inflate(PRIOR_M),
            posterior[2].inflate(PRIOR_RAD),
        ]);
        for (name, solver) in SOLVERS {
            self.solvers.entry(name).or_default().note(truth, || solve(solver, &pairs, &prior));
        }
        let printed = self.solvers.entry(TABLE_IV_PRINTED).or_default();
        printed.note(truth, || vec![printed_table_iv(&pairs, &prior)]);
    }
}

impl Answers {
    fn note(&mut self, truth: Pose, work: impl FnOnce() -> Vec<PoseBox>) {
        let began = Instant::now();
        let boxes = work();
        self.spent_s += began.elapsed().as_secs_f64();
        self.problems += 1;
        self.contained += usize::from(boxes.iter().any(|one| one.contains(&truth.to_array())));
        let hull = paving::hull(&boxes);
        if !hull.is_empty() {
            self.hulls.push(hull);
        }
    }
}

impl PointMap {
    /// Solves for the pose in the map and adds landmarks to the map that it does not hold yet.
    fn fix(
        &mut self,
        seen: &[(LandmarkId, [Interval; 2])],
        start: Pose,
        odometry: Pose,
        solved: impl FnOnce(&BTreeMap<LandmarkId, [f64; 2]>, &[(LandmarkId, [f64; 2])], Pose) -> Option<Pose>,
    ) {
        let points: Vec<(LandmarkId, [f64; 2])> =
            seen.iter().map(|(code, b)| (*code, [b[0].mid(), b[1].mid()])).collect();
        let guess = if self.fixed.is_some() { self.pose(odometry) } else { start };
        let pose = match solved(&self.places, &points, guess) {
            // Headings by odometry are not wrapped to one turn, so that the solution's heading is shifted by whole turns to the one nearest to
            // odometry's.
            Some(pose) => Pose { heading_rad: unwrapped(pose.heading_rad, odometry.heading_rad), ..pose },
            None => guess,
        };
        for (code, b) in points {
            self.places.entry(code).or_insert_with(|| place(pose, b));
        }
        self.fixed = Some([pose, odometry]);
    }

    /// Returns the robot's pose in the map: the pose at the last reading, carried on by the motion that odometry has measured since. `odometry`
    /// is the present pose by odometry.
    fn pose(&self, odometry: Pose) -> Pose {
        self.fixed.map_or(odometry, |[pose, then]| carried(pose, then, odometry))
    }
}

impl<M> Tracked<M> {
    /// Solves for the pose in the map, starting from the pose that odometry predicts.
    fn fix(&mut self, told: &Told<'_>, odometry: Pose, solved: impl FnOnce(&mut M, WeightedPose) -> WeightedPose) {
        let predicted = match &self.fixed {
            Some((pose, then)) => pose.carried_on(*then, odometry, told.wheels),
            None => WeightedPose::of_bounds(told.start, [0, 1, 2].map(|axis| told.start_box[axis].radius())),
        };
        self.fixed = Some((solved(&mut self.map, predicted), odometry));
    }

    /// Returns the robot's pose in the map: the pose at the last reading, carried on by the motion that odometry has measured since. `odometry`
    /// is the present pose by odometry.
    fn pose(&self, odometry: Pose) -> Pose {
        self.fixed.as_ref().map_or(odometry, |(fixed, then)| carried(fixed.pose, *then, odometry))
    }
}

/// Carries a pose on by the motion that odometry measured between `then` and `now`.
fn carried(pose: Pose, then: Pose, now: Pose) -> Pose {
    let (sin, cos) = then.heading_rad.sin_cos();
    let (x_m, y_m) = (now.x_m - then.x_m, now.y_m - then.y_m);
    let [x_m, y_m] = place(pose, [cos * x_m + sin * y_m, cos * y_m - sin * x_m]);
    Pose { x_m, y_m, heading_rad: pose.heading_rad + now.heading_rad - then.heading_rad }
}

fn place(pose: Pose, [forward_m, left_m]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sin_cos();
    [pose.x_m + cos * forward_m - sin * left_m, pose.y_m + sin * forward_m + cos * left_m]
}

fn unwrapped(angle_rad: f64, near_rad: f64) -> f64 {
    angle_rad - ((angle_rad - near_rad) / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
