//! Profiles of grey level across a line at full resolution, one every few pixels along the line.

use super::Picture;
use super::joint_filter::MAX_SAMPLES;
use super::vote::Candidate;

/// Length along a line, in pixels, over which grey levels are averaged into one profile across the line.
pub(super) const STATION_PX: f64 = 8.0;

/// Mean logarithmic grey-level profiles across a line, one per position, in their order along the line.
pub(super) struct Profiles {
    /// Number of samples of a profile on either side of the line. A profile has `2·half + 1` samples along the normal, one pixel apart.
    pub(super) half: usize,
    /// Position of each profile along the line, counted from the foot of the perpendicular from the image's centre.
    pub(super) along_px: Vec<f64>,
    /// Samples of the grey-level profiles, one profile after the other; a profile that is black or clipped has `NaN` as its first sample.
    samples: Vec<f32>,
}

impl Profiles {
    /// Samples of one grey-level profile, or `None` where the sensor was black or clipped.
    pub(super) fn get(&self, station: usize) -> Option<&[f32]> {
        let length = 2 * self.half + 1;
        let profile = &self.samples[station * length..(station + 1) * length];
        profile[0].is_finite().then_some(profile)
    }

    /// Replaces each group of `group` neighbouring profiles by their mean: noise decreases, but fewer points can be measured.
    pub(super) fn merged(&self, group: usize) -> Profiles {
        let length = 2 * self.half + 1;
        let (mut along_px, mut samples) = (Vec::new(), Vec::new());
        for first in (0..self.along_px.len()).step_by(group) {
            let members = first..(first + group).min(self.along_px.len());
            let usable: Vec<usize> = members.filter(|&station| self.get(station).is_some()).collect();
            if usable.is_empty() {
                continue;
            }
            along_px.push(usable.iter().map(|&station| self.along_px[station]).sum::<f64>() / usable.len() as f64);
            for sample in 0..length {
                samples.push(
                    usable.iter().map(|&station| self.samples[station * length + sample]).sum::<f32>()
                        / usable.len() as f32,
                );
            }
        }
        Profiles { half: self.half, along_px, samples }
    }
}

/// Range of grey levels in which a profile across a line is trusted: below it, eight bits are too coarse for a logarithm; above it, the sensor clips.
const USABLE_GREY: [f32; 2] = [3.0, 248.0];

/// Reads the grey-level profiles across a line, at all positions along it at which the whole width of a profile lies in the image.
pub(super) fn profiles(picture: &Picture, line: &Candidate, half: usize) -> Profiles {
    let half = half.min((MAX_SAMPLES - 1) / 2);
    let normal = [line.normal_rad.cos(), line.normal_rad.sin()];
    let along = [-normal[1], normal[0]];
    let (from_px, to_px) = visible_range(picture, normal, line.offset_px, half as f64);
    let count = ((to_px - from_px) / STATION_PX).floor().max(0.0) as usize;
    // The positions of the profiles are centred on the visible part of the line.
    let first_px = 0.5 * (from_px + to_px) - 0.5 * count as f64 * STATION_PX;
    let mut result =
        Profiles { half, along_px: Vec::with_capacity(count), samples: Vec::with_capacity(count * (2 * half + 1)) };
    for station in 0..count {
        let along_px = first_px + (station as f64 + 0.5) * STATION_PX;
        result.along_px.push(along_px);
        let start = result.samples.len();
        let mut usable = true;
        for sample in 0..=2 * half {
            let across_px = line.offset_px + sample as f64 - half as f64;
            let begin_px = along_px - 0.5 * (STATION_PX - 1.0);
            let at = |axis: usize| picture.centre_px[axis] + across_px * normal[axis] + begin_px * along[axis];
            let grey = mean_along(picture, [at(0), at(1)], along);
            usable &= (USABLE_GREY[0]..USABLE_GREY[1]).contains(&grey);
            result.samples.push(grey.ln());
        }
        if !usable {
            result.samples[start] = f32::NAN;
        }
    }
    result
}

/// Range of positions along a line at which a profile that reaches `half_px` to either side lies in the image: `(from, to)`, where `to < from` means
/// that there is none.
fn visible_range(picture: &Picture, normal: [f64; 2], offset_px: f64, half_px: f64) -> (f64, f64) {
    let along = [-normal[1], normal[0]];
    let (mut from, mut to) = (-1e9_f64, 1e9_f64);
    for axis in 0..2 {
        // The border of the image is left out by one pixel, so that bilinear interpolation has a neighbour for each sample.
        let room = picture.centre_px[axis] - 1.0 - half_px * normal[axis].abs();
        // No profile fits into an image that is narrower than the profile.
        if room < 0.0 {
            return (0.0, -1.0);
        }
        let foot = offset_px * normal[axis];
        if along[axis].abs() < 1e-9 {
            if foot.abs() > room {
                return (0.0, -1.0);
            }
            continue;
        }
        let ends = [(-room - foot) / along[axis], (room - foot) / along[axis]];
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (from, to)
}

/// Mean grey level along a line from a start point, with one sample per pixel of length, each interpolated bilinearly to 1/256 px.
#[inline]
fn mean_along(picture: &Picture, start_px: [f64; 2], along: [f64; 2]) -> f32 {
    const ONE: f64 = 65_536.0;
    let (mut u, mut v) = ((start_px[0] * ONE) as i32, (start_px[1] * ONE) as i32);
    let (du, dv) = ((along[0] * ONE) as i32, (along[1] * ONE) as i32);
    let mut sum = 0u32;
    for _ in 0..STATION_PX as usize {
        let corner = (v >> 16) as usize * picture.stride + (u >> 16) as usize;
        let (right, down) = (((u >> 8) & 255) as u32, ((v >> 8) & 255) as u32);
        // The profile lies in the visible range, so that all four neighbouring pixels exist. The check merely avoids a panic and costs nothing.
        if let (Some(&[a, b]), Some(&[c, d])) = (
            picture.pixels.get(corner..corner + 2).and_then(as_pair),
            picture.pixels.get(corner + picture.stride..corner + picture.stride + 2).and_then(as_pair),
        ) {
            let upper = u32::from(a) * (256 - right) + u32::from(b) * right;
            let lower = u32::from(c) * (256 - right) + u32::from(d) * right;
            sum += upper * (256 - down) + lower * down;
        }
        u += du;
        v += dv;
    }
    sum as f32 / (65_536.0 * STATION_PX as f32)
}

fn as_pair(slice: &[u8]) -> Option<&[u8; 2]> {
    slice.try_into().ok()
}
