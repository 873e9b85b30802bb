//! What of the floor a view sees, as instances of faces and bands in the view's local frame.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Vector2, vector};

use super::local::LocalFrame;
use crate::{
    drawn::LaidTiles,
    scene::{Room, Stray, Tiles},
};

/// Albedo of a floor without tiles: grey screed.
const PLAIN_ALBEDO: f32 = 0.4;
/// Albedo of what lies beyond the walls' feet: a dark skirting, lit like the floor.
const WALL_ALBEDO: f32 = 0.1;
/// A stray up to this wide is a wire that stands up from the floor and shades it; a wider one is a flat tape.
const WIDEST_WIRE_M: f64 = 0.012;
/// Share of the light that a wire takes away just beside it: it hides about this much of a room's ceiling.
const WIRE_SHADE: f32 = 0.15;
/// The shade's bell has fallen below a thousandth of its height this many widths from the wire's middle.
const SHADE_REACH_WIDTHS: f64 = 2.7;

/// `Tile` of tile.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct TileInstance {
    corners: [[f32; 2]; 4],
    anchor: [f32; 2],
    albedo: f32,
    seed: u32,
}

/// `Band` of band.wgsl.
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

/// Part of the floor that a view sees: a rectangle in the local frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    pub(super) low: Vector2<f64>,
    pub(super) high: Vector2<f64>,
    /// How far a pixel reaches over the floor.
    pub(super) pixel_m: f64,
    /// How far a pixel moves over the floor from the middle of the exposure to either end, along x and y.
    pub(super) motion_m: Vector2<f64>,
}

impl Footprint {
    /// How far a pixel reaches and moves across a band of this direction.
    fn margin_m(&self, direction: Vector2<f64>) -> f64 {
        self.pixel_m + self.motion_m.x * direction.y.abs() + self.motion_m.y * direction.x.abs()
    }

    /// How far a pixel reaches and moves in any direction.
    fn widest_margin_m(&self) -> f64 {
        self.pixel_m + self.motion_m.norm()
    }
}

impl BandInstance {
    /// A band of full contrast between two places, capped at both ends.
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

/// One face over the whole view.
pub(super) fn plain_face(seen: &Footprint) -> TileInstance {
    let (low, high) = (seen.low, seen.high);
    TileInstance {
        corners: [low, vector![high.x, low.y], vector![low.x, high.y], high].map(single),
        anchor: [0.0; 2],
        albedo: PLAIN_ALBEDO,
        seed: 0,
    }
}

/// Faces and joints of the tiles in view.
pub(super) fn tiles_in_view(
    tiles: &Tiles,
    laid: &LaidTiles,
    frame: &LocalFrame,
    seen: &Footprint,
) -> (Vec<TileInstance>, Vec<BandInstance>) {
    let edge_m = vector![tiles.edge_x_m, tiles.edge_y_m];
    let origin = [0, 1].map(|axis| frame.corner[axis] - laid.first[axis]);
    // Indices of the joints in view, with one tile more for corners that are displaced.
    let range = |axis: usize| {
        let last = laid.count[axis] as i32 - 1;
        let low = origin[axis] + (seen.low[axis] / edge_m[axis]).floor() as i32 - 1;
        let high = origin[axis] + (seen.high[axis] / edge_m[axis]).ceil() as i32 + 1;
        low.clamp(0, last) as usize..high.clamp(0, last) as usize
    };
    let nominal = |i: usize, j: usize| {
        edge_m.component_mul(&vector![(i as i32 - origin[0]) as f64, (j as i32 - origin[1]) as f64])
    };
    let index = |i: usize, j: usize| i * laid.count[1] + j;
    let corner = |i: usize, j: usize| nominal(i, j) + Vector2::from(laid.corner_offset_m[index(i, j)]);

    let mut faces = Vec::new();
    let mut joints = Vec::new();
    for i in range(0) {
        for j in range(1) {
            faces.push(TileInstance {
                corners: [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)].map(single),
                anchor: single(nominal(i, j)),
                albedo: laid.tile_albedo[index(i, j)],
                seed: tile_seed(laid.pattern_seed, i, j),
            });
            for axis in 0..2 {
                let (next_i, next_j) = if axis == 0 { (i, j + 1) } else { (i + 1, j) };
                let contrast = laid.contrast[axis][index(i, j)];
                let before = neighbour(laid, axis, [i, j], -1);
                let after = neighbour(laid, axis, [i, j], 1);
                // The face at (i, j) is left of a joint along grid x and right of one along grid y.
                let (left, right) = if axis == 0 { (i.checked_sub(1), Some(i)) } else { (Some(j), j.checked_sub(1)) };
                let albedo = |place: Option<usize>| {
                    place.map_or(laid.tile_albedo[index(i, j)], |place| {
                        laid.tile_albedo[if axis == 0 { index(place, j) } else { index(i, place) }]
                    })
                };
                let (from, to) = (corner(i, j), corner(next_i, next_j));
                let margin_m = seen.margin_m((to - from).normalize());
                joints.push(BandInstance {
                    albedo: tiles.joint_albedo as f32,
                    contrast: [faded(contrast, before), contrast, faded(contrast, after)],
                    step: albedo(left) - albedo(right),
                    capped: 0.0,
                    ..BandInstance::between(from, to, tiles.joint_width_m, [margin_m, 0.0])
                });
            }
        }
    }
    (faces, joints)
}

/// Wires and tape in view.
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

/// What lies beyond the room's walls, as far as it is in view.
pub(super) fn walls_in_view<'a>(
    room: &Room,
    frame: &'a LocalFrame,
    seen: &'a Footprint,
) -> impl Iterator<Item = BandInstance> + 'a {
    let (width, depth) = (room.width_m, room.depth_m);
    let corners = [vector![0.0, 0.0], vector![width, 0.0], vector![width, depth], vector![0.0, depth]];
    // Far enough to fill the view beyond a wall from any place within the room.
    let depth_m = (seen.high - seen.low).norm() + 1.0;
    (0..4).filter_map(move |side| {
        let [from, to] = [corners[side], corners[(side + 1) % 4]].map(|corner| frame.place(corner));
        let along = (to - from).normalize();
        let outward = vector![along.y, -along.x];
        // Of the view's four corners, the one farthest out.
        let farthest_m = (0..4)
            .map(|k| {
                let x = if k & 1 == 0 { seen.low.x } else { seen.high.x };
                let y = if k & 2 == 0 { seen.low.y } else { seen.high.y };
                (vector![x, y] - from).dot(&outward)
            })
            .fold(f64::MIN, f64::max);
        // The middle of the band is beside the camera, so that its coordinates are small.
        let beside = from + along * (-from).dot(&along) + outward * (depth_m / 2.0);
        let margin_m = seen.widest_margin_m();
        (farthest_m + margin_m > 0.0).then(|| BandInstance {
            albedo: WALL_ALBEDO,
            ..BandInstance::between(beside - along * depth_m, beside + along * depth_m, depth_m, [margin_m; 2])
        })
    })
}

/// Contrast of the segment before or after a segment of the same joint.
fn neighbour(laid: &LaidTiles, axis: usize, corner: [usize; 2], step: isize) -> Option<f32> {
    let mut next = corner;
    next[1 - axis] = next[1 - axis].checked_add_signed(step)?;
    (next[1 - axis] < laid.count[1 - axis]).then(|| laid.contrast[axis][next[0] * laid.count[1] + next[1]])
}

/// Contrast at a corner between two segments: their mean, unless one of them is missing.
fn faded(own: f32, neighbour: Option<f32>) -> f32 {
    match neighbour {
        Some(other) if own > 0.0 && other > 0.0 => (own + other) / 2.0,
        _ => own,
    }
}

/// A seed for the pattern of tile `(i, j)`: the finaliser of MurmurHash3 over the indices.
fn tile_seed(floor_seed: u32, i: usize, j: usize) -> u32 {
    let mut hash = floor_seed ^ (i as u32).wrapping_mul(0x9e37_79b1) ^ (j as u32).wrapping_mul(0x85eb_ca77);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

fn single(vector: Vector2<f64>) -> [f32; 2] {
    [vector.x as f32, vector.y as f32]
}
