//! The localizers that the option `--subject` of the command names.

use std::{
    fmt,
    str::FromStr,
    sync::{Arc, PoisonError, RwLock, atomic::AtomicBool},
    time::Duration,
};

use crate::scene::Scene;

use super::{
    ExtendedKalmanFilter, ForeignProcess, IntervalLocalizer, ParticleFilter, Subject, Tuning,
    interruptible::Interruptible,
};

/// Time that a process has for each answer unless the user states another. Starting an interpreter with large libraries takes some seconds, and an
/// answer after an image some tenths of a second.
pub const USUAL_LIMIT: Duration = Duration::from_secs(30);

/// A function that makes a localizer of what it may know of a scene beforehand; threads may share it.
type Create = dyn Fn(&Scene) -> Box<dyn Subject> + Send + Sync;

/// A localizer that a program has added to the built-in ones.
#[derive(Clone)]
pub struct Added {
    name: String,
    create: Arc<Create>,
    /// Whether it may have changed although the program is the same.
    may_have_changed: bool,
}

/// The added localizers, in the order in which they were added.
static ADDED: RwLock<Vec<Added>> = RwLock::new(Vec::new());

/// Adds a localizer to those that the option `--subject` names, for a program that has a localizer of its own and then is the command `wherein` by
/// calling [`cli::main`](crate::cli::main). `create` makes it from what it may know of a scene beforehand. Of two localizers with one name the one
/// that was added last is meant.
pub fn add_subject(name: &'static str, create: fn(&Scene) -> Box<dyn Subject>) {
    // A thread that panics leaves the list complete.
    ADDED.write().unwrap_or_else(PoisonError::into_inner).push(Added {
        name: name.to_owned(),
        create: Arc::new(create),
        may_have_changed: false,
    });
}

impl Added {
    /// A localizer by a function that its user may change from one run of the program to the next, such as one in a scripting language. It need not be
    /// added for a run to test it.
    pub fn of_user(name: String, create: impl Fn(&Scene) -> Box<dyn Subject> + Send + Sync + 'static) -> Added {
        Added { name, create: Arc::new(create), may_have_changed: true }
    }
}

impl fmt::Debug for Added {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Added").field(&self.name).finish()
    }
}

/// The added localizer of a name.
fn added(name: &str) -> Option<Added> {
    ADDED.read().unwrap_or_else(PoisonError::into_inner).iter().rev().find(|added| added.name == name).cloned()
}

/// Two added localizers are the same if they have the same name.
impl PartialEq for Added {
    fn eq(&self, other: &Added) -> bool {
        self.name == other.name
    }
}

impl Eq for Added {}

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
    /// A localizer that the program has added by [`add_subject`].
    Added(Added),
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
            Box::new(ExtendedKalmanFilter::of(scene, tuning.over(scene.filters.ekf), choice.to_string()))
        }
        SubjectChoice::ParticleFilter(tuning) => {
            Box::new(ParticleFilter::of(scene, tuning.over(scene.filters.particles), choice.to_string()))
        }
        SubjectChoice::Added(added) => (added.create)(scene),
        SubjectChoice::Command { command, limit } => Box::new(ForeignProcess::start(command, *limit, scene)),
    }
}

impl SubjectChoice {
    /// The same localizer, whose runs end by a failure at the next step once `stop` is set. This is for a program whose user may interrupt runs, and
    /// which then drops their records.
    pub fn until(&self, stop: &Arc<AtomicBool>) -> SubjectChoice {
        let (choice, stop) = (self.clone(), Arc::clone(stop));
        SubjectChoice::Added(Added {
            name: self.to_string(),
            may_have_changed: self.may_have_changed(),
            create: Arc::new(move |scene| Box::new(Interruptible::new(subject(&choice, scene), Arc::clone(&stop)))),
        })
    }

    /// Whether the localizer may have changed since it was tested, although this program is the same and the scene is: a command may start anything.
    pub fn may_have_changed(&self) -> bool {
        matches!(self, SubjectChoice::Command { .. } | SubjectChoice::Added(Added { may_have_changed: true, .. }))
    }
}

impl fmt::Display for SubjectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SubjectChoice::Intervals => f.write_str(NAMES[0]),
            SubjectChoice::ExtendedKalmanFilter(tuning) => write!(f, "{}{tuning}", NAMES[1]),
            SubjectChoice::ParticleFilter(tuning) => write!(f, "{}{tuning}", NAMES[2]),
            SubjectChoice::Added(added) => f.write_str(&added.name),
            SubjectChoice::Command { command, .. } => f.write_str(command),
        }
    }
}

impl FromStr for SubjectChoice {
    type Err = String;

    /// Reads a choice from a localizer's name, or from a command, which is a text with a blank or a slash, so that a mistyped name is not taken for
    /// one. The name of a filter may be followed by factors on its standard deviations, as in `ekf,motion=2,cues=0.5`. Errors for a single word that
    /// names no localizer, with the names that there are.
    fn from_str(text: &str) -> Result<SubjectChoice, String> {
        let command = text.trim();
        if command.contains(|c: char| c.is_whitespace() || c == '/' || c == std::path::MAIN_SEPARATOR) {
            return Ok(SubjectChoice::Command { command: command.to_owned(), limit: USUAL_LIMIT });
        }
        if let Some(added) = added(text) {
            return Ok(SubjectChoice::Added(added));
        }
        let (name, factors) = text.split_once(',').map_or((text, None), |(name, factors)| (name, Some(factors)));
        let tuning = || factors.map_or(Ok(Tuning::default()), str::parse);
        match name {
            "ekf" => Ok(SubjectChoice::ExtendedKalmanFilter(tuning()?)),
            "particles" => Ok(SubjectChoice::ParticleFilter(tuning()?)),
            "intervals" if factors.is_none() => Ok(SubjectChoice::Intervals),
            "intervals" => Err("expected no factors: boxes have no standard deviations".to_owned()),
            _ => {
                let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
                let names: Vec<&str> = NAMES.into_iter().chain(added.iter().map(|added| added.name.as_str())).collect();
                Err(format!(
                    "no such localizer, expected one of {}, or a command with a blank or a slash",
                    names.join(", ")
                ))
            }
        }
    }
}
