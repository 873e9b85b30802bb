//! Strips: flat faces of things that are hardly wider than a pixel. With one sample a pixel they would look like dashed lines, so that each pixel
//! is covered by the share of the strip in it instead.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Isometry3, Point3, Vector2};

use super::faces::cells_along;
use crate::{
    optics::Lens,
    place::building::{Panel, Part},
};

/// Width in pixels below which flat faces are drawn as strips. From two pixels on, each of a face's two edges has pixels of its own.
const NARROWEST_PX: f64 = 2.0;
/// Distance from the camera up to which nothing is drawn (the near plane), as in view.wgsl.
const NEAR_M: f64 = 0.02;

/// Device layout of `Strip` of strip.wgsl: a flat face hardly wider than a pixel, or a part of its length.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct StripOnDevice {
    surface: u32,
    /// 0 if the first side of the face that is drawn as a strip is the long one, 1 if the second side is.
    long_side: u32,
    /// The part of the flat face that the strip covers, as shares of the face's long side from 0 to 1.
    from_to: [f32; 2],
}

/// Index, 0 or 1, of the long side of a flat face (panel) that a pinhole camera sees too narrow to draw it as a face. It is `None` for floors,
/// walls and ceilings, and for faces that are wide enough.
pub(super) fn long_side(panel: &Panel, world_from_camera: &Isometry3<f64>, lens: &Lens) -> Option<usize> {
    if panel.part != Part::Thing {
        return None;
    }
    let corners = [Default::default(), panel.along, panel.along + panel.up, panel.up].map(|way| {
        let seen = world_from_camera.inverse_transform_point(&(panel.corner + way));
        (seen.z > NEAR_M).then(|| pixel(seen, lens))
    });
    let [Some(a), Some(b), Some(c), Some(d)] = corners else { return None };
    let area_px = 0.5 * ((c - a).perp(&(d - b))).abs();
    let longest_px = [(b - a).norm().max((d - c).norm()), (c - b).norm().max((a - d).norm())];
    let long = usize::from(longest_px[1] > longest_px[0]);
    (area_px < NARROWEST_PX * longest_px[long]).then_some(long)
}

/// The strips for a narrow flat face; none if it faces none of the camera positions. There is one strip for the whole face, or for a rolling
/// shutter one for each length into which faces are cut.
pub(super) fn strips(
    (index, panel): (usize, &Panel),
    long: usize,
    eyes: &[Point3<f64>],
    rolling: bool,
) -> impl Iterator<Item = StripOnDevice> + use<> {
    let normal = panel.along.cross(&panel.up);
    let faces = eyes.iter().any(|eye| normal.dot(&(eye - panel.corner)) > 0.0);
    let count = match (faces, rolling) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => cells_along(panel.size_m()[long]),
    };
    (0..count).map(move |part| StripOnDevice {
        surface: index as u32,
        long_side: long as u32,
        from_to: [part, part + 1].map(|end| end as f32 / count as f32),
    })
}

fn pixel(seen: Point3<f64>, lens: &Lens) -> Vector2<f64> {
    Vector2::new(seen.x / seen.z * lens.focal_px[0], seen.y / seen.z * lens.focal_px[1])
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, vector};

    use super::*;
    use crate::place::building::Material;

    #[test]
    fn a_panel_three_centimetres_deep_is_a_strip_where_it_shows_less_than_two_pixels() {
        // Seen from the side at 4 m, the face's far border lies 0.03 m deeper. At 0.2 m aside it shows 417 px·0.2·0.03/4² = 0.16 px, at 4 m aside
        // 3.1 px.
        let panel = |aside_m: f64| Panel {
            corner: Point3::new(aside_m, -1.0, 4.0),
            along: vector![0.0, 0.0, 0.03],
            up: vector![0.0, 2.0, 0.0],
            material: Material::matt(0.5),
            part: Part::Thing,
            room: 0,
            outline: None,
        };
        let lens = Lens::ideal([640, 480], 417.0);
        let camera = Isometry3::from(Translation3::identity());
        assert_eq!(long_side(&panel(0.2), &camera, &lens), Some(1));
        assert_eq!(long_side(&panel(4.0), &camera, &lens), None);
        assert_eq!(long_side(&Panel { part: Part::Wall, ..panel(0.2) }, &camera, &lens), None);
    }

    #[test]
    fn strips_are_of_faces_seen_from_in_front_and_cut_for_a_rolling_shutter() {
        let panel = Panel {
            corner: Point3::new(0.2, -1.0, 4.0),
            along: vector![0.0, 0.0, 0.03],
            up: vector![0.0, 2.0, 0.0],
            material: Material::matt(0.5),
            part: Part::Thing,
            room: 0,
            outline: None,
        };
        // The normal of the flat face, along × up, points to −x.
        let count = |x_m: f64, rolling: bool| strips((7, &panel), 1, &[Point3::new(x_m, 0.0, 0.0)], rolling).count();
        assert_eq!([count(0.0, false), count(0.0, true), count(1.0, false), count(1.0, true)], [1, 20, 0, 0]);
        let ends: Vec<_> = strips((7, &panel), 1, &[Point3::origin()], true).map(|strip| strip.from_to).collect();
        assert!((0..20).all(|part| ends[part] == [part, part + 1].map(|end| end as f32 / 20.0)), "{ends:?}");
    }
}
