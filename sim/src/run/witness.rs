//! Whoever looks on while a run happens, such as a recording.

use localizer::{Estimate, Pose, Reading, localizer::Account};

use crate::truth::Truth;

/// Told of a run's events in their order. Nothing that it does reaches the run.
pub trait Witness {
    /// The localizer starts, at the scene's start or at a station; its times have `offset_s` added from now on, readings' have not.
    fn start(&mut self, offset_s: f64, station: Option<usize>);
    /// A reading is about to reach the localizer.
    fn sense(&mut self, reading: &Reading);
    /// What the methods made of it.
    fn account(&mut self, reading: &Reading, accounts: &[Account]);
    /// A step of 10 ms has ended; its times have the offset added.
    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose);
}

/// Nobody looks on.
impl Witness for () {
    fn start(&mut self, _offset_s: f64, _station: Option<usize>) {}
    fn sense(&mut self, _reading: &Reading) {}
    fn account(&mut self, _reading: &Reading, _accounts: &[Account]) {}
    fn step(&mut self, _truth: &Truth, _estimate: &Estimate, _odometry: Pose) {}
}
