//! Simulated drives past landmarks that no map contains: poses and landmarks contract each other, and the box of neither ever loses the truth.

use std::collections::BTreeMap;

use interval::{Interval, IntervalBox};
use localizer::{
    Claim, Method, PoseUnion, Reading,
    method::{Context, Memory},
    methods::range_landmarks::{Freedom, RangeLandmarks, Solver},
    motion::moved_union,
    reading::LandmarkId,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::command::rounds;
use crate::range_landmarks_setup::{
    Confusion, Landmark, TrueCamera, box_around, corner, landmarks, measured, random, robot,
};

const STEP_S: f64 = 0.1;
/// Bound on the error of the odometry's motion between two readings, to either side: forward and left in metres, turn in radians.
const ODOMETRY: [f64; 3] = [0.002, 0.002, 0.003];

/// True path of the robot: a circle driven again and again, or a line driven to and fro when `turn_rad_per_s` is 0.
struct Path {
    start: [f64; 3],
    speed_m_per_s: f64,
    turn_rad_per_s: f64,
}

impl Path {
    fn pose(&self, time_s: f64) -> [f64; 3] {
        let [x_m, y_m, heading_rad] = self.start;
        if self.turn_rad_per_s == 0.0 {
            let along_m = 1.5 * (self.speed_m_per_s / 1.5 * time_s).sin();
            return [x_m + along_m * heading_rad.cos(), y_m + along_m * heading_rad.sin(), heading_rad];
        }
        let (radius_m, turned_rad) = (self.speed_m_per_s / self.turn_rad_per_s, self.turn_rad_per_s * time_s);
        let end_rad = heading_rad + turned_rad;
        [
            x_m + radius_m * (end_rad.sin() - heading_rad.sin()),
            y_m - radius_m * (end_rad.cos() - heading_rad.cos()),
            end_rad,
        ]
    }
}

/// A simulated drive in progress. The test itself does what the localizer would do: it carries the box of the pose forward by odometry and calls the
/// method for landmarks with each reading.
struct Drive {
    path: Path,
    camera: TrueCamera,
    marks: Vec<Landmark>,
    confusion: Confusion,
    q_items: usize,
    method: RangeLandmarks,
    pose: PoseUnion,
    time_s: f64,
    n_false: usize,
    rng: ChaCha8Rng,
}

impl Drive {
    fn new(
        (freedom, solver): Setup,
        [q_items, wrong_spacing]: [usize; 2],
        path: Path,
        n_marks: u32,
        mut rng: ChaCha8Rng,
    ) -> Self {
        let start = box_around(path.start, [1e-4, 1e-4, 1e-4], &mut rng);
        Drive {
            camera: TrueCamera::drawn(&mut rng),
            marks: landmarks(n_marks, 4.0, &mut rng),
            confusion: Confusion::new(q_items, wrong_spacing),
            q_items,
            method: RangeLandmarks::new(&robot(q_items, wrong_spacing), freedom, solver).expect("a range camera"),
            pose: PoseUnion::single(start),
            time_s: 0.0,
            n_false: 0,
            path,
            rng,
        }
    }

    /// A reading of the range camera with the current time as its stamp. The landmarks are seen from the robot's pose at most 1 ms before or after
    /// that stamp.
    fn reading(&mut self) -> Reading {
        let seen_from = self.path.pose(self.time_s + 0.001 * corner(&mut self.rng));
        let mut sightings: Vec<_> =
            self.marks.iter().filter_map(|mark| self.camera.sight(seen_from, mark, &mut self.rng)).collect();
        let codes: Vec<_> = self.marks.iter().map(|mark| mark.code).collect();
        self.confusion.confuse(&mut sightings, &codes, 0.2, &mut self.rng);
        Reading::Range { measured_s: self.time_s, arrived_s: self.time_s, sightings }
    }

    /// Advances the simulated drive by one reading of the range camera, and checks the boxes of pose and landmarks and the number of false claims.
    fn step(&mut self) {
        if self.time_s > 0.0 {
            let (before, after) = (self.path.pose(self.time_s - STEP_S), self.path.pose(self.time_s));
            let (sine, cosine) = before[2].sin_cos();
            let (across, along) = (after[0] - before[0], after[1] - before[1]);
            let motion = [cosine * across + sine * along, cosine * along - sine * across, after[2] - before[2]];
            let told =
                IntervalBox::from(std::array::from_fn(|axis| measured(motion[axis], ODOMETRY[axis], &mut self.rng)));
            self.pose = moved_union(&self.pose, &told);
        }
        let known = self.places();
        let reading = self.reading();
        if let Some(constraint) = self.method.constrain(&reading, &Context::at_rest(&self.pose)) {
            self.judge(&constraint.claims);
            let branches = self.pose.branches.iter().flat_map(|branch| constraint.on_pose.branches(branch)).collect();
            self.pose = PoseUnion { branches }.without_repeats();
            self.method.learn(&constraint.shown.unwrap(), Some(&self.pose));
        }
        let truth = self.path.pose(self.time_s);
        assert!(
            self.pose.branches.iter().any(|branch| branch.contains(&truth)),
            "{truth:?} lost at {} s, {:?} left",
            self.time_s,
            self.pose
        );
        self.compare(&known);
        self.time_s += STEP_S;
    }

    /// Checks the claims that the method makes about a reading (which landmark is where): at most the declared number of them is false. Counts the
    /// false ones.
    fn judge(&mut self, claims: &[Claim]) {
        let [x_m, y_m, heading_rad] = self.path.pose(self.time_s);
        let (sine, cosine) = heading_rad.sin_cos();
        let is_false = |claim: &&Claim| {
            let Claim::Landmark { landmark, in_robot_m } = claim else { return true };
            let [mark_x, mark_y] = self.marks[landmark.0 as usize].xy();
            let (across, along) = (mark_x - x_m, mark_y - y_m);
            !(in_robot_m[0].contains(cosine * across + sine * along)
                && in_robot_m[1].contains(cosine * along - sine * across))
        };
        let n_false = claims.iter().filter(is_false).count();
        assert!(n_false <= self.q_items, "{n_false} false claims at {} s", self.time_s);
        self.n_false += n_false;
    }

    fn places(&self) -> BTreeMap<LandmarkId, [Interval; 2]> {
        self.method.landmarks().into_iter().collect()
    }

    /// Checks that the box of every known landmark contains the landmark's true position and is nowhere wider than in `before`.
    fn compare(&self, before: &BTreeMap<LandmarkId, [Interval; 2]>) {
        let now = self.places();
        for (code, place) in &now {
            let truth = self.marks[code.0 as usize].xy();
            assert!(
                place[0].contains(truth[0]) && place[1].contains(truth[1]),
                "landmark {code:?} at {truth:?} lost at {} s: {place:?}",
                self.time_s
            );
        }
        for (code, old) in before {
            let new = now.get(code).expect("a landmark is not forgotten");
            assert!((0..2).all(|axis| new[axis].is_subset_of(old[axis])), "landmark {code:?} grew");
        }
    }
}

fn circle(rng: &mut ChaCha8Rng) -> Path {
    Path {
        start: [rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5), rng.random_range(-7.0..7.0)],
        speed_m_per_s: 0.4,
        turn_rad_per_s: [-0.5, 0.5][rng.random_range(0..2)],
    }
}

/// Set-up of the method for landmarks: which coordinates of the pose it solves for, and with which solver.
type Setup = (Freedom, Solver);

fn full(solver: Solver) -> Setup {
    (Freedom::Full, solver)
}

/// Simulates drives of 60 readings each with one setup. Returns the mean width of the heading at the end and the number of false claims.
fn drives(setup: Setup, wrong: [usize; 2], n_drives: u64, seed: u64) -> (f64, usize) {
    let (mut width_rad, mut n_false) = (0.0, 0);
    for drive in 0..n_drives {
        let mut rng = random(seed + drive);
        let path = circle(&mut rng);
        let mut drive = Drive::new(setup, wrong, path, 120, rng);
        (0..60).for_each(|_| drive.step());
        width_rad += drive.pose.hull().width(2) / n_drives as f64;
        n_false += drive.n_false;
    }
    println!("{setup:?}, wrong {wrong:?}: heading known to {width_rad:.4} rad after 6 s, {n_false} claims false");
    (width_rad, n_false)
}

#[test]
fn poses_and_landmarks_keep_the_truth_with_every_solver() {
    for solver in [Solver::OneShot, Solver::Polar, Solver::TableIv, Solver::Sivia { resolution: 0.02 }] {
        let (_, n_false) = drives(full(solver), [0, 0], rounds(12, 40), 100);
        assert_eq!(n_false, 0);
    }
}

#[test]
fn poses_and_landmarks_keep_the_truth_when_correspondences_are_wrong() {
    for wrong in [[1, 3], [1, 1], [2, 4]] {
        let (_, n_false) = drives(full(Solver::OneShot), wrong, rounds(12, 40), 200);
        assert!(n_false > rounds(30, 100), "only {n_false} wrong: the test says nothing");
    }
    for solver in [Solver::Polar, Solver::TableIv] {
        drives(full(solver), [1, 3], rounds(3, 10), 300);
    }
}

#[test]
fn the_tables_without_a_turn_keep_the_truth_on_a_line_and_on_a_circle() {
    for motion in [Freedom::Line, Freedom::Translation] {
        for seed in 0..30 {
            let mut rng = random(400 + seed);
            let mut path = circle(&mut rng);
            if seed % 2 == 0 {
                path.turn_rad_per_s = 0.0;
            }
            let mut drive = Drive::new((motion, Solver::OneShot), [0, 0], path, 40, rng);
            (0..60).for_each(|_| drive.step());
        }
    }
}

#[test]
fn the_pose_does_not_drift_where_odometry_alone_would() {
    let (mut early, mut late, mut without) = (0.0, 0.0, 0.0);
    for seed in 0..10 {
        let mut rng = random(500 + seed);
        let path = Path { turn_rad_per_s: 0.0, ..circle(&mut rng) };
        let mut drive = Drive::new(full(Solver::OneShot), [0, 0], path, 120, rng);
        (0..50).for_each(|_| drive.step());
        early += drive.pose.hull().width(2) / 10.0;
        (0..150).for_each(|_| drive.step());
        late += drive.pose.hull().width(2) / 10.0;
        // Width of the heading by odometry alone at the end of the drive: 199 motions, each with a heading error of ±3 mrad.
        without += 199.0 * 2.0 * ODOMETRY[2] / 10.0;
    }
    println!("heading known to {early:.4} rad after 5 s, {late:.4} rad after 20 s, {without:.4} rad by odometry");
    assert!(late < early && late < 0.1 * without, "{early} rad, then {late} rad against {without} rad of odometry");
}

#[test]
fn what_is_learnt_after_a_doubt_began_is_unlearnt_exactly() {
    for wrong in [[0, 0], [1, 2]] {
        let mut rng = random(600);
        let path = circle(&mut rng);
        let mut drive = Drive::new(full(Solver::OneShot), wrong, path, 40, rng);
        (0..50).for_each(|_| drive.step());
        let (knowledge, known) = (drive.method.knowledge().unwrap(), drive.places());
        (0..30).for_each(|_| drive.step());
        assert_ne!(drive.places(), known, "nothing was learnt: the test says nothing");
        drive.method.go_back(&knowledge);
        assert_eq!(drive.places(), known);
    }
}

#[test]
fn nothing_remains_of_what_a_wrong_pose_taught() {
    for seed in 0..5 {
        let mut rng = random(610 + seed);
        let path = circle(&mut rng);
        let mut drive = Drive::new(full(Solver::OneShot), [0, 0], path, 120, rng);
        (0..40).for_each(|_| drive.step());
        let (since_s, pose) = (drive.time_s - STEP_S, drive.pose.clone());
        let knowledge = drive.method.knowledge().unwrap();
        // For two seconds the method is taught wrongly: the robot moves on along its path, while the method is given poses that say that the
        // robot stands still.
        for _ in 0..20 {
            let reading = drive.reading();
            let constraint = drive.method.constrain(&reading, &Context::at_rest(&pose)).unwrap();
            drive.method.learn(&constraint.shown.unwrap(), Some(&pose));
            drive.time_s += STEP_S;
        }
        drive.method.go_back(&knowledge);
        // The simulated time is set back, which puts the robot on its path one step after the last reading before the method was taught wrongly.
        drive.time_s = since_s + STEP_S;
        drive.pose = pose;
        (0..60).for_each(|_| drive.step());
    }
}

#[test]
fn a_clock_set_back_keeps_what_is_known() {
    let mut rng = random(601);
    let path = circle(&mut rng);
    let mut drive = Drive::new(full(Solver::OneShot), [0, 0], path, 40, rng);
    (0..50).for_each(|_| drive.step());
    let known = drive.places();
    drive.method.clock_set_back();
    assert_eq!(drive.places(), known);
}
