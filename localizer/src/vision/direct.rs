//! The direct chain of the tile joint detection: it measures joints in the image as taken, at full resolution, without deblurring.
//!
//! ```text
//! image ──> binned_log ──> ridge_points ──> hypotheses ──> measure (profiles × matched filter) ──> agreement ──> FloorLines
//! ```
//!
//! Blur that is symmetric about mid-exposure leaves a joint's centre line in place and only flattens its edges. Therefore the matched
//! filter is blurred, rather than the image sharpened, and the claimed bound of a point grows with the blur.

mod agreement;
mod course;
mod joint_filter;
mod measure;
mod profile;
mod ridge;
mod vote;

use image::GrayImage;

use self::measure::{Filters, Joint};
use self::ridge::RidgePoint;
use self::vote::Candidate;
use super::{FloorLine, FloorLines, FloorView};

/// An image with the estimated motion during its exposure.
struct Picture<'a> {
    pixels: &'a [u8],
    stride: usize,
    /// Middle of the image, `[(width − 1)/2, (height − 1)/2]`.
    centre_px: [f64; 2],
    /// Motion of the image over the exposure, at the image's centre.
    blur_px: [f64; 2],
    /// Rotation of the robot over the exposure, counter-clockwise as seen from above.
    turn_rad: f64,
}

impl Picture<'_> {
    /// Point of the image at a given position along a line and a given distance across from the line.
    fn point_px(&self, line: &Candidate, along_px: f64, across_px: f64) -> [f64; 2] {
        let (sin, cos) = line.normal_rad.sin_cos();
        let offset_px = line.offset_px + across_px;
        [self.centre_px[0] + offset_px * cos - along_px * sin, self.centre_px[1] + offset_px * sin + along_px * cos]
    }

    /// Image motion across a line during the exposure, at a given position along the line.
    ///
    /// When the robot turns by +ω, the floor turns by −ω in the robot's frame; with v down, a point `q` relative to the centre moves by `ω·(−v, u)`.
    fn blur_across_px(&self, line: &Candidate, along_px: f64) -> f64 {
        let (sin, cos) = line.normal_rad.sin_cos();
        // The image motion across the line is n·(−v, u) at q = offset·n + along·t with t = (−sin, cos): only the
        // component along the line counts, −along.
        (self.blur_px[0] * cos + self.blur_px[1] * sin - self.turn_rad * along_px).abs()
    }
}

/// Finds the joints in an image of a tiled floor.
///
/// `blur_px` is the image motion `(du, dv)` over the exposure at the image's centre, `turn_rad` the robot's rotation over the exposure,
/// counter-clockwise as seen from above. An image that is black, clipped or shows no grid gives no line.
pub fn detect(image: &GrayImage, view: &FloorView, blur_px: [f64; 2], turn_rad: f64) -> FloorLines {
    let size_px = [image.width() as f32, image.height() as f32];
    let picture = Picture {
        pixels: image.as_raw(),
        stride: image.width() as usize,
        centre_px: size_px.map(|size| 0.5 * (f64::from(size) - 1.0)),
        blur_px,
        turn_rad,
    };
    // Cells of the binned image that are somewhat smaller than a tile joint is wide keep the joint's contrast and lose most of the noise.
    let bin = (0.8 * view.joint_width_px).round().clamp(2.0, 8.0) as usize;
    let Some(plane) = ridge::binned_log(image, bin) else { return FloorLines::default() };
    let mut points = ridge::ridge_points(&plane, bin, size_px, STRONG_SHARE);
    let mut filters = Filters::new(view.joint_width_px);
    let mut result = FloorLines::default();
    let (mut grids, mut seen, mut measured) = (Vec::new(), Vec::new(), Vec::new());
    // The angle with the most votes is tried first. Ridge points near the lines found at that angle are removed, so that they do not vote for the
    // next one.
    for _ in 0..HYPOTHESES {
        let candidates = vote::candidates(&points, bin as f32, size_px);
        let mut joints: Vec<Joint> = Vec::new();
        seen.extend_from_slice(&candidates);
        for candidate in &candidates {
            match measure::measure(&picture, &mut filters, candidate) {
                Some(joint) => {
                    measured.push(joint.line);
                    joints.push(joint);
                }
                None => result.rejected_px.push(segment(&picture, candidate)),
            }
            vote::remove(&mut points, candidate, 2.0 * bin as f32);
        }
        grids.push(agreement::grid(joints, view));
    }
    let mut joints = agreement::best(grids);
    if let [lone] = joints.as_slice() {
        let is_lone = seen.iter().all(|candidate| is_beside(candidate, lone, SIDE_LOBE_CELLS * bin as f64))
            && is_alone(lone, &ridge::ridge_points(&plane, bin, size_px, 0.0), bin as f32, size_px);
        if !is_lone {
            joints.clear();
        }
    }
    let is_claimed = |line: &Candidate| joints.iter().any(|joint| joint.line == *line);
    result.rejected_px.extend(measured.iter().filter(|line| !is_claimed(line)).map(|line| segment(&picture, line)));
    for joint in joints {
        result.lines.push(FloorLine {
            points_px: joint.points_px,
            share_wrong: SHARE_WRONG,
            family: joint.line.family,
        });
    }
    result
}

/// Number of grid angles that are tried: that of the tile joints, and that of a competing structure (a wire, a tape, a shadow's edge).
const HYPOTHESES: usize = 2;

/// Ridges in the image that are fainter than this share of the strong ridges are taken for side effects of the strong ones' smoothing (side lobes)
/// and left out.
const STRONG_SHARE: f32 = 0.15;
/// Distance from a line within which weak ridges are taken for side lobes of its own, in cells of the binned image: the smoothing of a line's ridge
/// leaves them up to four cells away.
const SIDE_LOBE_CELLS: f64 = 5.0;
/// If only one line is found in the image, it must extend over at least this share of the image's shorter side.
const LONE_SPAN: f64 = 0.6;

/// Whether the only line that was found may be taken for a tile joint: it is long, its width is that of a joint, and nothing else in the image is
/// straight.
///
/// `points` are all ridge points, including faint ones, because a black wire is stronger than the tile joints beside it.
fn is_alone(lone: &Joint, points: &[RidgePoint], cell_px: f32, size_px: [f32; 2]) -> bool {
    let mut points = points.to_vec();
    vote::remove(&mut points, &lone.line, SIDE_LOBE_CELLS as f32 * cell_px);
    lone.width_is_sure
        && lone.span_px > LONE_SPAN * f64::from(size_px[0].min(size_px[1]))
        && vote::candidates(&points, cell_px, size_px).is_empty()
}

/// Whether a candidate lies within `reach_px` of a joint along all of the joint's visible length, as a side lobe of the joint does.
fn is_beside(candidate: &Candidate, joint: &Joint, reach_px: f64) -> bool {
    let ((sin, cos), (along_sin, along_cos)) = (candidate.normal_rad.sin_cos(), joint.line.normal_rad.sin_cos());
    [-0.5 * joint.span_px, 0.5 * joint.span_px].into_iter().all(|along_px| {
        let end_px = [joint.middle_px[0] - along_px * along_sin, joint.middle_px[1] + along_px * along_cos];
        (end_px[0] * cos + end_px[1] * sin - candidate.offset_px).abs() <= reach_px
    })
}

/// Greatest share of a line's points that may be farther than their bound from the tile joint. A wire, a crumb or a worn stretch that passes the
/// checks spoils fewer points; scatter alone puts one point in eighty outside.
const SHARE_WRONG: f64 = 0.20;

/// Rough extent of a candidate line for debug frames: 60 px to either side of its point nearest to the image's centre.
fn segment(picture: &Picture, candidate: &Candidate) -> [f64; 4] {
    let [from, to] = [-60.0, 60.0].map(|along_px| picture.point_px(candidate, along_px, 0.0));
    [from[0], from[1], to[0], to[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::{Floor, Pattern, Random, Strip};
    use crate::vision::trial::{Tally, frames, plain_floor, realistic_floor, save};

    /// Runs the tile joint detection on random floors of one kind and asserts that no reported line, point or set of lines is false.
    fn trial(name: &str, seed: u64, usual: usize, mut floor: impl FnMut(&mut Random) -> Floor) -> Tally {
        let mut random = Random::new(seed);
        let mut tally = Tally::default();
        for frame in 0..frames(usual) {
            let floor = floor(&mut random);
            let (picture, found, good) = tally.add(detect, &floor, &mut random);
            if !good {
                save(&format!("{name}_{frame}").replace(' ', "_"), &picture, &found, &floor);
            }
        }
        tally.print(name);
        assert_eq!((tally.wrong_lines, tally.false_claims, tally.missed_sets), (0, 0, 0), "{name}");
        tally
    }

    fn found_share(tally: &Tally) -> f64 {
        tally.families_found as f64 / tally.families_in_view.max(1) as f64
    }

    #[test]
    fn plain_floors_are_measured_to_a_twentieth_of_a_pixel() {
        let tally = trial("plain", 1, 12, plain_floor);
        assert_eq!(found_share(&tally), 1.0);
        assert!((tally.rho_squares / tally.lines as f64).sqrt() < 0.05);
        assert!((tally.psi_squares / tally.lines as f64).sqrt() < 0.3e-3);
    }

    #[test]
    fn no_wrong_line_on_realistic_floors() {
        assert!(found_share(&trial("realistic", 2, 24, realistic_floor)) > 0.6);
    }

    #[test]
    fn three_lux_leave_the_joints_in_place() {
        let tally = trial("50 electrons", 4, 8, |random| Floor { electrons: 50.0, ..plain_floor(random) });
        assert!(found_share(&tally) > 0.9);
    }

    #[test]
    fn motion_of_ten_pixels_and_a_turn_leave_the_joints_in_place() {
        let tally = trial("blur 10 px, turn 12 mrad", 5, 8, |random| {
            let course = random.between(-3.0, 3.0);
            let blur_px = [10.0 * course.cos(), 10.0 * course.sin()];
            Floor { blur_px, turn_rad: 0.012, electrons: 1700.0, ..plain_floor(random) }
        });
        assert!(found_share(&tally) > 0.85);
    }

    #[test]
    fn a_tape_nearly_along_the_joints_is_not_one() {
        trial("tape", 6, 8, |random| {
            let floor = plain_floor(random);
            let normal_rad = floor.angle_rad + random.between(0.015, 0.06);
            let strip = Strip {
                sin_cos: [normal_rad.sin(), normal_rad.cos()],
                offset_px: random.between(-150.0, 150.0),
                width_px: floor.joint_width_px,
                albedo: floor.joint_albedo,
                bend_px: 0.0,
            };
            Floor { strips: vec![strip], ..floor }
        });
    }

    #[test]
    fn a_joint_of_tiles_larger_than_the_view_is_claimed() {
        // One joint crosses the view; those across it, and the next ones along it, lie 700 px from the image's centre, beyond its corners.
        let tally = trial("lone joints", 10, 12, |random| Floor {
            edge_px: [1400.0, 1400.0],
            phase_px: [random.between(-120.0, 120.0), 700.0],
            electrons: 1700.0,
            ..plain_floor(random)
        });
        assert!(found_share(&tally) > 0.9, "{}", found_share(&tally));
    }

    #[test]
    fn printed_stripes_are_no_joints() {
        let tally = trial("stripes", 7, 8, |random| {
            let pattern =
                Pattern::Stripes { pitch_px: random.between(35.0, 120.0), contrast: random.between(0.1, 0.2) };
            Floor { pattern, electrons: 1700.0, ..plain_floor(random) }
        });
        assert!(found_share(&tally) > 0.7);
    }

    #[test]
    fn joints_lighter_than_the_tiles_are_found() {
        let tally = trial("light joints", 8, 6, |random| Floor {
            tile_albedo: 0.4,
            joint_albedo: 0.7,
            electrons: 1700.0,
            ..plain_floor(random)
        });
        assert!(found_share(&tally) > 0.9);
    }

    #[test]
    fn a_black_a_clipped_and_an_empty_picture_have_no_line() {
        let view = plain_floor(&mut Random::new(1)).view();
        for picture in [
            GrayImage::from_pixel(640, 480, image::Luma([1])),
            GrayImage::from_pixel(640, 480, image::Luma([255])),
            GrayImage::from_pixel(640, 480, image::Luma([128])),
            GrayImage::new(0, 0),
            GrayImage::new(7, 3),
        ] {
            assert!(detect(&picture, &view, [0.0, 0.0], 0.0).lines.is_empty());
        }
    }

    #[test]
    fn noise_and_texture_without_joints_have_no_line() {
        let mut random = Random::new(9);
        for _ in 0..frames(6) {
            let floor = Floor { texture: 0.05, joint_albedo: 0.6, tile_spread: 0.0, ..plain_floor(&mut random) };
            let picture = floor.picture(&mut random);
            assert!(detect(&picture, &floor.view(), [0.0, 0.0], 0.0).lines.is_empty());
        }
    }

    #[test]
    fn turning_on_the_spot_blurs_a_line_through_the_centre_at_its_ends() {
        // By hand: a turn of the robot by 10 mrad moves an image point 300 px along the line by 3 px across it, in opposite directions at the two
        // ends.
        let picture =
            Picture { pixels: &[], stride: 640, centre_px: [319.5, 239.5], blur_px: [0.0, 0.0], turn_rad: 0.01 };
        let line = Candidate { normal_rad: 0.3, offset_px: 0.0, family: 0, dark: true, support: 0.0 };
        for along_px in [-300.0, 300.0] {
            assert!((picture.blur_across_px(&line, along_px) - 3.0).abs() < 1e-12);
        }
        // Image up is forward. A left turn moves a floor point on the right (u = +300) down in the image (v grows by 3), so that a motion
        // of the whole image by −3 in v leaves this point at rest.
        let level = Candidate { normal_rad: std::f64::consts::FRAC_PI_2, ..line };
        let picture = Picture { blur_px: [0.0, -3.0], ..picture };
        assert!(picture.blur_across_px(&level, -300.0) < 1e-9);
        assert!((picture.point_px(&level, -300.0, 0.0)[0] - 619.5).abs() < 1e-9);
    }
}
