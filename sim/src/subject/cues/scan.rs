//! Walls in the scans of a planar range scanner: the straight parts of a scan, each as a line with its errors.
//!
//! A scan is cut where neighbouring beams end far apart, each part is cut until it is straight, and a line is fitted to each that is long enough:
//! split-and-merge, which was the best of six algorithms for scans of buildings (V. Nguyen, S. Gächter, A. Martinelli, N. Tomatis, R. Siegwart, *A
//! comparison of line extraction algorithms using 2D range data for indoor mobile robotics*, Autonomous Robots 23, 2007). What a line says of a pose
//! is in the module [`super::floor_plan`], which knows the walls.
//!
//! The errors of a scan are kept apart by how long they last. Those of the distances are new in each beam, so that the more beams a line has, the
//! less of them is left in it. The lean of the body and the way within the error of the stamp are new in each scan, and displace all its beams alike.
//! The mount's position and yaw last, and are its [`Mount`]. The places of the walls last, too, and are the floor plan's.

use localizer::{
    Reading, RobotModel,
    methods::wall_ranges::{DEVICE, Scan, ScannerModel},
    motion::Twist,
    robot::BodyModel,
};
use nalgebra::Vector2;

use crate::scene::{MethodName, Scene};

use super::{Mount, SIGMAS_OF_BOUND, Seen, floor::fitted, stray, turned};

/// Walls as the scanner sees them.
pub(crate) struct Scans {
    scanner: ScannerModel,
    body: BodyModel,
}

/// A straight part of a scan in the robot frame, by the nominal mount.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Middle of the beams' ends.
    pub(crate) middle_m: [f64; 2],
    /// Direction of the line's normal towards the scanner, counter-clockwise from robot forward.
    pub(crate) normal_rad: f64,
    /// Distance from the middle to either end, about.
    pub(crate) half_m: f64,
    /// Standard deviations of the direction, and of the middle's place along the normal.
    pub(crate) sigma: [f64; 2],
}

/// Where one beam ended, and the direction that it came.
#[derive(Clone, Copy)]
struct End {
    beam: usize,
    at: Vector2<f64>,
    toward: Vector2<f64>,
    distance_m: f64,
}

/// Least angle between a beam and a wall for the ends of neighbouring beams to be taken for points of one wall: the λ of G. Borges, M.-J. Aldon,
/// *Line extraction in 2D range images for mobile robotics*, Journal of Intelligent and Robotic Systems 40 (2004), which has 10° too.
const LEAST_INCIDENCE_RAD: f64 = 0.1745;
/// Bend in metres that is none: far above rounding, far below what a scanner notices.
const STRAIGHT_M: f64 = 1e-4;
/// Least number and least length in metres of the points of a line. A shorter one is a leg, a corner or a box as often as a wall.
const FEWEST_POINTS: usize = 6;
const SHORTEST_M: f64 = 0.3;
/// Distance from a first fit, over the bound on distances, beyond which a point is left out: half as much again as the bound, for the error of that
/// fit.
const FIRST_FIT: f64 = 1.5;
/// Share of the points of a straight part that must be near a first fit: more are off only where it is bent.
const STRAIGHT_SHARE: f64 = 0.75;
/// Least standard deviation of a line's direction and place, so that a scanner that is stated to be exact makes no singular covariance.
const LEAST_SIGMA: f64 = 1e-5;

impl Scans {
    /// The scans of a scene whose localizer locates the robot by them.
    pub(crate) fn new(robot: &RobotModel, scene: &Scene) -> Option<Scans> {
        let keys = scene.robot.scanner.as_ref()?;
        let is_used = scene.localizer.methods.contains(&MethodName::WallRanges);
        is_used.then(|| Scans { scanner: keys.model(scene), body: robot.body })
    }

    /// Position and yaw of the scanner.
    pub(crate) fn mount(&self) -> Mount {
        let half = |of: interval::Interval| SIGMAS_OF_BOUND * 0.5 * of.width();
        let [forward, left] = self.scanner.position_m;
        Mount { sigma: [half(forward), half(left), half(self.scanner.yaw_rad)] }
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let Reading::Other { device, numbers, .. } = reading else { return None };
        let scan = Scan::of(numbers).filter(|_| device == DEVICE)?;
        let ends = self.ends(&scan);
        let runs = ends.chunk_by(|one, next| self.are_neighbours(one, next, scan.step_rad.abs()));
        let mut lines: Vec<Line> =
            runs.flat_map(|run| self.straight(run)).filter_map(|part| self.line(part, twist)).collect();
        // Long lines are mostly walls, and make the pose known by which furniture is told from them.
        lines.sort_by(|one, other| other.half_m.total_cmp(&one.half_m));
        Some(Seen::Lines(lines))
    }

    /// Where the beams that met something ended, in the robot frame.
    fn ends(&self, scan: &Scan) -> Vec<End> {
        let scanner = &self.scanner;
        let mount_m = Vector2::from(scanner.position_m.map(|side| side.mid()));
        let end = |(beam, distance_m): (usize, &Option<f64>)| {
            let distance_m = (*distance_m)?;
            let bearing_rad = scan.first_rad + beam as f64 * scan.step_rad + scanner.yaw_rad.mid();
            let toward = Vector2::from(turned([1.0, 0.0], bearing_rad));
            Some(End { beam, at: mount_m + toward * distance_m, toward, distance_m })
        };
        scan.distances_m.iter().enumerate().filter_map(end).collect()
    }

    /// Whether two beams are neighbours whose ends may be points of one wall (adaptive breakpoint detector of Borges and Aldon, eq. 2). `step_rad` is
    /// the angle between neighbouring beams, whichever way the scanner turns. Beams that are [`LEAST_INCIDENCE_RAD`] or more apart have no neighbours.
    fn are_neighbours(&self, one: &End, next: &End, step_rad: f64) -> bool {
        let least_rad = LEAST_INCIDENCE_RAD - step_rad;
        let most_m = one.distance_m * step_rad.sin() / least_rad.sin() + self.scanner.range_error_m;
        next.beam == one.beam + 1 && least_rad > 0.0 && (next.at - one.at).norm() <= most_m
    }

    /// The straight parts of a run of neighbouring ends: cut into such parts, of which those are put together again that are one.
    fn straight<'a>(&self, run: &'a [End]) -> Vec<&'a [End]> {
        let (mut whole, mut from, mut to) = (Vec::new(), 0, 0);
        for n_ends in self.cut(run) {
            if !self.is_straight(&run[from..to + n_ends]) {
                whole.push(&run[from..to]);
                from = to;
            }
            to += n_ends;
        }
        whole.push(&run[from..to]);
        whole
    }

    /// Numbers of ends in the parts of a run that is cut at the end farthest from the chord until none is farther than errors of the distances can
    /// move it from there (iterative end-point fit).
    fn cut(&self, run: &[End]) -> Vec<usize> {
        match self.corner(run) {
            Some(corner) => [self.cut(&run[..=corner]), self.cut(&run[corner + 1..])].concat(),
            None => vec![run.len()],
        }
    }

    fn is_straight(&self, run: &[End]) -> bool {
        self.corner(run).is_none()
    }

    /// Index of the end farthest from the chord between the first and the last, if the run is not straight.
    fn corner(&self, run: &[End]) -> Option<usize> {
        let [first, .., last] = run else { return None };
        let chord = (last.at - first.at).normalize();
        let off_m = |index: usize| chord.perp(&(run[index].at - first.at)).abs();
        let farthest = (1..run.len() - 1).max_by(|one, other| off_m(*one).total_cmp(&off_m(*other)))?;
        // The chord's own ends may be off by as much as what is compared with it.
        (off_m(farthest) > 2.0 * self.scanner.range_error_m + STRAIGHT_M).then_some(farthest)
    }

    /// The line through the ends of a straight part, by least squares; `None` for one that is too short or bent.
    fn line(&self, part: &[End], twist: &Twist) -> Option<Line> {
        let error_m = self.scanner.range_error_m;
        let of = |ends: &[End]| fitted(&ends.iter().map(|end| end.at).collect::<Vec<_>>());
        let (first_middle, first_normal) = of(part)?;
        // The outermost ends may belong to what stands beside.
        let most_m = FIRST_FIT * error_m + STRAIGHT_M;
        let is_near = |end: &&End| (end.at - first_middle).dot(&first_normal).abs() <= most_m;
        let ends: Vec<End> = part.iter().filter(is_near).copied().collect();
        if ends.len() < FEWEST_POINTS || (ends.len() as f64) < STRAIGHT_SHARE * part.len() as f64 {
            return None;
        }
        let (middle, normal) = of(&ends)?;
        let toward_scanner = ends.iter().map(|end| end.toward).sum::<Vector2<f64>>().dot(&normal) < 0.0;
        let normal = if toward_scanner { normal } else { -normal };
        let along = Vector2::new(-normal.y, normal.x);
        let places_m: Vec<f64> = ends.iter().map(|end| (end.at - middle).dot(&along)).collect();
        let [from_m, to_m] =
            [places_m.iter().copied().fold(0.0, f64::min), places_m.iter().copied().fold(0.0, f64::max)];
        if to_m - from_m < SHORTEST_M {
            return None;
        }
        // The error of a distance moves its end along the beam, so that at a slant little of it moves the line. As each is new, they average out.
        let off_m2 = |end: &End| (SIGMAS_OF_BOUND * error_m * end.toward.dot(&normal)).powi(2);
        let squares_m2: f64 = places_m.iter().map(|at_m| at_m * at_m).sum();
        let own_m2 = ends.iter().map(off_m2).sum::<f64>() / (ends.len() as f64).powi(2);
        let own_rad2 = ends.iter().zip(&places_m).map(|(end, at_m)| off_m2(end) * at_m * at_m).sum::<f64>();
        let own = [own_rad2.sqrt() / squares_m2, own_m2.sqrt()];
        // A lean moves the scanner aside by its height, and shortens all distances seen from above.
        let (scanner, body) = (&self.scanner, &self.body);
        let leant_m = body.most_leant_m(scanner.position_m, scanner.height_m).hi();
        let shortened_m = middle.dot(&normal).abs() * (1.0 - (body.tilt_rad + scanner.tilt_rad).cos());
        let [stray_m, stray_rad] = stray(twist, scanner.stamp_error_s);
        let common_m = SIGMAS_OF_BOUND * leant_m.hypot(shortened_m);
        let off_m = [own[1], common_m, stray_m, stray_rad * middle.dot(&along), LEAST_SIGMA];
        let sigma = [own[0].hypot(stray_rad).hypot(LEAST_SIGMA), off_m.into_iter().fold(0.0, f64::hypot)];
        Some(Line {
            middle_m: middle.into(),
            normal_rad: normal.y.atan2(normal.x),
            half_m: 0.5 * (to_m - from_m),
            sigma,
        })
    }
}
