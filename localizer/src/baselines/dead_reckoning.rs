//! Dead reckoning as a point: paper 2's odometry of 10 ms by wheels and gyroscope, with or without its flow sensor.

use std::collections::VecDeque;

use crate::{
    Pose,
    robot::{FlowModel, GyroModel, WheelModel},
};

use super::SlipDecision;

/// A pose that is carried on by nominal sensors.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    pose: Pose,
    wheels: WheelModel,
    gyro: GyroModel,
    flow: Option<(FlowModel, SlipDecision)>,
    ticks: Option<[i64; 2]>,
    /// Turn by the gyroscope, and counts of the flow sensor, since the wheels' latest reading.
    turn_rad: f64,
    counts: Option<[i64; 2]>,
    counted: [i64; 2],
    /// Whether the flow sensor saw nothing since then.
    blind_periods: u64,
    is_blind: bool,
    /// What the wheels rolled and the flow sensor saw, in each of the latest steps.
    latest_m: VecDeque<(f64, [f64; 2])>,
}

/// Steps over which the two are compared: in one of 10 ms the encoders' own steps are as large as slip is.
const COMPARED_STEPS: usize = 10;

impl DeadReckoning {
    /// Starts at `start`; with a flow sensor the wheels' travel is decided on by comparing the two.
    pub fn new(start: Pose, wheels: WheelModel, gyro: GyroModel, flow: Option<(FlowModel, SlipDecision)>) -> Self {
        DeadReckoning {
            pose: start,
            wheels,
            gyro,
            flow,
            ticks: None,
            turn_rad: 0.0,
            counts: None,
            counted: [0; 2],
            blind_periods: 0,
            is_blind: false,
            latest_m: VecDeque::new(),
        }
    }

    /// Takes in a turn rate, the mean over the gyroscope's period.
    pub fn turn(&mut self, rate_rad_per_s: f64) {
        let rate_rad_per_s = (rate_rad_per_s - self.gyro.bias_rad_per_s.mid()) / self.gyro.scale.mid();
        self.turn_rad += rate_rad_per_s * self.gyro.period_s;
    }

    /// Takes in totals of the flow sensor.
    pub fn flow(&mut self, counts: [i64; 2], blind_periods: u64) {
        if let Some(before) = self.counts.replace(counts) {
            (0..2).for_each(|axis| self.counted[axis] += counts[axis] - before[axis]);
        }
        self.is_blind |= blind_periods != self.blind_periods;
        self.blind_periods = blind_periods;
    }

    /// Goes on to the next encoder reading: (dx_r, dy_r, dθ_gyro), in the frame of the robot at the middle of the step.
    pub fn roll(&mut self, ticks: [i64; 2]) {
        let turn_rad = std::mem::take(&mut self.turn_rad);
        let (counted, is_blind) = (std::mem::take(&mut self.counted), std::mem::take(&mut self.is_blind));
        let Some(before) = self.ticks.replace(ticks) else { return };
        let rolled_m = 0.5
            * (0..2)
                .map(|wheel| (ticks[wheel] - before[wheel]) as f64 * self.wheels.metres_per_tick(wheel).mid())
                .sum::<f64>();
        let travel_m = match &self.flow {
            Some((model, decision)) if !is_blind => {
                let seen_m = counted.map(|count| count as f64 * model.metres_per_count.mid());
                // The sensor's own place moves by turn × arm.
                let [arm_f_m, arm_l_m] = model.position_m.map(|at| at.mid());
                let flow_m = [seen_m[0] + turn_rad * arm_l_m, seen_m[1] - turn_rad * arm_f_m];
                self.latest_m.push_back((rolled_m, flow_m));
                if self.latest_m.len() > COMPARED_STEPS {
                    self.latest_m.pop_front();
                }
                let sum = |part: fn(&(f64, [f64; 2])) -> f64| self.latest_m.iter().map(part).sum::<f64>();
                let (rolled, seen) = (sum(|step| step.0), [sum(|step| step.1[0]), sum(|step| step.1[1])]);
                let is_slip = decision.travel_m(rolled, seen) != [rolled, 0.0];
                let level_m = if is_slip { 0.0 } else { f64::INFINITY };
                SlipDecision { level_m, ..*decision }.travel_m(rolled_m, flow_m)
            }
            _ => [rolled_m, 0.0],
        };
        let (sin, cos) = (self.pose.heading_rad + 0.5 * turn_rad).sin_cos();
        self.pose.x_m += cos * travel_m[0] - sin * travel_m[1];
        self.pose.y_m += sin * travel_m[0] + cos * travel_m[1];
        self.pose.heading_rad += turn_rad;
    }

    /// The pose so far.
    pub fn pose(&self) -> Pose {
        self.pose
    }
}
