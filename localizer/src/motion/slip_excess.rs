//! Slip beyond its declared bound, in spans that somebody knows of who saw it: the simulator, when it asks what a run would have been.

use std::borrow::Cow;

use crate::robot::WheelModel;

/// A span in which bounds of slip are exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipExcess {
    /// Its begin and end.
    pub span_s: [f64; 2],
    /// What the floor of the slip bound lacks, over any window that has time in common with the span.
    pub slip_m: f64,
    /// What the floor of the side slip's lacks.
    pub side_slip_m: f64,
}

impl SlipExcess {
    /// The wheels' model over a span: its floors as wide as slip was where the span meets excesses, and as declared elsewhere.
    pub(super) fn over<'a>(excesses: &[SlipExcess], span_s: [f64; 2], wheels: &'a WheelModel) -> Cow<'a, WheelModel> {
        let meets = |excess: &&SlipExcess| excess.span_s[0] <= span_s[1] && span_s[0] <= excess.span_s[1];
        excesses.iter().filter(meets).fold(Cow::Borrowed(wheels), |mut wheels, excess| {
            let wider = wheels.to_mut();
            // One window may meet two excesses, and hold what is beyond in both.
            wider.slip_floor_m += excess.slip_m;
            wider.side_slip_floor_m += excess.side_slip_m;
            wheels
        })
    }
}
