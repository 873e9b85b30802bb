//! The local frame, in which a picture's floor points are computed, and homographies between that frame and the image.

use nalgebra::{Isometry3, Matrix3, Rotation2, Vector2, vector};

use crate::{optics::Intrinsics, place::drawn::LaidTiles, scene::Tiles};

/// The frame `local`, in which the floor is drawn: the grid frame of the tiles moved to a corner near the camera, so that single precision
/// suffices.
pub(super) struct LocalFrame {
    pub(super) grid_from_world: Rotation2<f64>,
    pub(super) origin_in_grid: Vector2<f64>,
    /// Indices of the two floor joints that cross at the origin of the local frame.
    pub(super) corner: [i32; 2],
}

impl LocalFrame {
    /// The local frame, with its origin at the nominal tile corner nearest to a point in the world, or at that point itself on a floor without
    /// tiles.
    pub(super) fn near(place_m: Vector2<f64>, tiled: Option<&(Tiles, LaidTiles)>) -> LocalFrame {
        let Some((tiles, _)) = tiled else {
            return LocalFrame { grid_from_world: Rotation2::identity(), origin_in_grid: place_m, corner: [0; 2] };
        };
        let grid_from_world = Rotation2::new(-tiles.rotation_deg.to_radians());
        let edge_m = vector![tiles.edge_x_m, tiles.edge_y_m];
        let phase_m = vector![tiles.phase_x_m, tiles.phase_y_m];
        let index = (grid_from_world * place_m - phase_m).component_div(&edge_m).map(f64::round);
        LocalFrame {
            grid_from_world,
            origin_in_grid: index.component_mul(&edge_m) + phase_m,
            corner: [index.x as i32, index.y as i32],
        }
    }

    /// Coordinates of a point of the world in the local frame.
    pub(super) fn place(&self, place_in_world_m: Vector2<f64>) -> Vector2<f64> {
        self.grid_from_world * place_in_world_m - self.origin_in_grid
    }

    /// Homography from pixels about the principal point to the floor.
    ///
    /// A ray r = R·(u/f, v/f, 1) from the optical centre c meets z = 0 at c − r·c_z/r_z, that is (r_xy·c_z − c_xy·r_z) / (−r_z): numerator
    /// and denominator are linear in the pixel.
    pub(super) fn local_from_pixel(&self, world_from_camera: &Isometry3<f64>, focal_px: f64) -> Matrix3<f64> {
        let rotation = world_from_camera.rotation.to_rotation_matrix();
        let centre = world_from_camera.translation.vector;
        let centre_in_local = self.place(centre.xy());
        let mut matrix = Matrix3::zeros();
        for (column, scale) in [1.0 / focal_px, 1.0 / focal_px, 1.0].into_iter().enumerate() {
            let ray = rotation.matrix().column(column) * scale;
            let ray_in_local = self.grid_from_world * vector![ray[0], ray[1]];
            let numerator = ray_in_local * centre.z - centre_in_local * ray[2];
            matrix.set_column(column, &vector![numerator.x, numerator.y, -ray[2]]);
        }
        matrix
    }
}

/// Homography from the floor to clip space: x and y from −1 to 1 over the outer edges of the image, y up, and the depth as w.
///
/// `None` if the camera lies in the floor and looks along it.
pub(super) fn clip_from_local(local_from_pixel: &Matrix3<f64>, intrinsics: &Intrinsics) -> Option<Matrix3<f64>> {
    let [width, height] = intrinsics.size_px.map(f64::from);
    let [cu, cv] = intrinsics.principal_point_px;
    let (x, y) = (2.0 / width, -2.0 / height);
    // The outer edges of the first pixel are at −0.5.
    let clip_from_pixel = Matrix3::new(x, 0.0, (cu + 0.5) * x - 1.0, 0.0, y, (cv + 0.5) * y + 1.0, 0.0, 0.0, 1.0);
    let pixel_from_local = local_from_pixel.try_inverse()?;
    // The floor point of a pixel is n/d, with n and d linear in the pixel. The inverse of this matrix gives pixel·k with k = 1/d for the floor
    // point; the sign of k is that of the depth.
    Some(clip_from_pixel * pixel_from_local)
}
