//! Calibration before a robot drives: the intrinsics of a camera, the position of a sensor on the robot, and the constants that a drive tells.

pub mod chessboard;
pub mod constants;
pub mod mount_offset;

/// Standard deviations of a calibrated quantity that its declared tolerance covers: of a normal distribution 99.7 % lie within them.
pub const TOLERATED_DEVIATIONS: f64 = 3.0;
