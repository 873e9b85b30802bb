//! The localizers that the option `--subject` of the command names.

use std::{fmt, str::FromStr};

use crate::scene::Scene;

use super::{IntervalLocalizer, Subject};

/// The localizer under test as the user chose it with the option `--subject`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum SubjectChoice {
    /// The interval localizer of this project.
    #[default]
    Intervals,
}

/// Each built-in localizer with its name on the command line and in results.
const BUILT_IN: [(&str, SubjectChoice); 1] = [("intervals", SubjectChoice::Intervals)];

/// Creates the localizer of a choice, with the map, robot and bounds that the scene states.
pub fn subject(choice: &SubjectChoice, scene: &Scene) -> Box<dyn Subject> {
    match choice {
        SubjectChoice::Intervals => IntervalLocalizer::boxed(scene),
    }
}

impl fmt::Display for SubjectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = BUILT_IN.iter().find(|(_, choice)| choice == self);
        f.write_str(named.map_or("", |(name, _)| name))
    }
}

impl FromStr for SubjectChoice {
    type Err = String;

    /// Reads a choice from its name. Errors for a text that names no localizer, with the names that there are.
    fn from_str(text: &str) -> Result<SubjectChoice, String> {
        let named = BUILT_IN.iter().find(|(name, _)| *name == text);
        named.map(|(_, choice)| choice.clone()).ok_or_else(|| {
            let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
            format!("no such localizer, expected one of {}", names.join(", "))
        })
    }
}
