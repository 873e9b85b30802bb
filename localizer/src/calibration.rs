//! What is measured before a robot drives: the camera's lens and where it sits.

pub mod chessboard;
pub mod mount_offset;
