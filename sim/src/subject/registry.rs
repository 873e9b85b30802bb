//! The localizers that the option `--subject` of the command names.

use std::{fmt, str::FromStr, time::Duration};

use crate::scene::Scene;

use super::{
    ExtendedKalmanFilter, ForeignProcess, IntervalLocalizer, ParticleFilter, Subject, extended_kalman_filter::Tuning,
};

/// Time that a process has for each answer unless the user states another. Starting an interpreter with large libraries takes some seconds, and an
/// answer after an image some tenths of a second.
pub const USUAL_LIMIT: Duration = Duration::from_secs(30);

/// The localizer under test as the user chose it with the option `--subject`.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SubjectChoice {
    /// The interval localizer of this project.
    #[default]
    Intervals,
    /// The extended Kalman filter.
    ExtendedKalmanFilter(Tuning),
    /// The particle filter.
    ParticleFilter(Tuning),
    /// A process of any language, started anew for every run.
    Command {
        /// The command of the shell that starts it.
        command: String,
        /// Time that it has for each answer.
        limit: Duration,
    },
}

/// Names of the built-in localizers.
const NAMES: [&str; 3] = ["intervals", "ekf", "particles"];

/// Creates the localizer of a choice, with the map, robot and bounds that the scene states.
pub fn subject(choice: &SubjectChoice, scene: &Scene) -> Box<dyn Subject> {
    match choice {
        SubjectChoice::Intervals => IntervalLocalizer::boxed(scene),
        SubjectChoice::ExtendedKalmanFilter(tuning) => {
            Box::new(ExtendedKalmanFilter::of(scene, *tuning, choice.to_string()))
        }
        SubjectChoice::ParticleFilter(tuning) => Box::new(ParticleFilter::of(scene, *tuning, choice.to_string())),
        SubjectChoice::Command { command, limit } => Box::new(ForeignProcess::start(command, *limit, scene)),
    }
}

impl SubjectChoice {
    /// Whether the localizer may have changed since it was tested, although this program is the same and the scene is: a command may start anything.
    pub fn may_have_changed(&self) -> bool {
        matches!(self, SubjectChoice::Command { .. })
    }
}

impl fmt::Display for SubjectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SubjectChoice::Intervals => f.write_str(NAMES[0]),
            SubjectChoice::ExtendedKalmanFilter(tuning) => write!(f, "{}{tuning}", NAMES[1]),
            SubjectChoice::ParticleFilter(tuning) => write!(f, "{}{tuning}", NAMES[2]),
            SubjectChoice::Command { command, .. } => f.write_str(command),
        }
    }
}

impl FromStr for SubjectChoice {
    type Err = String;

    /// Reads a choice from its name. The name of a filter may be followed by factors on its standard deviations, as in `ekf,motion=2,cues=0.5`.
    /// Errors for a text that names no localizer, with the names that there are.
    fn from_str(text: &str) -> Result<SubjectChoice, String> {
        let (name, factors) = text.split_once(',').map_or((text, ""), |(name, factors)| (name, factors));
        match name {
            "ekf" => Ok(SubjectChoice::ExtendedKalmanFilter(factors.parse()?)),
            "particles" => Ok(SubjectChoice::ParticleFilter(factors.parse()?)),
            "intervals" if factors.is_empty() => Ok(SubjectChoice::Intervals),
            _ => Err(format!(
                "no such localizer, expected one of {}, or a command with a blank or a slash",
                NAMES.join(", ")
            )),
        }
    }
}

impl fmt::Display for Tuning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, factor) in [("motion", self.motion), ("cues", self.cues)] {
            if factor != 1.0 {
                write!(f, ",{name}={factor}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Tuning {
    type Err = String;

    fn from_str(text: &str) -> Result<Tuning, String> {
        let mut tuning = Tuning::default();
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let (name, factor) = part.split_once('=').unwrap_or((part, ""));
            let factor = factor.parse().ok().filter(|factor: &f64| *factor > 0.0 && factor.is_finite());
            match (name, factor) {
                ("motion", Some(factor)) => tuning.motion = factor,
                ("cues", Some(factor)) => tuning.cues = factor,
                _ => return Err(format!("`{part}`: expected motion=FACTOR or cues=FACTOR, with a number above 0")),
            }
        }
        Ok(tuning)
    }
}
