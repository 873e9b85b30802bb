//! Why a scene cannot be used, with the place in its file underlined.

use std::{fmt, io, ops::Range, path::PathBuf};

use miette::{Diagnostic, LabeledSpan, SourceCode};
use thiserror::Error;

use super::extend::Sources;

/// Why a scene cannot be used. Its text follows "failed to".
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file or folder cannot be read.
    #[error("read scene {}: {source}", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is not text.
    #[error("read scene {file}: byte {offset} is not UTF-8, but a scene is a text file in TOML")]
    NotText {
        /// The file.
        file: String,
        /// Bytes before the first that is not UTF-8.
        offset: usize,
    },
    /// The text is not a valid scene.
    #[error("read scene {}: {problems}", sources.name())]
    Invalid {
        /// Its file and those that it extends.
        sources: Sources,
        /// What is wrong, in the order of the file, then of those that it extends.
        problems: Problems,
    },
    /// A folder holds no scene.
    #[error("find a scene in {}: expected at least one file that ends in .toml, there or in a folder below; .base.toml is for what scenes extend", folder.display())]
    NoScenes {
        /// The folder.
        folder: PathBuf,
    },
    /// A key was to be set that scenes do not have.
    #[error("set `{key}` of scene {}: unknown key, expected one such as {}", path.display(), nearest.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", "))]
    UnknownKey {
        /// The scene's file.
        path: PathBuf,
        /// The key.
        key: String,
        /// Keys that may have been meant, the nearest first.
        nearest: Vec<String>,
    },
    /// Another base was to be set.
    #[error("set `extends = {value}` of scene {}: what it extends is a matter of its file, expected a key of the scene itself", path.display())]
    SetBase {
        /// The scene's file.
        path: PathBuf,
        /// The value.
        value: String,
    },
    /// Two scenes would be recorded in the same place.
    #[error("tell {} and {} apart: both are scenes named `{name}`, expected different names", first.display(), second.display())]
    SameName {
        /// The name.
        name: String,
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
}

/// One thing wrong in a scene.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Dotted path of the key, such as `route.waypoint[3].x_m`; empty for the file as a whole.
    pub key: String,
    /// The value as the file writes it; none when the key is missing or itself the problem.
    pub value: Option<String>,
    /// What is wrong with it and what was expected.
    pub expected: String,
    /// Bytes to underline, counted through all files of the scene.
    pub span: Range<usize>,
    /// What the key means.
    pub help: Option<String>,
    /// The file in which it stands; none for the scene's own.
    pub file: Option<String>,
}

impl Problem {
    /// A text that is not TOML, which begins at byte `start` of all files of the scene.
    pub(crate) fn of_toml(error: &toml::de::Error, start: usize) -> Problem {
        let expected = format!("not a scene in TOML: {}", error.message().trim().replace('\n', ", "));
        let span = error.span().unwrap_or(0..0);
        let span = span.start + start..span.end + start;
        Problem { key: String::new(), value: None, expected, span, help: None, file: None }
    }
}

/// At least one problem.
#[derive(Debug)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "in {file}, ")?;
        }
        match (self.key.as_str(), &self.value) {
            ("", _) => write!(f, "{}", self.expected),
            (key, None) => write!(f, "`{key}`: {}", self.expected),
            (key, Some(value)) => write!(f, "`{key} = {value}`: {}", self.expected),
        }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{problem}")?;
        }
        Ok(())
    }
}

impl Diagnostic for SceneError {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        match self {
            SceneError::Invalid { sources, .. } => Some(sources),
            _ => None,
        }
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        match self {
            SceneError::Invalid { problems, .. } => Some(Box::new(
                problems
                    .0
                    .iter()
                    .map(|problem| LabeledSpan::new_with_span(Some(problem.expected.clone()), problem.span.clone())),
            )),
            _ => None,
        }
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        match self {
            SceneError::Invalid { problems, .. } => {
                let helps: Vec<&str> = problems.0.iter().filter_map(|problem| problem.help.as_deref()).collect();
                (!helps.is_empty()).then(|| Box::new(helps.join("\n")) as Box<dyn fmt::Display>)
            }
            _ => None,
        }
    }
}
