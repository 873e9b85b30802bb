//! Light maps: illuminance at a grid of points (nodes) on every flat face of a building, computed once.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::{Point3, Vector3};

use super::{
    Daylight, Illuminance, Lighting, Shape, Source,
    ambient::Ambient,
    gathered::Thrown,
    nodes::{Patch, hair, inside, nearest, nodes_of},
    occlusion::{Between, Occluders, weight},
    parallel::in_parallel,
    radiosity::Reflecting,
    reflector::Reflector,
    sky::Horizon,
};
use crate::{
    place::building::{Building, Panel, Part},
    scene::Scene,
};

/// Wanted distance between the nodes of the light map (points with a computed illuminance): on floors, and on all other faces of the building.
const NODE_DISTANCE_M: [f64; 2] = [0.05, 0.08];
/// Greatest number of nodes (points with a computed illuminance) of a light map; more would take seconds to compute. In a large hall the nodes
/// are farther apart.
const MAX_NODES: f64 = 90_000.0;
/// Greatest number of nodes outdoors, where sites are large and the light of the map has no sharp shadows.
const MAX_NODES_OUTDOORS: f64 = 40_000.0;
/// Wanted distance between the nodes of a floor on which a small lamp in its room casts shadows of furniture: a bulb of 10 cm, 2.1 m up, draws the
/// edge of a seat 0.4 m high over 24 mm.
const FINE_NODE_DISTANCE_M: f64 = 0.0125;
/// Greatest distance between opposite corners of a lamp that counts as small, or of the square around a bulb.
const SMALL_LAMP_M: f64 = 0.15;
/// Greatest number of nodes of all floors with a smaller distance between nodes. More would cost time whenever people and their shadows move.
const MAX_FINE_NODES: f64 = 30_000.0;
/// Number of nodes (points with a computed illuminance) in a row of the light map; no flat face of the building has more nodes in a row.
const WIDTH: usize = 1024;
/// Number of points along each side of a cell around a node of the light map, over which shadows are averaged. Each of these points is paired
/// with a different point on the lamp. The number must not be a multiple of 3, or points of the lamp would be left out.
const SUB_PLACES: usize = 7;
/// Corners of a lamp, by the coordinates along its axes.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Illuminance in both bands over all panels (flat faces) of a building, before the factor on all light that yields the illuminance which the
/// scene states.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Numbers of nodes (points with a computed illuminance) along both sides of the light map.
    pub size: [usize; 2],
    /// Equivalent lux at each node (point) of the light map, in the visible and in the infrared band, row by row.
    pub nodes: Vec<[f32; 2]>,
    /// For each flat face of the building, in the order of its panels, the rectangle of the light map that holds the face's nodes.
    pub patches: Vec<Patch>,
    /// Mean illuminance over the floor of the first room, which is the robot's: in lux, and by band (visible and infrared).
    pub mean_at_floor: Illuminance,
}

impl LightMap {
    /// Illuminance in one band (visible or infrared) at a point of a flat face, the shares `s` and `t` of the face's sides from 0 to 1; bilinear
    /// between the nodes of the light map.
    pub fn at(&self, panel: usize, s: f64, t: f64, band: usize) -> f64 {
        let patch = self.patches[panel];
        let node =
            |[i, j]: [usize; 2]| f64::from(self.nodes[(patch.first[1] + j) * self.size[0] + patch.first[0] + i][band]);
        patch.around([s, t]).map(|(at, weight)| weight * node(at)).iter().sum()
    }
}

/// What the light of all lamps of a building has in common: where its light map has nodes, and how its surfaces see each other.
pub(super) struct Baking<'a> {
    building: &'a Building,
    occluders: &'a Occluders,
    size: [usize; 2],
    patches: Vec<Patch>,
    reflecting: Reflecting<'a>,
    view_factors: Vec<Vec<(u32, f32)>>,
}

impl Baking<'_> {
    pub(super) fn new<'a>(building: &'a Building, lamps: &[Source], occluders: &'a Occluders) -> Baking<'a> {
        let (size, patches) = layout(building, &finely_shadowed(building, lamps, occluders));
        let reflecting = Reflecting::new(building, occluders);
        let view_factors = reflecting.view_factors();
        Baking { building, occluders, size, patches, reflecting, view_factors }
    }

    /// The light map of some of the building's lamps, and their reflected light anywhere in each room.
    ///
    /// With daylight, the map has the light of the sky and what is reflected, sunlight included, but not the direct sunlight, whose shadows the
    /// renderer draws. The mean over the floor has all of it.
    pub(super) fn light_of(&self, lamps: &[&Source], daylight: Option<&Daylight>) -> (LightMap, Ambient) {
        let (building, occluders, reflecting) = (self.building, self.occluders, &self.reflecting);
        let work: Vec<(&Panel, Patch)> = building.panels.iter().zip(self.patches.iter().copied()).collect();
        let direct = match daylight {
            None => in_parallel(&work, |(panel, patch)| direct_nodes(lamps, occluders, panel, *patch)),
            Some(daylight) => {
                let horizon = Horizon::new(building);
                in_parallel(&work, |(panel, patch)| sky_nodes(daylight, &horizon, panel, *patch))
            }
        };
        let sunlight = |at: Point3<f64>, normal: Vector3<f64>| {
            daylight.map_or_else(Illuminance::default, |daylight| daylight.direct_at(at, normal, occluders))
        };
        let of_reflector = |one: &Reflector| {
            let diffuse = mean_at(one, self.patches[one.panel], &direct[one.panel]);
            let add = |sum: Illuminance, at: &Point3<f64>| sum.plus(1.0, sunlight(*at, one.normal));
            let sunlit = one.places.iter().fold(Illuminance::default(), add);
            diffuse.plus(1.0 / one.places.len() as f64, sunlit)
        };
        let first: Vec<Illuminance> = reflecting.all.iter().map(of_reflector).collect();
        let exitances = reflecting.exitances(&self.view_factors, &first);
        let thrown = Thrown { building, occluders, reflecting, exitances: &exitances };
        let reflected = thrown.over_faces(&work);
        let sum = |(direct, reflected): (&Vec<Illuminance>, &Vec<Illuminance>)| -> Vec<Illuminance> {
            direct.iter().zip(reflected).map(|(direct, reflected)| direct.plus(1.0, *reflected)).collect()
        };
        let total: Vec<Vec<Illuminance>> = direct.iter().zip(&reflected).map(sum).collect();
        let size = self.size;
        let is_own_floor = |panel: &Panel| panel.part == Part::Floor && panel.room == 0;
        let mut mean_at_floor = mean_over(&work, &total, is_own_floor);
        if daylight.is_some() {
            let on_nodes = |(panel, patch): &(&Panel, Patch)| -> Vec<Illuminance> {
                let at = |[s, t]: [f64; 2]| {
                    if is_own_floor(panel) {
                        sunlight(panel.place(s, t), panel.normal())
                    } else {
                        Illuminance::default()
                    }
                };
                nodes_of(*patch).map(at).collect()
            };
            mean_at_floor = mean_at_floor.plus(1.0, mean_over(&work, &in_parallel(&work, on_nodes), is_own_floor));
        }
        let mut map =
            LightMap { size, nodes: vec![[0.0; 2]; size[0] * size[1]], mean_at_floor, patches: self.patches.clone() };
        for (patch, nodes) in map.patches.iter().zip(&total) {
            for (index, light) in nodes.iter().enumerate() {
                let (i, j) = (index % patch.count[0], index / patch.count[0]);
                map.nodes[(patch.first[1] + j) * size[0] + patch.first[0] + i] = light.by_band.map(|lux| lux as f32);
            }
        }
        (map, Ambient::new(&thrown))
    }
}

/// The factor on all lamps that yields the illuminance which the scene states at the camera or on the floor; 1 if the scene states how strong
/// each lamp is.
pub(super) fn dimming(scene: &Scene, building: &Building, lighting: &Lighting, mean_at_floor_lux: f64) -> f64 {
    if lighting.daylight.is_some() {
        return 1.0;
    }
    let ratio = |wanted: f64, given: f64| if given > 0.0 { wanted / given } else { 0.0 };
    if let (Some(wanted_lux), Some(camera)) = (scene.light.illuminance_at_camera_lux, &scene.robot.forward_camera) {
        let start = scene.nominal_start();
        let (sin, cos) = start.heading_rad.sin_cos();
        let at = Point3::new(
            start.x_m + cos * camera.forward_m - sin * camera.left_m,
            start.y_m + sin * camera.forward_m + cos * camera.left_m,
            camera.height_m,
        );
        let facing = crate::place::building::level(start.heading_rad + camera.yaw_deg.to_radians());
        return ratio(wanted_lux, lighting.at(at, facing, building.room_at(at), 8).lux);
    }
    if scene.lamps_state_outputs() { 1.0 } else { ratio(scene.light.illuminance_at_floor_lux, mean_at_floor_lux) }
}

/// Whether each flat face of the building is a floor on which a small lamp in the same room casts shadows of furniture.
fn finely_shadowed(building: &Building, lamps: &[Source], occluders: &Occluders) -> Vec<bool> {
    let is_small = |lamp: &&Source| 2.0 * lamp.shape.reach_m() < SMALL_LAMP_M;
    let small: Vec<&Source> = lamps.iter().filter(is_small).collect();
    let is_fine = |panel: &Panel| {
        let is_near = |lamp: &&&Source| building.room_at(lamp.shape.place(0.0, 0.0)) == panel.room;
        let casts = |lamp: &&Source| in_the_way(occluders, lamp, panel).has_boxes();
        panel.part == Part::Floor && small.iter().filter(is_near).any(casts)
    };
    building.panels.iter().map(is_fine).collect()
}

/// Gives each flat face of the building a rectangle of the light map for its nodes, which are closer to each other on `fine` faces. The rectangles
/// are packed in rows, from the tallest to the lowest.
fn layout(building: &Building, fine: &[bool]) -> ([usize; 2], Vec<Patch>) {
    let usual_m = |panel: &Panel| NODE_DISTANCE_M[usize::from(panel.part != Part::Floor)];
    let wanted: f64 = building.panels.iter().map(|panel| panel.area_m2() / usual_m(panel).powi(2)).sum();
    let most = if building.is_open { MAX_NODES_OUTDOORS } else { MAX_NODES };
    let stretch = (wanted / most).sqrt().max(1.0);
    let fine_m2: f64 =
        building.panels.iter().zip(fine).filter(|(_, fine)| **fine).map(|(panel, _)| panel.area_m2()).sum();
    let fine_m = FINE_NODE_DISTANCE_M.max((fine_m2 / MAX_FINE_NODES).sqrt());
    let counts: Vec<[usize; 2]> = building
        .panels
        .iter()
        .zip(fine)
        .map(|(panel, fine)| {
            let usual_m = usual_m(panel) * stretch;
            let distance_m = if *fine { usual_m.min(fine_m) } else { usual_m };
            panel.size_m().map(|side_m| ((side_m / distance_m).ceil() as usize + 1).clamp(2, WIDTH))
        })
        .collect();
    let mut order: Vec<usize> = (0..counts.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(counts[index][1]));
    let mut patches = vec![Patch { first: [0; 2], count: [2; 2] }; counts.len()];
    let (mut column, mut row, mut row_height) = (0, 0, 0);
    for index in order {
        let count = counts[index];
        if column + count[0] > WIDTH {
            (column, row) = (0, row + row_height);
            row_height = 0;
        }
        row_height = row_height.max(count[1]);
        patches[index] = Patch { first: [column, row], count };
        column += count[0];
    }
    ([WIDTH, (row + row_height).max(1)], patches)
}

/// Light of the sky at every light-map node of a flat face.
fn sky_nodes(daylight: &Daylight, horizon: &Horizon, panel: &Panel, patch: Patch) -> Vec<Illuminance> {
    let normal = panel.normal();
    let at = |shares: [f64; 2]| {
        let [s, t] = inside(panel, shares);
        daylight.diffuse_horizontal.times(horizon.share(panel.place(s, t), normal))
    };
    nodes_of(patch).map(at).collect()
}

/// Direct light, shadows included, at every light-map node of a flat face.
fn direct_nodes(lamps: &[&Source], occluders: &Occluders, panel: &Panel, patch: Patch) -> Vec<Illuminance> {
    let shadowing: Vec<_> = lamps.iter().map(|source| (*source, in_the_way(occluders, source, panel))).collect();
    let normal = panel.normal();
    let cells = Cells { panel, normal, step: patch.count.map(|count| 1.0 / (count - 1) as f64) };
    nodes_of(patch)
        .map(|shares| {
            let mut sum = Illuminance::default();
            // A node beyond the face's outline has the light of the nearest place within, and no light if nothing shows it.
            let [s, t] = nearest(panel, shares);
            if cells.is_unseen(shares, [s, t]) {
                return sum;
            }
            let mut between = Between::default();
            for (source, occluders) in &shadowing {
                let unshadowed = source.illuminance(panel.place(s, t), normal);
                if unshadowed > 0.0 {
                    let is_open = occluders.is_empty();
                    let share = if is_open { 1.0 } else { cells.share(source, occluders, [s, t], &mut between) };
                    sum.add(unshadowed * share, source.photons);
                }
            }
            sum
        })
        .collect()
}

/// The furniture and walls that may stand between a lamp and a flat face of the building.
fn in_the_way(all: &Occluders, source: &Source, panel: &Panel) -> Occluders {
    let middle = panel.place(0.5, 0.5);
    let ends = CORNERS.map(|[s, t]| source.shape.place_towards(middle, s, t));
    let places: Vec<Point3<f64>> = ends.into_iter().chain(panel.corners()).collect();
    all.among(&places)
}

/// The cells around the light-map nodes of a flat face, over each of which shadows are averaged.
struct Cells<'a> {
    panel: &'a Panel,
    normal: Vector3<f64>,
    /// Distances between nodes, as shares of the face's sides.
    step: [f64; 2],
}

impl Cells<'_> {
    /// Whether a node at `shares` of the face's sides is so far from `nearest`, the nearest place within the face's outline, that no such place is
    /// beside it.
    fn is_unseen(&self, shares: [f64; 2], nearest: [f64; 2]) -> bool {
        let away = self.panel.place(shares[0], shares[1]) - self.panel.place(nearest[0], nearest[1]);
        let cell = self.panel.along * self.step[0] + self.panel.up * self.step[1];
        away.norm() > 1.2 * cell.norm()
    }

    /// Share of a lamp that is visible from the cell around a node, weighted by what each point of the lamp contributes.
    ///
    /// Points in the cell are paired with points on the lamp in such a way that the partners of each row, column and diagonal of the one grid are
    /// spread over the whole of the other.
    fn share<'a>(&self, source: &Source, all: &'a Occluders, [s, t]: [f64; 2], between: &mut Between<'a>) -> f64 {
        const N: usize = SUB_PLACES;
        // What a point is moved by, off its surface and away from the face's edges.
        const SLACK_M: f64 = 0.01;
        let (panel, normal, step) = (self.panel, self.normal, self.step);
        let lamp = source.shape.place(0.0, 0.0);
        let cell_m = 0.5 * (panel.along * step[0] + panel.up * step[1]).norm();
        let lamp_m = source.shape.reach_m();
        all.between_balls([panel.place(s, t), lamp], [cell_m + SLACK_M, lamp_m + SLACK_M], between);
        if between.is_empty() {
            return 1.0;
        }
        let hair = hair(panel);
        let at = |i: f64, j: f64| {
            let s = (s + step[0] * i).clamp(hair[0], 1.0 - hair[0]);
            let t = (t + step[1] * j).clamp(hair[1], 1.0 - hair[1]);
            panel.place(s, t) + normal * 0.001
        };
        let cell = CORNERS.map(|[i, j]| at(0.5 * i, 0.5 * j));
        if between.hide(&cell, &CORNERS.map(|[u, v]| source.shape.place_towards(panel.place(s, t), u, v))) {
            return 0.0;
        }
        let axis = source.shape.normal();
        let within = |index: usize| (index as f64 + 0.5) / N as f64 - 0.5;
        let (mut seen, mut total) = (0.0, 0.0);
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let at = at(within(i), within(j));
            // A point inside a piece of furniture is skipped: the furniture hides it, and it must neither brighten nor darken the floor beside. So
            // is a point beyond the face's outline.
            if between.contain(at) || !panel.has([s + step[0] * within(i), t + step[1] * within(j)]) {
                continue;
            }
            let on_lamp = |place: usize| (place % N) as f64 * 2.0 / N as f64 + 1.0 / N as f64 - 1.0;
            let [u, v] = [on_lamp(2 * i + j), on_lamp(i + 2 * j + 1)];
            let to = match source.shape {
                Shape::Rectangle { .. } => source.shape.place(u, v),
                Shape::Point { .. } => {
                    let [u, v] = on_disc([u, v]);
                    source.shape.place_towards(at, u, v)
                }
            };
            let weight = weight(axis, at, to, normal);
            total += weight;
            if weight > 0.0 && !between.block(at, to) {
                seen += weight;
            }
        }
        if total > 0.0 { seen / total } else { 0.0 }
    }
}

/// The point of the unit disc for a point of the square from −1 to 1, so that equal areas stay equal (Shirley and Chiu, A Low Distortion Map Between
/// Disk and Square, 1997).
fn on_disc([u, v]: [f64; 2]) -> [f64; 2] {
    let (radius, angle_rad) = match (u.abs() > v.abs(), v == 0.0) {
        (true, _) => (u, FRAC_PI_4 * v / u),
        (false, false) => (v, FRAC_PI_2 - FRAC_PI_4 * u / v),
        (false, true) => (0.0, 0.0),
    };
    [radius * angle_rad.cos(), radius * angle_rad.sin()]
}

/// Mean illuminance over the points of a reflector that nothing covers, given its face's rectangle of the light map and the light at its nodes.
fn mean_at(reflector: &Reflector, patch: Patch, nodes: &[Illuminance]) -> Illuminance {
    let mut sum = Illuminance::default();
    for shares in &reflector.shares {
        for ([i, j], weight) in patch.around(*shares) {
            sum = sum.plus(weight, nodes[j * patch.count[0] + i]);
        }
    }
    sum.times(1.0 / reflector.shares.len() as f64)
}

/// Mean illuminance over the area of the panels (flat faces) that `wanted` selects, by the trapezoidal rule.
fn mean_over(work: &[(&Panel, Patch)], nodes: &[Vec<Illuminance>], wanted: impl Fn(&Panel) -> bool) -> Illuminance {
    let (mut sum, mut area_m2) = (Illuminance::default(), 0.0);
    for ((panel, patch), nodes) in work.iter().zip(nodes).filter(|((panel, _), _)| wanted(panel)) {
        let [columns, rows] = patch.count;
        let end = |index: usize, count: usize| if index == 0 || index + 1 == count { 0.5 } else { 1.0 };
        let cell_m2 = panel.area_m2() / ((columns - 1) * (rows - 1)) as f64;
        for (index, light) in nodes.iter().enumerate() {
            sum = sum.plus(cell_m2 * end(index % columns, columns) * end(index / columns, rows), *light);
        }
        area_m2 += panel.area_m2();
    }
    if area_m2 > 0.0 { sum.times(1.0 / area_m2) } else { sum }
}
