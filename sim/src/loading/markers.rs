//! Lays out ceiling markers where a scene asks for it.

use super::contradiction::Contradiction;
use crate::{
    loading::coverage::{Ceiling, Field, Hall, Place, Unlaid, smallest_kept},
    scene::{Marker, Scene, UNDER_CEILING_M},
};

/// Distance that the middles of laid-out markers keep from the walls.
const FROM_WALL_M: f64 = 0.08;
/// Least distance between the middles of two laid-out markers of rooms that overlap: the diagonal of a marker's square, at any turn of both.
const APART_M: f64 = 0.23;

impl Scene {
    /// Lays out ceiling markers as `[markers.layout]` demands, in the robot's room and then in each further room that is a rectangle. Does nothing if
    /// the scene has no such table.
    pub(super) fn lay_out_markers(&mut self) -> Result<(), Contradiction> {
        let Some(markers) = self.markers.as_ref().filter(|markers| markers.layout.is_some()) else { return Ok(()) };
        let refused = |expected: String| Contradiction { key: "markers.layout".to_owned(), expected };
        if !markers.markers.is_empty() {
            return Err(refused("stands beside `[[markers.marker]]`, expected one of the two".to_owned()));
        }
        if self.robot.ceiling_camera.is_none() {
            return Err(refused("stands without `[robot.ceiling_camera]`, for which markers are laid out".to_owned()));
        }
        let (words, coding) = (localizer::markers::Coding::from(markers.coding).identities(), markers.coding.as_str());
        let field = Field::new(self, markers.goal().margin_px);
        let mut laid_out: Vec<Marker> = Vec::new();
        for hall in Hall::all(self) {
            let ceiling = Ceiling {
                reach_m: hall.reach_m(self),
                markers_m: hall.size_m.map(|extent_m| [FROM_WALL_M, extent_m - FROM_WALL_M]),
                height_m: self.building.ceiling_height_m - UNDER_CEILING_M - markers.height_tolerance_m,
                seen_at_once: markers.goal().seen_at_once,
                most_markers: words.len() - laid_out.len(),
            };
            let places = field.as_ref().ok_or(Unlaid::Uncovered).and_then(|field| smallest_kept(field, &ceiling));
            let places = places.map_err(|unlaid| {
                refused(match unlaid {
                    Unlaid::Uncovered => "no lattice of up to 4096 markers is surely seen, expected a shorter focal length of the ceiling \
                                          camera, or smaller tolerances"
                        .to_owned(),
                    Unlaid::TooMany(needed) => format!(
                        "{} markers are needed, but the {coding} have {} words; expected a shorter focal length, a lower camera under a \
                         higher ceiling, smaller tolerances, or `coding = \"plain\"` with 4096",
                        laid_out.len() + needed,
                        words.len()
                    ),
                })
            })?;
            // Where rooms overlap, markers of the rooms before hang there already.
            let is_free = |[x_m, y_m]: &[f64; 2]| {
                laid_out.iter().all(|other| (other.x_m - x_m).hypot(other.y_m - y_m) >= APART_M)
            };
            let in_world = places.iter().map(|place: &Place| hall.in_world([place[0], place[1]]));
            let hung: Vec<[f64; 2]> = in_world.filter(is_free).collect();
            let free = words[laid_out.len()..].iter();
            laid_out.extend(
                free.zip(hung).map(|(word, [x_m, y_m])| Marker {
                    rotation_deg: hall.heading_deg,
                    ..Marker::new(word.0, x_m, y_m)
                }),
            );
        }
        if let Some(markers) = &mut self.markers {
            markers.laid_out = laid_out;
        }
        Ok(())
    }
}
