//! True lenses and poses of the cameras, as drawn at random for a seed.

use nalgebra::Isometry3;

use super::DrawnCamera;
use crate::{
    optics::{EQUIVALENT_LUMENS_PER_WATT_850_NM, Lens},
    scene::{Band, CameraKeys},
    truth::Truth,
};

impl Lens {
    /// The true lens of a camera, behind a filter that passes the camera's band. Only an infrared camera sees the light of the diodes around its lens;
    /// for a camera of visible light they are dark.
    pub fn of(camera: &dyn CameraKeys, drawn: &DrawnCamera) -> Lens {
        let shared = camera.shared();
        let ring_candela = match camera.band() {
            Band::Infrared => camera.ring_intensity_w_per_sr() * EQUIVALENT_LUMENS_PER_WATT_850_NM,
            Band::Visible => 0.0,
        };
        Lens {
            size_px: shared.size_px,
            focal_px: drawn.focal_px,
            principal_point_px: drawn.principal_point_px,
            distortion: drawn.distortion,
            vignetting: shared.lens.vignetting.unwrap_or(camera.darkens_off_axis()),
            defocus_px: shared.lens.defocus_px,
            row_time_s: shared.lens.row_time_s,
            band: camera.band(),
            ring_candela,
        }
    }
}

/// True pose of a camera in the world: its true mount on the body's true posture.
pub fn world_from_camera(truth: &Truth, drawn: &DrawnCamera) -> Isometry3<f64> {
    truth.world_from_body() * drawn.body_from_camera
}
