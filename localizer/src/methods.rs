//! One file per cue. A new method is one file here and one line in the table of whoever sets the localizer up.

pub mod ceiling_markers;
pub mod floor_tiles;
pub mod gnss_positions;
mod lean;
pub mod range_landmarks;
pub mod wall_directions;
