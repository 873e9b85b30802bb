//! Paper 2's methods to compare with, on the same readings: dead reckoning by wheels and gyroscope, the same with the flow sensor, and
//! the paper's whole system. In addition, dead reckoning that learns the gyroscope's bias at rest, which the paper's does not.

use localizer::{
    Pose, Reading, RobotModel,
    baselines::{CorrectedReckoning, DeadReckoning, SlipDecision, Way},
};

use crate::scene::{MethodName, Scene};

/// Name of dead reckoning by wheels and gyroscope.
pub(super) const WHEELS_AND_GYRO: &str = "wheels_and_gyro";
/// Name of dead reckoning by wheels or flow sensor, as paper 2 decides between them.
pub(super) const SLIP_DECISION: &str = "slip_decision";
/// Name of dead reckoning by wheels and gyroscope that learns the gyroscope's bias at rest.
pub(super) const GYRO_AT_REST: &str = "gyro_at_rest";
/// Name of dead reckoning by flow sensor and gyroscope.
pub(super) const FLOW_AND_GYRO: &str = "flow_and_gyro";
/// Name of paper 2's whole system.
pub(super) const POSE_GRAPH: &str = "pose_graph";

/// Threshold and weight of paper 2's decision that the wheels slip. The threshold of 1 mm over 0.1 s is a difference of 4 % at 0.25 m/s:
/// the encoders' steps of 0.3 mm and a scale error of 0.3 % stay below it. The paper states neither number.
const SLIPS: SlipDecision = SlipDecision { level_m: 0.001, flow_weight: 0.9 };

/// Poses by dead reckoning at every step of the record. There are none for a robot without a gyroscope, nor for one that neither has a
/// flow sensor nor is led along its route.
#[derive(Clone, Debug, Default)]
pub struct MotionBaselines {
    /// Name and state of each method of dead reckoning.
    running: Vec<(&'static str, DeadReckoning)>,
    /// Paper 2's whole system, which corrects a dead reckoning by wall directions: the index in `running` of that dead reckoning, and the
    /// system's state. `None` where the scene does not use wall directions.
    corrected: Option<(usize, CorrectedReckoning)>,
    /// Name and poses of each dead reckoning, in the order of `running`, then those of the corrected one.
    pub poses: Vec<(&'static str, Vec<Pose>)>,
}

impl MotionBaselines {
    /// Creates the dead reckonings that the sensors of a scene's robot allow.
    pub(super) fn new(scene: &Scene, robot: &RobotModel) -> Self {
        let (mut running, mut papers) = (Vec::new(), 0);
        if let (Some(gyro), true) = (robot.gyro, robot.flow.is_some() || scene.is_led()) {
            let reckoning = |way| DeadReckoning::new(scene.nominal_start(), robot.wheels.clone(), gyro, way);
            running.push((WHEELS_AND_GYRO, reckoning(Way::Wheels)));
            if let Some(flow) = robot.flow {
                running.push((SLIP_DECISION, reckoning(Way::Decided(flow, SLIPS))));
            }
            papers = running.len() - 1;
            running.push((GYRO_AT_REST, reckoning(Way::Wheels).with_gyro_at_rest()));
            if let Some(flow) = robot.flow {
                running.push((FLOW_AND_GYRO, reckoning(Way::Flow(flow)).with_gyro_at_rest()));
            }
        }
        let looks = scene.localizer.methods.contains(&MethodName::WallDirections);
        let corrected =
            (looks && !running.is_empty()).then(|| (papers, CorrectedReckoning::new(scene.nominal_start())));
        let names = running.iter().map(|(name, _)| *name).chain(corrected.iter().map(|_| POSE_GRAPH));
        MotionBaselines { poses: names.map(|name| (name, Vec::new())).collect(), running, corrected }
    }

    /// Takes in the direction of the walls that paper 2's vision chain found.
    pub(super) fn see(&mut self, measured_s: f64, seen_rad: f64) {
        if let Some((_, corrected)) = &mut self.corrected {
            corrected.see(measured_s, seen_rad);
        }
    }

    /// Takes in a reading of wheels, gyroscope or flow sensor; other readings are ignored.
    pub(super) fn sense(&mut self, reading: &Reading) {
        for (_, reckoning) in &mut self.running {
            match reading {
                Reading::Wheels { ticks, .. } => reckoning.roll(*ticks),
                Reading::Gyro { rate_rad_per_s, .. } => reckoning.turn(*rate_rad_per_s),
                Reading::Flow { counts, blind_periods, .. } => reckoning.flow(*counts, *blind_periods),
                Reading::Camera { .. } | Reading::Range { .. } | Reading::Other { .. } => {}
            }
        }
    }

    /// Adds the poses of all dead reckonings at a step.
    pub(super) fn step(&mut self, time_s: f64) {
        for ((_, reckoning), (_, poses)) in self.running.iter().zip(&mut self.poses) {
            poses.push(reckoning.pose());
        }
        if let (Some((papers, corrected)), Some((_, poses))) = (&mut self.corrected, self.poses.last_mut())
            && let Some((_, reckoning)) = self.running.get(*papers)
        {
            corrected.reckon(time_s, reckoning.pose());
            poses.push(corrected.pose());
        }
    }
}
