//! The things of a place by the landmarks on them: a painting, a shelf, a door.
//!
//! A map of landmarks does not say which of them are on one thing and move together. Landmarks that are near each other are taken to be, by chains of
//! neighbours on the floor plan, since things stand upright. Two things that stand side by side or above each other are then one, which is no harm to a
//! method that has to do without any one of them.

use std::collections::BTreeMap;

use interval::Interval;
use nalgebra::Vector3;

use crate::reading::LandmarkId;

use super::SpacePoint;

/// Greatest distance on the floor plan, in metres, of neighbours on one thing: less than paintings are apart on a wall.
const NEIGHBOUR_M: f64 = 0.25;
/// Width of a landmark's box, in metres along any axis, up to which it is a link of a chain: two things are not one because of a landmark whose place is
/// hardly known.
const PLACED_M: f64 = 0.2;
/// Greatest angle, in radians, between the ray of a landmark that is no link and the nearest landmark that is one: then both are on the same thing.
const BESIDE_RAD: f64 = 0.3;

/// The thing that each landmark is on, by numbers from 0 in the order of the first landmarks of the things. Left out are landmarks whose place is hardly
/// known with no other beside their ray.
pub(crate) fn things(points: &[(LandmarkId, SpacePoint)]) -> BTreeMap<LandmarkId, u32> {
    let place = |point: &SpacePoint| point.place_m().filter(|sides| sides.iter().all(|side| side.width() <= PLACED_M));
    let links: Vec<(LandmarkId, [f64; 3])> =
        points.iter().filter_map(|(landmark, point)| Some((*landmark, place(point)?.map(Interval::mid)))).collect();
    let mut thing_of: Vec<Option<u32>> = vec![None; links.len()];
    let mut n_things = 0;
    for first in 0..links.len() {
        if thing_of[first].is_some() {
            continue;
        }
        thing_of[first] = Some(n_things);
        let mut ends = vec![first];
        while let Some(end) = ends.pop() {
            for next in 0..links.len() {
                if thing_of[next].is_none() && are_neighbours(links[end].1, links[next].1) {
                    thing_of[next] = Some(n_things);
                    ends.push(next);
                }
            }
        }
        n_things += 1;
    }
    let of_links = links.iter().zip(&thing_of).filter_map(|((landmark, _), thing)| Some((*landmark, (*thing)?)));
    let of_others = points.iter().filter(|(_, point)| place(point).is_none()).filter_map(|(landmark, point)| {
        let angles_rad = links.iter().map(|(_, at_m)| angle_rad(point, *at_m));
        let (beside_rad, nearest) = angles_rad.zip(&thing_of).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (beside_rad <= BESIDE_RAD).then_some((*landmark, (*nearest)?))
    });
    of_links.chain(of_others).collect()
}

fn are_neighbours(one_m: [f64; 3], other_m: [f64; 3]) -> bool {
    let [x_m, y_m] = [0, 1].map(|axis| one_m[axis] - other_m[axis]);
    x_m.hypot(y_m) <= NEIGHBOUR_M
}

/// Angle between a landmark's ray and a place, as seen from where the ray begins.
fn angle_rad(point: &SpacePoint, place_m: [f64; 3]) -> f64 {
    let anchor = &point.anchor;
    let [i, j] = anchor.sides();
    let mut ray = Vector3::zeros();
    (ray[anchor.axis], ray[i], ray[j]) = (anchor.sign(), point.value[0].mid(), point.value[1].mid());
    ray.angle(&(Vector3::from(place_m) - Vector3::from(anchor.from_m)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Anchor;

    /// A landmark at y and z on a wall at x = 2 m, seen from the origin, known along y to a width.
    fn on_wall(number: u32, [y_m, z_m]: [f64; 2], width_m: f64) -> (LandmarkId, SpacePoint) {
        let anchor = Anchor { from_m: [0.0; 3], axis: 0, is_positive: true };
        let value = [Interval::centred(0.5 * y_m, 0.25 * width_m), Interval::point(0.5 * z_m), Interval::point(0.5)];
        (LandmarkId(number), SpacePoint { anchor, value })
    }

    fn of(points: &[(LandmarkId, SpacePoint)]) -> Vec<(u32, u32)> {
        things(points).into_iter().map(|(landmark, thing)| (landmark.0, thing)).collect()
    }

    #[test]
    fn neighbours_are_on_one_thing_and_what_is_apart_on_another() {
        // Two paintings 0.3 m apart, of which the first is a chain from its left to its right end.
        let found = of(&[
            on_wall(1, [0.0, 1.0], 0.01),
            on_wall(2, [0.4, 1.0], 0.01),
            on_wall(3, [0.2, 1.1], 0.01),
            on_wall(4, [0.7, 1.0], 0.01),
            on_wall(5, [0.7, 1.2], 0.01),
        ]);
        assert_eq!(found, [(1, 0), (2, 0), (3, 0), (4, 1), (5, 1)]);
    }

    #[test]
    fn boards_of_a_shelf_are_one_thing_and_what_is_beside_it_is_another() {
        let found = of(&[
            on_wall(1, [0.0, 0.2], 0.01),
            on_wall(2, [0.1, 0.75], 0.01),
            on_wall(3, [0.0, 1.3], 0.01),
            on_wall(4, [0.4, 0.75], 0.01),
        ]);
        assert_eq!(found, [(1, 0), (2, 0), (3, 0), (4, 1)]);
    }

    #[test]
    fn a_landmark_whose_place_is_hardly_known_joins_the_thing_beside_its_ray_and_links_none() {
        let between = on_wall(3, [0.2, 1.0], 0.5);
        let far = on_wall(4, [3.0, 1.0], 0.5);
        // Of the last one nothing is known but the ray, to a place 0.1 m beside the second.
        let anywhere = {
            let (number, point) = on_wall(5, [0.55, 1.0], 0.01);
            (number, SpacePoint { value: [point.value[0], point.value[1], Interval::new(0.0, 1.0)], ..point })
        };
        let found = of(&[on_wall(1, [0.0, 1.0], 0.01), on_wall(2, [0.45, 1.0], 0.01), between, far, anywhere]);
        assert_eq!(found, [(1, 0), (2, 1), (3, 0), (5, 1)]);
        assert!(of(&[]).is_empty());
    }
}
