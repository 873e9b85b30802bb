//! The physical world: a robot on its wheels in a walled room, in time steps of 1 ms. Wheel slip emerges from the tyres.
//!
//! rapier moves the body. Wheels, tyres and springs are modelled here and act on the body as forces, because rapier's wheels on joints
//! creep and its rolling cylinders scrub. Each step computes what the floor is like under the robot, what the springs bear, what the tyres
//! grip and what a hand pushes; then the body moves.

use rapier3d_f64::prelude::Vector;

use crate::{
    base::{DriveCommand, FootKind, balance_m},
    place::{
        Bystander,
        floor::{Floor, Ground},
    },
    scene::{Base, Scene},
    truth::{STEP_S, Truth},
};

mod chassis;
mod drawn;
mod drive;
mod lift;
mod odometer;
mod people;
mod push;
mod support;
mod stuck;
pub mod tyre;

pub use drawn::Drawn;
pub(crate) use drawn::is_clipped;

use chassis::{BodyState, Chassis};
use drive::Wheel;
use lift::Lift;
use odometer::Odometer;
use people::Walker;
use push::{Push, Rolled};
use stuck::StuckWheels;
use support::Support;
use tyre::{Contact, Tyre};

/// Number of time steps in a second. Times are quotients of whole numbers and therefore never drift.
pub const STEPS_PER_S: f64 = 1000.0;

/// Standard gravity.
const GRAVITY_M_PER_S2: f64 = 9.806_65;

/// Speed over the ground from which the drag of a carpet's pile has its full value. Below it the drag is proportional to the speed, so that
/// a robot comes to rest.
const DRAG_WHOLE_M_PER_S: f64 = 0.01;

/// The simulated robot, floor and walls. A clone is a snapshot: the original and the clone continue alike, bit for bit.
#[derive(Clone)]
pub struct World {
    chassis: Chassis,
    /// Keys of the base, which decide what the wheels do for a commanded motion.
    base: Base,
    /// The left and the right wheel of the axle, then those that are steered; each is under the support of the same index.
    wheels: Vec<Wheel>,
    /// Steering angle of the base, positive to the left.
    steering_rad: f64,
    /// Tyre of all wheels on a hard floor.
    tyre: Tyre,
    /// Supports of the body: those of the wheels first, then those of everything else that the base stands on.
    supports: Vec<Support>,
    floor: Floor,
    pushes: Vec<Push>,
    lifts: Vec<Lift>,
    stuck: StuckWheels,
    walkers: Vec<Walker>,
    /// Distance and turn by which the wheels rolled in the present step; `traction` is the force that the floor exerted on the wheels.
    rolled: Rolled,
    traction: Vector,
    /// Total vertical force of the floor on the robot in the present step.
    borne_n: f64,
    track_m: f64,
    /// Point of the floor under the centre of mass when the body is level, robot frame.
    balance: Vector,
    n_steps: u64,
    odometer: Odometer,
}

impl World {
    /// The scene's world at time 0: the robot at its true start, at rest on its wheels.
    pub fn new(scene: &Scene, drawn: &Drawn) -> World {
        let chassis = Chassis::new(scene, drawn);
        let robot = &scene.robot;
        let feet = robot.base.drivetrain().feet(robot, &drawn.base);
        let driven = drawn.base.wheel_radius_m.map(|radius_m| Wheel::new(radius_m, robot.mass_kg, GRAVITY_M_PER_S2));
        let steered = feet.iter().filter(|foot| foot.kind == FootKind::Steered);
        let steered = steered.map(|_| Wheel::free(robot.base.wheel_radius_m, robot.mass_kg));
        let wheels = driven.into_iter().chain(steered).collect();
        let [forward_m, left_m] = balance_m(&feet);
        World {
            odometer: Odometer::new(drawn, &chassis.state()),
            chassis,
            base: scene.robot.base.clone(),
            wheels,
            steering_rad: 0.0,
            tyre: Tyre::default(),
            supports: Support::all(scene, drawn),
            floor: Floor::new(scene),
            pushes: Push::all(scene),
            lifts: Lift::all(scene),
            stuck: StuckWheels::new(scene),
            walkers: Walker::all(scene),
            rolled: Rolled { forward_m: 0.0, turn_rad: 0.0 },
            traction: Vector::ZERO,
            borne_n: 0.0,
            track_m: drawn.base.track_m,
            balance: Vector::new(forward_m, left_m, 0.0),
            n_steps: 0,
        }
    }

    /// Advances the world by [`STEP_S`] under a commanded motion and returns the true state of the robot afterwards.
    pub fn step(&mut self, command: DriveCommand) -> Truth {
        let drivetrain = self.base.drivetrain();
        self.steering_rad = drivetrain.steered_rad(command, self.steering_rad, STEP_S);
        self.step_wheels(drivetrain.wheel_speeds_rad_per_s(&self.base, command, self.steering_rad))
    }

    /// Advances the world by [`STEP_S`] while the motors of the left and of the right wheel are commanded to reach these spin rates, positive when
    /// rolling forward; a base that steers keeps its steering angle. Returns the true state of the robot afterwards.
    pub fn step_wheels(&mut self, spins_rad_per_s: [f64; 2]) -> Truth {
        let time_s = self.n_steps as f64 / STEPS_PER_S;
        self.floor.advance_to(time_s);
        let body = self.chassis.state();
        self.chassis.release();
        self.bear(&body, spins_rad_per_s, time_s);
        self.shove(&body, time_s);
        self.lift(&body, time_s);
        self.walk(&body);
        self.chassis.advance(&body);
        self.n_steps += 1;
        let time_s = self.n_steps as f64 / STEPS_PER_S;
        self.odometer.advance(time_s, &self.chassis.state(), &self.wheels, self.steering_rad)
    }

    /// The true state of the robot at the present time.
    pub fn truth(&self) -> Truth {
        self.odometer.truth()
    }

    /// People as they stand at the present time.
    pub fn people(&self) -> Vec<Bystander> {
        self.walkers.iter().map(Walker::body).collect()
    }

    fn walk(&mut self, body: &BodyState) {
        let robot = body.world_from_robot.translation;
        for (index, walker) in self.walkers.iter_mut().enumerate() {
            walker.advance([robot.x, robot.y], STEP_S);
            self.chassis.place_person(index, walker.body().place_m);
        }
    }

    /// Applies the forces of the floor: supports bear the body, driven wheels pull it, and the pile of a carpet drags at wheels and
    /// casters.
    fn bear(&mut self, body: &BodyState, spins_rad_per_s: [f64; 2], time_s: f64) {
        let mut rolled_m = [0.0; 2];
        (self.traction, self.borne_n) = (Vector::ZERO, 0.0);
        for (support_idx, support) in self.supports.iter().enumerate() {
            let foot = support.foot(body);
            let ground = self.floor.at(foot.x, foot.y);
            let load_n = support.load_n(body, foot, &ground);
            self.borne_n += load_n;
            let mut force = Vector::new(0.0, 0.0, load_n);
            if ground.slope != [0.0; 2] {
                // On a slope the force of the ground is at right angles to the surface.
                force -= Vector::new(ground.slope[0], ground.slope[1], 0.0) * load_n;
            }
            if ground.drag > 0.0 {
                let [forward_m_per_s, left_m_per_s] = body.coming.over_floor(body, foot);
                let velocity = body.forward * forward_m_per_s + body.left * left_m_per_s;
                force -= velocity * (ground.drag * load_n / velocity.length().max(DRAG_WHOLE_M_PER_S));
            }
            // The first supports are the wheels; the others are casters, which roll without friction.
            if let Some(wheel) = self.wheels.get_mut(support_idx) {
                // Only steered wheels, which come after the two of the axle, roll in another direction than forward.
                let rolling_rad = match support_idx {
                    0 | 1 => 0.0,
                    _ => {
                        let place = support.foot_in_robot;
                        self.base.drivetrain().rolling_rad([place.x, place.y], self.steering_rad)
                    }
                };
                let (contact, axes) = contact(body, foot, rolling_rad, load_n, &ground);
                let tyre = ground.pile_stiffness.map_or(self.tyre, |pile| self.tyre.on_pile(pile));
                let before_rad = wheel.angle_rad;
                let stuck = if support_idx < 2 { self.stuck.at(support_idx, time_s) } else { None };
                let command_rad_per_s = spins_rad_per_s.get(support_idx).copied().unwrap_or(0.0);
                let traction = wheel.advance(command_rad_per_s, &tyre, &contact, stuck, STEP_S);
                if let Some(rolled_m) = rolled_m.get_mut(support_idx) {
                    *rolled_m = (wheel.angle_rad - before_rad) * wheel.radius_m;
                }
                let grip = axes[0] * traction.force_n[0] + axes[1] * traction.force_n[1];
                force += grip;
                self.traction += grip;
                let (sin, cos) = rolling_rad.sin_cos();
                let axle = body.world_from_robot.rotation * Vector::new(-sin, cos, 0.0);
                self.chassis.twist(axle * traction.reaction_n_m);
            }
            self.chassis.push(force, foot);
        }
        self.rolled = Rolled {
            forward_m: 0.5 * (rolled_m[0] + rolled_m[1]),
            turn_rad: (rolled_m[1] - rolled_m[0]) / self.track_m,
        };
    }

    /// Applies the pushes of hands. The part of a push that works against the tyres' grip acts at the height of the floor, the rest at the centre
    /// of mass, so that the body does not tilt.
    fn shove(&mut self, body: &BodyState, time_s: f64) {
        let [left_m, right_m] = [0, 1].map(|wheel_idx: usize| self.wheels[wheel_idx].patch.deflection_m());
        let deflection = (body.forward * (left_m[0] + right_m[0]) + body.left * (left_m[1] + right_m[1])) * 0.5;
        let heading_rad = self.odometer.truth().pose.heading_rad;
        for push in &mut self.pushes {
            let act = push.act(time_s, body, heading_rad, deflection, self.rolled, STEP_S);
            if let Some((force_n, torque_n_m)) = act {
                self.chassis.push(-self.traction, body.world_point(self.balance));
                self.chassis.push(force_n + self.traction, self.chassis.centre_of_mass());
                self.chassis.twist(Vector::new(0.0, 0.0, torque_n_m));
            }
        }
    }

    /// Applies the forces of hands that have lifted the robot and hold it on their path.
    fn lift(&mut self, body: &BodyState, time_s: f64) {
        let heading_rad = self.odometer.truth().pose.heading_rad;
        for lift in &mut self.lifts {
            if let Some((force_n, torque_n_m)) = lift.act(time_s, body, heading_rad, self.borne_n) {
                self.chassis.push(force_n, self.chassis.centre_of_mass());
                self.chassis.twist(torque_n_m);
            }
        }
    }
}

/// Contact of a wheel with the floor at its lowest point `foot`, and the axes of the contact patch in the world: forward and left of a wheel that
/// rolls in a direction counter-clockwise from the robot's forward, along the ground.
fn contact(body: &BodyState, foot: Vector, rolling_rad: f64, load_n: f64, ground: &Ground) -> (Contact, [Vector; 2]) {
    let (mut axes, mut velocity_m_per_s) = ([body.forward, body.left], body.coming.over_floor(body, foot));
    if rolling_rad != 0.0 {
        let (sin, cos) = rolling_rad.sin_cos();
        axes = [body.forward * cos + body.left * sin, body.left * cos - body.forward * sin];
        let [forward, left] = velocity_m_per_s;
        velocity_m_per_s = [forward * cos + left * sin, left * cos - forward * sin];
    }
    let along = |world: [f64; 2], axis: Vector| world[0] * axis.x + world[1] * axis.y;
    let nap = axes.map(|axis| along(ground.nap, axis));
    if ground.slope != [0.0; 2] {
        for axis in 0..2 {
            let rise = along(ground.slope, axes[axis]);
            let longer = (1.0 + rise * rise).sqrt();
            // A wheel that stays on a ramp rolls along the slope, which is longer than its horizontal projection.
            velocity_m_per_s[axis] *= longer;
            axes[axis] = (axes[axis] + Vector::Z * rise) / longer;
        }
    }
    (Contact { velocity_m_per_s, load_n, friction: ground.friction, nap }, axes)
}
