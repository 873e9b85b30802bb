//! What a drive tells of a landmark that is on the map.

use crate::reading::LandmarkId;

/// How often a landmark of the map was found and missed on a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenAgain {
    /// The landmark.
    pub landmark: LandmarkId,
    /// Number of pictures in which it was found where some possible pose of the robot shows it.
    pub n_found: usize,
    /// Number of pictures that contradict the place of the thing that it is on, such as a painting: no pose is possible of which that thing and the
    /// others in the picture are seen as they are, and without it one is.
    pub n_displaced: usize,
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
    /// Angle over which the directions from the landmark to the robot are spread in these pictures: what is on a surface that the robot passes nearly
    /// edge on may be missed from one direction and be there all the same.
    pub absent_over_rad: f64,
}

/// Least number of pictures in which a landmark is missed for it to be taken as gone, and number of pictures in which it is missed for each in which it is
/// found.
const OFTEN_MISSED: usize = 6;
const MISSED_PER_FOUND: usize = 10;
/// Least angle over which a landmark is missed for it to be taken as gone.
const MISSED_OVER_RAD: f64 = 0.2;

/// Least number of pictures that contradict the place of a landmark's thing for the landmark to be taken as displaced: one picture may have more false
/// sightings than declared, for any reason.
const OFTEN_DISPLACED: usize = 4;

impl SeenAgain {
    /// A landmark of which a drive has told nothing yet.
    pub(crate) fn of(landmark: LandmarkId) -> SeenAgain {
        SeenAgain {
            landmark,
            n_found: 0,
            n_displaced: 0,
            now_m: None,
            n_elsewhere: 0,
            n_missed: 0,
            n_absent: 0,
            absent_over_rad: 0.0,
        }
    }

    /// Whether the landmark is seen, but not quite where the map has it.
    pub fn is_displaced(&self) -> bool {
        self.n_displaced >= OFTEN_DISPLACED
    }

    /// Whether the landmark is no longer where the map has it, as far as the drive tells: found at another place more often than where it was, on a thing
    /// whose place pictures contradict, or missed nearly each time and from different directions. That is no proof, since it may be hidden by something
    /// that was not there before.
    pub fn is_gone(&self) -> bool {
        let is_elsewhere = self.now_m.is_some() && self.n_elsewhere > self.n_found;
        let is_often_missed = self.n_missed >= OFTEN_MISSED && self.n_missed >= MISSED_PER_FOUND * self.n_found;
        let is_missed = is_often_missed && self.absent_over_rad >= MISSED_OVER_RAD;
        is_elsewhere || is_missed || self.is_displaced()
    }
}
