//! Moves true values of floor, furniture and markers that lie beyond a declared bound (drawn by a seed or placed by a scene) back to the bound,
//! so that the run can be repeated as it would have been within the bound.

use localizer::bounds;
use nalgebra::{Rotation2, Vector2};

use crate::scene::{Marker, Markers, Scene};

use super::{DrawnMarker, DrawnPlace};

impl DrawnPlace {
    /// Moves true values that lie beyond the declared bound named `bound` back to that bound; all other values stay as drawn.
    pub(crate) fn clip(&mut self, bound: &str, scene: &Scene) {
        match bound {
            bounds::FLOOR_TILES_LAYING | bounds::FLOOR_TILES_STRAIGHTNESS => {
                let (Some(tiles), Some(laid)) = (&scene.floor.tiles, &mut self.tiles) else { return };
                if bound == bounds::FLOOR_TILES_LAYING {
                    laid.clip_offsets(tiles.laying_tolerance_m + tiles.corner_tolerance_m);
                } else {
                    laid.clip_bends(tiles, tiles.corner_tolerance_m);
                }
            }
            bounds::WALL_DIRECTIONS_ASKEW => {
                let declared_deg = scene.localizer.wall_directions().askew_deg;
                let askew_deg = scene.furniture_askew_deg(self);
                for (turn_deg, askew_deg) in self.furniture_turn_deg.iter_mut().zip(askew_deg) {
                    *turn_deg += askew_deg.clamp(-declared_deg, declared_deg) - askew_deg;
                }
            }
            bounds::MARKERS_PLACEMENT | bounds::MARKERS_ROTATION | bounds::MARKERS_PRINT | bounds::MARKERS_HEIGHT => {
                let Some(markers) = &scene.markers else { return };
                for drawn in &mut self.markers {
                    if let Some(nominal) = markers.all().get(drawn.index) {
                        drawn.clip(bound, nominal, markers, markers.height_m(nominal, scene));
                    }
                }
            }
            _ => {}
        }
    }
}

/// The vector, shortened to at most the given length.
fn within(vector: Vector2<f64>, longest_m: f64) -> Vector2<f64> {
    let length_m = vector.norm();
    if length_m > longest_m { vector * (longest_m / length_m) } else { vector }
}

impl DrawnMarker {
    fn clip(&mut self, bound: &str, nominal: &Marker, markers: &Markers, nominal_height_m: f64) {
        match bound {
            bounds::MARKERS_PLACEMENT => {
                let at = Vector2::new(nominal.x_m, nominal.y_m);
                let centre = at + within(Vector2::from(self.centre_m) - at, markers.placement_tolerance_m);
                let moved = centre - Vector2::from(self.centre_m);
                self.dots.iter_mut().for_each(|dot| dot.centre_in_world += moved.push(0.0));
                self.centre_m = centre.into();
            }
            bounds::MARKERS_ROTATION => {
                let tolerance_rad = markers.rotation_tolerance_deg.to_radians();
                let off = Rotation2::new(self.rotation_rad - nominal.rotation_deg.to_radians()).angle();
                let back = Rotation2::new(off.clamp(-tolerance_rad, tolerance_rad) - off);
                let centre = Vector2::from(self.centre_m);
                for dot in &mut self.dots {
                    let at = centre + back * (dot.centre_in_world.xy().coords - centre);
                    (dot.centre_in_world.x, dot.centre_in_world.y) = (at.x, at.y);
                }
                self.rotation_rad += back.angle();
            }
            bounds::MARKERS_PRINT => {
                let world_from_marker = Rotation2::new(self.rotation_rad);
                for dot in &mut self.dots {
                    let [along_m, across_m] = localizer::markers::dot_in_marker_m(dot.place);
                    let right = Vector2::from(self.centre_m) + world_from_marker * Vector2::new(along_m, across_m);
                    let at = right + within(dot.centre_in_world.xy().coords - right, markers.print_tolerance_m);
                    (dot.centre_in_world.x, dot.centre_in_world.y) = (at.x, at.y);
                }
            }
            _ => {
                let (low_m, high_m) =
                    (nominal_height_m - markers.height_tolerance_m, nominal_height_m + markers.height_tolerance_m);
                self.height_m = self.height_m.clamp(low_m, high_m);
                self.dots.iter_mut().for_each(|dot| dot.centre_in_world.z = self.height_m);
            }
        }
    }
}
