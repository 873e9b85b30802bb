//! The camera image as the localizer saw it: tone-mapped, with claims and rejected segments drawn over it.

use image::{
    GrayImage, Luma, Rgb,
    imageops::{self, FilterType},
};
use localizer::{Claim, markers::GridPlace};

use crate::{
    judge::{is_true, wall_line_deg},
    run::{ImageRecord, RunRecord},
    scene::Scene,
};

use super::{
    canvas::{Canvas, Panel},
    palette,
    tones::Tones,
};

/// Draws the image, the claims and the rejected segments into `panel`, which has the aspect ratio of the image.
pub(super) fn draw(
    canvas: &mut Canvas,
    panel: Panel,
    scene: &Scene,
    record: &RunRecord,
    image: &ImageRecord,
    pixels: &GrayImage,
) {
    paint(canvas, panel, &shown(pixels, panel.width_px as u32, panel.height_px as u32));
    let pens = Pens { scale: panel.width_px / f64::from(pixels.width()), stroke: 1.0 };
    draw_seen(canvas, panel, &pens, scene, record, image);
}

/// How what was seen in an image is drawn over a scaled image.
pub(super) struct Pens {
    /// Width of the scaled image over that of the image.
    pub(super) scale: f64,
    /// Width of strokes, over that in a debug figure.
    pub(super) stroke: f64,
}

/// Draws the claims and the rejected segments over the image that fills `panel`.
pub(super) fn draw_seen(
    canvas: &mut Canvas,
    panel: Panel,
    pens: &Pens,
    scene: &Scene,
    record: &RunRecord,
    image: &ImageRecord,
) {
    let Pens { scale, stroke } = *pens;
    // The centre of pixel (0, 0) lies half a pixel inside the image's corner, both in the image and in its scaled drawing.
    let place =
        |u_px: f64, v_px: f64| [panel.left_px + (u_px + 0.5) * scale - 0.5, panel.top_px + (v_px + 0.5) * scale - 0.5];
    let mut labels: Vec<[f64; 2]> = Vec::new();
    canvas.clipped(panel, |canvas| {
        for [u0, v0, u1, v1] in &image.rejected_px {
            canvas.line(place(*u0, *v0), place(*u1, *v1), 2.5 * stroke, palette::REJECTED);
        }
        for claim in &image.claims {
            let colour =
                if is_true(claim, scene, &record.drawn, &image.truth) { palette::SEEN } else { palette::FALSE };
            match claim {
                Claim::FloorJoint { points_px, .. } => joint(canvas, points_px, place, stroke, colour),
                Claim::WallLine { ends_px, bound_px } => {
                    let direction_deg = wall_line_deg(*ends_px, *bound_px, scene, &record.drawn, &image.truth);
                    edge(canvas, *ends_px, place, stroke, colour);
                    if let Some(deg) = direction_deg {
                        let [[u0, v0], [u1, v1]] = *ends_px;
                        let [left, top] = place(0.5 * (u0 + u1), 0.5 * (v0 + v1));
                        let at = below_labels(&labels, [left, top + 4.0]);
                        label(canvas, at, 15.0, stroke, colour, &format!("{:.0}°", deg.round() + 0.0));
                        labels.push(at);
                    }
                }
                Claim::UprightLine { ends_px, .. } => edge(canvas, *ends_px, place, stroke, colour),
                Claim::WallUpright { lines, .. } => {
                    lines.iter().for_each(|(ends_px, _)| edge(canvas, *ends_px, place, stroke, colour));
                }
                Claim::Marker { marker, dots_px } => marked(canvas, marker.0, dots_px, place, stroke, colour),
                Claim::SpacePoint { at_px: [u, v], .. } => {
                    let arms = [[-4.0, 0.0], [0.0, -4.0]].map(|[du, dv]| [[u - du, v - dv], [u + du, v + dv]]);
                    arms.into_iter().for_each(|ends_px| edge(canvas, ends_px, place, stroke, colour));
                }
                // Only a range reading has claims of landmarks, an image never has, so there is nothing to draw.
                Claim::Landmark { .. } | Claim::WallPoint { .. } => {}
            }
        }
    });
}

/// Writes a label beside what was seen. Beside thin strokes, as in a small picture, there is no room for labels.
fn label(canvas: &mut Canvas, at_px: [f64; 2], height_px: f32, stroke: f64, colour: Rgb<u8>, text: &str) {
    if stroke >= 1.0 {
        canvas.text(at_px, height_px, colour, text);
    }
}

/// The image tone-mapped and scaled to a size in pixels.
pub(super) fn shown(pixels: &GrayImage, width_px: u32, height_px: u32) -> GrayImage {
    let tones = Tones::of(pixels.as_raw().iter().map(|level| u16::from(*level)));
    let mut shown = pixels.clone();
    // Headroom below and above the shown grey levels keeps drawn lines apart from black and white.
    let show = |level: u8| (20.0 + 200.0 * tones.share(u16::from(level))).round() as u8;
    shown.as_mut().iter_mut().for_each(|level| *level = show(*level));
    imageops::resize(&shown, width_px, height_px, FilterType::Triangle)
}

/// Puts a picture into the panel of its size.
pub(super) fn paint(canvas: &mut Canvas, panel: Panel, picture: &GrayImage) {
    for (u, v, Luma([level])) in picture.enumerate_pixels() {
        let (left, top) = (panel.left_px as u32 + u, panel.top_px as u32 + v);
        canvas.image.put_pixel(left, top, Rgb([*level; 3]));
    }
}

/// Draws a ring around each dot of a marker, and the marker's identity beside the dots.
fn marked(
    canvas: &mut Canvas,
    id: u16,
    dots_px: &[(GridPlace, [f64; 3])],
    place: impl Fn(f64, f64) -> [f64; 2],
    stroke: f64,
    colour: Rgb<u8>,
) {
    let mut corner: Option<[f64; 2]> = None;
    for (_, [u, v, _]) in dots_px {
        let at = place(*u, *v);
        canvas.ring(at, 7.0 * stroke, 2.0 * stroke, colour);
        corner = Some(corner.map_or(at, |[left, bottom]| [left.min(at[0]), bottom.max(at[1])]));
    }
    if let Some([left, bottom]) = corner {
        label(canvas, [left, bottom + 12.0], 18.0, stroke, colour, &format!("marker {id}"));
    }
}

/// Draws a claimed edge, level or upright, as a line between its ends.
fn edge(
    canvas: &mut Canvas,
    [[u0, v0], [u1, v1]]: [[f64; 2]; 2],
    place: impl Fn(f64, f64) -> [f64; 2],
    stroke: f64,
    colour: Rgb<u8>,
) {
    canvas.line(place(u0, v0), place(u1, v1), 2.5 * stroke, colour);
}

/// Position for the text label of an edge's direction: the wanted position `at`, or the nearest one below it where the label does not cover labels
/// that are already written.
fn below_labels(labels: &[[f64; 2]], at: [f64; 2]) -> [f64; 2] {
    const SIZE_PX: [f64; 2] = [40.0, 16.0];
    let hides = |[left, top]: [f64; 2]| {
        move |other: &&[f64; 2]| (other[0] - left).abs() < SIZE_PX[0] && (other[1] - top).abs() < SIZE_PX[1]
    };
    let mut free = at;
    // Each step moves the label below one other label, so there are no more steps than labels.
    while let Some(label) = labels.iter().find(hides(free)) {
        free[1] = label[1] + SIZE_PX[1];
    }
    free
}

/// Draws the line of a claimed floor joint through the claim's points, and the points themselves.
fn joint(
    canvas: &mut Canvas,
    points_px: &[[f64; 3]],
    place: impl Fn(f64, f64) -> [f64; 2],
    stroke: f64,
    colour: Rgb<u8>,
) {
    // A distorting lens bends a floor joint into a curve, which is drawn from end to end through the means of eight groups of the joint's points.
    let mean =
        |part: &[[f64; 3]]| [0, 1].map(|axis| part.iter().map(|point| point[axis]).sum::<f64>() / part.len() as f64);
    let ends = [points_px.first(), points_px.last()].map(|end| end.map(|[u, v, _]| [*u, *v]));
    let parts = points_px.chunks(points_px.len().div_ceil(8).max(1)).map(mean);
    let knots: Vec<[f64; 2]> = ends[0].into_iter().chain(parts).chain(ends[1]).collect();
    for knot in knots.windows(2) {
        canvas.line(place(knot[0][0], knot[0][1]), place(knot[1][0], knot[1][1]), 1.6 * stroke, colour);
    }
    // More than 40 rings along a joint would run together into one line.
    let every = points_px.len().div_ceil(40).max(1);
    for point in points_px.iter().step_by(every) {
        canvas.ring(place(point[0], point[1]), 3.0 * stroke, 3.0 * stroke, colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_goes_below_those_in_its_place() {
        let labels = [[10.0, 16.0], [10.0, 0.0], [300.0, 4.0]];
        assert_eq!(below_labels(&labels, [20.0, 5.0]), [20.0, 32.0]);
        assert_eq!(below_labels(&labels, [120.0, 5.0]), [120.0, 5.0]);
    }
}
