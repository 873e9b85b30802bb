//! The keys by which a scene gives the localizer its bounds, and functions that make these bounds wider or narrower than declared.

use crate::{
    base,
    devices::{ToldKey, Widens, each_told_key},
    place::drawn::turn_from_nearest_deg,
    scene::{Bounds, Scene},
    world::Drawn,
};
use localizer::bounds;

impl Scene {
    /// Widens the bound of this name far enough to allow `true_value`; `declared` is the bound that the scene declares. A bound that is not exceeded
    /// stays unchanged.
    pub fn widen(&mut self, bound: &str, declared: f64, true_value: f64) {
        self.state_defaults();
        self.widen_others(bound, declared, true_value);
        each_key(self, &mut |key| match key.widens {
            _ if !key.bounds.contains(&bound) => {}
            // The relative margin of 1e-9 is greater than the one that the comparison of a true value with its bound allows for rounding.
            Widens::To => *key.value = key.value.max(true_value * key.per_true * (1.0 + 1e-9)),
            Widens::By => *key.value += (true_value - declared).max(0.0) * key.per_true * (1.0 + 1e-9),
            Widens::Not => {}
        });
    }

    /// Makes every bound that the scene gives the localizer narrower by the same factor. The box in which the robot starts is no error of a
    /// sensor and stays: a smaller one would be false before anything was measured.
    pub(crate) fn weaken(&mut self, factor: f64) {
        self.state_defaults();
        each_key(self, &mut |key| *key.value *= factor);
    }

    /// Moves values that the scene itself states, such as landmarks' heights, back to the bound of this name where they are beyond it.
    pub(crate) fn clip_placed(&mut self, bound: &str) {
        let Some(camera) = self.robot.range_camera.as_ref().filter(|_| bound == bounds::RANGE_CAMERA_HEIGHT_SPAN)
        else {
            return;
        };
        let [low_m, high_m] = [-1.0, 1.0].map(|side| camera.height_m + side * camera.height_span_m);
        self.landmarks.iter_mut().for_each(|landmark| landmark.height_m = landmark.height_m.clamp(low_m, high_m));
    }

    /// Corrects the map where it differs from what truly stands there by more than the bound of this name: wall directions are moved back
    /// to the bound, and missing ones are added.
    pub(crate) fn clip_mapped(&mut self, bound: &str, drawn: &Drawn) {
        if bound != bounds::WALL_DIRECTIONS_DIRECTION {
            return;
        }
        let (true_deg, mut setup) = (self.true_wall_directions_deg(&drawn.place), self.localizer.wall_directions());
        let mut mapped_deg = self.mapped_wall_directions_deg();
        for deg in &mut mapped_deg {
            let off_deg = turn_from_nearest_deg(*deg, &true_deg).unwrap_or(0.0);
            *deg += off_deg.clamp(-setup.tolerance_deg, setup.tolerance_deg) - off_deg;
        }
        let is_untold = |deg: &f64| {
            let off_deg = turn_from_nearest_deg(*deg, &mapped_deg).map(f64::abs);
            off_deg.is_none_or(|off_deg| off_deg > setup.tolerance_deg && !self.is_learnt_at(off_deg))
        };
        let untold_deg: Vec<f64> = true_deg.iter().copied().filter(is_untold).collect();
        mapped_deg.extend(untold_deg);
        setup.mapped_deg = Some(mapped_deg);
        self.localizer.wall_directions = Some(setup);
    }

    /// Writes values that otherwise follow from the scene or are defaults (markers' heights, setups of methods) explicitly into their keys, so
    /// that they stay when a bound changes.
    fn state_defaults(&mut self) {
        let ceiling = self.clone();
        if let Some(markers) = &mut self.markers {
            markers.state_heights(&ceiling);
        }
        self.localizer.wall_directions = Some(self.localizer.wall_directions());
        self.localizer.wall_ranges = Some(self.localizer.wall_ranges());
    }

    /// Widens the bounds that are not simply the value of one key of the scene.
    fn widen_others(&mut self, bound: &str, declared: f64, true_value: f64) {
        match bound {
            // The bound on walls is the least distance of the robot's origin from a wall, which follows from the body's radius.
            bounds::ROOM_WALLS => self.robot.body_radius_m -= (true_value - declared).max(0.0),
            // The bound on a floor joint's angle follows from the tiles' laying tolerance at both ends of the room's shorter side.
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

/// Calls `change` for every key that states a bound in a physical unit and has a value.
fn each_key(scene: &mut Scene, change: &mut dyn FnMut(ToldKey<'_>)) {
    let Scene { bounds, robot, floor, markers, localizer, .. } = scene;
    emergent(bounds).into_iter().for_each(&mut *change);
    if let Some(tiles) = &mut floor.tiles {
        change(ToldKey::is_part(&[bounds::FLOOR_TILES_LAYING], &mut tiles.laying_tolerance_m, Widens::By));
        change(ToldKey::is(&[bounds::FLOOR_TILES_STRAIGHTNESS], &mut tiles.corner_tolerance_m));
    }
    if let Some(markers) = markers {
        change(ToldKey::is(&[bounds::MARKERS_PLACEMENT], &mut markers.placement_tolerance_m));
        change(ToldKey::is_in_deg(&[bounds::MARKERS_ROTATION], &mut markers.rotation_tolerance_deg));
        change(ToldKey::is(&[bounds::MARKERS_PRINT], &mut markers.print_tolerance_m));
        change(ToldKey::is(&[bounds::MARKERS_HEIGHT], &mut markers.height_tolerance_m));
    }
    if let Some(setup) = &mut localizer.wall_directions {
        change(ToldKey::is_in_deg(&[bounds::WALL_DIRECTIONS_DIRECTION], &mut setup.tolerance_deg));
        change(ToldKey::is_in_deg(&[bounds::WALL_DIRECTIONS_ASKEW], &mut setup.askew_deg));
    }
    if let Some(setup) = &mut localizer.wall_ranges {
        change(ToldKey::is(&[bounds::WALLS_PLACEMENT], &mut setup.placement_tolerance_m));
    }
    base::told_keys(robot).into_iter().for_each(&mut *change);
    each_told_key(robot, change);
}

/// Keys of the bounds on quantities that emerge from the physics, such as slip, speed, acceleration and the body's tilt.
fn emergent(bounds: &mut Bounds) -> Vec<ToldKey<'_>> {
    let mut keys = vec![
        ToldKey::is_part(&[bounds::WHEELS_SLIP], &mut bounds.slip_ratio, Widens::Not),
        ToldKey::is_part(&[bounds::WHEELS_SLIP], &mut bounds.slip_floor_m, Widens::By),
        ToldKey::is_part(&[bounds::WHEELS_SIDE_SLIP], &mut bounds.side_slip_ratio, Widens::Not),
        ToldKey::is_part(&[bounds::WHEELS_SIDE_SLIP], &mut bounds.side_slip_floor_m, Widens::By),
        ToldKey::is(&[bounds::REACH_SPEED], &mut bounds.reach_speed_m_per_s),
        ToldKey::is(&[bounds::REACH_TURN_RATE], &mut bounds.reach_turn_rate_rad_per_s),
        ToldKey::is(&[bounds::REACH_ACCELERATION], &mut bounds.reach_acceleration_m_per_s2),
        ToldKey::is_in_deg(&[bounds::BODY_TILT], &mut bounds.body_tilt_deg),
        ToldKey::is(&[bounds::BODY_HEAVE], &mut bounds.body_heave_m),
    ];
    keys.extend(bounds.rest_turn_deg.as_mut().map(|rest_deg| ToldKey::is_in_deg(&[bounds::WHEELS_REST], rest_deg)));
    keys
}
