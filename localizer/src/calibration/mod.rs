//! Calibration before a robot drives: the intrinsics of a camera, the position of a sensor on the robot, and the constants that a drive tells.

pub mod chessboard;
pub mod constants;
pub mod mount_offset;
