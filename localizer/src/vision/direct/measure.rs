//! Measures a candidate line at full resolution: decides whether it is a tile joint, where exactly it lies, and which of its points can be trusted.

use super::Picture;
use super::course::{Course, Sighting};
use super::joint_filter::JointFilter;
use super::profile::{Profiles, profiles};
use super::vote::Candidate;

/// A candidate line that looks like a tile joint over its whole length, with the positions measured on it.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// The tile joint's refined line; its offset is counted from the centre of the image.
    pub(super) line: Candidate,
    /// Points on the tile joint's centre line, each `[u, v, bound]` in image coordinates: `bound` is the claimed greatest distance from that line.
    pub(super) points_px: Vec<[f64; 3]>,
    /// Contrast of the tile joint, as a difference of logarithms of grey levels; positive for dark and for light joints.
    pub(super) depth: f64,
    /// Standard deviation of the direction of the tile joint's line in the image, computed from the scatter of the measured points about the line.
    pub(super) direction_sd_rad: f64,
    /// Middle between the tile joint's first and last point, relative to the centre of the image.
    pub(super) middle_px: [f64; 2],
    /// Distance between the tile joint's first and last point.
    pub(super) span_px: f64,
    /// Share of the line's visible length that lies between the first and the last point measured on the tile joint.
    pub(super) cover: f64,
    /// Whether the strip along the line is as wide as the declared width of a tile joint. If not, it has one of the two neighbouring widths that are
    /// still accepted.
    pub(super) width_is_sure: bool,
}

/// Unit of distance for the checks of a tile joint's points: three times the scatter of points at the greatest noise that the checks allow, without
/// blur. A point's claimed bound is another quantity.
pub(super) const POINT_BOUND_PX: f64 = 0.30;
/// Relative growth, per pixel of image motion across the line, of a point's claimed bound and of the unit of its checks: motion makes the tile
/// joint's edges flatter.
pub(super) const BOUND_PER_BLUR: f64 = 0.28;
/// Motion across a tile joint beyond which its strip is too faint and too wide to be distinguished from a shadow.
const BLUR_MAX_PX: f64 = 20.0;
/// Distance to either side of a candidate line within which the tile joint is searched: the error of the candidate line at its ends.
const REACH_PX: f64 = 4.0;
/// Least number of points on a tile joint, and least length in pixels between its ends; below either, neither its
/// direction nor that it is a joint is certain.
const LEAST_POINTS: usize = 10;
const LEAST_SPAN_PX: f64 = 90.0;
/// Scatter of a line's points that is aimed at, in units of [`POINT_BOUND_PX`]. At this scatter a share of 0.02 of the points lies farther from the
/// line than that unit; the share of wrong points that a line declares (`SHARE_WRONG`) is ten times as great.
const SCATTER_WANTED: f64 = 0.42;
/// Greatest scatter of the points of a tile joint about its line, from bends of the joint and noise together, in units of [`POINT_BOUND_PX`].
const SCATTER_ALLOWED: f64 = 0.6;
/// Part of a point's claimed bound that remains without blur and without scatter: three times the error that an asymmetric tile joint or a shadow
/// gives to all points of a line alike, and that their scatter therefore does not show.
const CLAIM_FLOOR_PX: f64 = 0.12;
/// Growth of the claimed bound of a line's points with their scatter (root mean square distance from the line). At this factor one point in eighty
/// lies outside by chance.
const CLAIM_PER_SCATTER: f64 = 2.5;
/// Greatest number of neighbouring positions along a line that are averaged into one point; more would leave too few points on the line.
const GROUP_MAX: usize = 8;
/// Least share of the positions along a line at which a strip like a tile joint must be found: worn joints are missing at some positions, accidental
/// structures at more.
const LEAST_AGREEMENT: f64 = 0.5;
/// Pixels that are added to either side of the profiles, so that a strip twice as wide as a tile joint can be distinguished from a joint.
const LOOK_PX: usize = 4;
/// Greatest shift tried when the joint model is fitted to the mean profile of a part of the line: single profiles were already shifted to be centred
/// on the joint.
const LOOK_REACH_PX: f64 = 1.5;
/// Greatest residual, in units of the joint's depth, of the mean profile over a third of a tile joint. 99 of 100 joints leave less than 0.13;
/// patterns printed beside a joint leave more in at least one third for some joints.
const RESIDUAL_ALLOWED: f32 = 0.12;
/// Greatest step of brightness from tile to tile, in units of the depth of the joint's strip: at 2, the strip is one
/// side of a single edge of a tape or a shadow.
const STEP_ALLOWED: f32 = 1.3;
/// Widths of a strip that are tried on the mean profile across a line, in units of the tile joint's declared width; the best one must be near 1.
const WIDTHS: [f64; 5] = [0.45, 0.7, 1.0, 1.4, 2.1];

/// Matched filters, by motion blur in whole pixels. They are kept because building one costs as much as forty fits.
pub(super) struct Filters {
    width_px: f64,
    by_blur: Vec<Option<JointFilter>>,
}

impl Filters {
    pub(super) fn new(width_px: f64) -> Self {
        Filters { width_px, by_blur: (0..=BLUR_MAX_PX as usize).map(|_| None).collect() }
    }

    fn with_blur(&mut self, blur_px: f64) -> &JointFilter {
        let index = (blur_px.round() as usize).min(self.by_blur.len() - 1);
        let width_px = self.width_px;
        self.by_blur[index].get_or_insert_with(|| {
            let half = JointFilter::half_for(width_px, index as f64, REACH_PX);
            JointFilter::new(width_px, index as f64, REACH_PX, half)
        })
    }
}

impl Sighting {
    fn bound_px(&self) -> f64 {
        bound_px(self.blur_px)
    }
}

/// Unit of distance for the checks of a tile joint's point, for a given image motion across the line during the exposure.
fn bound_px(blur_px: f64) -> f64 {
    POINT_BOUND_PX * (1.0 + BOUND_PER_BLUR * blur_px)
}

/// Claimed greatest distance of a point from its tile joint: one term for an error that all points of the line share and one for their scatter.
fn claimed_px(blur_px: f64, scatter_px: f64) -> f64 {
    CLAIM_FLOOR_PX * (1.0 + BOUND_PER_BLUR * blur_px) + CLAIM_PER_SCATTER * scatter_px
}

/// Measures a candidate line; `None` if it does not look like a tile joint over its whole length.
pub(super) fn measure(picture: &Picture, filters: &mut Filters, line: &Candidate) -> Option<Joint> {
    let reach_px = picture.centre_px[0].hypot(picture.centre_px[1]);
    let blur_at = |along_px: f64| picture.blur_across_px(line, along_px);
    // The image motion across a line varies linearly along it, so that it is greatest at one of its ends.
    let blur_max_px = blur_at(-reach_px).max(blur_at(reach_px)).min(BLUR_MAX_PX);
    let half = JointFilter::half_for(filters.width_px, blur_max_px, REACH_PX) + LOOK_PX;
    let mut profiles = profiles(picture, line, half);
    let mut sightings = sight(&profiles, filters, line.dark, blur_at, None);
    let mut course = Course::through(&sightings)?;
    let (depth, noise) = depth_and_noise(&sightings, &course)?;
    let middle_px = 0.5 * (profiles.along_px.first()? + profiles.along_px.last()?);
    let middle_blur_px = blur_at(middle_px);
    // For a faint tile joint, neighbouring profiles are averaged, as many as are needed for the scatter of the measured points to be as small as
    // wanted.
    let scatter = f64::from(filters.with_blur(middle_blur_px).position_sd_px(depth, noise)) / bound_px(middle_blur_px);
    let group = (scatter / SCATTER_WANTED).powi(2).ceil().max(1.0) as usize;
    if group > GROUP_MAX {
        return None;
    }
    if group > 1 {
        profiles = profiles.merged(group);
        sightings = sight(&profiles, filters, line.dark, blur_at, Some(&course));
        course = Course::through(&sightings)?;
    }
    let (depth, noise) = depth_and_noise(&sightings, &course)?;
    let accepted = accept(&sightings, &mut course, depth, noise)?;
    let span = [accepted.first()?.along_px, accepted.last()?.along_px];
    let span_px = span[1] - span[0];
    let visited = profiles.along_px.iter().filter(|&&along_px| along_px >= span[0] && along_px <= span[1]).count();
    let agreement = accepted.len() as f64 / visited as f64;
    let scatter_px = scatter_px(&accepted, &course);
    let straight = scatter_px <= SCATTER_ALLOWED * bound_px(middle_blur_px);
    if accepted.len() < LEAST_POINTS || span_px < LEAST_SPAN_PX || agreement < LEAST_AGREEMENT || !straight {
        return None;
    }
    let look = Look { profiles: &profiles, course: &course, dark: line.dark, depth, blur_px: middle_blur_px };
    let width_is_sure = look.is_a_joint(filters.width_px, span)?;
    let turn_rad = course.slope.atan();
    let middle_along_px = 0.5 * (span[0] + span[1]);
    let middle_px = picture.point_px(line, middle_along_px, course.across_px(middle_along_px));
    let middle_px = [0, 1].map(|axis| middle_px[axis] - picture.centre_px[axis]);
    Some(Joint {
        // Since across = slope·along + intercept in the fit, the line's normal turns by −atan(slope).
        line: Candidate {
            normal_rad: line.normal_rad - turn_rad,
            offset_px: (line.offset_px + course.intercept_px) * turn_rad.cos(),
            ..*line
        },
        points_px: accepted
            .iter()
            .map(|sighting| {
                let [u, v] = picture.point_px(line, sighting.along_px, f64::from(sighting.fit.shift_px));
                [u, v, claimed_px(sighting.blur_px, scatter_px)]
            })
            .collect(),
        depth: f64::from(depth.abs()),
        // For a straight fit to n evenly spaced points, sd(slope) = √12·sd/(span·√n).
        direction_sd_rad: 3.5 * scatter_px.max(0.05) / (span_px * (accepted.len() as f64).sqrt()),
        middle_px,
        span_px,
        cover: span_px / (profiles.along_px.last()? - profiles.along_px.first()?),
        width_is_sure,
    })
}

/// Fits the model of a tile joint to the profile at every position along a line. The joint is searched within [`REACH_PX`] of the line, or only
/// within 2 px of the fitted line `near` if that is given.
fn sight(
    profiles: &Profiles,
    filters: &mut Filters,
    dark: bool,
    blur_at: impl Fn(f64) -> f64,
    near: Option<&Course>,
) -> Vec<Sighting> {
    let mut sightings = Vec::with_capacity(profiles.along_px.len());
    for (station, &along_px) in profiles.along_px.iter().enumerate() {
        let blur_px = blur_at(along_px);
        let Some(profile) = profiles.get(station).filter(|_| blur_px <= BLUR_MAX_PX) else { continue };
        let filter = filters.with_blur(blur_px);
        let fit = match near {
            None => filter.fit(profile, dark, 0.0, REACH_PX as f32),
            Some(course) => filter.fit(profile, dark, course.across_px(along_px) as f32, 2.0),
        };
        sightings.extend(fit.map(|fit| Sighting { along_px, blur_px, fit }));
    }
    sightings
}

/// Median contrast of the joint and median residual of the fits, over the measured positions that lie near the fitted line.
fn depth_and_noise(sightings: &[Sighting], course: &Course) -> Option<(f32, f32)> {
    let near: Vec<&Sighting> =
        sightings.iter().filter(|sighting| course.distance_px(sighting).abs() < 2.0 * sighting.bound_px()).collect();
    let mut depths: Vec<f32> = near.iter().map(|sighting| sighting.fit.depth).collect();
    let mut noises: Vec<f32> = near.iter().map(|sighting| sighting.fit.residual).collect();
    Some((median(&mut depths)?, median(&mut noises)?))
}

fn median(values: &mut [f32]) -> Option<f32> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The measured positions that can be trusted: about as deep in contrast and as clean as most, and near the fitted
/// line. The line is fitted to them again.
fn accept(sightings: &[Sighting], course: &mut Course, depth: f32, noise: f32) -> Option<Vec<Sighting>> {
    let noise_max = 2.5 * noise.max(0.02 * depth.abs());
    let sound: Vec<Sighting> = sightings
        .iter()
        .filter(|sighting| (0.4..2.5).contains(&(sighting.fit.depth / depth)) && sighting.fit.residual < noise_max)
        .copied()
        .collect();
    // A distance of twice [`POINT_BOUND_PX`] admits every true point of a tile joint that is bent as much as laying allows, and excludes weaker
    // parallel structures beside it.
    for _ in 0..2 {
        *course = course.refitted(&sound, |sighting| 2.0 * sighting.bound_px())?;
    }
    Some(sound.into_iter().filter(|sighting| course.distance_px(sighting).abs() < 2.0 * sighting.bound_px()).collect())
}

/// Root mean square distance of the accepted positions from the fitted line.
fn scatter_px(accepted: &[Sighting], course: &Course) -> f64 {
    let squares: f64 = accepted.iter().map(|sighting| course.distance_px(sighting).powi(2)).sum();
    // Two degrees of freedom are subtracted from the number of points, because slope and intercept of the line were fitted to them.
    (squares / (accepted.len() as f64 - 2.0).max(1.0)).sqrt()
}

/// What is needed to examine whether a line is a tile joint by the mean profiles across it: the profiles, the fitted line, and the joint's polarity,
/// depth and blur.
struct Look<'a> {
    profiles: &'a Profiles,
    course: &'a Course,
    dark: bool,
    depth: f32,
    blur_px: f64,
}

impl Look<'_> {
    /// Whether each third of the line shows a strip in the middle of its mean profile, and the strip is as wide as a tile joint. `None` if not;
    /// otherwise whether the width is certain.
    fn is_a_joint(&self, width_px: f64, span: [f64; 2]) -> Option<bool> {
        let third_px = (span[1] - span[0]) / 3.0;
        let half = self.profiles.half - REACH_PX as usize;
        let filter = |ratio: f64| JointFilter::new(ratio * width_px, self.blur_px.round(), LOOK_REACH_PX, half);
        let own = filter(1.0);
        for third in 0..3 {
            let from_px = span[0] + third_px * f64::from(third);
            let mean = self.mean_profile([from_px, from_px + third_px])?;
            let fit = own.fit(&mean, self.dark, 0.0, LOOK_REACH_PX as f32)?;
            let in_place = f64::from(fit.shift_px).abs() < 2.0 * bound_px(self.blur_px);
            let is_edge = fit.step.abs() > STEP_ALLOWED * fit.depth.abs();
            if is_edge
                || !in_place
                || !(0.3..3.0).contains(&(fit.depth / self.depth))
                || fit.residual > RESIDUAL_ALLOWED * fit.depth.abs()
            {
                return None;
            }
        }
        let mean = self.mean_profile(span)?;
        let fits = WIDTHS.map(|ratio| filter(ratio).fit(&mean, self.dark, 0.0, LOOK_REACH_PX as f32));
        let residual = |index: usize| fits[index].map_or(f32::MAX, |fit| fit.residual);
        let best = (0..WIDTHS.len()).min_by(|&a, &b| residual(a).total_cmp(&residual(b)))?;
        match best {
            2 => Some(true),
            1 | 3 => Some(false),
            _ => None,
        }
    }

    /// Mean of the grey-level profiles across a line, for a range of positions along it. Each profile is first shifted so that the fitted line passes
    /// through its middle.
    fn mean_profile(&self, range: [f64; 2]) -> Option<Vec<f32>> {
        let half = self.profiles.half - REACH_PX as usize;
        let (mut sum, mut count) = (vec![0f32; 2 * half + 1], 0);
        for (station, &along_px) in self.profiles.along_px.iter().enumerate() {
            let Some(profile) = self.profiles.get(station).filter(|_| along_px >= range[0] && along_px <= range[1])
            else {
                continue;
            };
            let across_px = self.course.across_px(along_px).clamp(1.0 - REACH_PX, REACH_PX - 1.0);
            let (whole, part) = (across_px.floor(), (across_px - across_px.floor()) as f32);
            let first = (REACH_PX + whole) as usize;
            for (sample, value) in sum.iter_mut().enumerate() {
                *value += profile[first + sample] * (1.0 - part) + profile[first + sample + 1] * part;
            }
            count += 1;
        }
        (count > 0).then(|| sum.into_iter().map(|value| value / count as f32).collect())
    }
}
