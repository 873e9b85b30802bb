//! The map of a log's replay: the boxes of the estimates, and the true path where it is known, on the plan of the rooms.

use image::RgbImage;
use localizer::{Estimate, Pose};

use crate::{place::building::GroundPlan, scene::Scene};

use super::{
    canvas::{Canvas, Panel},
    map_view::MapView,
    palette,
};

const WIDTH_PX: f64 = 1200.0;
const HEADER_PX: f64 = 44.0;

/// Greatest number of estimates whose boxes are drawn: more would cover each other.
const MOST_BOXES: usize = 120;

/// Draws the map. `truths` are true poses with their times.
pub(crate) fn draw(scene: &Scene, estimates: &[Estimate], truths: &[(f64, Pose)]) -> RgbImage {
    let [[x0_m, y0_m], [x1_m, y1_m]] = GroundPlan::of(scene).extents_m();
    let height_px = (WIDTH_PX * ((y1_m - y0_m) / (x1_m - x0_m)).min(1.5)).round() + 40.0;
    let mut canvas = Canvas::new(WIDTH_PX as u32, (HEADER_PX + height_px) as u32, palette::PAPER);
    let panel = Panel { left_px: 0.0, top_px: HEADER_PX, width_px: WIDTH_PX, height_px };
    let view = MapView::rooms(panel, scene);
    view.draw_floor(&mut canvas, scene, None);
    view.draw_things(&mut canvas, scene);
    view.draw_markers(&mut canvas, scene, None);
    view.draw_landmarks(&mut canvas, scene, &[]);
    let middles = estimates.iter().filter(|estimate| !estimate.pose.is_empty()).map(|estimate| {
        let [x_m, y_m, _] = estimate.pose.hull().midpoint();
        [x_m, y_m]
    });
    view.draw_path(&mut canvas, &middles.collect::<Vec<_>>(), palette::ROUTE);
    for estimate in estimates.iter().step_by(estimates.len().div_ceil(MOST_BOXES).max(1)) {
        view.draw_union(&mut canvas, &estimate.pose);
    }
    let path: Vec<[f64; 2]> = truths.iter().map(|(_, pose)| [pose.x_m, pose.y_m]).collect();
    view.draw_path(&mut canvas, &path, palette::TRUTH);
    view.draw_scale(&mut canvas);
    let legend = [
        (palette::BOX, "boxes", true),
        (palette::ROUTE, "their middles", true),
        (palette::TRUTH, "true path", !truths.is_empty()),
        (palette::MARKER, "ceiling markers", scene.markers.is_some()),
    ];
    let mut left_px = 14.0;
    for (colour, text, _) in legend.into_iter().filter(|(.., is_shown)| *is_shown) {
        canvas.line([left_px, 22.0], [left_px + 24.0, 22.0], 4.0, colour);
        canvas.text([left_px + 32.0, 12.0], 18.0, palette::INK, text);
        left_px += 32.0 + Canvas::text_width_px(18.0, text) + 28.0;
    }
    canvas.image
}
