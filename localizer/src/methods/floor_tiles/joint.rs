//! One line of an image of the floor as a statement about the robot's heading and position.

use std::f64::consts::{FRAC_PI_2, PI};

use interval::{Interval, IntervalBox};

use crate::{
    PoseUnion,
    vision::{FloorLine, line_fit::LineSet},
};

use super::{
    super::lean::{LeaningPlane, LeaningSight, heading_off_rad},
    Geometry,
};

/// Line seen on the floor, in the camera frame (forward, left; metres on the floor), with every declared error of the optics around it.
///
/// The feasible set of the line's normal angle ψ and its offset from the centroid is kept as found in the image: its hull alone would lose
/// the dependence between angle and offset.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    set: LineSet,
    /// Centroid of a floor line's points in the camera frame, in pixels: forward and left of the principal point.
    centroid_px: [f64; 2],
    /// Interval hull of a floor line's normal angle in the camera frame, as seen in the image.
    angle_rad: Interval,
    /// Points of the line in the robot frame, and the number of them that may belong to no joint.
    points_m: Vec<[f64; 2]>,
    n_wrong: usize,
    /// Greatest error of the floor position of any of the line's points.
    slack_m: f64,
    /// Greatest turn of the line by tilts of mount and body, and by the robot's turning within the stamp's error.
    tilt_angle_rad: f64,
    /// Greatest shift of the line along its normal by tilts and heave, and by the robot's motion within the stamp's error.
    shift_m: f64,
}

impl Joint {
    /// Makes the statement of a fitted line. `most_open_px` bounds the error that lens and shutter leave at any of the line's points.
    /// `None` when the line passes so far out that the bound on its turn by tilts is no longer useful.
    pub(super) fn new(set: LineSet, line: &FloorLine, most_open_px: f64, geometry: &Geometry) -> Option<Self> {
        let camera = &geometry.camera;
        let centroid_px = geometry.in_camera_px(set.centroid_px);
        let in_robot_m = |&[u, v, _]: &[f64; 3]| {
            let point_px = geometry.in_camera_px([u, v]);
            [0, 1].map(|axis| camera.position_m[axis].mid() + point_px[axis] / camera.pixels_per_m.mid())
        };
        let points_m: Vec<[f64; 2]> = line.points_px.iter().map(in_robot_m).collect();
        let n_wrong = (line.share_wrong * points_m.len() as f64).floor() as usize;
        let angle_rad = camera_angle(Interval::new(set.normal_angle_rad[0], set.normal_angle_rad[1]));
        let slack_m = room_slack_m(line, most_open_px, geometry)?;
        let mut joint =
            Joint { set, centroid_px, angle_rad, points_m, n_wrong, slack_m, tilt_angle_rad: 0.0, shift_m: 0.0 };
        joint.account_for_posture(geometry)?;
        (joint.tilt_angle_rad < FRAC_PI_2 / 4.0).then_some(joint)
    }

    /// Sets the bounds on the effects of mount tilt, body tilt, heave and stamp error on the line ([`LeaningPlane`]); `None` where these
    /// errors may move the line anywhere.
    ///
    /// Within the stamp's error the robot moves and turns. The line's distance from the robot origin changes only by the distance
    /// travelled, the camera's distance from the line also by the turn. Under a rolling shutter each row has its own posture of the body;
    /// there the bounds of the line's points account for that posture ([`body_shift_m`]).
    fn account_for_posture(&mut self, geometry: &Geometry) -> Option<()> {
        let (camera, body, reach) = (&geometry.camera, &geometry.robot.body, &geometry.robot.reach);
        let is_rolling = camera.row_time_s > 0.0;
        let (body_tilt_rad, heave_m) = if is_rolling { (0.0, 0.0) } else { (body.tilt_rad, body.heave_m) };
        let normal = Interval::point(1.0) * self.angle_rad;
        let distance_px = normal.cos() * self.centroid_px[0] + normal.sin() * self.centroid_px[1] + self.offset_hull();
        let slope = (distance_px.abs() / camera.pixels_per_m.lo() / camera.height_m).hi();
        let leaning = LeaningPlane::new(slope, camera.tilt_rad, body_tilt_rad)?;
        let arm_m = camera.position_m[0].hypot(camera.position_m[1]).hi();
        let stamp_m = (Interval::point(reach.turn_rate_rad_per_s) * arm_m + reach.speed_m_per_s) * camera.stamp_error_s;
        self.shift_m = (stamp_m + leaning.shift_m(camera.height_m, arm_m, heave_m)).hi();
        let stamp_rad = Interval::point(camera.stamp_error_s) * reach.turn_rate_rad_per_s;
        self.tilt_angle_rad = (stamp_rad + leaning.turn_rad()? + heading_off_rad(body_tilt_rad)).hi();
        Some(())
    }

    /// Interval hull of ψ, the line's normal angle in the robot frame.
    pub(super) fn robot_angle(&self, geometry: &Geometry) -> Interval {
        (self.angle_rad + geometry.camera.yaw_rad).inflate(self.tilt_angle_rad)
    }

    /// Families k of tile joints with k·π/2 + γ ∈ θ + ψ, within the laying angle's tolerance, as an inclusive range that is empty when
    /// first > last. For an unbounded heading these are all families.
    pub(super) fn families(&self, heading: Interval, geometry: &Geometry) -> (i64, i64) {
        let turned =
            (heading + self.robot_angle(geometry) - geometry.grid.rotation_rad).inflate(geometry.grid.laying_angle_rad);
        if turned.is_empty() {
            return (1, 0);
        }
        let quarter = turned / (Interval::PI * 0.5);
        (quarter.lo().ceil() as i64, quarter.hi().floor() as i64)
    }

    /// Headings that make this line a joint of the family `family`: θ = k·π/2 + γ − ψ.
    pub(super) fn heading(&self, family: i64, geometry: &Geometry) -> Interval {
        (family_angle(family, geometry) - self.robot_angle(geometry)).inflate(geometry.grid.laying_angle_rad)
    }

    /// Whether for some heading of the prior the line can be a tile joint.
    pub(super) fn agrees(&self, prior: &PoseUnion, geometry: &Geometry) -> bool {
        prior.branches.iter().any(|branch| {
            let (first, last) = self.families(branch[2], geometry);
            first <= last
        })
    }

    /// Whether, seen from every pose of the box, more of the line's points lie outside the room than may be wrong.
    pub(super) fn leaves_room(&self, pose: &IntervalBox<3>, geometry: &Geometry) -> bool {
        let (cos, sin) = (pose[2].cos(), pose[2].sin());
        let outside = self.points_m.iter().filter(|&&[forward_m, left_m]| {
            let x = pose[0] + cos * forward_m - sin * left_m;
            let y = pose[1] + sin * forward_m + cos * left_m;
            !x.overlaps(geometry.room_m[0].inflate(self.slack_m))
                || !y.overlaps(geometry.room_m[1].inflate(self.slack_m))
        });
        outside.count() > self.n_wrong
    }

    /// Distance from the robot origin to the joint along the grid axis of the family, σ·(n(ψ)·a + n(ψ_camera)·c + offset): the grid
    /// coordinate of the joint minus that of the robot origin. Empty when no line of the feasible set fits the heading.
    pub(super) fn ahead(&self, family: i64, heading: Interval, geometry: &Geometry) -> Interval {
        let camera = &geometry.camera;
        let robot_angle = (family_angle(family, geometry) - heading)
            .inflate(geometry.grid.laying_angle_rad)
            .intersect(self.robot_angle(geometry));
        let camera_angle = (robot_angle - camera.yaw_rad).inflate(self.tilt_angle_rad).intersect(self.angle_rad);
        if robot_angle.is_empty() || camera_angle.is_empty() {
            return Interval::EMPTY;
        }
        let mount = robot_angle.cos() * camera.position_m[0] + robot_angle.sin() * camera.position_m[1];
        let ahead = (mount + self.distance(camera_angle) / camera.pixels_per_m).inflate(self.shift_m);
        if family.rem_euclid(4) < 2 { ahead } else { -ahead }
    }

    /// Distance n(ψ)·c + offset of the line in pixels, over the part of the feasible set with ψ in `angle`. The angle is cut into slices,
    /// so that the dependence between offset and angle is kept.
    fn distance(&self, angle: Interval) -> Interval {
        const SLICES: usize = 4;
        let step = angle.width() / SLICES as f64;
        let mut distance = Interval::EMPTY;
        for slice in 0..SLICES {
            let lo = angle.lo() + slice as f64 * step;
            let hi = if slice + 1 == SLICES { angle.hi() } else { lo + step };
            // Slices of the angle overlap by a hair, so that rounding lets no angle fall between two of them.
            let part = Interval::new(lo, hi.max(lo)).inflate(1e-12);
            let image = image_angle(part, self.set.direction_rad);
            let Some([offset_lo, offset_hi]) = self.set.offset_at(image.lo(), image.hi()) else { continue };
            let along = part.cos() * self.centroid_px[0] + part.sin() * self.centroid_px[1];
            distance = distance.hull(along + Interval::new(offset_lo, offset_hi));
        }
        distance
    }

    fn offset_hull(&self) -> Interval {
        Interval::new(self.set.offset_px[0], self.set.offset_px[1])
    }
}

/// Point of the floor that a pixel shows, with bounds on the point's place. The pixel is given as `[forward, left]` of the principal point
/// and known to `bound_px`.
pub(super) struct FloorPoint {
    pub(super) sight: LeaningSight,
    /// Greatest distance of the floor point from the robot origin, for a body that stands level.
    pub(super) arm_m: f64,
    /// Greatest distance of the floor point from its place by nominal values, for a body that stands level.
    off_m: f64,
}

impl FloorPoint {
    /// Makes the floor point of a pixel; `None` where the declared leans may let the camera see the horizon at the pixel.
    pub(super) fn of(pixel_px: [f64; 2], bound_px: f64, geometry: &Geometry) -> Option<Self> {
        let camera = &geometry.camera;
        let reach_px = Interval::point(pixel_px[0]).hypot(Interval::point(pixel_px[1])) + bound_px;
        let distance_m = (reach_px / camera.pixels_per_m.lo()).hi();
        let sight = LeaningSight::new(distance_m, camera.height_m, camera.tilt_rad, geometry.robot.body.tilt_rad)?;
        let mount_m = camera.position_m.map(|at| Interval::point(at.radius()));
        // The chord of a turn is shorter than its arc, so the arc bounds a floor point's shift by the yaw error.
        let by_yaw_m = sight.distance_m * camera.yaw_rad.magnitude();
        let by_scale_m = reach_px / camera.pixels_per_m.lo() - reach_px / camera.pixels_per_m.mid();
        let by_bound_m = Interval::point(bound_px) / camera.pixels_per_m.lo();
        let off_m = (mount_m[0].hypot(mount_m[1]) + by_yaw_m + by_scale_m + by_bound_m + sight.by_mount_m).hi();
        let place_m = [0, 1].map(|axis| camera.position_m[axis].mid() + pixel_px[axis] / camera.pixels_per_m.mid());
        let arm_m = place_m[0].hypot(place_m[1]) + off_m;
        Some(FloorPoint { sight, arm_m, off_m })
    }
}

/// Greatest error of the floor position of any of the line's points at the stamp, for all declared errors together.
fn room_slack_m(line: &FloorLine, open_px: f64, geometry: &Geometry) -> Option<f64> {
    let (camera, body, reach) = (&geometry.camera, &geometry.robot.body, &geometry.robot.reach);
    line.points_px.iter().try_fold(0.0_f64, |most_m, &[u, v, bound_px]| {
        let point = FloorPoint::of(geometry.in_camera_px([u, v]), bound_px + open_px, geometry)?;
        let by_body_m = point.sight.by_body_m(point.sight.distance_m.hi(), point.arm_m, body.heave_m);
        let by_stamp_m =
            camera.stamp_error_s * (reach.speed_m_per_s + reach.turn_rate_rad_per_s * (point.arm_m + by_body_m));
        Some(most_m.max(point.off_m + by_body_m + by_stamp_m))
    })
}

/// Greatest shift of a floor point across a line by tilt and heave of the body. `along_m` is the point's distance, across the line, from
/// the point below the camera.
pub(super) fn body_shift_m(along_m: f64, point: &FloorPoint, geometry: &Geometry) -> f64 {
    point.sight.by_body_m(along_m, point.arm_m, geometry.robot.body.heave_m)
}

/// Angle of the normals of a family of joints in the world frame: k·π/2 + γ.
fn family_angle(family: i64, geometry: &Geometry) -> Interval {
    Interval::PI * 0.5 * (family as f64) + geometry.grid.rotation_rad
}

/// Normal angle of a line in the camera frame (forward, left), computed from its normal angle `image` in pixels (right, down).
///
/// Forward is minus down and left is minus right, so n = (cos α, sin α) in (u, v) is −(sin α, cos α) in (forward, left): ψ = −π/2 − α.
fn camera_angle(image: Interval) -> Interval {
    -(image + Interval::PI * 0.5)
}

/// Inverse of [`camera_angle`]: the normal angle in pixels, moved by whole turns next to `near`.
fn image_angle(camera: Interval, near: f64) -> Interval {
    let angle = -(camera + Interval::PI * 0.5);
    let turns = ((near - angle.mid()) / (2.0 * PI)).round();
    angle + Interval::PI * 2.0 * turns
}
