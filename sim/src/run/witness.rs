//! Observers that follow a run while it happens, such as a recording.

use localizer::{Estimate, Pose, Reading, localizer::Account};

use crate::{devices::Observation, truth::Truth};

/// An observer that is told of a run's events in their order. Nothing that an observer does reaches the run.
pub trait Witness {
    /// The localizer starts, at the scene's start or at a station (a stated pose at which the robot stands still). From this call on the times of
    /// steps include `offset_s`, but those of readings do not.
    fn start(&mut self, offset_s: f64, station: Option<usize>);
    /// A sensor's reading is about to reach the localizer. The observation has the truth behind the reading, too.
    fn sense(&mut self, observation: &Observation);
    /// The methods of the localizer have read `reading`; `accounts` are their reports of what they found in it and what it did to the estimate.
    fn account(&mut self, reading: &Reading, accounts: &[Account]);
    /// A step of 10 ms has ended. The times in `truth` and `estimate` are those of the whole run: they include the offset of the present drive.
    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose);
}

/// The observer that ignores all events.
impl Witness for () {
    fn start(&mut self, _offset_s: f64, _station: Option<usize>) {}
    fn sense(&mut self, _observation: &Observation) {}
    fn account(&mut self, _reading: &Reading, _accounts: &[Account]) {}
    fn step(&mut self, _truth: &Truth, _estimate: &Estimate, _odometry: Pose) {}
}

/// An optional observer, which ignores all events where it is `None`.
impl<W: Witness> Witness for Option<W> {
    fn start(&mut self, offset_s: f64, station: Option<usize>) {
        self.iter_mut().for_each(|witness| witness.start(offset_s, station));
    }

    fn sense(&mut self, observation: &Observation) {
        self.iter_mut().for_each(|witness| witness.sense(observation));
    }

    fn account(&mut self, reading: &Reading, accounts: &[Account]) {
        self.iter_mut().for_each(|witness| witness.account(reading, accounts));
    }

    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose) {
        self.iter_mut().for_each(|witness| witness.step(truth, estimate, odometry));
    }
}

/// A pair of observers, each of which is told of every event.
impl<A: Witness, B: Witness> Witness for (A, B) {
    fn start(&mut self, offset_s: f64, station: Option<usize>) {
        self.0.start(offset_s, station);
        self.1.start(offset_s, station);
    }

    fn sense(&mut self, observation: &Observation) {
        self.0.sense(observation);
        self.1.sense(observation);
    }

    fn account(&mut self, reading: &Reading, accounts: &[Account]) {
        self.0.account(reading, accounts);
        self.1.account(reading, accounts);
    }

    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose) {
        self.0.step(truth, estimate, odometry);
        self.1.step(truth, estimate, odometry);
    }
}
