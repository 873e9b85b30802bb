//! Declared bounds by name.

/// Name of a declared bound, such as `wheels.slip` or `floor_tiles.laying`.
pub type Assumption = &'static str;
