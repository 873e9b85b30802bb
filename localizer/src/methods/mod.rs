//! Localization methods, one file per cue (markers, tiles, walls, landmarks, satellites). A new method is one file here and one line in the
//! table of the program that sets the localizer up.

pub mod ceiling_markers;
pub mod floor_tiles;
pub mod gnss_positions;
pub mod mapped_landmarks;
mod lean;
mod tilt;
pub mod range_landmarks;
pub mod wall_directions;
mod window;
