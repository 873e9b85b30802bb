//! Contact sheets: pictures that each camera takes from one pose of the robot at rest, under different light.

use image::{GrayImage, Luma, Rgb, RgbImage, imageops};
use localizer::reading::Camera;

use super::{
    canvas::{Canvas, Panel},
    palette,
    tones::tone_mapped,
};
use crate::{render::DeepImage, run::sensors::still::Still, scene::SensorModel};

const MARGIN_PX: f64 = 20.0;
const GAP_PX: f64 = 12.0;
const HEADER_PX: f64 = 62.0;
const CAPTION_PX: f64 = 62.0;
const LINE_PX: f64 = 20.0;
const NAMES_PX: f64 = 92.0;
const CELL_WIDTH_PX: f64 = 400.0;
const TITLE_PX: f32 = 24.0;
const TEXT_PX: f32 = 16.0;

/// The pictures taken in one light, which fill one column of a contact sheet.
pub struct Column {
    /// Mean illuminance at the floor.
    pub illuminance_at_floor_lux: f64,
    /// One picture for each camera; every column has the same cameras in the same order.
    pub stills: Vec<Still>,
}

/// The picture with an equalised histogram: each grey level is mapped to the share of pixels below it plus half the share of pixels at it,
/// so that an image of a few photons per pixel uses the full range of greys.
fn equalised(levels: &DeepImage) -> GrayImage {
    let mut counts = vec![0_usize; 1 << 16];
    levels.as_raw().iter().for_each(|level| counts[usize::from(*level)] += 1);
    let total = levels.as_raw().len().max(1) as f64;
    let mut below = 0.0;
    let shown: Vec<u8> = counts
        .iter()
        .map(|count| {
            let middle = below + *count as f64 / 2.0;
            below += *count as f64;
            (255.0 * middle / total).round() as u8
        })
        .collect();
    GrayImage::from_fn(levels.width(), levels.height(), |u, v| Luma([shown[usize::from(levels.get_pixel(u, v).0[0])]]))
}

/// A row of a contact sheet: the pictures of one camera in every light.
struct Row {
    still: usize,
    equalised: bool,
    height_px: f64,
}

/// One row for each camera, and a second row with an equalised histogram for the forward camera.
fn rows(stills: &[Still]) -> Vec<Row> {
    let row = |(index, still): (usize, &Still), equalised: bool| {
        let height_px = (CELL_WIDTH_PX * f64::from(still.image.height()) / f64::from(still.image.width())).round();
        Row { still: index, equalised, height_px }
    };
    let ahead = |still: &Still| still.camera == Camera::Forward;
    let plain = stills.iter().enumerate().map(|place| row(place, false));
    plain.chain(stills.iter().enumerate().filter(|(_, still)| ahead(still)).map(|place| row(place, true))).collect()
}

/// Draws a contact sheet: a row for each camera and a column for each light, and for the forward camera a second row with an equalised histogram.
pub fn contact_sheet(title: &str, columns: &[Column]) -> RgbImage {
    let Some(first) = columns.first() else { return RgbImage::new(1, 1) };
    let rows = rows(&first.stills);
    let width_px = 2.0 * MARGIN_PX + NAMES_PX + columns.len() as f64 * (CELL_WIDTH_PX + GAP_PX) - GAP_PX;
    let height_px = HEADER_PX + rows.iter().map(|row| row.height_px + CAPTION_PX).sum::<f64>() + MARGIN_PX;
    let mut canvas = Canvas::new(width_px as u32, height_px as u32, palette::PAPER);
    canvas.text([MARGIN_PX, 16.0], TITLE_PX, palette::INK, title);
    for (index, column) in columns.iter().enumerate() {
        let left_px = MARGIN_PX + NAMES_PX + index as f64 * (CELL_WIDTH_PX + GAP_PX);
        let mut top_px = HEADER_PX;
        for Row { still, equalised: even, height_px } in &rows {
            let still = &column.stills[*still];
            let panel = Panel { left_px, top_px, width_px: CELL_WIDTH_PX, height_px: *height_px };
            paint(&mut canvas, panel, &if *even { equalised(&still.levels) } else { tone_mapped(&still.levels) });
            if index == 0 {
                let place = [MARGIN_PX, top_px + 4.0];
                canvas.text(place, 1.25 * TEXT_PX, palette::INK, still.camera.as_str());
                if *even {
                    canvas.text([place[0], place[1] + 24.0], TEXT_PX, palette::INK, "equalised");
                }
            }
            caption(&mut canvas, [left_px, top_px + height_px + 6.0], column, still);
            top_px += height_px + CAPTION_PX;
        }
    }
    canvas.image
}

fn caption(canvas: &mut Canvas, [left_px, top_px]: [f64; 2], column: &Column, still: &Still) {
    let lux = format!("{} lx", column.illuminance_at_floor_lux);
    canvas.text([left_px, top_px], TEXT_PX, palette::INK, &lux);
    let gain = still.exposure.gain_levels_per_electron;
    let how = format!("{:.2} ms, gain {gain:.3}", still.exposure.exposure_s * 1e3);
    let right_px = |text: &str| left_px + CELL_WIDTH_PX - Canvas::text_width_px(TEXT_PX, text);
    canvas.text([right_px(&how), top_px], TEXT_PX, palette::FAINT_INK, &how);
    let mean = mean(&still.levels, &still.sensor, gain);
    canvas.text([right_px(&mean), top_px + LINE_PX], TEXT_PX, palette::FAINT_INK, &mean);
}

/// Text that gives the mean of a picture in electrons and, where clipped pixels bias that mean, their share at either end. Dark noise that
/// is clipped at level 0 makes the mean too great; light that is clipped at the greatest level makes it too small.
fn mean(levels: &DeepImage, sensor: &SensorModel, gain_levels_per_electron: f64) -> String {
    const BIASING_SHARE: f64 = 0.005;
    let count = levels.as_raw().len().max(1) as f64;
    let sum: f64 = levels.as_raw().iter().map(|level| f64::from(*level)).sum();
    let mut text = format!("mean {:.1} e", (sum / count - sensor.black_level) / gain_levels_per_electron);
    for end in [0, sensor.bits.greatest_level()] {
        let share = levels.as_raw().iter().filter(|level| u32::from(**level) == end).count() as f64 / count;
        if share > BIASING_SHARE {
            text += &format!(", {:.0} % at {end}", (100.0 * share).max(1.0));
        }
    }
    text
}

fn paint(canvas: &mut Canvas, panel: Panel, pixels: &GrayImage) {
    let (width_px, height_px) = (panel.width_px as u32, panel.height_px as u32);
    let scaled = imageops::resize(pixels, width_px, height_px, imageops::FilterType::Triangle);
    for (u, v, Luma([level])) in scaled.enumerate_pixels() {
        canvas.image.put_pixel(panel.left_px as u32 + u, panel.top_px as u32 + v, Rgb([*level; 3]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SensorPreset;

    #[test]
    fn an_even_histogram_gives_each_level_the_share_of_pixels_below_it() {
        // Half of the pixels are at level 3, a quarter each at 4 and 200: the middles of their cumulative shares are 1/4, 5/8 and 7/8.
        let image = DeepImage::from_fn(4, 1, |u, _| Luma([[3, 4, 3, 200][u as usize]]));
        assert_eq!(equalised(&image).as_raw(), &[64, 159, 64, 223]);
    }

    #[test]
    fn a_mean_tells_what_is_cut_off() {
        let sensor = SensorModel { black_level: 0.0, ..SensorPreset::GlobalShutter.model() };
        let picture =
            |at: u16, of_hundred: u32| DeepImage::from_fn(100, 1, |u, _| Luma([if u < of_hundred { at } else { 20 }]));
        assert_eq!(mean(&picture(7, 0), &sensor, 2.0), "mean 10.0 e");
        assert_eq!(mean(&picture(0, 11), &sensor, 2.0), "mean 8.9 e, 11 % at 0");
        assert_eq!(mean(&picture(255, 2), &sensor, 2.0), "mean 12.3 e, 2 % at 255");
    }
}
