//! Mean and covariance of the filter's state: how a step of the robot carries them on, and how a measurement changes them.
//!
//! Source of the equations: S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics* (2005), sections 3.3 and 7.4. The motion is measured by several
//! sensors: the state is carried on by gyroscope and flow sensor, and over windows of time the way since a remembered pose is compared with the
//! wheels, after S. Roumeliotis, J. Burdick, *Stochastic cloning* (ICRA 2002).

use localizer::{Pose, PoseBox, RobotModel};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2xX, Matrix3, Matrix3xX, Vector2};

use crate::{
    scene::FilterNoise,
    subject::{
        chi_squared,
        cues::{LASTS_M, SIGMAS_OF_BOUND, Step, turned},
    },
};

use super::{
    layout::{Layout, POSE},
    moved::Moved,
};

/// Mean and covariance of pose, constants and landmarks.
#[derive(Clone, Debug)]
pub(crate) struct Belief {
    pub(crate) mean: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
    /// Things in the state of two coordinates each, in the order of their places at its end.
    pub(crate) things: Vec<Thing>,
    /// Place of the first thing.
    first_thing: usize,
    /// What the wheels have measured since the remembered pose.
    window: Window,
    /// Time up to which the belief has been carried.
    pub(crate) stamp_s: f64,
}

/// A thing in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    /// A landmark by its code: where it is.
    Landmark(u32),
    /// A wall by its index on the floor plan: how far its two ends are before their places on the map.
    Wall(usize),
}

/// The way by the wheels since the beginning of the present window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    span_s: f64,
    /// Pose in the frame of the remembered pose, by the nominal wheels.
    way: [f64; 3],
    /// Distance that each wheel rolled, signed, and without sign.
    rolled_m: [f64; 2],
    path_m: [f64; 2],
}

/// Share of right measurements that pass the gate: all within three standard deviations, which are the declared bound.
const GATE: f64 = 0.9973;

/// A row of a measurement's Jacobian: the places in the state on which it depends, with the derivatives.
pub(crate) type Row = Vec<(usize, f64)>;

impl Belief {
    pub(crate) fn start(layout: &Layout, start: &PoseBox) -> Belief {
        let (mean, covariance) = layout.start(start);
        let mut belief = Belief {
            first_thing: mean.len(),
            mean,
            covariance,
            things: Vec::new(),
            window: Window::default(),
            stamp_s: 0.0,
        };
        belief.remember(layout);
        belief
    }

    pub(crate) fn pose(&self) -> Pose {
        Pose { x_m: self.mean[0], y_m: self.mean[1], heading_rad: self.mean[2] }
    }

    /// Place of a thing in the state.
    pub(crate) fn place_of(&self, thing: Thing) -> Option<usize> {
        self.things.iter().position(|one| *one == thing).map(|index| self.first_thing + 2 * index)
    }

    /// Variance of what a row of a Jacobian says of the state.
    pub(crate) fn variance(&self, row: &Row) -> f64 {
        row.iter().map(|(i, a)| row.iter().map(|(j, b)| a * b * self.covariance[(*i, *j)]).sum::<f64>()).sum()
    }

    /// Carries the belief on by a step of the robot.
    pub(crate) fn step(&mut self, step: &Step, layout: &Layout, robot: &RobotModel, tuning: &FilterNoise) {
        let moved = Moved::of(step, &self.mean, layout, robot, tuning);
        let n = self.mean.len();
        let middle_rad = self.mean[2] + 0.5 * moved.turn_rad;
        let (sin, cos) = middle_rad.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        // A turn of the travel by a small angle moves it along its own left.
        let aside = turn * Vector2::new(-moved.travel_m[1], moved.travel_m[0]);
        let mut rows = Matrix3xX::zeros(n);
        rows.fixed_view_mut::<3, 3>(0, POSE).fill_with_identity();
        rows[(0, 2)] = aside.x;
        rows[(1, 2)] = aside.y;
        for (place, [ahead, left, turned]) in &moved.by {
            let way = turn * Vector2::new(*ahead, *left) + aside * (0.5 * turned);
            rows[(0, *place)] += way.x;
            rows[(1, *place)] += way.y;
            rows[(2, *place)] += turned;
        }
        let travel = turn * Vector2::from(moved.travel_m);
        self.mean[0] += travel.x;
        self.mean[1] += travel.y;
        self.mean[2] += moved.turn_rad;
        // Only the pose changes, so that only its rows and columns of the covariance do.
        let carried = &rows * &self.covariance;
        self.covariance.rows_mut(0, 3).copy_from(&carried);
        let carried = &self.covariance * rows.transpose();
        self.covariance.columns_mut(0, 3).copy_from(&carried);
        let noise_by = Matrix3::new(cos, -sin, 0.5 * aside.x, sin, cos, 0.5 * aside.y, 0.0, 0.0, 1.0);
        let noise = noise_by * moved.noise * noise_by.transpose();
        let mut corner = self.covariance.fixed_view_mut::<3, 3>(0, 0);
        corner += noise;
        if let (Some([bias, _]), Some(gyro)) = (layout.gyro, robot.gyro) {
            self.covariance[(bias, bias)] +=
                (tuning.motion * SIGMAS_OF_BOUND * gyro.bias_wander_rad_per_s2).powi(2) * step.span_s;
        }
        self.change(layout, 0.5 * (step.rolled_m[0].abs() + step.rolled_m[1].abs()));
        self.stamp_s = step.stamp_s;
        self.window.add(step, robot);
        if self.window.span_s >= robot.wheels.slip_window_s {
            self.compare_wheels(layout, robot, tuning);
            self.remember(layout);
        }
    }

    /// Lets the errors that last for a while forget themselves as the robot goes `path_m` on: each is a first-order Gauss–Markov process.
    pub(super) fn change(&mut self, layout: &Layout, path_m: f64) {
        let kept = (-path_m / LASTS_M).exp();
        for (place, sigma) in &layout.changing {
            self.mean[*place] *= kept;
            self.covariance.row_mut(*place).scale_mut(kept);
            self.covariance.column_mut(*place).scale_mut(kept);
            self.covariance[(*place, *place)] += sigma.powi(2) * (1.0 - kept.powi(2));
        }
    }

    /// Compares the way since the remembered pose with what the wheels measured of it: the turn where the gyroscope carried the state on, and the
    /// travel where the flow sensor did.
    fn compare_wheels(&mut self, layout: &Layout, robot: &RobotModel, tuning: &FilterNoise) {
        let Some(past) = layout.past else { return };
        let (window, wheels) = (&self.window, &robot.wheels);
        let track_m = wheels.track_m.mid();
        let ([left, right, track], [left_slip, right_slip, side_slip]) = (layout.wheels, layout.slip);
        let [x_m, y_m, from_rad] = [0, 1, 2].map(|axis| self.mean[past + axis]);
        let (sin, cos) = from_rad.sin_cos();
        let (dx, dy) = (self.mean[0] - x_m, self.mean[1] - y_m);
        let way = [cos * dx + sin * dy, cos * dy - sin * dx, self.mean[2] - from_rad];
        let [rolled_left_m, rolled_right_m] = window.rolled_m;
        // The wheels' way with the radii and the track as the state has them, to first order.
        let by_left = [0.5 * rolled_left_m, 0.0, -rolled_left_m / track_m];
        let by_right = [0.5 * rolled_right_m, 0.0, rolled_right_m / track_m];
        let path_m = 0.5 * (window.path_m[0] + window.path_m[1]);
        let constants = [
            (left, by_left),
            (left_slip, by_left),
            (right, by_right),
            (right_slip, by_right),
            (track, [0.0, 0.0, -window.way[2]]),
            (side_slip, [0.0, path_m, 0.0]),
        ];
        let told = [0, 1, 2].map(|axis| {
            window.way[axis] + constants.iter().map(|(place, by)| by[axis] * self.mean[*place]).sum::<f64>()
        });
        let floor_m2 = |floor_m: f64| (tuning.motion * SIGMAS_OF_BOUND * floor_m).powi(2);
        let tick_m = wheels.metres_per_tick(0).mid();
        let wheel_m2 = 2.0 * (floor_m2(wheels.slip_floor_m) + (tuning.motion * SIGMAS_OF_BOUND * tick_m).powi(2));
        let turn_rad2 = wheel_m2 / track_m.powi(2);
        let side_m2 = floor_m2(wheels.side_slip_floor_m) + (0.5 * path_m).powi(2) * turn_rad2;
        let variances = [0.25 * wheel_m2, side_m2, turn_rad2];
        let mut rows: [Row; 3] = [
            vec![(0, cos), (1, sin), (past, -cos), (past + 1, -sin), (past + 2, way[1])],
            vec![(0, -sin), (1, cos), (past, sin), (past + 1, -cos), (past + 2, -way[0])],
            vec![(2, 1.0), (past + 2, -1.0)],
        ];
        for axis in 0..3 {
            rows[axis].extend(constants.iter().map(|(place, by)| (*place, -by[axis])));
        }
        let axes: Vec<usize> =
            (0..3).filter(|axis| if *axis == 2 { layout.gyro.is_some() } else { layout.flow.is_some() }).collect();
        let residual = DVector::from_iterator(axes.len(), axes.iter().map(|axis| told[*axis] - way[*axis]));
        let rows: Vec<Row> = axes.iter().map(|axis| rows[*axis].clone()).collect();
        let noise = DVector::from_iterator(axes.len(), axes.iter().map(|axis| variances[*axis]));
        // Wheels that slip do not pass the gate, and are left out for this window.
        self.update(&rows, &residual, &DMatrix::from_diagonal(&noise));
    }

    /// Begins a window: remembers the present pose in the state.
    fn remember(&mut self, layout: &Layout) {
        self.window = Window::default();
        let Some(past) = layout.past else { return };
        let pose = self.mean.rows(0, 3).into_owned();
        self.mean.rows_mut(past, 3).copy_from(&pose);
        let rows = self.covariance.rows(0, 3).into_owned();
        self.covariance.rows_mut(past, 3).copy_from(&rows);
        let columns = self.covariance.columns(0, 3).into_owned();
        self.covariance.columns_mut(past, 3).copy_from(&columns);
    }

    /// Updates the belief by a measurement with the given residual, Jacobian and noise, if it passes the gate: if the squared Mahalanobis distance of
    /// the residual is below the quantile [`GATE`] of χ².
    pub(crate) fn update(&mut self, rows: &[Row], residual: &DVector<f64>, noise: &DMatrix<f64>) -> bool {
        let n = self.mean.len();
        let mut cross = DMatrix::zeros(n, rows.len());
        for (column, row) in rows.iter().enumerate() {
            for (place, slope) in row {
                cross.column_mut(column).axpy(*slope, &self.covariance.column(*place), 1.0);
            }
        }
        let mut spread = noise.clone();
        for (index, row) in rows.iter().enumerate() {
            for column in 0..rows.len() {
                spread[(index, column)] +=
                    row.iter().map(|(place, slope)| slope * cross[(*place, column)]).sum::<f64>();
            }
        }
        let Some(root) = spread.cholesky() else { return false };
        let weighted = root.solve(residual);
        if residual.dot(&weighted) > chi_squared_gate(rows.len()) {
            return false;
        }
        self.mean += &cross * weighted;
        let gain = root.solve(&cross.transpose());
        self.covariance -= &cross * gain;
        // Rounding would make the covariance asymmetric in the long run.
        let symmetric = (&self.covariance + self.covariance.transpose()) * 0.5;
        self.covariance = symmetric;
        true
    }

    /// Adds a landmark that was seen for the first time: at `place` of the world, which depends on the state by `rows` and on errors with the
    /// covariance `noise`.
    pub(crate) fn add_landmark(&mut self, code: u32, place: [f64; 2], rows: &[Row; 2], noise: &Matrix2<f64>) {
        let n = self.mean.len();
        let mut by_state = Matrix2xX::zeros(n);
        for (index, row) in rows.iter().enumerate() {
            row.iter().for_each(|(column, slope)| by_state[(index, *column)] += slope);
        }
        let cross = &by_state * &self.covariance;
        let own = &cross * by_state.transpose() + noise;
        self.add(Thing::Landmark(code), place, &cross, &own);
    }

    /// Adds a wall of which nothing is known but the standard deviation of either end's displacement, and returns its place in the state.
    pub(crate) fn add_wall(&mut self, wall: usize, sigma_m: f64) -> usize {
        let n = self.mean.len();
        let own = Matrix2::from_diagonal_element(sigma_m * sigma_m);
        self.add(Thing::Wall(wall), [0.0; 2], &Matrix2xX::zeros(n), &own);
        n
    }

    /// Adds a thing with its mean, its covariance with the rest of the state, and its own.
    fn add(&mut self, thing: Thing, [first, second]: [f64; 2], cross: &Matrix2xX<f64>, own: &Matrix2<f64>) {
        let n = self.mean.len();
        let mut mean = DVector::zeros(n + 2);
        mean.rows_mut(0, n).copy_from(&self.mean);
        mean[n] = first;
        mean[n + 1] = second;
        let mut covariance = DMatrix::zeros(n + 2, n + 2);
        covariance.view_mut((0, 0), (n, n)).copy_from(&self.covariance);
        covariance.view_mut((n, 0), (2, n)).copy_from(cross);
        covariance.view_mut((0, n), (n, 2)).copy_from(&cross.transpose());
        covariance.fixed_view_mut::<2, 2>(n, n).copy_from(own);
        (self.mean, self.covariance) = (mean, covariance);
        self.things.push(thing);
    }
}

impl Window {
    fn add(&mut self, step: &Step, robot: &RobotModel) {
        let [left_m, right_m] = step.rolled_m;
        let turn_rad = (right_m - left_m) / robot.wheels.track_m.mid();
        let [ahead_m, aside_m] = turned([0.5 * (left_m + right_m), 0.0], self.way[2] + 0.5 * turn_rad);
        self.way = [self.way[0] + ahead_m, self.way[1] + aside_m, self.way[2] + turn_rad];
        self.span_s += step.span_s;
        for (wheel, rolled_m) in step.rolled_m.into_iter().enumerate() {
            self.rolled_m[wheel] += rolled_m;
            self.path_m[wheel] += rolled_m.abs();
        }
    }
}

/// Squared Mahalanobis distance below which the share [`GATE`] of right residuals with so many components is.
fn chi_squared_gate(n_rows: usize) -> f64 {
    static GATES: std::sync::LazyLock<[f64; 4]> =
        std::sync::LazyLock::new(|| [1, 2, 3, 4].map(|degrees| chi_squared(GATE, f64::from(degrees))));
    GATES[n_rows.clamp(1, 4) - 1]
}
