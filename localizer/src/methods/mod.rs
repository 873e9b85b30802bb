//! Localization methods, one file per cue (markers, tiles, walls, landmarks, satellites, scans). A new method is one file here and one line in the
//! table of the program that sets the localizer up.

#[cfg(feature = "vision")]
pub mod ceiling_markers;
#[cfg(feature = "vision")]
pub mod floor_tiles;
pub mod gnss_positions;
pub mod mapped_landmarks;
// Without vision only the landmarks of a map lean.
#[cfg_attr(not(feature = "vision"), allow(dead_code))]
mod lean;
mod tilt;
pub mod range_landmarks;
#[cfg(feature = "vision")]
mod readout;
#[cfg(feature = "vision")]
mod rows;
#[cfg(feature = "vision")]
mod sight;
#[cfg(feature = "vision")]
pub mod wall_bearings;
#[cfg(feature = "vision")]
pub mod wall_directions;
pub mod wall_ranges;
