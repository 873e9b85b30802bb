use std::f64::consts::FRAC_PI_2;

use localizer::map::TileGrid;

use super::*;
use crate::scene::Scene;

/// A grid of tiles of 0.3 m by 0.5 m, turned by 0.1 rad, with its joints 0 at 0.05 m and 0.2 m.
fn grid() -> TileGrid {
    TileGrid {
        edge_m: [0.3, 0.5],
        rotation_rad: 0.1,
        phase_m: [0.05, 0.2],
        joint_width_m: 0.004,
        laying_m: 0.001,
        laying_angle_rad: 0.001,
        straightness_m: 0.0,
    }
}

#[test]
fn a_joint_agrees_with_the_pose_from_which_it_is_seen_in_every_quadrant() {
    // The joint 4 of the second axis is the line of the points whose grid y is 0.2 + 4·0.5 = 2.2 m; the robot is at grid (1.0, 2.13).
    let grid = grid();
    let [x_m, y_m] = turned([1.0, 2.13], grid.rotation_rad);
    for quarter in 0..8 {
        let heading_rad = 0.3 + f64::from(quarter) * FRAC_PI_2;
        // Seen from the robot, the joint is 0.07 m away in the direction of grid y.
        for (normal_rad, distance_m) in
            [(grid.rotation_rad + FRAC_PI_2 - heading_rad, 0.07), (grid.rotation_rad - FRAC_PI_2 - heading_rad, -0.07)]
        {
            let joint = Joint { normal_rad, distance_m, sigma: [0.01, 0.01] };
            let agreement = joint.agreement([x_m, y_m, heading_rad], &grid);
            assert!(agreement.turn_rad.abs() < 1e-9 && agreement.off_m.abs() < 1e-9, "{quarter}");
            assert_eq!(agreement.half_edge_m, 0.25);
            // From a pose 1 cm farther along grid y and turned by 0.02 rad, the residuals are those errors, with the sign of the normal.
            let [x_m, y_m] = turned([1.0, 2.14], grid.rotation_rad);
            let off = joint.agreement([x_m, y_m, heading_rad + 0.02], &grid);
            assert!((off.turn_rad + 0.02).abs() < 1e-9, "{quarter}");
            assert!((off.off_m.abs() - 0.01).abs() < 1e-9 && off.off_m * distance_m < 0.0, "{quarter}");
        }
    }
}

#[test]
fn edges_tell_the_heading_and_clutter_among_them_does_not() {
    let edge = |direction_rad: f64, lean: f64| Edge {
        direction_rad,
        sigma_rad: 0.001,
        by_lean: [lean, -0.5 * lean],
        lean_sigma_rad: 0.002,
    };
    // Heading 0.71 in a building along world x: walls are seen at −0.71 from forward, modulo quarter turns. A lean of 3 mrad about the forward axis
    // moves each as its own slope says.
    let lean_rad = 0.003;
    let seen: Vec<Edge> = [-1.5, -0.4, 0.8, 1.7, 0.1]
        .iter()
        .enumerate()
        .map(|(index, slope)| edge(-0.71 + FRAC_PI_2 * index as f64 - slope * lean_rad, *slope))
        .chain([edge(-0.71 + 0.03, 0.0), edge(0.3, 0.0)])
        .collect();
    let (off_rad, variance) = heading_of(&seen, &[0.0], 0.705, 0.005).unwrap();
    assert!((off_rad - 0.005).abs() < 0.0012, "{off_rad}");
    // Five edges of 1 mrad each cannot tell it better than 1 mrad / √5.
    assert!(variance.sqrt() >= 0.001 / 5.0_f64.sqrt() && variance.sqrt() < 0.001, "{}", variance.sqrt());
    assert!(heading_of(&seen[..2], &[0.0], 0.705, 0.005).is_none(), "two edges are too few");
}

#[test]
fn what_moves_all_that_a_camera_sees_like_a_wrong_position_is_an_error_of_its_mount() {
    let cues = |robot: &str, method: &str| {
        let text = format!(
            "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[start]\nx_m = 2.0\ny_m = 1.5\n[robot]\n\
             floor_camera = false\n{robot}[localizer]\nmethods = [\"{method}\"]\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n"
        );
        let scene = Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        Cues::new(&scene, &scene.map(), &scene.robot_model())
    };
    let range = "[robot.range_camera]\nposition_tolerance_m = 0.003\ntilt_tolerance_deg = 0.5\nheight_span_m = 0.4\n\
                 yaw_tolerance_deg = 0.3\nfocal_tolerance = 0.006\nbaseline_tolerance = 0.008\n";
    let range = cues(range, "range_landmarks");
    let [forward_m, left_m, yaw_rad] = range.mount(Mounted::RangeCamera).unwrap().sigma;
    // A third of 3 mm, and of what half a degree moves at 0.4 m, as independent errors.
    let by_hand_m = (0.003_f64.powi(2) + (0.4 * 0.5_f64.to_radians()).powi(2)).sqrt() / 3.0;
    assert!((forward_m - by_hand_m).abs() < 1e-6 && (left_m - by_hand_m).abs() < 1e-6, "{forward_m} {by_hand_m}");
    assert!((yaw_rad - 0.1_f64.to_radians()).abs() < 1e-9, "{yaw_rad}");
    // The two scales multiply: a third of 0.6 % and 0.8 % as independent errors, which is a third of 1 %.
    assert!((range.range_scale_sigma().unwrap() - 0.01 / 3.0).abs() < 1e-6);
    let ceiling = "[robot.ceiling_camera]\nheight_m = 0.3\nfocal_px = [400.0, 400.0]\n[robot.ceiling_camera.calibration]\n\
                   position_tolerance_m = 0.001\nangle_tolerance_deg = 0.0\nprincipal_point_tolerance_px = 2.0\n\
                   [markers]\nmarker = [{ id = 125, x_m = 2.0, y_m = 1.5, height_m = 2.3 }]\n";
    let [forward_m, left_m, _] = cues(ceiling, "ceiling_markers").mount(Mounted::CeilingCamera).unwrap().sigma;
    // The marker is 2 m above the camera, where 2 px are 10 mm.
    let by_hand_m = 0.001_f64.hypot(0.01) / 3.0;
    assert!((forward_m - by_hand_m).abs() < 1e-6 && (left_m - by_hand_m).abs() < 1e-6, "{forward_m} {by_hand_m}");
}
