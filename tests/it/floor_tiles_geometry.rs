//! Tests of the step from lines in an image to the pose, with a pinhole camera and tile joints that the tests model for themselves.

use interval::Interval;
use localizer::{
    Map, Method, PoseBox, PoseUnion, RobotModel,
    map::TileGrid,
    method::Context,
    methods::floor_tiles::{Chain, FloorTiles},
    robot::{BodyModel, FloorCameraModel, Reach, WheelModel},
    vision::{FloorLine, FloorLines},
};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::command::rounds;

const HEIGHT_M: f64 = 0.25;
const SCALE: f64 = 640.0 / 0.48;
const TILT_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Declared tilts of the body and of the camera's mount.
#[derive(Clone, Copy)]
struct Tilts {
    body: f64,
    mount: f64,
}

/// The bounds that most of these tests declare on the tilt of the robot's body and of the camera's mount: 0.1° each.
const SMALL: Tilts = Tilts { body: TILT_RAD, mount: TILT_RAD };

/// A true situation of robot, camera and tiles, with every error drawn inside its bound, half of them at the bound.
struct Situation {
    pose: [f64; 3],
    grid: TileGrid,
    world_from_camera: Isometry3<f64>,
    focal_px: f64,
    joint_offset_m: [Vec<f64>; 2],
    tilts: Tilts,
}

fn corner(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 0.5 { [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-1.0..1.0) }
}

fn tile_grid(rng: &mut ChaCha8Rng) -> TileGrid {
    TileGrid {
        edge_m: [0.30, rng.random_range(0.25..0.45)],
        rotation_rad: rng.random_range(-1.0..1.0),
        phase_m: [rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3)],
        joint_width_m: 0.004,
        laying_m: 0.0005,
        laying_angle_rad: 0.0003,
        straightness_m: 0.0,
    }
}

fn robot(tilt_rad: Tilts) -> RobotModel {
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
        body: BodyModel { tilt_rad: tilt_rad.body, heave_m: 0.0001, clearance_m: 0.0 },
        floor_camera: Some(FloorCameraModel {
            width_px: 640,
            height_px: 480,
            pixels_per_m: Interval::centred(SCALE, 0.001 * SCALE),
            height_m: HEIGHT_M,
            distortion: [0.0; 5],
            distortion_px: 0.0,
            row_time_s: 0.0,
            position_m: [Interval::centred(-0.15, 0.0005), Interval::centred(0.03, 0.0005)],
            yaw_rad: Interval::centred(0.0, TILT_RAD),
            tilt_rad: tilt_rad.mount,
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

fn situation(rng: &mut ChaCha8Rng, axis_aligned: bool, tilts: Tilts) -> Situation {
    let grid = tile_grid(rng);
    let quarter = f64::from(rng.random_range(-9..9)) * std::f64::consts::FRAC_PI_2;
    let heading = if axis_aligned {
        grid.rotation_rad + quarter + rng.random_range(-0.02..0.02)
    } else {
        rng.random_range(-20.0..20.0)
    };
    let pose = [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), heading];
    // The body is tilted about a horizontal axis and raised by the heave, at the robot origin.
    let tilted = |rng: &mut ChaCha8Rng, most_rad: f64| {
        let (angle, size) = (rng.random_range(0.0..std::f64::consts::TAU), most_rad * corner(rng));
        UnitQuaternion::from_scaled_axis(Vector3::new(angle.cos(), angle.sin(), 0.0) * size)
    };
    let world_from_body = Isometry3::from_parts(
        Translation3::new(pose[0], pose[1], 0.0001 * corner(rng)),
        with_forward_at(heading, tilted(rng, tilts.body)),
    );
    let position = [-0.15 + 0.0005 * corner(rng), 0.03 + 0.0005 * corner(rng)];
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TILT_RAD * corner(rng));
    // Image right is robot right, image down is robot backward, and the optical axis points down.
    let down = UnitQuaternion::from_rotation_matrix(&Rotation3::from_basis_unchecked(&[
        Vector3::new(0.0, -1.0, 0.0),
        Vector3::new(-1.0, 0.0, 0.0),
        Vector3::new(0.0, 0.0, -1.0),
    ]));
    let body_from_camera = Isometry3::from_parts(
        Translation3::new(position[0], position[1], HEIGHT_M),
        tilted(rng, tilts.mount) * yaw * down,
    );
    let offsets = |rng: &mut ChaCha8Rng| (0..200).map(|_| 0.0005 * corner(rng)).collect();
    Situation {
        pose,
        joint_offset_m: [offsets(rng), offsets(rng)],
        grid,
        world_from_camera: world_from_body * body_from_camera,
        focal_px: SCALE * HEIGHT_M * (1.0 + 0.001 * corner(rng)),
        tilts,
    }
}

/// A leaning attitude turned about the vertical so that its forward axis, seen from above, has the given heading, as with roll, pitch and yaw.
fn with_forward_at(heading_rad: f64, lean: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let forward = lean * Vector3::x();
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_rad - forward.y.atan2(forward.x)) * lean
}

impl Situation {
    /// Pixel at which the true camera sees a point of the floor; `None` if that pixel lies outside of the image.
    fn project(&self, point: Point3<f64>) -> Option<[f64; 2]> {
        let seen = self.world_from_camera.inverse_transform_point(&point);
        let image = [319.5 + self.focal_px * seen.x / seen.z, 239.5 + self.focal_px * seen.y / seen.z];
        (seen.z > 0.0 && (0.0..=639.0).contains(&image[0]) && (0.0..=479.0).contains(&image[1])).then_some(image)
    }

    /// Every joint in the image, as exact points with a small random error inside their bound.
    fn lines(&self, rng: &mut ChaCha8Rng) -> FloorLines {
        let mut lines = Vec::new();
        let (sin, cos) = self.grid.rotation_rad.sin_cos();
        let here = [self.pose[0] * cos + self.pose[1] * sin, self.pose[1] * cos - self.pose[0] * sin];
        for axis in 0..2 {
            let nearest = ((here[axis] - self.grid.phase_m[axis]) / self.grid.edge_m[axis]).round() as i64;
            for index in nearest - 3..=nearest + 3 {
                let across = self.grid.edge_m[axis] * index as f64
                    + self.grid.phase_m[axis]
                    + self.joint_offset_m[axis][(index + 100) as usize];
                let points: Vec<[f64; 3]> = (-200..=200)
                    .filter_map(|step| {
                        let along = here[1 - axis] + f64::from(step) * 0.004;
                        let (x, y) = if axis == 0 { (across, along) } else { (along, across) };
                        let [u, v] = self.project(Point3::new(x * cos - y * sin, x * sin + y * cos, 0.0))?;
                        Some([u + rng.random_range(-0.2..0.2), v + rng.random_range(-0.2..0.2), 0.3])
                    })
                    .collect();
                if points.len() >= 20 {
                    lines.push(FloorLine { points_px: points, share_wrong: 0.0, family: axis as u8 });
                }
            }
        }
        FloorLines { lines, rejected_px: Vec::new() }
    }

    fn method(&self) -> FloorTiles {
        let room = Interval::new(-10.0, 10.0);
        let map = Map {
            room_m: [room, room],
            tiles: Some(self.grid.clone()),
            markers: None,
            wall_directions_rad: Vec::new(),
            walls: None,
        };
        FloorTiles::new(&map, &robot(self.tilts), Chain::Direct).expect("a tiled map and a floor camera")
    }

    fn prior(&self, rng: &mut ChaCha8Rng, radius: [f64; 3]) -> PoseBox {
        PoseBox::from(
            [0, 1, 2].map(|axis| {
                Interval::centred(self.pose[axis] + radius[axis] * rng.random_range(-0.9..0.9), radius[axis])
            }),
        )
    }
}

#[test]
fn the_heading_relation_and_the_position_relation_keep_the_true_pose() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for trial in 0..rounds(600, 2000) {
        let situation = situation(&mut rng, trial % 2 == 0, SMALL);
        let lines = situation.lines(&mut rng);
        let prior = situation.prior(&mut rng, [0.02, 0.02, 0.02]);
        let Some(constraint) = situation.method().constraint(0.0, lines, &PoseUnion::single(prior)) else { continue };
        let mut contracted = prior;
        constraint.on_pose.contract(&mut contracted);
        assert!(contracted.contains(&situation.pose), "trial {trial}: {contracted:?} misses {:?}", situation.pose);
    }
}

#[test]
fn no_tilt_within_its_bound_loses_the_true_pose_however_great() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let rounds =
        std::env::var("WHEREIN_FLOOR_POSES").ok().and_then(|text| text.parse().ok()).unwrap_or(rounds(80, 300));
    for [body_deg, mount_deg] in [[0.5, 0.5], [1.0, 1.0], [3.0, 3.0], [10.0, 1.0], [30.0, 1.0], [1.0, 10.0]] {
        let tilts = Tilts { body: f64::to_radians(body_deg), mount: f64::to_radians(mount_deg) };
        let (mut n_told, mut widths) = (0, [0.0; 3]);
        for trial in 0..rounds {
            let situation = situation(&mut rng, trial % 2 == 0, tilts);
            let lines = situation.lines(&mut rng);
            let prior = situation.prior(&mut rng, [0.1, 0.1, 0.05]);
            let Some(constraint) = situation.method().constraint(0.0, lines, &PoseUnion::single(prior)) else {
                continue;
            };
            let branches = constraint.on_pose.branches(&prior);
            let holds = branches.iter().any(|branch| branch.contains(&situation.pose));
            assert!(holds, "{body_deg} and {mount_deg} deg, trial {trial}: {branches:?} miss {:?}", situation.pose);
            n_told += 1;
            let hull = PoseUnion { branches }.hull();
            (0..3).for_each(|axis| widths[axis] += hull.width(axis));
        }
        let mean = widths.map(|width| width / f64::from(n_told.max(1)));
        println!("{body_deg} and {mount_deg} deg: {n_told} told, mean widths {mean:?}");
        assert!(n_told > rounds / 3 || body_deg > 3.0 || mount_deg > 3.0, "{body_deg} deg: {n_told}");
    }
}

#[test]
fn a_frame_narrows_heading_to_half_a_degree_and_position_to_millimetres() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut heading, mut place, mut n_fixes) = (0.0, 0.0, 0.0);
    for _ in 0..300 {
        let situation = situation(&mut rng, true, SMALL);
        let lines = situation.lines(&mut rng);
        let families: std::collections::BTreeSet<u8> = lines.lines.iter().map(|line| line.family).collect();
        let prior = situation.prior(&mut rng, [0.02, 0.02, 0.02]);
        let Some(constraint) = situation.method().constraint(0.0, lines, &PoseUnion::single(prior)) else { continue };
        if families.len() < 2 {
            continue;
        }
        let mut contracted = prior;
        constraint.on_pose.contract(&mut contracted);
        heading += contracted[2].width();
        place += 0.5 * (contracted[0].width() + contracted[1].width());
        n_fixes += 1.0;
    }
    assert!(n_fixes > 100.0);
    println!("mean width at a fix: {:.2} mm, {:.3} degrees", 1e3 * place / n_fixes, (heading / n_fixes).to_degrees());
    assert!((heading / n_fixes).to_degrees() < 0.6);
    assert!(place / n_fixes < 0.006);
}

#[test]
fn a_prior_as_wide_as_a_tile_keeps_one_branch_for_each_tile_it_allows() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for trial in 0..200 {
        let situation = situation(&mut rng, false, SMALL);
        let lines = situation.lines(&mut rng);
        let prior = situation.prior(&mut rng, [0.4, 0.4, 0.3]);
        let Some(constraint) = situation.method().constraint(0.0, lines, &PoseUnion::single(prior)) else { continue };
        let branches = PoseUnion { branches: constraint.on_pose.branches(&prior) };
        assert!(
            branches.contains(localizer::Pose {
                x_m: situation.pose[0],
                y_m: situation.pose[1],
                heading_rad: situation.pose[2]
            }),
            "trial {trial}"
        );
        for branch in &branches.branches {
            assert!(branch.is_subset_of(&prior));
            assert!(
                branch[2].width() < 0.05,
                "trial {trial}: a branch spans headings that no joint allows: {branch:?}"
            );
        }
    }
}

#[test]
fn the_method_reads_floor_images_only() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut method = situation(&mut rng, false, SMALL).method();
    let wheels = localizer::Reading::Wheels { measured_s: 0.0, arrived_s: 0.0, ticks: [0, 0] };
    let twist = localizer::motion::Twist::default();
    assert!(method.constrain(&wheels, &Context { twist: &twist, ..Context::at_rest(&PoseUnion::default()) }).is_none());
}
