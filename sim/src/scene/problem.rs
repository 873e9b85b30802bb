//! What is wrong in a scene, and where in its text.

use std::{fmt, ops::Range};

/// One thing that is wrong in a scene.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Dotted path of the wrong key, such as `route.waypoint[3].x_m`; empty if the file as a whole is wrong.
    pub key: String,
    /// The key's value as the file writes it; none if the key is missing or is itself the problem.
    pub value: Option<String>,
    /// What is wrong with the key or its value, and what was expected.
    pub expected: String,
    /// Range of bytes to underline, counted from the start of the joined text of all files of the scene.
    pub span: Range<usize>,
    /// Explanation of what the key means.
    pub help: Option<String>,
    /// Name of the file in which the problem is; none if it is the scene's own file.
    pub file: Option<String>,
}

impl Problem {
    /// The problem of a file whose text is not TOML. The text begins at byte `start` of the joined text of all files of the scene.
    pub(crate) fn of_toml(error: &toml::de::Error, start: usize) -> Problem {
        let expected = format!("not a scene in TOML: {}", error.message().trim().replace('\n', ", "));
        let span = error.span().unwrap_or(0..0);
        let span = span.start + start..span.end + start;
        Problem { key: String::new(), value: None, expected, span, help: None, file: None }
    }
}

/// A list of at least one problem in a scene.
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
