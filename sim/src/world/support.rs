//! Supports of the robot's body: damped springs above the points at which its base stands on the floor.

use rapier3d_f64::prelude::Vector;

use crate::{base::Foot, place::floor::Ground, scene::Scene, world::Drawn};

use super::{GRAVITY_M_PER_S2, chassis::BodyState};

/// Stiffness of a support per robot mass: 30 kN/m under 9 kg, so that a wheel's tyre yields by 1.2 mm.
const STIFFNESS_PER_KG: f64 = 30_000.0 / 9.0;

/// Damping of a support per robot mass: 500 N·s/m under 9 kg, about critical for heave.
const DAMPING_PER_KG: f64 = 500.0 / 9.0;

/// A damped spring between the robot's body and the floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// Point where the support touches the floor when the body is at rest, robot frame.
    pub(super) foot_in_robot: Vector,
    rest_load_n: f64,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

impl Support {
    /// The supports under the feet of the robot's base, in the order of these feet. Together they bear the weight with the body level.
    pub(super) fn all(scene: &Scene, drawn: &Drawn) -> Vec<Support> {
        let robot = &scene.robot;
        let weight_n = robot.mass_kg * GRAVITY_M_PER_S2;
        let support = |foot: Foot| Support {
            foot_in_robot: Vector::new(foot.place_m[0], foot.place_m[1], 0.0),
            rest_load_n: foot.weight_share * weight_n,
            stiffness_n_per_m: STIFFNESS_PER_KG * robot.mass_kg * foot.relative_stiffness,
            damping_n_s_per_m: DAMPING_PER_KG * robot.mass_kg * foot.relative_stiffness,
        };
        robot.base.drivetrain().feet(robot, &drawn.base).into_iter().map(support).collect()
    }

    /// Point in the world where the support touches the floor.
    pub(super) fn foot(&self, body: &BodyState) -> Vector {
        body.world_point(self.foot_in_robot)
    }

    /// Vertical force of the ground at the foot: `N = N₀ − k·z − c·ż` with the foot's height z over the ground, never pulling.
    pub(super) fn load_n(&self, body: &BodyState, foot: Vector, ground: &Ground) -> f64 {
        let velocity = body.velocity_at(foot);
        let rise_m_per_s = velocity.z - (ground.slope[0] * velocity.x + ground.slope[1] * velocity.y);
        let above_m = foot.z - ground.height_m;
        let load_n = self.rest_load_n - self.stiffness_n_per_m * above_m - self.damping_n_s_per_m * rise_m_per_s;
        load_n.max(0.0)
    }
}
