//! Paper 5's control law for errands: turn towards the next corner of the path, then drive to it.

use localizer::Pose;

use super::{CREEP_M_PER_S, FACING_RAD, STILL_RAD_PER_S, TURN_GAIN_PER_S, Wish};

/// Distance at which a corner of the path counts as reached.
const CORNER_M: f64 = 0.03;

/// Turn rate per angle of heading error while driving. The paper's law turns only at standstill, but between two stops an error of a few
/// degrees would lead centimetres astray.
const HOLD_GAIN_PER_S: f64 = 2.0;

/// Heading error beyond which the robot stops to turn again, unless it has reached the corner.
const TURN_AGAIN_RAD: f64 = 0.5;

/// Direction and distance of a point as seen from the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing {
    /// The robot's heading minus the direction to the point, in (−π, π]; positive if the point lies to the right.
    pub off_rad: f64,
    /// Distance from the robot to the point.
    pub distance_m: f64,
}

/// Bearing of the point d from the robot r: θ = α − atan2(y_d − y_r, x_d − x_r), wrapped, and d = √((x_d − x_r)² + (y_d − y_r)²) (paper 5, Eqs.
/// 18 and 19). Eq. 18 is printed with the arctan of a quotient, which cannot tell ahead from behind; atan2 is used instead.
pub fn bearing(robot: Pose, place_m: [f64; 2]) -> Bearing {
    let (x_m, y_m) = (place_m[0] - robot.x_m, place_m[1] - robot.y_m);
    let off_rad = robot.heading_rad - y_m.atan2(x_m);
    // The angle is wrapped into (−π, π], with π and not −π for a point straight behind.
    let turns = std::f64::consts::TAU;
    let wrapped_rad = std::f64::consts::PI - (std::f64::consts::PI - off_rad).rem_euclid(turns);
    Bearing { off_rad: wrapped_rad, distance_m: x_m.hypot(y_m) }
}

/// Limits on speed, turn rate and braking that the control law of paper 5 keeps to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) speed_m_per_s: f64,
    pub(super) turn_rad_per_s: f64,
    /// Braking deceleration along the floor; turns brake with this value over the track.
    pub(super) braking_m_per_s2: f64,
    pub(super) track_m: f64,
}

/// The control law of paper 5, with its progress along the corners of a path.
#[derive(Clone, Debug)]
pub(super) struct TurnThenDrive {
    corners_m: Vec<[f64; 2]>,
    /// Index of the corner of the path to which the robot is heading.
    next: usize,
    is_turning: bool,
}

impl TurnThenDrive {
    /// Paper 5's control law for following a path from its first corner to its last.
    pub(super) fn new(corners_m: Vec<[f64; 2]>) -> Self {
        TurnThenDrive { corners_m, next: 1, is_turning: true }
    }

    /// Whether the last corner of the path has been reached.
    pub(super) fn is_finished(&self) -> bool {
        self.next >= self.corners_m.len()
    }

    /// Speed and turn rate that the control law asks for, at a pose and a present turn rate.
    pub(super) fn wish(&mut self, pose: Pose, turn_rad_per_s: f64, limits: &Limits) -> Wish {
        let Some(&corner_m) = self.corners_m.get(self.next) else { return Wish::default() };
        let Bearing { off_rad, distance_m } = bearing(pose, corner_m);
        let is_passed = distance_m <= 3.0 * CORNER_M && off_rad.abs() > std::f64::consts::FRAC_PI_2;
        if distance_m <= CORNER_M || is_passed {
            self.next += 1;
            self.is_turning = true;
            return Wish::default();
        }
        if self.is_turning && off_rad.abs() < FACING_RAD && turn_rad_per_s.abs() < STILL_RAD_PER_S {
            self.is_turning = false;
        } else if !self.is_turning && off_rad.abs() > TURN_AGAIN_RAD {
            self.is_turning = true;
        }
        if self.is_turning {
            if off_rad.abs() < FACING_RAD {
                return Wish::default();
            }
            let braking_rad_per_s2 = limits.braking_m_per_s2 / limits.track_m;
            let rate_rad_per_s = (2.0 * braking_rad_per_s2 * off_rad.abs())
                .sqrt()
                .min(TURN_GAIN_PER_S * off_rad.abs())
                .min(limits.turn_rad_per_s);
            return Wish { speed_m_per_s: 0.0, turn_rad_per_s: -off_rad.signum() * rate_rad_per_s };
        }
        let left_m = (distance_m - CORNER_M).max(0.0);
        let approach_m_per_s = (2.0 * limits.braking_m_per_s2 * left_m).sqrt() + CREEP_M_PER_S;
        let turn_rad_per_s = (-HOLD_GAIN_PER_S * off_rad).clamp(-limits.turn_rad_per_s, limits.turn_rad_per_s);
        Wish { speed_m_per_s: approach_m_per_s.min(limits.speed_m_per_s), turn_rad_per_s }
    }
}
