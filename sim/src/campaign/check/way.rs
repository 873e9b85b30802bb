//! The places of a scene's way at which pictures are taken.

use localizer::Pose;

use crate::{
    place::navigation::{Planner, length_m},
    scene::Scene,
};

/// Greatest number of places.
const MOST_PLACES: usize = 24;
/// Least distance between two of them along the way, so that a short way has few.
const LEAST_APART_M: f64 = 0.25;

/// Places along the way of a scene's robot.
#[derive(Clone, Debug)]
pub(super) struct Way {
    /// The poses of the robot, in the order in which it comes by.
    pub(super) places: Vec<Pose>,
    /// Length of the whole way; `None` for a scene with stations, which has none.
    pub(super) length_m: Option<f64>,
}

/// At most 24 places, evenly along the way from the start through all waypoints, or to all errands and from there to the goals `drawn_m` that the seed
/// draws, with the heading of the way; or as many of the scene's stations, evenly among them.
pub(super) fn way(scene: &Scene, drawn_m: &[[f64; 2]]) -> Way {
    if !scene.stations.is_empty() {
        let pose = |station: &crate::scene::Station| Pose {
            x_m: station.x_m,
            y_m: station.y_m,
            heading_rad: station.heading_deg.to_radians(),
        };
        let all: Vec<Pose> = scene.stations.iter().map(pose).collect();
        let n_places = all.len().min(MOST_PLACES);
        let places = (0..n_places).map(|nth| all[nth * all.len() / n_places]).collect();
        return Way { places, length_m: None };
    }
    let corners_m = corners_m(scene, drawn_m);
    let length_m = length_m(&corners_m);
    let n_places = ((length_m / LEAST_APART_M) as usize + 1).min(MOST_PLACES);
    let start = scene.nominal_start();
    let along = (1..n_places).filter_map(|nth| pose_at(&corners_m, length_m * nth as f64 / (n_places - 1) as f64));
    Way { places: std::iter::once(start).chain(along).collect(), length_m: Some(length_m) }
}

/// Corners of the way from the start on.
fn corners_m(scene: &Scene, drawn_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let start = scene.nominal_start();
    let mut corners_m = vec![[start.x_m, start.y_m]];
    if let Some(route) = &scene.route {
        corners_m.extend(route.waypoints.iter().map(|waypoint| [waypoint.x_m, waypoint.y_m]));
        return corners_m;
    }
    let planner = Planner::of(scene);
    for goal_m in scene.errands.iter().map(|errand| [errand.x_m, errand.y_m]).chain(drawn_m.iter().copied()) {
        let from_m = corners_m[corners_m.len() - 1];
        if let Some(path_m) = planner.plan(from_m, goal_m) {
            corners_m.extend(path_m);
        }
    }
    corners_m
}

/// The pose at a distance along the way, with the way's heading there.
fn pose_at(corners_m: &[[f64; 2]], distance_m: f64) -> Option<Pose> {
    let mut left_m = distance_m;
    let mut last = None;
    for pair in corners_m.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let along = [to[0] - from[0], to[1] - from[1]];
        let length_m = along[0].hypot(along[1]);
        if length_m < 1e-9 {
            continue;
        }
        let share = (left_m / length_m).min(1.0);
        let heading_rad = along[1].atan2(along[0]);
        last = Some(Pose { x_m: from[0] + share * along[0], y_m: from[1] + share * along[1], heading_rad });
        if left_m <= length_m {
            break;
        }
        left_m -= length_m;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_on_the_way_has_the_heading_of_its_stretch() {
        // 3 m along x, then 4 m along y; the robot stands at the corner in between for a while.
        let corners_m = [[0.0, 0.0], [3.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
        let at = |distance_m: f64| pose_at(&corners_m, distance_m).map(Pose::to_array);
        assert_eq!(at(1.0), Some([1.0, 0.0, 0.0]));
        assert_eq!(at(5.0), Some([3.0, 2.0, std::f64::consts::FRAC_PI_2]));
        assert_eq!(at(7.5), Some([3.0, 4.0, std::f64::consts::FRAC_PI_2]));
        assert_eq!(pose_at(&[[1.0, 1.0]], 0.0).map(Pose::to_array), None);
    }
}
