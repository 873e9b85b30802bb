//! Claims: assertions of what a method saw in a reading, which a simulator can check against the truth.

use interval::Interval;

use crate::{
    map::{SpacePoint, ViewSight},
    markers::{GridPlace, MarkerId},
    reading::LandmarkId,
};

/// An assertion by a method about what it saw. The simulator projects the true object with its own camera model and so knows whether the claim is
/// true.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A claim that a joint of the tiled floor was seen: at most `share_wrong` of the claimed points lie farther than their bound from the centre
    /// line of a true joint.
    FloorJoint {
        /// Points on the image of the joint's claimed centre line, each with the bound on its distance from the image of the true joint's centre
        /// line, `[u_px, v_px, bound_px]`. They are given in the image as taken, in which lens and shutter bend the joint.
        points_px: Vec<[f64; 3]>,
        /// Share of the claimed points that may be farther from the true joint than their bound.
        share_wrong: f64,
    },
    /// A claim that a level line along one of the building's directions was seen, and that its image passes both given end points within the bound.
    /// As for all claims of edges, the image is that of a global shutter at the stamp, also where the camera's shutter is a rolling one.
    WallLine {
        /// First and last point of the claimed line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line's image from either end point, across the line, in pixels.
        bound_px: f64,
    },
    /// A claim that an upright line was seen, and that its image passes both given end points within the bound.
    UprightLine {
        /// First and last point of the claimed line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line's image from either end point, across the line, in pixels.
        bound_px: f64,
    },
    /// A claim that a certain landmark was seen, and that it lies in the given box of the robot frame at the reading's stamp.
    Landmark {
        /// The landmark that is claimed to be seen.
        landmark: LandmarkId,
        /// Box of the claimed landmark's position at the reading's stamp: forward and left of the robot origin, in metres.
        in_robot_m: [Interval; 2],
    },
    /// A claim that a certain marker of the ceiling was seen, with every one of its dots within a bound of the given image point.
    Marker {
        /// The marker that is claimed to be seen.
        marker: MarkerId,
        /// For each of the marker's dots its place in the marker's grid and `[u, v, bound]`: the true image of the dot's centre differs from (u, v)
        /// by at most the bound along u and along v.
        dots_px: Vec<(GridPlace, [f64; 3])>,
    },
    /// A claim that a beam of a planar range scanner ended at the front of a mapped wall: at a distance that differs from the measured one by at most
    /// the range error, the beam is within the placement of a mapped wall that may show its front to the scanner.
    WallPoint {
        /// Bearing of the beam from the scanner's forward axis, counter-clockwise.
        bearing_rad: f64,
        /// Distance that the beam measured.
        distance_m: f64,
        /// Greatest error of the distance.
        range_error_m: f64,
        /// Greatest distance of a point of a wall from its place on the map.
        placement_m: f64,
    },
    /// A claim that a point in space was seen: the true image of some point of the given box is at the given place of the image, within the bound along
    /// u and along v.
    SpacePoint {
        /// The landmark that is claimed to be seen.
        landmark: LandmarkId,
        /// Box of the landmark's place in the world.
        point: SpacePoint,
        /// Column u and row v in the image as taken, which the lens bends.
        at_px: [f64; 2],
        /// Greatest error of the image point along u and along v.
        half_width_px: [f64; 2],
        /// Where a picture of the drive that taught the map is claimed to show the same point.
        view: Option<ViewSight>,
        /// The thing that the landmark is on, such as a painting, if the map tells; by a number of its own.
        thing: Option<u32>,
    },
    /// A claim that an upright edge of a mapped wall was seen: at least one of the given image lines is, within its bound, the image of at least one
    /// of the given edges of the map, where that truly stands.
    WallUpright {
        /// First and last point of each image line, `[u, v]`, with the greatest distance of the true edge's image from either of them, across the
        /// line, in pixels.
        lines: Vec<([[f64; 2]; 2], f64)>,
        /// Places of the edges on the map, world x and y.
        posts_m: Vec<[f64; 2]>,
    },
}
