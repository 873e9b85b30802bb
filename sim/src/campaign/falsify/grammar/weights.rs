//! How often random scenes state each key, and from which range its value is drawn where the schema allows more than a robot can drive with.
//!
//! A listed path applies to every key whose full path ends with it; where several listed paths do so, the longest counts.

use super::without_indices;

/// Returns the probability that a random scene states a key; none when the key is not listed, so that a default for keys of its type applies.
pub(super) fn chance(path: &str) -> Option<f64> {
    found(&CHANCES, path)
}

/// Returns the range from which a key's value is drawn; none when the range of the schema is suitable as it is.
pub(super) fn range(path: &str) -> Option<[f64; 2]> {
    found(&RANGES, path)
}

/// Returns the least and the greatest number of items that a list in a random scene has.
pub(super) fn count(path: &str) -> [i64; 2] {
    found(&COUNTS, path).unwrap_or([1, 3])
}

fn found<T: Copy>(listed: &[(&str, T)], path: &str) -> Option<T> {
    let path = without_indices(path);
    let is_ending =
        |ending: &str| path.strip_suffix(ending).is_some_and(|before| before.is_empty() || before.ends_with('.'));
    listed
        .iter()
        .filter(|(ending, _)| is_ending(ending))
        .max_by_key(|(ending, _)| ending.len())
        .map(|(_, value)| *value)
}

/// Probabilities with which random scenes state their keys. A probability of 0 is for keys that the module `settled` fills in afterwards, that the
/// localizer does not read, or that name a file that does not exist.
const CHANCES: [(&str, f64); 55] = [
    ("description", 0.0),
    ("expect", 0.0),
    ("log", 0.0),
    // Rooms under the sky have neither lamps nor a camera that looks up or down.
    ("outdoors", 0.0),
    ("building.facade", 0.0),
    ("navigation.map", 0.0),
    ("localizer.mapped_landmarks.map", 0.0),
    ("duration_s", 0.0),
    ("room", 0.0),
    ("building.room", 0.1),
    // A room is a rectangle, for which all of these are needed, unless `far_room` makes it a polygon.
    ("building.room.x_m", 1.0),
    ("building.room.y_m", 1.0),
    ("building.room.width_m", 1.0),
    ("building.room.depth_m", 1.0),
    ("building.room.corners_m", 0.0),
    ("markers.layout.margin_px", 0.5),
    ("start", 1.0),
    ("route", 1.0),
    ("route.waypoint", 1.0),
    ("navigation", 0.5),
    ("errand", 1.0),
    ("station", 1.0),
    ("station_spread", 1.0),
    ("robot", 1.0),
    ("robot.preset", 0.5),
    ("robot.errors", 0.6),
    ("robot.base", 1.0),
    ("robot.base.differential", 1.0),
    ("robot.base.ackermann", 1.0),
    ("robot.floor_camera", 1.0),
    ("robot.forward_camera", 1.0),
    ("robot.ceiling_camera", 1.0),
    ("robot.range_camera", 1.0),
    ("robot.point_camera", 1.0),
    ("robot.gyro", 1.0),
    ("robot.flow", 1.0),
    ("robot.scanner", 0.5),
    // Worn wheels are rare: a wheel worn beyond its tolerance exceeds a declared bound from the first second on, so that the run shows nothing more.
    ("robot.base.wheel_wear", 0.02),
    ("floor.tiles.misplaced", 0.03),
    ("markers.marker", 1.0),
    ("markers.marker.misplaced_m", 0.02),
    ("markers.marker.on_map", 0.05),
    ("markers.marker.pasted", 0.05),
    ("markers.marker.covered_share", 0.1),
    ("markers.marker.mirrored", 0.02),
    ("markers.marker.extra_dots", 0.0),
    ("markers.marker.missing_dots", 0.0),
    ("landmark", 1.0),
    ("floor.region", 0.25),
    ("furniture", 0.3),
    ("event", 0.25),
    ("localizer", 1.0),
    ("localizer.methods", 1.0),
    ("localizer.wall_directions", 1.0),
    ("localizer.mapped_landmarks", 0.7),
];

/// Ranges from which values of keys are drawn, narrower than those of the schema: beyond them a robot tips over, stands still, or sees nothing, and
/// every run is the same.
const RANGES: [(&str, [f64; 2]); 141] = [
    ("start.tolerance_m", [0.0, 0.5]),
    ("start.tolerance_deg", [0.0, 20.0]),
    ("station.tolerance_m", [0.0, 0.3]),
    ("station.tolerance_deg", [0.0, 20.0]),
    ("station_spread.count", [1.0, 6.0]),
    ("station_spread.tolerance_m", [0.0, 0.3]),
    ("station_spread.tolerance_deg", [0.0, 20.0]),
    ("route.begins_s", [0.0, 2.0]),
    ("pause_s", [0.0, 2.0]),
    ("speed_m_per_s", [0.05, 0.6]),
    ("errand.tolerance_m", [0.02, 0.5]),
    ("navigation.random_goals", [0.0, 3.0]),
    ("navigation.margin_m", [0.0, 0.15]),
    ("navigation.tolerance_m", [0.02, 0.3]),
    ("navigation.patience_s", [0.2, 5.0]),
    ("navigation.give_up_s", [1.0, 60.0]),
    ("robot.mass_kg", [2.0, 30.0]),
    ("robot.body_radius_m", [0.1, 0.3]),
    ("robot.base.wheel_radius_m", [0.025, 0.12]),
    ("robot.base.wheel_radius_tolerance", [0.0, 0.02]),
    ("robot.base.track_m", [0.15, 0.45]),
    ("robot.base.track_tolerance", [0.0, 0.03]),
    ("robot.base.wheel_wear", [0.0, 0.02]),
    ("robot.base.differential.caster_stiffness", [0.1, 1.0]),
    ("robot.base.ackermann.wheelbase_m", [0.15, 0.4]),
    ("robot.base.ackermann.front_track_m", [0.15, 0.45]),
    ("robot.base.ackermann.front_share", [0.3, 0.7]),
    ("robot.base.ackermann.max_steering_deg", [15.0, 40.0]),
    ("robot.base.ackermann.steering_rate_deg_per_s", [20.0, 300.0]),
    ("robot.max_speed_m_per_s", [0.1, 0.8]),
    ("robot.max_turn_rate_rad_per_s", [0.3, 2.5]),
    ("robot.max_acceleration_m_per_s2", [0.1, 1.5]),
    ("robot.encoders.ticks_per_turn", [20.0, 200_000.0]),
    ("robot.encoders.period_s", [0.001, 0.4]),
    ("robot.delivery.dropped_share", [0.0, 0.5]),
    ("robot.delivery.duplicated_share", [0.0, 0.5]),
    // Devices are mounted within the robot's body: these are their distances forward and to the left of the robot's origin.
    ("forward_m", [-0.3, 0.3]),
    ("left_m", [-0.3, 0.3]),
    // Camera images are small and their periods long, as half of the computing time of a run goes into them.
    ("width_px", [96.0, 640.0]),
    ("height_px", [96.0, 480.0]),
    ("floor_camera.period_s", [0.05, 1.0]),
    ("forward_camera.period_s", [0.1, 1.0]),
    ("ceiling_camera.period_s", [0.05, 1.0]),
    ("range_camera.period_s", [0.05, 1.0]),
    ("latency_s", [0.0, 0.4]),
    ("latency_tolerance_s", [0.0, 0.3]),
    ("stamp_tolerance_s", [0.0, 0.03]),
    ("floor_camera.height_m", [0.1, 0.5]),
    ("floor_camera.footprint_width_m", [0.2, 1.0]),
    ("floor_camera.q_items", [0.0, 4.0]),
    ("forward_camera.height_m", [0.1, 0.8]),
    ("forward_camera.horizontal_view_deg", [45.0, 110.0]),
    ("forward_camera.tilt_up_deg", [-10.0, 30.0]),
    ("forward_camera.turning_exposure_s", [0.0005, 0.01]),
    ("ceiling_camera.height_m", [0.1, 0.8]),
    ("ceiling_camera.focal_px", [150.0, 900.0]),
    ("ceiling_camera.lean_forward_deg", [-15.0, 15.0]),
    ("ceiling_camera.lean_left_deg", [-15.0, 15.0]),
    ("ceiling_camera.ring_intensity_w_per_sr", [0.0, 2.0]),
    ("forward_camera.ring_intensity_w_per_sr", [0.0, 2.0]),
    ("position_tolerance_m", [0.0, 0.02]),
    ("principal_point_tolerance_px", [0.0, 10.0]),
    ("distortion_tolerance_px", [0.0, 2.0]),
    ("lens.defocus_px", [0.0, 2.0]),
    // Beyond this distortion, the image of a wide lens is folded over: two directions share one pixel.
    ("lens.distortion", [-0.03, 0.03]),
    ("lens.row_time_s", [0.0, 5e-5]),
    ("sensor.exposure_s", [0.0005, 0.03]),
    ("sensor.longest_exposure_s", [0.001, 0.05]),
    ("sensor.f_number", [1.0, 8.0]),
    ("sensor.full_well_electrons", [2_000.0, 50_000.0]),
    ("sensor.read_noise_electrons", [0.0, 20.0]),
    ("sensor.dark_current_electrons_per_s", [0.0, 1_000.0]),
    ("sensor.dsnu_electrons", [0.0, 10.0]),
    ("sensor.prnu", [0.0, 0.03]),
    ("sensor.black_level", [0.0, 64.0]),
    ("sensor.max_gain_levels_per_electron", [0.01, 4.0]),
    ("sensor.pixel_pitch_m", [1.5e-6, 1e-5]),
    ("sensor.quantum_efficiency", [0.1, 0.9]),
    ("sensor.highlight_share", [0.0, 0.1]),
    ("range_camera.focal_px", [100.0, 1_000.0]),
    ("range_camera.width_px", [160.0, 1_280.0]),
    ("range_camera.greatest_range_m", [1.5, 20.0]),
    ("range_camera.least_range_m", [0.0, 0.7]),
    ("range_camera.height_m", [0.2, 1.0]),
    ("range_camera.q_items", [0.0, 3.0]),
    ("range_camera.wrong_items_max", [0.0, 3.0]),
    ("range_camera.wrong_share", [0.0, 0.2]),
    ("range_camera.wrong_spacing", [0.0, 8.0]),
    ("point_camera.focal_px", [100.0, 1_000.0]),
    ("point_camera.width_px", [160.0, 1_280.0]),
    ("point_camera.height_px", [120.0, 960.0]),
    ("point_camera.period_s", [0.05, 1.0]),
    ("point_camera.height_m", [0.1, 1.0]),
    ("point_camera.least_depth_m", [0.05, 1.0]),
    ("point_camera.greatest_depth_m", [1.5, 30.0]),
    ("gyro.period_s", [0.001, 0.1]),
    ("gyro.angle_random_walk_deg_per_sqrt_h", [0.0, 2.0]),
    ("markers.marker.misplaced_m", [-0.1, 0.1]),
    ("gyro.bias_wander_deg_per_s2", [0.0, 1.0]),
    ("gyro.noise_deg_per_s", [0.0, 5.0]),
    ("flow.period_s", [0.001, 0.1]),
    ("flow.greatest_speed_m_per_s", [0.2, 3.0]),
    ("flow.scale_tolerance", [0.0, 0.2]),
    ("flow.calibration_tolerance", [0.0, 0.1]),
    ("floor.friction", [0.4, 1.2]),
    ("floor.flow_dropout", [0.0, 0.9]),
    ("tiles.edge_x_m", [0.08, 0.8]),
    ("tiles.edge_y_m", [0.08, 0.8]),
    ("tiles.laying_tolerance_m", [0.0, 0.004]),
    ("tiles.corner_tolerance_m", [0.0, 0.003]),
    ("tiles.missing_share", [0.0, 0.4]),
    ("tiles.joint_width_m", [0.001, 0.02]),
    ("stray.width_m", [0.0005, 0.03]),
    ("region.friction", [0.2, 1.2]),
    ("region.height_m", [0.0, 0.004]),
    ("region.pile_height_m", [0.0, 0.003]),
    ("region.drag", [0.0, 0.2]),
    ("region.nap_drift", [0.0, 0.05]),
    ("event.friction", [0.1, 1.2]),
    ("event.displacement_m", [-0.4, 0.4]),
    ("event.lasts_s", [0.2, 3.0]),
    ("furniture.size_m", [0.05, 1.2]),
    ("furniture.height_m", [0.1, 2.0]),
    ("person.radius_m", [0.1, 0.3]),
    ("lamp.size_m", [0.05, 1.0]),
    ("lamp.lumens", [10.0, 5_000.0]),
    ("building.ceiling_height_m", [2.0, 4.0]),
    ("building.room.width_m", [0.8, 6.0]),
    ("building.room.depth_m", [0.8, 6.0]),
    ("door.height_m", [1.0, 2.0]),
    ("picture.bottom_m", [0.1, 1.4]),
    ("picture.height_m", [0.1, 0.6]),
    ("markers.rotation_tolerance_deg", [0.0, 5.0]),
    ("markers.height_tolerance_m", [0.0, 0.05]),
    ("landmark.height_m", [0.1, 1.5]),
    ("building.furniture_tolerance_deg", [0.0, 3.0]),
    ("localizer.wall_directions.tolerance_deg", [0.01, 5.0]),
    ("localizer.wall_directions.askew_deg", [0.0, 5.0]),
    ("light.unevenness_ratio", [1.0, 10.0]),
    ("illuminance_at_floor_lux", [0.1, 3_000.0]),
    ("illuminance_at_camera_lux", [0.05, 1_000.0]),
];

const COUNTS: [(&str, [i64; 2]); 6] = [
    ("route.waypoint", [1, 6]),
    ("landmark", [1, 30]),
    ("markers.marker", [1, 12]),
    ("station", [1, 5]),
    ("event", [1, 2]),
    ("waypoints_m", [1, 3]),
];
