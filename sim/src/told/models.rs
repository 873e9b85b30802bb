//! What the scene tells the localizer: nominal values with their declared bounds, never a drawn value.

use interval::Interval;
use localizer::{
    Map, Pose, PoseBox, RobotModel,
    map::TileGrid,
    reading::Camera,
    robot::{
        BodyModel, CeilingCameraModel, FloorCameraModel, FlowModel, ForwardCameraModel, GyroModel, RangeCameraModel,
        Reach, WheelModel,
    },
};

use crate::{
    optics::{AutoExposure, mounts::forward_focal_px},
    scene::{CeilingCamera, FloorCamera, Flow, ForwardCamera, Gyro, RangeCamera, Scene, Start, Station, Tiles},
    sensors::range_camera::FIRST_S,
    world::STEP_S,
};

/// The contact with a wall gives way by less than a millimetre.
const GIVES_WAY_M: f64 = 0.001;

impl Scene {
    /// The building as surveyed.
    pub fn map(&self) -> Map {
        let room_m = self.room_hull_m();
        Map {
            room_m,
            tiles: self.floor.tiles.as_ref().map(|tiles| tile_grid(tiles, self)),
            markers: self.markers.as_ref().map(|markers| markers.map(self)),
            wall_directions_rad: self.wall_directions_rad(),
        }
    }

    /// The robot as it knows itself.
    pub fn robot_model(&self) -> RobotModel {
        let (robot, bounds) = (&self.robot, &self.bounds);
        let radius_m = relative(robot.wheel_radius_m, robot.wheel_radius_tolerance);
        let mut model = RobotModel {
            wheels: WheelModel {
                radius_m: [radius_m, radius_m],
                track_m: relative(robot.track_m, robot.track_tolerance),
                ticks_per_turn: f64::from(robot.encoders.ticks_per_turn),
                slip_ratio: bounds.slip_ratio,
                slip_floor_m: bounds.slip_floor_m,
                side_slip_ratio: bounds.side_slip_ratio,
                side_slip_floor_m: bounds.side_slip_floor_m,
                slip_window_s: bounds.slip_window_s,
            },
            reach: Reach {
                speed_m_per_s: bounds.reach_speed_m_per_s,
                turn_rate_rad_per_s: bounds.reach_turn_rate_rad_per_s,
                acceleration_m_per_s2: bounds.reach_acceleration_m_per_s2,
            },
            body: BodyModel {
                tilt_rad: bounds.body_tilt_deg.to_radians(),
                heave_m: bounds.body_heave_m,
                clearance_m: robot.body_radius_m - GIVES_WAY_M,
            },
            floor_camera: robot.floor_camera.as_ref().map(floor_camera_model),
            forward_camera: robot.forward_camera.as_ref().map(forward_camera_model),
            gyro: robot.gyro.as_ref().map(gyro_model),
            flow: robot.flow.as_ref().map(flow_model),
            ceiling_camera: robot.ceiling_camera.as_ref().map(ceiling_camera_model),
            range_camera: robot.range_camera.as_ref().map(range_camera_model),
        };
        // The localizer reckons in the base's clock, against which the stamps of cameras are off by so much more.
        let base_s = robot.delivery.stamp_tolerance_s;
        model.floor_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.forward_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.ceiling_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.range_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model
    }

    /// What the room takes up however its walls stand within their tolerance.
    pub(crate) fn room_hull_m(&self) -> [Interval; 2] {
        let most_deg = if self.draws_walls() { self.localizer.wall_directions().tolerance_deg } else { 0.0 };
        let (plan, beyond_m) = (self.plan(), self.plan().beyond_m(most_deg.to_radians()));
        [0, 1].map(|axis| Interval::new(-beyond_m[axis], plan.size_m[axis] + beyond_m[axis]))
    }

    /// How far apart two places of the robot's origin may be along x and along y: what the walls leave to its body.
    pub(crate) fn left_to_origin_m(&self) -> [f64; 2] {
        let keep_m = self.robot.body_radius_m - GIVES_WAY_M;
        self.room_hull_m().map(|range| range.width() - 2.0 * keep_m)
    }

    fn wall_directions_rad(&self) -> Vec<Interval> {
        let setup = self.localizer.wall_directions();
        let tolerance_rad = setup.tolerance_deg.to_radians() + setup.askew_deg.to_radians();
        let directions_deg = self.mapped_wall_directions_deg();
        directions_deg.iter().map(|deg| Interval::centred(deg.to_radians(), tolerance_rad)).collect()
    }

    /// The start pose as the scene states it, before its error is drawn.
    pub fn nominal_start(&self) -> Pose {
        Pose { x_m: self.start.x_m, y_m: self.start.y_m, heading_rad: self.start.heading_deg.to_radians() }
    }

    /// The scene with the robot put at a station, for as long as one image takes to arrive.
    pub fn at_station(&self, station: &Station) -> Scene {
        let robot = &self.robot;
        let timings = Camera::ALL.into_iter().filter_map(|camera| robot.camera_timing(camera));
        let image_s = timings.map(|timing| timing.first_arrival_s()).fold(0.0, f64::max);
        let range_s =
            robot.range_camera.as_ref().map_or(0.0, |camera| FIRST_S + camera.latency_s + camera.latency_tolerance_s);
        let arrival_s = image_s.max(range_s);
        let start = Start {
            x_m: station.x_m,
            y_m: station.y_m,
            heading_deg: station.heading_deg,
            tolerance_m: station.tolerance_m.unwrap_or(self.start.tolerance_m),
            tolerance_deg: station.tolerance_deg.unwrap_or(self.start.tolerance_deg),
        };
        // A step more than the arrival, so that the estimate after it is counted too.
        let duration_s = ((arrival_s / 0.01).ceil() + 1.0) * 0.01;
        Scene { start, duration_s, stations: Vec::new(), ..self.clone() }
    }

    /// Simulated time of a run: the drive, or all stations.
    pub fn simulated_s(&self) -> f64 {
        if self.stations.is_empty() {
            return self.duration_s;
        }
        self.stations.iter().map(|station| self.at_station(station).duration_s + 0.01).sum()
    }

    /// The box in which the localizer is told that the robot starts.
    pub fn start_box(&self) -> PoseBox {
        let start = self.nominal_start();
        // The base's clock may have its 0 after the start: a robot that then gathers speed from rest gets a·ε²/2 far.
        let late_s = self.robot.delivery.stamp_tolerance_s;
        let left_m = 0.5 * self.bounds.reach_acceleration_m_per_s2 * late_s * late_s;
        let turned_rad = 2.0 * left_m / (self.robot.track_m * (1.0 - self.robot.track_tolerance));
        PoseBox::from([
            Interval::centred(start.x_m, self.start.tolerance_m + left_m),
            Interval::centred(start.y_m, self.start.tolerance_m + left_m),
            Interval::centred(start.heading_rad, self.start.tolerance_deg.to_radians() + turned_rad),
        ])
    }
}

fn tile_grid(tiles: &Tiles, scene: &Scene) -> TileGrid {
    let shortest_m = scene.room.width_m.min(scene.room.depth_m);
    TileGrid {
        edge_m: [tiles.edge_x_m, tiles.edge_y_m],
        rotation_rad: tiles.rotation_deg.to_radians(),
        phase_m: [tiles.phase_x_m, tiles.phase_y_m],
        joint_width_m: tiles.joint_width_m,
        laying_m: tiles.laying_tolerance_m,
        // A joint whose ends are both within the tolerance turns by at most their difference over the room's shorter side.
        laying_angle_rad: 2.0 * tiles.laying_tolerance_m / shortest_m,
        straightness_m: tiles.corner_tolerance_m,
    }
}

fn floor_camera_model(camera: &FloorCamera) -> FloorCameraModel {
    FloorCameraModel {
        width_px: camera.width_px,
        height_px: camera.height_px,
        pixels_per_m: relative(f64::from(camera.width_px) / camera.footprint_width_m, camera.scale_tolerance),
        height_m: camera.height_m,
        distortion: camera.lens.distortion,
        distortion_px: camera.distortion_tolerance_px,
        row_time_s: camera.lens.row_time_s,
        position_m: [
            Interval::centred(camera.forward_m, camera.position_tolerance_m),
            Interval::centred(camera.left_m, camera.position_tolerance_m),
        ],
        yaw_rad: Interval::centred(0.0, camera.yaw_tolerance_deg.to_radians()),
        tilt_rad: camera.tilt_tolerance_deg.to_radians(),
        stamp_error_s: camera.stamp_tolerance_s,
        q_items: camera.q_items,
    }
}

fn forward_camera_model(camera: &ForwardCamera) -> ForwardCameraModel {
    let calibration = &camera.calibration;
    let angle_rad = calibration.angle_tolerance_deg.to_radians();
    let middle_px = [camera.width_px, camera.height_px].map(|size| (f64::from(size) - 1.0) / 2.0);
    ForwardCameraModel {
        focal_px: relative(forward_focal_px(camera), calibration.focal_tolerance),
        principal_point_px: middle_px.map(|at_px| Interval::centred(at_px, calibration.principal_point_tolerance_px)),
        distortion: camera.lens.distortion,
        distortion_px: calibration.distortion_tolerance_px,
        tilt_up_rad: camera.tilt_up_deg.to_radians(),
        yaw_rad: Interval::centred(camera.yaw_deg.to_radians(), angle_rad),
        tilt_error_rad: angle_rad,
        stamp_error_s: camera.stamp_tolerance_s,
    }
}

fn ceiling_camera_model(camera: &CeilingCamera) -> CeilingCameraModel {
    let (calibration, sensor) = (&camera.calibration, camera.sensor_model());
    let angle_rad = calibration.angle_tolerance_deg.to_radians();
    let place = |nominal_m: f64| Interval::centred(nominal_m, calibration.position_tolerance_m);
    // Fixed or not, no image has more gain than the greatest; a fixed one has the least.
    let gain = AutoExposure::new(&sensor).greatest_gain_levels_per_electron();
    CeilingCameraModel {
        width_px: camera.width_px,
        height_px: camera.height_px,
        focal_px: camera.focal_px.map(|focal_px| relative(focal_px, calibration.focal_tolerance)),
        centre_px: camera
            .principal_point_px
            .map(|at_px| Interval::centred(at_px, calibration.principal_point_tolerance_px)),
        distortion: camera.lens.distortion,
        distortion_px: calibration.distortion_tolerance_px,
        height_m: place(camera.height_m),
        position_m: [place(camera.forward_m), place(camera.left_m)],
        // The model's image shows the robot's left at its right; half a turn makes that what this camera shows.
        yaw_rad: Interval::centred(std::f64::consts::PI, angle_rad),
        lean_rad: [-camera.lean_forward_deg.to_radians(), -camera.lean_left_deg.to_radians()],
        tilt_rad: angle_rad,
        stamp_error_s: camera.stamp_tolerance_s,
        electrons_per_grey: sensor.bits.levels_per_byte_level() / gain,
        q_items: camera.q_items,
    }
}

fn gyro_model(gyro: &Gyro) -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.0, gyro.bias_tolerance_deg_per_s.to_radians()),
        scale: relative(1.0, gyro.scale_tolerance),
        noise_rad_per_s: gyro.noise_deg_per_s.to_radians(),
        angle_floor_rad: gyro.angle_floor_deg.map_or(f64::INFINITY, f64::to_radians),
        angle_rad_per_s: gyro.angle_deg_per_s.to_radians(),
        bias_wander_rad_per_s2: gyro.bias_wander_deg_per_s2.to_radians(),
        period_s: gyro.period_s,
    }
}

fn flow_model(flow: &Flow) -> FlowModel {
    let place = |nominal_m: f64| Interval::centred(nominal_m, flow.position_tolerance_m);
    FlowModel {
        position_m: [place(flow.forward_m), place(flow.left_m)],
        metres_per_count: Interval::point(1.0) / relative(flow.counts_per_m, flow.calibration_share()),
        // |s − s₀| ≤ v makes |s/s₀ − 1| ≤ v/s₀, at most where s₀ is least.
        scale_change: flow.varying_share() / (1.0 - flow.calibration_share()),
        yaw_rad: Interval::centred(0.0, flow.yaw_tolerance_deg.to_radians()),
        quantisation_counts: 1.0,
        back_and_forth_m: flow.back_and_forth_m,
        period_s: flow.period_s,
    }
}

fn range_camera_model(camera: &RangeCamera) -> RangeCameraModel {
    RangeCameraModel {
        focal_px: relative(camera.focal_px, camera.focal_tolerance),
        baseline_m: relative(camera.baseline_m, camera.baseline_tolerance),
        centre_px: camera.centre_px(),
        // A step is twice the greatest error that rounding makes; noise before it adds to that on both sides.
        step_px: [camera.column_step_px, camera.match_step_px].map(|step_px| step_px + 2.0 * camera.column_noise_px),
        position_m: [
            Interval::centred(camera.forward_m, camera.position_tolerance_m),
            Interval::centred(camera.left_m, camera.position_tolerance_m),
        ],
        height_m: camera.height_m,
        yaw_rad: Interval::centred(camera.yaw_deg.to_radians(), camera.yaw_tolerance_deg.to_radians()),
        tilt_rad: camera.tilt_tolerance_deg.to_radians(),
        height_span_m: camera.height_span_m,
        stamp_error_s: camera.stamp_tolerance_s,
        latency_s: Interval::centred(camera.latency_s, camera.latency_tolerance_s)
            .intersect(Interval::new(0.0, f64::INFINITY)),
        // It measures at the first physics step after each period.
        period_s: camera.period_s - STEP_S,
        q_items: camera.q_items,
        wrong_spacing: camera.wrong_spacing,
    }
}

/// `nominal·(1 ± share)`.
fn relative(nominal: f64, share: f64) -> Interval {
    Interval::centred(nominal, nominal.abs() * share)
}
