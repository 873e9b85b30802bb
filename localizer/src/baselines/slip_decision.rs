//! Paper 2's decision on slip: encoders while they agree with the flow sensor, its weighted mean with them when they do not.

/// Level and weight; the paper states neither.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipDecision {
    /// Greatest difference, over one step, of encoders and flow sensor that is no slip.
    pub level_m: f64,
    /// Share of the flow sensor in the travel of a step with slip.
    pub flow_weight: f64,
}

impl SlipDecision {
    /// Travel in one step, forward and left, of a robot whose wheels tell `rolled_m` forward and whose flow sensor, its lever arm
    /// accounted for, tells `flow_m`. Wheels know of no travel to the side.
    pub fn travel_m(&self, rolled_m: f64, flow_m: [f64; 2]) -> [f64; 2] {
        let off_m = (rolled_m - flow_m[0]).hypot(flow_m[1]);
        if off_m <= self.level_m {
            return [rolled_m, 0.0];
        }
        [rolled_m + self.flow_weight * (flow_m[0] - rolled_m), self.flow_weight * flow_m[1]]
    }
}
