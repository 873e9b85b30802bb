//! The sightings of a picture that together tell most of the pose.

use interval::Interval;
use nalgebra::{Matrix3, Vector3};

use crate::PoseBox;

use super::{
    ray::{Optics, POINT},
    relate::Sight,
};

/// Number of the parameters that are a landmark's and the pose's, which are the first.
const OF_POINT_AND_POSE: usize = 6;
/// Least half width of a pose's coordinate, in metres and radians, in which what is told of it is counted.
const LEAST: [f64; 3] = [0.02, 0.02, 0.005];

/// What a sighting says of the pose: for each of its two equations the coefficients of x, y and heading, in half widths of the pose's box and in errors
/// of the equation.
type Told = [Vector3<f64>; 2];

/// The places of at most so many of some sightings: of those that are left one after the other that which, together with those that were taken before, tells
/// most of the pose, no two of them nearer in the picture than a distance. Of the sightings of one thing at most `most_of_thing` are taken.
///
/// With the coefficients a of all equations, the sighting is taken with which det(1 + Σ a·aᵀ) grows most: a greedy D-optimal design.
pub(super) fn most_telling(
    sights: &[Sight],
    pose: &PoseBox,
    optics: &Optics,
    (most, most_of_thing): (usize, usize),
    least_px: f64,
) -> Vec<usize> {
    let told: Vec<Told> = sights.iter().map(|sight| told(sight, pose, optics)).collect();
    let apart_px = |a: usize, b: usize| {
        let [du, dv] = [0, 1].map(|axis| sights[a].at_px[axis] - sights[b].at_px[axis]);
        du.hypot(dv)
    };
    let mut left: Vec<usize> = (0..sights.len()).collect();
    let mut used: Vec<usize> = Vec::new();
    let mut sum = Matrix3::identity();
    while used.len() < most {
        let with = |at: usize| told[at].iter().fold(sum, |sum, a| sum + a * a.transpose());
        let Some((_, best)) =
            left.iter().map(|&at| (with(at).determinant(), at)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
        else {
            break;
        };
        sum = with(best);
        used.push(best);
        let of_thing = |at: usize| sights[at].thing.filter(|_| sights[at].thing == sights[best].thing);
        let is_full = used.iter().filter(|&&at| of_thing(at).is_some()).count() >= most_of_thing;
        left.retain(|&at| at != best && apart_px(at, best) >= least_px && !(is_full && of_thing(at).is_some()));
    }
    used
}

/// What a sighting says of the pose at the middle of its box.
fn told(sight: &Sight, pose: &PoseBox, optics: &Optics) -> Told {
    let middle = optics.parameters(pose, sight.point.value).map(|one| Interval::point(one.mid()));
    let (equations, depth) = optics.equations::<OF_POINT_AND_POSE>(&middle, &sight.point.anchor, sight.at_px);
    let halves = [0, 1, 2].map(|axis| (0.5 * pose.width(axis)).max(LEAST[axis]));
    [0, 1].map(|k| {
        let slope = |index: usize| equations[k].slopes[index].mid();
        let of_picture = sight.error_px[k] * depth.value.mid().abs();
        let of_landmark = match &sight.view {
            // A picture from nearly the same place shows the landmark in the same direction, with an error of its own.
            Some(view) => view.sight.error_px[k] * depth.value.mid().abs(),
            None => POINT.iter().map(|&index| slope(index).abs() * sight.point.value[index].radius()).sum::<f64>(),
        };
        let error = (of_picture + of_landmark).max(1e-9);
        Vector3::from_fn(|axis, _| slope(POINT.len() + axis) * halves[axis] / error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        graph::trial::Draw,
        map::{Anchor, SpacePoint},
        methods::mapped_landmarks::trial::True,
        reading::LandmarkId,
    };

    #[test]
    fn what_is_near_is_taken_before_more_of_what_is_far() {
        let mut draw = Draw::new(20_261_132);
        let truth = True::new(&mut draw, 0.0);
        let optics = Optics::new(truth.camera, truth.body);
        // Ahead of the camera, side by side: nine landmarks 30 m away, and one 2 m away.
        let anchor = Anchor { from_m: [0.0, 0.0, 0.5], axis: 0, is_positive: true };
        let sights: Vec<Sight> = (0..10)
            .map(|at| Sight {
                landmark: LandmarkId(at),
                point: SpacePoint {
                    anchor,
                    value: [0.4, 0.2, if at == 7 { 0.5 } else { 1.0 / 30.0 }].map(|one| Interval::centred(one, 1e-4)),
                },
                at_px: [100.0 + 30.0 * f64::from(at), 200.0],
                error_px: [0.5; 2],
                view: None,
                thing: None,
            })
            .collect();
        let pose =
            PoseBox::from([Interval::centred(0.0, 0.2), Interval::centred(0.0, 0.2), Interval::centred(0.0, 0.02)]);
        assert_eq!(most_telling(&sights, &pose, &optics, (4, 10), 14.0)[0], 7);
        // Of the sightings of one thing no more are taken than asked for.
        let on_things: Vec<Sight> =
            sights.iter().map(|sight| Sight { thing: (sight.landmark.0 > 4).then_some(3), ..*sight }).collect();
        let taken = most_telling(&on_things, &pose, &optics, (10, 2), 14.0);
        assert_eq!(taken.iter().filter(|&&at| at > 4).count(), 2);
        assert_eq!(taken.len(), 7);
        // No two of them are nearer to each other than asked for.
        let apart = most_telling(&sights, &pose, &optics, (10, 10), 70.0);
        let places: Vec<f64> = apart.iter().map(|&at| sights[at].at_px[0]).collect();
        assert!(
            places.len() >= 3 && places.iter().all(|a| places.iter().filter(|b| (*a - **b).abs() < 70.0).count() == 1)
        );
        assert_eq!(most_telling(&sights, &pose, &optics, (4, 10), 14.0).len(), 4);
    }
}
