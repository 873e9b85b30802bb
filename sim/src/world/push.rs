//! A hand that pushes the robot's body by a stated distance while the wheels go on turning.

use localizer::Pose;
use rapier3d_f64::prelude::Vector;

use crate::scene::{Event, Scene};

use super::{GRAVITY_M_PER_S2, chassis::BodyState};

/// Share of a push in which the hand accelerates, and again in which it slows down. Its peak speed is `1/(1 − share)` = 1.11 times the
/// mean.
const RAMP_SHARE: f64 = 0.1;

/// Bandwidth of the critically damped control by which the hand holds the body to its path. Tyres that slide fully pull the body off the
/// path by 0.2 mm; above 400 per second the control rings with the 1 ms steps.
const GRIP_PER_S: f64 = 200.0;

/// Greatest force of the hand over the robot's weight: more than the tyres' grip at the greatest friction, 1.7, and little enough for the
/// walls to withstand.
const FORCE_LIMIT_OVER_WEIGHT: f64 = 3.0;

/// A push of the robot by a hand.
#[derive(Clone, Debug)]
pub(super) struct Push {
    at_s: f64,
    lasts_s: f64,
    displacement_m: [f64; 2],
    mass_kg: f64,
    inertia_kg_m2: f64,
    progress: Option<Progress>,
}

/// State of a push that has begun.
#[derive(Clone, Copy, Debug)]
struct Progress {
    /// Pose to which the wheels alone would have brought the robot.
    wheels_alone: Pose,
    /// Displacement of the robot by the whole push, world frame.
    displacement: Vector,
}

/// Distance and turn by which the rolling of the wheels moves the robot in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rolled {
    /// Mean rolled distance of both wheels.
    pub(super) forward_m: f64,
    /// Turn by rolling: the right wheel's distance minus the left wheel's, over the track.
    pub(super) turn_rad: f64,
}

impl Push {
    /// All pushes that the scene's events state.
    pub(super) fn all(scene: &Scene) -> Vec<Push> {
        let (mass_kg, radius_m) = (scene.robot.mass_kg, scene.robot.body_radius_m);
        let push = |event: &Event| match *event {
            Event::Push { at_s, displacement_m, lasts_s } => Some(Push {
                at_s,
                lasts_s,
                displacement_m,
                mass_kg,
                inertia_kg_m2: 0.5 * mass_kg * radius_m * radius_m,
                progress: None,
            }),
            _ => None,
        };
        scene.events.iter().filter_map(push).collect()
    }

    /// Force on the body and torque about its vertical, or `None` when the hand is off.
    ///
    /// `deflection` is the distance by which the tyres' bristles hold the body back, world frame. The rubber springs back when the hand
    /// lets go. The hand therefore carries the body farther by this distance in the end, so that the robot comes to rest where the push was
    /// meant to take it.
    pub(super) fn act(
        &mut self,
        time_s: f64,
        body: &BodyState,
        heading_rad: f64,
        deflection: Vector,
        rolled: Rolled,
        step_s: f64,
    ) -> Option<(Vector, f64)> {
        let phase = (time_s - self.at_s) / self.lasts_s;
        if !(0.0..1.0).contains(&phase) {
            return None;
        }
        let origin = body.world_from_robot.translation;
        let [forward_m, left_m] = self.displacement_m;
        let progress = self.progress.get_or_insert_with(|| Progress {
            wheels_alone: Pose { x_m: origin.x, y_m: origin.y, heading_rad },
            displacement: body.forward * forward_m + body.left * left_m,
        });
        let wheels = &mut progress.wheels_alone;
        let (sin, cos) = (wheels.heading_rad + 0.5 * rolled.turn_rad).sin_cos();
        let rolled_step = Vector::new(cos, sin, 0.0) * rolled.forward_m;
        wheels.x_m += rolled_step.x;
        wheels.y_m += rolled_step.y;
        wheels.heading_rad += rolled.turn_rad;

        let (share, share_rate) = ramped(phase);
        let place = Vector::new(wheels.x_m, wheels.y_m, 0.0) + progress.displacement * share;
        let velocity = rolled_step / step_s + progress.displacement * (share_rate / self.lasts_s);
        let mut off_place = place - (origin + deflection * share);
        let mut off_velocity = velocity - body.velocity_m_per_s;
        off_place.z = 0.0;
        off_velocity.z = 0.0;
        let force_n = (off_place * GRIP_PER_S + off_velocity * 2.0) * (GRIP_PER_S * self.mass_kg);
        let limit_n = FORCE_LIMIT_OVER_WEIGHT * self.mass_kg * GRAVITY_M_PER_S2;
        let off_heading_rad = wheels.heading_rad - heading_rad;
        let off_turn_rad_per_s = rolled.turn_rad / step_s - body.turn_rad_per_s.z;
        let torque_n_m = (off_heading_rad * GRIP_PER_S + off_turn_rad_per_s * 2.0) * (GRIP_PER_S * self.inertia_kg_m2);
        Some((force_n.clamp_length_max(limit_n), torque_n_m))
    }
}

/// Share of a push's displacement that is done at a share of the push's time, and the derivative of the former by the latter: the speed has a
/// trapezoidal profile.
fn ramped(phase: f64) -> (f64, f64) {
    let peak = 1.0 / (1.0 - RAMP_SHARE);
    if phase < RAMP_SHARE {
        (peak * phase * phase / (2.0 * RAMP_SHARE), peak * phase / RAMP_SHARE)
    } else if phase < 1.0 - RAMP_SHARE {
        (peak * (phase - 0.5 * RAMP_SHARE), peak)
    } else {
        let left = 1.0 - phase;
        (1.0 - peak * left * left / (2.0 * RAMP_SHARE), peak * left / RAMP_SHARE)
    }
}
