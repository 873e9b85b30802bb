//! Every entry point of the image processing returns for images of any size and content, because a camera may deliver anything.

use image::{GrayImage, Luma};
use nalgebra::Vector3;

use super::{
    FloorView, ceiling, direct,
    forward::{self, Picture, vanishing::Equalisation},
    paper,
    straighten::{RowMotion, Straightening},
    synthetic::Random,
};
use crate::markers::Coding;

const SIZES_PX: [u32; 13] = [0, 1, 2, 3, 4, 5, 7, 9, 15, 16, 31, 64, 100];

/// Test images of a given size: black, white, noise, a step along u, stripes along v, and one bright pixel on a dark ground.
fn contents(width: u32, height: u32, random: &mut Random) -> Vec<GrayImage> {
    let mut drawn = |of: &mut dyn FnMut(u32, u32, &mut Random) -> u8| {
        GrayImage::from_fn(width, height, |u, v| Luma([of(u, v, random)]))
    };
    vec![
        drawn(&mut |_, _, _| 0),
        drawn(&mut |_, _, _| 255),
        drawn(&mut |_, _, random| (255.0 * random.unit()) as u8),
        drawn(&mut |u, _, _| if 2 * u < width { 10 } else { 200 }),
        drawn(&mut |_, v, _| if v % 8 < 4 { 40 } else { 220 }),
        drawn(&mut |u, v, _| if 2 * u == width && 2 * v == height { 255 } else { 3 }),
    ]
}

fn pictures() -> Vec<GrayImage> {
    let mut random = Random::new(111);
    let sizes = SIZES_PX.into_iter().flat_map(|width| SIZES_PX.map(|height| (width, height)));
    sizes.flat_map(|(width, height)| contents(width, height, &mut random)).collect()
}

#[test]
fn both_chains_for_joints_return_from_any_picture() {
    for (at, image) in pictures().iter().enumerate() {
        // The declared width of a tile joint alternates from image to image between a usual one and one far below a pixel.
        let joint_width_px = [5.3, 0.3][at % 2];
        let view = FloorView { pixels_per_m: 1300.0, edge_px: [400.0, 400.0], joint_width_px, q_items: at % 2 };
        for (blur_px, turn_rad) in [([0.0, 0.0], 0.0), ([9.0, -4.0], 0.02)] {
            direct::detect(image, &view, blur_px, turn_rad);
            paper::detect(image, &view, blur_px, turn_rad);
        }
    }
}

#[test]
fn both_chains_for_edges_return_from_any_picture() {
    for image in &pictures() {
        let picture = Picture::from(image);
        forward::detect(&picture);
        forward::features::matches(image, image);
        for equalisation in [Equalisation::Whole, Equalisation::ByTiles] {
            forward::detect_as_printed(&picture, equalisation, |[u, v]| Vector3::new(u - 30.0, v - 30.0, 80.0));
        }
    }
}

#[test]
fn both_chains_for_markers_return_from_any_picture() {
    let view = ceiling::CeilingView::new(750.0, [2.0, 2.6], 0.1, 60.0);
    let words = Coding::Hexads.table();
    for image in &pictures() {
        let motion = ceiling::PictureMotion { shift_px: [3.0, -1.0], turn_rad: 0.01, about_px: [20.0, 20.0] };
        for motion in [ceiling::PictureMotion::default(), motion] {
            ceiling::detect(image, &view, &words, &motion);
        }
        ceiling::paper::detect(image, 2.9);
    }
}

#[test]
fn a_lens_is_taken_out_of_pictures_of_any_size() {
    for image in &pictures() {
        let size_px = [image.width(), image.height()];
        for distortion in [[-0.25, 0.06, 0.001, 0.0, 0.0], [0.3, 0.1, 0.0, 0.0, 0.0], [-2.0, 2.0, 2.0, -2.0, 2.0]] {
            if let Some(lens) = Straightening::new(size_px, 50.0, distortion, RowMotion::default()) {
                lens.straight(image);
            }
        }
    }
}
