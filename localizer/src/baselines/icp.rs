//! Rigid motion between two sets of points whose matches are unknown.

use crate::Pose;

use super::least_squares;

/// Greatest number of iterations of the matching.
const MOST_ITERATIONS: usize = 50;

/// Iterations end when the pose changes by less than this, in metres and radians.
const SETTLED: f64 = 1e-9;

/// Iterative closest point: each point of the view is matched to the nearest point of the map, the best rigid motion of these matches moves the
/// view, and so on until nothing changes. The result is the local minimum nearest to `start`, which is the right one if `start` is near enough.
///
/// Source: P. Besl, N. McKay, "A method for registration of 3-D shapes", IEEE PAMI 14 (1992).
pub fn closest_points(map: &[[f64; 2]], view: &[[f64; 2]], start: Pose) -> Pose {
    let mut pose = start;
    if map.is_empty() {
        return pose;
    }
    for _ in 0..MOST_ITERATIONS {
        let pairs: Vec<_> = view.iter().map(|&b| (nearest(map, in_world(&pose, b)), b)).collect();
        let Some(next) = least_squares(&pairs) else { break };
        // The new heading is shifted by whole turns to be nearest to that of the previous iteration, because headings are on the real line (not
        // wrapped).
        let turned = next.heading_rad - pose.heading_rad;
        let heading_rad = next.heading_rad - (turned / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        let moved = (next.x_m - pose.x_m).hypot(next.y_m - pose.y_m).max((heading_rad - pose.heading_rad).abs());
        pose = Pose { heading_rad, ..next };
        if moved < SETTLED {
            break;
        }
    }
    pose
}

fn nearest(map: &[[f64; 2]], place: [f64; 2]) -> [f64; 2] {
    let distance = |point: &[f64; 2]| (point[0] - place[0]).hypot(point[1] - place[1]);
    map.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(place)
}

/// The point b of the robot frame in the world: t + R·b.
fn in_world(pose: &Pose, [forward, left]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sin_cos();
    [pose.x_m + cos * forward - sin * left, pose.y_m + sin * forward + cos * left]
}
