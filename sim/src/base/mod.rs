//! The robot's base. What every base has is here: an axle with two wheels, its true dimensions as a seed draws them, what the localizer is given of
//! them, and their declared bounds. What a kind of base has of its own is in one file for each kind: what the robot stands on, and what its wheels do
//! when the driver commands a motion.
//!
//! A new kind needs such a file, its keys in [`scene::base`](crate::scene::Base), and one line of `scene::with_every_base`. The base's motion is in
//! [`world`](crate::world), the reading of its wheels in `devices::encoders`.

mod ackermann;
mod differential;
mod turning_circle;

use interval::Interval;
use localizer::{
    bounds::{self, Assumption},
    robot::WheelModel,
};

use crate::{
    devices::{ToldKey, relative},
    scene::{Base, BaseKind, Bounds, Robot, with_every_base},
    truth::randomness::{draw_within, stream},
};

pub(crate) use turning_circle::TurningCircle;

/// Declared bounds on the base that the true values can exceed, because wheels may be worn beyond what is declared.
pub(crate) const CLIPPED: [Assumption; 2] = [bounds::WHEELS_RADIUS, bounds::WHEELS_TRACK];

/// A motion that the driver commands of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveCommand {
    /// Speed of the middle of the axle, positive forward.
    pub speed_m_per_s: f64,
    /// Turn rate of the robot, counter-clockwise.
    pub turn_rad_per_s: f64,
}

/// A kind of base, implemented for the keys that only this kind has.
pub(crate) trait Drivetrain {
    /// What the robot stands on: the left wheel of the axle, its right wheel, then wheels that are steered, and then everything else.
    fn feet(&self, robot: &Robot, drawn: &DrawnBase) -> Vec<Foot>;

    /// Spin rates that the motors of the left and of the right wheel are to reach for a commanded motion, positive when rolling forward, while the
    /// base is steered by an angle. They are computed from nominal dimensions, as a robot does not know its true ones.
    fn wheel_speeds_rad_per_s(&self, base: &Base, command: DriveCommand, steering_rad: f64) -> [f64; 2];

    /// Steering angle of the base, positive to the left, when a time step under a commanded motion has passed since the angle was `_steering_rad`. It
    /// stays 0 where nothing is steered.
    fn steered_rad(&self, _command: DriveCommand, _steering_rad: f64, _step_s: f64) -> f64 {
        0.0
    }

    /// Direction in which a steered wheel rolls, counter-clockwise from forward, at a place forward and left in the robot frame.
    fn rolling_rad(&self, _place_m: [f64; 2], _steering_rad: f64) -> f64 {
        0.0
    }

    /// Circle that bounds how sharply the base turns; `None` if it can turn in place.
    fn turning_circle(&self) -> Option<TurningCircle> {
        None
    }
}

/// A point at which the robot stands on the floor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// Position of the point in the robot frame: forward and left.
    pub(crate) place_m: [f64; 2],
    /// Share of the robot's weight that the point bears when the robot is at rest on level floor. The shares of all feet add up to 1, and the robot's
    /// centre of mass is above the point at which they balance.
    pub(crate) weight_share: f64,
    /// Stiffness and damping of the spring above the point, over those of a usual wheel's spring.
    pub(crate) relative_stiffness: f64,
    /// What touches the floor there.
    pub(crate) kind: FootKind,
}

/// What touches the floor under a foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FootKind {
    /// A wheel of the axle, driven by a motor.
    Driven,
    /// A wheel that rolls freely in the direction in which it is steered, and grips sideways.
    Steered,
    /// A caster, which rolls in any direction without friction.
    Caster,
}

/// The point, forward and left in the robot frame, above which the robot's weight must be for each of its feet to bear its share of it.
pub(crate) fn balance_m(feet: &[Foot]) -> [f64; 2] {
    [0, 1].map(|axis| feet.iter().map(|foot| foot.weight_share * foot.place_m[axis]).sum())
}

macro_rules! define {
    ($($(#[$doc:meta])+ $kind:ident: $table:ident $(unless $omitted:literal)?,)+) => {
        impl Base {
            /// The drivetrain of this base's kind.
            pub(crate) fn drivetrain(&self) -> &dyn Drivetrain {
                match self.kind {
                    $(BaseKind::$kind => &self.$table,)+
                }
            }
        }
    };
}

with_every_base!(define);

impl Base {
    /// Spin rates at which the left and the right wheel of the axle roll without slip in a motion, by nominal dimensions.
    fn spins_rad_per_s(&self, motion: DriveCommand) -> [f64; 2] {
        let half_turn_m_per_s = 0.5 * self.track_m * motion.turn_rad_per_s;
        [motion.speed_m_per_s - half_turn_m_per_s, motion.speed_m_per_s + half_turn_m_per_s]
            .map(|wheel_m_per_s| wheel_m_per_s / self.wheel_radius_m)
    }
}

/// True dimensions of the robot's base, and the error of its clock.
#[derive(Clone, Copy, Debug)]
pub struct DrawnBase {
    /// True rolling radius of the left and of the right wheel.
    pub wheel_radius_m: [f64; 2],
    /// True distance between the contact points of the two wheels.
    pub track_m: f64,
    /// True distance from a car's rear axle to its front axle.
    pub wheelbase_m: f64,
    /// Delay, drawn at random, by which the stamps of wheels, gyroscope, flow sensor and steering encoder are late; negative if they are early.
    pub clock_s: f64,
}

impl DrawnBase {
    /// Draws the true dimensions and the clock error of a robot's base for a seed.
    pub(crate) fn draw(robot: &Robot, seed: u64) -> DrawnBase {
        let mut rng = stream(seed, "wheels");
        let mut around = |nominal: f64, share: f64| nominal * (1.0 + draw_within(share, robot.errors, &mut rng));
        let base = &robot.base;
        let wheelbase_share =
            draw_within(base.ackermann.wheelbase_tolerance, robot.errors, &mut stream(seed, "wheels.wheelbase"));
        let left_m = around(base.wheel_radius_m, base.wheel_radius_tolerance);
        let right_m = around(base.wheel_radius_m, base.wheel_radius_tolerance);
        let track_m = around(base.track_m, base.track_tolerance);
        DrawnBase {
            wheel_radius_m: [left_m * (1.0 - base.wheel_wear[0]), right_m * (1.0 - base.wheel_wear[1])],
            track_m,
            wheelbase_m: base.ackermann.wheelbase_m * (1.0 + wheelbase_share),
            clock_s: draw_within(robot.delivery.stamp_tolerance_s, robot.errors, &mut stream(seed, "base.clock")),
        }
    }

    /// Declared bounds of the base, each as name, declared value, and true value. Wheel radii and track are drawn within their bounds; only
    /// wear can put a radius outside.
    pub(crate) fn constants(&self, robot: &Robot) -> Vec<(Assumption, f64, f64)> {
        let off_m = self.wheel_radius_m.map(|radius_m| (radius_m - robot.base.wheel_radius_m).abs());
        let mut all = vec![
            (
                bounds::WHEELS_RADIUS,
                robot.base.wheel_radius_m * robot.base.wheel_radius_tolerance,
                off_m[0].max(off_m[1]),
            ),
            (
                bounds::WHEELS_TRACK,
                robot.base.track_m * robot.base.track_tolerance,
                (self.track_m - robot.base.track_m).abs(),
            ),
        ];
        if robot.steering_encoder.is_some() {
            let car = &robot.base.ackermann;
            let off_m = (self.wheelbase_m - car.wheelbase_m).abs();
            all.push((bounds::WHEELS_WHEELBASE, car.wheelbase_m * car.wheelbase_tolerance, off_m));
        }
        // With a stamp tolerance of zero the base and the localizer share one clock, so that there is no bound to check.
        if robot.delivery.stamp_tolerance_s > 0.0 {
            all.push((bounds::BASE_STAMP, robot.delivery.stamp_tolerance_s, self.clock_s.abs()));
        }
        all
    }

    /// Moves the true value that the bound named `bound` limits back to the bound, if the draw or the wear put it beyond.
    pub(crate) fn clip(&mut self, bound: &str, robot: &Robot) {
        let near = |value: f64, nominal: f64, share: f64| value.clamp(nominal * (1.0 - share), nominal * (1.0 + share));
        match bound {
            bounds::WHEELS_RADIUS => {
                self.wheel_radius_m =
                    self.wheel_radius_m.map(|m| near(m, robot.base.wheel_radius_m, robot.base.wheel_radius_tolerance));
            }
            bounds::WHEELS_TRACK => self.track_m = near(self.track_m, robot.base.track_m, robot.base.track_tolerance),
            _ => {}
        }
    }
}

/// Scene keys of the robot's base from which bounds of the localizer are taken.
pub(crate) fn told_keys(robot: &mut Robot) -> Vec<ToldKey<'_>> {
    let car = &mut robot.base.ackermann;
    vec![
        ToldKey::is_share_of(
            &[bounds::WHEELS_RADIUS],
            &mut robot.base.wheel_radius_tolerance,
            robot.base.wheel_radius_m,
        ),
        ToldKey::is_share_of(&[bounds::WHEELS_TRACK], &mut robot.base.track_tolerance, robot.base.track_m),
        ToldKey::is_share_of(&[bounds::WHEELS_WHEELBASE], &mut car.wheelbase_tolerance, car.wheelbase_m),
        ToldKey::is(&[bounds::BASE_STAMP], &mut robot.delivery.stamp_tolerance_s),
    ]
}

/// The model of the wheels that the localizer is given: nominal dimensions with their declared tolerances.
pub(crate) fn wheel_model(robot: &Robot, bounds: &Bounds) -> WheelModel {
    let radius_m: Interval = relative(robot.base.wheel_radius_m, robot.base.wheel_radius_tolerance);
    WheelModel {
        radius_m: [radius_m, radius_m],
        track_m: relative(robot.base.track_m, robot.base.track_tolerance),
        ticks_per_turn: f64::from(robot.encoders.ticks_per_turn),
        slip_ratio: bounds.slip_ratio,
        slip_floor_m: bounds.slip_floor_m,
        side_slip_ratio: bounds.side_slip_ratio,
        side_slip_floor_m: bounds.side_slip_floor_m,
        slip_window_s: bounds.slip_window_s,
    }
}

#[cfg(test)]
mod tests {
    use super::{Foot, FootKind, balance_m};

    /// Two feet 0.2 m apart bear three quarters of the weight, and one 0.4 m behind them bears a quarter: the weight is 0.1 m behind the two.
    #[test]
    fn weight_that_a_rear_foot_bears_is_behind_the_axle() {
        let kind = FootKind::Caster;
        let foot = |place_m: [f64; 2], weight_share: f64| Foot { place_m, weight_share, relative_stiffness: 1.0, kind };
        let feet = [foot([0.0, 0.1], 0.375), foot([0.0, -0.1], 0.375), foot([-0.4, 0.0], 0.25)];
        let [forward_m, left_m] = balance_m(&feet);
        assert!((forward_m + 0.1).abs() < 1e-15 && left_m.abs() < 1e-15, "{forward_m} {left_m}");
    }
}
