//! Level edges of walls, ceilings and doors, and the heading that they tell.

use localizer::{
    Map, Reading, RobotModel,
    methods::wall_directions::ray,
    motion::Twist,
    reading::Camera,
    robot::{BodyModel, ForwardCameraModel},
    vision::forward::{self, EdgeLine, Picture},
};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::scene::{MethodName, Scene};

use super::{Mount, SIGMAS_OF_BOUND, Seen, since_stamp, stray, within_quarter};

/// Edges as the camera that looks ahead sees them.
pub(crate) struct Walls {
    camera: ForwardCameraModel,
    body: BodyModel,
    /// Directions of the building, from world x, modulo quarter turns.
    pub(crate) directions_rad: Vec<f64>,
    /// Half the widths of the intervals in which the map states these directions, the greatest of them.
    direction_within_rad: f64,
    /// Whether long edges on the floor run along walls.
    floor_edges: bool,
}

/// An edge, if it is level: its direction from robot forward, and what moves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Direction of the level line, counter-clockwise from robot forward, modulo half turns.
    pub(crate) direction_rad: f64,
    /// Standard deviation of the direction by the places of the edge's ends.
    pub(crate) sigma_rad: f64,
    /// Change of the direction by a lean of robot and camera about the forward and about the left axis, per radian.
    pub(crate) by_lean: [f64; 2],
    /// Standard deviation of that lean about either axis.
    pub(crate) lean_sigma_rad: f64,
}

/// Least level part and least height of the unit normal of an edge's plane for the edge to be used as level: in a steeper plane the edge may as well
/// be upright, such as a door post. It is that of the method `wall_directions`.
const LEAST_SLOPE: f64 = 0.12;
/// Greatest standard deviation of an edge's direction with which it is used; a worse one is short or near the horizon, and mostly clutter.
const WORST_RAD: f64 = 0.01;
/// Elevation, as a tangent, below which a ray meets the floor, and the least length of an edge there that is not mere texture. Both are those of the
/// method `wall_directions`.
const DEEPEST: f64 = -0.07;
const LONG_PX: f64 = 100.0;
/// Step of the numerical derivative by the lean: small against the radii of the picture's curvature, large against rounding.
const LEAN_STEP_RAD: f64 = 1e-4;
/// Angle from the expected heading beyond which an edge is clutter, as the method `wall_directions` has it.
const CLUTTER_RAD: f64 = 0.0524;
/// Residual, in its standard deviations, beyond which an edge is clutter: 99.7 % of right ones stay within.
const CLUTTER_SIGMAS: f64 = 3.0;
/// Least number of edges that have to agree for a picture to tell the heading, as for the method `wall_directions`.
const FEWEST_EDGES: usize = 3;
/// Number of times that the heading is computed, each time by the edges that agree with the one before.
const ROUNDS: usize = 4;

/// The residual of an expected heading (told less expected) and its variance, by the edges that agree on it within their errors; `None` for fewer
/// than three of them. `expected_sigma_rad` is the standard deviation of the expected heading.
///
/// Each edge of direction φ, along a wall of direction α, tells the heading α − φ modulo quarter turns. The residuals are fitted by one turn and by
/// two leans of robot and camera, which move each edge in its own way and of which the standard deviation is known.
pub(crate) fn heading_of(
    edges: &[Edge],
    directions_rad: &[f64],
    expected_rad: f64,
    expected_sigma_rad: f64,
) -> Option<(f64, f64)> {
    let residual = |edge: &Edge| {
        let told = directions_rad.iter().map(|wall| within_quarter(wall - edge.direction_rad - expected_rad));
        told.min_by(|one, other| one.abs().total_cmp(&other.abs()))
    };
    let told: Vec<(f64, &Edge)> = edges.iter().filter_map(|edge| Some((residual(edge)?, edge))).collect();
    let within = |edge: &Edge, by_rad: f64| (CLUTTER_SIGMAS * edge.sigma_rad.hypot(by_rad)).min(CLUTTER_RAD);
    let lean_rad = |edge: &Edge| edge.lean_sigma_rad * edge.by_lean[0].hypot(edge.by_lean[1]);
    let mut fit = Vector3::zeros();
    let mut variance = f64::NAN;
    for round in 0..ROUNDS {
        let mut information = Matrix3::zeros();
        let mut sum = Vector3::zeros();
        let mut n_edges = 0;
        for (off, edge) in &told {
            let row = Vector3::new(1.0, edge.by_lean[0], edge.by_lean[1]);
            // In the first round neither heading nor lean is known but for their standard deviations.
            let by_rad = if round == 0 { expected_sigma_rad.hypot(lean_rad(edge)) } else { edge.sigma_rad };
            if (off - row.dot(&fit)).abs() > within(edge, by_rad) {
                continue;
            }
            let weight = edge.sigma_rad.powi(-2);
            information += row * row.transpose() * weight;
            sum += row * (off * weight);
            n_edges += 1;
        }
        if n_edges < FEWEST_EDGES {
            return None;
        }
        let lean_weight = told.first().map_or(0.0, |(_, edge)| edge.lean_sigma_rad.powi(-2));
        information += Matrix3::from_diagonal(&Vector3::new(0.0, lean_weight, lean_weight));
        let covariance = information.try_inverse()?;
        (fit, variance) = (covariance * sum, covariance[(0, 0)]);
    }
    Some((fit[0], variance))
}

impl Walls {
    /// The walls of a scene whose localizer uses the camera that looks ahead.
    pub(crate) fn new(map: &Map, robot: &RobotModel, scene: &Scene) -> Option<Walls> {
        let camera = robot.forward_camera.filter(|_| scene.localizer.methods.contains(&MethodName::WallDirections))?;
        let directions = &map.wall_directions_rad;
        Some(Walls {
            camera,
            body: robot.body,
            directions_rad: directions.iter().map(|direction| direction.mid()).collect(),
            direction_within_rad: directions.iter().map(|direction| 0.5 * direction.width()).fold(0.0, f64::max),
            floor_edges: scene.localizer.wall_directions().floor_edges,
        })
    }

    /// Yaw of the camera; a building that is turned against its plan looks just like a camera that is.
    pub(crate) fn mount(&self) -> Mount {
        let yaw_rad = (0.5 * self.camera.yaw_rad.width()).hypot(self.direction_within_rad);
        Mount { sigma: [0.0, 0.0, SIGMAS_OF_BOUND * yaw_rad] }
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let Reading::Camera { camera: Camera::Forward, image, .. } = reading else { return None };
        let lines = forward::detect(&Picture::from(&**image));
        Some(Seen::Edges(lines.iter().filter_map(|line| self.edge(line, twist)).collect()))
    }

    fn edge(&self, line: &EdgeLine, twist: &Twist) -> Option<Edge> {
        let rays = line.ends_px.map(|end| self.in_robot(end, twist));
        let normal = rays[0].cross(&rays[1]).normalize();
        if normal.xy().norm() < LEAST_SLOPE || normal.z.abs() < LEAST_SLOPE {
            return None;
        }
        let elevations = rays.map(|ray| ray.z / ray.xy().norm());
        let [[u0, v0], [u1, v1]] = line.ends_px;
        let length_px = (u1 - u0).hypot(v1 - v0);
        let on_floor = elevations.iter().any(|elevation| *elevation < DEEPEST);
        if elevations[0] * elevations[1] < 0.0 || (on_floor && !(self.floor_edges && length_px >= LONG_PX)) {
            return None;
        }
        let direction_rad = level_direction(&normal);
        let bound_px = line.bound_px.hypot(self.camera.distortion_px);
        let across_px = [-(v1 - v0) / length_px, (u1 - u0) / length_px].map(|part| part * bound_px * SIGMAS_OF_BOUND);
        let moved_rad = |end: usize| {
            let mut ends_px = line.ends_px;
            ends_px[end] = [0, 1].map(|axis| ends_px[end][axis] + across_px[axis]);
            let rays = ends_px.map(|end| self.in_robot(end, twist));
            within_half_turn(level_direction(&rays[0].cross(&rays[1])) - direction_rad)
        };
        let [_, stray_rad] = stray(twist, self.camera.stamp_error_s);
        let sigma_rad = moved_rad(0).hypot(moved_rad(1)).hypot(stray_rad);
        let leaning = |axis: Vector3<f64>| {
            let leant = Rotation3::new(axis * LEAN_STEP_RAD) * normal;
            within_half_turn(level_direction(&leant) - direction_rad) / LEAN_STEP_RAD
        };
        let by_lean = [leaning(Vector3::x()), leaning(Vector3::y())];
        let lean_sigma_rad = SIGMAS_OF_BOUND * self.camera.tilt_error_rad.hypot(self.body.tilt_rad);
        (sigma_rad <= WORST_RAD).then_some(Edge { direction_rad, sigma_rad, by_lean, lean_sigma_rad })
    }

    /// Direction of a pixel's ray in the robot frame at the image's stamp. The camera's u axis is level and points right, its optical axis is tilted
    /// up.
    fn in_robot(&self, pixel: [f64; 2], twist: &Twist) -> Vector3<f64> {
        let [.., turn_rad] = since_stamp(twist, (self.camera.row_time_s, self.camera.height_px), pixel[1]);
        let in_camera = ray(pixel, &self.camera);
        let (sin, cos) = self.camera.tilt_up_rad.sin_cos();
        let ahead =
            Vector3::new(cos * in_camera.z + sin * in_camera.y, -in_camera.x, sin * in_camera.z - cos * in_camera.y);
        Rotation3::from_axis_angle(&Vector3::z_axis(), self.camera.yaw_rad.mid() + turn_rad) * ahead
    }
}

/// Direction of the level line in a plane with the given normal.
fn level_direction(normal: &Vector3<f64>) -> f64 {
    normal.x.atan2(-normal.y)
}

/// The angle less the whole number of half turns nearest to it.
fn within_half_turn(angle_rad: f64) -> f64 {
    angle_rad - std::f64::consts::PI * (angle_rad / std::f64::consts::PI).round()
}
