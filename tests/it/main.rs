//! One binary for all integration tests; each module states what belongs in it.
#![allow(clippy::unwrap_used, clippy::expect_used)]

/// Interval arithmetic against the ITF1788 collection of cases from outside.
mod interval_itf1788;
/// Interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// The wheels' enclosure against motion integrated much finer.
mod motion_enclosure;
/// Tile joints to poses, against a camera and a floor of the tests' own.
mod floor_tiles_geometry;
/// Scenes and drives that the tests of the world share.
mod world_setup;
/// The tyre law against the brush's own integral and closed form.
mod world_tyre;
/// Motion at rest, straight on and in a circle against closed forms; walls; travel against pose.
mod world_motion;
/// Slip by region, friction events and pushes.
mod world_floor;
/// Routes driven by estimates, and the default bounds on such a drive.
mod world_driver;
/// Encoders against the definition of a tick.
mod world_encoder;
/// Drawn errors against their tolerances.
mod world_drawn;
