//! A rectangular room and scans of it that are worked out by hand, for tests of all that reads scans; and tests of the lines and of what they say.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Matrix3;

use super::*;

/// Size of the room, which has its corner in the origin.
pub(crate) const ROOM_M: [f64; 2] = [6.0, 4.0];
const BEAMS: usize = 180;
/// The scanner's place, and its yaw, on the robot.
const MOUNT: [f64; 3] = [0.1, -0.05, 0.2];

/// The room with a scanner on the robot, and with the robot's start known to a decimetre and three degrees.
pub(crate) fn room(more: &str) -> Scene {
    let text = format!(
        "duration_s = 5.0\n[room]\nwidth_m = 6.0\ndepth_m = 4.0\n[start]\nx_m = 2.0\ny_m = 1.5\ntolerance_m = 0.1\n\
         tolerance_deg = 3.0\n\
         [robot]\nfloor_camera = false\n[robot.scanner]\nfield_deg = 358.0\nbeams = {BEAMS}\nrange_m = 10.0\nforward_m = 0.1\n\
         left_m = -0.05\nyaw_deg = {}\n{more}\n[localizer]\nmethods = [\"wall_ranges\"]\n[localizer.wall_ranges]\n\
         placement_tolerance_m = 0.012\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n",
        MOUNT[2].to_degrees()
    );
    Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

/// A scan without errors from a pose in a room whose sides are at x and y; before its side at the greatest x stands furniture `box_m` deep along the
/// whole side.
pub(crate) fn scan(pose: [f64; 3], [x, y]: [[f64; 2]; 2], box_m: f64, measured_s: f64) -> Reading {
    let [dx, dy] = turned([MOUNT[0], MOUNT[1]], pose[2]);
    let eye = [pose[0] + dx, pose[1] + dy];
    let (first_rad, step_rad) = (-f64::to_radians(179.0), f64::to_radians(2.0));
    let sides = [[x[0], x[1] - box_m], y];
    let distance_m = |beam: usize| {
        let toward = turned([1.0, 0.0], pose[2] + MOUNT[2] + first_rad + beam as f64 * step_rad);
        // Along either axis the beam goes to the side that it comes closer to.
        let along = |axis: usize| (sides[axis][usize::from(toward[axis] > 0.0)] - eye[axis]) / toward[axis];
        along(0).min(along(1))
    };
    let numbers = [first_rad, step_rad].into_iter().chain((0..BEAMS).map(distance_m)).collect();
    Reading::Other { measured_s, arrived_s: measured_s, device: wall_ranges::DEVICE.to_owned(), numbers }
}

/// The sides of the room where the map has them.
pub(crate) const SIDES: [[f64; 2]; 2] = [[0.0, ROOM_M[0]], [0.0, ROOM_M[1]]];

/// The lines of a scan, and the floor plan.
pub(crate) fn lines_of(scene: &Scene, reading: &Reading) -> (Vec<Line>, FloorPlan) {
    let mut cues = Cues::new(scene, &scene.map(), &scene.robot_model());
    let Some(Told::Seen(_, Mounted::Scanner, Seen::Lines(lines))) = cues.take(reading) else { panic!("no lines") };
    (lines, cues.floor_plan().cloned().unwrap())
}

#[test]
fn the_lines_of_a_room_are_its_walls_as_seen_from_the_true_pose() {
    for heading_rad in [0.3, 2.0, -1.2, 3.3] {
        let pose = [2.0, 1.5, heading_rad];
        let (lines, plan) = lines_of(&room(""), &scan(pose, SIDES, 0.0, 0.0));
        // The beam straight back from the scanner is missing, so that one wall may be in two parts.
        assert!((4..=5).contains(&lines.len()), "{lines:?}");
        let mut lengths_m = [0.0; 4];
        for line in &lines {
            let met = plan.met(line, pose).unwrap();
            assert!(met.turn_rad.abs() < 5e-4 && met.off_m.abs() < 5e-4, "{met:?}");
            // Beams of 2 degrees that slant to a wall meet it up to half a metre before its corners, and again where the beam straight back is
            // missing.
            lengths_m[met.wall] += 2.0 * line.half_m;
            // From 2 cm farther along x and 3 cm along y, and turned by 0.01 rad, each wall is nearer or farther by that as its normal says.
            let [ahead_m, _] = turned(line.middle_m, -line.normal_rad);
            let moved = plan.met(line, [pose[0] + 0.02, pose[1] + 0.03, heading_rad + 0.01]).unwrap();
            let [dx, dy] = turned(line.middle_m, heading_rad);
            let by_hand_m = -moved.normal[0] * (0.02 - 0.01 * dy) - moved.normal[1] * (0.03 + 0.01 * dx);
            assert!((moved.off_m - met.off_m - by_hand_m).abs() < 3e-4, "{} {by_hand_m}", moved.off_m);
            assert!((moved.turn_rad - met.turn_rad + 0.01).abs() < 1e-9 && ahead_m < 0.0, "{moved:?} {line:?}");
        }
        let mut sides_m = [6.0, 4.0, 6.0, 4.0];
        sides_m.sort_by(f64::total_cmp);
        lengths_m.sort_by(f64::total_cmp);
        assert!(
            lengths_m.iter().zip(sides_m).all(|(seen_m, side_m)| side_m - 1.2 < *seen_m && *seen_m < side_m + 1e-6)
        );
    }
}

#[test]
fn a_scanner_that_turns_the_other_way_sees_the_same_lines() {
    let pose = [2.0, 1.5, 0.3];
    let reading = scan(pose, SIDES, 0.0, 0.0);
    let Reading::Other { measured_s, arrived_s, device, mut numbers } = reading.clone() else { panic!("no scan") };
    numbers[0] += (BEAMS - 1) as f64 * numbers[1];
    numbers[1] = -numbers[1];
    numbers[2..].reverse();
    let (lines, _) = lines_of(&room(""), &reading);
    let (reversed, plan) = lines_of(&room(""), &Reading::Other { measured_s, arrived_s, device, numbers });
    assert_eq!(reversed.len(), lines.len());
    for line in &reversed {
        let met = plan.met(line, pose).unwrap();
        assert!(met.turn_rad.abs() < 5e-4 && met.off_m.abs() < 5e-4, "{met:?}");
    }
}

#[test]
fn the_errors_of_distances_average_out_over_the_beams_of_a_line_and_those_of_the_scan_do_not() {
    let scene = room("tolerance_m = 0.03\nangle_tolerance_deg = 0.0\nstamp_tolerance_s = 0.0\nheight_m = 0.2");
    let (lines, plan) = lines_of(&scene, &scan([3.0, 2.0, -MOUNT[2]], SIDES, 0.0, 0.0));
    let line = lines.iter().find(|line| plan.met(line, [3.0, 2.0, -MOUNT[2]]).unwrap().normal[0] < -0.9).unwrap();
    // The scanner looks along x. The beams 1°, 3°, 5° and so on to either side meet the wall at x = 6; those to its corners are left out by the test.
    let [dx, dy] = turned([MOUNT[0], MOUNT[1]], -MOUNT[2]);
    let (far_m, corners_m) = (3.0 - dx, [-2.0 - dy, 2.0 - dy]);
    let bearings = (-45..45).map(|index| f64::to_radians(2.0 * f64::from(index) + 1.0));
    let met: Vec<f64> = bearings.filter(|at| (corners_m[0]..corners_m[1]).contains(&(far_m * at.tan()))).collect();
    let n_beams = met.len() as f64;
    let middle_m = met.iter().map(|at| far_m * at.tan()).sum::<f64>() / n_beams;
    let (mut off, mut turn, mut squares) = (0.0, 0.0, 0.0);
    for at in &met {
        let (moved_m, along_m) = (0.01 * at.cos(), far_m * at.tan() - middle_m);
        off += (moved_m / n_beams).powi(2);
        turn += (moved_m * along_m).powi(2);
        squares += along_m * along_m;
    }
    // A third of what the lean moves a scanner 0.2 m up; its arm and the shortened distances are too small to count.
    let leant_m = 0.2 * scene.robot_model().body.tilt_rad.sin() / 3.0;
    let [turn_rad, off_m] = [turn.sqrt() / squares, (off + leant_m * leant_m).sqrt()];
    assert!((line.sigma[0] / turn_rad - 1.0).abs() < 0.05, "{} {turn_rad}", line.sigma[0]);
    assert!((line.sigma[1] / off_m - 1.0).abs() < 0.05, "{} {off_m}", line.sigma[1]);
    assert!(off_m < 0.5 * 0.01, "{n_beams} beams");
}

#[test]
fn noise_within_the_bound_cuts_no_wall_and_corners_do() {
    let scene = room("tolerance_m = 0.03");
    let Reading::Other { measured_s, arrived_s, device, mut numbers } = scan([2.0, 1.5, 0.0], SIDES, 0.0, 0.0) else {
        panic!()
    };
    numbers.iter_mut().skip(2).enumerate().for_each(|(beam, at_m)| *at_m += if beam % 2 == 0 { 0.03 } else { -0.03 });
    let (lines, plan) = lines_of(&scene, &Reading::Other { measured_s, arrived_s, device, numbers });
    assert!((4..=5).contains(&lines.len()), "{lines:?}");
    for line in &lines {
        let met = plan.met(line, [2.0, 1.5, 0.0]).unwrap();
        assert!(met.turn_rad.abs() < 3.0 * line.sigma[0] && met.off_m.abs() < 0.01, "{met:?} {line:?}");
    }
}

#[test]
fn no_line_is_made_of_single_beams_gaps_and_bends() {
    let scene = room("");
    let n_lines = |distances: &dyn Fn(f64) -> f64| {
        let numbers =
            [-0.5, 0.02].into_iter().chain((0..50).map(|beam| distances(-0.5 + 0.02 * f64::from(beam)))).collect();
        let device = wall_ranges::DEVICE.to_owned();
        let reading = Reading::Other { measured_s: 0.0, arrived_s: 0.0, device, numbers };
        Cues::new(&scene, &scene.map(), &scene.robot_model()).take(&reading).map_or(0, |told| match told {
            Told::Seen(_, _, Seen::Lines(lines)) => lines.len(),
            _ => 0,
        })
    };
    let wall = |at: f64| 2.0 / at.cos();
    assert_eq!(n_lines(&wall), 1);
    // Each second beam goes through a fence; all but five beams meet nothing; all beams meet a curtain.
    assert_eq!(n_lines(&|at| if (at * 50.0).round() % 2.0 == 0.0 { wall(at) } else { 5.0 }), 0);
    assert_eq!(n_lines(&|at| if at.abs() < 0.05 { wall(at) } else { -1.0 }), 0);
    assert_eq!(n_lines(&|at| 1.0 + 0.2 * (40.0 * at).sin()), 0);
    // A doorway parts a wall.
    assert_eq!(n_lines(&|at| if at.abs() < 0.1 { 4.0 / at.cos() } else { wall(at) }), 3);
}

#[test]
fn either_cause_of_a_walls_displacement_may_use_up_the_bound() {
    let pose = [2.5, 1.5, 0.1];
    let (lines, plan) = lines_of(&room(""), &scan(pose, SIDES, 0.0, 0.0));
    let sigma_m2 = 0.004_f64.powi(2);
    for line in &lines {
        let met = plan.met(line, pose).unwrap();
        let (by, [from, to], length_m) = (plan.displaced(&met), met.shares, met.length_m);
        assert!((from + to - 1.0).abs() < 1e-9 && (length_m == 6.0 || length_m == 4.0));
        // A third of 12 mm for either end by itself; for the shift of the plan; and for the corners by its turn about the middle of the room, √13 m
        // from them, where the place along the wall counts as measured from there.
        let [along_m, far_m2] = [(to - 0.5) * length_m, 13.0];
        let off_m2 = sigma_m2 * (from * from + to * to + 1.0 + along_m * along_m / far_m2);
        let turn_rad2 = sigma_m2 * (2.0 / (length_m * length_m) + 1.0 / far_m2);
        let both = sigma_m2 * ((to - from) / length_m + along_m / far_m2);
        assert!((by[(1, 1)] - off_m2).abs() < 1e-11 && (by[(0, 0)] - turn_rad2).abs() < 1e-11, "{by} {met:?}");
        assert!((by[(0, 1)] - both).abs() < 1e-11 && by[(0, 1)] == by[(1, 0)], "{by} {both}");
    }
}

#[test]
fn a_plan_that_lies_askew_looks_like_a_robot_elsewhere() {
    // The walls are 1 cm farther along x and 2 cm along y, and turned by a quarter about the middle at (3, 2): seen from 1 m beside that middle, the
    // walls are where they would be seen from 1 m beside it in the direction a quarter back. To first order in the turn, here 0.01 rad.
    let (_, plan) = lines_of(&room(""), &scan([2.0, 1.5, 0.0], SIDES, 0.0, 0.0));
    let [x_m, y_m, heading_rad] = plan.seen_from([4.0, 2.0, FRAC_PI_2], [0.01, 0.02, 0.01]);
    assert!((x_m - 3.99).abs() < 1e-12 && (y_m - (2.0 - 0.02 - 0.01)).abs() < 1e-12);
    assert!((heading_rad - (FRAC_PI_2 - 0.01)).abs() < 1e-12);
}

#[test]
fn a_line_that_may_be_another_wall_or_furniture_tells_nothing_and_a_wall_does() {
    let (scene, pose) = (room(""), [2.0, 1.5, 0.4]);
    let known = Matrix3::from_diagonal_element(1e-4);
    let told = |box_m: f64, covariance: &Matrix3<f64>| {
        let cues = CueReader::of(&scene).read(&scan(pose, SIDES, box_m, 0.0));
        assert!(cues.iter().all(|cue| cue.kind() == "line"));
        (cues.iter().filter(|cue| cue.compare(pose, covariance).is_some()).count(), cues.len())
    };
    let (all, n_lines) = told(0.0, &known);
    assert_eq!(all, n_lines);
    // Furniture 0.2 m before one wall is twenty standard deviations of the pose away from it.
    let (without_one, n_lines) = told(0.2, &known);
    assert_eq!(without_one, n_lines - 1);
    // A partition 1.05 m before that wall, beside which the scan is: half-way is 0.525 m, which is three times 0.175 m.
    let partition =
        "[[furniture]]\nname = \"partition\"\nx_m = 5.0\ny_m = 2.0\nsize_m = [0.1, 1.0]\nheight_m = 2.5\nwall = true";
    let reading = scan(pose, SIDES, 0.0, 0.0);
    for (sigma_m, n_ambiguous) in [(0.16, 0), (0.18, 1)] {
        let covariance = Matrix3::from_diagonal(&[sigma_m * sigma_m, sigma_m * sigma_m, 1e-8].into());
        let cues = CueReader::of(&room(partition)).read(&reading);
        let told = cues.iter().filter(|cue| cue.compare(pose, &covariance).is_some()).count();
        assert_eq!(cues.len() - told, n_ambiguous, "{sigma_m}");
    }
}

#[test]
fn a_compared_line_falls_by_what_its_jacobian_says() {
    let (scene, pose) = (room(""), [2.0, 1.5, 0.4]);
    let covariance = Matrix3::from_diagonal_element(1e-3);
    for cue in CueReader::of(&scene).read(&scan(pose, SIDES, 0.0, 0.0)) {
        let before = cue.compare(pose, &covariance).unwrap();
        for axis in 0..3 {
            let mut moved = pose;
            moved[axis] += 1e-6;
            let change = (cue.compare(moved, &covariance).unwrap().residual - &before.residual) / 1e-6;
            assert!((change + before.jacobian.column(axis)).amax() < 1e-4, "along axis {axis}");
        }
        // Scanner and plan are each turned by their own errors, beside the line's and the wall's.
        let mount_rad = scene.robot.scanner.as_ref().unwrap().angle_tolerance_deg.to_radians() / 3.0;
        assert!(before.noise[(0, 0)] > mount_rad.powi(2) + (0.004 / 3.0_f64.hypot(2.0)).powi(2));
        assert!(before.noise[(1, 1)] < 0.02_f64.powi(2) && PI * before.noise.determinant() > 0.0);
    }
}
