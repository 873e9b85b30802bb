//! A candidate under the lens: is it a joint, where exactly, and which of its points are to be trusted?

use super::Picture;
use super::course::Course;
use super::joint_filter::{Fit, JointFilter};
use super::profile::{Profiles, profiles};
use super::vote::Candidate;

/// A candidate that looks like a joint all along, with the positions measured on it.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// The refined line, relative to the picture's centre.
    pub(super) line: Candidate,
    /// Points on the joint's centre line with their bounds, picture coordinates: `[u, v, bound]`.
    pub(super) points_px: Vec<[f64; 3]>,
    /// Logarithmic contrast, positive whatever the polarity.
    pub(super) depth: f64,
    /// Standard deviation of the line's direction that its points imply.
    pub(super) direction_sd_rad: f64,
    /// Middle between its first and last point, relative to the picture's centre.
    pub(super) middle_px: [f64; 2],
    /// Length between its first and last point.
    pub(super) span_px: f64,
    /// Whether its width is that of a joint rather than only not unlike it.
    pub(super) width_is_sure: bool,
}

/// Claimed bound of a point without blur. Three times the scatter of points that pass the gates at the noise they allow.
pub(super) const POINT_BOUND_PX: f64 = 0.30;
/// Growth of the bound per pixel of motion across the line: the edges get flatter by that much.
pub(super) const BOUND_PER_BLUR: f64 = 0.28;
/// Motion across a joint beyond which its strip is too faint and too wide to be told from a shadow.
const BLUR_MAX_PX: f64 = 20.0;
/// Distance to either side of the voted line within which the joint is looked for: the error of the vote at the line's ends.
const REACH_PX: f64 = 4.0;
/// Points on a line and pixels between its ends below which neither direction nor identity is certain.
const LEAST_POINTS: usize = 10;
const LEAST_SPAN_PX: f64 = 90.0;
/// Scatter wanted of a point, in units of its bound: 0.3 of the points may be wrong, at this scatter 0.02 are.
const SCATTER_WANTED: f64 = 0.42;
/// Scatter that the points of a joint have at most, in units of their bound: bends and noise together.
const SCATTER_ALLOWED: f64 = 0.6;
/// What is claimed of a point without blur and without scatter: three times the bias that a lopsided joint or a shadow gives a
/// whole line, which no scatter shows.
const CLAIM_FLOOR_PX: f64 = 0.12;
/// What is claimed besides, in units of the line's scatter: one point in eighty lies outside by chance.
const CLAIM_PER_SCATTER: f64 = 2.5;
/// Stations averaged at most into one point: more would leave too few points of a line.
const GROUP_MAX: usize = 8;
/// Share of the stations between a line's ends that must agree: worn joints lose some, accidents have fewer.
const LEAST_AGREEMENT: f64 = 0.5;
/// Pixels added to either side of the profiles, so that a strip twice as wide as a joint can be told from one.
const LOOK_PX: usize = 4;
/// Shifts tried on mean profiles, which the course has already centred.
const LOOK_REACH_PX: f64 = 1.5;
/// Residual of a third's mean profile in units of its depth: 99 of 100 joints leave less than 0.13, what is printed beside
/// some of them more.
const RESIDUAL_ALLOWED: f32 = 0.12;
/// Widths tried on the mean profile, in units of the joint's.
const WIDTHS: [f64; 5] = [0.45, 0.7, 1.0, 1.4, 2.1];

/// Filters by blur in whole pixels: building one costs as much as forty fits.
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

/// One station of the line: where the strip was found there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    pub(super) along_px: f64,
    pub(super) blur_px: f64,
    pub(super) fit: Fit,
}

impl Sighting {
    fn bound_px(&self) -> f64 {
        bound_px(self.blur_px)
    }
}

/// Claimed bound of a point under motion across its line.
fn bound_px(blur_px: f64) -> f64 {
    POINT_BOUND_PX * (1.0 + BOUND_PER_BLUR * blur_px)
}

/// Claimed distance of a point from its joint: the line's bias and its scatter.
fn claimed_px(blur_px: f64, scatter_px: f64) -> f64 {
    CLAIM_FLOOR_PX * (1.0 + BOUND_PER_BLUR * blur_px) + CLAIM_PER_SCATTER * scatter_px
}

/// Measures a candidate; `None` if it does not look like a joint all along.
pub(super) fn measure(picture: &Picture, filters: &mut Filters, line: &Candidate) -> Option<Joint> {
    let reach_px = picture.centre_px[0].hypot(picture.centre_px[1]);
    let blur_at = |along_px: f64| picture.blur_across_px(line, along_px);
    // Motion across a line is linear along it, so its greatest amount is at an end.
    let blur_max_px = blur_at(-reach_px).max(blur_at(reach_px)).min(BLUR_MAX_PX);
    let half = JointFilter::half_for(filters.width_px, blur_max_px, REACH_PX) + LOOK_PX;
    let mut profiles = profiles(picture, line, half);
    let mut sightings = sight(&profiles, filters, line.dark, blur_at, None);
    let mut course = Course::through(&sightings)?;
    let (depth, noise) = depth_and_noise(&sightings, &course)?;
    let middle_px = 0.5 * (profiles.along_px.first()? + profiles.along_px.last()?);
    let middle_blur_px = blur_at(middle_px);
    // Faint joints: average neighbouring stations until the scatter is what the claim needs.
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
        // across = slope·along + intercept: the normal turns by −atan(slope).
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
        // A straight fit to n even points: sd(slope) = √12·sd/(span·√n).
        direction_sd_rad: 3.5 * scatter_px.max(0.05) / (span_px * (accepted.len() as f64).sqrt()),
        middle_px,
        span_px,
        width_is_sure,
    })
}

/// Fits every station, anywhere within reach or near a course.
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

/// Medians of depth and of noise among the sightings near the course.
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

/// Sightings to be trusted: as deep and as clean as most, and near the course; the course is fitted to them again.
fn accept(sightings: &[Sighting], course: &mut Course, depth: f32, noise: f32) -> Option<Vec<Sighting>> {
    let noise_max = 2.5 * noise.max(0.02 * depth.abs());
    let sound: Vec<Sighting> = sightings
        .iter()
        .filter(|sighting| (0.4..2.5).contains(&(sighting.fit.depth / depth)) && sighting.fit.residual < noise_max)
        .copied()
        .collect();
    // Twice the bound holds every true point of a joint that bends as much as laying allows, and keeps neighbours' ghosts out.
    for _ in 0..2 {
        *course = course.refitted(&sound, |sighting| 2.0 * sighting.bound_px())?;
    }
    Some(sound.into_iter().filter(|sighting| course.distance_px(sighting).abs() < 2.0 * sighting.bound_px()).collect())
}

/// Root mean square distance from the course.
fn scatter_px(accepted: &[Sighting], course: &Course) -> f64 {
    let squares: f64 = accepted.iter().map(|sighting| course.distance_px(sighting).powi(2)).sum();
    // The course took two degrees of freedom.
    (squares / (accepted.len() as f64 - 2.0).max(1.0)).sqrt()
}

/// Mean profiles along the found course.
struct Look<'a> {
    profiles: &'a Profiles,
    course: &'a Course,
    dark: bool,
    depth: f32,
    blur_px: f64,
}

impl Look<'_> {
    /// Whether each third of the line shows the strip in its place, and the strip has the width of a joint: `Some(sure of the width)`.
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
            if !in_place
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

    /// Mean of the profiles in a range, each moved so that the course passes through its middle.
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
