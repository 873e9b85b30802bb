//! Tests of the point method that computes the robot's pose from ceiling markers when the camera's vertical is known,
//! against a pinhole worked out by hand.

use interval::Interval;
use localizer::{
    Pose,
    baselines::vertical_known,
    map::{MarkerMap, PlacedMarker},
    markers::{Coding, GridPlace, MarkerId, dot_in_marker_m},
    robot::CeilingCameraModel,
    vision::ceiling::paper::PaperMarker,
};

/// A camera that sees a ceiling 2.5 m above it at 200 pixels per metre, mounted 0.1 m ahead of the robot's axle.
fn camera() -> CeilingCameraModel {
    CeilingCameraModel {
        width_px: 640,
        height_px: 480,
        focal_px: [Interval::point(500.0); 2],
        centre_px: [Interval::point(320.0), Interval::point(240.0)],
        distortion: [0.0; 5],
        distortion_px: 0.0,
        height_m: Interval::point(0.2),
        position_m: [Interval::point(0.1), Interval::ZERO],
        yaw_rad: Interval::ZERO,
        lean_rad: [0.0; 2],
        tilt_rad: 0.0,
        stamp_error_s: 0.0,
        electrons_per_grey: 40.0,
        row_time_s: 0.0,
        q_items: 0,
    }
}

fn map() -> MarkerMap {
    let placed =
        |(id, centre_m)| PlacedMarker { id: MarkerId(id), centre_m, rotation_rad: 0.0, height_m: Interval::point(2.7) };
    MarkerMap {
        coding: Coding::Hexads,
        markers: [(125, [1.2, 2.1]), (183, [1.9, 2.2]), (207, [1.0, 3.0])].map(placed).to_vec(),
        placement_m: 0.0,
        rotation_tolerance_rad: 0.0,
        print_m: 0.0,
    }
}

const TRUTH: Pose = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 0.5 };
/// Places of the dots on a marker's grid: the three direction dots and two coded dots.
const PLACES: [GridPlace; 5] = [[0, 0], [3, 0], [0, 3], [1, 1], [2, 1]];

/// What the camera sees of a marker at a place on the ceiling, which is read as marker `id`. In the image its dots are shifted by `off_px`, one dot
/// to the right, the next one to the left, and so on.
fn seen(id: u16, [centre_x_m, centre_y_m]: [f64; 2], off_px: f64) -> PaperMarker {
    let (sin, cos) = TRUTH.heading_rad.sin_cos();
    let pixel = |(index, place): (usize, &GridPlace)| {
        let [x_m, y_m] = dot_in_marker_m(*place);
        let (x_m, y_m) = (centre_x_m + x_m - TRUTH.x_m, centre_y_m + y_m - TRUTH.y_m);
        let (ahead_m, left_m) = (cos * x_m + sin * y_m - 0.1, cos * y_m - sin * x_m);
        let off_px = if index % 2 == 0 { off_px } else { -off_px };
        // Image up is forward. As the camera looks up, a point to the robot's left appears at the right in the image.
        (*place, [320.0 + 200.0 * left_m + off_px, 240.0 - 200.0 * ahead_m])
    };
    let dots_px: Vec<(GridPlace, [f64; 2])> = PLACES.iter().enumerate().map(pixel).collect();
    let direction_dots_px = [dots_px[1].1, dots_px[0].1, dots_px[2].1];
    PaperMarker { id: MarkerId(id), direction_dots_px, dots_px, confidence: 1.0 }
}

fn off(pose: Pose) -> [f64; 2] {
    [(pose.x_m - TRUTH.x_m).hypot(pose.y_m - TRUTH.y_m), (pose.heading_rad - TRUTH.heading_rad).abs()]
}

#[test]
fn exact_dots_of_one_marker_give_the_exact_pose() {
    let pose = vertical_known(&[seen(125, [1.2, 2.1], 0.0)], &map(), &camera()).unwrap();
    assert!(off(pose).iter().all(|off| *off < 1e-12), "{pose:?}");
    assert!(vertical_known(&[seen(250, [1.2, 2.1], 0.0)], &map(), &camera()).is_none(), "not on the map");
}

#[test]
fn dots_that_are_off_by_a_tenth_of_a_pixel_move_the_robot_by_no_more_than_that_is_on_the_ceiling() {
    // A tenth of a pixel is half a millimetre on the ceiling; P3P, which computes the pose from three dots alone, turns this into centimetres. The
    // mean of ten dots is off by no more than one of them. The markers turn by at most 0.5 mm over the 0.35 m between each of them and their middle;
    // with the lever of 0.6 m from that middle to the robot this adds at most 0.9 mm.
    let both = [seen(125, [1.2, 2.1], 0.1), seen(183, [1.9, 2.2], 0.1)];
    let [away_m, turn_rad] = off(vertical_known(&both, &map(), &camera()).unwrap());
    assert!(away_m < 0.0014 && turn_rad < 0.0015, "{away_m} {turn_rad}");
}

#[test]
fn a_marker_that_is_misread_is_outvoted() {
    // Two markers are seen at the place of marker 183: one is read as 183, the other one is misread as 207, which hangs a metre away on the map.
    let markers = [seen(207, [1.9, 2.2], 0.0), seen(125, [1.2, 2.1], 0.0), seen(183, [1.9, 2.2], 0.0)];
    let pose = vertical_known(&markers, &map(), &camera()).unwrap();
    assert!(off(pose).iter().all(|off| *off < 1e-12), "{pose:?}");
    // Here a marker's dots do not fit the grid on which the dots of that marker are printed: they are off by up to 3 cm.
    assert!(vertical_known(&[seen(125, [1.2, 2.1], 6.0)], &map(), &camera()).is_none());
}
