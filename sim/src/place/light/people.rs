//! Shadows of people. People move, so that the light map does not contain them; they are modelled as upright cylinders, and lamps as discs.

use nalgebra::{Point2, Point3, Vector3};

use super::{
    LightMap, Lighting, Patch, Source,
    footprint::{Around, footprint},
    nodes::nodes_of,
};
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
        let near: Vec<&UprightBody> = people.iter().filter(|person| feet_reach(person, &corners)).collect();
        let hidden_lux = hidden(lighting, panel, *patch, people);
        if hidden_lux.is_empty() && near.is_empty() {
            continue;
        }
        for (index, [s, t]) in nodes_of(*patch).enumerate() {
            let (i, j) = (index % patch.count[0], index / patch.count[0]);
            let node = &mut nodes[(patch.first[1] + j) * map.size[0] + patch.first[0] + i];
            let hidden_lux = hidden_lux.get(index).copied().unwrap_or_default();
            let at = panel.place(s, t);
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

/// Illuminance, as equivalent lux in both bands, that each node of a face loses because people stand before lamps; empty where none can.
///
/// In a hall nearly every lamp and every person could shade some point of the floor, but each pair shades a small part of it: only the nodes of that
/// part are asked.
fn hidden(lighting: &Lighting, panel: &Panel, patch: Patch, people: &[UprightBody]) -> Vec<[f64; 2]> {
    let (corners, normal) = (panel.corners(), panel.normal());
    let place = |i: usize, j: usize| {
        panel.place(i as f64 / (patch.count[0] - 1) as f64, j as f64 / (patch.count[1] - 1) as f64)
    };
    let mut sum = Vec::new();
    // Share of the lamp that people leave open to each node.
    let mut open = vec![1.0; patch.count[0] * patch.count[1]];
    for source in &lighting.sources {
        let lamp = source.shape.place(0.0, 0.0);
        let lamp_radius_m = 0.5 * source.shape.area_m2().sqrt();
        let mut shaded = Vec::new();
        for person in people.iter().filter(|person| may_shade(source, person, &corners)) {
            let rows = footprint(panel, patch, lamp, &around(source, person, &corners));
            for (i, j) in rows.iter().flat_map(|(j, nodes)| nodes.clone().map(move |i| (i, *j))) {
                let at = place(i, j);
                open[j * patch.count[0] + i] *= 1.0 - hidden_behind(person, at, lamp - at, lamp_radius_m);
            }
            shaded.extend(rows);
        }
        for (i, j) in shaded.into_iter().flat_map(|(j, nodes)| nodes.map(move |i| (i, j))) {
            let index = j * patch.count[0] + i;
            let left = std::mem::replace(&mut open[index], 1.0);
            let (at, photons) = (place(i, j), source.photons);
            let facing = (lamp - at).dot(&normal);
            if left == 1.0 || facing <= 0.0 {
                continue;
            }
            let (way, square) = (lamp - at, (lamp - at).norm_squared());
            let shining = source.shape.normal().map_or(1.0, |normal| (-way.dot(&normal)).max(0.0) / square.sqrt());
            let lux = source.luminance() * source.shape.area_m2() * shining * facing / (square * square.sqrt());
            sum.resize(open.len(), [0.0; 2]);
            sum[index][0] += lux * (1.0 - left) * photons.visible;
            sum[index][1] += lux * (1.0 - left) * photons.infrared;
        }
    }
    sum
}

/// The box in which a line from a point of a face to a lamp passes a person that hides a part of the lamp from the point.
fn around(source: &Source, person: &UprightBody, corners: &[Point3<f64>; 4]) -> Around {
    let lamp = source.shape.place(0.0, 0.0);
    let lamp_radius_m = 0.5 * source.shape.area_m2().sqrt();
    let lowest_m = corners.iter().map(|corner| corner.z).fold(lamp.z, f64::min);
    // On the line from a point at height z, the share σ of the way to the lamp at which it passes the person keeps z + (lamp − z)·σ below the top of
    // the penumbra, h + r·σ or h + LEAST_SOFT_M. Where the lamp hangs above the person, the lowest point has the greatest σ.
    let share = |above_m: f64, soft_m: f64| (person.height_m + soft_m - lowest_m) / (above_m - lowest_m).max(1e-9);
    let greatest_share = match lamp.z - lamp_radius_m > person.height_m + LEAST_SOFT_M {
        true => share(lamp.z - lamp_radius_m, 0.0).max(share(lamp.z, LEAST_SOFT_M)).clamp(0.0, 1.0),
        false => 1.0,
    };
    let soft_m = (lamp_radius_m * greatest_share).max(LEAST_SOFT_M);
    let reach_m = WIDTH_OF_SHOULDERS * person.radius_m + soft_m;
    let [x_m, y_m] = person.middle_m;
    Around {
        low: Point3::new(x_m - reach_m, y_m - reach_m, lowest_m),
        high: Point3::new(x_m + reach_m, y_m + reach_m, person.height_m + soft_m),
    }
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

#[cfg(test)]
mod tests {
    use nalgebra::vector;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::{
        optics::Photons,
        place::{
            building::{Material, Part},
            light::Shape,
        },
    };

    use super::*;

    /// Floor, ceiling, two walls and the top of a table.
    fn panels() -> Vec<Panel> {
        let panel = |corner: [f64; 3], along: [f64; 3], up: [f64; 3]| Panel {
            corner: Point3::from(corner),
            along: Vector3::from(along),
            up: Vector3::from(up),
            material: Material::matt(0.5),
            part: Part::Thing,
            room: 0,
            outline: None,
        };
        vec![
            panel([0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 4.0, 0.0]),
            panel([0.0, 0.0, 2.5], [0.0, 4.0, 0.0], [6.0, 0.0, 0.0]),
            panel([0.0, 4.0, 0.0], [0.0, -4.0, 0.0], [0.0, 0.0, 2.5]),
            panel([6.0, 4.0, 0.0], [-6.0, 0.0, 0.0], [0.0, 0.0, 2.5]),
            panel([2.0, 1.0, 0.75], [1.2, 0.0, 0.0], [0.0, 0.8, 0.0]),
        ]
    }

    #[test]
    fn no_point_that_a_person_shades_is_left_out_of_a_shadows_footprint() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let patch = Patch { first: [0, 0], count: [25, 17] };
        let mut n_shaded = 0;
        for index in 0..400 {
            let mut draw = |low: f64, high: f64| rng.random_range(low..high);
            let at = Point3::new(draw(0.1, 5.9), draw(0.1, 3.9), draw(0.3, 2.48));
            let shape = match index % 2 {
                0 => Shape::Point { at, radius_m: draw(0.01, 0.1) },
                _ => Shape::Rectangle {
                    centre: at,
                    half_u: vector![draw(0.05, 0.6), 0.0, 0.0],
                    half_v: vector![0.0, -draw(0.05, 0.6), 0.0],
                },
            };
            let source = Source { shape, lumens: 1000.0, photons: Photons { visible: 1.0, infrared: 1.0 } };
            let person = UprightBody {
                middle_m: [draw(0.1, 5.9), draw(0.1, 3.9)],
                heading_rad: 0.0,
                height_m: draw(0.5, 2.2),
                radius_m: draw(0.1, 0.4),
                stride: 0.0,
                velocity_m_per_s: [0.0; 2],
            };
            let lamp_radius_m = 0.5 * source.shape.area_m2().sqrt();
            for panel in &panels() {
                let corners = panel.corners();
                let lamp = source.shape.place(0.0, 0.0);
                let found = match may_shade(&source, &person, &corners) {
                    true => footprint(panel, patch, lamp, &around(&source, &person, &corners)),
                    false => Vec::new(),
                };
                let is_in = |i: usize, j: usize| found.iter().any(|(row, nodes)| *row == j && nodes.contains(&i));
                for (index, [s, t]) in nodes_of(patch).enumerate() {
                    let at = panel.place(s, t);
                    let is_lit = (lamp - at).dot(&panel.normal()) > 0.0;
                    if is_lit && hidden_behind(&person, at, lamp - at, lamp_radius_m) > 0.0 {
                        assert!(is_in(index % patch.count[0], index / patch.count[0]), "{at} {source:?} {person:?}");
                        n_shaded += 1;
                    }
                }
            }
        }
        assert!(n_shaded > 10_000, "{n_shaded}");
    }
}
