//! What a localizer is told of a scene: map, robot and bounds, and never a drawn value.

mod models;
mod declared;
