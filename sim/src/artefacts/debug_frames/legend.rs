//! The legend of a figure: what each colour stands for.

use image::Rgb;

use super::{
    canvas::{Canvas, Panel},
    palette,
};

/// One line of colour with what it stands for.
pub(super) struct Entry {
    pub(super) colour: Rgb<u8>,
    pub(super) text: String,
}

/// Draws entries from left to right into a panel; those that do not fit into a line go into the next one below.
pub(super) fn draw_legend(canvas: &mut Canvas, panel: Panel, text_px: f32, entries: &[Entry]) {
    // The proportions of the figures' legend: a text of 18 pixels beside a stroke of 26, in lines of 26.
    let unit_px = f64::from(text_px) / 18.0;
    let (mut left_px, mut top_px) = (panel.left_px, panel.top_px);
    for Entry { colour, text } in entries {
        let width_px = 34.0 * unit_px + Canvas::text_width_px(text_px, text);
        if left_px + width_px > panel.left_px + panel.width_px {
            (left_px, top_px) = (panel.left_px, top_px + 26.0 * unit_px);
        }
        let middle_px = top_px + 9.0 * unit_px;
        canvas.line([left_px, middle_px], [left_px + 26.0 * unit_px, middle_px], 4.0 * unit_px, *colour);
        canvas.text([left_px + 34.0 * unit_px, top_px], text_px, palette::INK, text);
        left_px += width_px + 28.0 * unit_px;
    }
}
