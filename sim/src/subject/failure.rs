//! What a localizer under test did wrong so that its run had to end.

use serde::Serialize;

/// The failure of a localizer under test: it gave no valid answer, so that the run ended. The run up to there is judged as usual.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Time for which the missing answer was asked.
    pub time_s: f64,
    /// The newest reading that the subject had been given; `None` where it had been given none, and where
    /// readings have no part in the failure.
    pub reading: Option<GivenReading>,
    /// What the subject did, and what was expected of it.
    pub reason: String,
}

/// A reading that a localizer under test was given, as it is named to a user.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GivenReading {
    /// Number of the reading in the run, counted from 1 in the order of arrival.
    pub number: usize,
    /// Name of the device that measured.
    pub device: String,
    /// Stamp of the reading: the time of the measurement.
    pub measured_s: f64,
    /// Time at which the subject was given the reading.
    pub arrived_s: f64,
}

impl Failure {
    /// The failure with its times counted from the start of the run, for a drive that began at `offset_s`.
    pub(crate) fn begin_later(mut self, offset_s: f64) -> Failure {
        self.time_s += offset_s;
        if let Some(reading) = &mut self.reading {
            reading.measured_s += offset_s;
            reading.arrived_s += offset_s;
        }
        self
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the subject failed at {:.2} s", self.time_s)?;
        if let Some(GivenReading { number, device, measured_s, .. }) = &self.reading {
            write!(f, ", after reading {number} ({device} of {measured_s:.3} s)")?;
        }
        write!(f, ": {}", self.reason)
    }
}
