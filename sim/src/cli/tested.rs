//! Arguments that choose the localizer under test.

use std::time::Duration;

use clap::Args;

use crate::{
    campaign::cases::subject_option,
    subject::{SubjectChoice, USUAL_LIMIT},
};

/// Arguments that choose the localizer under test.
#[derive(Debug, Args)]
pub(super) struct Tested {
    /// Localizer to test: intervals (the project's own), another by its name, or a command in quotes, which is given the readings as an MCAP stream
    /// on its standard input and writes its answers to its standard output. [default: intervals, or what a sweep file states]
    #[arg(long, value_name = "NAME|COMMAND")]
    subject: Option<SubjectChoice>,
    /// Time that a tested command has for each answer, in seconds of the clock on the wall; longer is a failure.
    #[arg(long, value_name = "SECONDS", default_value_t = USUAL_LIMIT.as_secs_f64(), value_parser = limit_s)]
    subject_timeout_s: f64,
}

impl Tested {
    /// The localizer under test.
    pub(super) fn choice(&self) -> SubjectChoice {
        self.choice_or(&SubjectChoice::default())
    }

    /// The localizer under test as it is named, if it is another than the project's own.
    pub(super) fn other(&self) -> Option<String> {
        self.subject.as_ref().filter(|choice| **choice != SubjectChoice::Intervals).map(|choice| choice.to_string())
    }

    /// The localizer under test, which is `stated` unless the command line names one.
    pub(super) fn choice_or(&self, stated: &SubjectChoice) -> SubjectChoice {
        match self.subject.as_ref().unwrap_or(stated) {
            SubjectChoice::Command { command, .. } => SubjectChoice::Command {
                command: command.clone(),
                limit: Duration::from_secs_f64(self.subject_timeout_s),
            },
            built_in => built_in.clone(),
        }
    }

    /// The options that choose this localizer again, for a command line: empty for the one that is tested unless another is asked for.
    pub(super) fn options(&self) -> String {
        let choice = self.choice();
        let limit = match &choice {
            SubjectChoice::Command { limit, .. } if *limit != USUAL_LIMIT => {
                format!(" --subject-timeout-s {}", limit.as_secs_f64())
            }
            _ => String::new(),
        };
        subject_option(&choice.to_string()) + &limit
    }
}

/// Reads a time limit: from a millisecond to a day.
fn limit_s(text: &str) -> Result<f64, String> {
    let limit_s = text.parse::<f64>().ok().filter(|limit_s| (0.001..=86_400.0).contains(limit_s));
    limit_s.ok_or_else(|| "expected seconds from 0.001 to 86400".to_owned())
}
