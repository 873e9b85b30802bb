//! Paper 5's markers with what a robot on a level floor knows besides: its camera's vertical, and how far the ceiling is.
//!
//! The paper solves for six numbers from three dots, of which a tenth of a pixel tilts the camera by so much that the robot is a hand's
//! breadth away. With the vertical known each pixel is a place on the ceiling as seen from the robot, and x, y and heading are the planar
//! least squares of all dots of all markers in view. The camera stands nearly level, so that a pixel is as long on the ceiling wherever it
//! is, and all dots weigh alike. Source: Z. Kukelova, M. Bujnak, T. Pajdla, "Closed-form solutions to minimal absolute pose problems with known
//! vertical direction", ACCV 2010; with the height known too, what is left is D. Eggert et al.'s closed form of [`least_squares`].

use interval::Interval;

use crate::{
    Pose, RobotModel,
    map::MarkerMap,
    markers::DOT_RADIUS_M,
    methods::ceiling_markers::paper::{body_from_camera, dot_radius_px, in_world_m},
    robot::CeilingCameraModel,
    vision::{
        ceiling::paper::{PaperMarker, detect_all},
        distortion,
    },
};

use super::least_squares;

/// Greatest root mean square of a marker's dots from the grid that they are read as: a centroid further off than the dot's own radius
/// is of another dot.
const MOST_MISFIT_M: f64 = DOT_RADIUS_M;
/// Markers agree on a pose that puts their dots so near, root mean square: half of a marker's side, as two cannot hang nearer than a whole one.
const AGREE_M: f64 = 0.06;

/// Reads every marker as the paper reads one, and fits the pose to all that agree; `None` without a marker of the map.
pub fn locate_upright(image: &image::GrayImage, map: &MarkerMap, robot: &RobotModel) -> Option<Pose> {
    let camera = robot.ceiling_camera.as_ref()?;
    vertical_known(&detect_all(image, dot_radius_px(map, camera)), map, camera)
}

/// Least-squares pose of the robot from the dots of all markers that were read. Where markers contradict each other, the group of agreeing markers
/// with the most dots is used and the others are left out.
pub fn vertical_known(seen: &[PaperMarker], map: &MarkerMap, camera: &CeilingCameraModel) -> Option<Pose> {
    let markers: Vec<Vec<([f64; 2], [f64; 2])>> = seen.iter().filter_map(|one| pairs(one, map, camera)).collect();
    let agreeing = |marker: &Vec<([f64; 2], [f64; 2])>| -> Option<Vec<([f64; 2], [f64; 2])>> {
        let alone = least_squares(marker)?;
        let agrees = |other: &&Vec<_>| misfit_m(&alone, other) <= AGREE_M;
        (misfit_m(&alone, marker) <= MOST_MISFIT_M).then(|| markers.iter().filter(agrees).flatten().copied().collect())
    };
    let most = markers.iter().filter_map(agreeing).fold(Vec::new(), |most, dots| {
        // Of as many, those of the marker nearest to the middle of the picture, which comes first.
        if dots.len() > most.len() { dots } else { most }
    });
    least_squares(&most)
}

/// Each dot in the world and from the robot, level; `None` of a marker that is not on the map or of which a dot cannot be.
fn pairs(seen: &PaperMarker, map: &MarkerMap, camera: &CeilingCameraModel) -> Option<Vec<([f64; 2], [f64; 2])>> {
    let placed = map.markers.iter().find(|placed| placed.id == seen.id)?;
    let body_from_camera = body_from_camera(camera);
    let up_m = placed.height_m.mid() - camera.height_m.mid();
    let pair = |place, pixel: [f64; 2]| {
        let bent = [0, 1].map(|axis| (pixel[axis] - camera.centre_px[axis].mid()) / camera.focal_px[axis].mid());
        let [x, y] = distortion::unbent(camera.distortion, bent.map(Interval::point))?.at.map(Interval::mid);
        let ray = body_from_camera * nalgebra::Vector3::new(x, y, 1.0);
        let [ahead_m, aside_m] = camera.position_m.map(Interval::mid);
        let in_robot_m = [ahead_m + ray.x / ray.z * up_m, aside_m + ray.y / ray.z * up_m];
        let in_world = in_world_m(placed, place);
        (ray.z > 0.0).then_some(([in_world.x, in_world.y], in_robot_m))
    };
    seen.dots_px.iter().map(|(place, pixel)| pair(*place, *pixel)).collect()
}

/// Root mean square distance of dots in the world from where a pose puts them.
fn misfit_m(pose: &Pose, dots: &[([f64; 2], [f64; 2])]) -> f64 {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let squares = dots.iter().map(|([x_m, y_m], [ahead_m, aside_m])| {
        let off_x_m = pose.x_m + cos * ahead_m - sin * aside_m - x_m;
        let off_y_m = pose.y_m + sin * ahead_m + cos * aside_m - y_m;
        off_x_m * off_x_m + off_y_m * off_y_m
    });
    (squares.sum::<f64>() / dots.len() as f64).sqrt()
}
