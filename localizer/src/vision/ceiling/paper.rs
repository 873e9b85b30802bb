//! Paper 5's own processing chain for ceiling markers: it reads the marker nearest to the middle of the image by distances and angles between its
//! dots.
//!
//! It deviates from the paper where the printed formulas cannot work: the corner dots X and Y are distinguished by the sign of a cross product
//! (erratum I2), and the weights of the grid places in the identity are those of the matrix Q (erratum I1).

use image::GrayImage;
use imageproc::distance_transform::Norm;
use imageproc::morphology::{dilate, erode};

use super::components::components;
use super::confidence::{REFLECTIVE_GREY, confidence};
use crate::markers::{GridPlace, MarkerId};

/// Radius of the erosion that separates dots which touch each other; a greater one would remove dots with a radius of three pixels.
const EROSION_PX: u8 = 1;
/// Greatest ratio of a bright blob's long axis to its short one with which it may be a dot of a marker; the image of a fluorescent tube has more.
const LARGEST_ASPECT: f64 = 2.0;
/// Tolerances of Eqs. (7) and (8) of paper 5, by which marker dots are assigned to grid places: of the angle about 90°, and of the distance about
/// 1/3, 2/3 and 1 of the marker's side.
const ANGLE_RAD: f64 = 0.2;
const AMPLITUDE: f64 = 0.1;

/// A marker as the processing chain of paper 5 reads it: identity, dots and confidence.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperMarker {
    /// Identity of the marker by Eq. (9) of paper 5.
    pub id: MarkerId,
    /// Centroids of the marker's three corner dots X, O and Y, which give its direction: O is at the right angle.
    pub direction_dots_px: [[f64; 2]; 3],
    /// All dots that lie on the marker's grid: their places on the grid, and their centroids.
    pub dots_px: Vec<(GridPlace, [f64; 2])>,
    /// Confidence P(S) of the marker by Eq. (3) of paper 5.
    pub confidence: f64,
}

/// Reads the marker nearest to the middle of the image; `dot_radius_px` is the expected radius of a dot.
pub fn detect(image: &GrayImage, dot_radius_px: f64) -> Option<PaperMarker> {
    let dots = Dots::new(image, dot_radius_px);
    read(image, &dots.of_region(dots.regions.first()?), dot_radius_px)
}

/// Reads every marker of the image by the processing chain of paper 5, the one nearest to the image's middle first.
pub fn detect_all(image: &GrayImage, dot_radius_px: f64) -> Vec<PaperMarker> {
    let dots = Dots::new(image, dot_radius_px);
    dots.regions.iter().filter_map(|region| read(image, &dots.of_region(region), dot_radius_px)).collect()
}

/// Centres of the bright areas of an image that may be dots, and centres of the regions into which neighbouring dots grow together when each is
/// dilated.
struct Dots {
    centres_px: Vec<[f64; 2]>,
    /// Centres of the regions into which dots have grown together by dilation, the one nearest to the middle of the image first.
    regions: Vec<[f64; 2]>,
}

impl Dots {
    fn new(image: &GrayImage, dot_radius_px: f64) -> Self {
        let width = image.width() as usize;
        let bright = GrayImage::from_fn(image.width(), image.height(), |u, v| {
            image::Luma([if image.get_pixel(u, v)[0] >= REFLECTIVE_GREY { 255 } else { 0 }])
        });
        let dots = without_clutter(&bright, dot_radius_px);
        let eroded = erode(&dots, Norm::LInf, EROSION_PX);
        // Neighbouring dots of a marker are up to three pitches apart; growing each dot by half of that joins them into one region.
        let reach_px = (6.0 * dot_radius_px).ceil().min(255.0) as u8;
        let dilated = dilate(&eroded, Norm::LInf, reach_px);
        let middle = [0.5 * (f64::from(image.width()) - 1.0), 0.5 * (f64::from(image.height()) - 1.0)];
        let centres = |picture: &GrayImage| -> Vec<[f64; 2]> {
            let mut mask: Vec<bool> = picture.as_raw().iter().map(|grey| *grey > 0).collect();
            components(&mut mask, width, usize::MAX).iter().map(|component| component.centre_px).collect()
        };
        let mut regions = centres(&dilated);
        regions.sort_by(|a, b| norm(minus(*a, middle)).total_cmp(&norm(minus(*b, middle))));
        // The paper's step "image and": each dot is assigned to the region that it has grown into, here to the region with the nearest centre.
        Dots { centres_px: centres(&eroded), regions }
    }

    fn of_region(&self, region: &[f64; 2]) -> Vec<[f64; 2]> {
        let nearest = |dot: &[f64; 2]| {
            let away = |region: &&[f64; 2]| norm(minus(**region, *dot));
            self.regions.iter().min_by(|a, b| away(a).total_cmp(&away(b)))
        };
        self.centres_px.iter().filter(|dot| nearest(dot) == Some(region)).copied().collect()
    }
}

/// Reads the marker that the dots with these centres form.
fn read(image: &GrayImage, centres: &[[f64; 2]], dot_radius_px: f64) -> Option<PaperMarker> {
    let [x, o, y] = direction_dots(centres)?;
    let dots_px = places(centres, o, y, minus(x, o));
    let id = MarkerId::from_dots(dots_px.iter().map(|(place, _)| *place));
    let radius_px = dot_radius_px.ceil() as i64;
    let greys = centres.iter().flat_map(|centre| {
        let (u0, v0) = (centre[0].round() as i64, centre[1].round() as i64);
        (v0 - radius_px..=v0 + radius_px)
            .flat_map(move |v| (u0 - radius_px..=u0 + radius_px).map(move |u| (u, v)))
            .filter(|&(u, v)| u >= 0 && v >= 0 && u < i64::from(image.width()) && v < i64::from(image.height()))
            .map(|(u, v)| image.get_pixel(u as u32, v as u32)[0])
    });
    Some(PaperMarker { id, direction_dots_px: [x, o, y], dots_px, confidence: confidence(greys) })
}

/// The binary image without areas that are too large or too long for a dot.
fn without_clutter(bright: &GrayImage, dot_radius_px: f64) -> GrayImage {
    let width = bright.width() as usize;
    let most_px = std::f64::consts::PI * (1.5 * dot_radius_px + 1.0).powi(2);
    let mut mask: Vec<bool> = bright.as_raw().iter().map(|grey| *grey > 0).collect();
    let mut kept = GrayImage::new(bright.width(), bright.height());
    let dots = components(&mut mask, width, most_px as usize);
    for dot in dots.iter().filter(|dot| dot.aspect() <= LARGEST_ASPECT) {
        let reach = (3.0 * dot.axes_px[0]).ceil() as i64 + 1;
        let (u0, v0) = (dot.centre_px[0].round() as i64, dot.centre_px[1].round() as i64);
        for v in (v0 - reach).max(0)..=(v0 + reach).min(i64::from(bright.height()) - 1) {
            for u in (u0 - reach).max(0)..=(u0 + reach).min(i64::from(bright.width()) - 1) {
                kept.put_pixel(u as u32, v as u32, *bright.get_pixel(u as u32, v as u32));
            }
        }
    }
    kept
}

/// Finds the marker's corner dots X, O and Y, which give its direction. X and Y are the two dots farthest apart, and O is the dot farthest from the
/// middle between these two. X and Y are named so that the turn from OX to OY is clockwise in the image.
fn direction_dots(dots: &[[f64; 2]]) -> Option<[[f64; 2]; 3]> {
    let pairs = dots.iter().enumerate().flat_map(|(idx, a)| dots[..idx].iter().map(move |b| (*a, *b)));
    let (a, b) = pairs.max_by(|(a, b), (c, d)| norm(minus(*a, *b)).total_cmp(&norm(minus(*c, *d))))?;
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let others = dots.iter().filter(|dot| **dot != a && **dot != b);
    let o = *others.max_by(|c, d| norm(minus(**c, middle)).total_cmp(&norm(minus(**d, middle))))?;
    Some(if cross(minus(a, o), minus(b, o)) > 0.0 { [a, o, b] } else { [b, o, a] })
}

/// Assigns dots to places of the marker's grid by Eqs. (6) to (8) of paper 5. O and Y are two corners of the grid, and M and N divide the side OY in
/// thirds. From each of these four points, dots are searched at a right angle to OY, a third, two thirds and a whole side away.
fn places(dots: &[[f64; 2]], o: [f64; 2], y: [f64; 2], ox: [f64; 2]) -> Vec<(GridPlace, [f64; 2])> {
    let oy = minus(y, o);
    let mut places = Vec::new();
    for row in 0..4u8 {
        let share = f64::from(row) / 3.0;
        let from = [o[0] + share * oy[0], o[1] + share * oy[1]];
        for dot in dots {
            let to = minus(*dot, from);
            let amplitude = norm(to) / norm(oy);
            if amplitude < AMPLITUDE {
                places.push(([0, row], *dot));
                continue;
            }
            let cosine = (to[0] * oy[0] + to[1] * oy[1]) / (norm(to) * norm(oy));
            let thirds = (3.0 * amplitude).round();
            let is_ahead = to[0] * ox[0] + to[1] * ox[1] > 0.0;
            let is_square = (cosine.acos() - std::f64::consts::FRAC_PI_2).abs() < ANGLE_RAD;
            if is_ahead && is_square && (amplitude - thirds / 3.0).abs() < AMPLITUDE && thirds <= 3.0 {
                places.push(([thirds as u8, row], *dot));
            }
        }
    }
    places
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn norm([u, v]: [f64; 2]) -> f64 {
    u.hypot(v)
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
