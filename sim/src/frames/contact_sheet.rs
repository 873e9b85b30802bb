//! Contact sheets: a still pose seen by each camera in different light, and single pictures made legible.

use image::{GrayImage, Luma, Rgb, RgbImage, imageops};

use super::{
    canvas::{Canvas, Panel},
    palette,
};
use crate::still::Still;

const MARGIN_PX: f64 = 20.0;
const GAP_PX: f64 = 12.0;
const HEADER_PX: f64 = 62.0;
const CAPTION_PX: f64 = 46.0;
const NAMES_PX: f64 = 92.0;
const CELL_WIDTH_PX: f64 = 400.0;
const TITLE_PX: f32 = 24.0;
const TEXT_PX: f32 = 16.0;

/// What is seen in one light.
pub struct Column {
    /// Mean illuminance at the floor.
    pub illuminance_at_floor_lux: f64,
    /// One picture per camera, the same cameras in every column.
    pub stills: Vec<Still>,
}

/// A picture as a screen shows it: between its darkest and brightest half percent, with a screen's gamma.
pub fn tone_mapped(image: &GrayImage) -> GrayImage {
    let mut counts = [0_usize; 256];
    image.as_raw().iter().for_each(|level| counts[usize::from(*level)] += 1);
    let total = image.as_raw().len();
    let quantile = |share: f64| {
        let mut below = 0;
        let found = counts.iter().position(|count| {
            below += count;
            below as f64 > share * total as f64
        });
        found.unwrap_or(255) as f64
    };
    let (black, white) = (quantile(0.005), quantile(0.995));
    let shown = |level: u8| {
        let share = ((f64::from(level) - black) / (white - black).max(1.0)).clamp(0.0, 1.0);
        (255.0 * share.powf(1.0 / 2.2)).round() as u8
    };
    let mut toned = image.clone();
    toned.pixels_mut().for_each(|Luma([level])| *level = shown(*level));
    toned
}

/// Draws a sheet: a row for each camera, a column for each light.
pub fn contact_sheet(title: &str, columns: &[Column]) -> RgbImage {
    let Some(first) = columns.first() else { return RgbImage::new(1, 1) };
    let heights_px: Vec<f64> = first
        .stills
        .iter()
        .map(|still| (CELL_WIDTH_PX * f64::from(still.image.height()) / f64::from(still.image.width())).round())
        .collect();
    let width_px = 2.0 * MARGIN_PX + NAMES_PX + columns.len() as f64 * (CELL_WIDTH_PX + GAP_PX) - GAP_PX;
    let height_px = HEADER_PX + heights_px.iter().map(|height_px| height_px + CAPTION_PX).sum::<f64>() + MARGIN_PX;
    let mut canvas = Canvas::new(width_px as u32, height_px as u32, palette::PAPER);
    canvas.text([MARGIN_PX, 16.0], TITLE_PX, palette::INK, title);
    for (index, column) in columns.iter().enumerate() {
        let left_px = MARGIN_PX + NAMES_PX + index as f64 * (CELL_WIDTH_PX + GAP_PX);
        let mut top_px = HEADER_PX;
        for (still, height_px) in column.stills.iter().zip(&heights_px) {
            let panel = Panel { left_px, top_px, width_px: CELL_WIDTH_PX, height_px: *height_px };
            paint(&mut canvas, panel, &tone_mapped(&still.image));
            if index == 0 {
                let place = [MARGIN_PX, top_px + 4.0];
                canvas.text(place, 1.25 * TEXT_PX, palette::INK, still.camera.as_str());
            }
            caption(&mut canvas, [left_px, top_px + height_px + 6.0], column, still);
            top_px += height_px + CAPTION_PX;
        }
    }
    canvas.image
}

fn caption(canvas: &mut Canvas, [left_px, top_px]: [f64; 2], column: &Column, still: &Still) {
    let levels: f64 = still.levels.as_raw().iter().map(|level| f64::from(*level)).sum();
    let mean = levels / still.levels.as_raw().len() as f64 - still.sensor.black_level;
    let electrons = mean / still.exposure.gain_levels_per_electron;
    let lux = format!("{} lx", column.illuminance_at_floor_lux);
    canvas.text([left_px, top_px], TEXT_PX, palette::INK, &lux);
    let how = format!(
        "{:.2} ms, gain {:.3}, mean {electrons:.1} e",
        still.exposure.exposure_s * 1e3,
        still.exposure.gain_levels_per_electron
    );
    let right_px = left_px + CELL_WIDTH_PX - Canvas::text_width_px(TEXT_PX, &how);
    canvas.text([right_px, top_px], TEXT_PX, palette::FAINT_INK, &how);
}

fn paint(canvas: &mut Canvas, panel: Panel, pixels: &GrayImage) {
    let (width_px, height_px) = (panel.width_px as u32, panel.height_px as u32);
    let scaled = imageops::resize(pixels, width_px, height_px, imageops::FilterType::Triangle);
    for (u, v, Luma([level])) in scaled.enumerate_pixels() {
        canvas.image.put_pixel(panel.left_px as u32 + u, panel.top_px as u32 + v, Rgb([*level; 3]));
    }
}
