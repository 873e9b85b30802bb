//! When slip was certified: wheels and flow sensor had nothing in common, so that the wheels are left out.

use crate::{
    RobotModel,
    motion::{Agreement, Motion, WheelHistory, agree},
};

/// Wheels are left out for so long after they were last seen to slip: slip that goes on needs some time to show anew.
const LEFT_OUT_S: f64 = 0.5;
/// Slip that is seen now may have begun so long before: until wheels and flow sensor are farther apart than both are wide, what they have
/// in common may already be beside the truth.
pub(super) const UNSEEN_S: f64 = 1.0;

/// Spans in which the wheels are left out.
#[derive(Clone, Debug)]
pub(super) struct CertifiedSlip {
    spans_s: Vec<[f64; 2]>,
    keep_s: f64,
}

impl CertifiedSlip {
    /// None yet; a span is kept for as long as the wheels are remembered.
    pub(super) fn new(keep_s: f64) -> Self {
        CertifiedSlip { spans_s: Vec::new(), keep_s }
    }

    /// The wheels slipped somewhere in this span, the last of which is now, and perhaps [`UNSEEN_S`] before it. Answers whether that is
    /// news: whether no span before reached as far.
    pub(super) fn certify(&mut self, [from_s, now_s]: [f64; 2]) -> bool {
        self.spans_s.retain(|span_s| span_s[1] > now_s - self.keep_s);
        match self.spans_s.last_mut() {
            Some(latest) if from_s <= latest[1] => {
                latest[1] = now_s + LEFT_OUT_S;
                false
            }
            _ => {
                self.spans_s.push([from_s - UNSEEN_S, now_s + LEFT_OUT_S]);
                true
            }
        }
    }

    /// Whether the wheels are left out of a span.
    fn covers(&self, [from_s, to_s]: [f64; 2]) -> bool {
        self.spans_s.iter().any(|span_s| span_s[0] < to_s && from_s < span_s[1])
    }

    /// Motion of the robot over a span of time: what wheels and flow sensor both allow. Where the wheels are known to slip, what the flow sensor alone
    /// allows, and if it followed nothing then, what the limits of speed and acceleration allow. `None` if the remembered readings of the wheels do not
    /// cover the span.
    pub(super) fn motion(
        &self,
        span_s: [f64; 2],
        rolled: Option<Motion>,
        flow: Option<Motion>,
        wheels: &WheelHistory,
        robot: &RobotModel,
    ) -> Option<Motion> {
        match (self.covers(span_s), flow) {
            (true, Some(flow)) => Some(flow),
            (true, None) => Some(wheels.reach_motion(span_s[0], span_s[1], &robot.reach)),
            (false, flow) => Some(match agree(&rolled?, flow.as_ref()) {
                Agreement::Both(motion) | Agreement::SlipCertified(motion) => motion,
            }),
        }
    }
}
