//! Test bench with a robot at known poses over a known tile grid, its floor camera behind a lens with distortion. Pictures are made, and
//! claims and boxes are checked, by formulas of the bench's own.

mod lens;
mod rows;

use image::GrayImage;

use super::{Chain, FloorTiles};
use interval::Interval;

use crate::{
    Constraint, Map, PoseBox, RobotModel,
    map::TileGrid,
    motion::Twist,
    robot::{BodyModel, FloorCameraModel, Reach, WheelModel},
    vision::synthetic::Random,
};

const SIZE_PX: [u32; 2] = [640, 480];
const MIDDLE_PX: [f64; 2] = [319.5, 239.5];
pub(super) const HEIGHT_M: f64 = 0.25;
pub(super) const SCALE: f64 = 640.0 / 0.48;
const MOUNT_M: [f64; 2] = [-0.15, 0.03];
const TILT_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Coefficients of a wide barrel lens: the picture's corner is 1.2 focal lengths from the middle.
const BARREL: [f64; 5] = [-0.25, 0.06, 0.001, 0.0, 0.0];
const PINCUSHION: [f64; 5] = [0.12, -0.02, -0.001, 0.001, 0.0];
const ROW_TIME_S: f64 = 30e-6;

/// Model of a robot whose camera mount, image scale and posture are known with the usual bounds.
fn robot(distortion: [f64; 5], distortion_px: f64, row_time_s: f64) -> RobotModel {
    known_robot(1.0, distortion, distortion_px, row_time_s)
}

/// Model of a robot whose bounds on camera mount, image scale and posture are the usual ones times a factor: with 0, nothing hides an error
/// of the lens.
pub(super) fn known_robot(factor: f64, distortion: [f64; 5], distortion_px: f64, row_time_s: f64) -> RobotModel {
    let tilt_rad = factor * TILT_RAD;
    let radius = Interval::point(0.1);
    RobotModel {
        wheels: WheelModel {
            radius_m: [radius, radius],
            track_m: Interval::point(0.33),
            ticks_per_turn: 1000.0,
            slip_ratio: 0.0,
            slip_floor_m: 0.0,
            side_slip_ratio: 0.0,
            side_slip_floor_m: 0.0,
            slip_window_s: 0.2,
        },
        reach: Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 },
        body: BodyModel { tilt_rad, heave_m: factor * 0.0001, clearance_m: 0.0 },
        floor_camera: Some(FloorCameraModel {
            width_px: SIZE_PX[0],
            height_px: SIZE_PX[1],
            pixels_per_m: Interval::centred(SCALE, factor * 0.001 * SCALE),
            height_m: HEIGHT_M,
            distortion,
            distortion_px,
            row_time_s,
            position_m: MOUNT_M.map(|at| Interval::centred(at, factor * 0.0005)),
            yaw_rad: Interval::centred(0.0, tilt_rad),
            tilt_rad,
            stamp_error_s: 0.0,
            q_items: 0,
        }),
        forward_camera: None,
        gyro: None,
        flow: None,
        ceiling_camera: None,
        range_camera: None,
        steering: None,
    }
}

pub(super) fn method(robot: &RobotModel, chain: Chain) -> FloorTiles {
    let room = Interval::new(-10.0, 10.0);
    let grid = TileGrid {
        edge_m: [0.30; 2],
        rotation_rad: 0.0,
        phase_m: [0.0; 2],
        joint_width_m: 0.004,
        laying_m: 0.0,
        laying_angle_rad: 0.0,
        straightness_m: 0.0,
    };
    let map =
        Map { room_m: [room, room], tiles: Some(grid), markers: None, wall_directions_rad: Vec::new(), walls: None };
    FloorTiles::new(&map, robot, chain).unwrap_or_else(|| panic!("a tiled map and a floor camera"))
}

/// True floor camera, over joints at the whole multiples of 0.30 m along x and y.
#[derive(Clone, Copy)]
pub(super) struct Eye {
    lens: [f64; 5],
    pub(super) focal_px: f64,
    mount_m: [f64; 2],
    yaw_rad: f64,
    /// Speeds of the robot forward, left and turning, while the rows are exposed one after the other.
    speed: [f64; 3],
    row_time_s: f64,
    /// Motion of the robot as the wheels report it.
    twist: Twist,
}

impl Eye {
    /// Floor camera without any error.
    pub(super) fn exact(lens: [f64; 5]) -> Self {
        Eye {
            lens,
            focal_px: SCALE * HEIGHT_M,
            mount_m: MOUNT_M,
            yaw_rad: 0.0,
            speed: [0.0; 3],
            row_time_s: 0.0,
            twist: Twist::default(),
        }
    }

    /// Floor camera with every error at a corner of its bound.
    fn with(lens: [f64; 5]) -> Self {
        Eye {
            lens,
            focal_px: 1.001 * SCALE * HEIGHT_M,
            mount_m: [MOUNT_M[0] + 0.0005, MOUNT_M[1] - 0.0005],
            yaw_rad: -TILT_RAD,
            ..Eye::exact(lens)
        }
    }

    /// Distorted image of the point (x, y) at depth 1, by Brown and Conrady's formula term by term.
    pub(super) fn bent(&self, x: f64, y: f64) -> [f64; 2] {
        let [k1, k2, p1, p2, k3] = self.lens;
        let r = x.hypot(y);
        let radial = 1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6);
        [
            x * radial + 2.0 * p1 * x * y + p2 * (3.0 * x * x + y * y),
            y * radial + p1 * (x * x + 3.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The point at depth 1 that is seen at a pixel of the distorted image. The distortion is inverted by Newton's method with derivatives
    /// by finite differences, which ends when the residual is below 1e-12.
    pub(super) fn ray(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        const STEP: f64 = 1e-6;
        let seen = [(u - MIDDLE_PX[0]) / self.focal_px, (v - MIDDLE_PX[1]) / self.focal_px];
        let mut at = seen;
        for _ in 0..50 {
            let here = self.bent(at[0], at[1]);
            let off = [seen[0] - here[0], seen[1] - here[1]];
            if off[0].hypot(off[1]) < 1e-12 {
                return at;
            }
            let (right, down) = (self.bent(at[0] + STEP, at[1]), self.bent(at[0], at[1] + STEP));
            let [a, c] = [0, 1].map(|axis| (right[axis] - here[axis]) / STEP);
            let [b, d] = [0, 1].map(|axis| (down[axis] - here[axis]) / STEP);
            let determinant = a * d - b * c;
            at[0] += (d * off[0] - b * off[1]) / determinant;
            at[1] += (a * off[1] - c * off[0]) / determinant;
        }
        panic!("no point at {u}, {v}");
    }

    /// World position at which a ray meets the floor, for a robot at a given pose: image up is forward, image right is right.
    fn on_floor(&self, [x, y]: [f64; 2], [x_m, y_m, heading_rad]: [f64; 3]) -> [f64; 2] {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (ahead, left) = (-y * HEIGHT_M, -x * HEIGHT_M);
        let [forward_m, left_m] =
            [self.mount_m[0] + cos * ahead - sin * left, self.mount_m[1] + sin * ahead + cos * left];
        let (sin, cos) = heading_rad.sin_cos();
        [x_m + cos * forward_m - sin * left_m, y_m + sin * forward_m + cos * left_m]
    }

    /// Rays of four places within each pixel, row by row.
    fn rays(&self) -> Vec<[[f64; 2]; 4]> {
        let rows = (0..SIZE_PX[1]).flat_map(|v| (0..SIZE_PX[0]).map(move |u| [f64::from(u), f64::from(v)]));
        let parts = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
        rows.map(|[u, v]| parts.map(|[du, dv]| self.ray([u + du, v + dv]))).collect()
    }

    /// Pose of the robot when a row is exposed, from its pose at the stamp.
    fn pose_at_row(&self, pose: [f64; 3], v: f64) -> [f64; 3] {
        if self.row_time_s > 0.0 { moved(pose, self.speed, (v - MIDDLE_PX[1]) * self.row_time_s) } else { pose }
    }

    /// Picture of the floor with four samples a pixel, a slight brightness gradient, and the photon noise of 10 000 electrons at mid grey.
    fn picture(&self, rays: &[[[f64; 2]; 4]], pose: [f64; 3], random: &mut Random) -> GrayImage {
        // Floor points of the ray straight ahead and of rays one step along either image axis: where a ray meets the floor is affine in the
        // ray.
        let affine: Vec<[[f64; 2]; 3]> = (0..SIZE_PX[1])
            .map(|v| {
                let pose = self.pose_at_row(pose, f64::from(v));
                [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|ray| self.on_floor(ray, pose))
            })
            .collect();
        let mut rays = rays.iter();
        GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
            let [from, right, down] = affine[v as usize];
            let mut grey = 0.0;
            for &[x, y] in rays.next().into_iter().flatten() {
                let off_m = [0, 1].map(|axis| {
                    let at = (from[axis] + x * (right[axis] - from[axis]) + y * (down[axis] - from[axis])) / 0.30;
                    (at - at.round()).abs() * 0.30
                });
                // Each sample is the mean over an area of the floor as large as one pixel.
                let cover = off_m.map(|off| (0.5 - SCALE * (off - 0.002)).clamp(0.0, 1.0));
                grey += 32.0 - 18.0 * cover[0].max(cover[1]);
            }
            let grey = grey * (1.0 + 0.2 * (f64::from(u) / 320.0 - 1.0));
            let electrons = grey * 10_000.0 / 128.0;
            image::Luma([
                ((electrons + random.normal() * electrons.sqrt()) * 128.0 / 10_000.0).round().clamp(0.0, 255.0) as u8,
            ])
        })
    }

    /// Nearest joint of each of the two families to what a raw image point shows, with the distance of the joint's image in pixels, to
    /// first order.
    fn joints(&self, [u, v]: [f64; 2], pose: [f64; 3]) -> [(i64, f64); 2] {
        let place = |u: f64, v: f64| self.on_floor(self.ray([u, v]), self.pose_at_row(pose, v));
        let (here, right, down) = (place(u, v), place(u + 1e-3, v), place(u, v + 1e-3));
        [0, 1].map(|axis| {
            let number = (here[axis] / 0.30).round();
            let per_px = (right[axis] - here[axis]).hypot(down[axis] - here[axis]) / 1e-3;
            (number as i64, (here[axis] - 0.30 * number).abs() / per_px)
        })
    }

    /// Whether a claim is true: whether the points that some joint passes within their bounds are all but the claim's share.
    fn is_true(&self, points_px: &[[f64; 3]], share_wrong: f64, pose: [f64; 3]) -> bool {
        let mut near = std::collections::BTreeMap::<(usize, i64), usize>::new();
        for &[u, v, bound_px] in points_px {
            for (axis, (number, distance_px)) in self.joints([u, v], pose).into_iter().enumerate() {
                *near.entry((axis, number)).or_default() += usize::from(distance_px <= bound_px);
            }
        }
        let needed = (1.0 - share_wrong) * points_px.len() as f64;
        near.values().any(|&count| count as f64 >= needed)
    }
}

/// Pose after some time at constant speeds forward, left and turning.
fn moved(pose: [f64; 3], speed: [f64; 3], time_s: f64) -> [f64; 3] {
    let [forward, left, turning] = speed.map(|speed| speed * time_s);
    let (sin, cos) = (pose[2] + 0.5 * turning).sin_cos();
    [pose[0] + cos * forward - sin * left, pose[1] + sin * forward + cos * left, pose[2] + turning]
}

fn contracted(constraint: &Constraint, mut prior: PoseBox) -> PoseBox {
    constraint.on_pose.contract(&mut prior);
    prior
}

fn random_pose(random: &mut Random) -> ([f64; 3], PoseBox) {
    let pose = [random.between(-3.0, 3.0), random.between(-3.0, 3.0), random.between(-10.0, 10.0)];
    (pose, PoseBox::from(pose.map(|at| Interval::centred(at + random.between(-0.018, 0.018), 0.02))))
}
