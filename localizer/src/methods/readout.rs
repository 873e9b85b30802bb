//! Straight edges in images of a rolling shutter, as a global shutter would have shown them at the image's stamp.
//!
//! The row of an edge's end is exposed a time Δt after the stamp, when the robot has turned by δ and the camera has moved by s. What is seen along r
//! then, at a distance d, is seen along R(δ) r + s/d from where the camera was. The turn and the motion are enclosed by wheels and gyroscope. The
//! distance is not known: the claim of an edge is that what it shows is at least [`NEAREST_M`] away, and that the robot leans the same while the image
//! is read out. The end is put half-way between where it would be at that distance and where it would be infinitely far away, and what is left open is
//! added to the edge's bound.

use nalgebra::{Rotation3, Vector3};

use crate::{
    method::MotionBetween,
    motion,
    robot::{ForwardCameraModel, Reach, RobotModel},
    vision::{distortion, forward::EdgeLine},
};
use interval::Interval;

use super::{
    rows::Rows,
    sight::{in_robot, length_px, ray},
};

/// Least distance from the camera of what an edge shows.
pub(super) const NEAREST_M: f64 = 0.5;
/// Factor on what is left open of an edge's place: makes up for the curvature of the camera's mapping over so little.
const CURVED: f64 = 1.1;

/// What an edge is to tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tells {
    /// Only its direction, so that the camera may be anywhere along the robot's way.
    Direction,
    /// The direction in which it is seen, from where the camera was at the stamp.
    Bearing,
}

/// A camera that looks ahead and exposes its rows one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readout {
    camera: ForwardCameraModel,
    reach: Reach,
    /// Share of a turn by which it may be another one for the camera: its axis leans by so much, and a pixel's ray is known so well.
    attitude: f64,
    /// Greatest change of the turn rate in a second.
    turn_change_rad_per_s2: f64,
}

impl Readout {
    /// The readout of a robot's camera.
    pub(super) fn of(camera: &ForwardCameraModel, robot: &RobotModel) -> Readout {
        let focal_px = camera.focal_px.lo();
        let centre_px = camera.principal_point_px.map(|at| at.radius()).into_iter().fold(0.0, f64::hypot);
        let of_ray = (camera.focal_px.radius() + centre_px + camera.distortion_px) / focal_px;
        Readout {
            camera: *camera,
            reach: robot.reach,
            attitude: camera.tilt_error_rad + robot.body.tilt_rad + 2.0 * of_ray,
            turn_change_rad_per_s2: motion::greatest_change_rad_per_s2(&robot.wheels, &robot.reach),
        }
    }

    /// Edges of an image with the stamp `stamp_s`, moved to where a global shutter would have shown them then, each with a bound that allows for what
    /// is not known of the motion meanwhile. An edge of which nothing is known any more is left out.
    pub(super) fn at_stamp(
        &self,
        lines: Vec<EdgeLine>,
        tells: Tells,
        stamp_s: f64,
        motion: MotionBetween,
    ) -> Vec<EdgeLine> {
        let shape = (self.camera.row_time_s, self.camera.height_px);
        let Some(rows) = Rows::of(shape, stamp_s, self.reach, motion) else { return lines };
        lines.iter().filter_map(|line| self.line_at_stamp(line, tells, &rows)).collect()
    }

    fn line_at_stamp(&self, line: &EdgeLine, tells: Tells, rows: &Rows) -> Option<EdgeLine> {
        let [[u0, v0], [u1, v1]] = line.ends_px;
        let across = [-(v1 - v0), u1 - u0].map(|part| part / length_px(line));
        let (mut ends_px, mut open_px) = (line.ends_px, 0.0_f64);
        for ([u, v], end_px) in line.ends_px.into_iter().zip(&mut ends_px) {
            let turn = rows.moved(v, line.bound_px)[2];
            let [ahead, left, turn_since] = match tells {
                Tells::Direction => rows.between(0.5 * (v0 + v1), v, line.bound_px),
                Tells::Bearing => rows.moved(v, line.bound_px),
            };
            // The camera turns about the robot's origin.
            let [arm_ahead, arm_left] = self.camera.position_m;
            let (sin, less) = (turn_since.sin(), turn_since.cos() - Interval::ONE);
            let shift = [ahead + arm_ahead * less - arm_left * sin, left + arm_ahead * sin + arm_left * less];
            let toward = Vector3::new(shift[0].mid(), shift[1].mid(), 0.0) / NEAREST_M;
            let seen = in_robot(ray([u, v], &self.camera).normalize(), self.camera.tilt_up_rad);
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), turn.mid()) * self.by_yaw(&seen);
            let [far, near] = [turned, turned + toward].map(|seen| self.pixel(&seen));
            let (far, near) = (far?, near?);
            *end_px = [0, 1].map(|axis| 0.5 * (far.at_px[axis] + near.at_px[axis]));
            let apart_px = across[0] * (near.at_px[0] - far.at_px[0]) + across[1] * (near.at_px[1] - far.at_px[1]);
            // All rows are off by the stamp's error alike, but for what the robot's speeds change meanwhile.
            let late_s2 = self.camera.stamp_error_s * rows.after_s(v).abs();
            let Reach { speed_m_per_s, turn_rate_rad_per_s, acceleration_m_per_s2 } = self.reach;
            let change_m_per_s2 = acceleration_m_per_s2 + speed_m_per_s * turn_rate_rad_per_s;
            let shift_m = shift[0].magnitude().hypot(shift[1].magnitude());
            let off_m = shift[0].radius().hypot(shift[1].radius()) + shift_m * turn.magnitude();
            let off_rad = turn.radius()
                + turn.magnitude() * self.attitude
                + self.turn_change_rad_per_s2 * late_s2
                + (off_m + change_m_per_s2 * late_s2) / NEAREST_M;
            open_px = open_px.max(0.5 * apart_px.abs() + off_rad * far.px_per_rad.max(near.px_per_rad));
        }
        // The edge itself is turned by as much as its ends move, so that its bound is measured across another direction.
        let [[nu0, nv0], [nu1, nv1]] = ends_px;
        let moved = EdgeLine { ends_px, bound_px: line.bound_px };
        let along = ((u1 - u0) * (nu1 - nu0) + (v1 - v0) * (nv1 - nv0)) / (length_px(line) * length_px(&moved));
        let bound_px = CURVED * (line.bound_px / along + open_px);
        (along > 0.9 && bound_px.is_finite()).then_some(EdgeLine { bound_px, ..moved })
    }

    /// A direction in the frame of the nominal mount, turned as the camera's yaw has it.
    fn by_yaw(&self, seen: &Vector3<f64>) -> Vector3<f64> {
        Rotation3::from_axis_angle(&Vector3::z_axis(), self.camera.yaw_rad.mid()) * seen
    }

    /// The pixel that shows a direction of the robot frame, by nominal values; `None` behind the camera.
    fn pixel(&self, seen: &Vector3<f64>) -> Option<Pixel> {
        let (sin, cos) = self.camera.tilt_up_rad.sin_cos();
        let seen = Rotation3::from_axis_angle(&Vector3::z_axis(), -self.camera.yaw_rad.mid()) * seen;
        let ahead = cos * seen.x + sin * seen.z;
        let at = [-seen.y / ahead, (sin * seen.x - cos * seen.z) / ahead];
        let bent = distortion::bend(self.camera.distortion, at);
        let focal_px = self.camera.focal_px.mid();
        let [a, mixed, b] = distortion::slopes(self.camera.distortion, at);
        let slope = 0.5 * (a + b).abs() + (0.5 * (a - b)).hypot(mixed);
        (ahead > 0.0).then(|| Pixel {
            at_px: [0, 1].map(|axis| focal_px * (at[axis] + bent[axis]) + self.camera.principal_point_px[axis].mid()),
            px_per_rad: focal_px * slope * (1.0 + at[0] * at[0] + at[1] * at[1]),
        })
    }
}

/// A place in an image.
struct Pixel {
    at_px: [f64; 2],
    /// Greatest distance by which it moves where what it shows is turned, for each radian.
    px_per_rad: f64,
}

#[cfg(test)]
mod tests {
    use interval::IntervalBox;
    use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};

    use super::*;
    use crate::{
        graph::trial::{Draw, robot, rounds},
        robot::BodyModel,
    };

    const ROW_TIME_S: f64 = 5e-5;
    const MOUNT_M: [f64; 3] = [0.12, -0.05, 0.25];

    /// A camera with all errors within their bounds, on a robot that drives on a circle.
    struct Trial {
        robot: RobotModel,
        told: ForwardCameraModel,
        body_from_camera: Isometry3<f64>,
        focal_px: f64,
        centre_px: [f64; 2],
        off_px: [f64; 2],
        speed_m_per_s: f64,
        turn_rad_per_s: f64,
        /// Half widths of what is known of speed and turn rate.
        known: [f64; 2],
    }

    impl Trial {
        fn new(draw: &mut Draw) -> Trial {
            let around = |nominal: f64, half: f64| Interval::centred(nominal, half);
            let told = ForwardCameraModel {
                focal_px: around(417.0, draw.size(1e-3, 2.0)),
                principal_point_px: [around(319.5, draw.size(1e-3, 3.0)), around(239.5, draw.size(1e-3, 3.0))],
                distortion: [-0.08, 0.02, 0.001, -0.001, 0.0],
                distortion_px: draw.size(1e-3, 0.3),
                tilt_up_rad: 0.15,
                yaw_rad: around(draw.between(-0.3, 0.3), draw.size(1e-4, 0.01)),
                tilt_error_rad: draw.size(1e-4, 0.01),
                stamp_error_s: 0.0,
                position_m: [around(MOUNT_M[0], 0.002), around(MOUNT_M[1], 0.002)],
                height_m: around(MOUNT_M[2], 0.002),
                height_px: 480,
                row_time_s: ROW_TIME_S,
            };
            let body_rad = draw.size(1e-4, 0.01);
            let mut lean = |most_rad: f64| {
                let (about, size) = (draw.between(-3.2, 3.2), draw.between(0.5, 1.0));
                let axis = Vector3::new(about.cos(), about.sin(), 0.0) * most_rad * size;
                UnitQuaternion::from_scaled_axis(axis)
            };
            let (body, mount) = (lean(body_rad), lean(told.tilt_error_rad));
            let at_m = Translation3::new(draw.within(told.position_m[0]), draw.within(told.position_m[1]), MOUNT_M[2]);
            let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), draw.within(told.yaw_rad));
            let course = draw.between(-3.2, 3.2);
            Trial {
                robot: RobotModel { body: BodyModel { tilt_rad: body_rad, heave_m: 0.0, clearance_m: 0.1 }, ..robot() },
                body_from_camera: body * at_m * yaw * mount,
                focal_px: draw.within(told.focal_px),
                centre_px: told.principal_point_px.map(|at| draw.within(at)),
                off_px: [course.cos() * told.distortion_px, course.sin() * told.distortion_px],
                speed_m_per_s: draw.between(-0.8, 0.8),
                turn_rad_per_s: draw.between(-1.5, 1.5),
                known: [draw.size(1e-3, 0.05), draw.size(1e-3, 0.05)],
                told,
            }
        }

        /// Pose of the robot a time after the stamp, as seen from where it is at the stamp: on a circle at constant speed.
        fn moved(&self, after_s: f64) -> Isometry3<f64> {
            let turn = self.turn_rad_per_s * after_s;
            let arc = |of_turn: f64, small: f64| if turn.abs() < 1e-9 { small } else { of_turn / turn };
            let way_m = self.speed_m_per_s * after_s;
            let at_m = [way_m * arc(turn.sin(), 1.0), way_m * arc(1.0 - turn.cos(), 0.5 * turn)];
            Isometry3::from_parts(
                Translation3::new(at_m[0], at_m[1], 0.0),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn),
            )
        }

        /// What wheels and gyroscope tell of the motion between two times: it holds the true one, which is at a corner.
        fn told_motion(&self, from_s: f64, to_s: f64) -> motion::Motion {
            let motion = self.moved(from_s).inverse() * self.moved(to_s);
            let (span_s, [of_way, of_turn]) = (to_s - from_s, self.known);
            let [ahead, left, turn] =
                [motion.translation.x, motion.translation.y, self.turn_rad_per_s * span_s].map(Interval::point);
            let beside = |half: f64| Interval::new(-0.1 * half, 1.9 * half) * span_s;
            IntervalBox::from([ahead + beside(of_way), left + beside(of_way), turn + beside(of_turn)])
        }

        /// Pixel that shows a point from an attitude and a place of the camera, in the frame of the robot at the stamp.
        fn pixel(&self, attitude: Isometry3<f64>, eye: Point3<f64>, point: &Point3<f64>) -> Option<[f64; 2]> {
            let at = (attitude * self.body_from_camera).rotation.inverse() * (point - eye);
            let (sin, cos) = self.told.tilt_up_rad.sin_cos();
            let ahead = at.x * cos + at.z * sin;
            let seen = [-at.y / ahead, (at.x * sin - at.z * cos) / ahead];
            let bent = distortion::bend(self.told.distortion, seen);
            (ahead > 0.1).then(|| {
                [0, 1].map(|axis| self.focal_px * (seen[axis] + bent[axis]) + self.centre_px[axis] + self.off_px[axis])
            })
        }

        fn eye(&self, after_s: f64) -> Point3<f64> {
            self.moved(after_s) * self.body_from_camera * Point3::origin()
        }

        /// Pixel that shows a point when the pixel's row is exposed.
        fn shown(&self, point: &Point3<f64>) -> Option<[f64; 2]> {
            let mut after_s = 0.0;
            for _ in 0..20 {
                let [_, v] = self.pixel(self.moved(after_s), self.eye(after_s), point)?;
                after_s = (v - 239.5) * ROW_TIME_S;
            }
            self.pixel(self.moved(after_s), self.eye(after_s), point)
        }
    }

    /// A straight edge some way before the camera: level in any direction, or upright.
    fn edge(draw: &mut Draw, eye: &Point3<f64>) -> [Point3<f64>; 2] {
        let (bearing, far_m) = (draw.between(-0.6, 0.6), draw.between(0.7, 6.0));
        let middle = eye + Vector3::new(far_m * bearing.cos(), far_m * bearing.sin(), far_m * draw.between(-0.2, 0.5));
        let (course, half_m) = (draw.between(-3.2, 3.2), far_m * draw.between(0.05, 0.25));
        let way = if draw.unit() < 0.5 { Vector3::new(course.cos(), course.sin(), 0.0) } else { Vector3::z() };
        [middle - way * half_m, middle + way * half_m]
    }

    /// Greatest share of its bound by which an edge at the stamp is off what a global shutter would show, over random edges.
    fn greatest_share(tells: Tells, change: impl Fn(&mut Readout)) -> f64 {
        let (mut most, mut n_seen) = (0.0_f64, 0);
        let mut draw = Draw::new(77);
        for _ in 0..rounds(20_000) {
            let trial = Trial::new(&mut draw);
            let points = edge(&mut draw, &trial.eye(0.0));
            // A little more than the half metre that the limits page promises, as the camera moves meanwhile.
            let near = |point: &Point3<f64>| (point - trial.eye(0.0)).norm() < 0.52;
            let [Some(a), Some(b)] = points.each_ref().map(|point| trial.shown(point)) else { continue };
            let is_in = |[u, v]: [f64; 2]| (0.0..640.0).contains(&u) && (0.0..480.0).contains(&v);
            if points.iter().any(near) || !is_in(a) || !is_in(b) {
                continue;
            }
            let line = EdgeLine { ends_px: [a, b], bound_px: 1e-3 };
            let mut readout = Readout::of(&trial.told, &trial.robot);
            change(&mut readout);
            let told = |from_s: f64, to_s: f64| Some(trial.told_motion(from_s - 7.0, to_s - 7.0));
            let Some(moved) = readout.at_stamp(vec![line], tells, 7.0, &told).first().copied() else { continue };
            // The place from which the moved edge is seen.
            let middle_s = 0.5 * (a[1] + b[1] - 479.0) * ROW_TIME_S;
            let eye = trial.eye(if tells == Tells::Bearing { 0.0 } else { middle_s });
            let global = points.each_ref().map(|point| trial.pixel(Isometry3::identity(), eye, point));
            let [Some(from), Some(to)] = global else { continue };
            let length_px = (to[0] - from[0]).hypot(to[1] - from[1]);
            let off_px = moved.ends_px.map(|[u, v]| {
                ((u - from[0]) * (to[1] - from[1]) - (v - from[1]) * (to[0] - from[0])).abs() / length_px
            });
            n_seen += 1;
            most = most.max(off_px[0].max(off_px[1]) / moved.bound_px);
        }
        assert!(n_seen > rounds(20_000) / 4, "{n_seen}");
        most
    }

    #[test]
    fn edges_at_the_stamp_are_where_a_global_shutter_would_show_them() {
        for tells in [Tells::Direction, Tells::Bearing] {
            let share = greatest_share(tells, |_| {});
            println!("{tells:?}: {share}");
            assert!(share > 0.6 && share <= 1.0, "{tells:?}: {share}");
        }
    }

    #[test]
    fn an_edge_is_missed_where_the_camera_is_taken_to_turn_about_itself() {
        let without_lever = |readout: &mut Readout| readout.camera.position_m = [Interval::ZERO; 2];
        assert!(greatest_share(Tells::Bearing, without_lever) > 1.0);
    }

    /// The bound of an upright edge through the middle of the image, from its upper to its lower border, at the stamp.
    fn opened_px(change: impl Fn(&mut Trial), motion: MotionBetween) -> f64 {
        let mut trial = Trial::new(&mut Draw::new(5));
        let exact = [Interval::point(319.5), Interval::point(239.5)];
        let told = &mut trial.told;
        (told.focal_px, told.principal_point_px, told.distortion_px) = (Interval::point(417.0), exact, 0.0);
        (told.distortion, told.tilt_up_rad, told.tilt_error_rad) = ([0.0; 5], 0.0, 0.0);
        (told.yaw_rad, told.position_m) = (Interval::ZERO, [Interval::ZERO; 2]);
        trial.robot.body.tilt_rad = 0.0;
        change(&mut trial);
        let line = EdgeLine { ends_px: [[319.5, 0.0], [319.5, 479.0]], bound_px: 0.0 };
        let moved = Readout::of(&trial.told, &trial.robot).at_stamp(vec![line], Tells::Bearing, 0.0, motion);
        moved.first().unwrap_or_else(|| panic!("an edge is left")).bound_px
    }

    #[test]
    fn what_errors_of_the_attitude_and_of_the_stamp_leave_open_is_in_the_bound() {
        // By hand: the rows at the border are exposed 239.5 · 50 µs = 12 ms from the stamp, in which a robot that turns at 1 rad/s turns by 12 mrad.
        let border_s = 239.5 * ROW_TIME_S;
        let turning = |from_s: f64, to_s: f64| Some(IntervalBox::from([0.0, 0.0, to_s - from_s].map(Interval::point)));
        assert!(opened_px(|_| {}, &turning) < 0.01);
        // An axis that leans by 20 mrad makes 2 % of the turn, and so does half of that from the mount and half from the body.
        for [mount_rad, body_rad] in [[0.02, 0.0], [0.0, 0.02], [0.01, 0.01]] {
            let leaning = |trial: &mut Trial| {
                (trial.told.tilt_error_rad, trial.robot.body.tilt_rad) = (mount_rad, body_rad);
            };
            assert!(opened_px(leaning, &turning) >= 417.0 * border_s * 0.02);
        }
        // A turn rate that changes by as much as it can makes another turn of the same rows when all of them are exposed 5 ms later.
        let late = |trial: &mut Trial| trial.told.stamp_error_s = 0.005;
        let change_rad_per_s2 = {
            let robot = robot();
            2.0 * robot.reach.acceleration_m_per_s2 / robot.wheels.track_m.lo()
        };
        let standing = |_: f64, _: f64| Some(IntervalBox::from([Interval::ZERO; 3]));
        assert!(opened_px(late, &standing) >= 417.0 * change_rad_per_s2 * 0.005 * border_s);
    }

    #[test]
    fn a_global_shutter_leaves_edges_as_they_are() {
        let trial = Trial::new(&mut Draw::new(1));
        let camera = ForwardCameraModel { row_time_s: 0.0, ..trial.told };
        let line = EdgeLine { ends_px: [[10.0, 20.0], [300.0, 50.0]], bound_px: 0.4 };
        let told = |from_s: f64, to_s: f64| Some(trial.told_motion(from_s, to_s));
        let same = Readout::of(&camera, &trial.robot).at_stamp(vec![line], Tells::Direction, 0.0, &told);
        assert_eq!(same, [line]);
    }
}
