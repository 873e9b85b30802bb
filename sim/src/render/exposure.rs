//! The camera's path during exposure and readout, which are divided into sub-frames (equal steps of time): the camera poses at the ends of the
//! sub-frames, and their number.

use nalgebra::{Isometry3, Vector2};

use super::View;
use crate::optics::Intrinsics;

/// Greatest number of sub-frames (equal steps of the exposure), as in view.wgsl; with a longer blur, each sub-frame averages over a longer part
/// of it.
pub(super) const MAX_SUB_FRAMES: usize = 32;

/// Length of motion blur, in the image, that one sub-frame (a step of the exposure) takes up. The filter of a sub-frame is exact for an edge that
/// moves straight and steadily, so that a sub-frame only has to follow the bend of the path: at 1 rad/s and 10 ms that is 0.01 px over the whole
/// exposure.
const BLUR_PER_SUB_FRAME_PX: f64 = 4.0;

/// Length of motion blur between two samples of a floor pattern. Each sample is averaged over this length, which is finer than the pattern's
/// grain.
const BLUR_PER_PATTERN_SAMPLE_PX: f64 = 2.0;
/// Greatest number of samples of a floor pattern along the motion blur; a longer blur leaves nothing of the pattern.
const MAX_PATTERN_SAMPLES: u32 = 32;

/// The path of a camera from the start of the first row's exposure to the end of the last row's.
pub(super) struct Path {
    /// Camera poses at equal steps of time, one more than the exposure has sub-frames (steps into which it is divided). With a global shutter
    /// they are the ends of the sub-frames.
    pub(super) sub_frame_ends: Vec<Isometry3<f64>>,
    /// Number of times that a floor pattern is sampled along the camera's path.
    pub(super) pattern_samples: u32,
    /// Camera pose in the middle of the middle row's exposure.
    pub(super) middle: Isometry3<f64>,
    /// Share of the time from the start of the first row's exposure to the end of the last row's for which each row is exposed; 1 with a global
    /// shutter.
    pub(super) exposed_share: f64,
}

impl Path {
    /// The camera's path for one view (a picture to take), with the projection `plate`; `None` if the view has no camera pose.
    pub(super) fn new(plate: &Intrinsics, view: &View) -> Option<Path> {
        let (world_from_camera, readout_s) = (&view.world_from_camera, view.lens.readout_s());
        let exposed_share = if readout_s > 0.0 { view.exposure_s / (view.exposure_s + readout_s) } else { 1.0 };
        let blur_px = blur_length_px(plate, world_from_camera) * exposed_share;
        let count = ((blur_px / BLUR_PER_SUB_FRAME_PX).ceil() as usize).clamp(1, MAX_SUB_FRAMES);
        let sub_frame_ends = (0..=count)
            .map(|end| interpolate(world_from_camera, end as f64 / count as f64))
            .collect::<Option<Vec<_>>>()?;
        let samples = (blur_px / BLUR_PER_PATTERN_SAMPLE_PX).ceil() as u32;
        Some(Path {
            sub_frame_ends,
            pattern_samples: samples.clamp(1, MAX_PATTERN_SAMPLES),
            middle: interpolate(world_from_camera, 0.5)?,
            exposed_share,
        })
    }
}

/// Greatest length of the path that a floor point, seen at the image's corners or centre, describes on the image during exposure and readout.
fn blur_length_px(intrinsics: &Intrinsics, world_from_camera: &[Isometry3<f64>]) -> f64 {
    let [width, height] = intrinsics.size_px.map(|size| f64::from(size - 1));
    let pixels = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height], [width / 2.0, height / 2.0]];
    let step_px = |from: &Isometry3<f64>, to: &Isometry3<f64>, pixel: [f64; 2]| {
        let point = to.inverse_transform_point(&intrinsics.floor_point(from, pixel)?);
        let moved = intrinsics.project([point.x, point.y, point.z]);
        (point.z > 0.0).then(|| Vector2::new(moved[0] - pixel[0], moved[1] - pixel[1]).norm())
    };
    let path_px = |pixel: [f64; 2]| -> f64 {
        world_from_camera.windows(2).filter_map(|pair| step_px(&pair[0], &pair[1], pixel)).sum()
    };
    pixels.into_iter().map(path_px).fold(0.0, f64::max)
}

/// The camera pose at a share of the time between the first and the last of the given poses.
pub(super) fn interpolate(poses: &[Isometry3<f64>], share: f64) -> Option<Isometry3<f64>> {
    let position = share * (poses.len().checked_sub(1)?) as f64;
    let index = (position as usize).min(poses.len().saturating_sub(2));
    let next = poses.get(index + 1).unwrap_or(&poses[index]);
    Some(poses[index].lerp_slerp(next, position - index as f64))
}
