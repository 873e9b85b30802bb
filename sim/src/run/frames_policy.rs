//! Which images of a run are kept for debug frames.

use std::{fmt, str::FromStr};

/// Of which images a run leaves debug frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FramesPolicy {
    /// Of none.
    #[default]
    None,
    /// Of those after which the truth is outside the estimate, or that emptied it; of the one that left the widest box when
    /// a run without any of those misses an expectation.
    Failures,
    /// Of every n-th, the first included.
    Every(usize),
    /// Of all.
    All,
}

impl FramesPolicy {
    /// Whether to keep image `number`; `failed` when the truth is outside the estimate after it, or it emptied the estimate.
    pub fn keeps(self, number: usize, failed: bool) -> bool {
        match self {
            FramesPolicy::None => false,
            FramesPolicy::Failures => failed,
            FramesPolicy::Every(n) => number.is_multiple_of(n),
            FramesPolicy::All => true,
        }
    }
}

impl FromStr for FramesPolicy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let every = text.strip_prefix("every=").and_then(|n| n.parse().ok()).filter(|n| *n > 0);
        match (text, every) {
            ("none", _) => Ok(FramesPolicy::None),
            ("failures", _) => Ok(FramesPolicy::Failures),
            ("all", _) => Ok(FramesPolicy::All),
            (_, Some(n)) => Ok(FramesPolicy::Every(n)),
            _ => Err("expected none, failures, every=N with N at least 1, or all".to_owned()),
        }
    }
}

impl fmt::Display for FramesPolicy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FramesPolicy::None => f.write_str("none"),
            FramesPolicy::Failures => f.write_str("failures"),
            FramesPolicy::Every(n) => write!(f, "every={n}"),
            FramesPolicy::All => f.write_str("all"),
        }
    }
}
