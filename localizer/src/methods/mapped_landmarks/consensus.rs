//! The sightings of a picture that agree on some pose, where the picture may have been taken from anywhere: what looks like a landmark is then often
//! something else.
//!
//! Three bearings of landmarks tell a pose. Of many triples the pose is taken on which the most sightings agree, if no other pose has half as many of the rest. This
//! chooses what is claimed; whether the claims are true does not depend on it.
//!
//! Source: M. A. Fischler, R. C. Bolles, "Random sample consensus", Communications of the ACM 24 (1981); the pose from three bearings by V. Pierlot,
//! M. Van Droogenbroeck, "A new three object triangulation algorithm for mobile robot positioning", IEEE Transactions on Robotics 30 (2014), algorithm 1.

use std::f64::consts::{PI, TAU};

use super::{ray::Optics, relate::Sight};

/// Greatest number of triples that are tried: with half of the sightings wrong, an eighth of them are right ones.
const MOST_TRIPLES: usize = 3000;
/// Greatest differences in bearing, in radians, and in slope with which a sighting agrees with a pose: what directions and mount are known to.
const BEARING_RAD: f64 = 0.02;
const SLOPE: f64 = 0.03;
/// Greatest part of such a difference that comes from the landmark's depth. Of a landmark with more, too little is known.
const BY_DEPTH: f64 = 0.04;
/// Least number of sightings that agree.
const FEWEST: usize = 7;
/// Distance, in metres, and angle, in radians, from which poses are taken to be different.
const APART_M: f64 = 0.5;
const APART_RAD: f64 = 0.3;
/// Least difference of the bearings of a triple.
const LEAST_ANGLE_RAD: f64 = 0.08;

/// A sighting as a point method sees it: the landmark's place in the world, and how it is seen from the camera.
#[derive(Clone, Copy)]
struct Seen {
    place_m: [f64; 3],
    /// Where it was first seen from, world x and y, and half of the width of its inverse depth.
    anchor_m: [f64; 2],
    depth_error_per_m: f64,
    /// Angle to the left of robot forward.
    bearing_rad: f64,
    /// Height over horizontal distance.
    slope: f64,
}

/// The sightings that agree on a pose, by their places among all; none where no pose is singled out.
pub(super) fn agreeing(sights: &[Sight], optics: &Optics) -> Vec<usize> {
    let seen: Vec<(usize, Seen)> =
        sights.iter().enumerate().filter_map(|(at, sight)| Some((at, Seen::of(sight, optics)?))).collect();
    let agree_on = |pose: [f64; 3]| -> Vec<usize> {
        seen.iter().filter(|(_, one)| one.agrees(pose, optics)).map(|(at, _)| *at).collect()
    };
    let poses: Vec<[f64; 3]> =
        triples(seen.len()).into_iter().filter_map(|triple| from_bearings(triple.map(|at| seen[at].1))).collect();
    let agreeing: Vec<Vec<usize>> = poses.iter().map(|pose| agree_on(*pose)).collect();
    let Some(best) = (0..poses.len()).max_by_key(|&at| (agreeing[at].len(), std::cmp::Reverse(at))) else {
        return Vec::new();
    };
    let most = agreeing[best].len();
    // Another pose counts by the sightings that do not agree on the best one.
    let others = |at: usize| agreeing[at].iter().filter(|one| !agreeing[best].contains(one)).count();
    let is_rival = |at: usize| is_apart(poses[best], poses[at]) && 2 * others(at) > most;
    if most < FEWEST || (0..poses.len()).any(is_rival) { Vec::new() } else { agreeing[best].clone() }
}

impl Seen {
    fn of(sight: &Sight, optics: &Optics) -> Option<Seen> {
        let (camera, anchor, [alpha, beta, rho]) = (&optics.camera, sight.point.anchor, sight.point.value);
        sight.point.place_m()?;
        let mut place_m = anchor.from_m;
        let [i, j] = anchor.sides();
        place_m[anchor.axis] += anchor.sign() / rho.mid();
        place_m[i] += alpha.mid() / rho.mid();
        place_m[j] += beta.mid() / rho.mid();
        let [right, down] = [0, 1].map(|k| (sight.at_px[k] - camera.centre_px[k].mid()) / camera.focal_px.mid());
        let (sin, cos) = camera.tilt_up_rad.sin_cos();
        let [ahead, left, up] = [cos + down * sin, -right, sin - down * cos];
        Some(Seen {
            place_m,
            anchor_m: [anchor.from_m[0], anchor.from_m[1]],
            depth_error_per_m: 0.5 * rho.width(),
            bearing_rad: left.atan2(ahead) + camera.yaw_rad.mid(),
            slope: up / ahead.hypot(left),
        })
    }

    /// Whether the landmark is seen in this way by a camera at a pose: x, y and heading of the robot's axes under the camera's centre.
    fn agrees(&self, [x_m, y_m, heading_rad]: [f64; 3], optics: &Optics) -> bool {
        let [east_m, north_m] = [self.place_m[0] - x_m, self.place_m[1] - y_m];
        let slope = (self.place_m[2] - optics.camera.height_m.mid()) / east_m.hypot(north_m);
        let by_depth = self.depth_error_per_m * (x_m - self.anchor_m[0]).hypot(y_m - self.anchor_m[1]);
        by_depth <= BY_DEPTH
            && wrapped(north_m.atan2(east_m) - heading_rad - self.bearing_rad).abs() <= BEARING_RAD + by_depth
            && (slope - self.slope).abs() <= SLOPE + by_depth
    }
}

/// Triples of different numbers below `n`: all of them, or many at random, always the same.
fn triples(n: usize) -> Vec<[usize; 3]> {
    let n_all = n * n.saturating_sub(1) * n.saturating_sub(2) / 6;
    if n_all <= MOST_TRIPLES {
        return (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| [a, b, c]))).collect();
    }
    // The generator xorshift64.
    let mut state: u64 = 88_172_645_463_325_252;
    let mut below = |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let drawn = (0..MOST_TRIPLES).map(|_| [below(n), below(n), below(n)]);
    drawn.filter(|[a, b, c]| a != b && b != c && a != c).collect()
}

/// The place of the camera and the robot's heading from the bearings of three landmarks; `None` where they hardly determine it.
fn from_bearings([one, two, three]: [Seen; 3]) -> Option<[f64; 3]> {
    let [ahead, behind] = [wrapped(two.bearing_rad - one.bearing_rad), wrapped(three.bearing_rad - two.bearing_rad)];
    let is_told = |angle: f64| angle.sin().abs() >= LEAST_ANGLE_RAD;
    if !is_told(ahead) || !is_told(behind) || !is_told(ahead + behind) {
        return None;
    }
    let [t12, t23] = [ahead, behind].map(|angle| 1.0 / angle.tan());
    let t31 = (1.0 - t12 * t23) / (t12 + t23);
    let from_two = |other: Seen| [0, 1].map(|k| other.place_m[k] - two.place_m[k]);
    let ([x1, y1], [x3, y3]) = (from_two(one), from_two(three));
    let ([x12, y12], [x23, y23]) = ([x1 + t12 * y1, y1 - t12 * x1], [x3 - t23 * y3, y3 + t23 * x3]);
    let [x31, y31] = [x3 + x1 + t31 * (y3 - y1), y3 + y1 - t31 * (x3 - x1)];
    let k31 = x1 * x3 + y1 * y3 + t31 * (x1 * y3 - x3 * y1);
    let determinant = (x12 - x23) * (y23 - y31) - (y12 - y23) * (x23 - x31);
    if determinant.abs() < 1e-9 {
        return None;
    }
    let x_m = two.place_m[0] + k31 * (y12 - y23) / determinant;
    let y_m = two.place_m[1] + k31 * (x23 - x12) / determinant;
    let heading_rad = (one.place_m[1] - y_m).atan2(one.place_m[0] - x_m) - one.bearing_rad;
    [x_m, y_m, heading_rad].iter().all(|one| one.is_finite()).then_some([x_m, y_m, heading_rad])
}

fn is_apart(one: [f64; 3], other: [f64; 3]) -> bool {
    (one[0] - other[0]).hypot(one[1] - other[1]) > APART_M || wrapped(one[2] - other[2]).abs() > APART_RAD
}

/// The angle between −π and π.
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{graph::trial::Draw, methods::mapped_landmarks::few_wrong::tests::trial};

    #[test]
    fn three_bearings_tell_the_pose_worked_out_by_hand() {
        // From (2, 1), heading along world y: (2, 5) is straight ahead, (5, 1) to the right, and (−1, 4) at 45° to the left.
        let seen = [([2.0, 5.0], 0.0), ([5.0, 1.0], -90.0), ([-1.0, 4.0], 45.0)].map(|([x, y], bearing_deg)| Seen {
            place_m: [x, y, 1.0],
            anchor_m: [0.0; 2],
            depth_error_per_m: 0.0,
            bearing_rad: f64::to_radians(bearing_deg),
            slope: 0.0,
        });
        for order in [[0, 1, 2], [2, 0, 1], [1, 0, 2]] {
            let [x, y, heading] = from_bearings(order.map(|at| seen[at])).unwrap();
            assert!((x - 2.0).abs() < 1e-9 && (y - 1.0).abs() < 1e-9, "{x} {y}");
            assert!(wrapped(heading - 0.5 * PI).abs() < 1e-9, "{heading}");
        }
        // Two that are in line with the camera determine nothing.
        assert_eq!(from_bearings([seen[0], Seen { place_m: [2.0, 9.0, 1.0], ..seen[0] }, seen[1]]), None);
    }

    #[test]
    fn right_sightings_are_told_from_as_many_wrong_ones() {
        let mut draw = Draw::new(20_261_204);
        for round in 0..20 {
            let (optics, mut sights, ..) = trial(&mut draw, 0);
            let n_right = sights.len() - sights.len() / 2;
            // The other half are other landmarks than they are taken for.
            let places: Vec<[f64; 2]> = sights.iter().map(|sight| sight.at_px).collect();
            for at in n_right..sights.len() {
                sights[at].at_px = places[(at * 7 + 3) % n_right];
            }
            let agreeing = agreeing(&sights, &optics);
            let n_true = agreeing.iter().filter(|at| **at < n_right).count();
            assert!(n_true + 1 >= n_right && agreeing.len() <= n_true + 1, "round {round}: {agreeing:?} of {n_right}");
        }
    }

    #[test]
    fn sightings_that_agree_on_nothing_single_out_no_pose() {
        let mut draw = Draw::new(20_261_205);
        let (optics, mut sights, ..) = trial(&mut draw, 0);
        for sight in &mut sights {
            sight.at_px = [draw.between(0.0, 640.0), draw.between(0.0, 480.0)];
        }
        assert!(agreeing(&sights, &optics).is_empty());
        assert!(agreeing(&sights[..2], &optics).is_empty());
    }
}
