//! The subject of a run: a localizer under test, which is given the robot's readings and says where the robot is.

mod cues;
mod extended_kalman_filter;
mod failure;
mod foreign_answer;
mod interruptible;
mod interval_localizer;
mod particle_filter;
mod process;
mod registry;
mod stated;
mod stepped;
mod told;
mod tuning;

use interval::Interval;
use localizer::{
    Estimate, Pose, PoseBox, PoseUnion, Reading, Status,
    localizer::{Account, PoseWidth, PostLocalized},
    map::{SeenAgain, SpacePoint, Views},
    motion::SlipExcess,
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use crate::scene::Scene;

pub use cues::{Compared, Cue, CueReader};
pub use extended_kalman_filter::ExtendedKalmanFilter;
pub use failure::{Failure, GivenReading};
pub use foreign_answer::{ForeignAnswer, newest_stamp, turned_to};
pub use interval_localizer::IntervalLocalizer;
pub use particle_filter::ParticleFilter;
pub use process::{ForeignProcess, device, told};
pub use registry::{Added, SubjectChoice, USUAL_LIMIT, add_subject, subject};
pub(crate) use stated::half_turn;
pub use stated::{SHARES, Spread, Stated, chi_squared};
pub use stepped::{Step, Stepped, Steps, stepped};
pub use tuning::Tuning;

/// A localizer under test. It learns about the world through its readings alone. What it may know beforehand, a map and the robot's nominal
/// dimensions, it takes from [`Scene::map`] and [`Scene::robot_model`] when it is created.
///
/// Times are seconds since the start of the present drive.
pub trait Subject {
    /// Name of the localizer in results, by which the results of several localizers are told apart. The judge does not know it.
    fn name(&self) -> &str {
        "unnamed"
    }

    /// Whether the localizer lives in another program, which has begun the run, so that the option `--subject` cannot start it again by its name.
    fn is_elsewhere(&self) -> bool {
        false
    }

    /// Starts a drive at time 0 with the robot somewhere in `start`: x and y in metres and heading in radians, in the world frame. It is
    /// called before the first reading, and again whenever the robot is placed at another station.
    fn start(&mut self, start: &PoseBox);

    /// Takes in a reading. Readings come in the order of their arrival, which need not be that of their measurement.
    fn observe(&mut self, reading: &Reading);

    /// The answer of the tested localizer (the subject) to where the robot is at `time_s`, which is never before the arrival of the newest reading.
    fn estimate_at(&self, time_s: f64) -> Answer;

    /// Stamp of the newest reading that the present answer takes into account; `None` where the localizer does not tell. The age of the answer in
    /// results is counted from it.
    fn knows_until_s(&self) -> Option<f64> {
        None
    }

    /// What the subject's methods claimed to see in the latest reading, and what followed for the pose. The judge compares the claims with the truth,
    /// and debug frames show them; a subject without claims need not implement this.
    fn accounts(&mut self) -> Vec<Account> {
        Vec::new()
    }

    /// What makes the width of the pose's box at the latest key frame for which that is known; a subject without such an account need not implement
    /// this.
    fn width_by_bound(&self) -> Option<&PoseWidth> {
        None
    }

    /// Landmarks in space that the subject knows, from a map or learnt, for a map file; a subject without any need not implement this.
    fn space_points(&mut self) -> Vec<(LandmarkId, SpacePoint)> {
        Vec::new()
    }

    /// How often the landmarks of the map that the subject looked for were found on the drive; a subject without any need not implement this.
    fn seen_again(&self) -> Vec<SeenAgain> {
        Vec::new()
    }

    /// How the landmarks in space look that the subject knows by their looks, for a map file; a subject without any need not implement this.
    fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        Vec::new()
    }

    /// Where pictures of the drive show landmarks in space, for a map file; asked for after [`Subject::space_points`]. A subject without any need not
    /// implement this.
    fn views(&self) -> Option<Views> {
        None
    }

    /// The poses of the present drive, by what was read after them as well as before; a subject that does not look back need not implement this.
    fn post_localized(&mut self) -> Option<PostLocalized> {
        None
    }

    /// What the subject did wrong so that it cannot go on, if anything: the run ends at the first failure, and its verdict tells it. A subject that
    /// cannot fail need not implement this.
    fn failure(&self) -> Option<&Failure> {
        None
    }

    /// The run is over: nothing more is asked. Returns what the subject has written for its author, which is kept beside the results of the run.
    fn end(&mut self) -> Option<String> {
        None
    }

    /// Announces the spans of the next drive in which the wheels slip by more than declared. This happens only in a run that is simulated
    /// again to find the cause of a failure; a subject that declares no bound on slip need not implement this.
    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        drop(excesses);
    }
}

/// A function that creates the subject from a scene, for a run that is simulated again with changes.
pub type SubjectOf<'a> = dyn Fn(&Scene) -> Box<dyn Subject> + 'a;

/// A tested localizer's answer to where the robot is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Answer {
    /// The robot's pose is certainly in one of these boxes; the answer is judged by containment, width, and error of the midpoint of the box around
    /// them all.
    Boxes(Estimate),
    /// A single pose without bounds, at or near which the robot is; the answer is judged by its error alone.
    Point(Pose),
    /// A Gaussian distribution of the pose.
    Gaussian(GaussianPose),
    /// A weighted sample of poses that stands for the distribution of the pose, as a particle filter keeps it. It is never empty.
    Samples(Vec<WeightedPose>),
}

/// A Gaussian distribution of the robot's pose in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianPose {
    /// The most probable pose.
    pub mean: Pose,
    /// Covariance of x, y and heading, 3 × 3 and symmetric, in m², m·rad and rad². The heading's deviation is the turn of at most half a circle from
    /// the mean's heading.
    pub covariance: [[f64; 3]; 3],
}

/// One pose of a weighted sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedPose {
    /// The pose in the world.
    pub pose: Pose,
    /// Its weight, at least 0; only the ratios of weights matter.
    pub weight: f64,
}

/// The kinds of answers, which are judged in different ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerKind {
    /// Boxes that certainly hold the pose.
    Boxes,
    /// A pose without any bounds.
    Point,
    /// A distribution of the pose, Gaussian or by samples.
    Distribution,
}

impl AnswerKind {
    /// Keeps a localizer to one kind of answers: a box that is left out where it would be false, or a distribution where it would be overconfident,
    /// could not be judged. `first` is the kind of the answers so far. Errors with what is wrong with an answer of another kind.
    pub fn hold(first: &mut Option<AnswerKind>, answer: &Answer) -> Result<(), String> {
        let (kind, name) = (answer.kind(), |kind: AnswerKind| match kind {
            AnswerKind::Boxes => "boxes",
            AnswerKind::Point => "a pose without bounds",
            AnswerKind::Distribution => "a distribution",
        });
        match *first.get_or_insert(kind) {
            before if before == kind => Ok(()),
            before => {
                Err(format!("{} after {}, expected one kind of answers for a whole run", name(kind), name(before)))
            }
        }
    }
}

impl Answer {
    /// The kind of the answer.
    pub fn kind(&self) -> AnswerKind {
        match self {
            Answer::Boxes(_) => AnswerKind::Boxes,
            Answer::Point(_) => AnswerKind::Point,
            Answer::Gaussian(_) | Answer::Samples(_) => AnswerKind::Distribution,
        }
    }

    /// The answer as an estimate for `time_s`. A point becomes a box without width, and so does the mean of a distribution.
    pub(crate) fn into_estimate(self, time_s: f64) -> Estimate {
        match self {
            Answer::Boxes(estimate) => estimate,
            Answer::Point(pose) => exactly_at(time_s, pose),
            Answer::Gaussian(gaussian) => exactly_at(time_s, gaussian.mean),
            Answer::Samples(samples) => exactly_at(time_s, mean_of(&samples)),
        }
    }
}

/// The weighted mean of a sample of poses. The heading is the direction of the weighted mean of the unit vectors along the headings, within half a
/// turn of the first pose's heading, so that a localizer that counts its turns keeps its count. The mean of no poses, and that of weights that are
/// not numbers or are all 0, is not a number.
fn mean_of(samples: &[WeightedPose]) -> Pose {
    let total: f64 = samples.iter().map(|sample| sample.weight).sum();
    let mean =
        |of: &dyn Fn(&Pose) -> f64| samples.iter().map(|sample| sample.weight * of(&sample.pose)).sum::<f64>() / total;
    let first_rad = samples.first().map_or(f64::NAN, |sample| sample.pose.heading_rad);
    let turn_rad = |pose: &Pose| pose.heading_rad - first_rad;
    let off_rad = mean(&|pose| turn_rad(pose).sin()).atan2(mean(&|pose| turn_rad(pose).cos()));
    Pose { x_m: mean(&|pose| pose.x_m), y_m: mean(&|pose| pose.y_m), heading_rad: first_rad + off_rad }
}

/// An estimate that consists of exactly one pose, such as the true one.
pub(crate) fn exactly_at(time_s: f64, pose: Pose) -> Estimate {
    let pose = PoseUnion::single(PoseBox::from(pose.to_array().map(Interval::point)));
    Estimate { time_s, pose, status: Status::Sound, relies_on: Vec::new(), contradicting: None }
}
