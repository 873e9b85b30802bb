//! Images of the forward camera: edges that are computed by the formulas of school geometry, for a level camera without errors.

use std::f64::consts::FRAC_PI_2;

use interval::Interval;
use localizer::{
    bounds,
    quota::{Counting, Quota},
    reading::Camera,
};

use super::super::{
    history::{CameraPart, History, Looker, Quantity},
    walls::{Edge, FALSE_EDGES, Images, Look, Walls, Way},
};
use crate::judge::{FalseClaims, Quotable};

use super::images::{BOUND_PX, Bench, LOOK, STEP_S, broken_by, demand_all_bounds, moved, put};

/// Half of the length of each edge in the image.
const HALF_PX: f64 = 200.0;
/// Distance in the image from the edge across the view to the horizon.
const ABOVE_PX: f64 = 100.0;

fn bench() -> Bench {
    let mut bench = Bench::of("dark_carpet");
    bench.scene.robot.forward_camera.as_mut().unwrap().tilt_up_deg = 0.0;
    bench.robot = bench.scene.robot_model();
    bench
}

/// A wall's upper edge straight across the view, one that runs away along the view, and an upright one, seen by a robot that looks along x.
fn walls(bench: &Bench) -> Walls {
    let model = bench.robot.forward_camera.unwrap();
    let [cu, cv] = model.principal_point_px.map(|at_px| at_px.mid());
    let level = |stated_rad: f64| Way::Level { stated_rad, turns: true };
    let edge = |ends_px: [[f64; 2]; 2], way: Way| Edge { ends_px, bound_px: BOUND_PX, way };
    let across = [[cu - HALF_PX, cv - ABOVE_PX], [cu + HALF_PX, cv - ABOVE_PX]];
    // An edge along the view has its image on a line through the principal point.
    let away = [[cu + 40.0, cv - 30.0], [cu + 200.0, cv - 150.0]];
    let upright = [[cu, cv - HALF_PX], [cu, cv + HALF_PX]];
    let edges = vec![edge(across, level(FRAC_PI_2)), edge(away, level(0.0)), edge(upright, Way::Upright)];
    let look = Look { stamp: LOOK, measured_s: LOOK as f64 * STEP_S, image: 0, edges };
    let turn_rad = Interval::centred(0.0, 0.01);
    let images = images(NONE, FalseClaims::default());
    Walls { eye: bench.eye(Camera::Forward), looks: vec![look], turn_rad, askew_rad: 0.0, images }
}

/// The quota of an image of which no claim may be false, nor one of an upright edge.
const NONE: Quota =
    Quota { items: 0, things: 0, upright: 0, counting: Counting::Together { of: 1, share: 0.0, more: 0, readings: 0 } };

/// A single image with a quota, of whose claims so many are truly false.
fn images(quota: Quota, judged: FalseClaims) -> Images {
    let mut images = Images::default();
    images.push(0.5, Quotable { method: "wall_directions", quota, n_claims: 2, is_held: true }, judged);
    images
}

fn history(bench: &Bench, walls: &Walls) -> History {
    bench.history(Camera::Forward, walls)
}

#[test]
fn a_forward_image_is_refused_a_hair_beyond_each_of_its_bounds() {
    let bench = bench();
    let walls = walls(&bench);
    let history = history(&bench, &walls);
    assert_eq!(broken_by(&walls, &history, |_| {}), None);
    let of = |part| Quantity::Camera(Camera::Forward, part);
    let quantities = [
        (of(CameraPart::Yaw), bounds::FORWARD_CAMERA_YAW),
        (of(CameraPart::Tilt(0)), bounds::FORWARD_CAMERA_TILT),
        (of(CameraPart::Tilt(1)), bounds::FORWARD_CAMERA_TILT),
        (of(CameraPart::Focal(0)), bounds::FORWARD_CAMERA_FOCAL),
        (of(CameraPart::Centre(0)), bounds::FORWARD_CAMERA_PRINCIPAL_POINT),
        (of(CameraPart::Centre(1)), bounds::FORWARD_CAMERA_PRINCIPAL_POINT),
        (Quantity::WallsTurn, bounds::WALL_DIRECTIONS_DIRECTION),
        (Quantity::Instant(Looker::Camera(Camera::Forward), LOOK), bounds::FORWARD_CAMERA_STAMP),
    ];
    demand_all_bounds(&walls, &history, &quantities);
    let most_rad = bench.robot.forward_camera.unwrap().tilt_error_rad;
    let tilted = broken_by(&walls, &history, |history| {
        (0..2).for_each(|axis| put(of(CameraPart::Tilt(axis)), 0.8 * most_rad)(history));
    });
    assert_eq!(tilted, Some(bounds::FORWARD_CAMERA_TILT));
}

/// By hand, to first order. A turn by δ slopes the edge across the view by `ABOVE_PX`·δ/f, so that its ends are `HALF_PX` times that off. A roll by δ
/// takes the ends of the upright edge `HALF_PX`·δ to the side.
#[test]
fn edges_are_refused_a_hair_beyond_their_bounds() {
    let bench = bench();
    let mut walls = walls(&bench);
    let history = history(&bench, &walls);
    let focal_px = bench.robot.forward_camera.unwrap().focal_px.mid();
    let edges = walls.looks[0].edges.clone();
    walls.looks[0].edges = vec![edges[0]];
    let most_rad = BOUND_PX * focal_px / (HALF_PX * ABOVE_PX);
    for sign in [-1.0, 1.0] {
        let at = |walls: &Walls, share: f64| broken_by(walls, &history, moved(0.3, -0.2, sign * share * most_rad));
        assert_eq!((at(&walls, 1.003), at(&walls, 0.997)), (Some(FALSE_EDGES), None));
        // The walls may be turned with the robot.
        let turned = broken_by(&walls, &history, |history| {
            moved(0.0, 0.0, sign * 1.02 * most_rad)(history);
            put(Quantity::WallsTurn, sign * 0.03 * most_rad)(history);
        });
        assert_eq!(turned, None);
        // Furniture may stand askew by a tenth of that.
        walls.askew_rad = 0.1 * most_rad;
        assert_eq!((at(&walls, 1.103), at(&walls, 1.097)), (Some(FALSE_EDGES), None));
        walls.askew_rad = 0.0;
    }
    // An edge that truly runs along another wall is refused.
    walls.looks[0].edges[0].way = Way::Level { stated_rad: 1.2, turns: true };
    assert_eq!(broken_by(&walls, &history, |_| {}), Some(FALSE_EDGES));

    walls.looks[0].edges = vec![edges[2]];
    let most_rad = BOUND_PX / HALF_PX;
    for sign in [-1.0, 1.0] {
        let at = |share: f64| broken_by(&walls, &history, put(Quantity::BodyTilt(LOOK, 0), sign * share * most_rad));
        assert_eq!((at(1.0 + 1e-4), at(1.0 - 1e-4)), (Some(FALSE_EDGES), None));
    }
}

/// A turn of half a degree takes the edge across the view and the one along it out of their bounds, and a roll the upright one.
#[test]
fn as_many_edges_are_false_as_the_quota_of_the_image_says() {
    let bench = bench();
    let mut walls = walls(&bench);
    let history = history(&bench, &walls);
    let mut with = |items: usize, upright: usize, truly: FalseClaims, change: &dyn Fn(&mut History)| {
        walls.images = images(Quota { upright, ..Quota::of_each(items) }, truly);
        broken_by(&walls, &history, change)
    };
    let none = FalseClaims::default();
    let turned = |by_rad: f64| moved(0.0, 0.0, by_rad);
    assert_eq!(
        [0, 1, 2].map(|items| with(items, 0, none, &turned(0.02))),
        [Some(FALSE_EDGES), Some(FALSE_EDGES), None]
    );
    // What is false in truth counts, too, and leaves no witness where it is more than declared.
    let truly = FalseClaims { others: 1, ..none };
    assert_eq!([2, 3].map(|items| with(items, 0, truly, &turned(0.02))), [Some(FALSE_EDGES), None]);
    assert_eq!([0, 1].map(|items| with(items, 0, truly, &|_| {})), [Some(FALSE_EDGES), None]);
}
