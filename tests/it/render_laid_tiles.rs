//! Floor tiles as a seed lays them, with drawn errors, compared with the declared bounds that the localizer is given.

use sim::{
    place::drawn::LaidTiles,
    scene::{Distribution, Misplaced, Tiles},
};

/// Least and greatest coordinates of the floor.
const FLOOR_M: [[f64; 2]; 2] = [[0.0, 0.0], [3.6, 2.4]];

fn inside(place: [f64; 2]) -> bool {
    (0.0..=FLOOR_M[1][0]).contains(&place[0]) && (0.0..=FLOOR_M[1][1]).contains(&place[1])
}

fn to_world(tiles: &Tiles, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = tiles.rotation_deg.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Nominal and true place of tile corner `(i, j)`, in the frame of the tile grid.
fn corner(tiles: &Tiles, laid: &LaidTiles, i: usize, j: usize) -> ([f64; 2], [f64; 2]) {
    let nominal = [
        (i as i32 + laid.first[0]) as f64 * tiles.edge_x_m + tiles.phase_x_m,
        (j as i32 + laid.first[1]) as f64 * tiles.edge_y_m + tiles.phase_y_m,
    ];
    let offset = laid.corner_offset_m[i * laid.count[1] + j];
    (nominal, [nominal[0] + offset[0], nominal[1] + offset[1]])
}

/// How far floor tiles as laid depart from the nominal grid, at places inside the room: largest offset of any joint across its direction, and largest
/// angle between a joint and its nominal direction.
fn departures(tiles: &Tiles, laid: &LaidTiles) -> (f64, f64) {
    let (mut offset_m, mut angle_rad) = (0.0_f64, 0.0_f64);
    for i in 0..laid.count[0] - 1 {
        for j in 0..laid.count[1] - 1 {
            for axis in 0..2 {
                let (nominal, from) = corner(tiles, laid, i, j);
                let (next_i, next_j) = if axis == 0 { (i, j + 1) } else { (i + 1, j) };
                let (_, to) = corner(tiles, laid, next_i, next_j);
                for step in 0..=20 {
                    let share = f64::from(step) / 20.0;
                    let place = [0, 1].map(|k| from[k] + (to[k] - from[k]) * share);
                    if inside(to_world(tiles, place)) {
                        offset_m = offset_m.max((place[axis] - nominal[axis]).abs());
                        angle_rad = angle_rad.max(((to[axis] - from[axis]) / (to[1 - axis] - from[1 - axis])).abs());
                    }
                }
            }
        }
    }
    (offset_m, angle_rad)
}

#[test]
fn every_joint_keeps_the_declared_laying_bound() {
    let mut nearest_to_bound = 0.0_f64;
    for distribution in
        [Distribution::Uniform, Distribution::TruncatedGaussian, Distribution::Corner, Distribution::Drift]
    {
        for (seed, rotation_deg, corner_tolerance_m) in
            [(0, 0.0, 0.0), (1, 17.0, 0.0), (2, 45.0, 0.0), (3, -60.0, 0.001), (4, 5.0, 0.002)]
        {
            let tiles = Tiles { rotation_deg, corner_tolerance_m, phase_x_m: 0.07, edge_y_m: 0.45, ..Tiles::default() };
            let laid = LaidTiles::draw(&tiles, FLOOR_M, distribution, seed);
            let (offset_m, angle_rad) = departures(&tiles, &laid);
            let bound_m = tiles.laying_tolerance_m + corner_tolerance_m;
            assert!(offset_m <= bound_m + 1e-12, "{distribution:?}, seed {seed}: {offset_m} beyond {bound_m}");
            if corner_tolerance_m == 0.0 {
                assert!(angle_rad <= 2.0 * tiles.laying_tolerance_m / 2.4 + 1e-12, "{angle_rad}");
            }
            nearest_to_bound = nearest_to_bound.max(offset_m / bound_m);
        }
    }
    // Some joint must come near the bound: otherwise the check that all joints keep it would prove nothing.
    assert!(nearest_to_bound > 0.95, "{nearest_to_bound}");
}

#[test]
fn a_joint_laid_straight_does_not_bend_at_its_corners() {
    let tiles = Tiles { rotation_deg: 17.0, laying_tolerance_m: 0.005, ..Tiles::default() };
    let laid = LaidTiles::draw(&tiles, FLOOR_M, Distribution::Uniform, 3);
    for i in 0..laid.count[0] {
        let places: Vec<_> = (0..laid.count[1]).map(|j| corner(&tiles, &laid, i, j).1).collect();
        let [first, last] = [places[0], places[places.len() - 1]];
        for place in places {
            let straight = first[0] + (last[0] - first[0]) * (place[1] - first[1]) / (last[1] - first[1]);
            assert!((place[0] - straight).abs() < 1e-12);
        }
    }
}

#[test]
fn a_misplaced_tile_shows_near_itself_and_nowhere_else() {
    let misplaced = Misplaced { tile: [5, 3], offset_m: [0.008, 0.0] };
    let tiles = Tiles { misplaced: vec![misplaced], laying_tolerance_m: 0.0, ..Tiles::default() };
    let laid = LaidTiles::draw(&tiles, FLOOR_M, Distribution::Uniform, 0);
    // The floor tile that the scene misplaces covers x from 1.5 to 1.8 and y from 0.9 to 1.2.
    assert!((laid.errors_near(&tiles, FLOOR_M, [1.65, 1.05], 0.3).offset_m - 0.008).abs() < 1e-12);
    assert!(laid.errors_near(&tiles, FLOOR_M, [0.6, 0.6], 0.3).offset_m < 1e-12);
    // The left joint of the misplaced tile is 8 mm further to the right along its whole edge.
    let joints = |x_m: f64, within_m: f64| laid.joints_within(&tiles, [x_m, 1.05], [within_m; 2]);
    assert_eq!(joints(1.508, 1e-12), [(0, 5)]);
    assert_eq!((joints(1.5, 0.008 - 1e-12), joints(1.5, 0.008 + 1e-12)), (Vec::new(), vec![(0, 5)]));
}

#[test]
fn wear_does_not_move_a_joint() {
    let new = LaidTiles::draw(&Tiles::default(), FLOOR_M, Distribution::Uniform, 9);
    let worn_tiles = Tiles { worn_share: 0.4, missing_share: 0.2, ..Tiles::default() };
    let worn = LaidTiles::draw(&worn_tiles, FLOOR_M, Distribution::Uniform, 9);
    assert_eq!(new.corner_offset_m, worn.corner_offset_m);
    assert_eq!(new.tile_albedo, worn.tile_albedo);
    let n_missing = worn.contrast.iter().flatten().filter(|&&contrast| contrast == 0.0).count();
    let n_segments = worn.contrast[0].len() + worn.contrast[1].len();
    let share = n_missing as f64 / n_segments as f64;
    assert!((share - 0.2).abs() < 0.08, "{share} of {n_segments} are missing");
}
