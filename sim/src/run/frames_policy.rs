//! Choice of the images of a run that are kept for debug frames.

use std::{fmt, str::FromStr};

/// For which images a run writes debug frames: pictures of what the camera gave and of what the localizer made of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FramesPolicy {
    /// Debug frames for no image.
    #[default]
    None,
    /// Debug frames for each image after which the true pose is outside the estimate, or which left the estimate empty. If a run has no such
    /// image and yet misses an expectation, the debug frame of the image that left the widest box.
    Failures,
    /// Debug frames for every n-th reading of the methods, pictures or other readings each counted by themselves, the first included.
    Every(usize),
    /// Debug frames for all images.
    All,
}

impl FramesPolicy {
    /// Whether to keep the image that comes after so many of its kind. `failed` is true when the true pose is outside the estimate after the image, or the image left
    /// the estimate empty.
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
