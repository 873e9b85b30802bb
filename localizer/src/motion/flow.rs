//! From optical flow to motion: an enclosure of where the robot has gone that does not depend on the wheels.
//!
//! The sensor sees the floor pass at its own place a (the lever arm). Its travel d in the body's frame is that of the axle middle plus turn × a,
//! so that the axle middle travels d_f + dφ·a_l forward and d_l − dφ·a_f to the left. Over a span of time the sensor is displaced by ∫ R(φ) dd.
//!
//! **Scale.** The sensor counts dc = s(t)·n·dd with n nominal counts per metre. The scale s(t) is s₀ except for what the sensor's height over
//! the floor makes of it: s₀ is one unknown of the whole run, while |s(t)/s₀ − 1| ≤ κ may have another value at every instant. With the run's
//! own metres per count m = 1/(n·s₀), dd = m·(s₀/s)·dc, and s₀/s lies in [1/(1 + κ), 1/(1 − κ)], which is 1/(1 − κ²)·(1 ± κ).
//! With m′ = m/(1 − κ²) that gives
//!
//! ```text
//! ∫ R(φ) dd = m′·∫ R(φ) dc + rest,   |rest along x| ≤ κ·m′·∫ |cos φ|·|dc_f| + |sin φ|·|dc_l|,   along y with both exchanged
//! ```
//!
//! The first term is one unknown times a sum. The rest grows with the length of the path, step by step, and with the path of the lever arm in a
//! turn on the spot too: where the scale changes before the sensor comes back, the errors do not cancel.
//!
//! **Path.** Of the length P of a period's path no more than b goes back and forth, P ≤ |∫ dd| + b: at most b/2 of it goes against the rest, and
//! is counted at (1 + κ)/m per metre at most. So ∫ |dc| ≤ |Δc| + (1 + κ)·b/m and m′·∫ |dc| ≤ m′·|Δc| + b/(1 − κ); and |∫ dd| ≤ m·|Δc| + κ·P (by
//! dd = m·dc + (1 − s/s₀)·dd), hence P ≤ (m·|Δc| + b)/(1 − κ).
//!
//! **Quantisation.** What is read is c plus an error that lies, per axis, in one interval of width w at all stamps, hence within w/2 of its
//! middle: a vector of length w/√2 at most. The error telescopes in ∫ R dc: by summation by parts it acts at both ends and with the total
//! turning, (2 + ∫ |dφ|)·w/√2. Where the scale varies, it does not telescope in metres: every step's |Δc| may be greater by w.

use interval::{Interval, IntervalBox};

use crate::robot::FlowModel;

use super::Motion;

/// Motion of the robot since a stamp by the optical flow sensor (which sees the floor pass), integrated one reading at a time.
#[derive(Clone, Debug)]
pub struct FlowIntegral {
    /// Sum over the flow sensor's readings of Δc·cos φ, with the counts Δc of a reading, forward and left, and the heading φ relative to that at
    /// the start.
    cos_counts: [Interval; 2],
    /// Sum over the flow sensor's readings of Δc·sin φ, with the counts Δc of a reading, forward and left, and the heading φ relative to that at
    /// the start.
    sin_counts: [Interval; 2],
    turn_rad: Interval,
    /// Bound on the robot's total turning ∫ |dφ| since the start.
    turning_rad: f64,
    /// Bound on the error that a varying scale of the counts makes in the travel, along x and along y of the frame at the start.
    varied_m: [f64; 2],
    /// Bound on the travel error from using the heading at a step's middle for the whole step.
    remainder_m: f64,
}

impl FlowIntegral {
    /// An integral of the flow sensor's motion at its start, without motion.
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

    /// Adds the counts of one flow sensor reading, forward and left.
    ///
    /// `turn_rad` encloses the turn from the start to the reading's stamp, and `step_turn_rad` bounds the turning between this reading and the
    /// one before; both come from another sensor. `excess_m` bounds by how much the path of the step is longer than the distance between its
    /// ends, on either axis.
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
        // Bound κ·m′·∫ |dc| on the error of the step's travel that a varying scale of the flow sensor's counts c causes, forward and left: the
        // scale varies by up to the fraction κ, and m′ is about the length of one count.
        let varied_m =
            counted_m.map(|counted_m| change * (counted_m / (1.0 - change * change) + excess_m / (1.0 - change)));
        let (cos, sin) = (cos.magnitude(), sin.magnitude());
        self.varied_m[0] += cos * varied_m[0] + sin * varied_m[1];
        self.varied_m[1] += sin * varied_m[0] + cos * varied_m[1];
        // Greatest length of the path that the flow sensor covers in the step, forward and left.
        let way_m = counted_m.map(|counted_m| (counted_m + excess_m) / (1.0 - change));
        // Within a step the robot's heading departs from the mean of its values at both ends by at most half of the total turning in the step.
        self.remainder_m += 0.5 * step_turn_rad * (way_m[0] + way_m[1]);
        self.turning_rad += step_turn_rad;
        self.turn_rad = turn_rad;
    }

    /// Motion of the axle middle from the start to the latest reading; its turn is the one that was given for that reading. Where the sensor's
    /// counts at the start and at the end were interpolated between readings, `bent_m` bounds the sensor's distance from the interpolated
    /// positions, summed over both ends.
    pub fn motion(&self, bent_m: f64, model: &FlowModel) -> Motion {
        let (mount_cos, mount_sin) = (model.yaw_rad.cos(), model.yaw_rad.sin());
        // The sum Σ R(φ)·(counts forward, counts left). The rotation by the mount's yaw follows later, as rotations about the same axis commute.
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
        // While the axle middle stays and the robot turns by φ, the sensor's place moves by (R(φ) − 1)·a, which is subtracted.
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

/// Factor by which a sum of positive error bounds is increased, to make up for the few roundings of the sum.
const ABOVE: f64 = 1.0 + 1e-12;

/// Result of comparing the wheels' enclosure of a motion with the flow sensor's.
#[derive(Clone, Debug, PartialEq)]
pub enum Agreement {
    /// The wheels and the flow sensor agree: the motions that both allow.
    Both(Motion),
    /// The flow sensor's motion, which has nothing in common with the wheels' motion: the wheels slipped by more than their bound, since the
    /// flow sensor does not depend on the wheels.
    SlipCertified(Motion),
}

/// Intersects the wheels' enclosure of a motion with the flow sensor's. Where the flow sensor saw nothing (`None`), the wheels' enclosure stands
/// alone.
pub fn agree(wheels: &Motion, flow: Option<&Motion>) -> Agreement {
    let Some(flow) = flow else { return Agreement::Both(*wheels) };
    let both = wheels.intersect(flow);
    if both.is_empty() { Agreement::SlipCertified(*flow) } else { Agreement::Both(both) }
}
