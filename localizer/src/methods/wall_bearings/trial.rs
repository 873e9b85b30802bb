//! Images of rooms that are made here, by a projection of their own, against what the method leaves of boxes around the true pose.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::*;
use crate::{
    graph::trial::{self, Draw, rounds},
    method::Window,
    motion::Motion,
    robot::{BodyModel, Reach},
};

/// Nominal mount of the camera: forward, left, up, and upward tilt.
const MOUNT_M: [f64; 3] = [0.12, -0.05, 0.25];
const TILT_UP_RAD: f64 = 0.15;
const DISTORTION: [f64; 5] = [-0.08, 0.02, 0.001, -0.001, 0.0];
const SIZE_PX: [f64; 2] = [640.0, 480.0];
const HALF_FIELD_RAD: f64 = 0.6;

/// The corners of a rectangle, turned about its middle, counter-clockwise.
fn corners(middle: [f64; 2], size: [f64; 2], turn_rad: f64) -> Vec<[f64; 2]> {
    let (sin, cos) = turn_rad.sin_cos();
    let corner = |[x, y]: [f64; 2]| {
        let (x, y) = (0.5 * x * size[0], 0.5 * y * size[1]);
        [middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y]
    };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner).to_vec()
}

/// A camera on a robot in a room with two free walls and upright things that are on no map, with all errors at an end of their bound or within it.
struct Trial {
    robot: RobotModel,
    camera: ForwardCameraModel,
    walls: WallMap,
    /// For each upright edge where it is on the map and where it truly stands; `None` for a thing that is on no map.
    uprights: Vec<(Option<[f64; 2]>, [f64; 2])>,
    /// Pose at each image's stamp.
    poses: Vec<[f64; 3]>,
    /// For each image its lines, each with the number of the upright edge that it shows.
    images: Vec<Vec<(EdgeLine, usize)>>,
    moved_m: f64,
    turned_rad: f64,
}

/// True values of the camera's mount and lens.
struct True {
    at_m: [f64; 3],
    yaw_rad: f64,
    tilt: Rotation3<f64>,
    focal_px: f64,
    centre_px: [f64; 2],
}

/// A lean of up to `most_rad` about a level axis, of that size three times in four.
fn lean(draw: &mut Draw, most_rad: f64) -> Rotation3<f64> {
    trial::tilt(draw, most_rad.max(1e-9)).0
}

/// The pixel at which a lens shows a point of the camera's frame (right, down, ahead).
fn pixel(at: Vector3<f64>, lens: &True) -> [f64; 2] {
    let [k1, k2, p1, p2, k3] = DISTORTION;
    let (x, y) = (at.x / at.z, at.y / at.z);
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let bent = [
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    ];
    [0, 1].map(|axis| lens.centre_px[axis] + lens.focal_px * bent[axis])
}

impl Trial {
    fn new(draw: &mut Draw, n_things: usize, n_images: usize) -> Trial {
        let size_m = [draw.between(3.0, 7.0), draw.between(3.0, 7.0)];
        let middle = [draw.between(-5.0, 5.0), draw.between(-5.0, 5.0)];
        let placement_m = draw.size(1e-6, 0.02);
        let room = corners(middle, size_m, draw.between(-3.0, 3.0));
        // Two free walls stand before the robot, in any direction.
        let ahead_rad = draw.between(-3.2, 3.2);
        let before = |along_m: f64, across_m: f64| {
            let (sin, cos) = ahead_rad.sin_cos();
            [middle[0] + cos * along_m - sin * across_m, middle[1] + sin * along_m + cos * across_m]
        };
        let free_m = before(draw.between(1.0, 1.5), draw.between(-0.6, 0.6));
        let free = corners(free_m, [0.1, draw.between(0.3, 1.0)], ahead_rad + draw.between(-0.3, 0.3));
        let screen_m = before(draw.between(1.8, 2.6), draw.between(-1.2, 1.2));
        let screen = corners(screen_m, [0.08, draw.between(0.3, 1.2)], ahead_rad + draw.between(-0.3, 0.3));
        let side = |of: &[[f64; 2]], index: usize| [of[index], of[(index + 1) % 4]];
        let mut walls: Vec<Wall> = (0..4).map(|index| Wall { ends_m: side(&room, index) }).collect();
        walls.extend((0..4).map(|index| side(&free, index)).map(|[from, to]| Wall { ends_m: [to, from] }));
        walls.extend((0..4).map(|index| side(&screen, index)).map(|[from, to]| Wall { ends_m: [to, from] }));
        let mut uprights: Vec<(Option<[f64; 2]>, [f64; 2])> = Vec::new();
        // Inner corners of rooms are not used, so that the image has only those of free walls.
        for mapped in free.iter().chain(&screen) {
            let (far_m, to_rad) = (placement_m * draw.between(0.7, 1.0), draw.between(-3.2, 3.2));
            uprights.push((Some(*mapped), [mapped[0] + far_m * to_rad.cos(), mapped[1] + far_m * to_rad.sin()]));
        }
        for _ in 0..n_things {
            // Some things stand beside an edge of the map, where they are taken for it.
            let near = [&free, &screen][(draw.unit() * 1.99) as usize][(draw.unit() * 3.99) as usize];
            let half_m = if draw.unit() < 0.5 { 0.2 } else { 2.0 };
            uprights.push((None, [0, 1].map(|axis| near[axis] + draw.between(-half_m, half_m))));
        }
        let body_rad = draw.size(1e-6, 0.02);
        let robot = RobotModel {
            reach: Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 2.0, acceleration_m_per_s2: 1.0 },
            body: BodyModel { tilt_rad: body_rad, heave_m: 0.0, clearance_m: 0.0 },
            ..trial::robot()
        };
        let (position_m, height_m) = (draw.size(1e-6, 0.005), 0.002);
        let around = |nominal: f64, half: f64| Interval::centred(nominal, half);
        let camera = ForwardCameraModel {
            focal_px: around(417.0, draw.size(1e-3, 1.0)),
            principal_point_px: [around(319.5, draw.size(1e-3, 1.0)), around(239.5, draw.size(1e-3, 1.0))],
            distortion: DISTORTION,
            distortion_px: draw.size(1e-3, 0.3),
            tilt_up_rad: TILT_UP_RAD,
            yaw_rad: around(draw.between(-0.3, 0.3), draw.size(1e-6, 0.01)),
            tilt_error_rad: draw.size(1e-6, 0.01),
            stamp_error_s: draw.size(1e-6, 0.005),
            position_m: [around(MOUNT_M[0], position_m), around(MOUNT_M[1], position_m)],
            height_m: around(MOUNT_M[2], height_m),
            height_px: 480,
            row_time_s: 0.0,
        };
        let lens = True {
            at_m: [draw.within(camera.position_m[0]), draw.within(camera.position_m[1]), draw.within(camera.height_m)],
            yaw_rad: draw.within(camera.yaw_rad),
            tilt: lean(draw, camera.tilt_error_rad),
            focal_px: draw.within(camera.focal_px),
            centre_px: camera.principal_point_px.map(|side| draw.within(side)),
        };
        let [x, y] = before(draw.between(-1.2, 0.0), draw.between(-0.5, 0.5));
        let start = [x, y, ahead_rad + draw.between(-0.4, 0.4)];
        let step = [draw.between(-0.05, 0.08), draw.between(-0.02, 0.02), draw.between(-0.08, 0.08)];
        let poses: Vec<[f64; 3]> =
            (0..n_images).map(|index| [0, 1, 2].map(|axis| start[axis] + index as f64 * step[axis])).collect();
        let mut made = Trial {
            robot,
            camera,
            walls: WallMap { walls, placement_m },
            uprights,
            poses,
            images: Vec::new(),
            moved_m: draw.size(1e-6, 0.003),
            turned_rad: draw.size(1e-6, 0.002),
        };
        made.images = (0..n_images).map(|index| made.image(draw, index, &lens)).collect();
        made
    }

    /// The lines of one image. Walls hide nothing here: an edge that the map has behind a wall is in view as well, as a false one.
    fn image(&self, draw: &mut Draw, index: usize, lens: &True) -> Vec<(EdgeLine, usize)> {
        let late_s = draw.within(Interval::centred(0.0, self.camera.stamp_error_s));
        let [x, y, heading_rad] = self.poses[index];
        let (heading_rad, course_rad) = (heading_rad + 2.0 * late_s, draw.between(-3.2, 3.2));
        let at = Vector3::new(x + late_s * course_rad.cos(), y + late_s * course_rad.sin(), 0.0);
        // Roll and pitch whose product leans by the declared angle.
        let leant = lean(draw, self.robot.body.tilt_rad);
        let forward = leant * Vector3::x();
        let untwisted = Rotation3::from_axis_angle(&Vector3::z_axis(), -forward.y.atan2(forward.x)) * leant;
        let body = Rotation3::from_axis_angle(&Vector3::z_axis(), heading_rad) * untwisted;
        let level = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
        let nominal = level * Rotation3::from_axis_angle(&Vector3::x_axis(), TILT_UP_RAD);
        let mount = Rotation3::from_axis_angle(&Vector3::z_axis(), lens.yaw_rad) * lens.tilt * nominal;
        let eye = at + body * Vector3::from(lens.at_m);
        let camera = body * mount;
        let shown = |(number, (_, [x, y])): (usize, &(Option<[f64; 2]>, [f64; 2]))| {
            let place = |high_m: f64| camera.inverse() * (Vector3::new(*x, *y, high_m) - eye);
            // From somewhere near the floor, or from above a piece of furniture, up to somewhere below the ceiling.
            let (low_m, high_m) = (draw.between(0.1, 0.7), draw.between(1.0, 1.6));
            let bound_px = draw.size(0.01, 0.4);
            let ends = [place(low_m), place(high_m)];
            if ends.iter().any(|end| end.z < 0.3 || (end.x / end.z).abs() > HALF_FIELD_RAD.tan()) {
                return None;
            }
            let [a, b] = ends.map(|end| pixel(end, lens));
            let is_inside = |at: [f64; 2]| (0..2).all(|axis| (0.0..SIZE_PX[axis]).contains(&at[axis]));
            let length_px = (b[0] - a[0]).hypot(b[1] - a[1]);
            if !is_inside(a) || !is_inside(b) || length_px < 45.0 {
                return None;
            }
            let across = [-(b[1] - a[1]) / length_px, (b[0] - a[0]) / length_px];
            let mut seen = |at: [f64; 2]| {
                let claimed_px = draw.within(Interval::centred(0.0, UPRIGHT_BOUNDS * bound_px));
                let (bent_px, to_rad) = (self.camera.distortion_px, draw.between(-3.2, 3.2));
                [
                    at[0] + claimed_px * across[0] + bent_px * to_rad.cos(),
                    at[1] + claimed_px * across[1] + bent_px * to_rad.sin(),
                ]
            };
            Some((EdgeLine { ends_px: [seen(a), seen(b)], bound_px }, number))
        };
        self.uprights.iter().enumerate().filter_map(shown).collect()
    }

    /// Motion from one pose to another, as a box that holds it.
    fn motion(&self, from: [f64; 3], to: [f64; 3]) -> Motion {
        let (sin, cos) = from[2].sin_cos();
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        Motion::from([
            Interval::centred(cos * x + sin * y, self.moved_m),
            Interval::centred(cos * y - sin * x, self.moved_m),
            Interval::centred(to[2] - from[2], self.turned_rad),
        ])
    }

    /// What the method leaves of the last of the given boxes, one at each image, and the number of false sightings of all images.
    fn left(&self, priors: &[PoseBox], quotas: Quotas) -> (PoseUnion, usize, usize) {
        let setup = Setup { tallest_thing_m: 0.0, quotas };
        let method = WallBearings::new(self.camera, &self.walls, setup, &self.robot);
        let mut window = Window::new(method.n_earlier());
        let (mut n_false, mut n_all) = (0, 0);
        let mut left = PoseUnion::single(priors[priors.len() - 1]);
        for (index, (image, prior)) in self.images.iter().zip(priors).enumerate() {
            let pose_at = |stamp_s: f64| self.poses[stamp_s.round() as usize];
            let motion = |from_s: f64, to_s: f64| Some(self.motion(pose_at(from_s), pose_at(to_s)));
            let earlier = window.carried_to(index as f64, &motion);
            let lines: Vec<EdgeLine> = image.iter().map(|(line, _)| *line).collect();
            let prior = PoseUnion::single(*prior);
            let Some(constraint) = method.constraint(index as f64, &lines, &prior, &earlier) else { continue };
            constraint.shown.iter().for_each(|shown| window.hold(index as f64, shown.clone()));
            for claim in &constraint.claims {
                n_all += 1;
                n_false += usize::from(!self.is_true(claim, image));
            }
            if index + 1 == priors.len() {
                left = prior.contracted(&*constraint.on_pose);
            }
        }
        (left, n_false, n_all)
    }

    /// Whether one of the lines of a claim was made from one of its edges of the map.
    fn is_true(&self, claim: &Claim, image: &[(EdgeLine, usize)]) -> bool {
        let Claim::WallUpright { lines, posts_m } = claim else { panic!("{claim:?}") };
        lines.iter().any(|(ends_px, _)| {
            let seen = image.iter().find(|(line, _)| line.ends_px == *ends_px);
            seen.and_then(|(_, number)| self.uprights[*number].0).is_some_and(|mapped_m| posts_m.contains(&mapped_m))
        })
    }

    /// A box around the true pose at an image, which lies anywhere in it.
    fn around(&self, draw: &mut Draw, index: usize, half: [f64; 3]) -> PoseBox {
        let side = |axis: usize| {
            let off = half[axis] * draw.between(-1.0, 1.0);
            Interval::centred(self.poses[index][axis] + off, half[axis] * (1.0 + 1e-9))
        };
        PoseBox::from([0, 1, 2].map(side))
    }
}

#[test]
fn no_true_pose_is_lost_among_walls_and_things_that_are_on_no_map() {
    let mut draw = Draw::new(20_261_127);
    let (mut n_narrowed, mut n_used, mut n_emptied) = (0, 0, 0);
    for round in 0..rounds(300) {
        let n_images = 2 + round % 11;
        let trial = Trial::new(&mut draw, round % 5, n_images);
        let half = [draw.size(0.005, 0.3), draw.size(0.005, 0.3), draw.size(0.001, 0.06)];
        let priors: Vec<PoseBox> = (0..n_images).map(|index| trial.around(&mut draw, index, half)).collect();
        let domain = priors[n_images - 1];
        let (_, n_false, n_all) = trial.left(&priors, Quotas { held_share: 0.0, held_more: 0 });
        // As many sightings may be wrong as are wrong: told as a number, and as a share.
        let share = n_false as f64 / (n_all as f64).max(1.0);
        let told = [Quotas { held_share: 0.0, held_more: n_false }, Quotas { held_share: share, held_more: 0 }];
        for quotas in told {
            let (left, _, _) = trial.left(&priors, quotas);
            let is_held = left.branches.iter().any(|branch| branch.contains(&trial.poses[n_images - 1]));
            assert!(is_held, "round {round}: {:?} is not in {left:?} of {domain:?}", trial.poses[n_images - 1]);
            let width = |of: &PoseBox| of.width(0) + of.width(1);
            n_used += usize::from(n_all >= FEWEST_HELD);
            n_narrowed += usize::from(width(&left.hull()) < 0.6 * width(&domain));
        }
        if n_false > 0 {
            let (left, _, _) = trial.left(&priors, Quotas { held_share: 0.0, held_more: n_false - 1 });
            n_emptied += usize::from(!left.branches.iter().any(|one| one.contains(&trial.poses[n_images - 1])));
        }
    }
    // Many boxes are narrowed, and one wrong sighting more than declared excludes many a true pose.
    println!("{n_narrowed} of {n_used}, {n_emptied}");
    assert!(4 * n_narrowed > n_used && n_used > rounds(300) / 3 && n_emptied > 10, "{n_narrowed} {n_used} {n_emptied}");
}

#[test]
fn the_camera_is_anywhere_that_mount_lean_and_stamp_allow() {
    let trial = Trial::new(&mut Draw::new(3), 0, 1);
    let camera = ForwardCameraModel {
        stamp_error_s: 0.005,
        position_m: [Interval::new(0.098, 0.102), Interval::new(-0.002, 0.002)],
        height_m: Interval::new(0.24, 0.26),
        ..trial.camera
    };
    let robot = RobotModel { body: BodyModel { tilt_rad: 0.02, ..trial.robot.body }, ..trial.robot.clone() };
    let method = WallBearings::new(camera, &trial.walls, Setup::default(), &robot);
    // By hand: 2 mm for the mount, 0.26 m · sin 0.02 = 5.2 mm for the lean, and 5 mm for the way at 1 m/s within the error of the stamp; the turn by
    // 0.01 rad in that time moves the lever of 0.1 m by 1 mm.
    let [forward, left] = method.eye_m;
    assert!(Interval::new(0.1 - 0.0131, 0.1 + 0.0131).is_subset_of(forward) && forward.width() < 0.028, "{forward}");
    assert!(Interval::new(-0.0131, 0.0131).is_subset_of(left) && left.width() < 0.028, "{left}");
    assert!((method.stamp_turn_rad - 0.01).abs() < 1e-9);
}
