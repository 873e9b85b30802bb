//! Antialiased drawing on an image: text, and one filled convex shape from which lines and arrows are made.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, ScaleFont, point};
use image::{Rgb, RgbImage};

/// The font DejaVu Sans, reduced to the characters of Latin-1 and a few signs; its licence lies in the same folder.
const FONT: &[u8] = include_bytes!("DejaVuSans-subset.ttf");

/// A rectangle of pixels that includes its left and top edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// Left edge of the panel.
    pub(super) left_px: f64,
    /// Top edge of the panel.
    pub(super) top_px: f64,
    /// Width of the panel, to the right of its left edge.
    pub(super) width_px: f64,
    /// Height of the panel, downwards from its top edge.
    pub(super) height_px: f64,
}

impl Panel {
    /// Whether a point lies in the panel.
    pub(super) fn contains(&self, [left_px, top_px]: [f64; 2]) -> bool {
        (0.0..self.width_px).contains(&(left_px - self.left_px))
            && (0.0..self.height_px).contains(&(top_px - self.top_px))
    }
}

/// An image that is being drawn on.
#[derive(Clone)]
pub(super) struct Canvas {
    /// The image with everything that has been drawn on it.
    pub(super) image: RgbImage,
    clip: Panel,
}

impl Canvas {
    /// Creates a canvas that is filled with one colour.
    pub(super) fn new(width_px: u32, height_px: u32, colour: Rgb<u8>) -> Canvas {
        let clip = Panel { left_px: 0.0, top_px: 0.0, width_px: f64::from(width_px), height_px: f64::from(height_px) };
        Canvas { image: RgbImage::from_pixel(width_px, height_px, colour), clip }
    }

    /// Runs `draw` with all drawing confined to `panel`.
    pub(super) fn clipped(&mut self, panel: Panel, draw: impl FnOnce(&mut Canvas)) {
        let before = std::mem::replace(&mut self.clip, panel);
        draw(self);
        self.clip = before;
    }

    /// Fills a convex polygon, whose corners may go round in either sense. `opacity` is from 0 to 1.
    pub(super) fn fill(&mut self, corners_px: &[[f64; 2]], colour: Rgb<u8>, opacity: f64) {
        let n = corners_px.len();
        let doubled_area: f64 = (0..n).map(|i| cross(corners_px[i], corners_px[(i + 1) % n])).sum();
        if doubled_area == 0.0 {
            return;
        }
        // Each side of the polygon with its inward normal of length 1. A pixel is covered by the share of it that lies on the inner side of
        // all sides.
        let sides: Vec<([f64; 2], [f64; 2])> = (0..n)
            .filter_map(|i| {
                let (from, to) = (corners_px[i], corners_px[(i + 1) % n]);
                let (du, dv) = (to[0] - from[0], to[1] - from[1]);
                let length = du.hypot(dv) * doubled_area.signum();
                (length != 0.0).then(|| (from, [-dv / length, du / length]))
            })
            .collect();
        self.shade(corners_px, colour, |pixel| {
            let inside =
                |(at, normal): &([f64; 2], [f64; 2])| (pixel[0] - at[0]) * normal[0] + (pixel[1] - at[1]) * normal[1];
            let depth_px = sides.iter().map(inside).fold(f64::INFINITY, f64::min);
            opacity * (depth_px + 0.5).clamp(0.0, 1.0)
        });
    }

    /// Draws a straight line.
    pub(super) fn line(&mut self, from_px: [f64; 2], to_px: [f64; 2], width_px: f64, colour: Rgb<u8>) {
        let (du, dv) = (to_px[0] - from_px[0], to_px[1] - from_px[1]);
        let length = du.hypot(dv);
        if length == 0.0 {
            return;
        }
        let across = [-dv / length * width_px / 2.0, du / length * width_px / 2.0];
        let shifted = |at: [f64; 2], sign: f64| [at[0] + sign * across[0], at[1] + sign * across[1]];
        let corners = [shifted(from_px, 1.0), shifted(to_px, 1.0), shifted(to_px, -1.0), shifted(from_px, -1.0)];
        self.fill(&corners, colour, 1.0);
    }

    /// Draws a closed polygon's outline.
    pub(super) fn outline(&mut self, corners_px: &[[f64; 2]], width_px: f64, colour: Rgb<u8>) {
        for (index, corner) in corners_px.iter().enumerate() {
            self.line(*corner, corners_px[(index + 1) % corners_px.len()], width_px, colour);
        }
    }

    /// Draws a disc, or a ring when `width_px`, the width of its stroke, is less than the radius.
    pub(super) fn ring(&mut self, centre_px: [f64; 2], radius_px: f64, width_px: f64, colour: Rgb<u8>) {
        let around = [
            [centre_px[0] - radius_px, centre_px[1] - radius_px],
            [centre_px[0] + radius_px, centre_px[1] + radius_px],
        ];
        self.shade(&around, colour, |pixel| {
            let distance_px = (pixel[0] - centre_px[0]).hypot(pixel[1] - centre_px[1]);
            let within = (radius_px - distance_px).min(distance_px - (radius_px - width_px));
            (within + 0.5).clamp(0.0, 1.0)
        });
    }

    /// Draws an arrow with its head at `to_px`.
    pub(super) fn arrow(&mut self, from_px: [f64; 2], to_px: [f64; 2], width_px: f64, colour: Rgb<u8>) {
        let (du, dv) = (to_px[0] - from_px[0], to_px[1] - from_px[1]);
        let length = du.hypot(dv);
        if length == 0.0 {
            return;
        }
        let (along, head_px) = ([du / length, dv / length], (5.0 * width_px).min(length));
        let at = |back: f64, aside: f64| {
            [to_px[0] - back * along[0] - aside * along[1], to_px[1] - back * along[1] + aside * along[0]]
        };
        self.line(from_px, at(head_px * 0.8, 0.0), width_px, colour);
        self.fill(&[to_px, at(head_px, head_px * 0.45), at(head_px, -head_px * 0.45)], colour, 1.0);
    }

    /// Writes a line of text whose top-left corner is at `at_px`.
    pub(super) fn text(&mut self, at_px: [f64; 2], height_px: f32, colour: Rgb<u8>, text: &str) {
        let Some(font) = font() else { return };
        let scaled = font.as_scaled(height_px);
        // Placing the text at whole pixels keeps horizontal strokes crisp.
        let baseline_px = (at_px[1] as f32 + scaled.ascent()).round();
        let mut pen_px = at_px[0].round() as f32;
        for character in text.chars() {
            let id = scaled.glyph_id(character);
            let glyph = id.with_scale_and_position(height_px, point(pen_px, baseline_px));
            pen_px += scaled.h_advance(id);
            let Some(outline) = font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|u, v, coverage| {
                let (u, v) = (corner.x + u as f32, corner.y + v as f32);
                if u >= 0.0 && v >= 0.0 {
                    self.blend(u as u32, v as u32, colour, f64::from(coverage));
                }
            });
        }
    }

    /// Width of a line of text in pixels.
    pub(super) fn text_width_px(height_px: f32, text: &str) -> f64 {
        let Some(font) = font() else { return 0.0 };
        let scaled = font.as_scaled(height_px);
        f64::from(text.chars().map(|character| scaled.h_advance(scaled.glyph_id(character))).sum::<f32>())
    }

    /// Blends `colour` into every pixel of the rectangle around `corners_px`, to the share that `coverage` gives for the pixel's centre.
    fn shade(&mut self, corners_px: &[[f64; 2]], colour: Rgb<u8>, coverage: impl Fn([f64; 2]) -> f64) {
        let range = |axis: usize, start_px: f64, extent_px: f64| {
            let least = corners_px.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min) - 1.0;
            let greatest = corners_px.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max) + 1.0;
            // The cast to an unsigned integer cuts negative positions off at 0, where the image begins.
            let end_px = (start_px + extent_px).min(f64::from([self.image.width(), self.image.height()][axis]));
            least.max(start_px).max(0.0).ceil() as u32..(greatest + 1.0).min(end_px).max(0.0) as u32
        };
        let clip = self.clip;
        let columns = range(0, clip.left_px, clip.width_px);
        for v in range(1, clip.top_px, clip.height_px) {
            for u in columns.clone() {
                self.blend(u, v, colour, coverage([f64::from(u), f64::from(v)]));
            }
        }
    }

    /// Blends `colour` into a share of one pixel; nothing happens outside the image.
    fn blend(&mut self, u: u32, v: u32, colour: Rgb<u8>, share: f64) {
        if share <= 0.0 {
            return;
        }
        if let Some(pixel) = self.image.get_pixel_mut_checked(u, v) {
            for (channel, target) in pixel.0.iter_mut().zip(colour.0) {
                *channel = (f64::from(*channel) * (1.0 - share) + f64::from(target) * share).round() as u8;
            }
        }
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The font, or `None` if the embedded font file is damaged: debug frames then have no text, and everything else still works.
fn font() -> Option<&'static FontRef<'static>> {
    static LOADED: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    LOADED.get_or_init(|| FontRef::try_from_slice(FONT).ok()).as_ref()
}
