//! Calibration before a robot drives: the intrinsics of a camera, and the position of a sensor on the robot.

pub mod chessboard;
pub mod mount_offset;
