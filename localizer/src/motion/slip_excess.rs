//! Wheel slip beyond its declared bound, in known spans of time. The simulator, which knows the slip, gives them when it computes what a run would
//! have been with wider bounds.

use std::borrow::Cow;

use crate::robot::WheelModel;

/// A span of time in which the declared bounds of slip are exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipExcess {
    /// Begin and end of the span of time in which slip exceeds its bounds.
    pub span_s: [f64; 2],
    /// Amount by which the constant part (floor) of the declared slip bound is too small, in every time window that has time in common with the
    /// span; the slip bound holds for each such window.
    pub slip_m: f64,
    /// Amount by which the constant part (floor) of the declared bound on side slip is too small.
    pub side_slip_m: f64,
}

impl SlipExcess {
    /// The model of the wheels for a span of time. If the wheels provably slipped by more than declared within the span, the constant parts of the
    /// bounds on slip (floors) are raised to that slip; otherwise the model is the declared one.
    pub(super) fn over<'a>(excesses: &[SlipExcess], span_s: [f64; 2], wheels: &'a WheelModel) -> Cow<'a, WheelModel> {
        let meets = |excess: &&SlipExcess| excess.span_s[0] <= span_s[1] && span_s[0] <= excess.span_s[1];
        excesses.iter().filter(meets).fold(Cow::Borrowed(wheels), |mut wheels, excess| {
            let wider = wheels.to_mut();
            // A time window of the slip bound may meet two spans of excess slip and contain the slip of both, so their amounts add up.
            wider.slip_floor_m += excess.slip_m;
            wider.side_slip_floor_m += excess.side_slip_m;
            wheels
        })
    }
}
