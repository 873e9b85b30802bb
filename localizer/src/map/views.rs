//! Pictures of the drives that taught a map: where they show its landmarks.

use interval::Interval;

use crate::{PoseBox, reading::LandmarkId};

/// Where pictures of the drives that taught a map show its landmarks.
///
/// The errors of the teacher's heading and of its camera's direction turn the places of all landmarks together about the places from which they were
/// seen, so that the landmarks' boxes are wide. From near the place of a picture the landmarks are seen as the picture shows them, whatever the depth
/// and whatever these errors are: relative to pictures landmarks are known as well as pixels are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Views {
    /// The camera of each drive.
    pub cameras: Vec<ViewCamera>,
    /// The pictures.
    pub pictures: Vec<ViewPicture>,
    /// Where they show landmarks: in the order of the landmarks' numbers, and of the pictures for each of them.
    pub sights: Vec<(LandmarkId, ViewSight)>,
}

/// The camera of a drive that taught a map, with the robot that carried it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewCamera {
    /// Focal length in pixels.
    pub focal_px: Interval,
    /// Principal point, u and v.
    pub centre_px: [Interval; 2],
    /// Nominal upward tilt of the optical axis.
    pub tilt_up_rad: f64,
    /// Direction of the optical axis from robot forward, counter-clockwise.
    pub yaw_rad: Interval,
    /// Greatest turn of the camera about any level axis from its nominal attitude.
    pub tilt_rad: f64,
    /// Position of the optical centre in the robot frame: forward and left.
    pub position_m: [Interval; 2],
    /// Height of the optical centre above the floor at rest.
    pub height_m: Interval,
    /// Greatest angle between the body's vertical and the floor's.
    pub body_tilt_rad: f64,
    /// Greatest rise or sinking of the robot origin from its height at rest.
    pub heave_m: f64,
}

/// A picture of a drive that taught a map.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewPicture {
    /// Stamp in seconds since the start of its drive.
    pub stamp_s: f64,
    /// Index of the drive's camera.
    pub camera: usize,
    /// Box of the pose from which the picture was taken.
    pub pose: PoseBox,
    /// Earlier pictures by their indices, with intervals of the turn from the heading there to that here: far better known than either heading.
    pub turned_since: Vec<(usize, Interval)>,
}

/// Where a picture shows a landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSight {
    /// Index of the picture.
    pub picture: usize,
    /// Column and row at which a pinhole camera would see the landmark.
    pub at_px: [f64; 2],
    /// Greatest error of the image point along u and along v.
    pub error_px: [f64; 2],
}
