//! A map of landmarks in space: the contents of the map file that a scene names.

use localizer::{map::SpacePoint, reading::LandmarkId, vision::point_features::Landmark};

/// A map of landmarks in space, as a drive has learnt them.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkMap {
    /// Extent of the room along world x and y.
    pub room_m: [f64; 2],
    /// Names of the declared bounds that the landmarks' places rely on.
    pub relies_on: Vec<String>,
    /// The landmarks, in the order of their numbers.
    pub landmarks: Vec<(LandmarkId, SpacePoint)>,
    /// How the landmarks look, for all of them in the order of their numbers; empty where a point camera has told which landmark is which.
    pub looks: Vec<(LandmarkId, Landmark)>,
}
