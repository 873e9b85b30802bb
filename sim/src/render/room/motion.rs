//! A camera's motion while it exposes and reads out: sub-frames with their poses and twists.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::{building::UprightBody, sensors::lens::Lens};

/// Blur that is drawn as one sub-frame: below the width of the pixel's own filter and the bilinear one together.
const BLUR_PER_SUB_FRAME_PX: f64 = 1.5;
/// Sub-frames at most; a longer blur shows as so many images.
pub(super) const MAX_SUB_FRAMES: usize = 24;
/// Things are taken to be this far when the length of blur is estimated: nearer than most.
const TYPICAL_DEPTH_M: f64 = 1.0;

/// One of the instants that stand for an exposure.
#[derive(Clone, Debug)]
pub(super) struct SubFrame {
    /// While the middle row is exposed.
    pub(super) world_from_camera: Isometry3<f64>,
    /// In the camera's frame.
    pub(super) turn_rad_per_s: Vector3<f64>,
    /// In the camera's frame.
    pub(super) drift_m_per_s: Vector3<f64>,
    /// From the end of the last row's exposure, when people are where they were placed; below 0.
    pub(super) before_end_s: f64,
}

/// Sub-frames of an exposure, with poses at equal steps from the start of the first row's exposure to the end of the last's.
///
/// n instants spread evenly would keep only 1 − 1/n² of the variance of a steady blur; they are spread wider by that much.
pub(super) fn sub_frames(
    lens: &Lens,
    poses: &[Isometry3<f64>],
    exposure_s: f64,
    bodies: &[UprightBody],
) -> Option<Vec<SubFrame>> {
    let readout_s = lens.readout_s();
    let total_s = exposure_s + readout_s;
    let at = |time_s: f64| interpolated(poses, if total_s > 0.0 { time_s / total_s } else { 0.5 });
    let (start, end) = (at(0.5 * readout_s)?, at(0.5 * readout_s + exposure_s)?);
    let longest_px = bodies.iter().map(|body| body_blur_px(lens, &start, body, exposure_s)).fold(0.0, f64::max);
    let longest_px = longest_px.max(blur_px(lens, &start, &end));
    let count = ((longest_px / BLUR_PER_SUB_FRAME_PX).ceil() as usize).clamp(1, MAX_SUB_FRAMES);
    let spread = if count > 1 { 1.0 / (1.0 - 1.0 / (count * count) as f64).sqrt() } else { 1.0 };
    (0..count)
        .map(|index| {
            let within = 0.5 + ((index as f64 + 0.5) / count as f64 - 0.5) * spread;
            let first_row_s = within * exposure_s;
            let (start, middle, end) =
                (at(first_row_s)?, at(first_row_s + 0.5 * readout_s)?, at(first_row_s + readout_s)?);
            let per_s = if readout_s > 0.0 { 1.0 / readout_s } else { 0.0 };
            Some(SubFrame {
                turn_rad_per_s: (start.rotation.inverse() * end.rotation).scaled_axis() * per_s,
                drift_m_per_s: middle.rotation.inverse() * (end.translation.vector - start.translation.vector) * per_s,
                world_from_camera: middle,
                before_end_s: first_row_s + 0.5 * readout_s - total_s,
            })
        })
        .collect()
}

/// The longest way that a typical thing at rest moves over the image, at its corners and its middle.
fn blur_px(lens: &Lens, start: &Isometry3<f64>, end: &Isometry3<f64>) -> f64 {
    let [width, height] = lens.size_px.map(|size| f64::from(size - 1));
    let pixels = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height], [width / 2.0, height / 2.0]];
    let moved_px = |pixel: [f64; 2]| {
        let [x, y] = lens.ray(pixel)?;
        let thing = start * Point3::new(x * TYPICAL_DEPTH_M, y * TYPICAL_DEPTH_M, TYPICAL_DEPTH_M);
        let moved = end.inverse_transform_point(&thing);
        let seen = lens.pixel([moved.x / moved.z, moved.y / moved.z]);
        (moved.z > 0.0).then(|| (seen[0] - pixel[0]).hypot(seen[1] - pixel[1]))
    };
    pixels.into_iter().filter_map(moved_px).fold(0.0, f64::max)
}

/// The way that a walking person moves over the image; nothing for one who is not in view.
fn body_blur_px(lens: &Lens, world_from_camera: &Isometry3<f64>, body: &UprightBody, exposure_s: f64) -> f64 {
    let [x, y] = body.velocity_m_per_s;
    let way = world_from_camera.rotation.inverse() * Vector3::new(x, y, 0.0) * exposure_s;
    let [width, height] = lens.size_px.map(f64::from);
    let of_height = |share: f64| {
        let place = Point3::new(body.middle_m[0], body.middle_m[1], share * body.height_m);
        let seen = world_from_camera.inverse_transform_point(&place);
        let [u, v] = lens.pixel([seen.x / seen.z, seen.y / seen.z]);
        let in_view =
            seen.z > body.radius_m && (-width..2.0 * width).contains(&u) && (-height..2.0 * height).contains(&v);
        in_view.then(|| way.norm() * lens.focal_px[0] / seen.z)
    };
    [0.1, 0.5, 0.9].into_iter().filter_map(of_height).fold(0.0, f64::max)
}

/// The pose at a share of the way through poses at equal steps.
fn interpolated(poses: &[Isometry3<f64>], share: f64) -> Option<Isometry3<f64>> {
    let last = poses.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let index = (place as usize).min(last.saturating_sub(1));
    match poses.get(index + 1) {
        Some(next) => Some(poses[index].lerp_slerp(next, place - index as f64)),
        None => poses.first().copied(),
    }
}
