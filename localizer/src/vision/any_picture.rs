//! Every entry point of the image processing returns for images of any size and content, because a camera may deliver anything, and sees nothing
//! where nothing is to be seen.

use std::panic::catch_unwind;

use image::{GrayImage, Luma};
use interval::Interval;
use nalgebra::Vector3;

use super::{
    FloorLines, FloorView,
    ceiling::{self, PictureMotion},
    direct,
    forward::{
        self, EdgeLine, Picture, Segment, equalise, features, guidance_filter, refit, segments, stabilise,
        vanishing::{self, Equalisation},
    },
    line_fit, p3p, paper,
    point_features::{Frame, ImageBounds, Search},
    straighten::{RowMotion, Straightening},
    synthetic::Random,
};
use crate::{
    calibration::{
        chessboard::{
            self, Bend, Corner,
            corners::{self, Board},
        },
        mount_offset,
    },
    markers::Coding,
};

/// Sides of the test images: each is combined with each.
const SIDES_PX: [u32; 13] = [0, 1, 2, 3, 4, 5, 7, 9, 15, 16, 31, 64, 100];
/// Further sizes of test images: long and narrow ones, and one in which every chain has room for what it looks for.
const SIZES_PX: [[u32; 2]; 6] = [[1, 1000], [1000, 1], [2, 700], [700, 3], [29, 600], [320, 240]];

/// Test images of a given size: black, white, noise, a step along u, stripes along v, two chessboards of single pixels and of squares, and one bright
/// pixel on a dark ground.
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
        drawn(&mut |u, v, _| if (u + v) % 2 == 0 { 0 } else { 255 }),
        drawn(&mut |u, v, _| if (u / 20 + v / 20) % 2 == 0 { 0 } else { 255 }),
        drawn(&mut |u, v, _| if 2 * u == width && 2 * v == height { 255 } else { 3 }),
    ]
}

fn pictures() -> Vec<GrayImage> {
    let mut random = Random::new(111);
    let squares = SIDES_PX.into_iter().flat_map(|width| SIDES_PX.map(|height| [width, height]));
    squares.chain(SIZES_PX).flat_map(|[width, height]| contents(width, height, &mut random)).collect()
}

/// A way into the image processing, by name: from an image to the number of things that were seen in it.
type Way = (&'static str, fn(&GrayImage) -> usize);

const WAYS: [Way; 17] = [
    ("direct::detect", |image| joints(image, direct::detect)),
    ("paper::detect", |image| joints(image, paper::detect)),
    ("forward::detect", |image| forward::detect(&Picture::from(image)).len()),
    ("forward::detect_as_printed, whole", |image| edges_as_printed(image, Equalisation::Whole)),
    ("forward::detect_as_printed, by tiles", |image| edges_as_printed(image, Equalisation::ByTiles)),
    ("forward::vanishing", |image| {
        let found = vanishing::segments_in(&Picture::from(image), Equalisation::Whole);
        vanishing::vanishing_points(&found, ray).map_or(0, |points| vanishing::agreeing(&found, &points, ray).len())
    }),
    ("forward::features::matches", |image| features::matches(image, image).len()),
    ("forward::guided, forward::long_segments", |image| {
        let picture = Picture::from(image);
        forward::long_segments(&forward::guided(&picture.binned()), &picture).len()
    }),
    ("forward::segments", |image| segments::segments(&Picture::from(image), segments::NOISE_FLOOR).len()),
    ("forward::refitted", |image| any_edges(&Picture::from(image)).len()),
    ("forward::stabilise", |image| same_size(image, stabilise::stabilised)),
    ("forward::equalise", |image| {
        same_size(image, equalise::equalised)
            + same_size(image, |picture| equalise::equalised_by_tiles(picture, [8, 6], 3.0))
    }),
    ("forward::guidance_filter", |image| {
        same_size(image, |picture| guidance_filter::rolling_guidance(picture, 3.0, 25.0, forward::ROUNDS))
            + same_size(image, |picture| guidance_filter::rolling_guidance_at_speed(picture, 2.5, 0.5, 2))
    }),
    ("ceiling::detect", markers),
    ("ceiling::paper", |image| {
        usize::from(ceiling::paper::detect(image, 2.9).is_some()) + ceiling::paper::detect_all(image, 2.9).len()
    }),
    ("point_features", |image| {
        let bounds = ImageBounds { focal_px: 500.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
        let mut frame = Frame::new(image, &bounds);
        let landmarks = frame.landmarks(10);
        let region = [image.width(), image.height()].map(|size| Interval::new(-50.0, f64::from(size)));
        for [scale, turn_rad] in [[Interval::new(0.7, 1.4), Interval::ENTIRE], [Interval::ENTIRE, Interval::ZERO]] {
            let search = Search::in_box(region, scale, turn_rad);
            for landmark in &landmarks {
                let _ = frame.find(landmark, &search);
            }
        }
        frame.keypoints().len()
    }),
    ("chessboard::corners::find", |image| {
        let boards = [[0, 0], [1, 1], [1, 9], [2, 2], [2, 3], [9, 7]];
        let board = |[columns, rows]: [usize; 2]| Board { columns, rows, square_m: 0.025 };
        boards.into_iter().filter_map(|size| corners::find(image, &board(size))).map(|corners| corners.len()).sum()
    }),
];

fn joints(image: &GrayImage, chain: fn(&GrayImage, &FloorView, [f64; 2], f64) -> FloorLines) -> usize {
    // The declared width of a tile joint is once a usual one and once far below a pixel.
    let views = [(5.3, 0), (0.3, 1)].map(|(joint_width_px, q_items)| FloorView {
        pixels_per_m: 1300.0,
        edge_px: [400.0, 400.0],
        joint_width_px,
        q_items,
    });
    let motions = [([0.0, 0.0], 0.0), ([9.0, -4.0], 0.02)];
    let found = views
        .iter()
        .flat_map(|view| motions.map(|(blur_px, turn_rad)| chain(image, view, blur_px, turn_rad).lines.len()));
    found.sum()
}

fn ray([u, v]: [f64; 2]) -> Vector3<f64> {
    Vector3::new(u - 30.0, v - 30.0, 80.0)
}

fn edges_as_printed(image: &GrayImage, equalisation: Equalisation) -> usize {
    forward::detect_as_printed(&Picture::from(image), equalisation, ray).len()
}

/// Edges measured at segments that have nothing to do with the image: along its border, across it, outside of it, and a segment without length.
fn any_edges(picture: &Picture) -> Vec<EdgeLine> {
    let [right, below] = [picture.width as f64 - 1.0, picture.height as f64 - 1.0];
    let ends = [
        [[0.0, 0.0], [right, 0.0]],
        [[0.5 * right, 0.0], [0.5 * right, below]],
        [[-200.0, 10.0], [900.0, 60.0]],
        [[3.0, 3.0], [3.0, 3.0]],
    ];
    let some = ends.map(|ends_px| Segment { ends_px });
    assert!(refit::refit(picture, &some[3]).is_none(), "an edge without length");
    forward::refitted(picture, &some)
}

/// Applies a filter to an image and demands an image of the same size. A filter sees nothing.
fn same_size(image: &GrayImage, filter: impl Fn(&Picture) -> Picture) -> usize {
    let filtered = filter(&Picture::from(image));
    assert_eq!([filtered.width, filtered.height], [image.width() as usize, image.height() as usize]);
    assert_eq!(filtered.values.len(), image.as_raw().len());
    0
}

fn markers(image: &GrayImage) -> usize {
    let view = ceiling::CeilingView::new(750.0, [2.0, 2.6], 0.1, 60.0);
    let moving = PictureMotion { shift_px: [3.0, -1.0], turn_rad: 0.01, about_px: [20.0, 20.0] };
    let words = Coding::Hexads.table();
    let motions = [PictureMotion::default(), moving];
    motions.iter().map(|motion| ceiling::detect(image, &view, &words, motion).markers.len()).sum()
}

#[test]
fn every_way_into_vision_returns_from_any_picture_and_sees_nothing_in_plain_ones() {
    let pictures = pictures();
    let is_plain = |image: &GrayImage| image.as_raw().windows(2).all(|pair| pair[0] == pair[1]);
    for (name, way) in WAYS {
        // A panic is caught only to say for which images it comes.
        let fails = |image: &&GrayImage| catch_unwind(|| way(image)).map_or(true, |seen| seen > 0 && is_plain(image));
        let failures: Vec<_> = pictures.iter().filter(fails).map(GrayImage::dimensions).collect();
        assert!(failures.is_empty(), "{name} fails for {} images, of the sizes {failures:?}", failures.len());
    }
}

#[test]
fn a_lens_is_taken_out_of_pictures_of_any_size() {
    for image in &pictures() {
        let size_px = [image.width(), image.height()];
        for distortion in [[-0.25, 0.06, 0.001, 0.0, 0.0], [0.3, 0.1, 0.0, 0.0, 0.0], [-2.0, 2.0, 2.0, -2.0, 2.0]] {
            for rows in [RowMotion::default(), RowMotion { shift_px: [0.02, -0.03], turn_rad: 1e-4 }] {
                if let Some(lens) = Straightening::new(size_px, 50.0, distortion, rows) {
                    lens.straight(image);
                }
            }
        }
    }
}

/// Numbers at the limits of what a double holds, and usual ones.
const NUMBERS: [f64; 9] = [0.0, -0.0, 1.0, -3.5, 120.0, 1e-300, 1e155, -1e155, f64::MAX];

fn any_number(random: &mut Random) -> f64 {
    NUMBERS[(random.unit() * NUMBERS.len() as f64) as usize]
}

#[test]
fn pictures_of_extreme_values_go_through_every_step_of_the_chain_for_edges() {
    let mut random = Random::new(112);
    for [width, height] in [[1, 1], [3, 3], [31, 29], [40, 90], [120, 70]] {
        for values in [[0.0, f32::MAX], [f32::MIN, f32::MAX], [f32::MIN_POSITIVE, 0.0], [-1.0, 1e30]] {
            let mut picture = Picture::filled(width, height, 0.0);
            picture.values.fill_with(|| values[usize::from(random.chance(0.5))]);
            forward::detect(&picture);
            any_edges(&picture);
            for equalisation in [Equalisation::Whole, Equalisation::ByTiles] {
                forward::detect_as_printed(&picture, equalisation, ray);
            }
        }
    }
}

#[test]
fn points_and_poses_are_solved_for_from_any_numbers() {
    let mut random = Random::new(113);
    for round in 0..3000 {
        let mut number = || any_number(&mut random);
        let points: Vec<[f64; 3]> = (0..round % 9).map(|_| [number(), number(), number()]).collect();
        for share_wrong in [-1.0, 0.0, 0.3, 1.0, 7.0] {
            line_fit::enclose(&points, share_wrong);
        }
        let mut triple = || [0, 1, 2].map(|_| Vector3::new(number(), number(), number()));
        p3p::solve(&triple(), &triple());
        mount_offset::solve(&[points, vec![[number(), number(), number()]]]);
        let views: Vec<Vec<Corner>> = (0..round % 5)
            .map(|n_more| (0..4 + n_more).map(|_| ([number(), number()], [number(), number()])).collect())
            .collect();
        for bend in [Bend::Radial, Bend::RadialAndTangential] {
            chessboard::calibrate(&views, bend);
        }
    }
}
