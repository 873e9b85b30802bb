//! Optical flow to motion: an enclosure of where the robot has gone, that knows of no wheel.
//!
//! The sensor sees the floor pass at its own place a (the lever arm). Its travel in the body's frame is that of the axle middle plus
//! turn × a, so that dF = dS_f + dφ·a_l and dL = dS_l − dφ·a_f; over a span, ∫ R(φ)·(dF, dL). Counts telescope: their quantisation acts
//! once at the end and, by summation by parts, with the total turning.

use crate::{Interval, IntervalBox, robot::FlowModel};

use super::Motion;

/// Motion since a stamp as the flow sensor tells it, one reading at a time.
#[derive(Clone, Debug)]
pub struct FlowIntegral {
    /// Σ Δc·cos φ and Σ Δc·sin φ, for the counts forward and left.
    cos_counts: [Interval; 2],
    sin_counts: [Interval; 2],
    turn_rad: Interval,
    /// Greatest total turning.
    turning_rad: f64,
    /// Bound, in counts, of what the heading of a step's middle leaves out.
    remainder_counts: f64,
}

impl FlowIntegral {
    /// An integral that has not moved.
    pub fn new() -> Self {
        FlowIntegral {
            cos_counts: [Interval::ZERO; 2],
            sin_counts: [Interval::ZERO; 2],
            turn_rad: Interval::ZERO,
            turning_rad: 0.0,
            remainder_counts: 0.0,
        }
    }

    /// Goes on by the counts of one reading, forward and left.
    ///
    /// `turn_rad` encloses the turn since the start at the reading's stamp, and `step_turn_rad` bounds the turning between this reading and the
    /// one before, `step_s` earlier; both come from another sensor.
    pub fn advance(
        &mut self,
        counts: [f64; 2],
        turn_rad: Interval,
        step_turn_rad: f64,
        step_s: f64,
        model: &FlowModel,
    ) {
        // Where readings are missing, as much may go forth and back in each of their periods.
        let back_and_forth_counts = model.back_and_forth_counts * (step_s / model.period_s - 1e-6).ceil().max(1.0);
        let middle = (self.turn_rad + turn_rad) * 0.5;
        let (cos, sin) = (middle.cos(), middle.sin());
        for (axis, counts) in counts.into_iter().enumerate() {
            self.cos_counts[axis] += cos * counts;
            self.sin_counts[axis] += sin * counts;
            // Within a step the heading is as far from its middle as the step turns; the way may be longer than the counts by
            // what the sensor goes forth and back within a period.
            self.remainder_counts += step_turn_rad * (counts.abs() + back_and_forth_counts);
        }
        self.turning_rad += step_turn_rad;
        self.turn_rad = turn_rad;
    }

    /// Motion of the axle middle from the start to the latest reading; the turn is the one that was told. The totals at both ends are off by up
    /// to `bent_counts` together, beyond their quantisation, where they were interpolated.
    pub fn motion(&self, bent_counts: f64, model: &FlowModel) -> Motion {
        let scale = model.metres_per_count;
        let (mount_cos, mount_sin) = (model.yaw_rad.cos(), model.yaw_rad.sin());
        // Σ R(φ)·(counts forward, counts left), then the mount's turn, which commutes with those about the same axis.
        let x = self.cos_counts[0] - self.sin_counts[1];
        let y = self.sin_counts[0] + self.cos_counts[1];
        let lost = (model.quantisation_counts * 2.0 + bent_counts) * (1.0 + self.turning_rad) + self.remainder_counts;
        let (x, y) = (x.inflate(lost * ABOVE) * scale, y.inflate(lost * ABOVE) * scale);
        let (x, y) = (x * mount_cos - y * mount_sin, x * mount_sin + y * mount_cos);
        // The sensor's place moves by (R(φ) − 1)·a while the axle middle stays.
        let [a_f, a_l] = model.position_m;
        let (cos, sin) = (self.turn_rad.cos(), self.turn_rad.sin());
        let one = Interval::point(1.0);
        IntervalBox::from([x - (a_f * (cos - one) - a_l * sin), y - (a_f * sin + a_l * (cos - one)), self.turn_rad])
    }
}

impl Default for FlowIntegral {
    fn default() -> Self {
        FlowIntegral::new()
    }
}

/// Makes up for the few roundings of a sum of positive terms.
const ABOVE: f64 = 1.0 + 1e-12;

/// One motion as two sensors tell it.
#[derive(Clone, Debug, PartialEq)]
pub enum Agreement {
    /// What both allow.
    Both(Motion),
    /// They have nothing in common: the wheels slipped more than their bound, for the flow sensor knows of no wheel.
    SlipCertified(Motion),
}

/// Wheels and flow sensor as contractors of one motion. A flow sensor that saw nothing leaves the wheels alone.
pub fn agree(wheels: &Motion, flow: Option<&Motion>) -> Agreement {
    let Some(flow) = flow else { return Agreement::Both(*wheels) };
    let both = wheels.intersect(flow);
    if both.is_empty() { Agreement::SlipCertified(*flow) } else { Agreement::Both(both) }
}
