//! Corner features with binary descriptors, matched between two images: the method that fails in the dark in Fig. 1 of paper 2.

use image::GrayImage;
use imageproc::{
    binary_descriptors::{
        BinaryDescriptor,
        brief::{BriefDescriptor, TestPair, brief},
    },
    corners::corners_fast9,
    point::Point,
};

use crate::vision::draws::Draws;

/// Least contrast of a FAST corner, in grey levels; the value that OpenCV's ORB uses.
const CONTRAST: u8 = 20;
/// Greatest number of corners in an image that get a descriptor, the strongest ones first.
const CORNERS: usize = 500;
/// Number of bits of a descriptor.
const BITS: usize = 256;
/// Greatest number of bits in which two matched descriptors may differ.
const DIFFERING_BITS: u32 = 64;
/// Least distance of a corner feature from the image's border: its descriptor compares pixels in a square of about this half width around it.
const PATCH_PX: u32 = 16;

/// Matches FAST corners of two images whose BRIEF descriptors are each other's nearest: their positions `[u, v]` in the
/// first and in the second image.
pub fn matches(first: &GrayImage, second: &GrayImage) -> Vec<[[u32; 2]; 2]> {
    let (a, b) = (corners(first), corners(second));
    let pattern = pattern();
    let describe = |image, corners: &[Point<u32>]| brief(image, corners, BITS, Some(&pattern));
    let (Ok((a, _)), Ok((b, _))) = (describe(first, &a), describe(second, &b)) else { return Vec::new() };
    let nearest = |of: &BriefDescriptor, among: &[BriefDescriptor]| {
        let differing = among.iter().map(|other| of.hamming_distance(other));
        differing.enumerate().min_by_key(|(_, bits)| *bits)
    };
    let pair = |(idx, of): (usize, &BriefDescriptor)| {
        let (other, bits) = nearest(of, &b)?;
        let mutual = bits <= DIFFERING_BITS && nearest(&b[other], &a)?.0 == idx;
        mutual.then(|| [of.position(), b[other].position()].map(|at| [at.x, at.y]))
    };
    a.iter().enumerate().filter_map(pair).collect()
}

/// Test pattern of a BRIEF descriptor: random pairs of points in a patch of 31 × 31 pixels, denser near its middle. The mean of four
/// uniform random numbers approximates a normal distribution.
fn pattern() -> Vec<TestPair> {
    let mut draws = Draws::new();
    let mut place = || ((0..4).map(|_| draws.below(31)).sum::<usize>() / 4) as u32;
    (0..BITS).map(|_| TestPair { p0: Point::new(place(), place()), p1: Point::new(place(), place()) }).collect()
}

fn corners(image: &GrayImage) -> Vec<Point<u32>> {
    let (width, height) = image.dimensions();
    let inside = |at: &Point<u32>| {
        (PATCH_PX..width.saturating_sub(PATCH_PX)).contains(&at.x)
            && (PATCH_PX..height.saturating_sub(PATCH_PX)).contains(&at.y)
    };
    let mut found = corners_fast9(image, CONTRAST);
    found.sort_by(|a, b| b.score.total_cmp(&a.score).then((a.y, a.x).cmp(&(b.y, b.x))));
    found.into_iter().map(|corner| Point::new(corner.x, corner.y)).filter(inside).take(CORNERS).collect()
}
