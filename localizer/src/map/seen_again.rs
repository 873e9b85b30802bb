//! What a drive tells of a landmark that is on the map.

use crate::reading::LandmarkId;

/// How often a landmark of the map was found and missed on a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeenAgain {
    /// The landmark.
    pub landmark: LandmarkId,
    /// Number of pictures in which it was found where some possible pose of the robot shows it.
    pub n_found: usize,
    /// Number of pictures in which it was found where no possible pose shows it: something else looks like it, or it has moved.
    pub n_elsewhere: usize,
    /// Number of pictures in which it was not found although it should have been wholly in view, near the place from which it was first seen, and others
    /// were found.
    pub n_missed: usize,
}

/// Least number of pictures in which a landmark is missed for it to be taken as gone, and number of pictures in which it is missed for each in which it is
/// found.
const OFTEN_MISSED: usize = 6;
const MISSED_PER_FOUND: usize = 10;
/// Least number of pictures in which it is found elsewhere.
const OFTEN_ELSEWHERE: usize = 3;

impl SeenAgain {
    /// Whether the landmark is no longer where the map has it, as far as the drive tells: found elsewhere more often than where it was, or missed nearly
    /// each time. That is no proof, since it may be hidden by something that was not there before.
    pub fn is_gone(&self) -> bool {
        let is_elsewhere = self.n_elsewhere >= OFTEN_ELSEWHERE && self.n_elsewhere > self.n_found;
        let is_missed = self.n_missed >= OFTEN_MISSED && self.n_missed >= MISSED_PER_FOUND * self.n_found;
        is_elsewhere || is_missed
    }
}
