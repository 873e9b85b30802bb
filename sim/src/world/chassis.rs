//! The robot's body in rapier: one rigid body, with walls, furniture and people as colliders. The wheels are not part of it.
//!
//! rapier's vector types are used in `world` only. Frame `robot` is the frame of the rigid body.

use rapier3d_f64::prelude::*;

use crate::{base::balance_m, place::building::GroundPlan, scene::Scene, truth::STEP_S, world::Drawn};

use super::GRAVITY_M_PER_S2;

/// Height of the centre of mass over the body's radius, for a robot with batteries low and a deck above.
const CENTRE_OF_MASS_OVER_RADIUS: f64 = 0.5;

/// Width by which the collider (the shape with which rapier finds contacts) exceeds the robot's body. rapier's contacts are soft, so that the
/// collider sinks into a wall, at 0.5 m/s and with both motors pushing by less than a fifth of this width; the body itself never does.
const SKIN_M: f64 = 0.001;

/// Distance between the robot and a surface at which rapier prepares contacts. With its default of 20 mm every step along a wall would cost the
/// time of a contact.
const PREDICTION_M: f64 = 0.005;

/// Friction between the robot's body and a wall, for smooth plastic on plaster.
const WALL_FRICTION: f64 = 0.2;

/// The robot's body and everything that it can run into.
pub(super) struct Chassis {
    physics: PhysicsWorld,
    body: RigidBodyHandle,
    people: Vec<RigidBodyHandle>,
    /// Velocity of the robot's origin and angular velocity before the last step, world frame.
    before: [Vector; 2],
}

impl Clone for Chassis {
    /// Copies everything that a step of the simulation depends on; rapier's pipelines are working memory and are made anew.
    fn clone(&self) -> Self {
        let from = &self.physics;
        let physics = PhysicsWorld {
            gravity: from.gravity,
            integration_parameters: from.integration_parameters,
            islands: from.islands.clone(),
            broad_phase: from.broad_phase.clone(),
            narrow_phase: from.narrow_phase.clone(),
            bodies: from.bodies.clone(),
            colliders: from.colliders.clone(),
            impulse_joints: from.impulse_joints.clone(),
            multibody_joints: from.multibody_joints.clone(),
            soft_bodies: from.soft_bodies.clone(),
            ..PhysicsWorld::default()
        };
        Chassis { physics, body: self.body, people: self.people.clone(), before: self.before }
    }
}

/// Position, orientation and motion of the robot's body.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyState {
    /// Pose of the body in the world, `world_from_robot`.
    pub(super) world_from_robot: Pose,
    /// Velocity of the robot's origin, world frame.
    pub(super) velocity_m_per_s: Vector,
    /// Angular velocity of the body, world frame.
    pub(super) turn_rad_per_s: Vector,
    /// Unit vector in the floor plane along robot x, world frame.
    pub(super) forward: Vector,
    /// Unit vector in the floor plane to the left of `forward`, world frame.
    pub(super) left: Vector,
    /// Motion of the body in the middle of the coming step, if forces stay as they are.
    pub(super) coming: Coming,
}

/// Motion of the body halfway through the coming step.
///
/// rapier moves a body by the velocity after a step, so that the present velocity belongs to the middle of the last step. If the wheels' rolling
/// were compared with it, the wheels would seem to slip by `a·Δt` under an acceleration a, and sideways by `v·ω·Δt/2`, which is as much as tyres
/// really slip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coming {
    velocity_m_per_s: Vector,
    turn_rad_per_s: Vector,
    forward: Vector,
}

impl Chassis {
    /// The body at its true start, at rest, in the room.
    pub(super) fn new(scene: &Scene, drawn: &Drawn) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -GRAVITY_M_PER_S2);
        let parameters = &mut physics.integration_parameters;
        parameters.dt = STEP_S;
        parameters.normalized_prediction_distance = PREDICTION_M;
        // rapier's reuse of contacts of earlier steps is off, because these can be off by more than the tolerances of this world.
        parameters.contact_recycling = false;
        // With rapier's default contact softness (60 Hz at ten times critical damping) a body that is pushed at 2 m/s would enter the wall
        // by 3 mm.
        parameters.static_contact_softness = SpringCoefficients::new(300.0, 2.0);
        // One solver iteration is enough, because the forces of tyres and springs are constant during a step.
        parameters.num_solver_iterations = 1;
        // Continuous collision detection is off, because nothing here moves fast against its size.
        parameters.max_ccd_substeps = 0;
        build_walls(&mut physics, scene);
        build_furniture(&mut physics, scene);
        let people = build_people(&mut physics, scene);
        let start = drawn.start;
        let body = RigidBodyBuilder::dynamic()
            .translation(Vector::new(start.x_m, start.y_m, 0.0))
            .rotation(Vector::new(0.0, 0.0, start.heading_rad))
            .additional_mass_properties(mass_properties(scene, drawn))
            .can_sleep(false)
            .build();
        let body = physics.bodies.insert(body);
        let radius_m = scene.robot.body_radius_m;
        // rapier's cylinders stand along y, so that the body is turned to stand along z.
        let collider = ColliderBuilder::cylinder(0.4 * radius_m, radius_m + SKIN_M)
            .rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0))
            .translation(Vector::new(0.0, 0.0, CENTRE_OF_MASS_OVER_RADIUS * radius_m))
            .density(0.0)
            .friction(WALL_FRICTION)
            .build();
        physics.colliders.insert_with_parent(collider, body, &mut physics.bodies);
        Chassis { physics, body, people, before: [Vector::ZERO; 2] }
    }

    /// State of the body after the last step.
    pub(super) fn state(&self) -> BodyState {
        let body = &self.physics.bodies[self.body];
        let world_from_robot = *body.position();
        let robot_x = world_from_robot.rotation * Vector::X;
        let forward = Vector::new(robot_x.x, robot_x.y, 0.0).normalize();
        let left = Vector::new(-forward.y, forward.x, 0.0);
        let (velocity_m_per_s, turn_rad_per_s) = (body.velocity_at_point(world_from_robot.translation), body.angvel());
        let coming = Coming {
            velocity_m_per_s: velocity_m_per_s * 2.0 - self.before[0],
            turn_rad_per_s: turn_rad_per_s * 2.0 - self.before[1],
            forward: (forward + left * (0.5 * STEP_S * turn_rad_per_s.z)).normalize(),
        };
        BodyState { world_from_robot, velocity_m_per_s, turn_rad_per_s, forward, left, coming }
    }

    /// The body's centre of mass, world frame.
    pub(super) fn centre_of_mass(&self) -> Vector {
        self.physics.bodies[self.body].center_of_mass()
    }

    /// Removes the forces of the last step, which rapier would keep otherwise.
    pub(super) fn release(&mut self) {
        let body = &mut self.physics.bodies[self.body];
        body.reset_forces(false);
        body.reset_torques(false);
    }

    /// Adds a force at a point of the body for the next step, both in the world frame.
    pub(super) fn push(&mut self, force_n: Vector, point_m: Vector) {
        self.physics.bodies[self.body].add_force_at_point(force_n, point_m, false);
    }

    /// Adds a torque on the body for the next step, world frame.
    pub(super) fn twist(&mut self, torque_n_m: Vector) {
        self.physics.bodies[self.body].add_torque(torque_n_m, false);
    }

    /// Sets the position at which a person is at the end of the next step.
    pub(super) fn place_person(&mut self, index: usize, place_m: [f64; 2]) {
        let Some(body) = self.people.get(index).and_then(|handle| self.physics.bodies.get_mut(*handle)) else { return };
        let height_m = body.translation().z;
        body.set_next_kinematic_translation(Vector::new(place_m[0], place_m[1], height_m));
    }

    /// Advances the body by one step.
    pub(super) fn advance(&mut self, now: &BodyState) {
        self.before = [now.velocity_m_per_s, now.turn_rad_per_s];
        self.physics.step();
    }
}

impl BodyState {
    /// The world position of a point given in the robot frame.
    pub(super) fn world_point(&self, point_in_robot: Vector) -> Vector {
        self.world_from_robot.translation + self.world_from_robot.rotation * point_in_robot
    }

    /// Velocity of a point of the body, world frame.
    pub(super) fn velocity_at(&self, point_in_world: Vector) -> Vector {
        self.velocity_m_per_s + self.turn_rad_per_s.cross(point_in_world - self.world_from_robot.translation)
    }
}

impl Coming {
    /// Velocity of a point of the body over the floor: forward and left.
    pub(super) fn over_floor(&self, body: &BodyState, point_in_world: Vector) -> [f64; 2] {
        let lever = point_in_world - body.world_from_robot.translation;
        let velocity = self.velocity_m_per_s + self.turn_rad_per_s.cross(lever);
        let left = Vector::new(-self.forward.y, self.forward.x, 0.0);
        [velocity.dot(self.forward), velocity.dot(left)]
    }
}

/// Mass properties of the body: those of an upright homogeneous cylinder, whose centre is above the point at which the feet of the base bear their
/// shares of the weight with the body level. For a differential drive that point is the middle of the axle, for a car it is before that.
fn mass_properties(scene: &Scene, drawn: &Drawn) -> MassProperties {
    let (mass_kg, radius_m) = (scene.robot.mass_kg, scene.robot.body_radius_m);
    let [forward_m, left_m] = balance_m(&scene.robot.base.drivetrain().feet(&scene.robot, &drawn.base));
    let centre_m = CENTRE_OF_MASS_OVER_RADIUS * radius_m;
    let height_m = 2.0 * centre_m;
    let upright_kg_m2 = mass_kg * radius_m * radius_m / 2.0;
    let level_kg_m2 = mass_kg * (3.0 * radius_m * radius_m + height_m * height_m) / 12.0;
    let inertia_kg_m2 = Vector::new(level_kg_m2, level_kg_m2, upright_kg_m2);
    MassProperties::new(Vector::new(forward_m, left_m, centre_m), mass_kg, inertia_kg_m2)
}

fn build_furniture(physics: &mut PhysicsWorld, scene: &Scene) {
    for piece in &scene.furniture {
        let collider = ColliderBuilder::cuboid(0.5 * piece.size_m[0], 0.5 * piece.size_m[1], 0.5 * piece.height_m)
            .translation(Vector::new(piece.x_m, piece.y_m, 0.5 * piece.height_m))
            .rotation(Vector::new(0.0, 0.0, piece.rotation_deg.to_radians()))
            .friction(WALL_FRICTION)
            .build();
        physics.colliders.insert(collider);
    }
}

fn build_people(physics: &mut PhysicsWorld, scene: &Scene) -> Vec<RigidBodyHandle> {
    let mut people = Vec::new();
    for person in &scene.people {
        let [x_m, y_m] = person.waypoints_m.first().copied().unwrap_or_default();
        let half_m = 0.5 * person.height_m;
        let body = RigidBodyBuilder::kinematic_position_based().translation(Vector::new(x_m, y_m, half_m)).build();
        let body = physics.bodies.insert(body);
        let collider = ColliderBuilder::cylinder(half_m, person.radius_m)
            .rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0))
            .friction(WALL_FRICTION)
            .build();
        physics.colliders.insert_with_parent(collider, body, &mut physics.bodies);
        people.push(body);
    }
    people
}

fn build_walls(physics: &mut PhysicsWorld, scene: &Scene) {
    let half_height_m = 1.0;
    for block in GroundPlan::of(scene).blocks() {
        let ([x_m, y_m], [half_x_m, half_y_m]) = (block.middle_m, block.half_m);
        let wall = ColliderBuilder::cuboid(half_x_m, half_y_m, half_height_m)
            .translation(Vector::new(x_m, y_m, half_height_m))
            .rotation(Vector::new(0.0, 0.0, block.heading_rad))
            .friction(WALL_FRICTION)
            .build();
        physics.colliders.insert(wall);
    }
}
