//! The tile joint detection of paper 1 (Lv et al. 2019, section 3.1), step by step.
//!
//! ```text
//! image ──> deblur ──> edges (Canny, closed) ──> thinning ──> pruning ──> Hough (11)–(13) ──> clustering (14) ──> FloorLines
//! ```
//!
//! The paper rejects lines that are no joints later, by odometry (20). Here, lines that are neither parallel nor orthogonal to the
//! strongest line are dropped already, so that the claims of this chain can be compared with those of the direct chain.

mod clustering;
mod deblur;
mod edges;
mod hough;
mod pruning;
mod thinning;

use std::f64::consts::{FRAC_PI_2, PI};

use image::GrayImage;

use self::hough::Peak;
use super::{FloorLine, FloorLines, FloorView};

/// Binary image of white and black pixels, row-major, with a black frame one pixel wide.
struct Binary {
    width: usize,
    height: usize,
    pixels: Vec<bool>,
}

impl Binary {
    fn new(image: &GrayImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let inside = |index: usize| {
            let (u, v) = (index % width, index / width);
            u > 0 && v > 0 && u + 1 < width && v + 1 < height
        };
        let pixels = image.as_raw().iter().enumerate().map(|(index, &grey)| grey > 0 && inside(index)).collect();
        Binary { width, height, pixels }
    }

    /// Indices of the eight pixels around a pixel inside of the frame, clockwise from the pixel above.
    fn around(&self, index: usize) -> [usize; 8] {
        let (up, down) = (index - self.width, index + self.width);
        [up, up + 1, index + 1, down + 1, down, down - 1, index - 1, up - 1]
    }

    fn neighbours(&self, index: usize) -> [bool; 8] {
        self.around(index).map(|near| self.pixels[near])
    }

    fn white_neighbours(&self, index: usize) -> Vec<usize> {
        self.around(index).into_iter().filter(|&near| self.pixels[near]).collect()
    }
}

/// Claimed greatest distance of a line's points from the joint's centre line, for the quantisation of r and ϑ, rounding of the skeleton to
/// pixels, and the pull of spurs. The greatest distance on 1100 lines of plain floors was 2.4 px.
const BOUND_PX: f64 = 3.0;
/// Growth of the claimed bound per pixel of motion that rotation adds at the image's corners, because a single
/// point-spread function does not remove that motion.
const BOUND_PER_TURN: f64 = 0.25;
/// Least number of Hough votes of a line that may be a tile joint, as a share of the image's shorter side; a stretch of wire or the rim of a stain
/// has fewer votes.
const VOTES_SHARE: f64 = 0.25;
/// Distance from a line within which pixels of the skeleton count as support for that line; the skeleton of a tile joint's band departs from the
/// joint's centre line by no more.
const SUPPORT_PX: f64 = 3.0;
/// A line is taken for a tile joint only if its angle against the strongest line is within this of 0° or 90°.
const FAMILY_RAD: f64 = 0.035;

/// Finds the joints in an image of a tiled floor by the processing chain of paper 1; the arguments are those of
/// [`direct::detect`](super::direct::detect).
///
/// The deconvolution uses one point-spread function, that of the image's centre; the rotation `turn_rad` widens the bounds instead.
pub fn detect(image: &GrayImage, view: &FloorView, blur_px: [f64; 2], turn_rad: f64) -> FloorLines {
    let shorter_px = f64::from(image.width().min(image.height()));
    let border_px = deblur::taper_px(blur_px);
    if shorter_px < 4.0 * border_px as f64 {
        return FloorLines::default();
    }
    let Ok(restored) = deblur::deblurred(image, blur_px) else { return FloorLines::default() };
    let bands = edges::bands(&restored, view.joint_width_px, border_px);
    let skeleton = pruning::pruned(thinning::skeleton(Binary::new(&bands)));
    let peaks = hough::peaks(&skeleton, (VOTES_SHARE * shorter_px) as u32);
    let mut result = FloorLines::default();
    let mut kept: Vec<(Peak, u8)> = Vec::new();
    for peak in clustering::clustered(&peaks) {
        let Some(ends) = ends(&skeleton, &peak) else { continue };
        match family(&peak, &kept, view) {
            Some(family) => {
                kept.push((peak, family));
                result.lines.push(line(image, ends, turn_rad, family));
            }
            None => result.rejected_px.push([ends[0][0], ends[0][1], ends[1][0], ends[1][1]]),
        }
    }
    result
}

/// The line through the two outermost of its supporting pixels, as three points with the claimed bound of their distance from a tile joint.
fn line(image: &GrayImage, ends: [[f64; 2]; 2], turn_rad: f64, family: u8) -> FloorLine {
    let reach_px = 0.5 * f64::from(image.width()).hypot(f64::from(image.height()));
    let bound_px = BOUND_PX + BOUND_PER_TURN * turn_rad.abs() * reach_px;
    let middle = [0, 1].map(|axis| 0.5 * (ends[0][axis] + ends[1][axis]));
    let points_px = [ends[0], middle, ends[1]].map(|[u, v]| [u, v, bound_px]).to_vec();
    FloorLine { points_px, share_wrong: 0.0, family }
}

/// First and last point on a line that pixels of the skeleton support; `None` if these pixels cover less than half of
/// the distance between the two points.
fn ends(skeleton: &Binary, peak: &Peak) -> Option<[[f64; 2]; 2]> {
    let (sin, cos) = peak.angle_rad.sin_cos();
    let mut along: Vec<f64> = (0..skeleton.pixels.len())
        .filter(|&index| skeleton.pixels[index])
        .map(|index| ((index % skeleton.width) as f64, (index / skeleton.width) as f64))
        .filter(|(u, v)| (u * cos + v * sin - peak.r_px).abs() < SUPPORT_PX)
        .map(|(u, v)| v * cos - u * sin)
        .collect();
    along.sort_by(f64::total_cmp);
    let (from, to) = (*along.first()?, *along.last()?);
    let covered = along.windows(2).map(|pair| (pair[1] - pair[0]).min(2.0)).sum::<f64>();
    let point = |along: f64| [peak.r_px * cos - along * sin, peak.r_px * sin + along * cos];
    (covered > 0.5 * (to - from)).then(|| [point(from), point(to)])
}

/// Which of the two families of parallel tile joints a line belongs to, given the stronger lines. `None` if the line fits neither family, or its
/// distance from a line of its family is no multiple of the joints' pitch.
fn family(peak: &Peak, kept: &[(Peak, u8)], view: &FloorView) -> Option<u8> {
    let Some((strongest, _)) = kept.first() else { return Some(0) };
    let quarter_turns = (peak.angle_rad - strongest.angle_rad) / FRAC_PI_2;
    let askew_rad = (quarter_turns - quarter_turns.round()) * FRAC_PI_2;
    let family = quarter_turns.round().rem_euclid(2.0) as u8;
    let at_pitch = kept.iter().filter(|other| other.1 == family).all(|(other, _)| {
        let flipped = ((peak.angle_rad - other.angle_rad) / PI).round().rem_euclid(2.0) == 1.0;
        let apart_px = (if flipped { -peak.r_px } else { peak.r_px } - other.r_px).abs();
        // The distances of the two lines are counted along perpendiculars with different feet. If the lines' angles differ by the tolerance, that
        // shifts the difference of distances by up to a tenth of a pitch.
        view.edge_px.iter().any(|edge| (apart_px - (apart_px / edge).round().max(1.0) * edge).abs() < 0.1 * edge)
    });
    (askew_rad.abs() < FAMILY_RAD && at_pitch).then_some(family)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;
    use crate::vision::trial::{Tally, frames, plain_floor, save};

    #[test]
    fn the_papers_chain_finds_the_joints_of_plain_floors_within_its_bound() {
        let mut random = Random::new(3);
        let mut tally = Tally::default();
        for frame in 0..frames(20) {
            let mut floor = plain_floor(&mut random);
            floor.blur_px = [random.between(-5.0, 5.0), random.between(-5.0, 5.0)];
            floor.turn_rad = random.between(-0.01, 0.01);
            let (picture, found, good) = tally.add(detect, &floor, &mut random);
            if !good {
                save(&format!("paper_{frame}"), &picture, &found, &floor);
            }
        }
        tally.print("paper, plain");
        assert_eq!((tally.wrong_lines, tally.false_claims, tally.missed_sets), (0, 0, 0));
    }
}
