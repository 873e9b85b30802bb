//! The things of a place by the landmarks on them: a painting, a shelf, a door.
//!
//! A map of landmarks does not say which of them are on one thing and move together. Landmarks that are near each other on the floor plan are taken to
//! be, by chains of neighbours, since things stand upright. Few landmarks that are by themselves are taken to be on what is next to them: a thing on
//! which a camera holds on here and there is not to count as several. Things that stand side by side or above each other may be one then, which is no
//! harm to a method that has to do without any one of them.

use std::collections::BTreeMap;

use interval::Interval;
use nalgebra::Vector3;

use crate::reading::LandmarkId;

use super::SpacePoint;

/// Greatest distance on the floor plan, in metres, of neighbours on one thing.
const NEIGHBOUR_M: f64 = 0.4;
/// Number of landmarks below which they are few, and greatest distance on the floor plan, in metres, of what they are then on.
const FEW: usize = 4;
const NEXT_M: f64 = 0.6;
/// Width of a landmark's box, in metres along any axis, up to which it is a link of a chain: two things are not one because of a landmark whose place is
/// hardly known.
const PLACED_M: f64 = 0.2;
/// Greatest angle, in radians, between the ray of a landmark that is no link and the nearest landmark that is one: then both are on the same thing. If
/// the landmark's depth is bounded, its box has to be within a distance of that on the floor plan, in metres, too.
const BESIDE_RAD: f64 = 0.3;
const BESIDE_M: f64 = 0.3;

/// The thing that each landmark is on, by numbers. Left out are landmarks whose place is hardly known with no other beside them.
pub fn things(points: &[(LandmarkId, SpacePoint)]) -> BTreeMap<LandmarkId, u32> {
    let links: Vec<(LandmarkId, [f64; 3])> =
        points.iter().filter_map(|(landmark, point)| Some((*landmark, link_m(point)?))).collect();
    let apart_m = |[one, other]: [usize; 2]| {
        let [x_m, y_m] = [0, 1].map(|axis| links[one].1[axis] - links[other].1[axis]);
        x_m.hypot(y_m)
    };
    let pairs = (0..links.len()).flat_map(|one| (0..one).map(move |other| [one, other]));
    let mut near: Vec<(f64, [usize; 2])> = pairs.map(|pair| (apart_m(pair), pair)).collect();
    near.retain(|(apart_m, _)| *apart_m <= NEXT_M);
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The nearest ones first. Things only grow, so that a pair which is passed by stays apart.
    let mut thing_of: Vec<usize> = (0..links.len()).collect();
    let mut sizes = vec![1; links.len()];
    for (apart_m, pair) in near {
        let [from, into] = pair.map(|at| thing_of[at]);
        if from != into && (apart_m <= NEIGHBOUR_M || sizes[from].min(sizes[into]) < FEW) {
            thing_of.iter_mut().filter(|thing| **thing == from).for_each(|thing| *thing = into);
            sizes[into] += sizes[from];
        }
    }
    let of_links = links.iter().zip(&thing_of).map(|((landmark, _), thing)| (*landmark, *thing as u32));
    let of_others = points.iter().filter(|(_, point)| link_m(point).is_none()).filter_map(|(landmark, point)| {
        let is_beside = |link: &(&(LandmarkId, [f64; 3]), &usize)| is_beside(point, link.0.1);
        let candidates = links.iter().zip(&thing_of).filter(is_beside);
        let (beside_rad, thing) = candidates
            .map(|((_, at_m), thing)| (angle_rad(point, *at_m), *thing))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        (beside_rad <= BESIDE_RAD).then_some((*landmark, thing as u32))
    });
    of_links.chain(of_others).collect()
}

/// The middle of a landmark's box, if that is narrow enough for the landmark to be a link.
fn link_m(point: &SpacePoint) -> Option<[f64; 3]> {
    let place_m = point.place_m().filter(|sides| sides.iter().all(|side| side.width() <= PLACED_M))?;
    Some(place_m.map(Interval::mid))
}

/// Whether a landmark may be near a place on the floor plan, as far as its box tells.
fn is_beside(point: &SpacePoint, place_m: [f64; 3]) -> bool {
    let Some(sides) = point.place_m() else { return true };
    (0..2).all(|axis| sides[axis].inflate(BESIDE_M).contains(place_m[axis]))
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
        // Two paintings 0.5 m apart, each a chain of four landmarks; the boards of a shelf are one thing whatever their heights.
        let at = |y_m: [f64; 8]| {
            let heights_m = [1.0, 0.1, 1.2, 1.9];
            (0..8).map(|k| on_wall(k as u32, [y_m[k], heights_m[k % 4]], 0.01)).collect::<Vec<_>>()
        };
        let found = of(&at([0.0, 0.7, 0.35, 0.9, 1.4, 1.7, 2.0, 2.3]));
        let numbers: Vec<u32> = found.iter().map(|(_, thing)| *thing).collect();
        assert!(numbers[..4].iter().all(|one| *one == numbers[0]) && numbers[4..].iter().all(|one| *one == numbers[4]));
        assert_ne!(numbers[0], numbers[4]);
    }

    #[test]
    fn few_landmarks_by_themselves_are_on_what_is_next_to_them() {
        // Four on the left of a sideboard; one 0.5 m beside them, and one 0.5 m beside that one. Another one is 0.7 m farther.
        let mut points: Vec<_> = (0..4).map(|k| on_wall(k, [0.1 * f64::from(k), 0.5], 0.01)).collect();
        points.extend([(4, 0.8), (5, 1.3), (6, 2.0)].map(|(number, y_m)| on_wall(number, [y_m, 0.5], 0.01)));
        let numbers: Vec<u32> = of(&points).iter().map(|(_, thing)| *thing).collect();
        assert!(numbers[..6].iter().all(|one| *one == numbers[0]), "{numbers:?}");
        assert_ne!(numbers[6], numbers[0]);
    }

    #[test]
    fn a_landmark_whose_place_is_hardly_known_joins_the_thing_beside_its_ray_and_links_none() {
        let between = on_wall(3, [0.3, 1.0], 0.5);
        let far = on_wall(4, [3.0, 1.0], 0.5);
        // Of this one nothing is known but the ray, to a place 0.1 m beside the second.
        let anywhere = {
            let (number, point) = on_wall(5, [0.75, 1.0], 0.01);
            (number, SpacePoint { value: [point.value[0], point.value[1], Interval::new(0.0, 1.0)], ..point })
        };
        // This one is in line with the second from where it was seen, and a metre nearer.
        let nearer = {
            let (number, point) = on_wall(6, [0.65, 1.0], 0.01);
            (number, SpacePoint { value: [point.value[0], point.value[1], Interval::new(0.8, 1.2)], ..point })
        };
        let found = of(&[on_wall(1, [0.0, 1.0], 0.01), on_wall(2, [0.65, 1.0], 0.01), between, far, anywhere, nearer]);
        assert_eq!(found, [(1, 0), (2, 1), (3, 0), (5, 1)]);
        assert!(of(&[]).is_empty());
    }
}
