//! Keeps the true state of the robot: the pose with its heading unwrapped, and the distances travelled, accumulated so that they agree with the
//! pose.

use localizer::Pose;
use rapier3d_f64::prelude::Vector;

use crate::{
    truth::{STEP_S, Truth},
    world::Drawn,
};

use super::{chassis::BodyState, drive::Wheel};

/// Integrates the true state of the robot from step to step.
#[derive(Clone, Debug)]
pub(super) struct Odometer {
    truth: Truth,
    forward: Vector,
    track_m: f64,
}

impl Odometer {
    /// The truth at time 0.
    pub(super) fn new(drawn: &Drawn, body: &BodyState) -> Self {
        let truth = Truth { pose: drawn.start, ..Truth::default() };
        Odometer { truth, forward: body.forward, track_m: drawn.base.track_m }
    }

    /// The true state of the robot after the last step.
    pub(super) fn truth(&self) -> Truth {
        self.truth
    }

    /// Updates the true state of the robot by one step of the body, at whose end the base is steered by the given angle.
    pub(super) fn advance(&mut self, time_s: f64, body: &BodyState, wheels: &[Wheel], steering_rad: f64) -> Truth {
        let truth = &mut self.truth;
        let origin = body.world_from_robot.translation;
        let turn_rad = self.forward.cross(body.forward).z.atan2(self.forward.dot(body.forward));
        // A body that turns evenly during the step moves along the mean direction; its path is longer than the chord by the factor
        // (Δθ/2)/sin(Δθ/2), which exceeds 1 by 4·10⁻⁸ at 1 rad/s.
        let mean_forward = (self.forward + body.forward).normalize();
        let mean_left = Vector::new(-mean_forward.y, mean_forward.x, 0.0);
        let chord = Vector::new(origin.x - truth.pose.x_m, origin.y - truth.pose.y_m, 0.0);
        let path = chord * (1.0 + turn_rad * turn_rad / 24.0);
        let half_turn_m = 0.5 * self.track_m * turn_rad;
        let (forward_m, left_m) = (path.dot(mean_forward), path.dot(mean_left));
        truth.wheel_travel_m[0] += forward_m - half_turn_m;
        truth.wheel_travel_m[1] += forward_m + half_turn_m;
        truth.lateral_travel_m += left_m;
        truth.velocity = [forward_m / STEP_S, left_m / STEP_S, turn_rad / STEP_S];

        truth.time_s = time_s;
        truth.pose = Pose { x_m: origin.x, y_m: origin.y, heading_rad: truth.pose.heading_rad + turn_rad };
        truth.heave_m = origin.z;
        truth.tilt_rad = tilt_rad(body);
        truth.wheel_angle_rad = [0, 1].map(|idx: usize| wheels[idx].angle_rad);
        truth.steering_rad = steering_rad;
        self.forward = body.forward;
        *truth
    }
}

/// Roll and pitch of the body: with `R = Rz(yaw)·Ry(pitch)·Rx(roll)`, robot y rises by `cos(pitch)·sin(roll)`, robot x by `−sin(pitch)`.
fn tilt_rad(body: &BodyState) -> [f64; 2] {
    let rotation = body.world_from_robot.rotation;
    let roll_rad = (rotation * Vector::Y).z.atan2((rotation * Vector::Z).z);
    [roll_rad, -(rotation * Vector::X).z.asin()]
}
