//! The map of a drive: what is on the robot's map, which paths were planned for errands, what was driven, what was answered, and the markers and
//! landmarks on the way.

use image::RgbImage;

use crate::{loading::SceneFile, place::building::GroundPlan, run::RunRecord};

use super::{
    canvas::{Canvas, Panel},
    map_view::{MapView, learnt_by},
    palette,
};

const WIDTH_PX: f64 = 1200.0;
const HEADER_PX: f64 = 44.0;

/// Draws the map of a run, with its errands if it has any, and with the trail of the answers' middles if they are wanted.
pub(super) fn draw(file: &SceneFile, record: &RunRecord, with_answers: bool) -> RgbImage {
    let [[x0_m, y0_m], [x1_m, y1_m]] = GroundPlan::of(&file.scene).extents_m();
    let height_px = (WIDTH_PX * ((y1_m - y0_m) / (x1_m - x0_m)).min(1.5)).round() + 40.0;
    let mut canvas = Canvas::new(WIDTH_PX as u32, (HEADER_PX + height_px) as u32, palette::PAPER);
    let panel = Panel { left_px: 0.0, top_px: HEADER_PX, width_px: WIDTH_PX, height_px };
    let view = MapView::rooms(panel, &file.scene);
    view.draw_floor(&mut canvas, &file.scene, None);
    view.draw_things(&mut canvas, &file.scene);
    view.draw_grid(&mut canvas, &file.scene);
    view.draw_errands(&mut canvas, record, f64::INFINITY);
    view.draw_markers(&mut canvas, &file.scene, Some(&record.drawn.place.markers));
    view.draw_landmarks(&mut canvas, &file.scene, learnt_by(record, f64::INFINITY));
    view.draw_trail(&mut canvas, record, f64::INFINITY);
    if with_answers {
        view.draw_answers(&mut canvas, record);
    }
    if let Some(truth) = record.truths.last() {
        view.draw_robot(&mut canvas, &file.scene, truth.pose);
        view.draw_truth(&mut canvas, truth.pose, 30.0);
    }
    view.draw_scale(&mut canvas);
    let has_errands = record.errands.is_some();
    let legend = [
        (palette::WALL, "on the map", has_errands),
        (palette::ROUTE, if has_errands { "planned ways" } else { "route" }, true),
        (palette::TRAIL, "driven in truth", true),
        (palette::BOX, "answered", with_answers),
        (palette::TRUTH, "goals reached", has_errands),
        (palette::MISS, "goals missed", has_errands),
        (palette::MARKER, "ceiling markers", file.scene.markers.is_some()),
        (palette::TRUTH, "landmarks (dots)", !file.scene.landmarks.is_empty()),
    ];
    let mut left_px = 14.0;
    for (colour, text, _) in legend.into_iter().filter(|(.., is_shown)| *is_shown) {
        canvas.line([left_px, 22.0], [left_px + 24.0, 22.0], 4.0, colour);
        canvas.text([left_px + 32.0, 12.0], 18.0, palette::INK, text);
        left_px += 32.0 + Canvas::text_width_px(18.0, text) + 28.0;
    }
    canvas.image
}
