//! The camera's path while it exposes and reads out: where it is at the ends of sub-frames, and how many there are.

use nalgebra::{Isometry3, Vector2};

use super::View;
use crate::optics::Intrinsics;

/// Sub-frames at most, as in view.wgsl; a longer blur widens the filter of each.
pub(super) const MAX_SUB_FRAMES: usize = 32;

/// Blur that one sub-frame takes up. Its filter is exact for an edge that moves straight and steadily, so that a
/// sub-frame only has to hold the path's bend: at 1 rad/s and 10 ms that is 0.01 px over the whole exposure.
const BLUR_PER_SUB_FRAME_PX: f64 = 4.0;

/// Blur between two samples of a pattern, which are filtered by as much: finer than the pattern's grain.
const BLUR_PER_PATTERN_SAMPLE_PX: f64 = 2.0;
/// Samples of a pattern at most; a longer blur leaves nothing of it.
const MAX_PATTERN_SAMPLES: u32 = 32;

/// The way of a camera from the start of the first row's exposure to the end of the last row's.
pub(super) struct Path {
    /// Poses at equal steps of time: one more than a row's exposure takes sub-frames. Of a global shutter they are the sub-frames' ends.
    pub(super) sub_frame_ends: Vec<Isometry3<f64>>,
    /// How often a pattern is sampled along the way.
    pub(super) pattern_samples: u32,
    /// The pose in the middle of the middle row's exposure.
    pub(super) middle: Isometry3<f64>,
    /// Share of the time that each row is exposed for: all of it by a global shutter.
    pub(super) exposed_share: f64,
}

impl Path {
    /// The path of a view whose plate has this projection; `None` if it has no pose.
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

/// Longest path on the image of the floor points seen at the image's corners and centre.
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

/// The pose at a share of the time between the first and the last.
pub(super) fn interpolate(poses: &[Isometry3<f64>], share: f64) -> Option<Isometry3<f64>> {
    let position = share * (poses.len().checked_sub(1)?) as f64;
    let index = (position as usize).min(poses.len().saturating_sub(2));
    let next = poses.get(index + 1).unwrap_or(&poses[index]);
    Some(poses[index].lerp_slerp(next, position - index as f64))
}
