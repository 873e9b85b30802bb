//! The figures of a drive that was looked back at.

use serde::Serialize;

use super::FixWidth;

/// Post-localization of a drive: how narrow the boxes at its key frames become by what was read later, and whether they hold the truth.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PostLocalization {
    /// Number of key frames of a window.
    pub window: usize,
    /// Number of key frames whose boxes were judged.
    pub checks: usize,
    /// Number of them whose box holds the true pose.
    pub contained: usize,
    /// Number of them whose box does not.
    pub outside: usize,
    /// Whether the readings of some window contradict each other, so that nothing is told.
    pub contradictory: bool,
    /// Full widths of the boxes.
    pub width: FixWidth,
    /// Full widths of the estimates' hulls (the smallest boxes around their boxes) at the steps just after.
    pub real_time_width: FixWidth,
}
