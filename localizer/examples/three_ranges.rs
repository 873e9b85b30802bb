//! Where is a robot that measured its distance to three beacons, each to within 0.2 m?
use image::{ImageError, Rgb, RgbImage};
use interval::{Interval, IntervalBox, contractor::ForwardBackward, paving::Paving, separator::Separator};

fn main() -> Result<(), ImageError> {
    let beacons = [[0.0, 0.0, 4.3], [6.0, 0.0, 4.1], [2.0, 5.0, 2.4]];
    // The equation of the measured distance to a beacon becomes a set: all places at that distance, give or take its error.
    let [first, second, third] = beacons.map(|[a, b, range_m]| {
        let range = Interval::centred(range_m, 0.2);
        ForwardBackward::new(move |[x, y]| (x - a).hypot(y - b), range)
    });
    let room = IntervalBox::new([Interval::new(-1.0, 7.0); 2]);
    let places = Paving::new(&first.and(second).and(third), room, &[0, 1], 0.02);
    let [x, y] = places.hull().components();
    println!("the robot is in x {x:.3} m, y {y:.3} m");
    // In the picture, places that agree with one or more of the ranges are grey, the darker the more ranges they agree with. Places that surely
    // agree with all three ranges are green, undecided ones orange.
    let picture = RgbImage::from_fn(640, 640, |u, v| {
        let (x, y) = (f64::from(u) / 80.0 - 1.0, 7.0 - f64::from(v) / 80.0);
        let is_in = |boxes: &[IntervalBox<2>]| boxes.iter().any(|one| one.contains(&[x, y]));
        let is_on = |[a, b, range]: &&[f64; 3]| ((x - a).hypot(y - b) - range).abs() < 0.2;
        let grey = 250 - 40 * beacons.iter().filter(is_on).count() as u8;
        match (is_in(&places.inner), is_in(&places.boundary)) {
            (true, _) => Rgb([60, 160, 80]),
            (false, true) => Rgb([240, 160, 40]),
            (false, false) => Rgb([grey, grey, grey]),
        }
    });
    picture.save("three_ranges.png")
}
