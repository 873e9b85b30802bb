//! A wheel with spin and tyre, and with a motor if it is driven, simulated in substeps of a quarter of a millisecond.

use crate::scene::Stuck;

use super::tyre::{Contact, Patch, Tyre};

/// Number of substeps into which one step of the world is divided for a wheel. A wheel oscillates on its tyre at 36 Hz, and the control of its
/// motor is as stiff.
const SUBSTEPS: u32 = 4;

/// Inertia of a wheel with its geared rotor, as an equivalent mass at the wheel's rim, over the robot's mass; 0.0086 kg·m² for the P3-DX.
const INERTIA_SHARE: f64 = 0.1;

/// Inertia of a wheel without a motor, as an equivalent mass at the wheel's rim, over the robot's mass: a solid wheel of a twenty-fifth of the robot's
/// mass. A lighter one would oscillate on its tyre faster than the substeps resolve.
const FREE_INERTIA_SHARE: f64 = 0.02;

/// Bandwidth of the wheel's speed controller when the wheel drives half the robot's mass: so fast that its lag is unnoticeable at 10 ms, and so
/// slow that it does not ring with the tyre.
const SPEED_BANDWIDTH_PER_S: f64 = 60.0;

/// Ratio of proportional to integral gain of the wheel's speed controller: the time in which the controller makes up for a steady load.
const INTEGRAL_TIME_S: f64 = 0.1;

/// Greatest force of one motor at the wheel's rim, over the robot's weight. Both wheels together hold against any friction below 1.2, so that a
/// pushed robot slides instead of turning its motors.
const FORCE_LIMIT_OVER_WEIGHT: f64 = 0.5;

/// Time constant with which the set-point follows the command, so that commands 10 ms apart give a smooth acceleration.
const SETPOINT_LAG_S: f64 = 0.02;

/// A wheel, driven or rolling freely.
#[derive(Clone, Debug)]
pub(super) struct Wheel {
    /// True rolling radius of the wheel.
    pub(super) radius_m: f64,
    /// Spin angle of the wheel since the start, positive when rolling forward.
    pub(super) angle_rad: f64,
    /// Spin rate of the wheel.
    pub(super) spin_rad_per_s: f64,
    /// Contact patch of the wheel's tyre on the floor.
    pub(super) patch: Patch,
    inertia_kg_m2: f64,
    /// Motor of a driven wheel.
    motor: Option<Motor>,
}

/// Forces that a wheel exerts on the robot's body, averaged over a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Traction {
    /// Mean force of the floor at the contact patch: forward and left.
    pub(super) force_n: [f64; 2],
    /// Mean torque about the axle by which the wheel's own change of spin reacts on the body.
    pub(super) reaction_n_m: f64,
}

impl Wheel {
    /// A driven wheel at rest under a robot of the given mass.
    pub(super) fn new(radius_m: f64, robot_mass_kg: f64, gravity_m_per_s2: f64) -> Self {
        let inertia_kg_m2 = INERTIA_SHARE * robot_mass_kg * radius_m * radius_m;
        let driven_kg_m2 = inertia_kg_m2 + 0.5 * robot_mass_kg * radius_m * radius_m;
        let limit_n_m = FORCE_LIMIT_OVER_WEIGHT * robot_mass_kg * gravity_m_per_s2 * radius_m;
        Wheel {
            radius_m,
            angle_rad: 0.0,
            spin_rad_per_s: 0.0,
            patch: Patch::default(),
            inertia_kg_m2,
            motor: Some(Motor::new(SPEED_BANDWIDTH_PER_S * driven_kg_m2, limit_n_m)),
        }
    }

    /// A wheel without a motor at rest under a robot of the given mass.
    pub(super) fn free(radius_m: f64, robot_mass_kg: f64) -> Self {
        Wheel {
            radius_m,
            angle_rad: 0.0,
            spin_rad_per_s: 0.0,
            patch: Patch::default(),
            inertia_kg_m2: FREE_INERTIA_SHARE * robot_mass_kg * radius_m * radius_m,
            motor: None,
        }
    }

    /// Turns the wheel for one step of the world. `tyre` has the properties that the tyre has on the ground under it.
    pub(super) fn advance(
        &mut self,
        commanded_rad_per_s: f64,
        tyre: &Tyre,
        contact: &Contact,
        stuck: Option<Stuck>,
        step_s: f64,
    ) -> Traction {
        // A wheel that spins without hold on the floor bears no load on its tyre.
        let contact =
            &Contact { load_n: if stuck == Some(Stuck::Spinning) { 0.0 } else { contact.load_n }, ..*contact };
        let substep_s = step_s / f64::from(SUBSTEPS);
        let mut mean = Traction::default();
        for _ in 0..SUBSTEPS {
            let torque_n_m = match &mut self.motor {
                Some(motor) => motor.torque(commanded_rad_per_s, self.spin_rad_per_s, substep_s),
                None => 0.0,
            };
            let force_n = self.patch.force_n(tyre, contact);
            // Semi-implicit step: I·Ω̇ = T − R·F_x gives the new spin first, then the wheel's angle and the tyre's bristles are advanced with
            // that spin. Both must use the same rolling, or every acceleration would slip by half a substep's worth.
            let mut surplus_n_m = torque_n_m - self.radius_m * force_n[0];
            if stuck == Some(Stuck::Blocked) {
                // Whatever blocks the wheel takes up all torque that remains, and it takes up the wheel's momentum at once, so that the wheel
                // stops.
                surplus_n_m = -self.spin_rad_per_s * self.inertia_kg_m2 / substep_s;
            }
            self.spin_rad_per_s += surplus_n_m / self.inertia_kg_m2 * substep_s;
            self.angle_rad += self.spin_rad_per_s * substep_s;
            self.patch.advance(tyre, contact, self.radius_m * self.spin_rad_per_s, substep_s);
            mean.force_n[0] += force_n[0] / f64::from(SUBSTEPS);
            mean.force_n[1] += force_n[1] / f64::from(SUBSTEPS);
            mean.reaction_n_m -= surplus_n_m / f64::from(SUBSTEPS);
        }
        mean
    }
}

/// A wheel motor under proportional-integral speed control, limited in torque.
#[derive(Clone, Debug)]
struct Motor {
    gain_n_m_s: f64,
    limit_n_m: f64,
    setpoint_rad_per_s: f64,
    integral_n_m: f64,
}

impl Motor {
    fn new(gain_n_m_s: f64, limit_n_m: f64) -> Self {
        Motor { gain_n_m_s, limit_n_m, setpoint_rad_per_s: 0.0, integral_n_m: 0.0 }
    }

    fn torque(&mut self, commanded_rad_per_s: f64, spin_rad_per_s: f64, step_s: f64) -> f64 {
        self.setpoint_rad_per_s += (commanded_rad_per_s - self.setpoint_rad_per_s) * step_s / SETPOINT_LAG_S;
        let error_rad_per_s = self.setpoint_rad_per_s - spin_rad_per_s;
        let proportional_n_m = self.gain_n_m_s * error_rad_per_s;
        let wanted_n_m = proportional_n_m + self.integral_n_m;
        let torque_n_m = wanted_n_m.clamp(-self.limit_n_m, self.limit_n_m);
        // A saturated motor stops integrating. Otherwise a wheel held at a wall would race as soon as it is freed.
        if torque_n_m == wanted_n_m {
            self.integral_n_m += proportional_n_m * step_s / INTEGRAL_TIME_S;
        }
        torque_n_m
    }
}
