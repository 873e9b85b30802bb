//! What a process under test is told before its readings: the map and the robot model that every localizer is given, as JSON.
//!
//! Every interval is an array of its least and its greatest value. A bound that is not declared is `null`.

use interval::Interval;
use localizer::{
    Map, RobotModel,
    map::{MarkerMap, PlacedMarker, TileGrid, WallMap},
    methods::{gnss_positions::ReceiverModel, wall_ranges::ScannerModel},
    robot::{
        BodyModel, CeilingCameraModel, FloorCameraModel, FlowModel, ForwardCameraModel, GyroModel, RangeCameraModel,
        Reach, SteeringModel, WheelModel,
    },
};
use serde_json::{Value, json};

use crate::scene::Scene;

use super::messages::{PROTOCOL, Setup};

impl Setup {
    /// What a localizer is told about a scene beforehand.
    pub(super) fn of(scene: &Scene) -> Setup {
        let mut robot = robot(scene.robot_model());
        robot["gnss"] = scene.robot.gnss.as_ref().map_or(Value::Null, |gnss| receiver(gnss.model(scene)));
        robot["scanner"] =
            scene.robot.scanner.as_ref().map_or(Value::Null, |scanner| range_scanner(scanner.model(scene)));
        robot["clock"] = json!({
            "stamp_error_s": scene.robot.delivery.stamp_tolerance_s,
            "devices": ["wheels", "gyro", "flow"],
        });
        if let Some(encoder) = &scene.robot.steering_encoder {
            robot["steering"] = steering_model(encoder.model(&scene.robot.base));
            robot["clock"]["devices"] = json!(["wheels", "gyro", "flow", "steering_encoder"]);
        }
        Setup { protocol: PROTOCOL, map: map(scene.map()), robot }
    }
}

/// A value that is told as JSON.
trait Told {
    fn told(&self) -> Value;
}

macro_rules! tell_as_it_is {
    ($($kind:ty),+) => {
        $(impl Told for $kind {
            fn told(&self) -> Value {
                json!(self)
            }
        })+
    };
}

tell_as_it_is!(f64, u32, usize, [f64; 2], [f64; 5]);

impl Told for Interval {
    fn told(&self) -> Value {
        json!([self.lo(), self.hi()])
    }
}

impl Told for [Interval; 2] {
    fn told(&self) -> Value {
        self.iter().map(Told::told).collect()
    }
}

/// JSON object with all fields of a struct. A field that the struct has and the list has not is an error of compilation.
macro_rules! object {
    ($value:ident: $type:ident { $($field:ident),+ }) => {{
        let $type { $($field),+ } = $value;
        json!({ $((stringify!($field)): $field.told()),+ })
    }};
}

fn map(map: Map) -> Value {
    let Map { room_m, tiles, markers, wall_directions_rad, walls } = map;
    json!({
        "room_m": room_m.told(),
        "tiles": tiles.map(tile_grid),
        "markers": markers.map(marker_map),
        "wall_directions_rad": wall_directions_rad.iter().map(Told::told).collect::<Value>(),
        "walls": walls.map(wall_map),
    })
}

fn wall_map(map: WallMap) -> Value {
    let WallMap { walls, placement_m } = map;
    let ends_m: Vec<[[f64; 2]; 2]> = walls.into_iter().map(|wall| wall.ends_m).collect();
    json!({ "ends_m": ends_m, "placement_m": placement_m })
}

fn tile_grid(tiles: TileGrid) -> Value {
    object!(tiles: TileGrid {
        edge_m, rotation_rad, phase_m, joint_width_m, laying_m, laying_angle_rad, straightness_m
    })
}

fn marker_map(map: MarkerMap) -> Value {
    let MarkerMap { coding, markers, placement_m, rotation_tolerance_rad, print_m } = map;
    let identities: Vec<u16> = coding.identities().iter().map(|id| id.0).collect();
    json!({
        "identities": identities,
        "placed": markers.into_iter().map(placed_marker).collect::<Value>(),
        "placement_m": placement_m,
        "rotation_tolerance_rad": rotation_tolerance_rad,
        "print_m": print_m,
    })
}

fn placed_marker(marker: PlacedMarker) -> Value {
    let PlacedMarker { id, centre_m, rotation_rad, height_m } = marker;
    json!({ "id": id.0, "centre_m": centre_m, "rotation_rad": rotation_rad, "height_m": height_m.told() })
}

fn robot(model: RobotModel) -> Value {
    let RobotModel {
        wheels,
        reach,
        body,
        floor_camera,
        forward_camera,
        gyro,
        flow,
        ceiling_camera,
        range_camera,
        steering: _,
    } = model;
    json!({
        "wheels": wheel_model(wheels),
        "reach": reach_model(reach),
        "body": body_model(body),
        "floor_camera": floor_camera.map(floor_camera_model),
        "forward_camera": forward_camera.map(forward_camera_model),
        "ceiling_camera": ceiling_camera.map(ceiling_camera_model),
        "gyro": gyro.map(gyro_model),
        "flow": flow.map(flow_model),
        "range_camera": range_camera.map(range_camera_model),
    })
}

fn wheel_model(wheels: WheelModel) -> Value {
    object!(wheels: WheelModel {
        radius_m, track_m, ticks_per_turn, slip_ratio, slip_floor_m, side_slip_ratio, side_slip_floor_m,
        slip_window_s
    })
}

fn reach_model(reach: Reach) -> Value {
    object!(reach: Reach { speed_m_per_s, turn_rate_rad_per_s, acceleration_m_per_s2 })
}

fn body_model(body: BodyModel) -> Value {
    object!(body: BodyModel { tilt_rad, heave_m, clearance_m })
}

fn floor_camera_model(camera: FloorCameraModel) -> Value {
    object!(camera: FloorCameraModel {
        width_px, height_px, pixels_per_m, height_m, distortion, distortion_px, row_time_s, position_m, yaw_rad,
        tilt_rad, stamp_error_s, q_items
    })
}

fn forward_camera_model(camera: ForwardCameraModel) -> Value {
    object!(camera: ForwardCameraModel {
        focal_px, principal_point_px, distortion, distortion_px, tilt_up_rad, yaw_rad, tilt_error_rad, stamp_error_s,
        position_m, height_m, height_px, row_time_s
    })
}

fn ceiling_camera_model(camera: CeilingCameraModel) -> Value {
    object!(camera: CeilingCameraModel {
        width_px, height_px, focal_px, centre_px, distortion, distortion_px, height_m, position_m, yaw_rad,
        lean_rad, tilt_rad, stamp_error_s, electrons_per_grey, row_time_s, q_items
    })
}

fn gyro_model(gyro: GyroModel) -> Value {
    object!(gyro: GyroModel {
        bias_rad_per_s, scale, noise_rad_per_s, angle_floor_rad, angle_rad_per_s, bias_wander_rad_per_s2, period_s
    })
}

fn flow_model(flow: FlowModel) -> Value {
    object!(flow: FlowModel {
        position_m, metres_per_count, scale_change, yaw_rad, quantisation_counts, back_and_forth_m, period_s
    })
}

fn steering_model(steering: SteeringModel) -> Value {
    object!(steering: SteeringModel {
        wheelbase_m, rad_per_tick, zero_rad, scale, rate_rad_per_s, slip_share, slip_rad_per_m,
        slip_floor_rad
    })
}

fn range_camera_model(camera: RangeCameraModel) -> Value {
    object!(camera: RangeCameraModel {
        focal_px, baseline_m, centre_px, step_px, position_m, height_m, yaw_rad, tilt_rad, height_span_m,
        stamp_error_s, latency_s, period_s, q_items, wrong_spacing
    })
}

fn range_scanner(scanner: ScannerModel) -> Value {
    object!(scanner: ScannerModel { position_m, height_m, yaw_rad, tilt_rad, range_error_m, stamp_error_s })
}

fn receiver(receiver: ReceiverModel) -> Value {
    object!(receiver: ReceiverModel { position_m, height_m, fixed_m, floating_m, stamp_error_s })
}
