//! Scans of rooms and furniture that are made here, by rays that are met by hand, against what the method leaves of boxes around the true pose.

use super::*;
use crate::{
    PoseUnion,
    graph::trial::{self, Draw, rounds},
    map::Wall,
    robot::{BodyModel, Reach},
};

/// A segment that stops beams from both sides: its ends.
type Segment = [[f64; 2]; 2];

/// Distance along a ray to a segment, by Cramer's rule.
fn met_at_m(eye: [f64; 2], direction_rad: f64, [from, to]: Segment) -> Option<f64> {
    let (dx, dy) = (direction_rad.cos(), direction_rad.sin());
    let (wx, wy) = (to[0] - from[0], to[1] - from[1]);
    let det = dx * -wy - dy * -wx;
    let (px, py) = (from[0] - eye[0], from[1] - eye[1]);
    let (along_m, share) = ((px * -wy - py * -wx) / det, (dx * py - dy * px) / det);
    (along_m > 0.0 && (0.0..=1.0).contains(&share)).then_some(along_m)
}

/// The sides of a rectangle, turned about its middle, with their left sides inside or outside.
fn rectangle(middle: [f64; 2], size: [f64; 2], turn_rad: f64, inside: bool) -> Vec<Segment> {
    let corner = |x: f64, y: f64| {
        let (x, y) = (0.5 * x * size[0], 0.5 * y * size[1]);
        let (sin, cos) = turn_rad.sin_cos();
        [middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y]
    };
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let side = |index: usize| [corners[index], corners[(index + 1) % 4]];
    (0..4).map(side).map(|[from, to]| if inside { [from, to] } else { [to, from] }).collect()
}

fn robot(tilt_rad: f64) -> RobotModel {
    RobotModel {
        reach: Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 2.0, acceleration_m_per_s2: 1.0 },
        body: BodyModel { tilt_rad, heave_m: 0.0, clearance_m: 0.0 },
        ..trial::robot()
    }
}

/// A room with a free wall in it, furniture that is on no map, and a scanner, with all errors at an end of their bound or within it.
struct Trial {
    robot: RobotModel,
    scanner: ScannerModel,
    walls: WallMap,
    pose: [f64; 3],
    scan: Scan,
    /// Number of beams that end at no wall.
    n_wrong: usize,
}

impl Trial {
    fn new(draw: &mut Draw, n_furniture: usize) -> Trial {
        let (width_m, depth_m) = (draw.between(3.0, 9.0), draw.between(3.0, 9.0));
        let room_rad = draw.between(-3.0, 3.0);
        let middle = [draw.between(-5.0, 5.0), draw.between(-5.0, 5.0)];
        let placement_m = draw.size(1e-6, 0.03);
        let mut mapped = rectangle(middle, [width_m, depth_m], room_rad, true);
        // The free wall stands in the part of the room with lower x, the robot in the other.
        let free_m = [middle[0] - draw.between(0.3, 0.5), middle[1] + draw.between(-0.6, 0.6)];
        mapped.extend(rectangle(free_m, [0.1, draw.between(0.3, 1.0)], draw.between(-0.2, 0.2), false));
        // The true walls are the mapped ones with their corners moved to within the placement, each corner for both of its walls.
        let mut corners: Vec<[[f64; 2]; 2]> = Vec::new();
        let mut moved = |[x_m, y_m]: [f64; 2]| {
            if let Some([_, moved_m]) = corners.iter().find(|[mapped_m, _]| *mapped_m == [x_m, y_m]) {
                return *moved_m;
            }
            let (far_m, to_rad) = (placement_m * draw.between(0.7, 1.0), draw.between(-3.2, 3.2));
            let moved_m = [x_m + far_m * to_rad.cos(), y_m + far_m * to_rad.sin()];
            corners.push([[x_m, y_m], moved_m]);
            moved_m
        };
        let walls: Vec<Segment> = mapped.iter().map(|ends| ends.map(&mut moved)).collect();
        let furniture: Vec<Segment> = (0..n_furniture)
            .flat_map(|_| {
                let at = [0, 1].map(|axis| middle[axis] + draw.between(-3.0, 3.0));
                rectangle(at, [draw.between(0.1, 0.8), draw.between(0.1, 0.8)], draw.between(-3.0, 3.0), false)
            })
            .collect();
        let within_m = 0.4 * width_m.min(depth_m);
        let pose = [
            middle[0] + draw.between(0.2, within_m),
            middle[1] + draw.between(-0.5, 0.5) * within_m,
            draw.between(-4.0, 4.0),
        ];
        let (body_rad, tilt_rad) = (draw.size(1e-6, 0.02), draw.size(1e-6, 0.02));
        let mount = [0, 1].map(|_| {
            let half_m = draw.size(1e-6, 0.01);
            Interval::centred(draw.between(-0.2, 0.2), half_m)
        });
        let yaw = Interval::centred(draw.between(-3.0, 3.0), draw.size(1e-6, 0.01));
        let scanner = ScannerModel {
            position_m: mount,
            height_m: 0.3,
            yaw_rad: yaw,
            tilt_rad,
            range_error_m: draw.size(1e-6, 0.05),
            stamp_error_s: draw.size(1e-6, 0.002),
        };
        // The true scan: seen from above, a lean by φ about an axis moves the scanner by its height times sin φ across that axis, and shortens what
        // is across it by cos φ.
        let true_mount = mount.map(|side| draw.within(side));
        let true_yaw_rad = draw.within(yaw);
        let lean_rad = body_rad;
        let axis_rad = draw.between(-3.2, 3.2);
        let leant = |[x, y]: [f64; 2], up: f64, by_rad: f64| {
            let (sin, cos) = axis_rad.sin_cos();
            let (along, across) = (cos * x + sin * y, cos * y - sin * x);
            let across = across * by_rad.cos() + up * by_rad.sin();
            [cos * along - sin * across, sin * along + cos * across]
        };
        let later_s = draw.within(Interval::centred(0.0, scanner.stamp_error_s));
        let at = [pose[0] + later_s * 0.7, pose[1] - later_s * 0.7, pose[2] + 2.0 * later_s];
        let in_world = |[x, y]: [f64; 2], from: [f64; 2]| {
            let (sin, cos) = at[2].sin_cos();
            [from[0] + cos * x - sin * y, from[1] + sin * x + cos * y]
        };
        let eye = in_world(leant(true_mount, scanner.height_m, lean_rad), [at[0], at[1]]);
        let mut n_wrong = 0;
        let n_beams = 72;
        let step_rad = std::f64::consts::TAU / n_beams as f64;
        let first_rad = -std::f64::consts::PI;
        let distances_m = (0..n_beams)
            .map(|index| {
                let bearing_rad = true_yaw_rad + first_rad + index as f64 * step_rad;
                let level = leant([bearing_rad.cos(), bearing_rad.sin()], 0.0, lean_rad + tilt_rad);
                let [x, y] = in_world(level, [0.0, 0.0]);
                let (direction_rad, shortened) = (y.atan2(x), x.hypot(y));
                let nearest = |of: &[Segment]| {
                    let met = of.iter().filter_map(|one| met_at_m(eye, direction_rad, *one));
                    met.fold(f64::INFINITY, f64::min)
                };
                let (wall_m, thing_m) = (nearest(&walls), nearest(&furniture));
                let true_m = wall_m.min(thing_m);
                n_wrong += usize::from(thing_m < wall_m);
                let error_m = draw.within(Interval::centred(0.0, scanner.range_error_m));
                true_m.is_finite().then_some((true_m / shortened + error_m).max(0.0))
            })
            .collect();
        Trial {
            robot: robot(body_rad),
            scanner,
            walls: WallMap { walls: mapped.into_iter().map(|ends_m| Wall { ends_m }).collect(), placement_m },
            pose,
            scan: Scan { first_rad, step_rad, distances_m },
            n_wrong,
        }
    }

    /// What the method's constraint leaves of a box.
    fn left(&self, domain: PoseBox, wrong_share: Option<f64>) -> PoseUnion {
        let mut method = WallRanges::new(self.scanner, &self.walls, wrong_share, &self.robot);
        let prior = PoseUnion::single(domain);
        let numbers = self.scan.numbers();
        let reading = Reading::Other { measured_s: 1.0, arrived_s: 1.0, device: DEVICE.to_owned(), numbers };
        let constraint = method.constrain(&reading, &Context::at_rest(&prior));
        constraint.map_or(prior.clone(), |constraint| prior.contracted(&*constraint.on_pose))
    }

    fn contains(&self, left: &PoseUnion) -> bool {
        left.branches.iter().any(|branch| branch.contains(&self.pose))
    }

    /// A box around the true pose, which lies anywhere in it.
    fn around(&self, draw: &mut Draw, half: [f64; 3]) -> PoseBox {
        let side = |axis: usize| {
            let off = half[axis] * draw.between(-1.0, 1.0);
            Interval::centred(self.pose[axis] + off, half[axis] * (1.0 + 1e-9))
        };
        PoseBox::from([0, 1, 2].map(side))
    }
}

#[test]
fn no_true_pose_is_lost_among_walls_and_furniture() {
    let mut draw = Draw::new(20_261_126);
    let (mut n_narrowed, mut n_both) = (0, 0);
    for round in 0..rounds(4_000) {
        let trial = Trial::new(&mut draw, round % 6);
        let half = [draw.size(0.005, 0.6), draw.size(0.005, 0.6), draw.size(0.001, 0.3)];
        let domain = trial.around(&mut draw, half);
        let left = trial.left(domain, None);
        assert!(trial.contains(&left), "round {round}: {:?} is not in {left:?} of {domain:?}", trial.pose);
        let n_echoes = trial.scan.echoes().count();
        let share = trial.n_wrong as f64 / n_echoes as f64;
        let by_most = trial.left(domain, Some(share));
        assert!(trial.contains(&by_most), "round {round}, most: {:?} is not in {by_most:?} of {domain:?}", trial.pose);
        let width = |union: &PoseUnion| union.hull().width(0) + union.hull().width(1);
        n_narrowed += usize::from(width(&left) < 0.7 * (domain.width(0) + domain.width(1)));
        n_both += usize::from(width(&by_most) < 0.9 * width(&left));
    }
    // Both rules narrow many of the boxes, the second one more than the first alone where they are not too wide for it.
    assert!(n_narrowed > rounds(4_000) / 4 && n_both > rounds(4_000) / 16, "{n_narrowed} and {n_both}");
}

/// A scan from the middle of a room of 6 m by 4 m, without any error.
fn in_a_room() -> (ScannerModel, WallMap, Vec<Segment>) {
    let scanner = ScannerModel {
        position_m: [Interval::ZERO; 2],
        height_m: 0.2,
        yaw_rad: Interval::ZERO,
        tilt_rad: 0.0,
        range_error_m: 0.01,
        stamp_error_s: 0.0,
    };
    let sides = rectangle([3.0, 2.0], [6.0, 4.0], 0.0, true);
    let walls = sides.iter().map(|ends_m| Wall { ends_m: *ends_m }).collect();
    (scanner, WallMap { walls, placement_m: 0.005 }, sides)
}

fn scan_of(segments: &[Segment], eye: [f64; 2]) -> Scan {
    let nearest = |index: usize| {
        let met = segments.iter().filter_map(|one| met_at_m(eye, f64::to_radians(4.0 * index as f64) - 3.0, *one));
        Some(met.fold(f64::INFINITY, f64::min)).filter(|at_m| at_m.is_finite())
    };
    Scan { first_rad: -3.0, step_rad: f64::to_radians(4.0), distances_m: (0..90).map(nearest).collect() }
}

#[test]
fn a_scan_bounds_the_place_as_tightly_as_its_errors_allow() {
    let (scanner, walls, sides) = in_a_room();
    let scan = scan_of(&sides, [2.0, 1.5]);
    let trial = Trial { robot: robot(0.0), scanner, walls, pose: [2.0, 1.5, 0.0], scan, n_wrong: 0 };
    let domain = PoseBox::from([Interval::centred(2.05, 0.1), Interval::centred(1.45, 0.1), Interval::point(0.0)]);
    for wrong_share in [None, Some(0.0)] {
        let left = trial.left(domain, wrong_share).hull();
        // At a known heading each wall bounds its side to ±15 mm: 10 mm for the distance, 5 mm for the wall. Of a slanting beam's error only a part
        // counts, of the wall's none is lost.
        for axis in 0..2 {
            assert!(left.width(axis) < 0.0301 && left.width(axis) > 0.01, "{axis}: {}", left[axis]);
        }
    }
}

#[test]
fn beams_that_slant_to_both_sides_bound_the_place_though_the_heading_is_uncertain() {
    let (scanner, walls, sides) = in_a_room();
    let scan = scan_of(&sides, [2.0, 1.5]);
    let trial = Trial { robot: robot(0.0), scanner, walls, pose: [2.0, 1.5, 0.0], scan, n_wrong: 0 };
    let heading = Interval::centred(0.0, f64::to_radians(1.7));
    let domain = PoseBox::from([Interval::centred(2.05, 0.1), Interval::centred(1.45, 0.1), heading]);
    let left = trial.left(domain, None).hull();
    // At 1.7° the beam to the wall at x = 6 that is 20° off its normal ends up to 40 mm nearer or farther, and so does the one on the other side, the
    // other way round. Together they leave as much of the place as at a known heading, and bound the heading too.
    assert!(left.width(0) < 0.04 && left.width(1) < 0.04, "{left:?}");
    assert!(left.width(2).to_degrees() < 1.5 && left.contains(&trial.pose), "{}", left.width(2).to_degrees());
}

#[test]
fn furniture_before_one_wall_leaves_the_place_open_unless_most_beams_end_at_walls() {
    let (scanner, walls, mut segments) = in_a_room();
    // A row of shelves along the whole wall at x = 0, which the map does not have. More beams end at the wall at x = 6, which is nearer.
    segments.push([[0.4, 0.0], [0.4, 4.0]]);
    let scan = scan_of(&segments, [4.5, 1.5]);
    let n_wrong = scan.echoes().filter(|(at_rad, far_m)| far_m * at_rad.cos() < -4.05).count();
    let trial = Trial { robot: robot(0.0), scanner, walls, pose: [4.5, 1.5, 0.0], scan, n_wrong };
    let domain = PoseBox::from([Interval::centred(4.42, 0.12), Interval::centred(1.5, 0.1), Interval::point(0.0)]);
    let by_no_passing = trial.left(domain, None).hull();
    // The wall at x = 6 lets the robot be at most 15 mm farther along x; the shelves let it be 0.4 m nearer to the other wall.
    let farthest_m = by_no_passing[0].hi();
    assert!(farthest_m > 4.505 && farthest_m < 4.5151 && by_no_passing[0].lo() < 4.31, "{}", by_no_passing[0]);
    let share = n_wrong as f64 / trial.scan.echoes().count() as f64;
    let by_most = trial.left(domain, Some(share)).hull();
    assert!(by_most.width(0) < 0.035 && by_most.contains(&trial.pose), "{}", by_most[0]);
    // A smaller share than the true one excludes every pose.
    assert!(trial.left(domain, Some(0.5 * share)).is_empty());
}

#[test]
fn a_beam_through_a_door_says_nothing_of_the_wall_beside_it() {
    let (scanner, mut walls, _) = in_a_room();
    // The wall at x = 6 has a door from y = 1 to y = 3, behind which is another wall at x = 8.
    walls.walls.retain(|wall| wall.ends_m.iter().any(|end| end[0] < 5.9));
    let segments = [[[6.0, 0.0], [6.0, 1.0]], [[6.0, 3.0], [6.0, 4.0]], [[8.0, -2.0], [8.0, 6.0]]];
    walls.walls.extend(segments.map(|ends_m| Wall { ends_m }));
    let all: Vec<Segment> = walls.walls.iter().map(|wall| wall.ends_m).collect();
    let scan = scan_of(&all, [3.0, 2.0]);
    let farthest_m = scan.echoes().map(|(_, far_m)| far_m).fold(0.0, f64::max);
    assert!(farthest_m > 4.9, "{farthest_m}");
    let trial = Trial { robot: robot(0.0), scanner, walls, pose: [3.0, 2.0, 0.0], scan, n_wrong: 0 };
    let domain =
        PoseBox::from([Interval::centred(3.0, 0.1), Interval::centred(2.0, 0.1), Interval::centred(0.0, 0.02)]);
    for wrong_share in [None, Some(0.0)] {
        let left = trial.left(domain, wrong_share);
        assert!(trial.contains(&left) && left.hull().width(0) < 0.08, "{left:?}");
    }
}

#[test]
fn numbers_that_are_no_scan_are_refused() {
    let scan = Scan { first_rad: -1.0, step_rad: 0.5, distances_m: vec![Some(1.0), None, Some(0.0)] };
    assert_eq!(Scan::of(&scan.numbers()), Some(scan));
    for numbers in [&[][..], &[0.0], &[0.0, f64::NAN, 1.0], &[0.0, 0.1, f64::INFINITY]] {
        assert_eq!(Scan::of(numbers), None, "{numbers:?}");
    }
    assert!(Scan::of(&[0.0, 0.1]).is_some_and(|scan| scan.echoes().next().is_none()));
}
