//! Drawn errors: inside their tolerance, all over it, and each from its own stream.

use sim::{drawn::Drawn, scene::Scene};

use crate::world_setup::scene;

fn scene_with(errors: &str, yaw_tolerance_deg: f64) -> Scene {
    let robot = serde_json::json!({ "errors": errors, "floor_camera": { "yaw_tolerance_deg": yaw_tolerance_deg } });
    let start = serde_json::json!({ "x_m": 2.0, "y_m": 3.0, "tolerance_m": 0.25, "tolerance_deg": 2.0 });
    scene(serde_json::json!({ "robot": robot, "start": start }))
}

/// Every drawn error over its tolerance; all of them in [−1, 1] when the draws keep their bounds.
fn shares(drawn: &Drawn) -> Vec<f64> {
    let camera = drawn.floor_camera.unwrap();
    let px_per_m = camera.focal_px / camera.height_m;
    vec![
        (drawn.wheel_radius_m[0] / 0.0975 - 1.0) / 0.002,
        (drawn.wheel_radius_m[1] / 0.0975 - 1.0) / 0.002,
        (drawn.track_m / 0.33 - 1.0) / 0.003,
        (drawn.start.x_m - 2.0) / 0.25,
        (drawn.start.y_m - 3.0) / 0.25,
        drawn.start.heading_rad.to_degrees() / 2.0,
        (camera.position_m[0] + 0.15) / 0.0005,
        camera.position_m[1] / 0.0005,
        (px_per_m / (640.0 / 0.48) - 1.0) / 0.001,
        camera.yaw_rad.to_degrees() / 0.1,
        camera.tilt_rad[0].hypot(camera.tilt_rad[1]).to_degrees() / 0.1,
    ]
}

#[test]
fn drawn_errors_fill_their_tolerance_and_never_leave_it() {
    let n_errors = shares(&Drawn::draw(&scene_with("uniform", 0.1), 0)).len();
    for errors in ["uniform", "truncated_gaussian", "corner"] {
        let scene = scene_with(errors, 0.1);
        let draws: Vec<Vec<f64>> = (0..300).map(|seed| shares(&Drawn::draw(&scene, seed))).collect();
        for error_idx in 0..n_errors {
            let drawn: Vec<f64> = draws.iter().map(|draw| draw[error_idx]).collect();
            assert!(
                drawn.iter().all(|share| share.abs() <= 1.0 + 1e-9),
                "{errors}: error {error_idx} leaves its tolerance"
            );
            assert!(
                drawn.iter().any(|share| *share > 0.8),
                "{errors}: error {error_idx} never comes near its tolerance"
            );
            // The tilt's share is a norm and has no sign.
            let is_norm = error_idx == n_errors - 1;
            assert!(is_norm || drawn.iter().any(|share| *share < -0.8), "{errors}: error {error_idx} is one-sided");
            assert!(
                errors != "corner" || drawn.iter().all(|share| share.abs() > 0.999),
                "error {error_idx} off its corner"
            );
        }
    }
}

#[test]
fn a_cameras_tolerance_moves_no_wheel() {
    for seed in 0..5 {
        let [loose, tight] =
            [10.0, 0.0].map(|yaw_tolerance_deg| Drawn::draw(&scene_with("uniform", yaw_tolerance_deg), seed));
        assert_eq!(loose.wheel_radius_m, tight.wheel_radius_m);
        assert_eq!(loose.start, tight.start);
        assert_ne!(loose.floor_camera.unwrap().yaw_rad, tight.floor_camera.unwrap().yaw_rad);
    }
}
