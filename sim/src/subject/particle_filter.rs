//! A particle filter over the robot's pose, as AMCL has it: Monte Carlo localization whose number of samples adapts to how far they are spread.
//!
//! Sources: S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics* (2005): the motion of samples section 5.4, low-variance resampling table 4.4, KLD
//! sampling table 8.4; D. Fox, *Adapting the sample size in particle filters through KLD-sampling*, International Journal of Robotics Research 22
//! (2003).
//!
//! The samples stand for the pose at the stamp of the latest measurement. The answer is the samples carried on by dead reckoning to the present, each
//! with an error of its own.

mod cloud;
mod likelihood;
mod odometry;
mod resampling;

use std::f64::consts::PI;

use localizer::{Pose, PoseBox, Reading, RobotModel};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::{
    scene::{FilterNoise, Scene},
    truth::randomness::stream,
};

use super::{
    Answer, Subject, WeightedPose,
    cues::{Cues, Mounted, SIGMAS_OF_BOUND, Seen, Step, Told, turned},
};

use cloud::{Cloud, Constants, Sample};
use likelihood::{Known, likelihood};
use odometry::{Odometry, Reckoned, Way};

/// The particle filter as the subject of a run.
pub struct ParticleFilter {
    cues: Cues,
    robot: RobotModel,
    tuning: FilterNoise,
    name: String,
    area_m2: f64,
    constants: Constants,
    odometry: Odometry,
    cloud: Cloud,
    /// Dead reckoning at the stamp that the samples stand for.
    sampled: Reckoned,
    /// Measurements whose stamps are later than that of the latest step.
    waiting: Vec<(f64, Mounted, Seen)>,
    /// Short and long mean of how well the samples explain measured positions, over how well the best pose does.
    explained: Option<[f64; 2]>,
}

/// Decay of the short and of the long mean of how well the samples explain measured positions. Where the short one falls below the long one, the
/// samples are lost, and a share of them is drawn from the measurement (*Probabilistic Robotics*, table 8.3: there 0 ≤ α_slow ≪ α_fast).
const DECAY: [f64; 2] = [0.3, 0.01];
/// Standard deviation of a lost sample's heading, where a measured position does not tell the heading: that of a robot that has gone astray.
const LOST_RAD: f64 = 0.1;
/// Time without a measurement after which the samples are carried on, so that later errors of the motion are independent of earlier ones.
const LONGEST_WAY_S: f64 = 0.5;

impl ParticleFilter {
    /// The filter for a scene, with the map, robot and bounds that it states; `name` is what results call it.
    pub fn of(scene: &Scene, tuning: FilterNoise, name: String) -> ParticleFilter {
        let (map, robot) = (scene.map(), scene.robot_model());
        let cues = Cues::new(scene, &map, &robot);
        let constants = Constants {
            bias_rad_per_s: robot
                .gyro
                .map_or(0.0, |gyro| tuning.motion * SIGMAS_OF_BOUND * 0.5 * gyro.bias_rad_per_s.width()),
            mounts: Mounted::ALL.map(|mounted| cues.mount(mounted).map_or([0.0; 3], |mount| mount.sigma)),
        };
        let mut filter = ParticleFilter {
            cues,
            odometry: Odometry::new(&robot, tuning),
            area_m2: map.room_m[0].width() * map.room_m[1].width(),
            constants,
            robot,
            tuning,
            name,
            cloud: Cloud::new(stream(0, "subject.particle_filter")),
            sampled: Reckoned::default(),
            waiting: Vec::new(),
            explained: None,
        };
        filter.begin(&scene.start_box());
        filter
    }

    /// Begins a drive somewhere in a box.
    fn begin(&mut self, start: &PoseBox) {
        self.odometry = Odometry::new(&self.robot, self.tuning);
        self.sampled = self.odometry.latest();
        self.waiting.clear();
        self.explained = None;
        self.cloud.draw_start(start, &self.constants);
    }

    /// Carries the samples on to a later stamp.
    fn carry(&mut self, to: Reckoned) {
        self.cloud.carry(&Way::between(&self.sampled, &to));
        self.sampled = to;
    }

    /// Weighs the samples by a measurement.
    fn weigh(&mut self, stamp_s: f64, mounted: Mounted, seen: &Seen) {
        let at = self.odometry.at(stamp_s);
        if stamp_s > self.sampled.stamp_s {
            self.carry(at);
        }
        if self.cues.mount(mounted).is_none() {
            return;
        }
        // A measurement from before the stamp of the samples is compared with where each of them was then.
        let back = Way::between(&self.sampled, &at).exactly();
        let known = Known {
            tiles: self.cues.tiles(),
            wall_directions_rad: self.cues.wall_directions_rad(),
            floor_plan: self.cues.floor_plan(),
            area_m2: self.area_m2,
            scale: self.tuning.cues,
        };
        // The pose at which the device would be seen to be if it were mounted as stated.
        let apparent = |Sample { pose, errors, .. }: &Sample| {
            let ([x_m, y_m, heading_rad], mount) = (back.from(*pose, errors), errors.mounts[mounted as usize]);
            let [dx, dy] = turned([mount[0], mount[1]], heading_rad);
            [x_m + dx, y_m + dy, heading_rad + mount[2]]
        };
        let mean_rad = self.cloud.mean_of(&|sample| apparent(sample)[2]);
        let Some(likelihood) = likelihood(seen, &known, mean_rad) else { return };
        let of_sample = |sample: &Sample| likelihood(apparent(sample));
        let Some(best) = best_pose(seen, mean_rad) else {
            self.cloud.weigh(&of_sample);
            return;
        };
        let explained = self.cloud.mean_of(&|sample| of_sample(sample).exp()) / likelihood(best).exp();
        self.cloud.weigh(&of_sample);
        let before = self.explained.unwrap_or([explained; 2]);
        let [short, long] = [0, 1].map(|mean| before[mean] + DECAY[mean] * (explained - before[mean]));
        self.explained = Some([short, long]);
        let lost_share = (1.0 - short / long.max(f64::MIN_POSITIVE)).max(0.0);
        let forth = Way::between(&at, &self.sampled).exactly();
        self.cloud.replace(lost_share, &self.constants, &forth, &|rng, pose| drawn_from(seen, pose, rng));
    }

    fn step(&mut self, step: &Step) {
        self.odometry.add(step);
        let (ready, waiting): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.waiting).into_iter().partition(|(stamp_s, ..)| *stamp_s <= step.stamp_s);
        self.waiting = waiting;
        ready.into_iter().for_each(|(stamp_s, mounted, seen)| self.weigh(stamp_s, mounted, &seen));
        if step.stamp_s - self.sampled.stamp_s > LONGEST_WAY_S {
            self.carry(self.odometry.latest());
        }
    }
}

/// The pose that explains a measurement of a position best; `None` for a measurement that does not tell where in the building the robot is.
fn best_pose(seen: &Seen, heading_rad: f64) -> Option<[f64; 3]> {
    match seen {
        Seen::Pose { pose, .. } => Some(*pose),
        Seen::Position { in_robot_m, in_world_m, .. } => {
            let [dx, dy] = turned(*in_robot_m, heading_rad);
            Some([in_world_m[0] - dx, in_world_m[1] - dy, heading_rad])
        }
        Seen::Joints(_) | Seen::Edges(_) | Seen::Lines(_) | Seen::Landmarks(_) => None,
    }
}

/// A pose drawn from a measurement of a position, for a sample that is lost. A heading that the measurement does not tell is that of the sample, but
/// for an error; a heading that it tells is told up to whole turns, of which the samples keep count.
fn drawn_from(seen: &Seen, lost: [f64; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    let normal = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
    let heading_rad = lost[2] + LOST_RAD * normal[2];
    let Some(best) = best_pose(seen, heading_rad) else { return lost };
    match seen {
        Seen::Pose { covariance, .. } => {
            let off = covariance.cholesky().map_or_else(Vector3::zeros, |root| root.l() * normal);
            let turns = ((lost[2] - best[2]) / (2.0 * PI)).round();
            [best[0] + off[0], best[1] + off[1], best[2] + off[2] + 2.0 * PI * turns]
        }
        Seen::Position { sigma_m, .. } => [best[0] + sigma_m * normal[0], best[1] + sigma_m * normal[1], best[2]],
        Seen::Joints(_) | Seen::Edges(_) | Seen::Lines(_) | Seen::Landmarks(_) => lost,
    }
}

impl Subject for ParticleFilter {
    fn name(&self) -> &str {
        &self.name
    }

    fn start(&mut self, start: &PoseBox) {
        self.cues.restart(&self.robot);
        self.begin(start);
    }

    fn observe(&mut self, reading: &Reading) {
        match self.cues.take(reading) {
            None => {}
            Some(Told::Step(step)) => self.step(&step),
            Some(Told::Seen(stamp_s, mounted, seen)) => {
                if stamp_s > self.odometry.latest().stamp_s {
                    self.waiting.push((stamp_s, mounted, seen));
                } else {
                    self.weigh(stamp_s, mounted, &seen);
                }
            }
        }
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        let latest = self.odometry.latest();
        let way = Way::between(&self.sampled, &latest);
        // Between two readings of the wheels the robot goes on as it did.
        let ahead_s = (time_s - latest.stamp_s).clamp(0.0, LONGEST_WAY_S);
        let twist = self.cues.twist();
        let answer = |sample: &Sample| {
            let [x_m, y_m, heading_rad] = way.from(sample.pose, &sample.errors);
            let turn_rad = twist.turn_rad_per_s * ahead_s;
            let [dx, dy] = turned([twist.forward_m_per_s * ahead_s, 0.0], heading_rad + 0.5 * turn_rad);
            let pose = Pose { x_m: x_m + dx, y_m: y_m + dy, heading_rad: heading_rad + turn_rad };
            WeightedPose { pose, weight: sample.log_weight.exp() }
        };
        Answer::Samples(self.cloud.samples.iter().map(answer).collect())
    }

    fn knows_until_s(&self) -> Option<f64> {
        Some(self.odometry.latest().stamp_s)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
