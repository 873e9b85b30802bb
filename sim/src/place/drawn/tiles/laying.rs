//! Random draws for a tiled floor: where joints run, how they are worn, how bright tiles are.

use rand::RngExt;

use crate::{
    scene::{Distribution, Tiles},
    truth::randomness::{self, draw_within},
};

/// Contrast of a worn joint. The scene's key `worn_share` defines it as a third of the contrast of a new joint.
const WORN_CONTRAST: f32 = 1.0 / 3.0;

/// Draws straight joints, both ends of each within the laying tolerance of the joint's nominal line. The line of each joint is returned as its
/// displacement where the coordinate along the joint is 0, and its slope.
///
/// The ends of a joint are at the limits of the room in the grid frame (the frame of the tiles), which are never less than the room's shorter
/// side apart. A joint's angle therefore stays within 2·tolerance / shorter side, and every point of the joint in the room within the tolerance.
pub(super) fn draw_lines(
    tiles: &Tiles,
    distribution: Distribution,
    seed: u64,
    count: [usize; 2],
    room: [[f64; 2]; 2],
) -> [Vec<[f64; 2]>; 2] {
    let mut rng = randomness::stream(seed, "tiles.laying");
    // With the distribution `Drift` all joints that run in the same direction are shifted or turned alike, so that no number of joints reveals
    // the error.
    let alike_m = (distribution == Distribution::Drift)
        .then(|| [0; 2].map(|_| [0; 2].map(|_| draw_within(tiles.laying_tolerance_m, distribution, &mut rng))));
    [0, 1].map(|axis| {
        let [low_m, high_m] = [room[0][1 - axis], room[1][1 - axis]];
        (0..count[axis])
            .map(|_| {
                let mut draw_ends = || [0; 2].map(|_| draw_within(tiles.laying_tolerance_m, distribution, &mut rng));
                let [at_low, at_high] = alike_m.map_or_else(&mut draw_ends, |alike_m| alike_m[axis]);
                let slope = (at_high - at_low) / (high_m - low_m);
                [at_low - slope * low_m, slope]
            })
            .collect()
    })
}

/// Displacements of the tile corners from their nominal places if all joints are straight: the exact crossings x = a(y) and y = b(x) of two
/// linear functions.
pub(super) fn laid_straight(tiles: &Tiles, first: [i32; 2], lines: &[Vec<[f64; 2]>; 2]) -> Vec<[f64; 2]> {
    let edge_m = [tiles.edge_x_m, tiles.edge_y_m];
    let phase_m = [tiles.phase_x_m, tiles.phase_y_m];
    let mut offsets = Vec::with_capacity(lines[0].len() * lines[1].len());
    for (i, &[shift_x, slope_x]) in (first[0]..).zip(&lines[0]) {
        for (j, &[shift_y, slope_y]) in (first[1]..).zip(&lines[1]) {
            let x = f64::from(i) * edge_m[0] + phase_m[0];
            let y = f64::from(j) * edge_m[1] + phase_m[1];
            // With d the displacement of a corner from its nominal place (x, y), and with the shifts and slopes of the two joints that cross
            // there, d_x = shift_x + slope_x·(y + d_y) and d_y = shift_y + slope_y·(x + d_x).
            let along_x = shift_x + slope_x * y;
            let along_y = shift_y + slope_y * x;
            let d_x = (along_x + slope_x * along_y) / (1.0 - slope_x * slope_y);
            offsets.push([d_x, along_y + slope_y * d_x]);
        }
    }
    offsets
}

/// Draws at random the contrast of every segment of the joints between floor tiles.
pub(super) fn contrasts(tiles: &Tiles, seed: u64, count: usize) -> [Vec<f32>; 2] {
    let mut worn = randomness::stream(seed, "tiles.worn");
    let mut missing = randomness::stream(seed, "tiles.missing");
    [0; 2].map(|_| {
        (0..count)
            .map(|_| {
                let is_worn = worn.random::<f64>() < tiles.worn_share;
                let is_missing = missing.random::<f64>() < tiles.missing_share;
                match (is_missing, is_worn) {
                    (true, _) => 0.0,
                    (false, true) => WORN_CONTRAST,
                    (false, false) => 1.0,
                }
            })
            .collect()
    })
}

/// Draws at random the albedo of every floor tile.
pub(super) fn albedos(tiles: &Tiles, seed: u64, count: usize) -> Vec<f32> {
    let mut rng = randomness::stream(seed, "tiles.albedo");
    (0..count)
        .map(|_| {
            let spread = draw_within(tiles.tile_albedo_spread, Distribution::Uniform, &mut rng);
            (tiles.tile_albedo + spread).clamp(0.0, 1.0) as f32
        })
        .collect()
}
