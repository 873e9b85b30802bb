//! Hands that lift the robot off the floor, carry and turn it, and put it down.

use std::f64::consts::PI;

use rapier3d_f64::prelude::Vector;

use crate::scene::{Event, Scene};

use super::{GRAVITY_M_PER_S2, chassis::BodyState};

/// Share of a lift's duration in which the robot is raised, and again in which it is put down. It is carried in between.
const RAISE_SHARE: f64 = 0.2;

/// Height to which a lift raises the robot: higher than its springs and the highest carpet reach.
const HEIGHT_M: f64 = 0.06;

/// Bandwidth of the critically damped control by which hands hold the lifted robot; the same as for a push.
const GRIP_PER_S: f64 = 200.0;

/// A lift of the robot by hands.
#[derive(Clone, Debug)]
pub(super) struct Lift {
    at_s: f64,
    lasts_s: f64,
    displacement_m: [f64; 2],
    turn_rad: f64,
    mass_kg: f64,
    inertia_kg_m2: f64,
    /// Where the robot was taken up: its origin, its heading, and the displacement of the whole lift in the world frame.
    taken: Option<(Vector, f64, Vector)>,
}

impl Lift {
    /// All lifts that the scene's events state.
    pub(super) fn all(scene: &Scene) -> Vec<Lift> {
        let (mass_kg, radius_m) = (scene.robot.mass_kg, scene.robot.body_radius_m);
        let lift = |event: &Event| match *event {
            Event::Lift { at_s, displacement_m, turn_deg, lasts_s } => Some(Lift {
                at_s,
                lasts_s,
                displacement_m,
                turn_rad: turn_deg.to_radians(),
                mass_kg,
                inertia_kg_m2: 0.5 * mass_kg * radius_m * radius_m,
                taken: None,
            }),
            _ => None,
        };
        scene.events.iter().filter_map(lift).collect()
    }

    /// Force at the centre of mass and torque on the body, or `None` while no hands are on the robot. `borne_n` is the part of the weight
    /// that the floor bears.
    pub(super) fn act(
        &mut self,
        time_s: f64,
        body: &BodyState,
        heading_rad: f64,
        borne_n: f64,
    ) -> Option<(Vector, Vector)> {
        let phase = (time_s - self.at_s) / self.lasts_s;
        if !(0.0..1.0).contains(&phase) {
            return None;
        }
        let origin = body.world_from_robot.translation;
        let [forward_m, left_m] = self.displacement_m;
        let (taken, heading_then_rad, way) =
            *self.taken.get_or_insert((origin, heading_rad, body.forward * forward_m + body.left * left_m));
        let (raised, raised_rate) = raised(phase);
        let (carried, carried_rate) = eased((phase - RAISE_SHARE) / (1.0 - 2.0 * RAISE_SHARE));
        let carried_rate = carried_rate / (1.0 - 2.0 * RAISE_SHARE);
        let target = taken + way * carried + Vector::Z * (HEIGHT_M * raised);
        let target_velocity = (way * carried_rate + Vector::Z * (HEIGHT_M * raised_rate)) / self.lasts_s;
        let (off_place, off_velocity) = (target - origin, target_velocity - body.velocity_m_per_s);
        let weight = Vector::Z * (self.mass_kg * GRAVITY_M_PER_S2 - borne_n);
        let force_n = (off_place * GRIP_PER_S + off_velocity * 2.0) * (GRIP_PER_S * self.mass_kg) + weight;
        // The torque turns the lifted body upright and to the heading that the lift has reached.
        let off_heading_rad = heading_then_rad + self.turn_rad * carried - heading_rad;
        let off_attitude = (body.world_from_robot.rotation * Vector::Z).cross(Vector::Z) + Vector::Z * off_heading_rad;
        let off_turn = Vector::Z * (self.turn_rad * carried_rate / self.lasts_s) - body.turn_rad_per_s;
        let torque_n_m = (off_attitude * GRIP_PER_S + off_turn * 2.0) * (GRIP_PER_S * self.inertia_kg_m2);
        Some((force_n, torque_n_m))
    }
}

/// Height of the robot as a share of the lift's greatest height, at a share of the lift's duration, and the derivative of the former by the
/// latter.
fn raised(phase: f64) -> (f64, f64) {
    let (up, up_rate) = eased(phase / RAISE_SHARE);
    let (down, down_rate) = eased((1.0 - phase) / RAISE_SHARE);
    if phase < 0.5 { (up, up_rate / RAISE_SHARE) } else { (down, -down_rate / RAISE_SHARE) }
}

/// A smooth transition from 0 to 1 without a jump of speed, and its derivative.
fn eased(phase: f64) -> (f64, f64) {
    let phase = phase.clamp(0.0, 1.0);
    (0.5 - 0.5 * (PI * phase).cos(), 0.5 * PI * (PI * phase).sin())
}
