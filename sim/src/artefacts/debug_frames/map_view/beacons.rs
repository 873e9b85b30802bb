//! What the localizer finds its way by besides the floor and the walls: ceiling markers, and landmarks with the boxes in which they were learnt.

use interval::Interval;
use localizer::reading::LandmarkId;

use crate::{place::drawn::DrawnMarker, run::RunRecord, scene::Scene};

use super::{super::canvas::Canvas, MapView, palette};

/// Half the side of a marker's film: the outer dots lie 6 cm from its middle, and the film has an edge of 2 cm around them.
const MARKER_HALF_M: f64 = 0.08;
/// Least half side of a drawn marker, so that it can be seen in the view of a whole flat.
const MARKER_HALF_PX: f64 = 4.0;
/// Greatest number of markers in a view whose identities are written beside them; more would cover each other.
const MOST_NAMED: usize = 40;

/// The boxes in which the localizer had learnt by a time that landmarks lie; none before it saw one.
pub(in super::super) fn learnt_by(record: &RunRecord, time_s: f64) -> &[(LandmarkId, [Interval; 2])] {
    let seen =
        record.images.iter().take_while(|image| image.measured_s <= time_s).filter(|image| !image.landmarks.is_empty());
    seen.last().map_or(&[], |image| &image.landmarks)
}

impl MapView {
    /// Draws the ceiling markers where they stand on the map, with a stroke in the direction from dot O to dot X: filled where one is truly pasted
    /// there (`drawn`, where the truth is known), hollow where it has fallen off or was put elsewhere, grey where the localizer's map does not have it.
    pub(in super::super) fn draw_markers(&self, canvas: &mut Canvas, scene: &Scene, drawn: Option<&[DrawnMarker]>) {
        let Some(markers) = &scene.markers else { return };
        let half_px = (MARKER_HALF_M * self.pixels_per_m).max(MARKER_HALF_PX);
        canvas.clipped(self.panel, |canvas| {
            for (index, marker) in markers.all().iter().enumerate() {
                let colour = if marker.on_map { palette::MARKER } else { palette::FAINT_INK };
                let (sin, cos) = marker.rotation_deg.to_radians().sin_cos();
                let middle = self.place([marker.x_m, marker.y_m]);
                // Pixels count downwards, the world's y axis upwards.
                let at = |along: f64, across: f64| {
                    let (along, across) = (along * half_px, across * half_px);
                    [middle[0] + along * cos - across * sin, middle[1] - along * sin - across * cos]
                };
                let corners = [at(1.0, 1.0), at(-1.0, 1.0), at(-1.0, -1.0), at(1.0, -1.0)];
                let is_moved = marker.misplaced_m != [0.0, 0.0];
                if !is_moved && drawn.is_none_or(|drawn| drawn.iter().any(|one| one.index == index)) {
                    canvas.fill(&corners, colour, 0.35);
                }
                canvas.outline(&corners, 1.2, colour);
                canvas.line(middle, at(1.6, 0.0), 1.2, colour);
                let name_at = [middle[0] + half_px + 3.0, middle[1] - half_px - 10.0];
                // Text is not clipped.
                if markers.all().len() <= MOST_NAMED && self.panel.contains(middle) {
                    canvas.text(name_at, 12.0, colour, &marker.id.to_string());
                }
            }
        });
    }

    /// Draws landmarks at their true positions, and the boxes in which the localizer has learnt that they lie; a box is red when its landmark is not
    /// in it.
    pub(in super::super) fn draw_landmarks(
        &self,
        canvas: &mut Canvas,
        scene: &Scene,
        learnt: &[(LandmarkId, [Interval; 2])],
    ) {
        canvas.clipped(self.panel, |canvas| {
            for (code, [x, y]) in learnt {
                let Some(truth) = scene.landmarks.get(code.0 as usize) else { continue };
                let is_inside = x.contains(truth.x_m) && y.contains(truth.y_m);
                let colour = if is_inside { palette::BOX } else { palette::MISS };
                let corners = self.rectangle([x.lo(), x.hi()], [y.lo(), y.hi()]);
                canvas.fill(&corners, colour, 0.2);
                canvas.outline(&corners, 1.2, colour);
            }
            for landmark in &scene.landmarks {
                canvas.ring(self.place([landmark.x_m, landmark.y_m]), 2.5, 2.5, palette::TRUTH);
            }
        });
    }
}
