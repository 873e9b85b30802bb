//! Paper 2's chain from segments to the robot's azimuth: direction histogram, RANSAC under orthogonality, refinement, tilt.
//!
//! Frames: camera x right, y down, z forward; robot x right (lateral), y forward, z up, as in the paper's Fig. 5.

use nalgebra::{Matrix3, Rotation3, Vector3, vector};

use super::{Picture, Segment, draws::Draws, equalise, guidance_filter, segments};

/// How the paper's chain brightens a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Equalisation {
    /// Over the whole picture.
    #[default]
    Whole,
    /// By tiles and within limits: CLAHE.
    ByTiles,
}

/// Three directions at right angles, in the camera frame, and how many segments point to one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanishingPoints {
    /// Unit vectors.
    pub directions: [Vector3<f64>; 3],
    /// Segments within the threshold of one of them.
    pub agreeing: usize,
}

/// A slope has a direction where a pixel has neighbours on all sides: pictures less wide or high than three pixels show none.
const LEAST_SIDE: usize = 3;
/// A segment agrees with a direction when its plane holds it within this: sin 1°.
const PLANE_TOLERANCE: f64 = 0.0175;
/// Bins of the direction histogram over half a turn.
const BINS: usize = 18;
/// Samples drawn.
const SAMPLES: usize = 300;
/// At fewer agreeing segments nothing is said.
const FEWEST: usize = 4;
/// Range of the guided rounds in equalised levels; the paper does not state it.
const RANGE_LEVELS: f32 = 25.0;
/// Least gradient in equalised levels a pixel; the paper does not state it.
const LEAST_GRADIENT: f32 = 4.0;

/// Segments by the paper's chain: equalise, rolling guidance, segments.
pub fn segments_in(picture: &Picture, equalisation: Equalisation) -> Vec<Segment> {
    if picture.width.min(picture.height) < LEAST_SIDE {
        return Vec::new();
    }
    let bright = match equalisation {
        Equalisation::Whole => equalise::equalised(picture),
        Equalisation::ByTiles => equalise::equalised_by_tiles(picture, [8, 6], 3.0),
    };
    let filtered = guidance_filter::rolling_guidance(&bright, 3.0, RANGE_LEVELS, super::ROUNDS);
    segments::segments(&filtered, LEAST_GRADIENT).into_iter().filter(|segment| segment.length_px() > 30.0).collect()
}

/// Three orthogonal vanishing points of segments; `ray` gives the direction in the camera frame in which a pixel looks.
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
        // The second point lies in a plane of set B and at right angles to the first.
        let Some(second) = normals[rest[draw.below(rest.len())]].cross(&first).try_normalize(1e-3) else { continue };
        let directions = [first, second, first.cross(&second)];
        let agreeing = normals.iter().filter(|normal| nearest(normal, &directions).is_some()).count();
        if best.is_none_or(|best| agreeing > best.agreeing) {
            best = Some(VanishingPoints { directions, agreeing });
        }
    }
    best.filter(|best| best.agreeing >= FEWEST).map(|best| refined(&normals, best))
}

/// The segments that point to one of the vanishing points, within the threshold.
pub fn agreeing(
    segments: &[Segment],
    points: &VanishingPoints,
    ray: impl Fn([f64; 2]) -> Vector3<f64>,
) -> Vec<Segment> {
    let normal = |of: &Segment| ray(of.ends_px[0]).cross(&ray(of.ends_px[1])).normalize();
    segments.iter().copied().filter(|segment| nearest(&normal(segment), &points.directions).is_some()).collect()
}

/// Azimuth of the robot against the room, in [−π/4, π/4]: the angle between the robot's lateral axis and the vanishing point with
/// the largest lateral part, counter-clockwise, for a camera tilted up.
///
/// Eq. (1): with x lateral, a turn about x by the tilt. A camera tilted up looks with its axis above the horizon, so that levelling
/// it lowers what it sees; with the wrong sign azimuths err by up to 1.3° at 8.7°.
pub fn azimuth_rad(points: &VanishingPoints, tilt_up_rad: f64) -> f64 {
    let lateral = points
        .directions
        .iter()
        .map(|direction| levelled(direction, tilt_up_rad))
        .fold(Vector3::zeros(), |best: Vector3<f64>, next| if next.x.abs() > best.x.abs() { next } else { best });
    // The wall's direction as the robot sees it, (cos φ, sin φ), leaves the robot turned by −φ against the wall.
    -(lateral.y * lateral.x.signum()).atan2(lateral.x.abs())
}

/// A direction of the camera frame in the robot's: x right, y forward, z up.
pub fn levelled(direction: &Vector3<f64>, tilt_up_rad: f64) -> Vector3<f64> {
    let (sin, cos) = tilt_up_rad.sin_cos();
    vector![direction.x, direction.y * sin + direction.z * cos, direction.z * sin - direction.y * cos]
}

/// Sets A and B: indices of segments that point as most of the length does, and of the others.
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

/// Levenberg and Marquardt on the turn of all three directions: Σ (normal · direction)² over the agreeing segments.
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
            // d(ω × e · n) = (e × n) · ω.
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

/// The direction that a segment's plane holds best, if within the tolerance.
fn nearest(normal: &Vector3<f64>, directions: &[Vector3<f64>; 3]) -> Option<usize> {
    let off = |at: usize| normal.dot(&directions[at]).abs();
    let best = (1..3).fold(0, |best, next| if off(next) < off(best) { next } else { best });
    (off(best) < PLANE_TOLERANCE).then_some(best)
}
