//! The direct chain: joints are found where they are, at full resolution, without deblurring.
//!
//! ```text
//! image ──> binned_log ──> ridge_points ──> hypotheses ──> measure (profiles × matched filter) ──> agreement ──> FloorLines
//! ```
//!
//! Blur that is symmetric about mid-exposure leaves a joint's centre line where it was and only flattens its edges, so the
//! matched filter is blurred instead of the picture sharpened, and the claimed bound of a point grows with the blur.

mod agreement;
mod course;
mod joint_filter;
mod measure;
mod profile;
mod ridge;
mod vote;

use image::GrayImage;

use self::measure::{Filters, Joint};
use self::vote::Candidate;
use super::{FloorLine, FloorLines, FloorView};

/// A picture with what is known of the motion during its exposure.
struct Picture<'a> {
    pixels: &'a [u8],
    stride: usize,
    /// Middle of the picture, `[(width − 1)/2, (height − 1)/2]`.
    centre_px: [f64; 2],
    /// Image motion over the exposure at the centre.
    blur_px: [f64; 2],
    /// Rotation of the robot over the exposure, counter-clockwise seen from above.
    turn_rad: f64,
}

impl Picture<'_> {
    /// Point of the picture at a position along a line and a distance from it.
    fn point_px(&self, line: &Candidate, along_px: f64, across_px: f64) -> [f64; 2] {
        let (sin, cos) = line.normal_rad.sin_cos();
        let offset_px = line.offset_px + across_px;
        [self.centre_px[0] + offset_px * cos - along_px * sin, self.centre_px[1] + offset_px * sin + along_px * cos]
    }

    /// Motion across a line during the exposure, at a position along it.
    ///
    /// When the robot turns by +ω, the floor turns by −ω in its frame; with v down a point `q` from the centre moves by `ω·(−v, u)`.
    fn blur_across_px(&self, line: &Candidate, along_px: f64) -> f64 {
        let (sin, cos) = line.normal_rad.sin_cos();
        // n·(−v, u) at q = offset·n + along·t, t = (−sin, cos): only the part along the line counts, −along.
        (self.blur_px[0] * cos + self.blur_px[1] * sin - self.turn_rad * along_px).abs()
    }
}

/// Finds the joints in a picture of a tiled floor.
///
/// `blur_px` is the image motion `(du, dv)` over the exposure at the picture's centre, `turn_rad` the robot's rotation
/// over it, counter-clockwise seen from above. A picture that is black, clipped or without a grid gives no line.
pub fn detect(image: &GrayImage, view: &FloorView, blur_px: [f64; 2], turn_rad: f64) -> FloorLines {
    let size_px = [image.width() as f32, image.height() as f32];
    let picture = Picture {
        pixels: image.as_raw(),
        stride: image.width() as usize,
        centre_px: size_px.map(|size| 0.5 * (f64::from(size) - 1.0)),
        blur_px,
        turn_rad,
    };
    // Cells somewhat smaller than a joint keep its contrast and lose most of the noise.
    let bin = (0.8 * view.joint_width_px).round().clamp(2.0, 8.0) as usize;
    let Some(plane) = ridge::binned_log(image, bin) else { return FloorLines::default() };
    let mut points = ridge::ridge_points(&plane, bin, size_px);
    let mut filters = Filters::new(view.joint_width_px);
    let mut result = FloorLines::default();
    let mut grids = Vec::new();
    // The strongest angle first; what it explains must not vote again for another angle.
    for _ in 0..HYPOTHESES {
        let candidates = vote::candidates(&points, bin as f32, size_px);
        let mut joints: Vec<Joint> = Vec::new();
        for candidate in &candidates {
            match measure::measure(&picture, &mut filters, candidate) {
                Some(joint) => joints.push(joint),
                None => result.rejected_px.push(segment(&picture, candidate)),
            }
            vote::remove(&mut points, candidate, 2.0 * bin as f32);
        }
        grids.push(agreement::grid(joints, view));
    }
    for joint in agreement::best(grids, f64::from(size_px[0].min(size_px[1]))) {
        result.lines.push(FloorLine {
            points_px: joint.points_px,
            share_wrong: SHARE_WRONG,
            family: joint.line.family,
        });
    }
    result
}

/// Angles tried: the joints, and what may compete with them (a wire, a tape, a shadow's edge).
const HYPOTHESES: usize = 2;

/// Share of a line's points that may be wrong: a wire, a crumb or a worn stretch spoils that many and no more.
const SHARE_WRONG: f64 = 0.30;

/// The visible part of a candidate, roughly: 60 px to either side of the point nearest to the centre.
fn segment(picture: &Picture, candidate: &Candidate) -> [f64; 4] {
    let [from, to] = [-60.0, 60.0].map(|along_px| picture.point_px(candidate, along_px, 0.0));
    [from[0], from[1], to[0], to[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;
    use crate::vision::trial::{Tally, frames, plain_floor, realistic_floor};

    #[test]
    fn every_line_found_on_plain_floors_is_a_joint_where_it_claims() {
        let mut random = Random::new(1);
        let mut tally = Tally::default();
        for _ in 0..frames(40) {
            let floor = plain_floor(&mut random);
            tally.add(detect, &floor, &mut random);
        }
        tally.print("plain");
        assert_eq!((tally.wrong_lines, tally.false_claims, tally.missed_sets), (0, 0, 0));
    }

    #[test]
    fn no_wrong_line_on_realistic_floors() {
        let mut random = Random::new(2);
        let mut tally = Tally::default();
        for frame in 0..frames(40) {
            let floor = realistic_floor(&mut random);
            let (picture, found, good) = tally.add(detect, &floor, &mut random);
            if !good && std::env::var_os("VISION_SAVE").is_some() {
                crate::vision::trial::save(&format!("bad_{frame}"), &picture, &found, &floor);
            }
        }
        tally.print("realistic");
        assert_eq!((tally.wrong_lines, tally.false_claims, tally.missed_sets), (0, 0, 0));
    }
}
