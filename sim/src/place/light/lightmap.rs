//! Light maps: illuminance at a grid of points (nodes) on every flat face of a building, computed once.

use nalgebra::Point3;

use super::{Bounce, Illuminance, Lighting, RoomLight, Source, source::Shape};
use crate::{
    place::building::{Building, Panel, Part},
    scene::Scene,
};

/// Wanted distance between the nodes of the light map (points with a computed illuminance): on floors, and on all other faces of the building.
const NODE_DISTANCE_M: [f64; 2] = [0.05, 0.08];
/// Greatest number of nodes (points with a computed illuminance) of a light map; more would take seconds to compute. In a large hall the nodes
/// are farther apart.
const MAX_NODES: f64 = 90_000.0;
/// Number of nodes (points with a computed illuminance) in a row of the light map; no flat face of the building has more nodes in a row.
const WIDTH: usize = 1024;
/// Number of points along each side of a cell around a node of the light map, over which shadows are averaged. Each of these points is paired
/// with a different point on the lamp. The number must not be a multiple of 3, or points of the lamp would be left out.
const SUB_PLACES: usize = 7;
/// Distance within which furniture reduces the reflected light in the corners that it forms with other surfaces.
const CORNER_REACH_M: f64 = 1.0;

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

/// The rectangle of a light map that holds the nodes (points with a computed illuminance) of one flat face of the building. The first node is at
/// the face's first corner, the last at the opposite corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Column and row of the light map in which the first node of a flat face stands.
    pub first: [usize; 2],
    /// Numbers of light-map nodes (points with a computed illuminance) along both sides of a flat face, at least two each.
    pub count: [usize; 2],
}

impl LightMap {
    /// Illuminance in one band (visible or infrared) at a point of a flat face, the shares `s` and `t` of the face's sides from 0 to 1; bilinear
    /// between the nodes of the light map.
    pub fn at(&self, panel: usize, s: f64, t: f64, band: usize) -> f64 {
        let patch = self.patches[panel];
        let split = |share: f64, count: usize| {
            let place = share.clamp(0.0, 1.0) * (count - 1) as f64;
            let low = (place as usize).min(count - 2);
            (low, place - low as f64)
        };
        let ((i, a), (j, b)) = (split(s, patch.count[0]), split(t, patch.count[1]));
        let node =
            |i: usize, j: usize| f64::from(self.nodes[(patch.first[1] + j) * self.size[0] + patch.first[0] + i][band]);
        let row = |j: usize| node(i, j) * (1.0 - a) + node(i + 1, j) * a;
        row(j) * (1.0 - b) + row(j + 1) * b
    }
}

/// Computes all light in a building: the reflected light, the factor on all lamps, and the light map (illuminance over all faces of the
/// building).
pub fn bake(scene: &Scene, building: &Building) -> (Lighting, LightMap) {
    let mut lighting = Lighting::direct(scene, building);
    let (size, patches) = layout(building);
    let work: Vec<(&Panel, Patch)> = building.panels.iter().zip(patches.iter().copied()).collect();
    let direct = in_parallel(&work, |(panel, patch)| direct_nodes(&lighting, panel, *patch));
    lighting.bounces = bounces(building, &work, &direct);
    let lit: Vec<(&Panel, Patch, &Vec<Illuminance>)> =
        work.iter().zip(&direct).map(|((panel, patch), nodes)| (*panel, *patch, nodes)).collect();
    let total = in_parallel(&lit, |(panel, patch, nodes)| with_bounces(&lighting, panel, *patch, nodes));

    let mut map = LightMap {
        size,
        nodes: vec![[0.0; 2]; size[0] * size[1]],
        mean_at_floor: mean_over(&work, &total, |panel| panel.part == Part::Floor && panel.room == 0),
        patches: patches.clone(),
    };
    for (patch, nodes) in map.patches.iter().zip(&total) {
        for (index, light) in nodes.iter().enumerate() {
            let (i, j) = (index % patch.count[0], index / patch.count[0]);
            map.nodes[(patch.first[1] + j) * size[0] + patch.first[0] + i] = light.by_band.map(|lux| lux as f32);
        }
    }
    lighting.dimming = dimming(scene, building, &lighting, map.mean_at_floor.lux);
    (lighting, map)
}

/// The factor on all lamps that yields the illuminance which the scene states at the camera or on the floor; 1 if the scene states how strong
/// each lamp is.
fn dimming(scene: &Scene, building: &Building, lighting: &Lighting, mean_at_floor_lux: f64) -> f64 {
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
    let stated = !scene.lamps.is_empty()
        && scene.lamps.iter().all(|lamp| lamp.lumens.is_some() || lamp.illuminance_at_floor_lux.is_some());
    if stated { 1.0 } else { ratio(scene.light.illuminance_at_floor_lux, mean_at_floor_lux) }
}

/// Gives each flat face of the building a rectangle of the light map for its nodes. The rectangles are packed in rows, from the tallest to the
/// lowest.
fn layout(building: &Building) -> ([usize; 2], Vec<Patch>) {
    let wanted_m = |panel: &Panel| NODE_DISTANCE_M[usize::from(panel.part != Part::Floor)];
    let wanted: f64 = building.panels.iter().map(|panel| panel.area_m2() / wanted_m(panel).powi(2)).sum();
    let stretch = (wanted / MAX_NODES).sqrt().max(1.0);
    let counts: Vec<[usize; 2]> = building
        .panels
        .iter()
        .map(|panel| {
            let distance_m = wanted_m(panel) * stretch;
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

/// Direct light, shadows included, at every light-map node of a flat face.
fn direct_nodes(lighting: &Lighting, panel: &Panel, patch: Patch) -> Vec<Illuminance> {
    let shadowing: Vec<_> =
        lighting.sources.iter().map(|source| (source, in_the_way(lighting, source, panel))).collect();
    nodes_of(patch)
        .map(|[s, t]| {
            let mut sum = Illuminance::default();
            for (source, occluders) in &shadowing {
                let unshadowed = source.illuminance(panel.place(s, t), panel.normal());
                if unshadowed > 0.0 {
                    let share =
                        if occluders.is_empty() { 1.0 } else { cell_share(source, occluders, panel, patch, [s, t]) };
                    sum.add(unshadowed * share, source.photons);
                }
            }
            sum
        })
        .collect()
}

/// The furniture and walls that may stand between a lamp and a flat face of the building.
fn in_the_way(lighting: &Lighting, source: &Source, panel: &Panel) -> super::Occluders {
    let ends = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[s, t]| source.shape.place(s, t));
    let places: Vec<Point3<f64>> = ends.into_iter().chain(panel.corners()).collect();
    lighting.occluders.among(&places)
}

/// Share of a lamp that is visible from the cell around a node of the light map, weighted by what each point of the lamp contributes.
///
/// Points in the cell are paired with points on the lamp in such a way that the partners of each row, column and diagonal of the one grid are
/// spread over the whole of the other.
fn cell_share(source: &Source, occluders: &super::Occluders, panel: &Panel, patch: Patch, [s, t]: [f64; 2]) -> f64 {
    const N: usize = SUB_PLACES;
    let normal = panel.normal();
    let step = patch.count.map(|count| 1.0 / (count - 1) as f64);
    let within = |index: usize| (index as f64 + 0.5) / N as f64 - 0.5;
    let (mut seen, mut total) = (0.0, 0.0);
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let [s, t] = inside(panel, [s + step[0] * within(i), t + step[1] * within(j)]);
        let at = panel.place(s, t) + normal * 0.001;
        // A point inside a piece of furniture is skipped: the furniture hides it, and it must neither brighten nor darken the floor beside.
        if occluders.contain(at) {
            continue;
        }
        let [u, v] = [2 * i + j, i + 2 * j + 1].map(|place| (place % N) as f64 * 2.0 / N as f64 + 1.0 / N as f64 - 1.0);
        let to = if let Shape::Point { at, .. } = source.shape { at } else { source.shape.place(u, v) };
        let weight = super::occlusion::weight(source, at, to, normal);
        total += weight;
        if weight > 0.0 && !occluders.block(at, to) {
            seen += weight;
        }
    }
    if total > 0.0 { seen / total } else { 0.0 }
}

/// Adds the reflected light to the direct light at the light-map nodes of a flat face. Near furniture, which hides a part of the room from the
/// face, less is added.
fn with_bounces(lighting: &Lighting, panel: &Panel, patch: Patch, direct: &[Illuminance]) -> Vec<Illuminance> {
    let normal = panel.normal();
    nodes_of(patch)
        .zip(direct)
        .map(|([s, t], light)| {
            let [s_inside, t_inside] = inside(panel, [s, t]);
            let bounced = lighting.bounced(panel.place(s_inside, t_inside), normal, panel.room);
            light.plus(lighting.occluders.open_share(panel.place(s, t), normal, CORNER_REACH_M), bounced)
        })
        .collect()
}

/// Moves a point of a flat face away from the face's edge by a hair. The edge lies in the planes of the neighbouring faces, where it is undefined
/// whether they hide it.
fn inside(panel: &Panel, shares: [f64; 2]) -> [f64; 2] {
    const HAIR_M: f64 = 0.002;
    let size_m = panel.size_m();
    [0, 1].map(|axis| {
        let hair = (HAIR_M / size_m[axis]).min(0.5);
        shares[axis].clamp(hair, 1.0 - hair)
    })
}

fn bounces(building: &Building, work: &[(&Panel, Patch)], direct: &[Vec<Illuminance>]) -> Vec<Bounce> {
    const PARTS: [Part; 3] = [Part::Floor, Part::Wall, Part::Ceiling];
    let of_room = |room: usize| {
        let direct = PARTS.map(|part| mean_over(work, direct, |panel| panel.room == room && panel.part == part));
        let albedo = PARTS.map(|part| {
            let panels = || building.panels.iter().filter(move |panel| panel.room == room && panel.part == part);
            let area_m2: f64 = panels().map(Panel::area_m2).sum();
            [0, 1].map(|band| {
                panels().map(|panel| panel.area_m2() * panel.material.albedo[band]).sum::<f64>() / area_m2.max(1e-9)
            })
        });
        RoomLight { direct, albedo }
    };
    let light: Vec<RoomLight> = (0..building.rooms.len()).map(of_room).collect();
    Bounce::in_rooms(&building.rooms, &light, &building.openings)
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

/// Positions of the light-map nodes of a flat face, as shares of the face's sides, row by row.
pub(super) fn nodes_of(patch: Patch) -> impl Iterator<Item = [f64; 2]> {
    let share = |index: usize, count: usize| index as f64 / (count - 1) as f64;
    (0..patch.count[1])
        .flat_map(move |j| (0..patch.count[0]).map(move |i| [share(i, patch.count[0]), share(j, patch.count[1])]))
}

/// Applies `work` to every item, on as many threads as there are cores, and returns the results in the order of the items.
fn in_parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(items.len().max(1));
    let next = std::sync::atomic::AtomicUsize::new(0);
    let take = || next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let one = || {
        let indices = std::iter::from_fn(|| Some(take())).take_while(|index| *index < items.len());
        indices.map(|index| (index, work(&items[index]))).collect::<Vec<_>>()
    };
    let mut done: Vec<(usize, R)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        handles
            .into_iter()
            .flat_map(|handle| handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
