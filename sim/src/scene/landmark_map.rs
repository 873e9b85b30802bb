//! A map of landmarks in space: the contents of the map file that a scene names.

use localizer::{
    map::{SpacePoint, Views},
    reading::LandmarkId,
    vision::point_features::Landmark,
};
use nalgebra::Isometry3;

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
    /// Where pictures of the drives that taught the map show landmarks; none in maps of earlier versions.
    pub views: Views,
    /// The cameras that truly took these pictures, one for each of them, by which the judge decides whether what is claimed of them is true; empty where
    /// that is not known. Nothing of it is told to a localizer.
    pub true_eyes: Vec<TrueEye>,
}

/// The pinhole camera that truly took a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueEye {
    /// Pose of the camera in the world.
    pub world_from_camera: Isometry3<f64>,
    /// Focal length along u.
    pub focal_px: f64,
    /// Principal point, u and v.
    pub centre_px: [f64; 2],
}
