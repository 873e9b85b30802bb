//! Joints of a tiled floor as straight lines in the robot frame.

use localizer::{
    Map, Reading, RobotModel,
    map::TileGrid,
    methods::floor_tiles::{Chain, FloorTiles},
    motion::Twist,
    robot::{BodyModel, FloorCameraModel},
    vision::FloorLine,
};
use nalgebra::{Matrix2, Vector2};

use super::{Mount, SIGMAS_OF_BOUND, Seen, stray, turned, within_quarter};

/// Joints as the camera that looks down sees them.
pub(crate) struct Floor {
    method: FloorTiles,
    camera: FloorCameraModel,
    body: BodyModel,
    pub(crate) grid: TileGrid,
}

/// The line of one joint: the points p of the robot frame with n(ψ)·p = d, where n(ψ) is the unit vector at the angle ψ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// Angle ψ of the line's normal, counter-clockwise from robot forward.
    pub(crate) normal_rad: f64,
    /// Distance d of the line from the robot's origin along the normal.
    pub(crate) distance_m: f64,
    /// Standard deviations of the angle, and of the distance.
    pub(crate) sigma: [f64; 2],
}

/// What a joint says about a pose: for its heading and for its position along one axis of the grid, the residual (measured less predicted).
pub(crate) struct Agreement {
    /// Residual of the heading.
    pub(crate) turn_rad: f64,
    /// Unit vector in the world along which the joint tells the position, and the residual along it.
    pub(crate) along: [f64; 2],
    pub(crate) off_m: f64,
    /// Half the distance between neighbouring joints: what the residual may be without being that of another joint.
    pub(crate) half_edge_m: f64,
}

impl Joint {
    /// Compares the joint with the nearest one that the map has for a pose, where the device is seen from `pose` with its mount's errors included.
    ///
    /// With the heading θ, θ + ψ is a direction of the grid, γ + k·π/2, and n(γ + k·π/2)·P + d is the coordinate of a joint.
    pub(crate) fn agreement(&self, [x_m, y_m, heading_rad]: [f64; 3], grid: &TileGrid) -> Agreement {
        let turn_rad = within_quarter(grid.rotation_rad - heading_rad - self.normal_rad);
        let direction_rad = heading_rad + self.normal_rad + turn_rad;
        let along = turned([1.0, 0.0], direction_rad);
        // The direction is an axis of the grid up to its sign.
        let on_grid = turned(along, -grid.rotation_rad);
        let axis = usize::from(on_grid[1].abs() > on_grid[0].abs());
        let (edge_m, phase_m) = (grid.edge_m[axis], grid.phase_m[axis] * on_grid[axis].signum());
        let coordinate_m = along[0] * x_m + along[1] * y_m + self.distance_m;
        let nearest_m = phase_m + edge_m * ((coordinate_m - phase_m) / edge_m).round();
        Agreement { turn_rad, along, off_m: nearest_m - coordinate_m, half_edge_m: 0.5 * edge_m }
    }
}

impl Floor {
    pub(crate) fn new(map: &Map, robot: &RobotModel) -> Option<Floor> {
        Some(Floor {
            method: FloorTiles::new(map, robot, Chain::Direct)?,
            camera: robot.floor_camera.clone()?,
            body: robot.body,
            grid: map.tiles.clone()?,
        })
    }

    /// Position and yaw of the camera, and the tilt of its mount, which moves the picture of the floor like a wrong position.
    pub(crate) fn mount(&self) -> Mount {
        let tilted_m = self.camera.tilt_rad * self.camera.height_m;
        let along = |axis: usize| SIGMAS_OF_BOUND * (0.5 * self.camera.position_m[axis].width()).hypot(tilted_m);
        Mount { sigma: [along(0), along(1), SIGMAS_OF_BOUND * 0.5 * self.camera.yaw_rad.width()] }
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let lines = self.method.look(reading, twist)?.lines;
        Some(Seen::Joints(lines.iter().filter_map(|line| self.joint(line, twist)).collect()))
    }

    /// The line's joint by least squares, in the robot frame.
    fn joint(&self, line: &FloorLine, twist: &Twist) -> Option<Joint> {
        let camera = &self.camera;
        let [middle_u, middle_v] = [camera.width_px, camera.height_px].map(|size_px| 0.5 * (f64::from(size_px) - 1.0));
        let per_m = camera.pixels_per_m.mid();
        let mut points: Vec<(Vector2<f64>, f64)> = line
            .points_px
            .iter()
            .map(|[u, v, bound_px]| (Vector2::new(middle_v - v, middle_u - u) / per_m, bound_px / per_m))
            .collect();
        let n_wrong = (line.share_wrong * points.len() as f64).floor() as usize;
        let places = |points: &[(Vector2<f64>, f64)]| points.iter().map(|(place, _)| *place).collect::<Vec<_>>();
        let (first_middle, first_normal) = fitted(&places(&points))?;
        // The points farthest from a first fit may be wrong.
        let off = |point: &Vector2<f64>| (point - first_middle).dot(&first_normal).abs();
        points.sort_by(|one, other| off(&one.0).total_cmp(&off(&other.0)));
        points.truncate(points.len() - n_wrong);
        let (middle, normal) = fitted(&places(&points))?;
        let along = Vector2::new(-normal.y, normal.x);
        let n_points = points.len() as f64;
        let bound_m = points.iter().map(|(_, bound_m)| bound_m).sum::<f64>() / n_points;
        let spread_m =
            (points.iter().map(|(point, _)| (point - middle).dot(&along).powi(2)).sum::<f64>() / n_points).sqrt();
        let [stray_m, stray_rad] = stray(twist, camera.stamp_error_s);
        let grid = &self.grid;
        // Errors that all points of a line have in common do not average out, so that a line is as good as its points.
        let scale_m = 0.5 * camera.pixels_per_m.width() / per_m * middle.norm();
        let tilted_m = self.body.tilt_rad * camera.height_m;
        let lens_m = camera.distortion_px / per_m;
        let line_m = bound_m.hypot(grid.straightness_m).hypot(lens_m);
        let off_m = [line_m, grid.laying_m, tilted_m, scale_m].into_iter().fold(0.0, f64::hypot);
        let turn_rad = grid.laying_angle_rad.hypot(line_m / spread_m);
        let yaw_rad = camera.yaw_rad.mid();
        let position = turned(middle.into(), yaw_rad);
        let normal_rad = normal.y.atan2(normal.x) + yaw_rad;
        let n = turned([1.0, 0.0], normal_rad);
        let mount_m = camera.position_m.map(|side| side.mid());
        let distance_m = n[0] * (position[0] + mount_m[0]) + n[1] * (position[1] + mount_m[1]);
        let sigma = [(SIGMAS_OF_BOUND * turn_rad).hypot(stray_rad), (SIGMAS_OF_BOUND * off_m).hypot(stray_m)];
        (spread_m > 0.0).then_some(Joint { normal_rad, distance_m, sigma })
    }
}

/// Middle and unit normal of the line with the least sum of squared distances from the points.
pub(super) fn fitted(points: &[Vector2<f64>]) -> Option<(Vector2<f64>, Vector2<f64>)> {
    if points.len() < 2 {
        return None;
    }
    let middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let scatter: Matrix2<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let least = usize::from(eigen.eigenvalues[1] < eigen.eigenvalues[0]);
    Some((middle, eigen.eigenvectors.column(least).into_owned()))
}
