//! A reading of the range camera drawn in the robot frame, with forward upwards: for each landmark code that was read, the box in which the localizer
//! claims the landmark to lie, and the landmark's true position.

use localizer::Claim;

use crate::{
    judge::is_true,
    run::{ImageRecord, RunRecord},
    scene::{RangeCamera, Scene},
};

use super::{
    canvas::{Canvas, Panel},
    palette,
};

/// Space below the robot, as a share of the panel's height.
const BELOW: f64 = 0.12;
const LABEL_PX: f32 = 16.0;

/// Draws the range camera's field of view, circles of equal range, and every landmark code that was read.
pub(super) fn draw(
    canvas: &mut Canvas,
    panel: Panel,
    scene: &Scene,
    camera: &RangeCamera,
    record: &RunRecord,
    image: &ImageRecord,
) {
    let pixels_per_m = panel.height_px * (1.0 - BELOW) / (camera.greatest_range_m + camera.forward_m.abs() + 0.2);
    let origin_px = [panel.left_px + 0.5 * panel.width_px, panel.top_px + panel.height_px * (1.0 - BELOW)];
    let place =
        |forward_m: f64, left_m: f64| [origin_px[0] - left_m * pixels_per_m, origin_px[1] - forward_m * pixels_per_m];
    canvas.clipped(panel, |canvas| {
        field_of_view(canvas, camera, place);
        canvas.ring(origin_px, scene.robot.body_radius_m * pixels_per_m, 1.2, palette::FAINT_INK);
        canvas.arrow(origin_px, place(0.8 * scene.robot.body_radius_m, 0.0), 2.0, palette::TRUTH);
        for claim in &image.claims {
            let Claim::Landmark { landmark, in_robot_m: [forward, left] } = claim else { continue };
            let is_so = is_true(claim, scene, &record.drawn, &image.truth);
            let colour = if is_so { palette::SEEN } else { palette::FALSE };
            let corners = [
                place(forward.lo(), left.hi()),
                place(forward.lo(), left.lo()),
                place(forward.hi(), left.lo()),
                place(forward.hi(), left.hi()),
            ];
            canvas.fill(&corners, colour, 0.3);
            canvas.outline(&corners, 1.5, colour);
            // Text is not clipped: a label above the panel would stand in what is written there.
            let label_top_px = (corners[3][1] - 20.0).max(panel.top_px + 2.0);
            canvas.text([corners[3][0], label_top_px], LABEL_PX, palette::INK, &landmark.0.to_string());
            if let Some(true_place) = scene.landmarks.get(landmark.0 as usize) {
                let (sin, cos) = image.truth.pose.heading_rad.sin_cos();
                let (x_m, y_m) = (true_place.x_m - image.truth.pose.x_m, true_place.y_m - image.truth.pose.y_m);
                canvas.ring(place(cos * x_m + sin * y_m, cos * y_m - sin * x_m), 2.0, 2.0, palette::TRUTH);
            }
        }
    });
}

/// Draws the edges of the horizontal field of view of the range camera, for the first of its two stereo views, and a circle for each metre of range
/// and for the least and the greatest range.
fn field_of_view(canvas: &mut Canvas, camera: &RangeCamera, place: impl Fn(f64, f64) -> [f64; 2]) {
    const STEPS: usize = 48;
    let half_rad = (0.5 * f64::from(camera.width_px) / camera.focal_px).atan();
    let at = |range_m: f64, share: f64| {
        let (sin, cos) = (camera.yaw_deg.to_radians() + half_rad * share).sin_cos();
        place(camera.forward_m + range_m * cos, camera.left_m + range_m * sin)
    };
    for side in [-1.0, 1.0] {
        canvas.line(at(camera.least_range_m, side), at(camera.greatest_range_m, side), 1.2, palette::JOINT);
    }
    let whole_metres = (1..).map(f64::from).take_while(|range_m| *range_m < camera.greatest_range_m);
    for range_m in whole_metres.chain([camera.least_range_m, camera.greatest_range_m]) {
        let share = |step: usize| 2.0 * step as f64 / STEPS as f64 - 1.0;
        (0..STEPS).for_each(|step| {
            canvas.line(at(range_m, share(step)), at(range_m, share(step + 1)), 1.0, palette::JOINT);
        });
        canvas.text(at(range_m, -1.0), LABEL_PX, palette::FAINT_INK, &format!(" {range_m} m"));
    }
}
