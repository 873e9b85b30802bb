//! What a log says about the cameras' lenses, compared with what the robot's file says, or put in its place.

use localizer::reading::Camera;
use serde_json::{Value, json};

use super::messages::LensInfo;
use crate::scene::{Calibration, Scene};

/// A lens as a log has it, beside the declared one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LensFound {
    pub(super) camera: Camera,
    /// For each quantity its name, the value in the log, the declared one and the declared bound on its error.
    pub(super) quantities: Vec<(&'static str, f64, f64, f64)>,
    /// Where the lens cannot be compared, why.
    pub(super) unread: Option<String>,
}

impl LensFound {
    /// Quantities in which the log departs from what is declared by more than its bound.
    pub(super) fn departing(&self) -> impl Iterator<Item = &(&'static str, f64, f64, f64)> {
        // Values that were rounded to six digits on their way count as equal.
        self.quantities
            .iter()
            .filter(|(_, stated, declared, within)| (stated - declared).abs() > within + 1e-6 * declared.abs().max(1.0))
    }

    pub(super) fn to_json(&self) -> Value {
        let quantities = self.quantities.iter();
        json!({
            "camera": self.camera.device(),
            "unread": self.unread,
            "quantities": quantities.map(|(name, stated, declared, within)| {
                json!({ "name": name, "in_log": stated, "declared": declared, "declared_bound": within })
            }).collect::<Vec<_>>(),
        })
    }
}

/// The five coefficients k1, k2, p1, p2, k3 of a lens, or why it has others.
fn plumb_bob(lens: &LensInfo) -> Result<[f64; 5], String> {
    // A camera without distortion may leave the model empty.
    let is_known = ["plumb_bob", ""].contains(&lens.model.as_str()) && lens.distortion.len() <= 5;
    if !is_known {
        let n = lens.distortion.len();
        return Err(format!(
            "distortion `{}` with {n} coefficients, of which only `plumb_bob` with five is read",
            lens.model
        ));
    }
    let mut five = [0.0; 5];
    five[..lens.distortion.len()].copy_from_slice(&lens.distortion);
    Ok(five)
}

/// Puts the lens of a log in the place of the declared one, as far as the camera has keys for it.
pub(super) fn adopt(scene: &mut Scene, camera: Camera, lens: &LensInfo) {
    let Ok(distortion) = plumb_bob(lens) else { return };
    if lens.focal_px.iter().any(|focal_px| *focal_px <= 0.0) {
        return;
    }
    let robot = &mut scene.robot;
    match camera {
        Camera::Floor => {
            if let Some(keys) = &mut robot.floor_camera {
                keys.footprint_width_m = f64::from(keys.width_px) * keys.height_m / lens.focal_px[0];
                keys.lens.distortion = distortion;
            }
        }
        Camera::Forward => {
            if let Some(keys) = &mut robot.forward_camera {
                let half = f64::from(keys.width_px) / 2.0 / lens.focal_px[0];
                keys.horizontal_view_deg = 2.0 * half.atan().to_degrees();
                keys.lens.distortion = distortion;
            }
        }
        Camera::Ceiling => {
            if let Some(keys) = &mut robot.ceiling_camera {
                keys.focal_px = lens.focal_px;
                keys.principal_point_px = lens.principal_point_px;
                keys.lens.distortion = distortion;
            }
        }
    }
}

/// Compares the lens of a log with the declared one; `None` for a camera that the robot does not have.
pub(super) fn compare(scene: &Scene, camera: Camera, lens: &LensInfo) -> Option<LensFound> {
    let keys = scene.robot.camera(camera)?;
    let distortion = match plumb_bob(lens) {
        Ok(distortion) => distortion,
        Err(why) => return Some(LensFound { camera, quantities: Vec::new(), unread: Some(why) }),
    };
    let (size_px, focal_px, centre_px) = (keys.shared().size_px, keys.focal_px(), keys.principal_point_px());
    let of = |calibration: &Calibration| {
        (calibration.focal_tolerance, calibration.principal_point_tolerance_px, calibration.distortion_tolerance_px)
    };
    let robot = &scene.robot;
    let (focal_share, centre_within_px, bent_px) = match camera {
        Camera::Floor => robot.floor_camera.as_ref().map(|keys| {
            // A floor camera is calibrated by the scale and the place of its image on the floor, so that its principal point is within the accuracy
            // of its position.
            (keys.scale_tolerance, keys.position_tolerance_m * keys.pixels_per_m(), keys.distortion_tolerance_px)
        })?,
        Camera::Forward => of(&robot.forward_camera.as_ref()?.calibration),
        Camera::Ceiling => of(&robot.ceiling_camera.as_ref()?.calibration),
    };
    let declared = keys.shared().lens.distortion;
    // Distance between where the two models put the corner of the image.
    let corner = [0, 1].map(|axis| 0.5 * f64::from(size_px[axis]) / focal_px[axis]);
    let [one, other] = [distortion, declared].map(|model| distorted(model, corner));
    let apart_px = ((one[0] - other[0]) * focal_px[0]).hypot((one[1] - other[1]) * focal_px[1]);
    let quantities = vec![
        ("width_px", f64::from(lens.size_px[0]), f64::from(size_px[0]), 0.0),
        ("height_px", f64::from(lens.size_px[1]), f64::from(size_px[1]), 0.0),
        ("focal_u_px", lens.focal_px[0], focal_px[0], focal_share * focal_px[0]),
        ("focal_v_px", lens.focal_px[1], focal_px[1], focal_share * focal_px[1]),
        ("principal_point_u_px", lens.principal_point_px[0], centre_px[0], centre_within_px),
        ("principal_point_v_px", lens.principal_point_px[1], centre_px[1], centre_within_px),
        ("distortion_at_corner_px", apart_px, 0.0, bent_px),
    ];
    Some(LensFound { camera, quantities, unread: None })
}

/// Brown and Conrady's model for coordinates in focal lengths from the principal point.
fn distorted([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [f64; 2]) -> [f64; 2] {
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    [x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y]
}
