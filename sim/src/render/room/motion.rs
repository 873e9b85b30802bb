//! A camera's motion during exposure and readout: sub-frames (instants by which the exposure is approximated) with their poses and twists.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::{
    optics::Lens,
    place::building::{Panel, UprightBody},
};

/// Length of motion blur, in pixels, for which one sub-frame (an instant of the exposure) is drawn; it is less than the width of the pixel's own
/// filter together with the bilinear one.
const BLUR_PER_SUB_FRAME_PX: f64 = 1.5;
/// Greatest number of sub-frames (instants) by which an exposure is approximated; a longer blur shows as that many separate images.
pub(super) const MAX_SUB_FRAMES: usize = 64;
/// Number of pixels along each side of the image at which the length of the motion blur is estimated, by the surfaces seen there.
const PLACES_PER_SIDE: u32 = 7;
/// Distance that is assumed, to estimate motion blur, where no surface is seen.
const FARTHEST_M: f64 = 100.0;
/// Least distance of a surface from the lens that is considered in the estimate of motion blur.
const NEAREST_M: f64 = 0.05;

/// A sub-frame: one of the instants by which an exposure is approximated.
#[derive(Clone, Debug)]
pub(super) struct SubFrame {
    /// Camera pose of the sub-frame (an instant of the exposure), for the image's middle row.
    pub(super) world_from_camera: Isometry3<f64>,
    /// Turn rate of the camera at the sub-frame (an instant of the exposure), in the camera's frame.
    pub(super) turn_rad_per_s: Vector3<f64>,
    /// Velocity of the camera at the sub-frame (an instant of the exposure), in the camera's frame.
    pub(super) drift_m_per_s: Vector3<f64>,
    /// Time of the sub-frame, at most 0, counted from the end of the last row's exposure, the instant at which people are where they were placed.
    pub(super) before_end_s: f64,
}

/// Sub-frames, the instants by which an exposure is approximated. `poses` are camera poses at equal steps of time, from the start of the first
/// row's exposure to the end of the last row's.
///
/// n instants that are evenly spread would keep only 1 − 1/n² of the variance of a steady blur; they are spread wider to make up for it.
pub(super) fn sub_frames(
    lens: &Lens,
    poses: &[Isometry3<f64>],
    exposure_s: f64,
    (panels, bodies): (&[Panel], &[UprightBody]),
) -> Option<Vec<SubFrame>> {
    let readout_s = lens.readout_s();
    let total_s = exposure_s + readout_s;
    let at = |time_s: f64| interpolated(poses, if total_s > 0.0 { time_s / total_s } else { 0.5 });
    let (start, end) = (at(0.5 * readout_s)?, at(0.5 * readout_s + exposure_s)?);
    let of_bodies = bodies.iter().map(|body| body_blur_px(lens, [&start, &end], body, exposure_s)).fold(0.0, f64::max);
    let longest_px = of_bodies.max(blur_px(lens, [&start, &end], panels));
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

/// Estimate of the greatest motion in the image, in pixels, of anything that stands still while the camera moves from the first pose to the
/// second. It is taken over the surfaces seen at some pixels spread over the image.
fn blur_px(lens: &Lens, [start, end]: [&Isometry3<f64>; 2], panels: &[Panel]) -> f64 {
    if start == end {
        return 0.0;
    }
    let last = PLACES_PER_SIDE - 1;
    let along = |index: u32, axis: usize| f64::from(index) / f64::from(last) * f64::from(lens.size_px[axis] - 1);
    let eye = Point3::from(start.translation.vector);
    let moved_px = |pixel: [f64; 2]| {
        let [x, y] = lens.ray(pixel)?;
        let ray = start.rotation * Vector3::new(x, y, 1.0);
        let depths_m = panels.iter().filter_map(|panel| panel.seen_along(eye, ray));
        let depth_m = depths_m.filter(|depth_m| *depth_m > NEAREST_M).fold(FARTHEST_M, f64::min);
        way_px(lens, [start, end], [eye + ray * depth_m; 2])
    };
    let pixels = (0..=last).flat_map(|j| (0..=last).map(move |i| (i, j))).map(|(i, j)| [along(i, 0), along(j, 1)]);
    pixels.filter_map(moved_px).fold(0.0, f64::max)
}

/// Motion of a person over the image, in pixels, by walking and by the camera's motion; 0 for a person who is not in view.
fn body_blur_px(lens: &Lens, camera: [&Isometry3<f64>; 2], body: &UprightBody, exposure_s: f64) -> f64 {
    let [x, y] = body.velocity_m_per_s;
    let walked = Vector3::new(x, y, 0.0) * exposure_s;
    let [width, height] = lens.size_px.map(f64::from);
    let of_height = |share: f64| {
        let place = Point3::new(body.middle_m[0], body.middle_m[1], share * body.height_m);
        let places = [place - walked, place];
        let seen = [0, 1].map(|instant: usize| camera[instant].inverse_transform_point(&places[instant]));
        let in_view = seen.iter().any(|seen| {
            let [u, v] = lens.pixel([seen.x / seen.z, seen.y / seen.z]);
            seen.z > body.radius_m && (-width..2.0 * width).contains(&u) && (-height..2.0 * height).contains(&v)
        });
        // The near side of the person's body moves faster over the image than its middle.
        let depth_m = seen[0].z.min(seen[1].z);
        let nearer = depth_m / (depth_m - body.radius_m).max(NEAREST_M);
        in_view.then(|| way_px(lens, camera, places))?.map(|way_px| way_px * nearer)
    };
    [0.1, 0.5, 0.9].into_iter().filter_map(of_height).fold(0.0, f64::max)
}

/// Motion of a point over the image, in pixels, while point and camera move from their first to their last positions; `None` if the point gets
/// behind the camera.
fn way_px(lens: &Lens, camera: [&Isometry3<f64>; 2], places: [Point3<f64>; 2]) -> Option<f64> {
    let [first, last] = [0, 1].map(|instant: usize| {
        let seen = camera[instant].inverse_transform_point(&places[instant]);
        (seen.z > 0.0).then(|| lens.pixel([seen.x / seen.z, seen.y / seen.z]))
    });
    let ([u0, v0], [u1, v1]) = (first?, last?);
    Some((u1 - u0).hypot(v1 - v0))
}

/// The camera pose at a share of the time that is covered by poses at equal steps of time.
fn interpolated(poses: &[Isometry3<f64>], share: f64) -> Option<Isometry3<f64>> {
    let last = poses.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let index = (place as usize).min(last.saturating_sub(1));
    match poses.get(index + 1) {
        Some(next) => Some(poses[index].lerp_slerp(next, place - index as f64)),
        None => poses.first().copied(),
    }
}
