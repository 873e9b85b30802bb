//! Things whose panels are seen from their side, narrower than a pixel: one sample a pixel would make dashes of them, so that they are left out.

use nalgebra::{Isometry3, Point3, Vector2};

use crate::{
    building::{Panel, Part},
    sensors::lens::Lens,
};

/// Narrower panels are left out.
const NARROWEST_PX: f64 = 0.8;
/// As in view.wgsl.
const NEAR_M: f64 = 0.02;

/// Whether a thing's panel is too narrow to be seen, as a pinhole sees it; what encloses a room is always drawn.
pub(super) fn is_sliver(panel: &Panel, world_from_camera: &Isometry3<f64>, lens: &Lens) -> bool {
    let corners = [Default::default(), panel.along, panel.along + panel.up, panel.up].map(|way| {
        let seen = world_from_camera.inverse_transform_point(&(panel.corner + way));
        (seen.z > NEAR_M).then(|| pixel(seen, lens))
    });
    let [Some(a), Some(b), Some(c), Some(d)] = corners else { return false };
    let area_px = 0.5 * ((c - a).perp(&(d - b))).abs();
    let longest_px = [b - a, c - b, d - c, a - d].iter().map(Vector2::norm).fold(0.0, f64::max);
    panel.part == Part::Thing && area_px < NARROWEST_PX * longest_px
}

fn pixel(seen: Point3<f64>, lens: &Lens) -> Vector2<f64> {
    Vector2::new(seen.x / seen.z * lens.focal_px[0], seen.y / seen.z * lens.focal_px[1])
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, vector};

    use super::*;
    use crate::building::Material;

    #[test]
    fn a_panel_three_centimetres_deep_is_a_sliver_where_it_shows_less_than_a_pixel() {
        // From the side at 4 m, its far border lies 0.03 m deeper: at 0.2 m aside, 417 px·0.2·0.03/4² = 0.16 px; at 2 m aside 1.6 px.
        let panel = |aside_m: f64| Panel {
            corner: Point3::new(aside_m, -1.0, 4.0),
            along: vector![0.0, 0.0, 0.03],
            up: vector![0.0, 2.0, 0.0],
            material: Material::matt(0.5),
            part: Part::Thing,
            room: 0,
        };
        let lens = Lens::ideal([640, 480], 417.0);
        let camera = Isometry3::from(Translation3::identity());
        assert!(is_sliver(&panel(0.2), &camera, &lens));
        assert!(!is_sliver(&panel(2.0), &camera, &lens));
    }
}
