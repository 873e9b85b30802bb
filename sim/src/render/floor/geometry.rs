//! The part of the floor that a picture shows, as tile faces and flat bands in the picture's local frame.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use nalgebra::{Isometry3, Vector2, vector};

use super::local::LocalFrame;
use crate::{
    place::{
        building::{GroundPlan, covering_albedo},
        drawn::LaidTiles,
    },
    scene::{Region, Stray, Tiles},
};

/// Albedo of a floor without tiles: grey screed.
const PLAIN_ALBEDO: f32 = 0.4;
/// Albedo of what lies beyond the walls' feet: a dark skirting board, lit like the floor.
const WALL_ALBEDO: f32 = 0.1;
/// Greatest width of a stray line on the floor that counts as a wire, which stands up from the floor and shades it; a wider one is a flat
/// tape.
const WIDEST_WIRE_M: f64 = 0.012;
/// Share of the light that a wire takes away just beside it; a wire hides about this much of a room's ceiling.
const WIRE_SHADE: f32 = 0.15;
/// Distance from a wire's middle, in widths of the wire, at which the bell-shaped shade has fallen below a thousandth of its height.
const SHADE_REACH_WIDTHS: f64 = 2.7;

/// Device layout of `Tile` of tile.wgsl: the face of one tile.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct TileInstance {
    corners: [[f32; 2]; 4],
    anchor: [f32; 2],
    albedo: f32,
    seed: u32,
    /// 1 for a tile whose corners are visible; 0 for a face so large that its corners are never in view.
    ends: u32,
}

/// Device layout of `Band` of band.wgsl, a flat band over the floor: a joint, a stray wire or tape, a covering or a wall.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct BandInstance {
    middle: [f32; 2],
    direction: [f32; 2],
    half_length_m: f32,
    half_width_m: f32,
    margin_m: [f32; 2],
    albedo: f32,
    contrast: [f32; 3],
    step: f32,
    shade: f32,
    capped: f32,
}

/// Rectangle in the local frame that bounds the part of the floor that a picture shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    pub(super) low: Vector2<f64>,
    pub(super) high: Vector2<f64>,
    /// Extent of an image pixel on the floor.
    pub(super) pixel_m: f64,
    /// Greatest motion of an image pixel over the floor from the middle of the exposure to any other time of it, along x and y of the local
    /// frame.
    pub(super) motion_m: Vector2<f64>,
}

impl Footprint {
    /// Extent plus motion of an image pixel on the floor, across a flat band (a joint, wire or wall) of the given direction.
    fn margin_m(&self, direction: Vector2<f64>) -> f64 {
        self.pixel_m + self.motion_m.x * direction.y.abs() + self.motion_m.y * direction.x.abs()
    }

    /// Extent plus motion of an image pixel on the floor, in whatever direction it is greatest.
    fn widest_margin_m(&self) -> f64 {
        self.pixel_m + self.motion_m.norm()
    }
}

impl BandInstance {
    /// A flat band over the floor from one point to another, which ends at both points and has full contrast all along.
    fn between(from: Vector2<f64>, to: Vector2<f64>, width_m: f64, margin_m: [f64; 2]) -> Self {
        let reach = to - from;
        let direction = reach.try_normalize(0.0).unwrap_or(Vector2::x());
        BandInstance {
            middle: single((from + to) / 2.0),
            direction: single(direction),
            half_length_m: (reach.norm() / 2.0) as f32,
            half_width_m: (width_m / 2.0) as f32,
            margin_m: margin_m.map(|margin| margin as f32),
            albedo: 0.0,
            contrast: [1.0; 3],
            step: 0.0,
            shade: 0.0,
            capped: 1.0,
        }
    }
}

/// A single flat face that covers all of the floor that the camera sees at any time of its exposure.
pub(super) fn plain_face(seen: &Footprint) -> TileInstance {
    let (low, high) = (seen.low - seen.motion_m, seen.high + seen.motion_m);
    TileInstance {
        corners: [low, vector![high.x, low.y], vector![low.x, high.y], high].map(single),
        anchor: [0.0; 2],
        albedo: PLAIN_ALBEDO,
        seed: 0,
        ends: 0,
    }
}

/// The tiles as they were truly laid, with their corners counted from the origin of a picture's local frame.
struct TileWindow<'a> {
    tiles: &'a Tiles,
    laid: &'a LaidTiles,
    /// Indices of the tile corner whose nominal place is the origin of the local frame.
    origin: [i32; 2],
}

/// Faces and joints of the tiles in view.
pub(super) fn tiles_in_view(
    tiles: &Tiles,
    laid: &LaidTiles,
    frame: &LocalFrame,
    seen: &Footprint,
) -> (Vec<TileInstance>, Vec<BandInstance>) {
    let origin = [0, 1].map(|axis| frame.corner[axis] - laid.first[axis]);
    let window = TileWindow { tiles, laid, origin };
    let [columns, rows] = window.in_view(seen);
    let places = || columns.clone().flat_map(|i| rows.clone().map(move |j| [i, j]));
    let faces = places().map(|place| window.face(place)).collect();
    let joints = places().flat_map(|place| [0, 1].map(|axis| window.joint(axis, place, seen))).collect();
    (faces, joints)
}

impl TileWindow<'_> {
    /// Range of tiles in view along each axis, with one more on each side because corners may be displaced.
    fn in_view(&self, seen: &Footprint) -> [Range<usize>; 2] {
        let edge_m = [self.tiles.edge_x_m, self.tiles.edge_y_m];
        [0, 1].map(|axis| {
            let last = self.laid.count[axis] as i32 - 1;
            let low = self.origin[axis] + (seen.low[axis] / edge_m[axis]).floor() as i32 - 1;
            let high = self.origin[axis] + (seen.high[axis] / edge_m[axis]).ceil() as i32 + 1;
            low.clamp(0, last) as usize..high.clamp(0, last) as usize
        })
    }

    fn index(&self, [i, j]: [usize; 2]) -> usize {
        i * self.laid.count[1] + j
    }

    fn nominal_corner(&self, [i, j]: [usize; 2]) -> Vector2<f64> {
        let tiles_away = vector![(i as i32 - self.origin[0]) as f64, (j as i32 - self.origin[1]) as f64];
        tiles_away.component_mul(&vector![self.tiles.edge_x_m, self.tiles.edge_y_m])
    }

    fn corner(&self, place: [usize; 2]) -> Vector2<f64> {
        self.nominal_corner(place) + Vector2::from(self.laid.corner_offset_m[self.index(place)])
    }

    /// The flat face of the tile whose corner with the least indices is `(i, j)`.
    fn face(&self, [i, j]: [usize; 2]) -> TileInstance {
        TileInstance {
            corners: [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]].map(|place| single(self.corner(place))),
            anchor: single(self.nominal_corner([i, j])),
            albedo: self.laid.tile_albedo[self.index([i, j])],
            seed: tile_seed(self.laid.pattern_seed, i, j),
            ends: 1,
        }
    }

    /// The joint segment from corner `(i, j)` to the next one, of the family at constant grid x (axis 0) or grid y (axis 1).
    fn joint(&self, axis: usize, place: [usize; 2], seen: &Footprint) -> BandInstance {
        let contrast_at = |place| self.laid.contrast[axis][self.index(place)];
        let contrast = contrast_at(place);
        let before = stepped(place, 1 - axis, -1).map(contrast_at);
        let next = stepped(place, 1 - axis, 1).filter(|next| next[1 - axis] < self.laid.count[1 - axis]);
        let (from, to) = (self.corner(place), next.map_or(self.corner(place), |next| self.corner(next)));

        let albedo = self.laid.tile_albedo[self.index(place)];
        let across = stepped(place, axis, -1).map_or(albedo, |other| self.laid.tile_albedo[self.index(other)]);
        // Along a joint in the direction of grid y, the tile at (i, j) is on the right; along grid x it is on the left.
        let step = if axis == 0 { across - albedo } else { albedo - across };
        let direction = (to - from).try_normalize(0.0).unwrap_or(Vector2::x());
        BandInstance {
            albedo: self.tiles.joint_albedo as f32,
            contrast: [faded(contrast, before), contrast, faded(contrast, next.map(contrast_at))],
            step,
            capped: 0.0,
            ..BandInstance::between(from, to, self.tiles.joint_width_m, [seen.margin_m(direction), 0.0])
        }
    }
}

/// Carpets and other coverings in view, as flat bands over the floor.
pub(super) fn coverings_in_view<'a>(
    regions: &'a [Region],
    frame: &'a LocalFrame,
    seen: &'a Footprint,
) -> impl Iterator<Item = BandInstance> + 'a {
    regions.iter().filter_map(|region| {
        let albedo = covering_albedo(region.covering?);
        let middle_y_m = (region.y_m[0] + region.y_m[1]) / 2.0;
        let [from, to] = region.x_m.map(|x_m| frame.place(region.in_world([x_m, middle_y_m]).into()));
        let width_m = region.y_m[1] - region.y_m[0];
        let margin_m = seen.widest_margin_m();
        let reach = Vector2::repeat(width_m / 2.0 + margin_m);
        let (low, high) = (from.inf(&to) - reach, from.sup(&to) + reach);
        (low < seen.high && high > seen.low)
            .then(|| BandInstance { albedo: albedo as f32, ..BandInstance::between(from, to, width_m, [margin_m; 2]) })
    })
}

/// Stray wires and tapes in view, as flat bands over the floor.
pub(super) fn strays_in_view<'a>(
    strays: &'a [Stray],
    frame: &'a LocalFrame,
    seen: &'a Footprint,
) -> impl Iterator<Item = BandInstance> + 'a {
    strays.iter().filter_map(|stray| {
        let [from, to] = [stray.from_m, stray.to_m].map(|end| frame.place(Vector2::from(end)));
        let wire = stray.width_m <= WIDEST_WIRE_M;
        let shade_m = if wire { SHADE_REACH_WIDTHS * stray.width_m } else { 0.0 };
        let margin_m = seen.widest_margin_m() + shade_m;
        let reach = Vector2::repeat(stray.width_m + margin_m);
        let (low, high) = (from.inf(&to) - reach, from.sup(&to) + reach);
        let in_view = low < seen.high && high > seen.low;
        in_view.then(|| BandInstance {
            albedo: stray.albedo as f32,
            shade: if wire { WIRE_SHADE } else { 0.0 },
            ..BandInstance::between(from, to, stray.width_m, [margin_m; 2])
        })
    })
}

/// The area beyond the walls, as far as it is in view, as flat bands over the floor.
pub(super) fn walls_in_view<'a>(
    ground_plan: &GroundPlan,
    world_from_camera: &Isometry3<f64>,
    frame: &'a LocalFrame,
    seen: &'a Footprint,
) -> impl Iterator<Item = BandInstance> + 'a {
    let faces = ground_plan.faces_seen_from(world_from_camera.translation.vector.xy().into());
    // Depth of the flat band that stands for the area behind a wall: enough to fill the picture beyond the wall from any place in the room.
    let depth_m = (seen.high - seen.low).norm() + 1.0;
    faces.into_iter().filter_map(move |face| {
        let [from, to] = face.ends_m.map(|end| frame.place(end));
        let along = (to - from).normalize();
        let outward = vector![along.y, -along.x];
        // Distance from the wall to the outermost corner of the visible part of the floor, if that corner is beyond the wall.
        let farthest_m = (0..4)
            .map(|k| {
                let x = if k & 1 == 0 { seen.low.x } else { seen.high.x };
                let y = if k & 2 == 0 { seen.low.y } else { seen.high.y };
                (vector![x, y] - from).dot(&outward)
            })
            .fold(f64::MIN, f64::max);
        // The middle of the band that stands for the area behind a wall is put beside the camera, so that its coordinates are small. Where the wall
        // ends in an open door, so does the band.
        let beside = from + along * (-from).dot(&along) + outward * (depth_m / 2.0);
        let reach_m = [(from - beside).dot(&along), (to - beside).dot(&along)];
        let ends_m = [(reach_m[0] - face.goes_on_m[0]).max(-depth_m), (reach_m[1] + face.goes_on_m[1]).min(depth_m)];
        let margin_m = seen.widest_margin_m();
        (farthest_m + margin_m > 0.0 && ends_m[0] < ends_m[1]).then(|| BandInstance {
            albedo: WALL_ALBEDO,
            ..BandInstance::between(beside + along * ends_m[0], beside + along * ends_m[1], depth_m, [margin_m; 2])
        })
    })
}

/// The indices of the tile corner that is `step` corners away along a grid axis; `None` if an index would be below 0.
fn stepped(place: [usize; 2], axis: usize, step: isize) -> Option<[usize; 2]> {
    let mut next = place;
    next[axis] = next[axis].checked_add_signed(step)?;
    Some(next)
}

/// Contrast of a joint at the corner between two segments: their mean, unless one of them is missing.
fn faded(own: f32, neighbour: Option<f32>) -> f32 {
    match neighbour {
        Some(other) if own > 0.0 && other > 0.0 => (own + other) / 2.0,
        _ => own,
    }
}

/// Seed for the pattern of tile `(i, j)`: the finaliser of MurmurHash3 over the indices.
fn tile_seed(floor_seed: u32, i: usize, j: usize) -> u32 {
    let mut hash = floor_seed ^ (i as u32).wrapping_mul(0x9e37_79b1) ^ (j as u32).wrapping_mul(0x85eb_ca77);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

fn single(vector: Vector2<f64>) -> [f32; 2] {
    [vector.x as f32, vector.y as f32]
}
