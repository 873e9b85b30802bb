//! Draws the three kinds of boxes of a paving: boxes surely inside the set (green), undecided ones (orange), and boxes surely outside (grey).
//!
//! The set consists of the places that are at most 3 m from one lamp, at least 1.2 m from another, and on the upper side of a wavy wall. The
//! picture is the one in the documentation of `interval::paving`; it is written to the path given on the command line.

use image::{Rgb, RgbImage};
use interval::{Interval, IntervalBox, contractor::ForwardBackward, paving::Paving, separator::Separator};

const SIZE_PX: u32 = 480;
const METRES: f64 = 8.0;

fn main() -> Result<(), image::ImageError> {
    let lit = ForwardBackward::new(|[x, y]| x.hypot(y), Interval::new(0.0, 3.0));
    let far = ForwardBackward::new(|[x, y]| (x - 1.5).hypot(y - 1.0), Interval::new(1.2, f64::INFINITY));
    let above = ForwardBackward::new(|[x, y]| y - 0.5 * (3.0 * x).sin(), Interval::new(-1.0, f64::INFINITY));
    let domain = IntervalBox::new([Interval::new(-0.5 * METRES, 0.5 * METRES); 2]);
    let paving = Paving::new(&lit.and(far).and(above), domain, &[0, 1], 0.1);
    let counts = [&paving.inner, &paving.boundary, &paving.outer].map(Vec::len);
    println!("{} boxes inside, {} undecided, {} outside", counts[0], counts[1], counts[2]);
    let mut picture = RgbImage::from_pixel(SIZE_PX, SIZE_PX, Rgb([255, 255, 255]));
    for (boxes, colour) in [
        (&paving.outer, Rgb([225, 225, 230])),
        (&paving.inner, Rgb([90, 180, 110])),
        (&paving.boundary, Rgb([245, 165, 50])),
    ] {
        for one in boxes {
            fill(&mut picture, one, colour);
        }
    }
    picture.save(std::env::args().nth(1).unwrap_or("paving.png".into()))
}

/// Fills a box in the picture, and draws its left column and its upper row of pixels darker, as a border line.
fn fill(picture: &mut RgbImage, one: &IntervalBox<2>, colour: Rgb<u8>) {
    let pixel =
        |metres: f64| ((metres / METRES + 0.5) * f64::from(SIZE_PX)).round().clamp(0.0, f64::from(SIZE_PX)) as u32;
    let (left, right) = (pixel(one[0].lo()), pixel(one[0].hi()));
    let (top, bottom) = (SIZE_PX - pixel(one[1].hi()), SIZE_PX - pixel(one[1].lo()));
    let line = colour.0.map(|channel| (f64::from(channel) * 0.75) as u8);
    for v in top..bottom {
        for u in left..right {
            picture.put_pixel(u, v, if u == left || v == top { Rgb(line) } else { colour });
        }
    }
}
