//! The paper's own method to locate a robot by ceiling markers, as a baseline: it takes the marker nearest to the middle of the picture and
//! its three direction dots, solves P3P, and subtracts the offset of the camera's mount.

use nalgebra::{Matrix3, Rotation3, Vector3};

use interval::Interval;

use crate::{
    Pose, RobotModel,
    map::{MarkerMap, PlacedMarker},
    markers::{DIRECTION_DOTS, DOT_RADIUS_M, GridPlace, MarkerId, dot_in_marker_m},
    robot::CeilingCameraModel,
    vision::{
        ceiling::paper::{self, PaperMarker},
        p3p::{self, CameraPose},
    },
};

/// Greatest excess of a P3P solution's lean over that of the most upright solution for both to count as equally upright. Among such
/// solutions the one whose reprojection fits all dots best is taken.
const AS_UPRIGHT_RAD: f64 = 0.03;

/// Pose that the paper's method computes from one marker, without error bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperFix {
    /// Pose of the robot origin, with the heading in (−π, π].
    pub pose: Pose,
    /// World position of the camera in metres.
    pub camera_m: [f64; 3],
    /// Identity of the marker that was read.
    pub marker: MarkerId,
    /// Confidence P(S) of the marker that was read, Eq. (3) of the paper.
    pub confidence: f64,
}

/// Locates the robot by the marker nearest to the middle of the picture: solves Eqs. (10) to (15), then Eq. (17) of the paper. `None` when
/// no marker of the map is found.
pub fn locate(image: &image::GrayImage, map: &MarkerMap, robot: &RobotModel) -> Option<PaperFix> {
    let camera = robot.ceiling_camera.as_ref()?;
    let seen = paper::detect(image, dot_radius_px(map, camera))?;
    let placed = map.markers.iter().find(|placed| placed.id == seen.id)?;
    let [o, x, y] = DIRECTION_DOTS.map(|place| in_world_m(placed, place));
    let solutions = p3p::solve(&seen.direction_dots_px.map(|pixel| ray(camera, pixel)), &[x, o, y]);
    let body_from_camera = body_from_camera(camera);
    let world_from_body = |pose: &CameraPose| pose.rotation.transpose() * body_from_camera.transpose();
    let lean_rad = |pose: &CameraPose| world_from_body(pose)[(2, 2)].clamp(-1.0, 1.0).acos();
    let most_upright = solutions.iter().map(lean_rad).fold(f64::INFINITY, f64::min);
    let solution = solutions
        .iter()
        .filter(|pose| lean_rad(pose) <= most_upright + AS_UPRIGHT_RAD)
        .min_by(|a, b| misfit(a, &seen, placed, camera).total_cmp(&misfit(b, &seen, placed, camera)))?;
    let centre_m = -(solution.rotation.transpose() * solution.translation_m);
    let forward = world_from_body(solution) * Vector3::x();
    let heading_rad = forward.y.atan2(forward.x);
    // The offset of the camera is subtracted as in Eq. (17), but with its direction and not its length alone (erratum I8).
    let [ahead, aside] = camera.position_m.map(Interval::mid);
    let (sin, cos) = heading_rad.sin_cos();
    let pose = Pose {
        x_m: centre_m.x - (cos * ahead - sin * aside),
        y_m: centre_m.y - (sin * ahead + cos * aside),
        heading_rad,
    };
    Some(PaperFix { pose, camera_m: centre_m.into(), marker: seen.id, confidence: seen.confidence })
}

/// Radius in the image, in pixels, of a marker dot that is straight above the camera, for the lowest marker of the map.
pub(crate) fn dot_radius_px(map: &MarkerMap, camera: &CeilingCameraModel) -> f64 {
    let heights = map.markers.iter().map(|placed| placed.height_m.mid() - camera.height_m.mid());
    camera.focal_px[0].mid() * DOT_RADIUS_M / heights.fold(f64::INFINITY, f64::min)
}

/// Sum of squared distances, in focal lengths, between all dots of the marker as seen and as a solution for the camera pose projects them.
fn misfit(pose: &CameraPose, seen: &PaperMarker, placed: &PlacedMarker, camera: &CeilingCameraModel) -> f64 {
    let squares = seen.dots_px.iter().map(|(place, pixel)| {
        let point = pose.rotation * in_world_m(placed, *place) + pose.translation_m;
        (point / point.z - ray(camera, *pixel)).norm_squared()
    });
    squares.sum()
}

/// Ray of a pixel in the camera frame, Eq. (12) of the paper.
fn ray(camera: &CeilingCameraModel, pixel: [f64; 2]) -> Vector3<f64> {
    let [x, y] = [0, 1].map(|axis| (pixel[axis] - camera.centre_px[axis].mid()) / camera.focal_px[axis].mid());
    Vector3::new(x, y, 1.0)
}

pub(crate) fn in_world_m(placed: &PlacedMarker, place: GridPlace) -> Vector3<f64> {
    let [x, y] = dot_in_marker_m(place);
    let (sin, cos) = placed.rotation_rad.sin_cos();
    let [centre_x, centre_y] = placed.centre_m;
    Vector3::new(centre_x + cos * x - sin * y, centre_y + sin * x + cos * y, placed.height_m.mid())
}

/// Nominal orientation of the ceiling camera in the body frame.
pub(crate) fn body_from_camera(camera: &CeilingCameraModel) -> Matrix3<f64> {
    let [forward, left] = camera.lean_rad;
    let lean = Rotation3::new(Vector3::new(-left, forward, 0.0));
    let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), camera.yaw_rad.mid());
    // The columns of the matrix say: image right is the robot's left, image down is backward, and the optical axis points up.
    let upright = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    yaw.matrix() * lean.matrix() * upright
}
