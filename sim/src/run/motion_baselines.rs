//! Paper 2's comparisons on the same readings: dead reckoning by wheels and gyroscope, by the flow sensor too, and its whole system.

use localizer::{
    Pose, Reading, RobotModel,
    baselines::{CorrectedReckoning, DeadReckoning, SlipDecision},
};

use crate::scene::{MethodName, Scene};

/// Over 0.1 s, at 0.25 m/s a difference of 4 %: the encoders' steps of 0.3 mm and 0.3 % of scale stay below it. The paper states neither number.
const SLIP_DECISION: SlipDecision = SlipDecision { level_m: 0.001, flow_weight: 0.9 };

/// Poses at every step of the record; none for a robot without gyroscope or without anything to compare.
#[derive(Clone, Debug, Default)]
pub struct MotionBaselines {
    /// Name and reckoning.
    running: Vec<(&'static str, DeadReckoning)>,
    /// On top of the last of them, where the robot looks ahead.
    corrected: Option<CorrectedReckoning>,
    /// Name and poses, in the same order, the corrected one last.
    pub poses: Vec<(&'static str, Vec<Pose>)>,
}

impl MotionBaselines {
    /// Those that a scene's robot allows.
    pub(super) fn new(scene: &Scene, robot: &RobotModel) -> Self {
        let mut running = Vec::new();
        if let (Some(gyro), true) = (robot.gyro, robot.flow.is_some() || scene.is_led()) {
            let start = scene.nominal_start();
            running.push(("wheels_and_gyro", DeadReckoning::new(start, robot.wheels.clone(), gyro, None)));
            if let Some(flow) = robot.flow {
                let decision = Some((flow, SLIP_DECISION));
                running.push(("slip_decision", DeadReckoning::new(start, robot.wheels.clone(), gyro, decision)));
            }
        }
        let looks = scene.localizer.methods.contains(&MethodName::WallDirections);
        let corrected = (looks && !running.is_empty()).then(|| CorrectedReckoning::new(scene.nominal_start()));
        let names = running.iter().map(|(name, _)| *name).chain(corrected.iter().map(|_| "pose_graph"));
        MotionBaselines { poses: names.map(|name| (name, Vec::new())).collect(), running, corrected }
    }

    /// Takes in the direction of walls that the paper's chain saw from the robot.
    pub(super) fn see(&mut self, measured_s: f64, seen_rad: f64) {
        if let Some(corrected) = &mut self.corrected {
            corrected.see(measured_s, seen_rad);
        }
    }

    /// Takes in a reading.
    pub(super) fn sense(&mut self, reading: &Reading) {
        for (_, reckoning) in &mut self.running {
            match reading {
                Reading::Wheels { ticks, .. } => reckoning.roll(*ticks),
                Reading::Gyro { rate_rad_per_s, .. } => reckoning.turn(*rate_rad_per_s),
                Reading::Flow { counts, blind_periods, .. } => reckoning.flow(*counts, *blind_periods),
                Reading::Camera { .. } | Reading::Range { .. } => {}
            }
        }
    }

    /// Notes the poses of a step.
    pub(super) fn step(&mut self, time_s: f64) {
        for ((_, reckoning), (_, poses)) in self.running.iter().zip(&mut self.poses) {
            poses.push(reckoning.pose());
        }
        if let (Some(corrected), Some((_, reckoning)), Some((_, poses))) =
            (&mut self.corrected, self.running.last(), self.poses.last_mut())
        {
            corrected.reckon(time_s, reckoning.pose());
            poses.push(corrected.pose());
        }
    }
}
