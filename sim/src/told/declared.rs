//! The keys by which a scene tells the localizer its bounds: what tells it other bounds than those that hold.

use crate::{
    drawn::{Drawn, turn_from_nearest_deg},
    scene::{Bounds, Robot, Scene},
};
use localizer::bounds;

/// One key of the scene that states a bound.
struct Key<'a> {
    /// Bounds that it states, by their names in `relies_on`.
    bounds: &'static [&'static str],
    /// Its value, in the key's own unit.
    value: &'a mut f64,
    /// How much of the key's unit is one unit of the true value that is held against the bound.
    per_true: f64,
    widens: Widens,
}

/// What a true value beyond the bound makes of the key.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Widens {
    /// The key becomes the true value.
    To,
    /// What is missing is added: the bound is a sum, or one over every window.
    By,
    /// Another key of the same bound does it.
    Not,
}

impl Scene {
    /// Widens the bound of this name so that `true_value` keeps it, where the scene declares `declared`. A bound that holds stays.
    pub fn widen(&mut self, bound: &str, declared: f64, true_value: f64) {
        self.state_defaults();
        self.widen_others(bound, declared, true_value);
        for key in keys(self).0.into_iter().filter(|key| key.bounds.contains(&bound)) {
            match key.widens {
                // A share more than the comparison of a bound leaves to rounding.
                Widens::To => *key.value = key.value.max(true_value * key.per_true * (1.0 + 1e-9)),
                Widens::By => *key.value += (true_value - declared).max(0.0) * key.per_true * (1.0 + 1e-9),
                Widens::Not => {}
            }
        }
    }

    /// Makes every bound that the scene tells the localizer narrower by the same factor. Where the robot starts is no error of a sensor
    /// and stays: told smaller, it would be false before anything was measured.
    pub(crate) fn weaken(&mut self, factor: f64) {
        self.state_defaults();
        keys(self).0.into_iter().for_each(|key| *key.value *= factor);
    }

    /// Whether the true value behind a bound is drawn by the simulator or placed by the scene, so that a run can have it within its bound.
    /// All else emerges from the physics, or is drawn within its bound by construction.
    pub(crate) fn places(bound: &str) -> bool {
        const PLACED: [&str; 15] = [
            bounds::WHEELS_RADIUS,
            bounds::WHEELS_TRACK,
            bounds::FLOOR_TILES_LAYING,
            bounds::FLOOR_TILES_STRAIGHTNESS,
            bounds::MARKERS_PLACEMENT,
            bounds::MARKERS_ROTATION,
            bounds::MARKERS_PRINT,
            bounds::MARKERS_HEIGHT,
            bounds::GYRO_NOISE,
            bounds::GYRO_ANGLE,
            bounds::RANGE_CAMERA_HEIGHT_SPAN,
            bounds::RANGE_LANDMARKS_Q_ITEMS,
            bounds::RANGE_LANDMARKS_WRONG_SPACING,
            bounds::WALL_DIRECTIONS_DIRECTION,
            bounds::WALL_DIRECTIONS_ASKEW,
        ];
        PLACED.contains(&bound)
    }

    /// Moves back to its bound what the scene itself places beyond the bound of this name.
    pub(crate) fn clip_placed(&mut self, bound: &str) {
        let Some(camera) = self.robot.range_camera.as_ref().filter(|_| bound == bounds::RANGE_CAMERA_HEIGHT_SPAN)
        else {
            return;
        };
        let [low_m, high_m] = [-1.0, 1.0].map(|side| camera.height_m + side * camera.height_span_m);
        self.landmarks.iter_mut().for_each(|landmark| landmark.height_m = landmark.height_m.clamp(low_m, high_m));
    }

    /// Moves back to its bound what the map tells beyond the bound of this name of what truly stands there.
    pub(crate) fn clip_mapped(&mut self, bound: &str, drawn: &Drawn) {
        if bound != bounds::WALL_DIRECTIONS_DIRECTION {
            return;
        }
        let (true_deg, mut setup) = (self.true_wall_directions_deg(drawn), self.localizer.wall_directions());
        let mut mapped_deg = self.mapped_wall_directions_deg();
        for deg in &mut mapped_deg {
            let off_deg = turn_from_nearest_deg(*deg, &true_deg).unwrap_or(0.0);
            *deg += off_deg.clamp(-setup.tolerance_deg, setup.tolerance_deg) - off_deg;
        }
        let is_untold = |deg: &f64| {
            turn_from_nearest_deg(*deg, &mapped_deg).is_none_or(|off_deg| off_deg.abs() > setup.tolerance_deg)
        };
        let untold_deg: Vec<f64> = true_deg.iter().copied().filter(is_untold).collect();
        if !setup.learns {
            mapped_deg.extend(untold_deg);
        }
        setup.mapped_deg = Some(mapped_deg);
        self.localizer.wall_directions = Some(setup);
    }

    /// States what follows from a bound unless stated, so that it stays when the bound changes.
    fn state_defaults(&mut self) {
        let ceiling = self.clone();
        if let Some(markers) = &mut self.markers {
            markers.state_heights(&ceiling);
        }
        self.localizer.wall_directions = Some(self.localizer.wall_directions());
    }

    /// The bounds that are no key's value as it stands.
    fn widen_others(&mut self, bound: &str, declared: f64, true_value: f64) {
        match bound {
            // How close the origin may come to a wall.
            bounds::ROOM_WALLS => self.robot.body_radius_m -= (true_value - declared).max(0.0),
            // The angle follows from the laying at both ends of the room's shorter side.
            bounds::FLOOR_TILES_LAYING_ANGLE => {
                let shortest_m = self.room.width_m.min(self.room.depth_m);
                if let Some(tiles) = &mut self.floor.tiles {
                    tiles.laying_tolerance_m = tiles.laying_tolerance_m.max(0.5 * true_value * shortest_m);
                }
            }
            bounds::RANGE_LANDMARKS_Q_ITEMS | bounds::RANGE_LANDMARKS_WRONG_SPACING => {
                if let Some(camera) = &mut self.robot.range_camera {
                    let beyond = (true_value - declared).max(0.0).ceil() as usize;
                    match bound {
                        bounds::RANGE_LANDMARKS_Q_ITEMS => camera.q_items += beyond,
                        _ => camera.wrong_spacing = camera.wrong_spacing.saturating_sub(beyond),
                    }
                }
            }
            _ => {}
        }
    }
}

/// Keys of bounds, each once.
struct Keys<'a>(Vec<Key<'a>>);

impl<'a> Keys<'a> {
    fn add(&mut self, bounds: &'static [&'static str], value: &'a mut f64, per_true: f64, widens: Widens) {
        self.0.push(Key { bounds, value, per_true, widens });
    }

    /// A key that is the bound, in the unit of the true value.
    fn is(&mut self, bounds: &'static [&'static str], value: &'a mut f64) {
        self.add(bounds, value, 1.0, Widens::To);
    }

    /// A key in degrees of a bound in radians.
    fn is_in_deg(&mut self, bounds: &'static [&'static str], value: &'a mut f64) {
        self.add(bounds, value, f64::to_degrees(1.0), Widens::To);
    }
}

/// Every key that states a bound in a physical unit and has a value.
fn keys(scene: &mut Scene) -> Keys<'_> {
    let mut keys = Keys(Vec::new());
    let Scene { bounds, robot, floor, markers, localizer, .. } = scene;
    emergent(bounds, &mut keys);
    sensors(robot, &mut keys);
    if let Some(tiles) = &mut floor.tiles {
        keys.add(&[bounds::FLOOR_TILES_LAYING], &mut tiles.laying_tolerance_m, 1.0, Widens::By);
        keys.is(&[bounds::FLOOR_TILES_STRAIGHTNESS], &mut tiles.corner_tolerance_m);
    }
    if let Some(markers) = markers {
        keys.is(&[bounds::MARKERS_PLACEMENT], &mut markers.placement_tolerance_m);
        keys.is_in_deg(&[bounds::MARKERS_ROTATION], &mut markers.rotation_tolerance_deg);
        keys.is(&[bounds::MARKERS_PRINT], &mut markers.print_tolerance_m);
        keys.is(&[bounds::MARKERS_HEIGHT], &mut markers.height_tolerance_m);
    }
    if let Some(setup) = &mut localizer.wall_directions {
        keys.is_in_deg(&[bounds::WALL_DIRECTIONS_DIRECTION], &mut setup.tolerance_deg);
        keys.is_in_deg(&[bounds::WALL_DIRECTIONS_ASKEW], &mut setup.askew_deg);
    }
    keys
}

/// What comes out of the physics.
fn emergent<'a>(bounds: &'a mut Bounds, keys: &mut Keys<'a>) {
    keys.add(&[bounds::WHEELS_SLIP], &mut bounds.slip_ratio, 1.0, Widens::Not);
    keys.add(&[bounds::WHEELS_SLIP], &mut bounds.slip_floor_m, 1.0, Widens::By);
    keys.add(&[bounds::WHEELS_SIDE_SLIP], &mut bounds.side_slip_ratio, 1.0, Widens::Not);
    keys.add(&[bounds::WHEELS_SIDE_SLIP], &mut bounds.side_slip_floor_m, 1.0, Widens::By);
    keys.is(&[bounds::REACH_SPEED], &mut bounds.reach_speed_m_per_s);
    keys.is(&[bounds::REACH_TURN_RATE], &mut bounds.reach_turn_rate_rad_per_s);
    keys.is(&[bounds::REACH_ACCELERATION], &mut bounds.reach_acceleration_m_per_s2);
    keys.is_in_deg(&[bounds::BODY_TILT], &mut bounds.body_tilt_deg);
    keys.is(&[bounds::BODY_HEAVE], &mut bounds.body_heave_m);
    if let Some(rest_deg) = &mut bounds.rest_turn_deg {
        keys.is_in_deg(&[bounds::WHEELS_REST], rest_deg);
    }
}

/// What is drawn of the robot.
fn sensors<'a>(robot: &'a mut Robot, keys: &mut Keys<'a>) {
    keys.add(&[bounds::WHEELS_RADIUS], &mut robot.wheel_radius_tolerance, 1.0 / robot.wheel_radius_m, Widens::To);
    keys.is(&[bounds::BASE_STAMP], &mut robot.delivery.stamp_tolerance_s);
    keys.add(&[bounds::WHEELS_TRACK], &mut robot.track_tolerance, 1.0 / robot.track_m, Widens::To);
    if let Some(camera) = &mut robot.floor_camera {
        let m_per_px = camera.footprint_width_m / f64::from(camera.width_px);
        keys.is(&[bounds::FLOOR_CAMERA_POSITION], &mut camera.position_tolerance_m);
        keys.is_in_deg(&[bounds::FLOOR_CAMERA_YAW], &mut camera.yaw_tolerance_deg);
        keys.is_in_deg(&[bounds::FLOOR_CAMERA_TILT], &mut camera.tilt_tolerance_deg);
        keys.add(&[bounds::FLOOR_CAMERA_SCALE], &mut camera.scale_tolerance, m_per_px, Widens::To);
        keys.is(&[bounds::FLOOR_CAMERA_DISTORTION], &mut camera.distortion_tolerance_px);
        keys.is(&[bounds::FLOOR_CAMERA_STAMP], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.forward_camera {
        let calibration = &mut camera.calibration;
        keys.is_in_deg(
            &[bounds::FORWARD_CAMERA_YAW, bounds::FORWARD_CAMERA_TILT],
            &mut calibration.angle_tolerance_deg,
        );
        keys.is(&[bounds::FORWARD_CAMERA_FOCAL], &mut calibration.focal_tolerance);
        keys.is(&[bounds::FORWARD_CAMERA_PRINCIPAL_POINT], &mut calibration.principal_point_tolerance_px);
        keys.is(&[bounds::FORWARD_CAMERA_DISTORTION], &mut calibration.distortion_tolerance_px);
        keys.is(&[bounds::FORWARD_CAMERA_STAMP], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.ceiling_camera {
        let calibration = &mut camera.calibration;
        keys.is(
            &[bounds::CEILING_CAMERA_POSITION, bounds::CEILING_CAMERA_HEIGHT],
            &mut calibration.position_tolerance_m,
        );
        keys.is_in_deg(
            &[bounds::CEILING_CAMERA_YAW, bounds::CEILING_CAMERA_TILT],
            &mut calibration.angle_tolerance_deg,
        );
        keys.is(&[bounds::CEILING_CAMERA_FOCAL], &mut calibration.focal_tolerance);
        keys.is(&[bounds::CEILING_CAMERA_CENTRE], &mut calibration.principal_point_tolerance_px);
        keys.is(&[bounds::CEILING_CAMERA_DISTORTION], &mut calibration.distortion_tolerance_px);
        keys.is(&[bounds::CEILING_CAMERA_STAMP], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.range_camera {
        keys.add(&[bounds::RANGE_CAMERA_FOCAL], &mut camera.focal_tolerance, 1.0 / camera.focal_px, Widens::To);
        keys.add(&[bounds::RANGE_CAMERA_BASELINE], &mut camera.baseline_tolerance, 1.0 / camera.baseline_m, Widens::To);
        keys.is(&[bounds::RANGE_CAMERA_POSITION], &mut camera.position_tolerance_m);
        keys.is_in_deg(&[bounds::RANGE_CAMERA_YAW], &mut camera.yaw_tolerance_deg);
        keys.is_in_deg(&[bounds::RANGE_CAMERA_TILT], &mut camera.tilt_tolerance_deg);
        keys.is(&[bounds::RANGE_CAMERA_HEIGHT_SPAN], &mut camera.height_span_m);
        keys.is(&[bounds::RANGE_CAMERA_STAMP], &mut camera.stamp_tolerance_s);
        keys.is(&[bounds::RANGE_CAMERA_LATENCY], &mut camera.latency_tolerance_s);
        keys.is(&[bounds::RANGE_CAMERA_COLUMNS], &mut camera.column_noise_px);
    }
    if let Some(gyro) = &mut robot.gyro {
        keys.is_in_deg(&[bounds::GYRO_BIAS], &mut gyro.bias_tolerance_deg_per_s);
        keys.is(&[bounds::GYRO_SCALE], &mut gyro.scale_tolerance);
        keys.is_in_deg(&[bounds::GYRO_NOISE], &mut gyro.noise_deg_per_s);
        keys.is_in_deg(&[bounds::GYRO_WANDER], &mut gyro.bias_wander_deg_per_s2);
        keys.add(&[bounds::GYRO_ANGLE], &mut gyro.angle_deg_per_s, 1.0, Widens::Not);
        if let Some(floor_deg) = &mut gyro.angle_floor_deg {
            keys.is_in_deg(&[bounds::GYRO_ANGLE], floor_deg);
        }
    }
    if let Some(flow) = &mut robot.flow {
        keys.is(&[bounds::FLOW_POSITION], &mut flow.position_tolerance_m);
        keys.is_in_deg(&[bounds::FLOW_YAW], &mut flow.yaw_tolerance_deg);
        keys.is(&[bounds::FLOW_CALIBRATION], &mut flow.calibration_tolerance);
        // Of it, what the calibration leaves may vary.
        keys.add(&[bounds::FLOW_SCALE, bounds::FLOW_CALIBRATION], &mut flow.scale_tolerance, 1.0, Widens::By);
        keys.is(&[bounds::FLOW_BACK_AND_FORTH], &mut flow.back_and_forth_m);
    }
}
