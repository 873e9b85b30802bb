//! Tests of occupancy grids, paths through them and their files, against maps drawn by hand and the rules of ROS's map_server.

use std::{
    fs,
    path::{Path, PathBuf},
};

use sim::{
    place::navigation::{Cell, OccupancyGrid, Planner, length_m, map_server},
    scene::Scene,
};

use crate::{
    command::{blind_scene, folder, outcome, wherein},
    world_setup::scene,
};

/// An occupancy grid with cells of 1 m, from rows of text with the greatest y first: `#` is occupied, `?` unknown, anything else free.
fn drawn_grid(rows: &[&str]) -> OccupancyGrid {
    let cells = rows.iter().rev().flat_map(|row| row.chars()).map(|character| match character {
        '#' => Cell::Occupied,
        '?' => Cell::Unknown,
        _ => Cell::Free,
    });
    let cells = cells.collect();
    OccupancyGrid { resolution_m: 1.0, origin_m: [0.0, 0.0], size: [rows[0].len(), rows.len()], cells }
}

#[test]
fn the_grid_of_a_room_shows_walls_and_what_is_mapped() {
    let piece =
        |x_m: f64, mapped: bool| serde_json::json!({ "x_m": x_m, "y_m": 0.5, "size_m": [0.2, 0.1], "mapped": mapped });
    let scene = scene(serde_json::json!({
        "room": { "width_m": 2.0, "depth_m": 1.0 },
        "furniture": [piece(0.6, true), piece(1.4, false)],
    }));
    let grid = OccupancyGrid::from_scene(&scene);
    // The room is 2.0 m wide, which makes 40 cells of 0.05 m in the occupancy grid, plus a cell of wall at each end.
    assert_eq!((grid.size, grid.origin_m), ([42, 22], [-0.05, -0.05]));
    let at = |x_m: f64, y_m: f64| grid.at(grid.cell_at([x_m, y_m]).unwrap());
    for [x_m, y_m] in [[-0.01, 0.5], [2.01, 0.5], [1.0, -0.01], [1.0, 1.01]] {
        assert_eq!(at(x_m, y_m), Cell::Occupied, "the wall at {x_m}, {y_m}");
    }
    for [x_m, y_m] in [[0.01, 0.01], [1.99, 0.99], [1.4, 0.5], [0.6, 0.61], [0.76, 0.5]] {
        assert_eq!(at(x_m, y_m), Cell::Free, "nothing at {x_m}, {y_m}");
    }
    // The box on the map reaches from 0.5 to 0.7 m in x and from 0.45 to 0.55 m in y.
    for [x_m, y_m] in [[0.6, 0.5], [0.51, 0.46], [0.69, 0.54]] {
        assert_eq!(at(x_m, y_m), Cell::Occupied, "the box at {x_m}, {y_m}");
    }
}

#[test]
fn the_shortest_way_round_a_wall_has_the_length_worked_out_by_hand() {
    let grid = drawn_grid(&[".......", "...#...", "...#...", "...#...", "...#..."]);
    let planner = Planner::new(grid, 0.1);
    let way = planner.plan([1.5, 0.5], [5.5, 0.5]).unwrap();
    // The shortest path round the wall goes over its end without cutting its corner: up 4 cells and across 1, along 2, and down again.
    assert_eq!(way, [[1.5, 0.5], [2.5, 4.5], [4.5, 4.5], [5.5, 0.5]]);
    assert!((length_m(&way) - (2.0 * 17.0_f64.sqrt() + 2.0)).abs() < 1e-12);
    assert_eq!(planner.plan([1.5, 0.5], [2.5, 3.5]).unwrap(), [[1.5, 0.5], [2.5, 3.5]], "seen, and straight");
}

#[test]
fn where_there_is_no_way_there_is_none_and_unknown_floor_is_no_way() {
    for wall in ["#", "?"] {
        let row = format!("...{wall}...");
        let planner = Planner::new(drawn_grid(&[row.as_str(); 5]), 0.1);
        assert_eq!(planner.plan([1.5, 0.5], [5.5, 0.5]), None, "through {wall}");
        assert!(planner.plan([1.5, 0.5], [1.5, 4.5]).is_some());
    }
}

#[test]
fn a_gap_lets_through_only_what_fits() {
    // The gap in the wall is 3 m wide. A path through its middle has 1.5 m of distance to either edge, so that it exists if the robot must keep 1.4 m
    // away from walls, but not with 1.6 m.
    let grid = drawn_grid(&[
        "......#......",
        "......#......",
        ".............",
        ".............",
        ".............",
        "......#......",
        "......#......",
    ]);
    let plan = |keep_away_m: f64| Planner::new(grid.clone(), keep_away_m).plan([2.5, 3.5], [10.5, 3.5]);
    assert!(plan(1.4).is_some());
    assert_eq!(plan(1.6), None);
}

/// Lengths of the shortest paths over cells from a start, by relaxing every step until nothing changes.
fn relaxed_lengths(grid: &OccupancyGrid, start: [usize; 2]) -> Vec<f64> {
    let [n_columns, n_rows] = grid.size;
    let is_open = |column: i64, row: i64| {
        column >= 0
            && row >= 0
            && (column as usize) < n_columns
            && (row as usize) < n_rows
            && grid.at([column as usize, row as usize]) == Cell::Free
    };
    let mut lengths = vec![f64::INFINITY; n_columns * n_rows];
    lengths[start[1] * n_columns + start[0]] = 0.0;
    loop {
        let before = lengths.clone();
        for row in 0..n_rows as i64 {
            for column in 0..n_columns as i64 {
                for (x, y) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
                    let is_step = is_open(column, row)
                        && is_open(column + x, row)
                        && is_open(column, row + y)
                        && is_open(column + x, row + y);
                    if is_step {
                        let from = lengths[(row + y) as usize * n_columns + (column + x) as usize];
                        let here = &mut lengths[row as usize * n_columns + column as usize];
                        *here = here.min(from + ((x * x + y * y) as f64).sqrt());
                    }
                }
            }
        }
        if lengths == before {
            return lengths;
        }
    }
}

#[test]
fn ways_through_mazes_are_never_longer_than_the_shortest_over_cells() {
    let mut state = 12_345_u64;
    let mut draw = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let (mut found, mut refused) = (0, 0);
    for _ in 0..40 {
        let mut cells: Vec<Cell> = (0..900).map(|_| if draw() < 0.32 { Cell::Occupied } else { Cell::Free }).collect();
        (cells[0], cells[899]) = (Cell::Free, Cell::Free);
        let grid = OccupancyGrid { resolution_m: 1.0, origin_m: [0.0, 0.0], size: [30, 30], cells };
        let shortest_m = relaxed_lengths(&grid, [0, 0])[899];
        let way = Planner::new(grid.clone(), 0.1).plan([0.5, 0.5], [29.5, 29.5]);
        assert_eq!(way.is_some(), shortest_m.is_finite());
        let Some(way) = way else {
            refused += 1;
            continue;
        };
        found += 1;
        assert!(length_m(&way) <= shortest_m + 1e-9, "{} m, over cells {shortest_m} m", length_m(&way));
        for pair in way.windows(2) {
            for look in 0..=200 {
                let share = f64::from(look) / 200.0;
                let place_m = [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
                assert_eq!(grid.at(grid.cell_at(place_m).unwrap()), Cell::Free, "{place_m:?} on {pair:?}");
            }
        }
    }
    assert!(found > 10 && refused > 3, "{found} found, {refused} refused");
}

fn write_map(place: &Path, yaml: &str, pgm: &[u8]) -> PathBuf {
    fs::write(place.join("m.pgm"), pgm).unwrap();
    fs::write(place.join("m.yaml"), yaml).unwrap();
    place.join("m.yaml")
}

const YAML: &str =
    "image: m.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

#[test]
fn a_map_is_read_by_the_rules_of_map_server() {
    use Cell::{Free, Occupied, Unknown};
    let place = folder("map_rules");
    // By the rules of ROS's map_server a pixel with grey level x has the occupancy p = (255 − x)/255, which is free below 0.196 and occupied above
    // 0.65. Grey level 89 gives 0.651 and 90 gives 0.647; 205 gives 0.1961 and 206 gives 0.192.
    let pgm = [b"P5\n# made by hand\n3 2\n255\n".as_slice(), &[0, 89, 90, 205, 206, 254]].concat();
    let grid = map_server::read(&write_map(&place, YAML, &pgm)).unwrap();
    assert_eq!((grid.size, grid.resolution_m, grid.origin_m), ([3, 2], 0.5, [-1.0, 2.0]));
    // The first row of the image is the row farthest from the map's origin.
    assert_eq!(grid.cells, [Unknown, Free, Free, Occupied, Occupied, Unknown]);
    assert_eq!(grid.at(grid.cell_at([-0.9, 2.9]).unwrap()), Occupied);
    // In a map file with `negate: 1` a pixel with grey level x has the occupancy p = x/255: 89 gives 0.349, 90 gives 0.353.
    let grid = map_server::read(&write_map(&place, &YAML.replace("negate: 0", "negate: 1"), &pgm)).unwrap();
    assert_eq!(grid.cells, [Occupied, Occupied, Occupied, Free, Unknown, Unknown]);
}

#[test]
fn a_written_map_has_the_bytes_of_map_saver_and_reads_back_the_same() {
    let place = folder("map_round");
    let mut grid = drawn_grid(&["#.?", "..#"]);
    (grid.resolution_m, grid.origin_m) = (0.05, [-0.05, 1.25]);
    let yaml = map_server::write(&grid, &place, "saved").unwrap();
    assert_eq!(fs::read(place.join("saved.pgm")).unwrap(), b"P5\n3 2\n255\n\x00\xfe\xcd\xfe\xfe\x00");
    let text = fs::read_to_string(&yaml).unwrap();
    for line in [
        "image: saved.pgm",
        "resolution: 0.05",
        "origin: [-0.05, 1.25, 0.0]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
    ] {
        assert!(text.lines().any(|written| written == line), "{line} in {text}");
    }
    assert_eq!(map_server::read(&yaml).unwrap(), grid);
}

#[test]
fn lists_in_blocks_pictures_in_ascii_and_png_and_keys_of_others_are_read() {
    let place = folder("map_dialects");
    let read = |yaml: &str, picture: &[u8]| map_server::read(&write_map(&place, yaml, picture)).unwrap();
    let plain = read(YAML, &[b"P5 2 1 255\n".as_slice(), &[254, 0]].concat());
    assert_eq!((plain.size, plain.at([0, 0]), plain.at([1, 0])), ([2, 1], Cell::Free, Cell::Occupied));
    assert_eq!(plain.origin_m, [-1.0, 2.0]);
    assert_eq!(read(YAML, b"P2\n# by hand\n2 1\n255\n254 0\n"), plain);
    let in_blocks = YAML.replace("origin: [-1.0, 2.0, 0.0]", "origin:\n  - -1.0\n  - 2.0\n  - 0.0");
    assert_ne!(in_blocks, YAML);
    let more = format!("---\n{in_blocks}cost_translation:\n  254: lethal # for a planner\nmode: \"trinary\"\n");
    assert_eq!(read(&more, b"P2 2 1 255 254 0"), plain);
    let mut png = Vec::new();
    let levels = image::GrayImage::from_raw(2, 1, vec![254, 0]).unwrap();
    levels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    fs::write(place.join("m.png"), &png).unwrap();
    assert_eq!(read(&YAML.replace("m.pgm", "m.png"), b""), plain);
}

#[test]
fn a_map_that_cannot_be_is_refused_by_name() {
    let place = folder("map_refused");
    let good = [b"P5 1 1 255\n".as_slice(), &[254]].concat();
    assert!(map_server::read(&write_map(&place, YAML, &good)).is_ok());
    let refused = |yaml: &str, pgm: &[u8], part: &str| {
        let told = map_server::read(&write_map(&place, yaml, pgm)).unwrap_err().to_string();
        assert!(told.contains(part), "{told} does not tell of {part}");
    };
    refused(YAML, b"no picture", "m.pgm: expected a PGM or PNG picture");
    refused(YAML, &[b"P5 2 1 255\n".as_slice(), &[254]].concat(), "m.pgm: expected a PGM or PNG picture");
    refused(YAML, &[b"P5 0 1 255\n".as_slice(), &[]].concat(), "m.pgm");
    refused("image: [", &good, "m.yaml: expected YAML");
    refused("no keys", &good, "m.yaml: expected YAML");
    let without = |key: &str| -> String {
        YAML.lines().filter(|line| !line.starts_with(key)).map(|line| format!("{line}\n")).collect()
    };
    for key in ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"] {
        refused(&without(key), &good, key);
    }
    refused(&YAML.replace("0.196", "0.9"), &good, "0 ≤ free ≤ occupied ≤ 1");
    refused(&YAML.replace("2.0, 0.0]", "2.0, 0.5]"), &good, "yaw");
    for resolution in ["0", "1e-300", "0.0001", "50"] {
        let text = YAML.replace("resolution: 0.5", &format!("resolution: {resolution}"));
        refused(&text, &good, "expected a number of metres from 0.01 to 1");
    }
    refused(&YAML.replace("resolution: 0.5", "resolution: nan"), &good, "finite");
    refused(&format!("{YAML}mode: scale\n"), &good, "trinary");
    refused(&YAML.replace("m.pgm", "none.pgm"), &good, "none.pgm");
}

/// Text of a scene with the given lines, in which errands replace the route.
fn errand_scene(more: &str) -> String {
    let scene = blind_scene(20.0, "");
    scene.split("[[route").next().unwrap().to_owned() + more
}

#[test]
fn the_command_writes_the_map_of_a_scene_and_plans_on_the_map_of_a_file() {
    let place = folder("map_command");
    fs::write(place.join("x.toml"), errand_scene("[[errand]]\nx_m = 2.4\ny_m = 1.2\n")).unwrap();
    let (code, told, errors) = outcome(&mut wherein(&place, &["map", "x.toml", "--out", "out"]));
    assert_eq!((code, told.trim()), (0, "out/x/map.yaml"), "{errors}");
    let grid = map_server::read(&place.join("out/x/map.yaml")).unwrap();
    assert_eq!(grid, OccupancyGrid::from_scene(&Scene::load(&place.join("x.toml")).unwrap()));
    // The map written before is saved again as a file, with an additional wall across the room that the scene does not have.
    let mut walled = grid;
    for row in 0..200 {
        walled.occupy([1.5, f64::from(row) * 0.01]);
    }
    map_server::write(&walled, &place, "walled").unwrap();
    let planned =
        errand_scene("[navigation]\nmap = \"walled.yaml\"\n[[errand]]\nname = \"window\"\nx_m = 2.4\ny_m = 1.2\n");
    fs::write(place.join("y.toml"), &planned).unwrap();
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "y.toml", "--out", "out"]));
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("errand[0].x_m") && errors.contains("no way leads from the start"), "{errors}");
    fs::write(place.join("y.toml"), planned.replace("walled", "lost")).unwrap();
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "y.toml", "--out", "out"]));
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("navigation.map") && errors.contains("lost.yaml"), "{errors}");
}

#[test]
fn errands_that_cannot_be_are_refused() {
    let refused = |more: &str, parts: &[&str]| {
        let error = Scene::parse(&errand_scene(more), "x.toml").unwrap_err().to_string();
        parts.iter().for_each(|part| assert!(error.contains(part), "{error} does not tell of {part}"));
    };
    let wall = "[[furniture]]\nx_m = 1.5\ny_m = 1.0\nsize_m = [0.1, 2.0]\n";
    refused(&format!("[[errand]]\nx_m = 2.4\ny_m = 1.2\n{wall}"), &["`errand[0].x_m = 2.4`", "no way leads", "margin"]);
    refused("[[errand]]\nx_m = 9.0\ny_m = 1.2\n", &["`errand[0].x_m = 9.0`", "outside the room"]);
    refused(
        "[[errand]]\nx_m = 1.0\ny_m = 1.0\n[[station]]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 0\n",
        &["errand", "stands beside"],
    );
    refused(
        "[[errand]]\nx_m = 1.0\ny_m = 1.0\n[[route.waypoint]]\nx_m = 1.0\ny_m = 1.0\n",
        &["route", "stands beside errands"],
    );
    refused("", &["route", "an `[[errand]]`"]);
    refused(
        "[navigation]\nfollower = \"turn_than_drive\"\n[[errand]]\nx_m = 1.0\ny_m = 1.0\n",
        &["navigation.follower", "turn_then_drive"],
    );
}
