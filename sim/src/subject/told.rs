//! What a localizer is given about a scene: map, robot and bounds, and never a value drawn at random.

mod models;
mod declared;
