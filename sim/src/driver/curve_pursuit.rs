//! The control law for planned curves: pure pursuit on each piece of a path without a change of direction, forwards or backwards, and a stop at its
//! end.
//!
//! The middle of the rear axle, which follows the path, moves backwards along the same circles as forwards. Backwards the law is therefore the same
//! for the direction in which the car moves.

use std::f64::consts::{FRAC_PI_2, PI};

use localizer::Pose;

use crate::place::navigation::reeds_shepp::Arc;

use super::{ARRIVED_M, CREEP_M_PER_S, LOOK_AHEAD_S, PERIOD_S};

/// Look-ahead distance at standstill, over the radius of the turning circle. With half a radius a car strays twice as far from its path where arcs
/// meet; with a shorter one it weaves when the estimate jumps.
const LOOK_AHEAD_OVER_CIRCLE: f64 = 0.35;

/// Distance between the points by which a path is followed.
const STATION_M: f64 = 0.05;

/// Share of the speed at which the car drives backwards, where its sensors mostly do not look.
const BACKWARDS_SHARE: f64 = 0.6;

/// Angle between the direction in which the car moves and that of its path beyond which it has lost the path.
const LOST_PATH_RAD: f64 = 1.0;

/// Speed that is asked for while the car steers at rest. A base steers to the angle of the motion that it is asked for, and this one moves it by no
/// more than micrometres.
const STEERING_M_PER_S: f64 = 1e-6;

/// Time that the car takes for steering at rest, over that which its steering rate needs for the share of the greatest curvature. A small curvature
/// takes more of the angle, `tan δ/δ` of its share: 1.1 for a greatest angle δ of 30°, 1.2 for 40°.
const STEERING_OVER_LEAST: f64 = 1.2;

/// A path's pieces, of which the car drives each in one direction.
#[derive(Clone, Debug)]
pub(super) struct CurvePursuit {
    pieces: Vec<Piece>,
    piece_idx: usize,
    /// Index of the point of the piece that the car has last passed.
    passed_idx: usize,
    is_stopping: bool,
    curvature_per_m: f64,
    /// Time for which the car still steers at rest before the piece; `None` before it has begun to.
    steering_left_s: Option<f64>,
}

#[derive(Clone, Debug)]
struct Piece {
    /// 1 forwards, −1 backwards.
    way: f64,
    /// Points of the piece, with the heading of the direction in which the car moves.
    stations: Vec<Station>,
}

#[derive(Clone, Copy, Debug)]
struct Station {
    pose: Pose,
    /// Length of the piece up to here.
    along_m: f64,
    curvature_per_m: f64,
}

/// What the law asks for, and whether the car has lost its path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pursued {
    /// Speed, negative backwards.
    pub(super) speed_m_per_s: f64,
    /// Turn per length driven forwards, positive to the left.
    pub(super) curvature_per_m: f64,
    /// Whether the car is too far from its path, or turned too far from it, to follow it.
    pub(super) has_lost_path: bool,
}

/// What the law keeps to.
pub(super) struct CurveLimits<'a> {
    pub(super) speed_m_per_s: f64,
    /// Braking deceleration before stops and curves.
    pub(super) braking_m_per_s2: f64,
    /// Greatest speed for a curvature.
    pub(super) curve_m_per_s: &'a dyn Fn(f64) -> f64,
    /// Greatest speed on a piece of a length that begins and ends at rest.
    pub(super) reachable_m_per_s: &'a dyn Fn(f64) -> f64,
    /// Radius of the smallest circle, and the time in which the car steers from this circle to one side to that to the other.
    pub(super) radius_m: f64,
    pub(super) lock_to_lock_s: f64,
    /// Distance from the path beyond which the car has lost it.
    pub(super) lost_path_m: f64,
}

impl CurvePursuit {
    /// The law for a path from its beginning.
    pub(super) fn new(from: Pose, arcs: &[Arc]) -> CurvePursuit {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut at = from;
        for arc in arcs {
            let way = arc.length_m.signum();
            let moved = |pose: Pose| Pose { heading_rad: pose.heading_rad + if way < 0.0 { PI } else { 0.0 }, ..pose };
            let station =
                |pose: Pose, along_m: f64| Station { pose: moved(pose), along_m, curvature_per_m: arc.curvature_per_m };
            if pieces.last().is_none_or(|piece| piece.way != way) {
                pieces.push(Piece { way, stations: vec![station(at, 0.0)] });
            }
            let Some(piece) = pieces.last_mut() else { continue };
            let (before_m, n_stations) = (piece.length_m(), (arc.length_m.abs() / STATION_M).ceil().max(1.0));
            piece.stations.extend((1..=n_stations as usize).map(|nth| {
                let gone_m = arc.length_m * nth as f64 / n_stations;
                station(arc.after(at, gone_m), before_m + gone_m.abs())
            }));
            at = arc.end(at);
        }
        CurvePursuit {
            pieces,
            piece_idx: 0,
            passed_idx: 0,
            is_stopping: false,
            curvature_per_m: 0.0,
            steering_left_s: None,
        }
    }

    /// All points of the path, in order.
    pub(super) fn places_m(&self) -> Vec<[f64; 2]> {
        let stations = self.pieces.iter().flat_map(|piece| &piece.stations);
        stations.map(|station| [station.pose.x_m, station.pose.y_m]).collect()
    }

    /// Whether the car stands at the end of the path.
    pub(super) fn is_finished(&self) -> bool {
        self.piece_idx >= self.pieces.len()
    }

    /// The points of the present piece that are still ahead, up to a length from the car, each with the length to it.
    pub(super) fn ahead(&self, up_to_m: f64) -> Vec<([f64; 2], f64)> {
        let Some(piece) = self.pieces.get(self.piece_idx) else { return Vec::new() };
        let from_m = piece.stations[self.passed_idx].along_m;
        let ahead = piece.stations[self.passed_idx..].iter().map(|station| (station, station.along_m - from_m));
        ahead
            .take_while(|(_, length_m)| *length_m <= up_to_m)
            .map(|(station, length_m)| ([station.pose.x_m, station.pose.y_m], length_m))
            .collect()
    }

    /// Speed and curvature at a pose and a present speed.
    ///
    /// The car follows the arc that starts along the direction in which it moves and leads to the look-ahead point: of curvature `κ = 2·y/d²`, with y
    /// for the distance of the point to the left and d for that to it (Coulter 1992).
    pub(super) fn pursue(&mut self, pose: Pose, speed_m_per_s: f64, limits: &CurveLimits) -> Pursued {
        let stop = Pursued { curvature_per_m: self.curvature_per_m, ..Pursued::default() };
        let Some(piece) = self.pieces.get(self.piece_idx) else { return stop };
        let place_m = [pose.x_m, pose.y_m];
        while let Some(next) = piece.stations.get(self.passed_idx + 1)
            && next.is_passed(place_m)
        {
            self.passed_idx += 1;
        }
        let passed = piece.stations[self.passed_idx];
        let (past_m, aside_m) = passed.seen(place_m);
        let along_m = passed.along_m + past_m;
        let left_m = piece.length_m() - along_m;
        if self.is_stopping || left_m < ARRIVED_M {
            self.is_stopping = speed_m_per_s != 0.0;
            if !self.is_stopping {
                self.piece_idx += 1;
                self.passed_idx = 0;
                self.steering_left_s = None;
            }
            return stop;
        }
        let moving = Pose { heading_rad: pose.heading_rad + if piece.way < 0.0 { PI } else { 0.0 }, ..pose };
        let look_ahead_m = LOOK_AHEAD_OVER_CIRCLE * limits.radius_m + LOOK_AHEAD_S * speed_m_per_s.abs();
        let (forward_m, left_to_point_m) = seen_m(moving, piece.at_m(along_m + look_ahead_m));
        let off_rad = left_to_point_m.atan2(forward_m);
        let (sin, cos) = (moving.heading_rad - passed.pose.heading_rad).sin_cos();
        let turned_rad = sin.atan2(cos);
        let is_turned = off_rad.abs() > FRAC_PI_2 || turned_rad.abs() > LOST_PATH_RAD;
        let sharpest_per_m = 1.0 / limits.radius_m;
        let wanted_per_m =
            2.0 * left_to_point_m / (forward_m * forward_m + left_to_point_m * left_to_point_m).max(1e-12);
        let curvature_per_m = piece.way * wanted_per_m.clamp(-sharpest_per_m, sharpest_per_m);
        let steered = 0.5 * limits.radius_m * (curvature_per_m - self.curvature_per_m).abs();
        self.curvature_per_m = curvature_per_m;
        let left_s = self.steering_left_s.unwrap_or(STEERING_OVER_LEAST * limits.lock_to_lock_s * steered);
        self.steering_left_s = Some((left_s - PERIOD_S).max(0.0));
        let speed_m_per_s = match left_s > 0.0 {
            true => STEERING_M_PER_S,
            false => self.speed_m_per_s(piece, left_m, look_ahead_m, limits),
        };
        Pursued {
            speed_m_per_s: piece.way * speed_m_per_s,
            curvature_per_m: self.curvature_per_m,
            has_lost_path: is_turned || aside_m.abs() > limits.lost_path_m,
        }
    }

    /// Greatest speed from which the car can still stop at the end of the piece, and with which it drives the curves ahead.
    fn speed_m_per_s(&self, piece: &Piece, left_m: f64, look_ahead_m: f64, limits: &CurveLimits) -> f64 {
        let usual_m_per_s = limits.speed_m_per_s * if piece.way < 0.0 { BACKWARDS_SHARE } else { 1.0 };
        let approach_m_per_s = (2.0 * limits.braking_m_per_s2 * left_m.max(0.0)).sqrt() + CREEP_M_PER_S;
        let from_m = piece.stations[self.passed_idx].along_m + look_ahead_m;
        // The look-ahead point meets a curve before the car does.
        let in_curves_m_per_s = piece.stations[self.passed_idx..].iter().map(|station| {
            let curve_m_per_s = (limits.curve_m_per_s)(station.curvature_per_m);
            let braking_m = (station.along_m - from_m).max(0.0);
            (curve_m_per_s * curve_m_per_s + 2.0 * limits.braking_m_per_s2 * braking_m).sqrt()
        });
        // While the car drives its look-ahead distance, it can steer from straight ahead to the smallest circle.
        let steered_m_per_s = LOOK_AHEAD_OVER_CIRCLE * limits.radius_m / (0.5 * limits.lock_to_lock_s);
        usual_m_per_s
            .min(approach_m_per_s)
            .min(steered_m_per_s)
            .min((limits.reachable_m_per_s)(piece.length_m()).max(CREEP_M_PER_S))
            .min(in_curves_m_per_s.fold((limits.curve_m_per_s)(self.curvature_per_m), f64::min))
    }
}

impl Piece {
    fn length_m(&self) -> f64 {
        self.stations.last().map_or(0.0, |station| station.along_m)
    }

    /// The point of the piece at a length along it; beyond the end, on the circle of its last arc.
    fn at_m(&self, along_m: f64) -> [f64; 2] {
        let next_idx = self.stations.partition_point(|station| station.along_m < along_m);
        let Station { pose, along_m: before_m, .. } = self.stations[next_idx.saturating_sub(1)];
        let last = self.stations.get(next_idx).or(self.stations.last());
        let curvature_per_m = self.way * last.map_or(0.0, |station| station.curvature_per_m);
        let arc = Arc { length_m: along_m - before_m, curvature_per_m };
        let Pose { x_m, y_m, .. } = arc.end(pose);
        [x_m, y_m]
    }
}

impl Station {
    /// Distances of a place ahead of this point and to its left, in the direction of the path.
    fn seen(&self, place_m: [f64; 2]) -> (f64, f64) {
        seen_m(self.pose, place_m)
    }

    fn is_passed(&self, place_m: [f64; 2]) -> bool {
        self.seen(place_m).0 >= 0.0
    }
}

/// Distances of a place ahead of a pose and to its left.
fn seen_m(pose: Pose, place_m: [f64; 2]) -> (f64, f64) {
    let (x_m, y_m) = (place_m[0] - pose.x_m, place_m[1] - pose.y_m);
    let (sin, cos) = pose.heading_rad.sin_cos();
    (cos * x_m + sin * y_m, cos * y_m - sin * x_m)
}
