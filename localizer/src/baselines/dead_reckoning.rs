//! Dead reckoning as a point method. It is the odometry of paper 2 (Yi, Lee and Cho 2018), in steps of 10 ms by wheels and gyroscope, with or
//! without the flow sensor; and what a careful engineer makes of the same sensors: the gyroscope's bias is subtracted, and the travel is that of
//! the flow sensor alone.

use std::collections::VecDeque;

use crate::{
    Pose,
    robot::{FlowModel, GyroModel, WheelModel},
};

use super::{GyroAtRest, SlipDecision};

/// Sensor from which the travel is taken; the turn always comes from the gyroscope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// The wheel encoders.
    Wheels,
    /// The wheels where they agree with the flow sensor, otherwise the weighted mean of both: the slip decision of paper 2 (Yi, Lee and Cho 2018).
    Decided(FlowModel, SlipDecision),
    /// The flow sensor, which wheel slip does not affect; the wheels while the flow sensor is blind (sees nothing of the floor).
    Flow(FlowModel),
}

/// A robot pose by dead reckoning: a point estimate that is carried on by the sensors' readings with their nominal calibration.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    pose: Pose,
    wheels: WheelModel,
    gyro: GyroModel,
    at_rest: Option<GyroAtRest>,
    way: Way,
    ticks: Option<[i64; 2]>,
    /// Turn by the gyroscope since the wheels' latest reading.
    turn_rad: f64,
    /// Totals of the flow sensor at its latest reading.
    counts: Option<[i64; 2]>,
    /// Counts of the flow sensor since the last step of dead reckoning that used them.
    counted: [i64; 2],
    /// Motion by wheels and gyroscope since the flow sensor's latest reading.
    unseen: Unseen,
    /// Total number of periods in which the flow sensor saw nothing, at its latest reading.
    blind_periods: u64,
    /// Whether there was a period in which the flow sensor was blind (saw nothing of the floor) since its counts were last used.
    is_blind: bool,
    /// Distance by the wheels and travel by the flow sensor, forward and left, in each of the latest steps.
    latest_m: VecDeque<(f64, [f64; 2])>,
}

/// Motion by wheels and gyroscope for which no reading of the flow sensor has been used yet.
#[derive(Clone, Copy, Debug, Default)]
struct Unseen {
    rolled_m: f64,
    turn_rad: f64,
    /// Whether a flow sensor reading that covers this motion has arrived.
    is_over: bool,
}

/// Number of steps over which wheels and flow sensor are compared: within one step of 10 ms the encoders' quantisation is as large as slip is.
const COMPARED_STEPS: usize = 10;

impl DeadReckoning {
    /// Dead reckoning that starts at the pose `start`, with the gyroscope's nominal bias.
    pub fn new(start: Pose, wheels: WheelModel, gyro: GyroModel, way: Way) -> Self {
        DeadReckoning {
            pose: start,
            wheels,
            gyro,
            at_rest: None,
            way,
            ticks: None,
            turn_rad: 0.0,
            counts: None,
            counted: [0; 2],
            unseen: Unseen::default(),
            blind_periods: 0,
            is_blind: false,
            latest_m: VecDeque::new(),
        }
    }

    /// The same dead reckoning with the gyroscope's bias as it is found whenever the robot stands.
    pub fn with_gyro_at_rest(self) -> Self {
        DeadReckoning { at_rest: Some(GyroAtRest::new(self.gyro)), ..self }
    }

    /// Adds a turn rate of the gyroscope, which is the mean over its period.
    pub fn turn(&mut self, rate_rad_per_s: f64) {
        let nominal_rad_per_s = self.gyro.bias_rad_per_s.mid();
        let bias_rad_per_s = self.at_rest.as_mut().map_or(nominal_rad_per_s, |at_rest| {
            at_rest.rate(rate_rad_per_s);
            at_rest.bias_rad_per_s()
        });
        let rate_rad_per_s = (rate_rad_per_s - bias_rad_per_s) / self.gyro.scale.mid();
        self.turn_rad += rate_rad_per_s * self.gyro.period_s;
    }

    /// Adds a reading of the flow sensor: its totals of counts and of blind periods.
    pub fn flow(&mut self, counts: [i64; 2], blind_periods: u64) {
        if let Some(before) = self.counts.replace(counts) {
            (0..2).for_each(|axis| self.counted[axis] += counts[axis] - before[axis]);
        }
        self.unseen.is_over = true;
        self.is_blind |= blind_periods != self.blind_periods;
        self.blind_periods = blind_periods;
    }

    /// Carries the pose on to the next encoder reading by the step (dx_r, dy_r, dθ_gyro), in the robot's frame at the middle of the step.
    pub fn roll(&mut self, ticks: [i64; 2]) {
        let turn_rad = std::mem::take(&mut self.turn_rad);
        let Some(before) = self.ticks.replace(ticks) else {
            (self.counted, self.is_blind) = ([0; 2], false);
            return;
        };
        if ticks != before
            && let Some(at_rest) = &mut self.at_rest
        {
            at_rest.moved();
        }
        let rolled_m = 0.5
            * (0..2)
                .map(|wheel| (ticks[wheel] - before[wheel]) as f64 * self.wheels.metres_per_tick(wheel).mid())
                .sum::<f64>();
        let travel_m = match self.way {
            Way::Wheels => [rolled_m, 0.0],
            Way::Decided(model, decision) => self.decided_m(&model, &decision, rolled_m, turn_rad),
            Way::Flow(model) => self.seen_m(&model, rolled_m, turn_rad),
        };
        let (sin, cos) = (self.pose.heading_rad + 0.5 * turn_rad).sin_cos();
        self.pose.x_m += cos * travel_m[0] - sin * travel_m[1];
        self.pose.y_m += sin * travel_m[0] + cos * travel_m[1];
        self.pose.heading_rad += turn_rad;
    }

    /// What the flow sensor has counted since the last call of this function, in metres along its own axes; `None` if it was blind in that time.
    fn take_counted_m(&mut self, model: &FlowModel) -> Option<[f64; 2]> {
        let (counted, is_blind) = (std::mem::take(&mut self.counted), std::mem::take(&mut self.is_blind));
        (!is_blind).then(|| counted.map(|count| count as f64 * model.metres_per_count.mid()))
    }

    fn decided_m(&mut self, model: &FlowModel, decision: &SlipDecision, rolled_m: f64, turn_rad: f64) -> [f64; 2] {
        let Some(counted_m) = self.take_counted_m(model) else { return [rolled_m, 0.0] };
        let flow_m = without_arm(model, counted_m, turn_rad);
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

    /// Travel of the robot by the flow sensor, forward and left, in one step of the wheels. It is zero in steps without a new reading of the flow
    /// sensor; the step with a reading gets all travel since the reading before.
    fn seen_m(&mut self, model: &FlowModel, rolled_m: f64, turn_rad: f64) -> [f64; 2] {
        self.unseen.rolled_m += rolled_m;
        self.unseen.turn_rad += turn_rad;
        if !self.unseen.is_over {
            return [0.0, 0.0];
        }
        let unseen = std::mem::take(&mut self.unseen);
        let Some([forward_m, left_m]) = self.take_counted_m(model) else { return [unseen.rolled_m, 0.0] };
        let (sin, cos) = model.yaw_rad.mid().sin_cos();
        let in_robot_m = [cos * forward_m - sin * left_m, sin * forward_m + cos * left_m];
        without_arm(model, in_robot_m, unseen.turn_rad)
    }

    /// The pose at the latest encoder reading.
    pub fn pose(&self) -> Pose {
        self.pose
    }
}

/// Travel of the robot origin, from what a sensor saw at its own place, which moves by turn × arm relative to the origin.
fn without_arm(model: &FlowModel, seen_m: [f64; 2], turn_rad: f64) -> [f64; 2] {
    let [arm_forward_m, arm_left_m] = model.position_m.map(|at| at.mid());
    [seen_m[0] + turn_rad * arm_left_m, seen_m[1] - turn_rad * arm_forward_m]
}
