//! The keys by which a scene tells the localizer its bounds: what tells it other bounds than those that hold.

use crate::{
    drawn::Drawn,
    scene::{Bounds, Robot, Scene},
};

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
        const PLACED: [&str; 14] = [
            "wheels.radius",
            "wheels.track",
            "floor_tiles.laying",
            "floor_tiles.straightness",
            "markers.placement",
            "markers.rotation",
            "markers.print",
            "markers.height",
            "gyro.noise",
            "gyro.angle",
            "range_camera.height_span",
            "range_landmarks.q_items",
            "range_landmarks.wrong_spacing",
            "wall_directions.direction",
        ];
        PLACED.contains(&bound)
    }

    /// Moves back to its bound what the scene itself places beyond the bound of this name.
    pub(crate) fn clip_placed(&mut self, bound: &str) {
        let Some(camera) = self.robot.range_camera.as_ref().filter(|_| bound == "range_camera.height_span") else {
            return;
        };
        let [low_m, high_m] = [-1.0, 1.0].map(|side| camera.height_m + side * camera.height_span_m);
        self.landmarks.iter_mut().for_each(|landmark| landmark.height_m = landmark.height_m.clamp(low_m, high_m));
    }

    /// Moves back to its bound what the map tells beyond the bound of this name of what truly stands there.
    pub(crate) fn clip_mapped(&mut self, bound: &str, drawn: &Drawn) {
        if bound != "wall_directions.direction" {
            return;
        }
        let (true_deg, mut setup) = (self.true_wall_directions_deg(drawn), self.localizer.wall_directions());
        let off_deg = |from_deg: f64, to_deg: f64| (from_deg - to_deg + 45.0).rem_euclid(90.0) - 45.0;
        let nearest = |deg: f64, others_deg: &[f64]| {
            others_deg.iter().map(|other_deg| off_deg(deg, *other_deg)).min_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let mut mapped_deg = self.mapped_wall_directions_deg();
        for deg in &mut mapped_deg {
            let off_deg = nearest(*deg, &true_deg).unwrap_or(0.0);
            *deg += off_deg.clamp(-setup.tolerance_deg, setup.tolerance_deg) - off_deg;
        }
        let is_untold =
            |deg: &f64| nearest(*deg, &mapped_deg).is_none_or(|off_deg| off_deg.abs() > setup.tolerance_deg);
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
            "room.walls" => self.robot.body_radius_m -= (true_value - declared).max(0.0),
            // The angle follows from the laying at both ends of the room's shorter side.
            "floor_tiles.laying_angle" => {
                let shortest_m = self.room.width_m.min(self.room.depth_m);
                if let Some(tiles) = &mut self.floor.tiles {
                    tiles.laying_tolerance_m = tiles.laying_tolerance_m.max(0.5 * true_value * shortest_m);
                }
            }
            "range_landmarks.q_items" | "range_landmarks.wrong_spacing" => {
                if let Some(camera) = &mut self.robot.range_camera {
                    let beyond = (true_value - declared).max(0.0).ceil() as usize;
                    match bound {
                        "range_landmarks.q_items" => camera.q_items += beyond,
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
        keys.add(&["floor_tiles.laying"], &mut tiles.laying_tolerance_m, 1.0, Widens::By);
        keys.is(&["floor_tiles.straightness"], &mut tiles.corner_tolerance_m);
    }
    if let Some(markers) = markers {
        keys.is(&["markers.placement"], &mut markers.placement_tolerance_m);
        keys.is_in_deg(&["markers.rotation"], &mut markers.rotation_tolerance_deg);
        keys.is(&["markers.print"], &mut markers.print_tolerance_m);
        keys.is(&["markers.height"], &mut markers.height_tolerance_m);
    }
    if let Some(setup) = &mut localizer.wall_directions {
        keys.is_in_deg(&["wall_directions.direction"], &mut setup.tolerance_deg);
    }
    keys
}

/// What comes out of the physics.
fn emergent<'a>(bounds: &'a mut Bounds, keys: &mut Keys<'a>) {
    keys.add(&["wheels.slip"], &mut bounds.slip_ratio, 1.0, Widens::Not);
    keys.add(&["wheels.slip"], &mut bounds.slip_floor_m, 1.0, Widens::By);
    keys.add(&["wheels.side_slip"], &mut bounds.side_slip_ratio, 1.0, Widens::Not);
    keys.add(&["wheels.side_slip"], &mut bounds.side_slip_floor_m, 1.0, Widens::By);
    keys.is(&["reach.speed"], &mut bounds.reach_speed_m_per_s);
    keys.is(&["reach.turn_rate"], &mut bounds.reach_turn_rate_rad_per_s);
    keys.is(&["reach.acceleration"], &mut bounds.reach_acceleration_m_per_s2);
    keys.is_in_deg(&["body.tilt"], &mut bounds.body_tilt_deg);
    keys.is(&["body.heave"], &mut bounds.body_heave_m);
    if let Some(rest_deg) = &mut bounds.rest_turn_deg {
        keys.is_in_deg(&["wheels.rest"], rest_deg);
    }
}

/// What is drawn of the robot.
fn sensors<'a>(robot: &'a mut Robot, keys: &mut Keys<'a>) {
    keys.add(&["wheels.radius"], &mut robot.wheel_radius_tolerance, 1.0 / robot.wheel_radius_m, Widens::To);
    keys.is(&["base.stamp"], &mut robot.delivery.stamp_tolerance_s);
    keys.add(&["wheels.track"], &mut robot.track_tolerance, 1.0 / robot.track_m, Widens::To);
    if let Some(camera) = &mut robot.floor_camera {
        let m_per_px = camera.footprint_width_m / f64::from(camera.width_px);
        keys.is(&["floor_camera.position"], &mut camera.position_tolerance_m);
        keys.is_in_deg(&["floor_camera.yaw"], &mut camera.yaw_tolerance_deg);
        keys.is_in_deg(&["floor_camera.tilt"], &mut camera.tilt_tolerance_deg);
        keys.add(&["floor_camera.scale"], &mut camera.scale_tolerance, m_per_px, Widens::To);
        keys.is(&["floor_camera.distortion"], &mut camera.distortion_tolerance_px);
        keys.is(&["floor_camera.stamp"], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.forward_camera {
        let calibration = &mut camera.calibration;
        keys.is_in_deg(&["forward_camera.yaw", "forward_camera.tilt"], &mut calibration.angle_tolerance_deg);
        keys.is(&["forward_camera.focal"], &mut calibration.focal_tolerance);
        keys.is(&["forward_camera.principal_point"], &mut calibration.principal_point_tolerance_px);
        keys.is(&["forward_camera.distortion"], &mut calibration.distortion_tolerance_px);
        keys.is(&["forward_camera.stamp"], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.ceiling_camera {
        let calibration = &mut camera.calibration;
        keys.is(&["ceiling_camera.position", "ceiling_camera.height"], &mut calibration.position_tolerance_m);
        keys.is_in_deg(&["ceiling_camera.yaw", "ceiling_camera.tilt"], &mut calibration.angle_tolerance_deg);
        keys.is(&["ceiling_camera.focal"], &mut calibration.focal_tolerance);
        keys.is(&["ceiling_camera.centre"], &mut calibration.principal_point_tolerance_px);
        keys.is(&["ceiling_camera.distortion"], &mut calibration.distortion_tolerance_px);
        keys.is(&["ceiling_camera.stamp"], &mut camera.stamp_tolerance_s);
    }
    if let Some(camera) = &mut robot.range_camera {
        keys.add(&["range_camera.focal"], &mut camera.focal_tolerance, 1.0 / camera.focal_px, Widens::To);
        keys.add(&["range_camera.baseline"], &mut camera.baseline_tolerance, 1.0 / camera.baseline_m, Widens::To);
        keys.is(&["range_camera.position"], &mut camera.position_tolerance_m);
        keys.is_in_deg(&["range_camera.yaw"], &mut camera.yaw_tolerance_deg);
        keys.is_in_deg(&["range_camera.tilt"], &mut camera.tilt_tolerance_deg);
        keys.is(&["range_camera.height_span"], &mut camera.height_span_m);
        keys.is(&["range_camera.stamp"], &mut camera.stamp_tolerance_s);
        keys.is(&["range_camera.latency"], &mut camera.latency_tolerance_s);
        keys.is(&["range_camera.columns"], &mut camera.column_noise_px);
    }
    if let Some(gyro) = &mut robot.gyro {
        keys.is_in_deg(&["gyro.bias"], &mut gyro.bias_tolerance_deg_per_s);
        keys.is(&["gyro.scale"], &mut gyro.scale_tolerance);
        keys.is_in_deg(&["gyro.noise"], &mut gyro.noise_deg_per_s);
        keys.is_in_deg(&["gyro.wander"], &mut gyro.bias_wander_deg_per_s2);
        keys.add(&["gyro.angle"], &mut gyro.angle_deg_per_s, 1.0, Widens::Not);
        if let Some(floor_deg) = &mut gyro.angle_floor_deg {
            keys.is_in_deg(&["gyro.angle"], floor_deg);
        }
    }
    if let Some(flow) = &mut robot.flow {
        keys.is(&["flow.position"], &mut flow.position_tolerance_m);
        keys.is_in_deg(&["flow.yaw"], &mut flow.yaw_tolerance_deg);
        keys.is(&["flow.calibration"], &mut flow.calibration_tolerance);
        // Of it, what the calibration leaves may vary.
        keys.add(&["flow.scale", "flow.calibration"], &mut flow.scale_tolerance, 1.0, Widens::By);
        keys.is(&["flow.back_and_forth"], &mut flow.back_and_forth_m);
    }
}
