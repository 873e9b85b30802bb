//! What a run tests: whoever is given the robot's readings and says where the robot is.

mod interval_localizer;

use interval::Interval;
use localizer::{Estimate, Pose, PoseBox, PoseUnion, Reading, Status, localizer::Account, motion::SlipExcess};

use crate::scene::Scene;

pub use interval_localizer::IntervalLocalizer;

/// A localizer in the loop. It learns of the world by its readings alone; what it may know beforehand, a map and the robot's nominal
/// dimensions, it takes from [`Scene::map`] and [`Scene::robot_model`] when it is made.
///
/// Times are seconds since the start of the present drive.
pub trait Subject {
    /// A drive begins at time 0 with the robot somewhere in `start`: x and y in metres and heading in radians, world. It is called before the
    /// first reading, and again whenever the robot is put at another station.
    fn start(&mut self, start: &PoseBox);

    /// Takes in a reading. Readings come in the order of their arrival, which need not be that of their measurement.
    fn observe(&mut self, reading: &Reading);

    /// Where the robot is at `time_s`, which is never before the arrival of the newest reading.
    fn estimate_at(&self, time_s: f64) -> Answer;

    /// What its methods made of the reading that it took in last. The judge holds these claims against the truth, and debug frames show them; a
    /// subject that has none to show leaves this as it is.
    fn accounts(&mut self) -> Vec<Account> {
        Vec::new()
    }

    /// Tells in which spans of the next drive the wheels slip by more than declared. Only a run that is simulated again to find whose fault a
    /// failure was is told so; a subject that declares nothing of slip leaves this as it is.
    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        drop(excesses);
    }
}

/// Makes the subject of what a scene tells it, for a run that is simulated again with something otherwise.
pub type SubjectOf<'a> = dyn Fn(&Scene) -> Box<dyn Subject> + 'a;

/// Where a subject says that the robot is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Answer {
    /// Surely in one of these boxes: judged by containment, width and error of the hull's midpoint.
    Boxes(Estimate),
    /// About here: judged by its error alone.
    Point(Pose),
}

impl Answer {
    /// As an estimate of `time_s`; a point is a box without width.
    pub(crate) fn into_estimate(self, time_s: f64) -> Estimate {
        match self {
            Answer::Boxes(estimate) => estimate,
            Answer::Point(pose) => exactly_at(time_s, pose),
        }
    }
}

/// The estimate of somebody who sees where the robot is.
pub(crate) fn exactly_at(time_s: f64, pose: Pose) -> Estimate {
    let pose = PoseUnion::single(PoseBox::from(pose.to_array().map(Interval::point)));
    Estimate { time_s, pose, status: Status::Sound, relies_on: Vec::new() }
}
