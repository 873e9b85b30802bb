//! Shadows of people. People move, so that the light map does not contain them; they are modelled as upright cylinders, and lamps as discs.

use nalgebra::{Point2, Point3, Vector3};

use super::{LightMap, Lighting, Source, lightmap::nodes_of};
use crate::place::building::{Panel, UprightBody};

/// Width of the cylinder that stands for a person, over the width of the person's shoulders: except at the shoulders people are narrower.
const WIDTH_OF_SHOULDERS: f64 = 0.75;
/// Least half-width of a shadow's penumbra: a person's outline is less sharp than a cylinder's.
const LEAST_SOFT_M: f64 = 0.02;
/// Share of the light that a person takes away at the feet in addition to hiding lamps, and the distance within which this share falls to 1/e.
const AT_FEET: (f64, f64) = (0.35, 0.15);
/// Distance from a person's feet, in multiples of the decay length of the shade around them, beyond which that shade is neglected (5e-5).
const FEET_REACH: f64 = 9.0;
/// Distance from the point below a lamp within which the direction to the lamp on the floor means nothing.
const STRAIGHT_BELOW_M: f64 = 1e-4;
/// Least share of a lamp's light that remains in a shadow, because some light always comes by reflection in the room.
const LEAST_LEFT: f64 = 0.05;

/// Illuminance at the nodes of a light map with the shadows of people, in the order of [`LightMap::nodes`].
pub fn nodes_with_people(
    lighting: &Lighting,
    map: &LightMap,
    panels: &[Panel],
    people: &[UprightBody],
) -> Vec<[f32; 2]> {
    let mut nodes = map.nodes.clone();
    for (panel, patch) in panels.iter().zip(&map.patches) {
        let corners = panel.corners();
        let shadows: Vec<(&Source, &UprightBody)> = lighting
            .sources
            .iter()
            .flat_map(|source| people.iter().map(move |person| (source, person)))
            .filter(|(source, person)| may_shade(source, person, &corners))
            .collect();
        let near: Vec<&UprightBody> = people.iter().filter(|person| feet_reach(person, &corners)).collect();
        if shadows.is_empty() && near.is_empty() {
            continue;
        }
        let normal = panel.normal();
        for (index, [s, t]) in nodes_of(*patch).enumerate() {
            let (i, j) = (index % patch.count[0], index / patch.count[0]);
            let node = &mut nodes[(patch.first[1] + j) * map.size[0] + patch.first[0] + i];
            let at = panel.place(s, t);
            let hidden_lux = hidden(&shadows, at, normal);
            let beside_feet = 1.0 - near.iter().map(|person| hidden_by_feet(person, at)).fold(0.0, f64::max);
            for band in 0..2 {
                let mapped_lux = f64::from(node[band]);
                let left = (1.0 - hidden_lux[band] / mapped_lux.max(1e-6)).max(LEAST_LEFT) * beside_feet;
                node[band] = (mapped_lux * left) as f32;
            }
        }
    }
    nodes
}

/// Whether a person may stand between a lamp and some point of a flat face of the building.
fn may_shade(source: &Source, person: &UprightBody, corners: &[Point3<f64>; 4]) -> bool {
    let lamp = source.shape.place(0.0, 0.0);
    let reach_m = WIDTH_OF_SHOULDERS * person.radius_m + 0.5 * source.shape.area_m2().sqrt() + LEAST_SOFT_M;
    let ends = || corners.iter().chain([&lamp]);
    (0..2).all(|axis| {
        let middle_m = person.middle_m[axis];
        ends().any(|end| end[axis] > middle_m - reach_m) && ends().any(|end| end[axis] < middle_m + reach_m)
    }) && ends().any(|end| end.z < person.height_m + reach_m)
}

fn feet_reach(person: &UprightBody, corners: &[Point3<f64>; 4]) -> bool {
    let reach_m = person.radius_m + FEET_REACH * AT_FEET.1;
    corners.iter().any(|corner| corner.z <= person.height_m)
        && (0..2).all(|axis| {
            let middle_m = person.middle_m[axis];
            corners.iter().any(|corner| corner[axis] > middle_m - reach_m)
                && corners.iter().any(|corner| corner[axis] < middle_m + reach_m)
        })
}

/// Illuminance, as equivalent lux in both bands, that a point loses because people stand before lamps.
fn hidden(shadows: &[(&Source, &UprightBody)], at: Point3<f64>, normal: Vector3<f64>) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for of_one_lamp in shadows.chunk_by(|one, other| std::ptr::eq(one.0, other.0)) {
        let source = of_one_lamp[0].0;
        let way = source.shape.place(0.0, 0.0) - at;
        let facing = way.dot(&normal);
        if facing <= 0.0 {
            continue;
        }
        let lamp_radius_m = 0.5 * source.shape.area_m2().sqrt();
        let open: f64 =
            of_one_lamp.iter().map(|(_, person)| 1.0 - hidden_behind(person, at, way, lamp_radius_m)).product();
        if open == 1.0 {
            continue;
        }
        let square = way.norm_squared();
        let shining = source.shape.normal().map_or(1.0, |normal| (-way.dot(&normal)).max(0.0) / square.sqrt());
        let lux = source.luminance() * source.shape.area_m2() * shining * facing / (square * square.sqrt());
        sum[0] += lux * (1.0 - open) * source.photons.visible;
        sum[1] += lux * (1.0 - open) * source.photons.infrared;
    }
    sum
}

/// Share of a lamp of the given radius that a person hides from a point.
fn hidden_behind(person: &UprightBody, at: Point3<f64>, way: Vector3<f64>, lamp_radius_m: f64) -> f64 {
    let to_axis = Point2::from(person.middle_m) - at.xy();
    let level_m = way.xy().norm();
    // Of a point straight below the lamp only who stands right there hides a part.
    let (aside_m, share) = if level_m < STRAIGHT_BELOW_M {
        (to_axis.norm(), 0.0)
    } else {
        let direction = way.xy() / level_m;
        let along_m = to_axis.dot(&direction);
        if along_m < 0.0 || along_m > level_m {
            return 0.0;
        }
        (direction.perp(&to_axis).abs(), along_m / level_m)
    };
    // Half-width of the shadow's penumbra, measured where the person stands.
    let soft_m = (lamp_radius_m * share).max(LEAST_SOFT_M);
    let beside_m = WIDTH_OF_SHOULDERS * person.radius_m - aside_m;
    let below_top_m = person.height_m - (at.z + way.z * share);
    smooth_step(beside_m / soft_m) * smooth_step(below_top_m / soft_m)
}

/// Share of the light that a person takes away from points close to the feet, in addition to hiding lamps.
fn hidden_by_feet(person: &UprightBody, at: Point3<f64>) -> f64 {
    let from_axis_m = (Point2::from(person.middle_m) - at.xy()).norm();
    if at.z > person.height_m { 0.0 } else { AT_FEET.0 * (-(from_axis_m - person.radius_m).max(0.0) / AT_FEET.1).exp() }
}

/// A smooth step from 0 at −1 to 1 at 1, with zero slope at both ends.
fn smooth_step(x: f64) -> f64 {
    let t = (0.5 + 0.5 * x).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
