//! Panels (flat faces), lamps and discs (retro-reflective dots and bulbs) of a building in the form in which the graphics device reads them.

use std::{collections::BTreeMap, ops::Range};

use bytemuck::{Pod, Zeroable};
use nalgebra::{Point3, Vector3};

use super::{
    glints::GlossyCell,
    parts::{NodeOnDevice, Parts, Rectangle},
    pipelines::Kind,
};
use crate::{
    place::{
        building::{Building, Panel},
        light::{Lighting, Patch, Shadows, Shape, Source},
    },
    scene::Pattern,
};

/// Greatest length of the cells into which faces of the building are cut. Within a cell, the row at which a rolling shutter sees a point is
/// interpolated linearly. Before a wall at half a metre, a turn of the camera by 12 px during readout is then drawn accurately to 0.1 px.
const CELL_M: f64 = 0.1;
/// Greatest number of cells along a side of a flat face of the building, however long the side is.
const MOST_CELLS: f64 = 128.0;
/// Number of cells along each side of a block, which is the part of a panel (flat face) for which the lamps reflected in it are determined
/// together.
const BLOCK_CELLS: u32 = 5;
/// Albedo of a lamp's diffuser, as in lamp.wgsl.
const DIFFUSER_ALBEDO: f64 = 0.7;
/// Albedo of a retro-reflective dot in light that does not come from the camera.
const DOT_ALBEDO: f32 = 0.3;

/// Device layout of `Surface` of world.wgsl: one flat face (panel) of the building.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct SurfaceOnDevice {
    corner: [f32; 4],
    along: [f32; 4],
    up: [f32; 4],
    nodes: [f32; 4],
    size: [f32; 4],
}

/// Device layout of `Lamp` of world.wgsl: one lamp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct LampOnDevice {
    centre: [f32; 4],
    side_u: [f32; 4],
    side_v: [f32; 4],
    normal: [f32; 4],
}

/// Device layout of `Disc` of disc.wgsl: a retro-reflective dot or a bulb.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct DiscOnDevice {
    centre: [f32; 3],
    radius_m: f32,
    retroreflection: f32,
    matt: f32,
}

/// Device layout of `Grid` of world.wgsl: the floor's tile grid.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct GridOnDevice {
    turn: [f32; 2],
    edge_m: [f32; 2],
    phase_m: [f32; 2],
    joint_width_m: f32,
    joint_albedo: f32,
    first: [i32; 2],
    count: [i32; 2],
    pattern_contrast: f32,
    mean_albedo: f32,
    padding: [u32; 2],
}

/// All flat faces (panels) of a building in the device's form, with their albedo in one band (visible or infrared).
pub(super) fn surfaces(building: &Building, patches: &[Patch], shadows: &Shadows, band: usize) -> Vec<SurfaceOnDevice> {
    let with = |vector: Vector3<f64>, fourth: f64| [vector.x as f32, vector.y as f32, vector.z as f32, fourth as f32];
    let surface = |((panel, patch), sunlight): ((&Panel, &Patch), &u32)| {
        let [along_m, up_m] = panel.size_m();
        SurfaceOnDevice {
            corner: with(panel.corner.coords, panel.material.albedo[band]),
            along: with(panel.along, panel.material.mirrored),
            up: with(panel.up, panel.material.roughness_rad),
            nodes: [patch.first[0], patch.first[1], patch.count[0] - 1, patch.count[1] - 1].map(|number| number as f32),
            size: [along_m as f32, up_m as f32, panel.material.seed as f32, *sunlight as f32],
        }
    };
    building.panels.iter().zip(patches).zip(&shadows.faces).map(surface).collect()
}

/// All flat faces (panels) of a building cut into blocks, and the blocks into cells.
#[derive(Debug)]
pub(super) struct Cells {
    /// The building's flat faces, grouped by the kind of surface.
    by_kind: Vec<(Kind, Vec<Face>)>,
}

/// A flat face (panel) of the building as triangles, both as a whole and cut into blocks.
#[derive(Debug)]
struct Face {
    panel: usize,
    whole: Vec<Rectangle>,
    blocks: Vec<Block>,
}

/// A block of a flat face of the building as triangles, both as a whole and cut into cells.
#[derive(Debug)]
struct Block {
    whole: Vec<Rectangle>,
    cells: Vec<Rectangle>,
    /// What is needed to determine which lamps are seen reflected in this block of a flat face; `None` if the face does not mirror.
    glossy: Option<GlossyCell>,
}

/// Indices of the vertices of the faces to draw, three to a triangle, and the runs into which they are divided.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    pub(super) indices: Vec<u32>,
    pub(super) runs: Vec<Run>,
}

/// A run of triangles that are drawn with one kind of surface.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) kind: Kind,
    /// Range of the lamps that may be seen reflected in these triangles.
    pub(super) lamps: Range<u32>,
    /// Range of the run within the list of vertex indices.
    pub(super) indices: Range<u32>,
}

impl Cells {
    /// Lists the triangles of all flat faces but those marked in `hidden`, for cameras at the given points; a reflected lamp is searched for only
    /// where it may be visible. Faces are cut only where they must be, for the rows of a rolling shutter or for lamps: along an edge that two
    /// triangles share, a driver shades the pixels twice.
    pub(super) fn seen_from(
        &self,
        eyes: &[Point3<f64>],
        lighting: &Lighting,
        hidden: &[bool],
        rolling: bool,
    ) -> Drawing {
        let sources: Vec<&Source> = in_order(lighting).collect();
        let lamps_in = |cell: &GlossyCell| {
            let shows = |lamp: &u32| eyes.iter().any(|eye| cell.shows(*eye, &sources[*lamp as usize].shape));
            let first = cell.lamps.iter().copied().find(shows);
            let last = cell.lamps.iter().rev().copied().find(shows);
            first.zip(last).map_or(0..0, |(first, last)| first..last + 1)
        };
        let mut drawing = Drawing::default();
        for (kind, faces) in &self.by_kind {
            let mut by_lamps: BTreeMap<[u32; 2], Vec<Rectangle>> = BTreeMap::new();
            for face in faces.iter().filter(|face| !hidden[face.panel]) {
                let lamps: Vec<Range<u32>> =
                    face.blocks.iter().map(|block| block.glossy.as_ref().map_or(0..0, lamps_in)).collect();
                if !rolling && lamps.iter().all(Range::is_empty) {
                    by_lamps.entry([0, 0]).or_default().extend(&face.whole);
                    continue;
                }
                for (block, lamps) in face.blocks.iter().zip(lamps) {
                    let pieces = if rolling { &block.cells } else { &block.whole };
                    by_lamps.entry([lamps.start, lamps.end]).or_default().extend(pieces);
                }
            }
            for ([first, end], rectangles) in by_lamps {
                let start = drawing.indices.len() as u32;
                drawing.indices.extend(rectangles.into_iter().flatten());
                let kind = if first == end { kind.without_glints() } else { *kind };
                let indices = start..drawing.indices.len() as u32;
                drawing.runs.push(Run { kind, lamps: first..end, indices });
            }
        }
        drawing
    }
}

/// Number of cells into which a side, of the given length, of a flat face is cut.
pub(super) fn cells_along(side_m: f64) -> u32 {
    (side_m / CELL_M).ceil().clamp(1.0, MOST_CELLS) as u32
}

/// Cuts the flat faces of a building into cells, and makes the vertices at the cells' corners.
pub(super) fn cells(building: &Building, lighting: &Lighting) -> (Vec<NodeOnDevice>, Cells) {
    let (mut nodes, mut by_kind) = (Vec::new(), Vec::new());
    let kind_of = |index: usize| Kind::of(&building.panels[index].material);
    let mut order: Vec<usize> = (0..building.panels.len()).collect();
    order.sort_by_key(|index| kind_of(*index));
    for group in order.chunk_by(|one, other| kind_of(*one) == kind_of(*other)) {
        let faces = group.iter().map(|panel| face_of(building, lighting, *panel, &mut nodes)).collect();
        by_kind.push((kind_of(group[0]), faces));
    }
    (nodes, Cells { by_kind })
}

/// The triangles of one flat face (panel); its vertices are appended to `nodes`.
fn face_of(building: &Building, lighting: &Lighting, panel_index: usize, nodes: &mut Vec<NodeOnDevice>) -> Face {
    let panel = &building.panels[panel_index];
    let [columns, rows] = panel.size_m().map(cells_along);
    let mut parts = Parts::new(panel_index, panel, [columns, rows], nodes);
    let glossy = |[i, j]: [u32; 2], [right, top]: [u32; 2]| {
        let place = |i: u32, j: u32| {
            panel.corner
                + panel.along * (f64::from(i) / f64::from(columns))
                + panel.up * (f64::from(j) / f64::from(rows))
        };
        let corners = [place(i, j), place(right, j), place(right, top), place(i, top)];
        let mut cell = GlossyCell {
            corners,
            normal: panel.along.cross(&panel.up).normalize(),
            roughness_rad: panel.material.roughness_rad,
            lamps: Vec::new(),
        };
        // From a corner beyond the face's outline, which may be behind a wall, nothing can be told of what the face shows.
        let has = |i: u32, j: u32| panel.has([f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows)]);
        let is_whole = has(i, j) && has(right, j) && has(right, top) && has(i, top);
        let sees = |lamp: &Source| !is_whole || cell.sees(&lamp.shape, &lighting.occluders);
        let seen = (0_u32..).zip(in_order(lighting)).filter(|(_, lamp)| sees(lamp));
        cell.lamps = seen.map(|(index, _)| index).collect();
        cell
    };
    let along =
        |from: u32, to: u32, step: u32| (from..to).step_by(step as usize).map(move |low| [low, (low + step).min(to)]);
    let is_glossy = Kind::of(&panel.material).gloss();
    let mut block = |[i, right]: [u32; 2], [j, top]: [u32; 2]| Block {
        whole: parts.between([i, j], [right, top]),
        cells: along(j, top, 1)
            .flat_map(|[j, top]| along(i, right, 1).map(move |[i, right]| ([i, j], [right, top])))
            .flat_map(|(low, high)| parts.between(low, high))
            .collect(),
        glossy: is_glossy.then(|| glossy([i, j], [right, top])),
    };
    let blocks = along(0, rows, BLOCK_CELLS)
        .flat_map(|upwards| along(0, columns, BLOCK_CELLS).map(move |sideways| (sideways, upwards)))
        .map(|(sideways, upwards)| block(sideways, upwards))
        .collect();
    Face { panel: panel_index, whole: parts.whole(), blocks }
}

/// Lamps with their luminance in one band (visible or infrared), in their order on the device. The luminance includes the room's light that the
/// lamp's diffuser reflects.
pub(super) fn lamps(building: &Building, lighting: &Lighting, band: usize) -> Vec<LampOnDevice> {
    let with = |vector: Vector3<f64>, fourth: f64| [vector.x as f32, vector.y as f32, vector.z as f32, fourth as f32];
    let lamp = |source: &Source| {
        let own = source.luminance() * [source.photons.visible, source.photons.infrared][band];
        let thrown = source.shape.normal().map_or(0.0, |normal| {
            let at = source.shape.place(0.0, 0.0) + normal * 0.01;
            let light = lighting.at(at, normal, building.room_at(at), 4).by_band[band];
            DIFFUSER_ALBEDO * light / lighting.dimming.max(1e-30) / std::f64::consts::PI
        });
        let luminance = own + thrown;
        match source.shape {
            Shape::Rectangle { centre, half_u, half_v } => LampOnDevice {
                centre: with(centre.coords, luminance),
                side_u: with(half_u.normalize(), half_u.norm()),
                side_v: with(half_v.normalize(), half_v.norm()),
                normal: with(half_u.cross(&half_v).normalize(), 0.0),
            },
            Shape::Point { at, radius_m } => LampOnDevice {
                centre: with(at.coords, luminance),
                side_u: [0.0; 4],
                side_v: [0.0; 4],
                normal: with(Vector3::zeros(), radius_m),
            },
        }
    };
    in_order(lighting).map(lamp).collect()
}

/// Lamps in their order on the device: rectangles before bulbs.
fn in_order(lighting: &Lighting) -> impl Iterator<Item = &Source> {
    let of_shape = |bulbs: bool| lighting.sources.iter().filter(move |source| source.shape.normal().is_none() == bulbs);
    of_shape(false).chain(of_shape(true))
}

/// Retro-reflective dots, lit by the light at their position, followed by bulbs.
pub(super) fn discs(building: &Building, lighting: &Lighting, band: usize) -> Vec<DiscOnDevice> {
    let single = |at: Point3<f64>| [at.x as f32, at.y as f32, at.z as f32];
    let dots = building.dots.iter().map(|dot| {
        let room = building.room_at(dot.centre);
        let light = lighting.at(dot.centre, -Vector3::z(), room, 4).by_band[band];
        DiscOnDevice {
            centre: single(dot.centre),
            radius_m: dot.radius_m as f32,
            // A retroreflection of exactly 0 would make the shader take the dot for a bulb.
            retroreflection: (dot.retroreflection_cd_per_lux_m2 as f32).max(1e-6),
            matt: light as f32 / lighting.dimming.max(1e-30) as f32 * DOT_ALBEDO,
        }
    });
    let bulbs = lighting.sources.iter().filter_map(|source| match source.shape {
        Shape::Point { at, radius_m } => Some(DiscOnDevice {
            centre: single(at),
            radius_m: radius_m as f32,
            retroreflection: 0.0,
            matt: match source.lumens > 0.0 {
                true => (source.luminance() * [source.photons.visible, source.photons.infrared][band]) as f32,
                false => bulb_off(building, lighting, at, band) as f32,
            },
        }),
        Shape::Rectangle { .. } => None,
    });
    dots.chain(bulbs).collect()
}

/// Luminance of a bulb that is off, before the factor on all light: it reflects the mean of what comes from above and from below.
fn bulb_off(building: &Building, lighting: &Lighting, at: Point3<f64>, band: usize) -> f64 {
    let room = building.room_at(at);
    let light = [Vector3::z(), -Vector3::z()].map(|normal| lighting.bounced(at, normal, room).by_band[band]);
    DIFFUSER_ALBEDO * 0.5 * (light[0] + light[1]) / std::f64::consts::PI
}

/// The grid of the floor's tiles and the albedo of each tile; the edge lengths are 0 if there are no tiles.
pub(super) fn grid(building: &Building) -> (GridOnDevice, Vec<f32>) {
    let Some((tiles, laid)) = &building.tiles else { return (GridOnDevice::zeroed(), vec![1.0]) };
    let (sin, cos) = tiles.rotation_deg.to_radians().sin_cos();
    let plain = matches!(tiles.pattern, Pattern::Plain);
    let grid = GridOnDevice {
        turn: [cos as f32, sin as f32],
        edge_m: [tiles.edge_x_m as f32, tiles.edge_y_m as f32],
        phase_m: [tiles.phase_x_m as f32, tiles.phase_y_m as f32],
        joint_width_m: tiles.joint_width_m as f32,
        joint_albedo: tiles.joint_albedo as f32,
        first: laid.first,
        count: laid.count.map(|count| count as i32),
        pattern_contrast: if plain { 0.0 } else { tiles.pattern_contrast as f32 },
        // Textures are factors on the mean albedo of their surface, so that black tiles stay black.
        mean_albedo: tiles.tile_albedo.max(1e-3) as f32,
        padding: [0; 2],
    };
    (grid, laid.tile_albedo.clone())
}
