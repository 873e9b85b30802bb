//! Optical flow to motion: an enclosure of where the robot has gone, that knows of no wheel.
//!
//! The sensor sees the floor pass at its own place a (the lever arm). Its travel d in the body's frame is that of the axle middle plus
//! turn × a, so that dF = dS_f + dφ·a_l and dL = dS_l − dφ·a_f; over a span, ∫ R(φ) dd.
//!
//! **Scale.** It counts dc = s(t)·n·dd with n nominal counts per metre. s(t) = s₀ but for what its height over the floor makes of it:
//! s₀ is one unknown of the whole run, while |s(t)/s₀ − 1| ≤ κ may be another at every instant. With the run's own m = 1/(n·s₀),
//! dd = m·(s₀/s)·dc, and s₀/s lies in [1/(1 + κ), 1/(1 − κ)], which is 1/(1 − κ²)·(1 ± κ). So with m′ = m/(1 − κ²)
//!
//! ```text
//! ∫ R(φ) dd = m′·∫ R(φ) dc + rest,   |rest along x| ≤ κ·m′·∫ |cos φ|·|dc_f| + |sin φ|·|dc_l|,   along y with both exchanged
//! ```
//!
//! The first is one unknown times a sum; the second is paid by the way, step by step, and by the lever arm's way in a turn on the spot too:
//! a scale that flips when the sensor comes back does not cancel.
//!
//! **Way.** Of a period's way P no more than b goes back and forth, P ≤ |∫ dd| + b: at most b/2 of it goes against the rest, and is counted at
//! (1 + κ)/m per metre at most. So ∫ |dc| ≤ |Δc| + (1 + κ)·b/m and m′·∫ |dc| ≤ m′·|Δc| + b/(1 − κ); and |∫ dd| ≤ m·|Δc| + κ·P (by
//! dd = m·dc + (1 − s/s₀)·dd), hence P ≤ (m·|Δc| + b)/(1 − κ).
//!
//! **Quantisation.** What is read is c plus an error that lies, per axis, in one interval of width w at all stamps, hence within w/2 of
//! its middle: a vector of length w/√2 at most. It telescopes in ∫ R dc: by summation by parts it acts at both ends and with the
//! total turning, (2 + ∫ |dφ|)·w/√2. Where the scale varies it does not telescope in metres: every step's |Δc| may be greater by w.

use interval::{Interval, IntervalBox};

use crate::robot::FlowModel;

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
    /// Bound, along x and along y at the start, of what a scale that varies makes of the way.
    varied_m: [f64; 2],
    /// Bound of what the heading of a step's middle leaves out.
    remainder_m: f64,
}

impl FlowIntegral {
    /// An integral that has not moved.
    pub fn new() -> Self {
        FlowIntegral {
            cos_counts: [Interval::ZERO; 2],
            sin_counts: [Interval::ZERO; 2],
            turn_rad: Interval::ZERO,
            turning_rad: 0.0,
            varied_m: [0.0; 2],
            remainder_m: 0.0,
        }
    }

    /// Goes on by the counts of one reading, forward and left.
    ///
    /// `turn_rad` encloses the turn since the start at the reading's stamp, and `step_turn_rad` bounds the turning between this reading and the
    /// one before; both come from another sensor. `excess_m` bounds what the way of the step is longer than its ends tell, on either axis.
    pub fn advance(
        &mut self,
        counts: [f64; 2],
        turn_rad: Interval,
        step_turn_rad: f64,
        excess_m: f64,
        model: &FlowModel,
    ) {
        let middle = (self.turn_rad + turn_rad) * 0.5;
        let (cos, sin) = (middle.cos(), middle.sin());
        for (axis, counts) in counts.into_iter().enumerate() {
            self.cos_counts[axis] += cos * counts;
            self.sin_counts[axis] += sin * counts;
        }
        let change = model.scale_change;
        let counted_m = counts.map(|counts| (counts.abs() + model.quantisation_counts) * model.metres_per_count.hi());
        // κ·m′·∫ |dc|, forward and left.
        let varied_m =
            counted_m.map(|counted_m| change * (counted_m / (1.0 - change * change) + excess_m / (1.0 - change)));
        let (cos, sin) = (cos.magnitude(), sin.magnitude());
        self.varied_m[0] += cos * varied_m[0] + sin * varied_m[1];
        self.varied_m[1] += sin * varied_m[0] + cos * varied_m[1];
        // P, forward and left.
        let way_m = counted_m.map(|counted_m| (counted_m + excess_m) / (1.0 - change));
        // Within a step the heading departs from the mean of its ends by at most half of the turning.
        self.remainder_m += 0.5 * step_turn_rad * (way_m[0] + way_m[1]);
        self.turning_rad += step_turn_rad;
        self.turn_rad = turn_rad;
    }

    /// Motion of the axle middle from the start to the latest reading; the turn is the one that was told. Where totals at the ends were
    /// interpolated, the sensor was up to `bent_m` from there, at both ends together.
    pub fn motion(&self, bent_m: f64, model: &FlowModel) -> Motion {
        let (mount_cos, mount_sin) = (model.yaw_rad.cos(), model.yaw_rad.sin());
        // Σ R(φ)·(counts forward, counts left), then the mount's turn, which commutes with those about the same axis.
        let x_counts = self.cos_counts[0] - self.sin_counts[1];
        let y_counts = self.sin_counts[0] + self.cos_counts[1];
        let lost_counts = std::f64::consts::FRAC_1_SQRT_2 * model.quantisation_counts * (2.0 + self.turning_rad);
        let change = Interval::point(model.scale_change);
        let metres_per_count = model.metres_per_count / (Interval::ONE - change * change);
        let [x, y] = [(x_counts, self.varied_m[0]), (y_counts, self.varied_m[1])].map(|(counts, varied_m)| {
            (counts.inflate(lost_counts * ABOVE) * metres_per_count)
                .inflate((varied_m + self.remainder_m + bent_m) * ABOVE)
        });
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
