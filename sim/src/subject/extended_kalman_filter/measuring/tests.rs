use std::f64::consts::PI;

use nalgebra::Vector2;

use crate::{
    scene::Scene,
    subject::cues::scan_trial::{SIDES, lines_of, room, scan},
};

use super::{
    super::tests::{filter, wide, yard},
    *,
};

fn known<'a>(layout: &'a Layout, tiles: Option<&'a TileGrid>) -> Known<'a> {
    Known { layout, tiles, wall_directions_rad: &[], floor_plan: None, tuning: &FilterNoise { motion: 1.0, cues: 1.0 } }
}

#[test]
fn derivatives_of_a_devices_pose_and_of_a_place_are_those_of_finite_differences() {
    let filter = filter(&yard());
    let mut belief = filter.belief.clone();
    for at in 0..belief.mean.len() {
        belief.mean[at] = 0.3 + 0.17 * at as f64;
    }
    let apparent = |belief: &Belief| Apparent::of(belief, &filter.layout, Mounted::Antenna);
    let numbers = |belief: &Belief| {
        let ([x_m, y_m, heading_rad], (place, _)) = (apparent(belief).pose, apparent(belief).place([0.7, -0.4]));
        [x_m, y_m, heading_rad, place[0], place[1]]
    };
    let middle = apparent(&belief);
    let rows = [&middle.rows[..], &middle.place([0.7, -0.4]).1].concat();
    for at in 0..belief.mean.len() {
        let moved = |by: f64| {
            let mut moved = belief.clone();
            moved.mean[at] += by;
            numbers(&moved)
        };
        let [low, high] = [-1e-5, 1e-5].map(moved);
        for (number, row) in rows.iter().enumerate() {
            let slope: f64 = row.iter().filter(|(place, _)| *place == at).map(|(_, slope)| slope).sum();
            let difference = (high[number] - low[number]) / 2e-5;
            assert!((slope - difference).abs() < 1e-8, "number {number} by {at}: {slope}, {difference}");
        }
    }
}

#[test]
fn a_markers_heading_is_off_by_the_turn_of_at_most_half_a_circle() {
    let (layout, mut belief) = (filter(&yard()).layout, wide());
    belief.mean[2] = 3.2;
    let pose = [0.0, 0.0, -3.08];
    // With the variance 0.01 of both, half of the difference counts.
    let seen = Seen::Pose { pose, covariance: Matrix3::from_diagonal_element(belief.covariance[(2, 2)]) };
    measure(&mut belief, Mounted::CeilingCamera, &seen, &known(&layout, None));
    let by_hand = 0.5 * (3.2 + 2.0 * PI - 3.08);
    assert!((belief.mean[2] - by_hand).abs() < 1e-9, "{}", belief.mean[2]);
}

#[test]
fn a_joint_counts_only_where_no_other_joint_can_be_meant() {
    let grid = TileGrid {
        edge_m: [0.3, 0.5],
        rotation_rad: 0.0,
        phase_m: [0.0, 0.0],
        joint_width_m: 0.004,
        laying_m: 0.001,
        laying_angle_rad: 0.001,
        straightness_m: 0.0,
    };
    // From x = 1 m the joint is seen at 1.21 m; the nearest one is at 1.2 m, and half an edge is 0.15 m.
    let joint = Joint { normal_rad: 0.0, distance_m: 0.21, sigma: [0.01, 0.01] };
    let layout = filter(&yard()).layout;
    let x_m_with = |sigma_m: f64| {
        let mut belief = wide();
        belief.mean[0] = 1.0;
        belief.covariance[(0, 0)] = sigma_m * sigma_m;
        measure(&mut belief, Mounted::FloorCamera, &Seen::Joints(vec![joint]), &known(&layout, Some(&grid)));
        belief.mean[0]
    };
    // Three standard deviations: 3·√(0.05² + 0.01²) = 0.153 m, and 3·√(0.048² + 0.01²) = 0.147 m.
    assert_eq!(x_m_with(0.05), 1.0);
    let by_hand = 1.0 - 0.01 * 0.048_f64.powi(2) / (0.048_f64.powi(2) + 0.01_f64.powi(2));
    assert!((x_m_with(0.048) - by_hand).abs() < 1e-9, "{} instead of {by_hand}", x_m_with(0.048));
}

/// Landmark 7 seen straight ahead of a camera in the robot's origin.
fn ahead(ahead_m: f64, variance_m2: f64) -> Landmark {
    let in_robot_m = Vector2::new(ahead_m, 0.0);
    Landmark { code: 7, in_robot_m, ray_m: in_robot_m, covariance: Matrix2::from_diagonal_element(variance_m2) }
}

#[test]
fn a_landmark_from_two_known_places_tells_the_scale_of_the_range_camera() {
    let text = "duration_s = 5.0\n[room]\nwidth_m = 12.0\ndepth_m = 8.0\n[start]\nx_m = 2.0\ny_m = 2.0\n[robot]\n\
                floor_camera = false\n[robot.range_camera]\n[localizer]\nmethods = [\"range_landmarks\"]\n\
                [[route.waypoint]]\nx_m = 4.0\ny_m = 2.0\n";
    let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let layout = filter(&scene).layout;
    let scale = layout.range_scale.unwrap();
    let mut belief = Belief::start(&layout, &scene.start_box());
    belief.mean.fill(0.0);
    belief.covariance.fill(0.0);
    belief.covariance[(scale, scale)] = 1e-4;
    let see = |belief: &mut Belief, ahead_m: f64| {
        let seen = Seen::Landmarks(vec![ahead(ahead_m, 1e-10)]);
        measure(belief, Mounted::RangeCamera, &seen, &known(&layout, None));
    };
    // Distances are 1 % too long: the landmark is 2.02 and, from 1 m farther ahead, 1.01 m away for 2 and 1 m.
    see(&mut belief, 2.02);
    belief.mean[0] = 1.0;
    see(&mut belief, 1.01);
    let landmark_m = belief.mean[belief.place_of(Thing::Landmark(7)).unwrap()];
    // To first order in the scale: 2.02·(1 − s) = 1 + 1.01·(1 − s).
    assert!((belief.mean[scale] - 0.01 / 1.01).abs() < 1e-5, "{}", belief.mean[scale]);
    assert!((landmark_m - 2.0).abs() < 1e-5, "{landmark_m}");
    assert!(belief.covariance[(scale, scale)].sqrt() < 1e-4);
}

#[test]
fn a_landmark_seen_again_is_as_uncertain_as_it_was_first_seen() {
    let (layout, mut belief) = (filter(&yard()).layout, wide());
    belief.covariance.row_mut(2).fill(0.0);
    belief.covariance.column_mut(2).fill(0.0);
    let see = |belief: &mut Belief, ahead_m: f64| {
        let seen = Seen::Landmarks(vec![ahead(ahead_m, 0.25)]);
        measure(belief, Mounted::RangeCamera, &seen, &known(&layout, None));
    };
    see(&mut belief, 2.0);
    // The robot moves, with the variance 1 along x.
    belief.covariance[(0, 0)] += 1.0;
    see(&mut belief, 2.3);
    // The residual of −0.3 m has the variances 1 of the motion and 0.25 of either sighting: the robot has two thirds of it and the landmark a sixth.
    let landmark = belief.place_of(Thing::Landmark(7)).unwrap();
    let [robot_m, landmark_m] = [belief.mean[0], belief.mean[landmark]];
    assert!((robot_m + 0.2).abs() < 1e-9 && (landmark_m - 2.05).abs() < 1e-9, "{robot_m} {landmark_m}");
    assert!((belief.covariance[(0, 0)] - (5.0 - 1.0 / 1.5)).abs() < 1e-9);
}

#[test]
fn derivatives_of_a_pose_on_a_plan_that_lies_askew_are_those_of_finite_differences() {
    let filter = filter(&room(""));
    let (_, plan) = lines_of(&room(""), &scan([2.0, 1.5, 0.0], SIDES, 0.0, 0.0));
    let mut belief = filter.belief.clone();
    for at in 0..belief.mean.len() {
        belief.mean[at] = 0.3 + 0.17 * at as f64;
    }
    let apparent =
        |belief: &Belief| Apparent::of(belief, &filter.layout, Mounted::Scanner).on(&plan, belief, &filter.layout);
    let rows = apparent(&belief).rows;
    for at in 0..belief.mean.len() {
        let [low, high] = [-1e-5, 1e-5].map(|by| {
            let mut moved = belief.clone();
            moved.mean[at] += by;
            apparent(&moved).pose
        });
        for (number, row) in rows.iter().enumerate() {
            let slope: f64 = row.iter().filter(|(place, _)| *place == at).map(|(_, slope)| slope).sum();
            let difference = (high[number] - low[number]) / 2e-5;
            assert!((slope - difference).abs() < 1e-8, "number {number} by {at}: {slope}, {difference}");
        }
    }
}

/// The filter's layout in the room, its belief at the start, and the belief after so many scans from a pose in a room with the given sides.
fn scanned(times: usize, pose: [f64; 3], sides: [[f64; 2]; 2], box_m: f64, known_m: Option<f64>) -> (Layout, Belief) {
    let scene = room("");
    let (layout, mut belief) = (filter(&scene).layout, filter(&scene).belief);
    if let Some(known_m) = known_m {
        // The pose is known so well, and neither mount nor plan is off.
        belief.covariance.fill(0.0);
        (0..3).for_each(|axis| belief.covariance[(axis, axis)] = known_m * known_m);
    }
    let (lines, plan) = lines_of(&scene, &scan(pose, sides, box_m, 0.0));
    let tuning = FilterNoise::default();
    let known =
        Known { layout: &layout, tiles: None, wall_directions_rad: &[], floor_plan: Some(&plan), tuning: &tuning };
    for _ in 0..times {
        measure(&mut belief, Mounted::Scanner, &Seen::Lines(lines.clone()), &known);
    }
    (layout, belief)
}

#[test]
fn a_scan_pulls_the_pose_to_where_it_was_made_but_never_closer_than_the_plan_may_be_off() {
    // The start is at (2, 1.5) and looks along x, known to 0.1 m and 3 degrees.
    let pose = [2.06, 1.45, 0.03];
    for times in [1, 100] {
        let (_, belief) = scanned(times, pose, SIDES, 0.0, None);
        for (axis, within) in [0.003, 0.003, 0.002].into_iter().enumerate() {
            let off = belief.mean[axis] - pose[axis];
            assert!(off.abs() < within, "axis {axis} after {times} scans: {off}");
        }
        // The plan may be shifted by a standard deviation of 4 mm, and turned by one of 4 mm over √13 m, whatever the number of scans; the start,
        // known to 33 mm and 17 mrad, takes little off that.
        for (axis, least) in [0.004, 0.004, 0.004 / 13.0_f64.sqrt()].into_iter().enumerate() {
            let sigma = belief.covariance[(axis, axis)].sqrt();
            assert!(sigma > 0.98 * least && sigma < 2.5 * least, "axis {axis} after {times} scans: {sigma}");
        }
    }
}

#[test]
fn furniture_before_a_wall_is_left_out() {
    let pose = [2.0, 1.5, 0.0];
    let (_, with) = scanned(3, pose, SIDES, 0.25, None);
    // Nothing was learnt of the wall behind it, the second one.
    assert_eq!(with.things.len(), 3, "{:?}", with.things);
    assert!(
        pose.iter().zip(with.mean.iter()).all(|(true_value, mean)| (mean - true_value).abs() < 1e-3),
        "{}",
        with.mean
    );
}

#[test]
fn a_wall_that_is_off_is_learnt_where_the_pose_is_known() {
    let pose = [2.0, 1.5, 0.0];
    let (_, belief) = scanned(50, pose, [[0.0, 6.006], [0.0, 4.0]], 0.0, Some(1e-5));
    // The wall at x = 6 begins at y = 0 and ends at y = 4; both ends are 6 mm behind their places, each with a prior of 4 mm. The other walls are not
    // off.
    for wall in 0..4 {
        let Some(at) = belief.place_of(Thing::Wall(wall)) else { panic!("wall {wall} was not seen") };
        let ends_m = [belief.mean[at], belief.mean[at + 1]];
        let is_off = ends_m.iter().all(|end_m| (end_m + 0.006).abs() < 5e-4);
        let is_right = ends_m.iter().all(|end_m| end_m.abs() < 5e-4);
        assert!(if wall == 1 { is_off } else { is_right }, "wall {wall}: {ends_m:?}");
    }
    assert!((belief.mean[0] - pose[0]).abs() < 1e-4, "{}", belief.mean);
}
