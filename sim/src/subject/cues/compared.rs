//! What readings say about a pose, ready for a filter of one's own: residuals, derivatives and noise, without the filter.

use std::sync::Arc;

use localizer::{Reading, RobotModel, map::TileGrid};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2, Vector3};

use crate::{scene::Scene, subject::half_turn};

use super::{Cues, Edge, FloorPlan, Joint, Landmark, Line, Mount, Mounted, Seen, Told, heading_of, turned};

/// Standard deviations of a predicted place of a joint that half the distance between joints must hold for the nearest joint to be taken for the one
/// that is seen: with fewer, a filter may follow the wrong tile for ever.
const UNAMBIGUOUS_SIGMAS: f64 = 3.0;
/// Derivatives of the heading by x, y and heading.
const TURN: [f64; 3] = [0.0, 0.0, 1.0];

/// Reads cues from the readings of a robot, with the vision that the built-in filters have, too.
pub struct CueReader {
    cues: Cues,
    robot: RobotModel,
    known: Arc<Known>,
}

/// What is known beforehand that cues are compared with.
struct Known {
    tiles: Option<TileGrid>,
    wall_directions_rad: Vec<f64>,
    floor_plan: Option<FloorPlan>,
}

/// One thing that a reading says about the pose.
#[derive(Clone)]
pub struct Cue {
    /// Stamp of the reading.
    pub measured_s: f64,
    what: What,
    mount: Mount,
    known: Arc<Known>,
}

#[derive(Clone)]
enum What {
    Markers { pose: [f64; 3], covariance: Matrix3<f64> },
    Joint(Joint),
    Walls(Vec<Edge>),
    Line(Line),
    Landmark { code: u32, in_robot_m: Vector2<f64>, covariance: Matrix2<f64> },
    Position { in_robot_m: [f64; 2], in_world_m: [f64; 2], sigma_m: f64 },
}

/// A cue compared with a pose, for `n` numbers that it measures.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Measured less predicted.
    pub residual: DVector<f64>,
    /// Derivatives of the predicted numbers by x, y and heading, n × 3.
    pub jacobian: DMatrix<f64>,
    /// Covariance of the measured numbers, n × n, with the errors of the device's mount in it.
    pub noise: DMatrix<f64>,
}

impl CueReader {
    /// A reader for a scene, with the map, robot and bounds that it states.
    pub fn of(scene: &Scene) -> CueReader {
        let (map, robot) = (scene.map(), scene.robot_model());
        let cues = Cues::new(scene, &map, &robot);
        let wall_directions_rad = cues.wall_directions_rad().to_vec();
        let floor_plan = cues.floor_plan().cloned();
        let known = Arc::new(Known { tiles: cues.tiles().cloned(), wall_directions_rad, floor_plan });
        CueReader { cues, robot, known }
    }

    /// Begins a drive anew.
    pub fn restart(&mut self) {
        self.cues.restart(&self.robot);
    }

    /// Takes in a reading and returns its cues. Readings of wheels and gyroscope have none, but the reader needs them to know how the robot moves.
    pub fn read(&mut self, reading: &Reading) -> Vec<Cue> {
        let Some(Told::Seen(measured_s, mounted, seen)) = self.cues.take(reading) else { return Vec::new() };
        let mount = self.cues.mount(mounted).unwrap_or(Mount { sigma: [0.0; 3] });
        let cue = |what| Cue { measured_s, what, mount, known: Arc::clone(&self.known) };
        match seen {
            Seen::Pose { pose, covariance } => vec![cue(What::Markers { pose, covariance })],
            Seen::Joints(joints) => joints.into_iter().map(|joint| cue(What::Joint(joint))).collect(),
            Seen::Edges(edges) => vec![cue(What::Walls(edges))],
            Seen::Lines(lines) => lines.into_iter().map(|line| cue(What::Line(line))).collect(),
            Seen::Landmarks(landmarks) => {
                let scale_sigma = self.cues.range_scale_sigma().unwrap_or(0.0);
                let landmark = |Landmark { code, in_robot_m, ray_m, covariance }| {
                    let scaled_m = ray_m * scale_sigma;
                    let covariance = covariance + scaled_m * scaled_m.transpose();
                    cue(What::Landmark { code, in_robot_m, covariance })
                };
                landmarks.into_iter().map(landmark).collect()
            }
            Seen::Position { in_robot_m, in_world_m, sigma_m } => {
                vec![cue(What::Position { in_robot_m, in_world_m, sigma_m })]
            }
        }
    }

    /// Whether a device of the robot gives cues.
    pub fn has_cues(&self) -> bool {
        Mounted::ALL.into_iter().any(|mounted| self.cues.mount(mounted).is_some())
    }
}

impl Cue {
    /// What the cue is: `markers`, `joint`, `walls`, `line`, `landmark` or `position`.
    pub fn kind(&self) -> &'static str {
        match self.what {
            What::Markers { .. } => "markers",
            What::Joint(_) => "joint",
            What::Walls(_) => "walls",
            What::Line(_) => "line",
            What::Landmark { .. } => "landmark",
            What::Position { .. } => "position",
        }
    }

    /// Code, place in the robot frame in metres, and covariance in m² of a landmark that no map gives; `None` for every other cue.
    pub fn landmark(&self) -> Option<(u32, Vector2<f64>, Matrix2<f64>)> {
        match &self.what {
            What::Landmark { code, in_robot_m, covariance } => Some((*code, *in_robot_m, *covariance)),
            _ => None,
        }
    }

    /// Compares the cue with a predicted pose (x, y, heading) of a given covariance. `None` where the cue does not apply: a joint or a
    /// line that may as well be another one, edges that do not agree on a heading, a line where no wall is, a landmark, which no map gives.
    pub fn compare(&self, pose: [f64; 3], covariance: &Matrix3<f64>) -> Option<Compared> {
        let [forward_m, left_m, yaw_rad] = self.mount.sigma;
        let [x_m, y_m, heading_rad] = pose;
        let (sin, cos) = heading_rad.sin_cos();
        // Covariance of x and y by the mount's position, which turns with the robot.
        let by_mount = |a: [f64; 2], b: [f64; 2]| {
            let along = |v: [f64; 2]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0]];
            let (a, b) = (along(a), along(b));
            a[0] * b[0] * forward_m.powi(2) + a[1] * b[1] * left_m.powi(2)
        };
        let (east, north) = ([1.0, 0.0], [0.0, 1.0]);
        match &self.what {
            What::Markers { pose: seen, covariance: of_dots } => {
                let [ee, en, nn] = [by_mount(east, east), by_mount(east, north), by_mount(north, north)];
                let mounted = Matrix3::new(ee, en, 0.0, en, nn, 0.0, 0.0, 0.0, yaw_rad.powi(2));
                let residual = Vector3::new(seen[0] - x_m, seen[1] - y_m, half_turn(seen[2] - heading_rad));
                let noise = of_dots + mounted;
                Some(Compared::new(residual.as_slice(), &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], TURN], noise.as_slice()))
            }
            What::Joint(joint) => {
                let agreement = joint.agreement(pose, self.known.tiles.as_ref()?);
                let row = [agreement.along[0], agreement.along[1], 0.0];
                let off_m2 = joint.sigma[1].powi(2) + by_mount(agreement.along, agreement.along);
                let variance = Vector3::from(row).dot(&(covariance * Vector3::from(row)));
                if UNAMBIGUOUS_SIGMAS * (variance + off_m2).sqrt() > agreement.half_edge_m {
                    return None;
                }
                let turn_rad2 = joint.sigma[0].powi(2) + yaw_rad.powi(2);
                let noise = [turn_rad2, 0.0, 0.0, off_m2];
                Some(Compared::new(&[agreement.turn_rad, agreement.off_m], &[TURN, row], &noise))
            }
            What::Walls(edges) => {
                let sigma_rad = covariance[(2, 2)].max(0.0).sqrt().hypot(yaw_rad);
                let (off_rad, noise_rad2) = heading_of(edges, &self.known.wall_directions_rad, heading_rad, sigma_rad)?;
                Some(Compared::new(&[off_rad], &[TURN], &[noise_rad2 + yaw_rad.powi(2)]))
            }
            What::Line(line) => {
                let plan = self.known.floor_plan.as_ref()?;
                let met = plan.met(line, pose)?;
                let (rows, noise) = plan.noise(line, &met, heading_rad, &self.mount);
                let row = Vector3::from(rows[1]);
                let off_m2 = row.dot(&(covariance * row)) + noise[(1, 1)];
                let most_m = UNAMBIGUOUS_SIGMAS * off_m2.sqrt();
                // What is farther from the wall than the errors allow stands before it.
                if met.off_m.abs() > most_m || most_m > plan.half_way_m(line, pose, &met) {
                    return None;
                }
                Some(Compared::new(&[met.turn_rad, met.off_m], &rows, noise.as_slice()))
            }
            What::Landmark { .. } => None,
            What::Position { in_robot_m, in_world_m, sigma_m } => {
                let arm = turned(*in_robot_m, heading_rad);
                let residual = [in_world_m[0] - x_m - arm[0], in_world_m[1] - y_m - arm[1]];
                let rows = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]];
                let (own_m2, across_m2) = (sigma_m.powi(2), by_mount(east, north));
                let noise = [own_m2 + by_mount(east, east), across_m2, across_m2, own_m2 + by_mount(north, north)];
                Some(Compared::new(&residual, &rows, &noise))
            }
        }
    }
}

impl Compared {
    /// `rows` has one row for each number, with its derivatives by x, y and heading.
    fn new(residual: &[f64], rows: &[[f64; 3]], noise: &[f64]) -> Compared {
        let n = residual.len();
        Compared {
            residual: DVector::from_column_slice(residual),
            jacobian: DMatrix::from_fn(n, 3, |row, column| rows[row][column]),
            noise: DMatrix::from_column_slice(n, n, noise),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const POSE: [f64; 3] = [2.03, 1.02, 0.4];

    fn cue(what: What) -> Cue {
        let tiles = TileGrid {
            edge_m: [0.3, 0.5],
            rotation_rad: 0.1,
            phase_m: [0.05, 0.2],
            joint_width_m: 0.004,
            laying_m: 0.001,
            laying_angle_rad: 0.001,
            straightness_m: 0.0,
        };
        let known = Arc::new(Known { tiles: Some(tiles), wall_directions_rad: vec![0.1], floor_plan: None });
        Cue { measured_s: 0.0, what, mount: Mount { sigma: [0.003, 0.002, 0.004] }, known }
    }

    fn cues() -> Vec<Cue> {
        let edge = |quarter: f64| Edge {
            direction_rad: 0.1 - 0.41 + quarter * std::f64::consts::FRAC_PI_2,
            sigma_rad: 0.001,
            by_lean: [0.0, 0.0],
            lean_sigma_rad: 0.002,
        };
        vec![
            cue(What::Markers { pose: [2.0, 1.0, 0.41], covariance: Matrix3::identity() * 1e-6 }),
            cue(What::Joint(Joint { normal_rad: -0.29, distance_m: 0.07, sigma: [0.01, 0.01] })),
            cue(What::Walls(vec![edge(0.0), edge(1.0), edge(2.0)])),
            cue(What::Position { in_robot_m: [0.1, 0.05], in_world_m: [2.1, 1.1], sigma_m: 0.01 }),
        ]
    }

    #[test]
    fn residuals_fall_by_what_the_jacobian_says_when_the_pose_moves() {
        let covariance = Matrix3::identity() * 1e-6;
        for cue in cues() {
            let before = cue.compare(POSE, &covariance).unwrap();
            for axis in 0..3 {
                let mut moved = POSE;
                moved[axis] += 1e-5;
                let change = (cue.compare(moved, &covariance).unwrap().residual - &before.residual) / 1e-5;
                let expected = -before.jacobian.column(axis);
                // A joint's direction turns with the pose within its rounding; the rest is the second order of a step of 1e-5.
                assert!((change - expected).amax() < 1e-3, "{} along axis {axis}", cue.kind());
            }
        }
    }

    #[test]
    fn the_noise_holds_the_errors_of_the_mount() {
        let covariance = Matrix3::identity() * 1e-6;
        let noise: Vec<DMatrix<f64>> = cues().iter().map(|cue| cue.compare(POSE, &covariance).unwrap().noise).collect();
        // Markers: the mount's variances on the diagonal, turned with the robot, so that their sum over x and y stays 0.003² + 0.002².
        let spread_m2 = 0.003_f64.powi(2) + 0.002_f64.powi(2);
        assert!((noise[0][(0, 0)] + noise[0][(1, 1)] - 2e-6 - spread_m2).abs() < 1e-12);
        assert!((noise[0][(2, 2)] - 1e-6 - 0.004_f64.powi(2)).abs() < 1e-12);
        assert!(noise[1][(0, 0)] >= 0.01_f64.powi(2) + 0.004_f64.powi(2) - 1e-12);
        assert!(noise[2][(0, 0)] >= 0.004_f64.powi(2));
        assert!((noise[3][(0, 0)] + noise[3][(1, 1)] - 2.0 * 0.01_f64.powi(2) - spread_m2).abs() < 1e-12);
    }

    #[test]
    fn a_joint_that_may_be_its_neighbour_tells_nothing() {
        let joint = &cues()[1];
        assert!(joint.compare(POSE, &(Matrix3::identity() * 1e-6)).is_some());
        assert!(joint.compare(POSE, &Matrix3::identity()).is_none());
    }
}
