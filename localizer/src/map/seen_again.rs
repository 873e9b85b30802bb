//! What a drive tells of a landmark that is on the map.

use crate::reading::LandmarkId;

/// How often a landmark of the map was found and missed on a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenAgain {
    /// The landmark.
    pub landmark: LandmarkId,
    /// Number of pictures in which it was found where some possible pose of the robot shows it.
    pub n_found: usize,
    /// World x, y and z of the place where it is now: its sightings where no possible pose shows it agree on that place from different poses, and a
    /// neighbour has moved with it. `None` if they do not; what looks alike is then seen.
    pub now_m: Option<[f64; 3]>,
    /// Number of pictures in which it was found at that other place.
    pub n_elsewhere: usize,
    /// Number of pictures in which it was not found although it should have been wholly in view, near the place from which it was first seen, and others
    /// were found.
    pub n_missed: usize,
    /// The same from wherever: elsewhere a wall may always have hidden it.
    pub n_absent: usize,
}

/// Least number of pictures in which a landmark is missed for it to be taken as gone, and number of pictures in which it is missed for each in which it is
/// found.
const OFTEN_MISSED: usize = 6;
const MISSED_PER_FOUND: usize = 10;

impl SeenAgain {
    /// Whether the landmark is no longer where the map has it, as far as the drive tells: found at another place more often than where it was, or missed
    /// nearly each time. That is no proof, since it may be hidden by something that was not there before.
    pub fn is_gone(&self) -> bool {
        let is_elsewhere = self.now_m.is_some() && self.n_elsewhere > self.n_found;
        let is_missed = self.n_missed >= OFTEN_MISSED && self.n_missed >= MISSED_PER_FOUND * self.n_found;
        is_elsewhere || is_missed
    }
}
