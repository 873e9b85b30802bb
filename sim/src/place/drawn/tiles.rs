//! A tiled floor as it was truly laid: tile corners off their nominal places, joints worn or missing.

use nalgebra::{Rotation2, Vector2, vector};
use rand::Rng;

use crate::{
    scene::{Distribution, Tiles},
    truth::randomness::{self, draw_within},
};

mod laying;
mod segment;

use laying::{albedos, contrasts, draw_lines, laid_straight};
use segment::Segment;

/// A tiled floor as it was truly laid: displaced corners and joint contrasts, covering the room with a margin.
///
/// Corner `(i, j)` is the crossing of joint `i` of grid x and joint `j` of grid y, `first[a] ≤ index < first[a] + count[a]`. A joint runs
/// straight from corner to corner.
#[derive(Clone, Debug)]
pub struct LaidTiles {
    /// Index of the first laid joint of each of the two families (joints at constant grid x, joints at constant grid y).
    pub first: [i32; 2],
    /// Number of laid joints in each of the two families (joints at constant grid x, joints at constant grid y).
    pub count: [usize; 2],
    /// Displacement of each tile corner from its nominal place, grid frame; `count[0] × count[1]`, row-major in `(i, j)`.
    pub corner_offset_m: Vec<[f64; 2]>,
    /// The straight line along which each joint of each grid axis was laid: its displacement from the nominal line where the other grid
    /// coordinate is 0, and its slope.
    pub lines: [Vec<[f64; 2]>; 2],
    /// Contrast of each joint segment, from 1 for a new joint to 0 for an invisible one. `[0]` holds the segments from corner `(i, j)` to
    /// `(i, j + 1)`, `[1]` those to `(i + 1, j)`; both are indexed like the corners.
    pub contrast: [Vec<f32>; 2],
    /// Albedo of the tile between the corners `(i, j)` and `(i + 1, j + 1)`, indexed like the corners.
    pub tile_albedo: Vec<f32>,
    /// Random seed of the pattern that is printed or grown on the tiles.
    pub pattern_seed: u32,
}

/// Greatest errors of the floor's joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointErrors {
    /// Greatest distance of a joint's centre line from its nominal line.
    pub offset_m: f64,
    /// Greatest distance of a joint's centre line from the straight line that it was laid along.
    pub bend_m: f64,
    /// Greatest angle between the straight line that a joint was laid along and its nominal direction.
    pub angle_rad: f64,
}

/// Number of joints laid beyond the room on each side, for camera views that reach behind its walls.
const MARGIN_JOINTS: i32 = 2;

impl LaidTiles {
    /// Lays tiles over a floor, given by its least and its greatest coordinates in the world frame, with all errors drawn at random for a seed.
    ///
    /// Laying, corners, wear, missing joints and albedos have a random stream each. Every point of a joint's centre line in the room is within
    /// `laying_tolerance_m + corner_tolerance_m` of the joint's nominal line, unless a tile is misplaced.
    pub fn draw(tiles: &Tiles, floor_m: [[f64; 2]; 2], distribution: Distribution, seed: u64) -> LaidTiles {
        let [low_m, high_m] = floor_in_grid(tiles, floor_m);
        let edge_m = [tiles.edge_x_m, tiles.edge_y_m];
        let phase_m = [tiles.phase_x_m, tiles.phase_y_m];
        let mut first = [0; 2];
        let mut count = [0; 2];
        for axis in 0..2 {
            let index_of = |place_m: f64| (place_m - phase_m[axis]) / edge_m[axis];
            first[axis] = index_of(low_m[axis]).floor() as i32 - MARGIN_JOINTS;
            let last = index_of(high_m[axis]).ceil() as i32 + MARGIN_JOINTS;
            count[axis] = (last - first[axis] + 1) as usize;
        }
        let lines = draw_lines(tiles, distribution, seed, count, [low_m, high_m]);
        let mut laid = LaidTiles {
            first,
            count,
            corner_offset_m: laid_straight(tiles, first, &lines),
            lines,
            contrast: contrasts(tiles, seed, count[0] * count[1]),
            tile_albedo: albedos(tiles, seed, count[0] * count[1]),
            pattern_seed: randomness::stream(seed, "tiles.pattern").next_u32(),
        };
        laid.move_corners(tiles, distribution, seed, [low_m, high_m]);
        laid.misplace(tiles);
        laid
    }

    /// All joints whose centre line passes close to a point of the floor (world frame), within the distance that is given for each of the two
    /// families of parallel joints. Each joint is given once, by its family and index.
    pub fn joints_within(&self, tiles: &Tiles, place_in_world_m: [f64; 2], distance_m: [f64; 2]) -> Vec<(usize, i32)> {
        let place = grid_from_world(tiles) * Vector2::from(place_in_world_m);
        let reach = vector![2.0 * tiles.edge_x_m, 2.0 * tiles.edge_y_m];
        let mut joints: Vec<(usize, i32)> = self
            .segments_within(tiles, place, reach)
            .filter(|segment| segment.distance_m(place) <= distance_m[segment.axis])
            .map(|segment| (segment.axis, segment.index))
            .collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    }

    /// Greatest errors of those parts of the joints that lie on the floor, given by its least and its greatest coordinates, and within a radius around a
    /// point of the floor (world frame).
    pub fn errors_near(
        &self,
        tiles: &Tiles,
        floor_m: [[f64; 2]; 2],
        place_in_world_m: [f64; 2],
        radius_m: f64,
    ) -> JointErrors {
        let grid_from_world = grid_from_world(tiles);
        let place = grid_from_world * Vector2::from(place_in_world_m);
        let reach = vector![radius_m + 2.0 * tiles.edge_x_m, radius_m + 2.0 * tiles.edge_y_m];
        let mut greatest = JointErrors::default();
        for segment in self.segments_within(tiles, place, reach) {
            let Some(in_room) = segment.within(&grid_from_world, floor_m) else { continue };
            let Some(part) = segment.in_disc(place, radius_m, in_room) else { continue };
            let largest = |ends: [f64; 2]| part.map(|share| (ends[0] + (ends[1] - ends[0]) * share).abs());
            let [from_m, to_m] = largest(segment.offset_m);
            greatest.offset_m = greatest.offset_m.max(from_m).max(to_m);
            let [from_m, to_m] = largest(segment.bend_m);
            greatest.bend_m = greatest.bend_m.max(from_m).max(to_m);
            greatest.angle_rad = greatest.angle_rad.max(segment.slope.atan().abs());
        }
        greatest
    }

    /// Moves tile corners back until no joint is farther than the tolerance from its nominal line.
    pub(super) fn clip_offsets(&mut self, tolerance_m: f64) {
        for offset in &mut self.corner_offset_m {
            *offset = offset.map(|off_m| off_m.clamp(-tolerance_m, tolerance_m));
        }
    }

    /// Moves tile corners back until no joint is farther than the tolerance from the straight line that it was laid along.
    pub(super) fn clip_bends(&mut self, tiles: &Tiles, tolerance_m: f64) {
        let straight = laid_straight(tiles, self.first, &self.lines);
        let steepest = self.lines.iter().flatten().map(|[_, slope]| slope.abs()).fold(0.0, f64::max);
        let tolerance_m = tolerance_m / (1.0 + steepest);
        for (offset, straight) in self.corner_offset_m.iter_mut().zip(&straight) {
            *offset =
                [0, 1].map(|axis| straight[axis] + (offset[axis] - straight[axis]).clamp(-tolerance_m, tolerance_m));
        }
    }

    /// Index of the tile corner `(i, j)` in the tables of corners, with `i` and `j` counted from the first corner.
    fn corner_index(&self, i: usize, j: usize) -> usize {
        i * self.count[1] + j
    }

    /// All joint segments whose first corner, at its nominal place, is within given distances from a point of the floor along x and along y of
    /// the grid frame.
    fn segments_within<'a>(
        &'a self,
        tiles: &'a Tiles,
        place: Vector2<f64>,
        reach: Vector2<f64>,
    ) -> impl Iterator<Item = Segment> + 'a {
        let edge = vector![tiles.edge_x_m, tiles.edge_y_m];
        let phase = vector![tiles.phase_x_m, tiles.phase_y_m];
        let range = move |axis: usize| {
            let index_of = |place_m: f64| (place_m - phase[axis]) / edge[axis] - f64::from(self.first[axis]);
            let last = self.count[axis] as f64 - 1.0;
            let low = index_of(place[axis] - reach[axis]).ceil().max(0.0);
            let high = index_of(place[axis] + reach[axis]).floor().min(last);
            low as usize..if high < low { low as usize } else { high as usize + 1 }
        };
        let corner = move |i: usize, j: usize| {
            let nominal = vector![
                (i as i32 + self.first[0]) as f64 * edge.x + phase.x,
                (j as i32 + self.first[1]) as f64 * edge.y + phase.y
            ];
            (nominal, Vector2::from(self.corner_offset_m[self.corner_index(i, j)]))
        };
        range(0).flat_map(move |i| range(1).map(move |j| (i, j))).flat_map(move |(i, j)| {
            (0..2).filter_map(move |axis| {
                let (next_i, next_j) = if axis == 0 { (i, j + 1) } else { (i + 1, j) };
                if next_i >= self.count[0] || next_j >= self.count[1] {
                    return None;
                }
                let (nominal, from_offset) = corner(i, j);
                let (next_nominal, to_offset) = corner(next_i, next_j);
                let [shift_m, slope] = self.lines[axis][[i, j][axis]];
                // Distance of the joint from the straight line that it was laid along, across the joint. The line's slope is so small that its
                // cosine is taken as 1.
                let bend_m = |nominal: Vector2<f64>, offset: Vector2<f64>| {
                    offset[axis] - shift_m - slope * (nominal[1 - axis] + offset[1 - axis])
                };
                Some(Segment {
                    axis,
                    index: self.first[axis] + [i, j][axis] as i32,
                    bend_m: [bend_m(nominal, from_offset), bend_m(next_nominal, to_offset)],
                    slope,
                    from: nominal + from_offset,
                    to: next_nominal + to_offset,
                    offset_m: [from_offset[axis], to_offset[axis]],
                })
            })
        })
    }

    /// Moves every tile corner by a random error of its own, so that joints bend from tile to tile.
    fn move_corners(&mut self, tiles: &Tiles, distribution: Distribution, seed: u64, room: [[f64; 2]; 2]) {
        // Where a joint is not parallel to its grid axis, moving a corner along the joint also shifts the joint sideways. The tolerance for
        // corners is reduced by that much, so that the declared bound on the joints stays exact.
        let slope =
            (0..2).map(|axis| 2.0 * tiles.laying_tolerance_m / (room[1][axis] - room[0][axis])).fold(0.0, f64::max);
        let tolerance_m = tiles.corner_tolerance_m / (1.0 + slope);
        let mut rng = randomness::stream(seed, "tiles.corners");
        for offset_m in self.corner_offset_m.iter_mut().flatten() {
            *offset_m += match distribution {
                // With the distribution `Drift` a corner is moved farther in the direction in which its joint is already off.
                Distribution::Drift => tolerance_m.copysign(*offset_m),
                _ => draw_within(tolerance_m, distribution, &mut rng),
            };
        }
    }

    /// Displaces the four corners of each misplaced tile.
    fn misplace(&mut self, tiles: &Tiles) {
        for misplaced in &tiles.misplaced {
            for (di, dj) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let i = misplaced.tile[0] + di - self.first[0];
                let j = misplaced.tile[1] + dj - self.first[1];
                let (Ok(i), Ok(j)) = (usize::try_from(i), usize::try_from(j)) else {
                    continue;
                };
                if i < self.count[0] && j < self.count[1] {
                    let index = self.corner_index(i, j);
                    self.corner_offset_m[index][0] += misplaced.offset_m[0];
                    self.corner_offset_m[index][1] += misplaced.offset_m[1];
                }
            }
        }
    }
}

fn grid_from_world(tiles: &Tiles) -> Rotation2<f64> {
    Rotation2::new(-tiles.rotation_deg.to_radians())
}

/// Lowest and highest coordinates in the grid frame, the frame of the tiles, of a floor given by its least and its greatest coordinates in the world
/// frame.
fn floor_in_grid(tiles: &Tiles, [[x0_m, y0_m], [x1_m, y1_m]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let corners = [[x0_m, y0_m], [x1_m, y0_m], [x0_m, y1_m], [x1_m, y1_m]]
        .map(|corner| grid_from_world(tiles) * Vector2::from(corner));
    let low = corners.iter().fold(corners[0], |low, corner| low.inf(corner));
    let high = corners.iter().fold(corners[0], |high, corner| high.sup(corner));
    [low.into(), high.into()]
}
