//! One binary for all integration tests; each module states what belongs in it.

/// Interval arithmetic against the ITF1788 collection of cases from outside.
mod interval_itf1788;
/// Interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// The wheels' enclosure against motion integrated much finer.
mod motion_enclosure;
/// Tile joints to poses, against a camera and a floor of the tests' own.
mod floor_tiles_geometry;
