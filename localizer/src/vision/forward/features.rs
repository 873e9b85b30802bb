//! Corners and their descriptors, matched between two pictures: what paper 2's Fig. 1 shows to fail in the dark.

use image::GrayImage;
use imageproc::{
    binary_descriptors::{
        BinaryDescriptor,
        brief::{BriefDescriptor, TestPair, brief},
    },
    corners::corners_fast9,
    point::Point,
};

use super::draws::Draws;

/// Contrast of a corner by FAST, in grey levels, as OpenCV's ORB has it.
const CONTRAST: u8 = 20;
/// As many of the strongest corners are described.
const CORNERS: usize = 500;
/// Bits of a descriptor.
const BITS: usize = 256;
/// Bits in which matched descriptors differ at most.
const DIFFERING_BITS: u32 = 64;
/// Distance to the border that a descriptor's patch needs.
const PATCH_PX: u32 = 16;

/// Places of FAST corners whose BRIEF descriptors are each other's nearest: `[u, v]` in the first and in the second picture.
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

/// Pairs of places in a patch of 31 × 31, nearer to its middle than not: the mean of four even draws stands for the normal distribution.
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
