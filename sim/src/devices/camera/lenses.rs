//! True lenses and poses of the cameras, as drawn at random for a seed.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, vector};

use super::{DrawnCamera, DrawnFloorCamera};
use crate::{
    optics::{EQUIVALENT_LUMENS_PER_WATT_850_NM, Lens, mounts::mount_from_looking_down},
    scene::{Band, CeilingCamera, FloorCamera, ForwardCamera, LensKeys},
    truth::Truth,
};

impl Lens {
    /// The true lens of the floor camera.
    pub fn floor(camera: &FloorCamera, drawn: &DrawnFloorCamera) -> Lens {
        let ideal = Lens::ideal([camera.width_px, camera.height_px], drawn.focal_px);
        Lens { vignetting: camera.lens.vignetting.unwrap_or(false), ..ideal.with(&camera.lens, drawn.distortion) }
    }

    /// The true lens of the forward camera.
    pub fn forward(camera: &ForwardCamera, drawn: &DrawnCamera) -> Lens {
        let ideal = Lens::ideal([camera.width_px, camera.height_px], 1.0);
        ideal.mounted(&camera.lens, drawn).seeing(camera.band, camera.ring_intensity_w_per_sr)
    }

    /// The true lens of the ceiling camera.
    pub fn ceiling(camera: &CeilingCamera, drawn: &DrawnCamera) -> Lens {
        let ideal = Lens::ideal([camera.width_px, camera.height_px], 1.0);
        ideal.mounted(&camera.lens, drawn).seeing(camera.band, camera.ring_intensity_w_per_sr)
    }

    /// This lens behind a spectral filter, with a ring of infrared diodes around it. Only an infrared camera sees the diodes' light; for a camera of
    /// visible light the ring is dark.
    fn seeing(self, band: Band, ring_intensity_w_per_sr: f64) -> Lens {
        let ring_candela = match band {
            Band::Infrared => ring_intensity_w_per_sr * EQUIVALENT_LUMENS_PER_WATT_850_NM,
            Band::Visible => 0.0,
        };
        Lens { band, ring_candela, ..self }
    }

    fn mounted(self, keys: &LensKeys, drawn: &DrawnCamera) -> Lens {
        let placed = Lens { focal_px: drawn.focal_px, principal_point_px: drawn.principal_point_px, ..self };
        placed.with(keys, drawn.distortion)
    }

    fn with(self, keys: &LensKeys, distortion: [f64; 5]) -> Lens {
        let (vignetting, defocus_px) = (keys.vignetting.unwrap_or(true), keys.defocus_px);
        Lens { distortion, vignetting, defocus_px, row_time_s: keys.row_time_s, ..self }
    }
}

/// True pose of a camera in the world: its true mount on the body's true posture.
pub fn world_from_camera(truth: &Truth, drawn: &DrawnCamera) -> Isometry3<f64> {
    truth.world_from_body() * drawn.body_from_camera
}

/// True pose of the floor camera in the world: its true mount on the body's true posture.
pub fn world_from_floor_camera(truth: &Truth, camera: &DrawnFloorCamera) -> Isometry3<f64> {
    let [forward_m, left_m] = camera.position_m;
    let tilt = vector![camera.tilt_rad[0], camera.tilt_rad[1], 0.0];
    let body_from_mount = Isometry3::from_parts(
        Translation3::new(forward_m, left_m, camera.height_m),
        UnitQuaternion::from_scaled_axis(tilt) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), camera.yaw_rad),
    );
    truth.world_from_body() * body_from_mount * mount_from_looking_down()
}
