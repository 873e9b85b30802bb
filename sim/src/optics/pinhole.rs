//! A pinhole camera: projection through a point.

use nalgebra::{Isometry3, Point3, Vector3, vector};

/// A pinhole projection without distortion. In the image u points right and v down, and (0, 0) is the centre of the first pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Width and height of the image.
    pub size_px: [u32; 2],
    /// Focal length of the camera.
    pub focal_px: f64,
    /// Principal point, where the optical axis meets the image.
    pub principal_point_px: [f64; 2],
}

impl Intrinsics {
    /// A pinhole projection whose principal point is the middle of the image.
    pub fn centred(size_px: [u32; 2], focal_px: f64) -> Intrinsics {
        let principal_point_px = size_px.map(|size| (f64::from(size) - 1.0) / 2.0);
        Intrinsics { size_px, focal_px, principal_point_px }
    }

    /// Image of a point in the camera frame. The point must lie in front of the camera.
    pub fn project(&self, point_in_camera: [f64; 3]) -> [f64; 2] {
        let [x, y, z] = point_in_camera;
        let [cu, cv] = self.principal_point_px;
        [cu + self.focal_px * x / z, cv + self.focal_px * y / z]
    }

    /// Ray of a pixel in the camera frame, as a vector with depth 1.
    pub fn ray(&self, pixel: [f64; 2]) -> Vector3<f64> {
        let [cu, cv] = self.principal_point_px;
        vector![(pixel[0] - cu) / self.focal_px, (pixel[1] - cv) / self.focal_px, 1.0]
    }

    /// Point at which the ray of a pixel meets the world's floor plane; `None` for a pixel above the horizon.
    pub fn floor_point(&self, world_from_camera: &Isometry3<f64>, pixel: [f64; 2]) -> Option<Point3<f64>> {
        let ray = world_from_camera.rotation * self.ray(pixel);
        let centre = world_from_camera.translation.vector;
        (ray.z < 0.0).then(|| Point3::from(centre - ray * (centre.z / ray.z)))
    }
}
