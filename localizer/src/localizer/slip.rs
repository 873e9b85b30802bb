//! Proved slip of the wheels: where wheels and flow sensor contradict each other, the wheels slipped by more than declared, so that the wheel
//! readings are left out.

use crate::{
    RobotModel,
    motion::{Agreement, Motion, WheelHistory, agree},
};

/// Time for which the wheel readings are left out after the wheels were last seen to slip: slip that continues needs some time to be detected
/// again.
const LEFT_OUT_S: f64 = 0.5;
/// Time before the detection of slip at which the slip may have begun. Slip is detected when the motions that wheels and flow sensor allow no longer
/// overlap; before that, their intersection may already exclude the true motion.
pub(super) const UNSEEN_S: f64 = 1.0;

/// Time spans in which the wheel readings are left out, because they contradicted the flow sensor, which proves that the wheels slipped.
#[derive(Clone, Debug)]
pub(super) struct CertifiedSlip {
    spans_s: Vec<[f64; 2]>,
    keep_s: f64,
}

impl CertifiedSlip {
    /// A record without any span of slip; each span that is noted later is kept for `keep_s`, as long as wheel readings are remembered.
    pub(super) fn new(keep_s: f64) -> Self {
        CertifiedSlip { spans_s: Vec::new(), keep_s }
    }

    /// Notes that the wheels slipped somewhere in the given time span, which ends at the present, or up to [`UNSEEN_S`] before that span. Returns
    /// whether this begins a new span of slip; if the latest one reached up to the given span, it is prolonged instead.
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

    /// Whether the wheel readings are left out in some part of the given time span because the wheels slipped.
    pub(super) fn covers(&self, [from_s, to_s]: [f64; 2]) -> bool {
        self.spans_s.iter().any(|span_s| span_s[0] < to_s && from_s < span_s[1])
    }

    /// Motion of the robot over a span of time: what wheels and flow sensor both allow. Where the wheels are known to slip, what the flow sensor
    /// alone allows, and if it followed nothing then, what the limits of speed and turn rate allow. `None` if the remembered readings of the
    /// wheels do not cover the span.
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
