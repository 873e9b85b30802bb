//! Reasons why a scene cannot be used, with the place in its file underlined.

use std::{fmt, io, path::PathBuf};

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, SourceCode};
use thiserror::Error;

use super::{problem::Problems, sources::Sources};

/// Reason why a scene cannot be used. The error's text is written to follow the words "failed to".
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file or folder cannot be read.
    #[error("read scene {}: {source}", path.display())]
    Unreadable {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// The file is larger than any scene.
    #[error("read scene {}: it has {}, expected a scene in TOML of at most {most_mb} MB", path.display(), size_mb.map_or("no end".to_owned(), |mb| format!("{mb:.1} MB")))]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Size of the file in 10⁶ bytes; none for a device or a pipe, which states no size.
        size_mb: Option<f64>,
        /// Greatest size of a scene's file in 10⁶ bytes.
        most_mb: u64,
    },
    /// The scene's file is not text in UTF-8.
    #[error("read scene {file}: byte {offset} is not UTF-8, but a scene is a text file in TOML")]
    NotText {
        /// Name of the file.
        file: String,
        /// Number of bytes before the first byte that is not UTF-8.
        offset: usize,
    },
    /// The text is not a valid scene.
    #[error("read scene {}: {problems}", sources.name())]
    Invalid {
        /// Texts of the scene's file and of the files that it extends.
        sources: Sources,
        /// Everything that is wrong, in the order of the scene's file and then of the files that it extends.
        problems: Problems,
    },
    /// A folder holds no scene.
    #[error("find a scene in {}: expected at least one file that ends in .toml, there or in a folder below; .base.toml is for what scenes extend", folder.display())]
    NoScenes {
        /// The folder without any scene.
        folder: PathBuf,
    },
    /// A setting is of a key that scenes do not have.
    #[error("set `{key}` of scene {}: unknown key, expected one such as {}", path.display(), nearest.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", "))]
    UnknownKey {
        /// Path of the scene's file.
        path: PathBuf,
        /// The unknown key.
        key: String,
        /// Known keys that may have been meant, the nearest first.
        nearest: Vec<String>,
    },
    /// A setting is of the key `extends`, which only the scene's file itself may state.
    #[error("set `extends = {value}` of scene {}: what it extends is a matter of its file, expected a key of the scene itself", path.display())]
    SetBase {
        /// Path of the scene's file.
        path: PathBuf,
        /// Value to which `extends` was to be set.
        value: String,
    },
    /// Two scenes have the same name, so that their runs would be recorded in the same place.
    #[error("tell {} and {} apart: both are scenes named `{name}`, expected different names", first.display(), second.display())]
    SameName {
        /// Name that both scenes have.
        name: String,
        /// File of the first scene.
        first: PathBuf,
        /// File of the second scene.
        second: PathBuf,
    },
}

impl SceneError {
    /// The places of the mistakes in the scene's file, as lines with the mistakes underlined; `None` where the error is not of a place in a file.
    pub fn place(&self, in_colours: bool) -> Option<String> {
        if !matches!(self, SceneError::Invalid { .. }) {
            return None;
        }
        let theme = if in_colours { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let handler = GraphicalReportHandler::new_themed(theme).without_cause_chain().with_wrap_lines(false);
        let mut report = String::new();
        handler.render_report(&mut report, self).ok()?;
        // The library's report begins with the error message; the lines after it show the place in the file.
        report.split_once('\n').map(|(_, place)| place.to_owned())
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
