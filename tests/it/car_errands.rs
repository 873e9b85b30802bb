//! Errands of a car: planned curves against geometry worked out by hand, the law that follows them, jumps of the estimate, and things in the way.

use std::f64::consts::{FRAC_PI_2, PI};

use localizer::{Estimate, Pose, Status};
use serde_json::{Value, json};
use sim::{
    driver::{ErrandDriver, Outcome},
    judge::distance_to_way_m,
    place::navigation::{Cell, CurvePlanner, OccupancyGrid, Planner, reeds_shepp::Arc},
    scene::Scene,
    truth::Truth,
    world::World,
};

use crate::{
    navigation_drive::drive_looking_out,
    world_setup::{estimate, hold, nominal, scene},
};

/// Radius of the smallest circle of the planner's tests, and the distance that it keeps.
const RADIUS_M: f64 = 1.0;
const KEEP_M: f64 = 0.5;

/// A box of a yard: least and greatest x, then least and greatest y.
type Block = [f64; 4];

/// A yard of 10 m by 6 m between walls, with boxes, in cells of 0.1 m.
fn yard(blocks: &[Block]) -> OccupancyGrid {
    let mut grid =
        OccupancyGrid { resolution_m: 0.1, origin_m: [-0.1, -0.1], size: [102, 62], cells: vec![Cell::Free; 102 * 62] };
    for index in 0..grid.cells.len() {
        let [x_m, y_m] = grid.centre_m([index % 102, index / 102]);
        let is_wall = !(0.0..10.0).contains(&x_m) || !(0.0..6.0).contains(&y_m);
        if is_wall
            || blocks
                .iter()
                .any(|[west, east, south, north]| (*west..*east).contains(&x_m) && (*south..*north).contains(&y_m))
        {
            grid.cells[index] = Cell::Occupied;
        }
    }
    grid
}

fn clearance_m(blocks: &[Block], [x_m, y_m]: [f64; 2]) -> f64 {
    let of_block = |[west, east, south, north]: &Block| {
        let beyond = |at_m: f64, low_m: f64, high_m: f64| (low_m - at_m).max(at_m - high_m).max(0.0);
        beyond(x_m, *west, *east).hypot(beyond(y_m, *south, *north))
    };
    let of_walls = x_m.min(10.0 - x_m).min(y_m).min(6.0 - y_m);
    blocks.iter().map(of_block).fold(of_walls, f64::min)
}

fn plan(blocks: &[Block], from: Pose, to_m: [f64; 2]) -> Option<Vec<Arc>> {
    CurvePlanner::new(&Planner::new(yard(blocks), KEEP_M), RADIUS_M).plan(from, to_m)
}

/// The poses of a car along a path, integrated in steps of 1 cm at most, each with whether it was reached backwards.
fn driven(from: Pose, arcs: &[Arc]) -> Vec<(Pose, bool)> {
    let (mut at, mut all) = (from, Vec::new());
    for arc in arcs {
        let n_steps = (arc.length_m.abs() / 0.01).ceil();
        let step_m = arc.length_m / n_steps;
        for _ in 0..n_steps as usize {
            let middle_rad = at.heading_rad + 0.5 * arc.curvature_per_m * step_m;
            at.x_m += step_m * middle_rad.cos();
            at.y_m += step_m * middle_rad.sin();
            at.heading_rad += arc.curvature_per_m * step_m;
            all.push((at, step_m < 0.0));
        }
    }
    all
}

/// The poses of a planned path, after checking that it ends at its goal, is clear, and keeps to the circle.
fn planned(blocks: &[Block], from: Pose, to_m: [f64; 2]) -> Vec<(Pose, bool)> {
    let arcs = plan(blocks, from, to_m).unwrap_or_else(|| panic!("no way from {from:?} to {to_m:?}"));
    assert!(arcs.iter().all(|arc| arc.curvature_per_m.abs() * RADIUS_M < 1.0 + 1e-9), "{arcs:?}");
    let poses = driven(from, &arcs);
    let end = poses.last().unwrap().0;
    assert!((end.x_m - to_m[0]).hypot(end.y_m - to_m[1]) < 0.005, "{arcs:?} ends at {end:?}, not at {to_m:?}");
    for (pose, _) in &poses {
        // A cell is open if its middle has the distance, so that half a cell's diagonal may be missing, and a little between two looks.
        let clear_m = clearance_m(blocks, [pose.x_m, pose.y_m]);
        assert!(clear_m > KEEP_M - 0.09, "{clear_m} m at {pose:?}");
    }
    poses
}

fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
    Pose { x_m, y_m, heading_rad }
}

#[test]
fn a_place_straight_ahead_is_driven_to_straight_ahead() {
    let arcs = plan(&[], pose(2.0, 3.0, 0.0), [7.0, 3.0]).unwrap();
    let [arc] = arcs.as_slice() else { panic!("{arcs:?}") };
    assert!((arc.length_m - 5.0).abs() < 1e-9 && arc.curvature_per_m.abs() < 1e-9, "{arc:?}");
}

/// A bay 1.6 m wide and 3 m deep, in which a car with a circle of 1 m cannot turn about.
#[test]
fn a_narrow_dead_end_is_left_backwards() {
    let blocks = [[6.6, 6.8, 0.0, 3.0], [8.4, 8.6, 0.0, 3.0]];
    let poses = planned(&blocks, pose(7.6, 0.8, -FRAC_PI_2), [2.0, 4.5]);
    assert!(poses.iter().filter(|(pose, _)| pose.y_m < 2.0).all(|(_, backwards)| *backwards), "{poses:?}");
    assert!(!poses.last().unwrap().1, "once outside it turns, and drives forwards");
    // It drives into the bay forwards, although its goal is as near by backing in.
    assert!(planned(&blocks, pose(2.0, 4.5, 0.0), [7.6, 0.8]).iter().all(|(_, backwards)| !backwards));
}

#[test]
fn a_goal_behind_a_wall_is_reached_around_its_end() {
    let blocks = [[4.9, 5.1, 0.0, 4.0]];
    let poses = planned(&blocks, pose(2.0, 1.0, 0.0), [8.0, 1.0]);
    let length_m = 0.01 * poses.len() as f64;
    // No path is shorter than the one that is stretched tightly around the wall's end at half a metre's distance.
    let tight_m = 2.0 * (3.0_f64 - 0.1 - KEEP_M).hypot(3.0) + 0.2;
    assert!(length_m > tight_m && length_m < 1.4 * tight_m, "{length_m} m, at least {tight_m} m");
}

#[test]
fn where_no_way_is_wide_enough_there_is_none() {
    let gap = |width_m: f64| [[4.9, 5.1, 0.0, 3.0], [4.9, 5.1, 3.0 + width_m, 6.0]];
    let through = |width_m: f64| plan(&gap(width_m), pose(2.0, 3.0, 0.0), [8.0, 3.0]);
    assert_eq!(through(0.0), None);
    assert_eq!(through(0.9), None, "narrower than twice {KEEP_M} m");
    assert!(through(1.4).is_some());
    assert_eq!(plan(&[], pose(2.0, 3.0, 0.0), [9.8, 3.0]), None, "a goal by the wall");
}

/// A car that stands half a metre from the wall before it, nearer than a path may come, backs away.
#[test]
fn a_car_too_near_to_a_wall_gets_away_from_it() {
    let from = pose(9.6, 3.0, 0.0);
    let poses = driven(from, &plan(&[], from, [3.0, 3.0]).expect("a way"));
    assert!(poses.iter().all(|(pose, _)| pose.x_m < 9.63), "never nearer than it was");
    assert!(poses.iter().take(20).all(|(_, backwards)| *backwards));
}

/// Between walls that leave the car's middle 1.4 m, where a half circle of 2 m does not fit. To drive 7.8 m backwards costs more than to turn about.
#[test]
fn a_car_turns_about_in_several_moves_where_a_circle_does_not_fit() {
    let blocks = [[0.0, 10.0, 0.0, 1.8], [0.0, 10.0, 4.2, 6.0]];
    let poses = planned(&blocks, pose(8.8, 3.0, 0.0), [1.0, 3.0]);
    let n_changes = poses.windows(2).filter(|pair| pair[0].1 != pair[1].1).count();
    let heading_rad = poses.last().unwrap().0.heading_rad;
    assert!(n_changes >= 1 && heading_rad.cos() < -0.99, "{n_changes} changes, ends at {heading_rad} rad");
    assert!(poses[poses.len() - 400..].iter().all(|(_, backwards)| !backwards));
    // With its nose to the goal it need not.
    let straight = planned(&blocks, pose(8.8, 3.0, PI), [1.0, 3.0]);
    assert!(straight.iter().all(|(_, backwards)| !backwards) && (straight.len() as f64 - 780.0).abs() < 2.0);
}

/// A car as in `scenes/car_errands.toml`, in a hall of 12 m by 8 m with a bay, at whose end it stands with its nose to the wall.
fn car(goals_m: &[[f64; 2]], more: Value) -> Scene {
    let errands: Vec<Value> = goals_m.iter().map(|at_m| json!({ "x_m": at_m[0], "y_m": at_m[1] })).collect();
    let fence = |x_m: f64| json!({ "x_m": x_m, "y_m": 1.6, "size_m": [0.1, 3.2] });
    let mut keys = json!({
        "room": { "width_m": 12.0, "depth_m": 8.0 },
        "start": { "x_m": 10.2, "y_m": 1.2, "heading_deg": -90, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
        "furniture": [fence(9.2), fence(11.2)],
        "errand": errands,
        "navigation": { "speed_m_per_s": 0.5, "margin_m": 0.15 },
        "robot": { "mass_kg": 15.0, "body_radius_m": 0.55, "floor_camera": false, "max_turn_rate_rad_per_s": 0.6,
                   "base": { "kind": "ackermann", "wheel_radius_m": 0.1, "track_m": 0.4 } },
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        match value.as_object() {
            Some(parts) if keys[key].is_object() => {
                parts.iter().for_each(|(part, value)| keys[key][part] = value.clone());
            }
            _ => keys[key] = value.clone(),
        }
    }
    scene(keys)
}

/// Drives a car's errands; `see` makes the estimate that the driver gets from the true state and the time. Checks that no command asks for a smaller
/// circle than the car's own, of 0.866 m.
fn drive_by(scene: &Scene, lasts_s: f64, see: impl Fn(&Truth, f64) -> Estimate) -> (Vec<Truth>, ErrandDriver) {
    let (mut world, mut driver) = (World::new(scene, &nominal(scene)), ErrandDriver::new(scene, &[]));
    let mut truths = vec![world.truth()];
    for step in 0..(lasts_s * 100.0) as usize {
        let time_s = step as f64 * 0.01;
        let asked = driver.command(&see(&world.truth(), time_s), None, time_s);
        let least_m = 0.5 / 30.0_f64.to_radians().tan();
        assert!(asked.turn_rad_per_s.abs() * least_m <= asked.speed_m_per_s.abs() + 1e-12, "{asked:?}");
        truths.push(hold(&mut world, asked, 0.01));
        if driver.is_done(time_s) {
            break;
        }
    }
    (truths, driver)
}

/// With a quick and with a slow steering, which takes 1.3 s from one side to the other.
#[test]
fn a_car_keeps_to_its_curves_within_a_hand_forwards_and_backwards() {
    let goal_m = [2.0, 6.4];
    for rate_deg_per_s in [90.0, 45.0] {
        let mut scene = car(&[goal_m], json!({}));
        scene.robot.base.ackermann.steering_rate_deg_per_s = rate_deg_per_s;
        let (truths, driver) = drive_by(&scene, 60.0, |truth, _| estimate(truth));
        let log = driver.into_log(60.0);
        assert_eq!((log.errands[0].outcome, log.errands[0].plans), (Outcome::Reached, 1), "{:?}", log.errands);
        let way_m = &log.legs[0].corners_m;
        let off_m = |truth: &Truth| distance_to_way_m([truth.pose.x_m, truth.pose.y_m], way_m);
        let most_m = truths.iter().map(off_m).fold(0.0, f64::max);
        assert!(most_m < 0.05, "{most_m} m beside its path");
        let end = truths.last().unwrap();
        assert!((end.pose.x_m - goal_m[0]).hypot(end.pose.y_m - goal_m[1]) < 0.05, "{:?}", end.pose);
        let speeds = || truths.iter().map(|truth| truth.velocity[0]);
        assert!(speeds().fold(0.0, f64::min) < -0.25 && speeds().fold(0.0, f64::max) > 0.4);
    }
}

/// From 12 s on the localizer says 0.6 m more in y than it should.
#[test]
fn a_car_whose_estimate_jumps_plans_anew_and_arrives_by_its_estimate() {
    let goal_m = [2.0, 4.0];
    let (truths, driver) = drive_by(&car(&[goal_m], json!({})), 100.0, |truth, time_s| {
        let mut seen = *truth;
        seen.pose.y_m += if time_s < 12.0 { 0.0 } else { 0.6 };
        estimate(&seen)
    });
    let log = driver.into_log(100.0);
    assert_eq!(log.errands[0].outcome, Outcome::Reached, "{:?}", log.errands);
    let starts_s: Vec<f64> = log.legs.iter().map(|leg| leg.from_s).collect();
    assert!(starts_s.iter().any(|start_s| (12.0..15.0).contains(start_s)), "paths begin at {starts_s:?} s");
    let end = truths.last().unwrap().pose;
    assert!((end.x_m - goal_m[0]).hypot(end.y_m - (goal_m[1] - 0.6)) < 0.06, "{end:?}");
}

#[test]
fn a_car_in_doubt_stands_for_a_while_then_creeps_on() {
    let scene = car(&[[2.0, 6.4]], json!({ "start": { "x_m": 5.0, "y_m": 6.0, "heading_deg": 180 } }));
    let (truths, driver) = drive_by(&scene, 40.0, |truth, time_s| {
        let status = if (2.0..15.0).contains(&time_s) { Status::Recovering } else { Status::Sound };
        Estimate { status, ..estimate(truth) }
    });
    let speed_at = |time_s: f64| truths[(100.0 * time_s) as usize].velocity[0];
    assert!(speed_at(1.9) > 0.3 && speed_at(6.0).abs() < 1e-3, "{} then {}", speed_at(1.9), speed_at(6.0));
    assert!((0.05..0.15).contains(&speed_at(9.0)), "a quarter of 0.5 m/s: {}", speed_at(9.0));
    assert_eq!(driver.into_log(40.0).errands[0].outcome, Outcome::Reached);
}

/// A box off the map stands where the car's straight way to its goal leads.
#[test]
fn a_car_waits_before_a_box_off_the_map_and_drives_round_it() {
    let scene = car(
        &[[9.5, 5.5]],
        json!({
            "start": { "x_m": 2.0, "y_m": 5.5, "heading_deg": 0 },
            "furniture": [{ "x_m": 6.0, "y_m": 5.5, "size_m": [0.4, 0.8], "mapped": false }],
            "robot": { "scanner": true },
            "duration_s": 90.0,
        }),
    );
    let (log, least_m) = drive_looking_out(&scene, 3);
    let errand = &log.errands[0];
    assert!(errand.outcome == Outcome::Reached && errand.detours >= 1 && errand.waited_s > 2.9, "{errand:?}");
    assert!(least_m > 0.02, "{least_m} m from the box");
}
