//! Sub-frames of an exposure: how many, and where the camera is at their ends.

use nalgebra::{Isometry3, Point3, Vector2};

use crate::sensors::camera::Intrinsics;

/// Sub-frames at most; a longer blur widens the filter of each.
pub(super) const MAX_SUB_FRAMES: usize = 32;

/// Blur that one sub-frame takes up. Its filter is exact for edges that move straight, so this only has to hold the
/// curvature of the path and to sample the pattern: at 2 px the pattern is still finer than the filter.
const BLUR_PER_SUB_FRAME_PX: f64 = 2.0;

/// Camera poses at the ends of equally long sub-frames: one more than there are sub-frames.
pub(super) fn sub_frame_ends(intrinsics: &Intrinsics, world_from_camera: &[Isometry3<f64>]) -> Vec<Isometry3<f64>> {
    let blur_px = blur_length_px(intrinsics, world_from_camera);
    let count = ((blur_px / BLUR_PER_SUB_FRAME_PX).ceil() as usize).clamp(1, MAX_SUB_FRAMES);
    (0..=count).map(|end| interpolate(world_from_camera, end as f64 / count as f64)).collect()
}

/// Longest path on the image of the floor points seen at the image's corners and centre.
fn blur_length_px(intrinsics: &Intrinsics, world_from_camera: &[Isometry3<f64>]) -> f64 {
    let [width, height] = intrinsics.size_px.map(|size| f64::from(size - 1));
    let pixels = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height], [width / 2.0, height / 2.0]];
    let longest = |pixel: [f64; 2]| -> f64 {
        world_from_camera
            .windows(2)
            .map(|pair| {
                let Some(point) = floor_point(intrinsics, &pair[0], pixel) else {
                    return 0.0;
                };
                let later = pair[1].inverse_transform_point(&point);
                if later.z <= 0.0 {
                    return 0.0;
                }
                let moved = intrinsics.project([later.x, later.y, later.z]);
                Vector2::new(moved[0] - pixel[0], moved[1] - pixel[1]).norm()
            })
            .sum()
    };
    pixels.into_iter().map(longest).fold(0.0, f64::max)
}

/// Where the ray of a pixel meets the floor, if it does.
pub(super) fn floor_point(
    intrinsics: &Intrinsics,
    world_from_camera: &Isometry3<f64>,
    pixel: [f64; 2],
) -> Option<Point3<f64>> {
    let ray = world_from_camera.rotation * intrinsics.ray(pixel);
    let centre = world_from_camera.translation.vector;
    (ray.z < 0.0).then(|| Point3::from(centre - ray * (centre.z / ray.z)))
}

/// The pose at a share of the time between the first and the last.
fn interpolate(poses: &[Isometry3<f64>], share: f64) -> Isometry3<f64> {
    let position = share * (poses.len() - 1) as f64;
    let index = (position as usize).min(poses.len().saturating_sub(2));
    match poses.get(index + 1) {
        Some(next) => poses[index].lerp_slerp(next, position - index as f64),
        None => poses[index],
    }
}
