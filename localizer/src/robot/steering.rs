//! Model of a car's steering, and of the encoder that reads its angle.

use interval::Interval;

/// Model of a car's steering with an encoder: `reading = round((scale·δ + zero)/rad_per_tick)`, with the steering angle δ of a wheel in the middle
/// of the front axle, positive to the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringModel {
    /// Distance from the axle of the drive wheels to the steered front axle (bound `wheels.wheelbase`).
    pub wheelbase_m: Interval,
    /// Angle that one tick of the steering encoder stands for.
    pub rad_per_tick: f64,
    /// Angle that the steering encoder reads when the car is steered straight ahead (bound `steering_encoder.zero`).
    pub zero_rad: Interval,
    /// Scale factor of the steering encoder (bound `steering_encoder.scale`).
    pub scale: Interval,
    /// Greatest rate at which the steering angle changes (bound `wheels.steering_rate`).
    pub rate_rad_per_s: f64,
    /// Part of the bound `wheels.steering_slip` that grows with the turn: over any time window of the wheels' `slip_window_s`, `|turn − ∫ tan δ/L dT|
    /// ≤ slip_share·∫ |tan δ/L dT| + slip_rad_per_m·|rolled| + slip_floor_rad`, with the wheelbase L, the true travel T of the middle of the rear
    /// axle, and the mean distance `rolled` that both rear wheels roll.
    pub slip_share: f64,
    /// Part of the bound `wheels.steering_slip` that grows with the distance.
    pub slip_rad_per_m: f64,
    /// Constant part of the bound `wheels.steering_slip`. Over a longer span it counts once for every window of `slip_window_s` that is begun.
    pub slip_floor_rad: f64,
}

impl SteeringModel {
    /// The steering angles at which the encoder reads this number of ticks.
    pub fn angle_rad(&self, ticks: f64) -> Interval {
        (Interval::centred(ticks, 0.5) * self.rad_per_tick - self.zero_rad) / self.scale
    }
}
