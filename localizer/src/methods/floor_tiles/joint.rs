//! One line of an image as a statement on heading and position.

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

/// A line in the camera frame (forward, left; metres on the floor), with every declared error of the optics around it.
///
/// The feasible set of its normal angle ψ and its offset from the centroid stays that of the image: only its hull would lose
/// how the two go together.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    set: LineSet,
    /// Centroid in the camera frame, in pixels: forward and left of the principal point.
    centroid_px: [f64; 2],
    /// Hull of the normal angle in the camera frame, as seen.
    angle_rad: Interval,
    /// Points of the line in the robot frame, and how many of them may be no joint's.
    points_m: Vec<[f64; 2]>,
    n_wrong: usize,
    /// A point is off by no more.
    slack_m: f64,
    /// Greatest turn of the line by tilts of mount and body, and within the stamp's error.
    tilt_angle_rad: f64,
    /// Greatest shift of the line along its normal by tilts, heave and stamp.
    shift_m: f64,
}

impl Joint {
    /// The statement of a fitted line, what lens and shutter leave open at most of one of its points; `None` when the line passes so far
    /// out that its tilt bound makes no sense.
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

    /// Bounds of what mount tilt, body tilt, heave and stamp do to the line ([`LeaningPlane`]); `None` where they may do anything.
    ///
    /// Within the stamp's error the robot goes and turns: the line's distance from its origin changes by the way alone, that of the
    /// camera's place by the turn. Under a rolling shutter each row has a posture of its own: there the bounds of the points account for
    /// that of the body ([`body_shift_m`]).
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

    /// Hull of ψ, the normal angle in the robot frame.
    pub(super) fn robot_angle(&self, geometry: &Geometry) -> Interval {
        (self.angle_rad + geometry.camera.yaw_rad).inflate(self.tilt_angle_rad)
    }

    /// The families k with k·π/2 + γ ∈ θ + ψ, give or take the laying angle: inclusive range, empty when first > last. Of an unbounded
    /// heading it is all that there are.
    pub(super) fn families(&self, heading: Interval, geometry: &Geometry) -> (i64, i64) {
        let turned =
            (heading + self.robot_angle(geometry) - geometry.grid.rotation_rad).inflate(geometry.grid.laying_angle_rad);
        if turned.is_empty() {
            return (1, 0);
        }
        let quarter = turned / (Interval::PI * 0.5);
        (quarter.lo().ceil() as i64, quarter.hi().floor() as i64)
    }

    /// θ = k·π/2 + γ − ψ: the headings that make this line a joint of family `family`.
    pub(super) fn heading(&self, family: i64, geometry: &Geometry) -> Interval {
        (family_angle(family, geometry) - self.robot_angle(geometry)).inflate(geometry.grid.laying_angle_rad)
    }

    /// Whether some heading of the prior makes the line a joint.
    pub(super) fn agrees(&self, prior: &PoseUnion, geometry: &Geometry) -> bool {
        prior.branches.iter().any(|branch| {
            let (first, last) = self.families(branch[2], geometry);
            first <= last
        })
    }

    /// Whether more of the line's points than may be wrong lie outside of the room from every pose of the box.
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

    /// σ·(n(ψ)·a + n(ψ_camera)·c + offset), what lies between the robot origin and the joint along the grid axis of the family:
    /// grid coordinate of the joint minus that of the robot origin. Empty when no line of the feasible set fits the heading.
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

    /// n(ψ)·c + offset in pixels, over the part of the feasible set with ψ in `angle`, slice by slice so that offset and angle stay together.
    fn distance(&self, angle: Interval) -> Interval {
        const SLICES: usize = 4;
        let step = angle.width() / SLICES as f64;
        let mut distance = Interval::EMPTY;
        for slice in 0..SLICES {
            let lo = angle.lo() + slice as f64 * step;
            let hi = if slice + 1 == SLICES { angle.hi() } else { lo + step };
            // A hair of overlap, so that no angle falls between two slices by rounding.
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

/// Where a pixel `[forward, left]` of the principal point, known to `bound_px`, shows a point of the floor that a camera without errors of
/// mount and posture stands over.
pub(super) struct FloorPoint {
    pub(super) sight: LeaningSight,
    /// Distance from the robot origin, at most, for a body that stands level.
    pub(super) arm_m: f64,
    /// How far it is, then, from where nominal values put it.
    off_m: f64,
}

impl FloorPoint {
    /// `None` where the declared leans may let the camera see the horizon there.
    pub(super) fn of(pixel_px: [f64; 2], bound_px: f64, geometry: &Geometry) -> Option<Self> {
        let camera = &geometry.camera;
        let reach_px = Interval::point(pixel_px[0]).hypot(Interval::point(pixel_px[1])) + bound_px;
        let distance_m = (reach_px / camera.pixels_per_m.lo()).hi();
        let sight = LeaningSight::new(distance_m, camera.height_m, camera.tilt_rad, geometry.robot.body.tilt_rad)?;
        let mount_m = camera.position_m.map(|at| Interval::point(at.radius()));
        // The chord of a turn is shorter than its arc.
        let by_yaw_m = sight.distance_m * camera.yaw_rad.magnitude();
        let by_scale_m = reach_px / camera.pixels_per_m.lo() - reach_px / camera.pixels_per_m.mid();
        let by_bound_m = Interval::point(bound_px) / camera.pixels_per_m.lo();
        let off_m = (mount_m[0].hypot(mount_m[1]) + by_yaw_m + by_scale_m + by_bound_m + sight.by_mount_m).hi();
        let place_m = [0, 1].map(|axis| camera.position_m[axis].mid() + pixel_px[axis] / camera.pixels_per_m.mid());
        let arm_m = place_m[0].hypot(place_m[1]) + off_m;
        Some(FloorPoint { sight, arm_m, off_m })
    }
}

/// A point of the line is off by no more, at the stamp, for all declared errors together.
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

/// What tilt and heave of the body shift a point across a line, at most: it lies `along_m` from the point below the camera, across the line.
pub(super) fn body_shift_m(along_m: f64, point: &FloorPoint, geometry: &Geometry) -> f64 {
    point.sight.by_body_m(along_m, point.arm_m, geometry.robot.body.heave_m)
}

/// k·π/2 + γ.
fn family_angle(family: i64, geometry: &Geometry) -> Interval {
    Interval::PI * 0.5 * (family as f64) + geometry.grid.rotation_rad
}

/// Normal angle in the camera frame (forward, left) of a normal at `image` in pixels (right, down).
///
/// forward and left are minus down and minus right, so n = (cos α, sin α) in (u, v) is −(sin α, cos α) in (forward, left): ψ = −π/2 − α.
fn camera_angle(image: Interval) -> Interval {
    -(image + Interval::PI * 0.5)
}

/// The inverse of [`camera_angle`], on the turn of the circle nearest to `near`.
fn image_angle(camera: Interval, near: f64) -> Interval {
    let angle = -(camera + Interval::PI * 0.5);
    let turns = ((near - angle.mid()) / (2.0 * PI)).round();
    angle + Interval::PI * 2.0 * turns
}
