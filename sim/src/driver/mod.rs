//! The driver: turns the localizer's estimates into drive commands (speed and turn rate), along the scene's route or on errands by paths that it plans
//! itself.
//!
//! On a route the driver steers by the estimated pose: pure pursuit along the polyline, with stops and turns in place where the route asks
//! for them. A base that cannot turn in place is never asked for a smaller circle than its own. The driver is given estimates only, never the
//! true pose, so that a robot with a wrong estimate drives as such a robot would. On errands it also has its scanner.

use std::f64::consts::FRAC_PI_2;

use localizer::{Estimate, Pose, Status};

use crate::{
    base::{DriveCommand, TurningCircle},
    scene::Scene,
};

mod caution;
mod curve_pursuit;
mod errands;
mod path;
mod pilot;
mod ramp;
mod surroundings;
mod turn_then_drive;

use caution::{Caution, Freedom};
pub use errands::{ErrandDriver, ErrandLog, ErrandRecord, Leg, Outcome};
use path::Path;
pub use pilot::Pilot;
use ramp::Ramp;
pub use turn_then_drive::{Bearing, bearing};

/// Time between two commands of the driver.
pub const PERIOD_S: f64 = 0.01;

/// Time in which a commanded acceleration rises to its full value. Shorter times make the tyres slip more, longer ones make the robot
/// overshoot.
const JERK_RISE_S: f64 = 0.2;

/// Look-ahead distance of pure pursuit at standstill, over the track. With a shorter one the robot weaves when the estimate jumps, with a
/// longer one it cuts corners.
const LOOK_AHEAD_OVER_TRACK: f64 = 1.0;

/// Look-ahead distance of pure pursuit at standstill, over the radius of the turning circle, for a base that cannot turn in place. With a shorter one
/// it begins its curves too late and comes out of them beside the path.
const LOOK_AHEAD_OVER_CIRCLE: f64 = 1.0;

/// Look-ahead distance of pure pursuit that is added per unit of speed.
const LOOK_AHEAD_S: f64 = 0.2;

/// Remaining distance at which the robot counts as arrived at a stop.
const ARRIVED_M: f64 = 0.01;

/// Angle between the heading and the look-ahead point below which the robot counts as facing that point; pure pursuit corrects the rest.
/// With a smaller angle, an estimate that jumps by centimetres would keep the robot turning to and fro.
const FACING_RAD: f64 = 0.08;

/// Angle between the heading and the look-ahead point beyond which the robot first turns in place.
const TURN_FIRST_RAD: f64 = 1.2;

/// Speed that is always allowed on the approach to a stop, so that the last millimetres do not take for ever.
const CREEP_M_PER_S: f64 = 0.02;

/// Turn rate per remaining angle near the end of a turn. A higher one is too fast for the rise time of the acceleration, so that the robot
/// swings to and fro.
const TURN_GAIN_PER_S: f64 = 2.0;

/// Turn rate below which a turn counts as ended.
const STILL_RAD_PER_S: f64 = 0.01;

/// Least progress towards a waypoint that the robot must make within `STUCK_S`; otherwise it gives up the waypoint.
const PROGRESS_M: f64 = 0.02;

/// Time without `PROGRESS_M` of progress after which a waypoint is given up. It is longer than any turn, and than the driver ever waits out
/// of caution.
const STUCK_S: f64 = 20.0;

/// Driver that follows the scene's route.
#[derive(Clone, Debug)]
pub struct Driver {
    path: Option<Path>,
    scene: Scene,
    segment_idx: usize,
    stage: Stage,
    speed: Ramp,
    turn: Ramp,
    /// Turning circle of a base that cannot turn in place, and the curvature that such a base drives at present, positive to the left.
    circle: Option<TurningCircle>,
    curvature_per_m: f64,
    caution: Caution,
    pose: Pose,
    progress: Progress,
}

/// What the driver is doing at present.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Drive,
    /// The robot slows down at a stop, then stands until the given time.
    Stand {
        until_s: Option<f64>,
    },
    Turn,
    Finished,
}

/// When the robot last made progress, and what distance to the waypoint remained then.
#[derive(Clone, Copy, Debug)]
struct Progress {
    left_m: f64,
    at_s: f64,
}

/// Speed and turn rate that the driver aims at, before accelerations are limited.
#[derive(Clone, Copy, Debug, Default)]
struct Wish {
    speed_m_per_s: f64,
    turn_rad_per_s: f64,
}

impl Driver {
    /// Makes a driver for the scene's route. Without a route it stands still.
    pub fn new(scene: &Scene) -> Driver {
        let robot = &scene.robot;
        let acceleration_m_per_s2 = robot.max_acceleration_m_per_s2;
        let circle = robot.base.drivetrain().turning_circle();
        Driver {
            path: None,
            scene: scene.clone(),
            segment_idx: 0,
            stage: if circle.is_some() { Stage::Drive } else { Stage::Turn },
            speed: Ramp::new(acceleration_m_per_s2, JERK_RISE_S),
            // In a turn the wheels accelerate half as hard as straight on, because a tyre may have to bear both accelerations at once, and
            // because at the end of a turn the tyres' rubber swings from full braking to nothing without rolling on.
            turn: Ramp::new(acceleration_m_per_s2 / robot.base.track_m, JERK_RISE_S),
            circle,
            curvature_per_m: 0.0,
            caution: Caution::new(scene),
            pose: scene.nominal_start(),
            progress: Progress { left_m: f64::INFINITY, at_s: 0.0 },
        }
    }

    /// The motion that the base is commanded for the next [`PERIOD_S`], by the localizer's estimate.
    pub fn command(&mut self, estimate: &Estimate, time_s: f64) -> DriveCommand {
        let hull = estimate.pose.hull();
        if !hull.is_empty() {
            let [x_m, y_m, heading_rad] = hull.midpoint();
            self.pose = Pose { x_m, y_m, heading_rad };
        }
        let freedom = self.caution.judge(&hull, estimate.status == Status::Recovering, time_s);
        let wish = match freedom {
            Freedom::Drive { .. } if self.rests(time_s) => Wish::default(),
            Freedom::Drive { speed_share } => {
                let wish = self.wish(time_s);
                Wish { speed_m_per_s: wish.speed_m_per_s * speed_share, ..wish }
            }
            // A base that cannot turn in place waits until it may creep on.
            Freedom::LookAround { .. } if self.circle.is_some() => Wish::default(),
            // The robot turns in place to see more: a round robot that turns about its own middle touches nothing, and its floor camera
            // sees other joints.
            Freedom::LookAround { turn_rad_per_s } => Wish { speed_m_per_s: 0.0, turn_rad_per_s },
            Freedom::Halt => Wish::default(),
        };
        self.actuate(wish)
    }

    /// Whether the route has not begun yet, so that the robot rests.
    fn rests(&self, time_s: f64) -> bool {
        self.scene.route.as_ref().is_some_and(|route| time_s < route.begins_s)
    }

    /// Motion that approaches the wanted speed and turn rate as fast as the tyres should bear.
    fn actuate(&mut self, wish: Wish) -> DriveCommand {
        let speed_m_per_s = self.speed.follow(wish.speed_m_per_s, PERIOD_S);
        let turn_rad_per_s = match self.circle {
            // The turn rate goes with the speed, so that the steering angle stays as the curve asks for it. The base limits the rate of that angle.
            Some(_) => speed_m_per_s * self.curvature_per_m,
            None => self.turn.follow(wish.turn_rad_per_s, PERIOD_S),
        };
        DriveCommand { speed_m_per_s, turn_rad_per_s }
    }

    /// The speed and turn rate that the route asks for at a time.
    fn wish(&mut self, time_s: f64) -> Wish {
        if self.path.is_none() {
            let place_m = [self.pose.x_m, self.pose.y_m];
            self.path = self.scene.route.as_ref().map(|route| Path::new(place_m, route));
        }
        let Some(path) = self.path.take() else { return Wish::default() };
        self.watch_progress(&path, time_s);
        let wish = match self.stage {
            Stage::Finished => Wish::default(),
            Stage::Stand { until_s } => self.stand(&path, until_s, time_s),
            Stage::Turn => self.turn(&path),
            Stage::Drive => self.drive(&path),
        };
        self.path = Some(path);
        wish
    }

    /// Gives up a turn that does not end, and a waypoint that does not come closer, for example one behind a wall.
    fn watch_progress(&mut self, path: &Path, time_s: f64) {
        let left_m =
            path.segment(self.segment_idx).map_or(0.0, |segment| segment.length_m - segment.foot_m(self.place_m()));
        let gets_on = match self.circle {
            // A car that circles about a waypoint moves all the time, but comes no closer.
            Some(_) => left_m < self.progress.left_m - PROGRESS_M,
            None => (left_m - self.progress.left_m).abs() > PROGRESS_M,
        };
        if gets_on || !matches!(self.stage, Stage::Drive | Stage::Turn) {
            self.progress = Progress { left_m, at_s: time_s };
        } else if time_s - self.progress.at_s > STUCK_S {
            self.progress = Progress { left_m, at_s: time_s };
            self.go_on_after(path, self.segment_idx);
        }
    }

    /// Brings the robot to a stand, waits as long as the waypoint asks for, then turns to the next waypoint.
    fn stand(&mut self, path: &Path, until_s: Option<f64>, time_s: f64) -> Wish {
        if self.speed.value() == 0.0 && self.turn.value() == 0.0 {
            let pause_s = path.waypoint(self.segment_idx).map_or(0.0, |waypoint| waypoint.pause_s);
            let until_s = until_s.unwrap_or(time_s + pause_s);
            self.stage = Stage::Stand { until_s: Some(until_s) };
            if time_s >= until_s {
                self.go_on_after(path, self.segment_idx);
            }
        }
        Wish::default()
    }

    fn go_on_after(&mut self, path: &Path, segment_idx: usize) {
        self.segment_idx = segment_idx + 1;
        self.stage = match (path.waypoint(self.segment_idx), &self.circle) {
            (None, _) => Stage::Finished,
            (Some(_), None) => Stage::Turn,
            (Some(_), Some(_)) => Stage::Drive,
        };
        if self.circle.is_some() {
            self.progress.left_m = f64::INFINITY;
        }
    }

    /// Turns the robot in place until it faces the look-ahead point on the path.
    fn turn(&mut self, path: &Path) -> Wish {
        let (off_rad, _) = self.way_ahead(path);
        if off_rad.abs() < FACING_RAD {
            if self.turn.value().abs() < STILL_RAD_PER_S {
                self.stage = Stage::Drive;
            }
            return Wish::default();
        }
        let robot = &self.scene.robot;
        let braking_rad_per_s2 = 0.5 * robot.max_acceleration_m_per_s2 / robot.base.track_m;
        let rate_rad_per_s = (2.0 * braking_rad_per_s2 * off_rad.abs())
            .sqrt()
            .min(TURN_GAIN_PER_S * off_rad.abs())
            .min(self.turn_limit_rad_per_s());
        Wish { speed_m_per_s: 0.0, turn_rad_per_s: off_rad.signum() * rate_rad_per_s }
    }

    /// Pure pursuit (Coulter 1992): the robot follows the arc that starts along its heading and leads to the look-ahead point, of curvature
    /// `κ = 2·y/d²`.
    fn drive(&mut self, path: &Path) -> Wish {
        let place_m = self.place_m();
        while let Some(segment) = path.segment(self.segment_idx)
            && !path.stops_after(self.segment_idx)
            && (segment.foot_m(place_m) >= segment.length_m
                || path
                    .segment(self.segment_idx + 1)
                    .is_some_and(|next| next.distance_m(place_m) < segment.distance_m(place_m)))
        {
            self.segment_idx += 1;
            if self.circle.is_some() {
                self.progress.left_m = f64::INFINITY;
            }
        }
        let Some((segment, waypoint)) = path.segment(self.segment_idx).zip(path.waypoint(self.segment_idx)) else {
            self.stage = Stage::Finished;
            return Wish::default();
        };
        let left_m = segment.length_m - segment.foot_m(place_m);
        if path.stops_after(self.segment_idx) && left_m < ARRIVED_M {
            self.stage = Stage::Stand { until_s: None };
            return Wish::default();
        }
        let (off_rad, distance_m) = self.way_ahead(path);
        if off_rad.abs() > TURN_FIRST_RAD && self.circle.is_none() {
            self.stage = Stage::Turn;
            return Wish::default();
        }
        let mut curvature_per_m = 2.0 * off_rad.sin() / distance_m;
        if let Some(circle) = &self.circle {
            // Towards a point behind, the sharpest curve leads soonest.
            let sharpest_per_m = 1.0 / circle.radius_m;
            let is_behind = off_rad.abs() > FRAC_PI_2;
            let wanted_per_m = if is_behind { off_rad.signum() * sharpest_per_m } else { curvature_per_m };
            curvature_per_m = wanted_per_m.clamp(-sharpest_per_m, sharpest_per_m);
            self.curvature_per_m = curvature_per_m;
        }
        let limit_m_per_s = waypoint
            .speed_m_per_s
            .min(self.scene.robot.max_speed_m_per_s)
            .min(self.curve_speed_m_per_s(curvature_per_m))
            .min(self.approach_speed_m_per_s(path, left_m));
        let turn_rad_per_s = self.speed.value() * curvature_per_m;
        let turn_limit = self.turn_limit_rad_per_s();
        Wish { speed_m_per_s: limit_m_per_s, turn_rad_per_s: turn_rad_per_s.clamp(-turn_limit, turn_limit) }
    }

    /// Greatest speed from which the robot can still slow down, by the end of the segment, to the speed that the corner there allows.
    fn approach_speed_m_per_s(&self, path: &Path, left_m: f64) -> f64 {
        // Only half of the robot's acceleration limit is planned with. The other half is kept for the acceleration's rise time and for
        // jumps of the estimate.
        let braking_m_per_s2 = 0.5 * self.scene.robot.max_acceleration_m_per_s2;
        if path.stops_after(self.segment_idx) {
            return (2.0 * braking_m_per_s2 * left_m.max(0.0)).sqrt() + CREEP_M_PER_S;
        }
        let look_ahead_m = self.look_ahead_m();
        let corner_rad = path.corner_rad(self.segment_idx).unwrap_or(0.0);
        // The look-ahead point goes round the corner while the robot does, so that the robot sees it at about two thirds of the corner's
        // angle.
        let sharpest_per_m = self.circle.map_or(f64::INFINITY, |circle| 1.0 / circle.radius_m);
        let curvature_per_m = (2.0 * (0.67 * corner_rad).sin() / look_ahead_m).min(sharpest_per_m);
        let corner_m_per_s = self.curve_speed_m_per_s(curvature_per_m);
        (corner_m_per_s * corner_m_per_s + 2.0 * braking_m_per_s2 * (left_m - look_ahead_m).max(0.0)).sqrt()
    }

    /// Greatest speed in a curve: within the turn rate's limit, and with a sideways acceleration no greater than the limit of the forward
    /// one.
    fn curve_speed_m_per_s(&self, curvature_per_m: f64) -> f64 {
        let sideways_m_per_s2 = self.scene.robot.max_acceleration_m_per_s2;
        let curvature_per_m = curvature_per_m.abs().max(1e-9);
        (self.turn_limit_rad_per_s() / curvature_per_m).min((sideways_m_per_s2 / curvature_per_m).sqrt())
    }

    /// Bearing of the look-ahead point against the robot's heading, in `[−π, π]`, and the distance of that point.
    fn way_ahead(&self, path: &Path) -> (f64, f64) {
        let along_m = path
            .segment(self.segment_idx)
            .map_or(0.0, |segment| segment.foot_m(self.place_m()).clamp(0.0, segment.length_m));
        let ahead_m = path.ahead_m(self.segment_idx, along_m, self.look_ahead_m());
        let (x_m, y_m) = (ahead_m[0] - self.pose.x_m, ahead_m[1] - self.pose.y_m);
        let (sin, cos) = self.pose.heading_rad.sin_cos();
        let (forward_m, left_m) = (cos * x_m + sin * y_m, cos * y_m - sin * x_m);
        (left_m.atan2(forward_m), forward_m.hypot(left_m).max(1e-6))
    }

    fn look_ahead_m(&self) -> f64 {
        let by_base_m = match &self.circle {
            Some(circle) => LOOK_AHEAD_OVER_CIRCLE * circle.radius_m,
            None => LOOK_AHEAD_OVER_TRACK * self.scene.robot.base.track_m,
        };
        by_base_m + LOOK_AHEAD_S * self.speed.value()
    }

    fn turn_limit_rad_per_s(&self) -> f64 {
        0.95 * self.scene.robot.max_turn_rate_rad_per_s
    }

    fn place_m(&self) -> [f64; 2] {
        [self.pose.x_m, self.pose.y_m]
    }
}
