//! Paper 2's chain from segments to the robot's azimuth: histogram of directions, RANSAC under orthogonality,
//! refinement, and correction for the camera's tilt.
//!
//! Frames: the camera has x right, y down, z forward; the robot has x right (lateral), y forward, z up, as in the paper's Fig. 5.

use nalgebra::{Matrix3, Rotation3, Vector3, vector};

use super::{Picture, Segment, equalise, guidance_filter, segments};
use crate::vision::draws::Draws;

/// Kinds of histogram equalisation with which the processing chain of paper 2 brightens an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Equalisation {
    /// Equalisation over the whole image.
    #[default]
    Whole,
    /// Equalisation by tiles with limited contrast (CLAHE).
    ByTiles,
}

/// Three orthogonal directions in the camera frame (the vanishing points), and the number of segments that point to one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanishingPoints {
    /// Unit vectors towards the three vanishing points.
    pub directions: [Vector3<f64>; 3],
    /// Number of segments that point to one of the vanishing points within `PLANE_TOLERANCE`.
    pub agreeing: usize,
}

/// Sine of the greatest angle between a direction and the plane through a segment and the camera at which the segment still counts as pointing in
/// that direction: sin 1°.
const PLANE_TOLERANCE: f64 = 0.0175;
/// Number of bins of the direction histogram over half a turn.
const BINS: usize = 18;
/// Number of random samples of segments from which RANSAC forms candidates for the vanishing points.
const SAMPLES: usize = 300;
/// Least number of agreeing segments for which vanishing points are reported.
const FEWEST: usize = 4;
/// Standard deviation, in equalised grey levels, of the differences of value that the rolling guidance filter smooths away; paper 2 does not state
/// it.
const RANGE_LEVELS: f32 = 25.0;
/// Least gradient of a segment, in equalised grey levels per pixel; paper 2 does not state it.
const LEAST_GRADIENT: f32 = 4.0;

/// Segments found by the chain of paper 2: equalisation, rolling guidance filter, segment detection.
pub fn segments_in(picture: &Picture, equalisation: Equalisation) -> Vec<Segment> {
    let bright = match equalisation {
        Equalisation::Whole => equalise::equalised(picture),
        Equalisation::ByTiles => equalise::equalised_by_tiles(picture, [8, 6], 3.0),
    };
    let filtered = guidance_filter::rolling_guidance(&bright, 3.0, RANGE_LEVELS, super::ROUNDS);
    segments::segments(&filtered, LEAST_GRADIENT).into_iter().filter(|segment| segment.length_px() > 30.0).collect()
}

/// Three orthogonal vanishing points of the segments. `ray` gives the direction in the camera frame in which a pixel looks.
pub fn vanishing_points(segments: &[Segment], ray: impl Fn([f64; 2]) -> Vector3<f64>) -> Option<VanishingPoints> {
    let normals: Vec<Vector3<f64>> =
        segments.iter().map(|of| ray(of.ends_px[0]).cross(&ray(of.ends_px[1])).normalize()).collect();
    let (dominant, rest) = dominant_and_rest(segments);
    if dominant.len() < 2 || rest.is_empty() {
        return None;
    }
    let mut draw = Draws::new();
    let mut best: Option<VanishingPoints> = None;
    for _ in 0..SAMPLES {
        let (i, j) = (dominant[draw.below(dominant.len())], dominant[draw.below(dominant.len())]);
        let Some(first) = normals[i].cross(&normals[j]).try_normalize(1e-3) else { continue };
        // The second vanishing point is orthogonal to the first and lies in the plane through the camera and a segment outside of the dominant
        // direction (set B of paper 2).
        let Some(second) = normals[rest[draw.below(rest.len())]].cross(&first).try_normalize(1e-3) else { continue };
        let directions = [first, second, first.cross(&second)];
        let agreeing = normals.iter().filter(|normal| nearest(normal, &directions).is_some()).count();
        if best.is_none_or(|best| agreeing > best.agreeing) {
            best = Some(VanishingPoints { directions, agreeing });
        }
    }
    best.filter(|best| best.agreeing >= FEWEST).map(|best| refined(&normals, best))
}

/// The segments that point to one of the vanishing points, within the tolerance of 1°.
pub fn agreeing(
    segments: &[Segment],
    points: &VanishingPoints,
    ray: impl Fn([f64; 2]) -> Vector3<f64>,
) -> Vec<Segment> {
    let normal = |of: &Segment| ray(of.ends_px[0]).cross(&ray(of.ends_px[1])).normalize();
    segments.iter().copied().filter(|segment| nearest(&normal(segment), &points.directions).is_some()).collect()
}

/// Azimuth of the robot relative to the room, in `[−π/4, π/4]`, for a camera that is tilted up: the counter-clockwise angle between the robot's
/// lateral axis and the vanishing point with the largest lateral component.
///
/// Eq. (1) of paper 2 is a rotation about the robot's lateral axis x by the camera's tilt. The optical axis of a camera tilted up points above the
/// horizon, so that levelling lowers the seen directions; with the wrong sign, azimuths err by up to 1.3° at a tilt of 8.7°.
pub fn azimuth_rad(points: &VanishingPoints, tilt_up_rad: f64) -> f64 {
    let lateral = points
        .directions
        .iter()
        .map(|direction| levelled(direction, tilt_up_rad))
        .fold(Vector3::zeros(), |best: Vector3<f64>, next| if next.x.abs() > best.x.abs() { next } else { best });
    // If a wall's direction is (cos φ, sin φ) in the robot's frame, the robot is turned by −φ relative to the wall.
    -(lateral.y * lateral.x.signum()).atan2(lateral.x.abs())
}

/// Converts a direction from the camera frame to the robot's frame: x right, y forward, z up.
pub fn levelled(direction: &Vector3<f64>, tilt_up_rad: f64) -> Vector3<f64> {
    let (sin, cos) = tilt_up_rad.sin_cos();
    vector![direction.x, direction.y * sin + direction.z * cos, direction.z * sin - direction.y * cos]
}

/// Splits the segments into paper 2's sets A and B: indices of the segments whose direction in the image is near the one with the greatest total
/// length, and of all other segments.
fn dominant_and_rest(segments: &[Segment]) -> (Vec<usize>, Vec<usize>) {
    let bin = |segment: &Segment| {
        let [du, dv] = segment.along();
        let share = dv.atan2(du).rem_euclid(std::f64::consts::PI) / std::f64::consts::PI;
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut lengths = [0.0; BINS];
    segments.iter().for_each(|segment| lengths[bin(segment)] += segment.length_px());
    let fullest = (0..BINS).fold(0, |best, next| if lengths[next] > lengths[best] { next } else { best });
    (0..segments.len()).partition(|&idx| {
        let apart = bin(&segments[idx]).abs_diff(fullest);
        apart.min(BINS - apart) <= 1
    })
}

/// Levenberg–Marquardt refinement of a common rotation of the three directions; it minimises Σ (normal · direction)² over the agreeing segments.
fn refined(normals: &[Vector3<f64>], found: VanishingPoints) -> VanishingPoints {
    let pairs: Vec<(Vector3<f64>, usize)> = normals
        .iter()
        .filter_map(|normal| nearest(normal, &found.directions).map(|direction| (*normal, direction)))
        .collect();
    let cost = |of: &[Vector3<f64>; 3]| pairs.iter().map(|(normal, at)| normal.dot(&of[*at]).powi(2)).sum::<f64>();
    let (mut directions, mut damping) = (found.directions, 1e-3);
    for _ in 0..20 {
        let (mut matrix, mut slope) = (Matrix3::zeros(), Vector3::zeros());
        for (normal, at) in &pairs {
            // Derivative for a small rotation ω of direction e: d(ω × e · n) = (e × n) · ω.
            let row = directions[*at].cross(normal);
            matrix += row * row.transpose();
            slope += row * normal.dot(&directions[*at]);
        }
        let damped = matrix + Matrix3::identity() * (damping * matrix.trace().max(1e-12));
        let Some(step) = damped.try_inverse().map(|inverse| -(inverse * slope)) else { break };
        let turn = Rotation3::from_scaled_axis(step);
        let turned = directions.map(|direction| turn * direction);
        if cost(&turned) < cost(&directions) {
            (directions, damping) = (turned, damping * 0.1);
        } else {
            damping *= 10.0;
        }
        if step.norm() < 1e-10 {
            break;
        }
    }
    VanishingPoints { directions, ..found }
}

/// Index of the direction that lies closest to the plane of a segment with this normal; `None` if it is not within the tolerance.
fn nearest(normal: &Vector3<f64>, directions: &[Vector3<f64>; 3]) -> Option<usize> {
    let off = |at: usize| normal.dot(&directions[at]).abs();
    let best = (1..3).fold(0, |best, next| if off(next) < off(best) { next } else { best });
    (off(best) < PLANE_TOLERANCE).then_some(best)
}
