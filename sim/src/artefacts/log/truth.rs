//! True poses of a log, to which the estimates are compared. They never reach the localizer.

use std::{f64::consts::TAU, fs, path::Path};

use localizer::Pose;

use super::{gathered::Stamped, messages::SpatialPose};
use crate::scene::LoggedTruth;

/// True poses of the robot in the world frame, in the order of their times.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TruePath {
    /// Time since the log's first reading of the wheels, and the pose; headings run on without a jump of a turn.
    poses: Vec<(f64, Pose)>,
    /// Longest time between two poses between which the robot is taken to move evenly.
    longest_gap_s: f64,
}

impl TruePath {
    /// The path of a log's true poses. `zero_ns` is the stamp of its first reading of the wheels.
    pub(super) fn of(poses: &[Stamped<Pose>], zero_ns: i64, keys: &LoggedTruth, longest_gap_s: f64) -> TruePath {
        let mut path: Vec<(f64, Pose)> = Vec::with_capacity(poses.len());
        for one in poses {
            let mut pose = in_world(one.value, keys);
            if let Some((_, before)) = path.last() {
                let turns = ((before.heading_rad - pose.heading_rad) / TAU).round();
                pose.heading_rad += turns * TAU;
            }
            path.push((one.stamp_ns.saturating_sub(zero_ns) as f64 * 1e-9, pose));
        }
        TruePath { poses: path, longest_gap_s }
    }

    /// Time of the first and of the last true pose.
    pub(super) fn span_s(&self) -> Option<[f64; 2]> {
        Some([self.poses.first()?.0, self.poses.last()?.0])
    }

    /// What is wrong, if the path has no pose in the time from the log's first reading of the wheels to its last estimate.
    pub(super) fn overlaps(&self, last_s: f64) -> Result<(), String> {
        match self.span_s() {
            Some([from_s, to_s]) if from_s > last_s || to_s < 0.0 => Err(format!(
                "the true poses are from {from_s:.3} s to {to_s:.3} s after the log's first reading of the wheels and the log ends at {last_s:.3} s, \
                 expected times of one clock"
            )),
            _ => Ok(()),
        }
    }

    /// The true pose at a time, even between the poses beside it; `None` outside of the path and in its gaps.
    pub(super) fn at(&self, time_s: f64) -> Option<Pose> {
        let after = self.poses.partition_point(|(at_s, _)| *at_s < time_s);
        let (to_s, to) = self.poses.get(after)?;
        if *to_s == time_s {
            return Some(*to);
        }
        let (from_s, from) = self.poses.get(after.checked_sub(1)?)?;
        if to_s - from_s > self.longest_gap_s {
            return None;
        }
        let share = (time_s - from_s) / (to_s - from_s);
        let between = |one: f64, other: f64| one + share * (other - one);
        Some(Pose {
            x_m: between(from.x_m, to.x_m),
            y_m: between(from.y_m, to.y_m),
            heading_rad: between(from.heading_rad, to.heading_rad),
        })
    }

    /// Way forward, way to the left and turn between two times, summed up from pose to pose; `None` where the path has a gap.
    pub(super) fn travelled(&self, from_s: f64, to_s: f64) -> Option<[f64; 3]> {
        let (mut before, mut before_s) = (self.at(from_s)?, from_s);
        let end = (to_s, self.at(to_s)?);
        let first = self.poses.partition_point(|(at_s, _)| *at_s <= from_s);
        let between = self.poses[first..].iter().take_while(|(at_s, _)| *at_s < to_s);
        let mut travelled = [0.0; 3];
        for &(at_s, pose) in between.chain([&end]) {
            if at_s - before_s > self.longest_gap_s {
                return None;
            }
            let turn_rad = pose.heading_rad - before.heading_rad;
            let (sin, cos) = (before.heading_rad + 0.5 * turn_rad).sin_cos();
            let [dx_m, dy_m] = [pose.x_m - before.x_m, pose.y_m - before.y_m];
            travelled[0] += cos * dx_m + sin * dy_m;
            travelled[1] += cos * dy_m - sin * dx_m;
            travelled[2] += turn_rad;
            (before, before_s) = (pose, at_s);
        }
        Some(travelled)
    }
}

/// The robot's pose in the world where `pose` is that of the tracked place in the frame of the true poses:
/// `world_from_robot = world_from_truth · truth_from_tracked · tracked_from_robot`.
fn in_world(pose: Pose, keys: &LoggedTruth) -> Pose {
    let world_from_truth = Pose { x_m: keys.x_m, y_m: keys.y_m, heading_rad: keys.heading_deg.to_radians() };
    let tracked = joined(world_from_truth, pose);
    let heading_rad = tracked.heading_rad - keys.yaw_deg.to_radians();
    let (sin, cos) = heading_rad.sin_cos();
    Pose {
        x_m: tracked.x_m - (cos * keys.forward_m - sin * keys.left_m),
        y_m: tracked.y_m - (sin * keys.forward_m + cos * keys.left_m),
        heading_rad,
    }
}

fn joined(outer: Pose, inner: Pose) -> Pose {
    let (sin, cos) = outer.heading_rad.sin_cos();
    Pose {
        x_m: outer.x_m + cos * inner.x_m - sin * inner.y_m,
        y_m: outer.y_m + sin * inner.x_m + cos * inner.y_m,
        heading_rad: outer.heading_rad + inner.heading_rad,
    }
}

/// Reads a file of poses in the TUM format. The poses come in the order of their times. Errors with what is wrong, and what was expected.
pub(super) fn read_tum(path: &Path) -> Result<Vec<Stamped<Pose>>, String> {
    let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
    let mut poses: Vec<Stamped<Pose>> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let wrong = |found: &str| {
            format!(
                "line {}: {found}, expected eight finite numbers: time, x, y, z, and a unit quaternion x, y, z, w",
                index + 1
            )
        };
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let numbers = numbers.map_err(|_| wrong("a word is no number"))?;
        let &[time_s, x, y, z, qx, qy, qz, qw] = numbers.as_slice() else {
            return Err(wrong(&format!("{} numbers", numbers.len())));
        };
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(wrong("a number is not finite"));
        }
        let pose = SpatialPose { position_m: [x, y, z], attitude: [qx, qy, qz, qw] };
        let value = pose.planar().ok_or_else(|| wrong("the quaternion has not the length 1"))?;
        let stamp_ns = (time_s * 1e9).round() as i64;
        poses.push(Stamped { stamp_ns, logged_ns: stamp_ns, number: poses.len(), value });
    }
    if poses.is_empty() {
        return Err("the file has no pose, expected one in each line".to_owned());
    }
    poses.sort_by_key(|pose| pose.stamp_ns);
    poses.dedup_by_key(|pose| pose.stamp_ns);
    Ok(poses)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn stamped(stamp_ns: i64, x_m: f64, y_m: f64, heading_rad: f64) -> Stamped<Pose> {
        Stamped { stamp_ns, logged_ns: stamp_ns, number: 0, value: Pose { x_m, y_m, heading_rad } }
    }

    #[test]
    fn a_tracked_place_ahead_of_the_axle_is_brought_back_to_it() {
        // The frame of the true poses is turned by a quarter, so that its (1, 0) is the world's (0, 1); the tracked place is 0.2 m ahead of a robot
        // that looks along the frame's x, the world's y.
        let keys = LoggedTruth { heading_deg: 90.0, forward_m: 0.2, ..LoggedTruth::default() };
        let path = TruePath::of(&[stamped(0, 1.0, 0.0, 0.0)], 0, &keys, 1.0);
        let pose = path.at(0.0).unwrap();
        assert!(pose.x_m.abs() < 1e-12 && (pose.y_m - 0.8).abs() < 1e-12, "{pose:?}");
        // A robot that looks along the world's x, and a place 0.2 m ahead and 0.1 m to the left of the axle.
        let keys = LoggedTruth { forward_m: 0.2, left_m: 0.1, ..LoggedTruth::default() };
        let pose = TruePath::of(&[stamped(0, 1.0, 0.0, 0.0)], 0, &keys, 1.0).at(0.0).unwrap();
        assert!((pose.x_m - 0.8).abs() < 1e-12 && (pose.y_m + 0.1).abs() < 1e-12, "{pose:?}");
    }

    #[test]
    fn between_two_poses_the_way_is_even_and_in_gaps_there_is_none() {
        let poses =
            [stamped(0, 0.0, 0.0, 3.1), stamped(1_000_000_000, 1.0, 0.0, -3.1), stamped(5_000_000_000, 2.0, 0.0, -3.1)];
        let path = TruePath::of(&poses, 0, &LoggedTruth::default(), 2.0);
        let pose = path.at(0.5).unwrap();
        // From 3.1 to −3.1 the short way leads over π.
        assert!((pose.x_m - 0.5).abs() < 1e-12 && (pose.heading_rad - std::f64::consts::PI).abs() < 1e-12, "{pose:?}");
        assert_eq!((path.at(3.0), path.at(6.0), path.travelled(0.5, 5.0)), (None, None, None));
    }

    #[test]
    fn the_way_of_a_robot_that_drives_backwards_is_negative() {
        let poses = [stamped(0, 0.0, 0.0, 0.0), stamped(1_000_000_000, -1.0, 0.5, 0.0)];
        let path = TruePath::of(&poses, 0, &LoggedTruth::default(), 2.0);
        assert_eq!(path.travelled(0.0, 1.0), Some([-1.0, 0.5, 0.0]));
    }

    #[test]
    fn the_axis_of_a_tracked_place_that_points_to_the_left_is_a_quarter_ahead_of_the_robots() {
        // The tracked axis looks along world x, and so the robot to its right of it along −y, with the tracked place 0.2 m ahead.
        let keys = LoggedTruth { yaw_deg: 90.0, forward_m: 0.2, ..LoggedTruth::default() };
        let pose = TruePath::of(&[stamped(0, 1.0, 0.0, 0.0)], 0, &keys, 1.0).at(0.0).unwrap();
        assert!((pose.heading_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{pose:?}");
        assert!((pose.x_m - 1.0).abs() < 1e-12 && (pose.y_m - 0.2).abs() < 1e-12, "{pose:?}");
    }
}
