//! The pose from the ceiling markers of paper 5 (Zhou et al. 2016), with what a robot on a level floor knows besides: its camera's vertical, and
//! how far the ceiling is.
//!
//! The paper solves for six numbers from three dots, where an error of a tenth of a pixel tilts the camera by so much that the robot is
//! misplaced by a hand's breadth. With the vertical known, each pixel is a place on the ceiling relative to the robot, and x, y and heading are
//! the planar least-squares fit to all dots of all markers in view. The camera stands nearly level, so that a pixel is as long on the ceiling
//! wherever it is, and all dots have the same weight. Source: Z. Kukelova, M. Bujnak, T. Pajdla, "Closed-form solutions to minimal absolute pose
//! problems with known vertical direction", ACCV 2010; with the height known too, what remains is D. Eggert et al.'s closed form of
//! [`least_squares`].

use interval::Interval;

use crate::{
    Pose, RobotModel,
    map::{MarkerMap, PlacedMarker},
    markers::{DOT_RADIUS_M, GridPlace},
    methods::ceiling_markers::paper::{body_from_camera, dot_radius_px, in_world_m},
    robot::CeilingCameraModel,
    vision::{
        ceiling::paper::{PaperMarker, detect_all},
        distortion,
    },
};

use super::least_squares;

/// Greatest root mean square distance of a marker's dots from the places of its grid that they are assigned to: a centroid that is further off than
/// the dot's own radius belongs to another dot.
const MOST_MISFIT_M: f64 = DOT_RADIUS_M;
/// Greatest root mean square distance of a marker's dots from where a pose puts them for the marker to agree with the pose: half of a marker's
/// side, as two markers cannot hang nearer to each other than a whole side.
const AGREE_M: f64 = 0.06;

/// The robot's pose from an image of the ceiling: reads every marker in the image by the image processing of paper 5, and fits the pose to all
/// markers that agree; `None` when no marker of the map is read.
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
        // Among groups of agreeing markers with equally many dots the first is kept; it is that of the marker nearest to the middle of the picture.
        if dots.len() > most.len() { dots } else { most }
    });
    least_squares(&most)
}

/// Pairs of each dot's place in the world and its place relative to the robot on a level floor. `None` for a marker that is not on the map, or
/// if the pixel of one of its dots belongs to no direction towards the ceiling.
fn pairs(seen: &PaperMarker, map: &MarkerMap, camera: &CeilingCameraModel) -> Option<Vec<([f64; 2], [f64; 2])>> {
    dot_pairs(&seen.dots_px, map.markers.iter().find(|placed| placed.id == seen.id)?, camera)
}

/// Pairs of the places in the world and relative to the robot on a level floor of the dots of one marker, given each dot's place in the marker's grid
/// and its pixel. `None` if the pixel of a dot belongs to no direction towards the ceiling.
pub fn dot_pairs(
    dots_px: &[(GridPlace, [f64; 2])],
    placed: &PlacedMarker,
    camera: &CeilingCameraModel,
) -> Option<Vec<([f64; 2], [f64; 2])>> {
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
    dots_px.iter().map(|(place, pixel)| pair(*place, *pixel)).collect()
}

/// Root mean square distance between the dots' places in the world and where a pose puts them.
fn misfit_m(pose: &Pose, dots: &[([f64; 2], [f64; 2])]) -> f64 {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let squares = dots.iter().map(|([x_m, y_m], [ahead_m, aside_m])| {
        let off_x_m = pose.x_m + cos * ahead_m - sin * aside_m - x_m;
        let off_y_m = pose.y_m + sin * ahead_m + cos * aside_m - y_m;
        off_x_m * off_x_m + off_y_m * off_y_m
    });
    (squares.sum::<f64>() / dots.len() as f64).sqrt()
}
