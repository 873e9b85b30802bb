//! An extended Kalman filter over the robot's pose, the constants of its sensors, and the landmarks that no map gives.
//!
//! It is what an engineer would build for the same robot from textbooks. All standard deviations are a third of the declared bounds. Constants such
//! as the gyroscope's bias, the wheels' radii and the mounts of the cameras are estimated along with the pose, since errors that last would make a
//! filter overconfident that takes them for noise. Images arrive late: the filter keeps the readings of the last moments with its belief before each,
//! goes back to the stamp of the image, and applies what came after it again.

mod belief;
mod layout;
mod measuring;
mod moved;

use std::collections::VecDeque;

use localizer::{Pose, PoseBox, Reading, RobotModel};

use crate::scene::{FilterNoise, Scene};

use super::{
    Answer, GaussianPose, Subject,
    cues::{Cues, Mounted, Seen, Step, Told},
};

use belief::Belief;
use layout::Layout;
use measuring::{Known, measure};

/// The extended Kalman filter as the subject of a run.
pub struct ExtendedKalmanFilter {
    cues: Cues,
    robot: RobotModel,
    layout: Layout,
    tuning: FilterNoise,
    name: String,
    history: VecDeque<Happened>,
    /// Measurements whose stamps are later than that of the latest step.
    waiting: Vec<(f64, Mounted, Seen)>,
    belief: Belief,
}

/// A step or a measurement of the last moments, with the belief before it.
struct Happened {
    before: Belief,
    what: What,
}

enum What {
    Step(Step),
    Seen(Mounted, Seen),
}

/// Time for which readings are kept, longer than any image takes to arrive.
const KEPT_S: f64 = 1.0;

impl ExtendedKalmanFilter {
    /// The filter for a scene, with the map, robot and bounds that it states; `name` is what results call it.
    pub fn of(scene: &Scene, tuning: FilterNoise, name: String) -> ExtendedKalmanFilter {
        let (map, robot) = (scene.map(), scene.robot_model());
        let cues = Cues::new(scene, &map, &robot);
        let layout = Layout::new(&robot, &cues, &tuning);
        let belief = Belief::start(&layout, &scene.start_box());
        ExtendedKalmanFilter {
            cues,
            robot,
            layout,
            tuning,
            name,
            history: VecDeque::new(),
            waiting: Vec::new(),
            belief,
        }
    }

    /// Applies a step or a measurement to the present belief.
    fn apply(&mut self, what: What) {
        let before = self.belief.clone();
        match &what {
            What::Step(step) => self.belief.step(step, &self.layout, &self.robot, &self.tuning),
            What::Seen(mounted, seen) => {
                let known = Known {
                    layout: &self.layout,
                    tiles: self.cues.tiles(),
                    wall_directions_rad: self.cues.wall_directions_rad(),
                    floor_plan: self.cues.floor_plan(),
                    tuning: &self.tuning,
                };
                measure(&mut self.belief, *mounted, seen, &known);
            }
        }
        self.history.push_back(Happened { before, what });
    }

    /// Applies a measurement at its stamp, and all that came after it again. A measurement from before the time that is kept is lost.
    fn insert(&mut self, stamp_s: f64, mounted: Mounted, seen: Seen) {
        let is_after = |happened: &Happened| matches!(&happened.what, What::Step(step) if step.stamp_s >= stamp_s);
        let Some(index) = self.history.iter().position(is_after) else { return };
        let mut later: VecDeque<Happened> = self.history.split_off(index);
        let Some(Happened { before, what: What::Step(step) }) = later.pop_front() else { return };
        if stamp_s < step.stamp_s - step.span_s && index == 0 && before.stamp_s > 0.0 {
            // Its step is no longer kept.
            self.history.push_back(Happened { before, what: What::Step(step) });
            self.history.append(&mut later);
            return;
        }
        self.belief = before;
        let share = (1.0 - (step.stamp_s - stamp_s) / step.span_s).clamp(0.0, 1.0);
        let [first, second] = step.split(share);
        if share > 0.0 {
            self.apply(What::Step(first));
        }
        self.apply(What::Seen(mounted, seen));
        if share < 1.0 {
            self.apply(What::Step(second));
        }
        later.into_iter().for_each(|happened| self.apply(happened.what));
    }
}

impl Subject for ExtendedKalmanFilter {
    fn name(&self) -> &str {
        &self.name
    }

    fn start(&mut self, start: &PoseBox) {
        self.cues.restart(&self.robot);
        self.belief = Belief::start(&self.layout, start);
        self.history.clear();
        self.waiting.clear();
    }

    fn observe(&mut self, reading: &Reading) {
        match self.cues.take(reading) {
            None => {}
            Some(Told::Seen(stamp_s, mounted, seen)) => {
                if stamp_s > self.belief.stamp_s {
                    self.waiting.push((stamp_s, mounted, seen));
                } else {
                    self.insert(stamp_s, mounted, seen);
                }
            }
            Some(Told::Step(step)) => {
                self.apply(What::Step(step));
                let (ready, waiting) =
                    std::mem::take(&mut self.waiting).into_iter().partition(|(stamp_s, ..)| *stamp_s <= step.stamp_s);
                self.waiting = waiting;
                let ready: Vec<(f64, Mounted, Seen)> = ready;
                ready.into_iter().for_each(|(stamp_s, mounted, seen)| self.insert(stamp_s, mounted, seen));
                while self.history.front().is_some_and(|first| first.before.stamp_s < step.stamp_s - KEPT_S) {
                    self.history.pop_front();
                }
            }
        }
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        // Between two readings of the wheels the robot goes on as it did.
        let ahead_s = (time_s - self.belief.stamp_s).clamp(0.0, KEPT_S);
        let twist = self.cues.twist();
        let Pose { x_m, y_m, heading_rad } = self.belief.pose();
        let turn_rad = twist.turn_rad_per_s * ahead_s;
        let (sin, cos) = (heading_rad + 0.5 * turn_rad).sin_cos();
        let ahead_m = twist.forward_m_per_s * ahead_s;
        let mean = Pose { x_m: x_m + cos * ahead_m, y_m: y_m + sin * ahead_m, heading_rad: heading_rad + turn_rad };
        let covariance = [0, 1, 2].map(|row| [0, 1, 2].map(|column| self.belief.covariance[(row, column)]));
        Answer::Gaussian(GaussianPose { mean, covariance })
    }

    fn knows_until_s(&self) -> Option<f64> {
        Some(self.belief.stamp_s)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
