//! Draws a run's errors inside the tolerances that its scene declares, each quantity from its own stream.

use localizer::Pose;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::{
    navigation::Planner,
    optics::{Lens, mounts},
    randomness::stream,
    scene::{Calibration, CeilingCamera, Distribution, FloorCamera, Flow, ForwardCamera, Gyro, RangeCamera, Scene},
};

use super::{
    Drawn, DrawnCamera, DrawnFloorCamera, DrawnFlow, DrawnGyro, DrawnMarker, DrawnRangeCamera, GyroCuts, LaidTiles,
    Repeated, draw_within, walls::draw_walls,
};

impl Drawn {
    /// Draws everything that a seed decides before the start.
    pub fn draw(scene: &Scene, seed: u64) -> Drawn {
        let (robot, errors) = (&scene.robot, scene.robot.errors);
        let mut rng = stream(seed, "wheels");
        let mut around = |nominal: f64, share: f64| nominal * (1.0 + draw_within(share, errors, &mut rng));
        let left_m = around(robot.wheel_radius_m, robot.wheel_radius_tolerance);
        let right_m = around(robot.wheel_radius_m, robot.wheel_radius_tolerance);
        let track_m = around(robot.track_m, robot.track_tolerance);
        Drawn {
            start: draw_start(scene, seed),
            wheel_radius_m: [left_m * (1.0 - robot.wheel_wear[0]), right_m * (1.0 - robot.wheel_wear[1])],
            track_m,
            base_clock_s: draw_within(robot.delivery.stamp_tolerance_s, errors, &mut stream(seed, "base.clock")),
            floor_camera: robot.floor_camera.as_ref().map(|camera| {
                let drawn = draw_floor_camera(camera, errors, &mut stream(seed, "floor_camera.mount"));
                let tolerance_px = camera.distortion_tolerance_px;
                let off_px = draw_within(tolerance_px, errors, &mut stream(seed, "floor_camera.distortion"));
                DrawnFloorCamera { distortion: Lens::floor(camera, &drawn).bent_further(off_px), ..drawn }
            }),
            forward_camera: robot.forward_camera.as_ref().map(|camera| {
                let nominal = DrawnCamera::forward(camera);
                let drawn =
                    draw_camera(nominal, &camera.calibration, errors, &mut stream(seed, "forward_camera.mount"));
                let tolerance_px = camera.calibration.distortion_tolerance_px;
                let off_px = draw_within(tolerance_px, errors, &mut stream(seed, "forward_camera.distortion"));
                DrawnCamera { distortion: Lens::forward(camera, &drawn).bent_further(off_px), ..drawn }
            }),
            ceiling_camera: robot.ceiling_camera.as_ref().map(|camera| {
                let nominal = DrawnCamera::ceiling(camera);
                let drawn =
                    draw_camera(nominal, &camera.calibration, errors, &mut stream(seed, "ceiling_camera.mount"));
                let tolerance_px = camera.calibration.distortion_tolerance_px;
                let off_px = draw_within(tolerance_px, errors, &mut stream(seed, "ceiling_camera.distortion"));
                DrawnCamera { distortion: Lens::ceiling(camera, &drawn).bent_further(off_px), ..drawn }
            }),
            range_camera: robot
                .range_camera
                .as_ref()
                .map(|camera| draw_range_camera(camera, errors, &mut stream(seed, "range_camera.mount"))),
            gyro: robot.gyro.as_ref().map(|gyro| draw_gyro(gyro, errors, &mut stream(seed, "gyro.calibration"))),
            flow: robot.flow.as_ref().map(|flow| draw_flow(flow, errors, &mut stream(seed, "flow.mount"))),
            tiles: scene.floor.tiles.as_ref().map(|tiles| LaidTiles::draw(tiles, &scene.room, errors, seed)),
            furniture_turn_deg: draw_furniture(scene, seed),
            walls_turn_deg: draw_walls(scene, seed),
            goals_m: draw_goals(scene, seed),
            markers: DrawnMarker::draw_all(scene, seed),
        }
    }
}

impl DrawnCamera {
    /// The forward camera without any error.
    pub fn forward(camera: &ForwardCamera) -> DrawnCamera {
        let size_px = [camera.width_px, camera.height_px].map(f64::from);
        DrawnCamera {
            body_from_camera: mounts::body_from_forward_camera(camera),
            focal_px: [mounts::forward_focal_px(camera); 2],
            principal_point_px: size_px.map(|size| (size - 1.0) / 2.0),
            distortion: camera.lens.distortion,
        }
    }

    /// The ceiling camera without any error.
    pub fn ceiling(camera: &CeilingCamera) -> DrawnCamera {
        DrawnCamera {
            body_from_camera: mounts::body_from_ceiling_camera(camera),
            focal_px: camera.focal_px,
            principal_point_px: camera.principal_point_px,
            distortion: camera.lens.distortion,
        }
    }
}

impl Scene {
    /// The scene with its walls and its furniture as they truly stand, for all that feels and sees it. Its keys, the map and the localizer are told nothing.
    pub fn as_built(&self, drawn: &Drawn) -> Scene {
        let mut built = self.clone();
        for (piece, turn_deg) in built.furniture.iter_mut().zip(&drawn.furniture_turn_deg) {
            piece.rotation_deg += turn_deg;
        }
        built.turn_walls(drawn.walls_turn_deg);
        built
    }
}

fn draw_furniture(scene: &Scene, seed: u64) -> Vec<f64> {
    let (tolerance_deg, errors) = (scene.building.furniture_tolerance_deg, scene.robot.errors);
    // In a drift all pieces are askew alike, so that they agree with each other.
    let mut turn = Repeated::new(errors, stream(seed, "furniture"));
    scene.furniture.iter().map(|_| turn.one_way(tolerance_deg)).collect()
}

fn draw_start(scene: &Scene, seed: u64) -> Pose {
    let (nominal, start, errors) = (scene.nominal_start(), &scene.start, scene.robot.errors);
    let mut rng = stream(seed, "start");
    Pose {
        x_m: nominal.x_m + draw_within(start.tolerance_m, errors, &mut rng),
        y_m: nominal.y_m + draw_within(start.tolerance_m, errors, &mut rng),
        heading_rad: nominal.heading_rad + draw_within(start.tolerance_deg.to_radians(), errors, &mut rng),
    }
}

/// Random goals are at least so far from the one before, or there would be nothing to drive.
const LEAST_LEG_M: f64 = 1.0;

/// Middles of cells that the robot can get to.
fn draw_goals(scene: &Scene, seed: u64) -> Vec<[f64; 2]> {
    let n_goals = scene.navigation.as_ref().map_or(0, |navigation| navigation.random_goals);
    let mut from_m = scene.errands.last().map_or([scene.start.x_m, scene.start.y_m], |errand| [errand.x_m, errand.y_m]);
    if n_goals == 0 {
        return Vec::new();
    }
    let centres_m = Planner::of(scene).reach(from_m).map(|reach| reach.centres_m()).unwrap_or_default();
    let mut rng = stream(seed, "navigation.goals");
    let mut goals_m = Vec::new();
    for _ in 0..n_goals {
        let is_far = |at_m: &&[f64; 2]| (at_m[0] - from_m[0]).hypot(at_m[1] - from_m[1]) >= LEAST_LEG_M;
        let far_m: Vec<&[f64; 2]> = centres_m.iter().filter(is_far).collect();
        // Where the room is too small for that, any place is far enough.
        let Some(goal_m) = far_m.choose(&mut rng).copied().or_else(|| centres_m.choose(&mut rng)) else { break };
        goals_m.push(*goal_m);
        from_m = *goal_m;
    }
    goals_m
}

fn draw_floor_camera(camera: &FloorCamera, errors: Distribution, rng: &mut ChaCha8Rng) -> DrawnFloorCamera {
    let position_m = [camera.forward_m, camera.left_m]
        .map(|nominal_m| nominal_m + draw_within(camera.position_tolerance_m, errors, rng));
    let nominal_px_per_m = f64::from(camera.width_px) / camera.footprint_width_m;
    let px_per_m = nominal_px_per_m * (1.0 + draw_within(camera.scale_tolerance, errors, rng));
    let tilt_rad = draw_tilt(camera.tilt_tolerance_deg, errors, rng);
    DrawnFloorCamera {
        position_m,
        height_m: camera.height_m,
        focal_px: px_per_m * camera.height_m,
        yaw_rad: draw_within(camera.yaw_tolerance_deg.to_radians(), errors, rng),
        tilt_rad,
        distortion: camera.lens.distortion,
    }
}

/// The tolerance bounds the angle in any direction, so an angle and a direction are drawn.
fn draw_tilt(tolerance_deg: f64, errors: Distribution, rng: &mut ChaCha8Rng) -> [f64; 2] {
    let tilt_rad = draw_within(tolerance_deg.to_radians(), errors, rng);
    let direction_rad = draw_within(std::f64::consts::FRAC_PI_2, Distribution::Uniform, rng);
    let (sin, cos) = direction_rad.sin_cos();
    [tilt_rad * cos, tilt_rad * sin]
}

fn draw_range_camera(camera: &RangeCamera, errors: Distribution, rng: &mut ChaCha8Rng) -> DrawnRangeCamera {
    let mut around = |nominal: f64, tolerance: f64| nominal + draw_within(tolerance, errors, rng);
    let position_m = [camera.forward_m, camera.left_m].map(|nominal_m| around(nominal_m, camera.position_tolerance_m));
    let yaw_rad = around(camera.yaw_deg.to_radians(), camera.yaw_tolerance_deg.to_radians());
    let focal_px = around(camera.focal_px, camera.focal_px * camera.focal_tolerance);
    let baseline_m = around(camera.baseline_m, camera.baseline_m * camera.baseline_tolerance);
    let tilt_rad = draw_tilt(camera.tilt_tolerance_deg, errors, rng);
    DrawnRangeCamera { position_m, yaw_rad, tilt_rad, focal_px, baseline_m }
}

fn draw_gyro(gyro: &Gyro, errors: Distribution, rng: &mut ChaCha8Rng) -> DrawnGyro {
    DrawnGyro {
        bias_rad_per_s: draw_within(gyro.bias_tolerance_deg_per_s.to_radians(), errors, rng),
        scale: 1.0 + draw_within(gyro.scale_tolerance, errors, rng),
        cuts: GyroCuts::default(),
    }
}

fn draw_flow(flow: &Flow, errors: Distribution, rng: &mut ChaCha8Rng) -> DrawnFlow {
    let mut around = |nominal: f64, tolerance: f64| nominal + draw_within(tolerance, errors, rng);
    DrawnFlow {
        position_m: [flow.forward_m, flow.left_m].map(|nominal_m| around(nominal_m, flow.position_tolerance_m)),
        yaw_rad: around(0.0, flow.yaw_tolerance_deg.to_radians()),
        scale: around(1.0, flow.calibration_tolerance),
    }
}

fn draw_camera(
    nominal: DrawnCamera,
    calibration: &Calibration,
    errors: Distribution,
    rng: &mut ChaCha8Rng,
) -> DrawnCamera {
    let shift_m = [0; 3].map(|_| draw_within(calibration.position_tolerance_m, errors, rng));
    let tilt_rad = draw_tilt(calibration.angle_tolerance_deg, errors, rng);
    let yaw_rad = draw_within(calibration.angle_tolerance_deg.to_radians(), errors, rng);
    let scale = 1.0 + draw_within(calibration.focal_tolerance, errors, rng);
    let tolerance_px = calibration.principal_point_tolerance_px;
    DrawnCamera {
        body_from_camera: mounts::misplaced(nominal.body_from_camera, tilt_rad, yaw_rad, shift_m),
        focal_px: nominal.focal_px.map(|focal_px| focal_px * scale),
        principal_point_px: nominal.principal_point_px.map(|at_px| at_px + draw_within(tolerance_px, errors, rng)),
        ..nominal
    }
}
