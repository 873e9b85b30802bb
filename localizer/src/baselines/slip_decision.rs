//! The slip decision of paper 2 (Yi, Lee and Cho 2018): the travel of a step is that of the wheel encoders while it agrees with the flow sensor's;
//! otherwise the wheels slip, and it is the weighted mean of both.

/// Threshold and weight of the slip decision; the paper states neither.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipDecision {
    /// Greatest difference between the encoders' and the flow sensor's travel over one step that does not count as slip.
    pub level_m: f64,
    /// Weight of the flow sensor, from 0 to 1, in the travel of a step with slip.
    pub flow_weight: f64,
}

impl SlipDecision {
    /// Travel of the robot in one step, forward and left, when its wheels report `rolled_m` forward and its flow sensor reports `flow_m`, from
    /// which the effect of the lever arm is subtracted. Wheels do not report travel to the side.
    pub fn travel_m(&self, rolled_m: f64, flow_m: [f64; 2]) -> [f64; 2] {
        let off_m = (rolled_m - flow_m[0]).hypot(flow_m[1]);
        if off_m <= self.level_m {
            return [rolled_m, 0.0];
        }
        [rolled_m + self.flow_weight * (flow_m[0] - rolled_m), self.flow_weight * flow_m[1]]
    }
}
