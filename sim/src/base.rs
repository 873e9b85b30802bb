//! The base of a robot, a differential drive: what a seed draws of it, what the localizer is told of it, and its bounds. How it moves is
//! [`world`](crate::world)'s, how its wheels are read `devices::encoders`'.

use interval::Interval;
use localizer::{
    bounds::{self, Assumption},
    robot::WheelModel,
};

use crate::{
    devices::{ToldKey, relative},
    randomness::{draw_within, stream},
    scene::{Bounds, Robot},
};

/// The bounds beyond which the wear of its wheels may put it.
pub(crate) const CLIPPED: [Assumption; 2] = [bounds::WHEELS_RADIUS, bounds::WHEELS_TRACK];

/// True dimensions of the base, and its clock.
#[derive(Clone, Copy, Debug)]
pub struct DrawnBase {
    /// True rolling radius of the left and of the right wheel.
    pub wheel_radius_m: [f64; 2],
    /// True distance between the contact points.
    pub track_m: f64,
    /// By how much the stamps of wheels, gyroscope and flow sensor are late.
    pub clock_s: f64,
}

impl DrawnBase {
    /// Draws the base of a robot.
    pub(crate) fn draw(robot: &Robot, seed: u64) -> DrawnBase {
        let mut rng = stream(seed, "wheels");
        let mut around = |nominal: f64, share: f64| nominal * (1.0 + draw_within(share, robot.errors, &mut rng));
        let left_m = around(robot.wheel_radius_m, robot.wheel_radius_tolerance);
        let right_m = around(robot.wheel_radius_m, robot.wheel_radius_tolerance);
        let track_m = around(robot.track_m, robot.track_tolerance);
        DrawnBase {
            wheel_radius_m: [left_m * (1.0 - robot.wheel_wear[0]), right_m * (1.0 - robot.wheel_wear[1])],
            track_m,
            clock_s: draw_within(robot.delivery.stamp_tolerance_s, robot.errors, &mut stream(seed, "base.clock")),
        }
    }

    /// Its declared bounds: name, declared, and true value. Radii and track are drawn inside of them, but for wear.
    pub(crate) fn constants(&self, robot: &Robot) -> Vec<(Assumption, f64, f64)> {
        let off_m = self.wheel_radius_m.map(|radius_m| (radius_m - robot.wheel_radius_m).abs());
        let mut all = vec![
            (bounds::WHEELS_RADIUS, robot.wheel_radius_m * robot.wheel_radius_tolerance, off_m[0].max(off_m[1])),
            (bounds::WHEELS_TRACK, robot.track_m * robot.track_tolerance, (self.track_m - robot.track_m).abs()),
        ];
        // Without a tolerance there is one clock.
        if robot.delivery.stamp_tolerance_s > 0.0 {
            all.push((bounds::BASE_STAMP, robot.delivery.stamp_tolerance_s, self.clock_s.abs()));
        }
        all
    }

    /// Moves back to its bound what was drawn, or is worn, beyond the bound of this name.
    pub(crate) fn clip(&mut self, bound: &str, robot: &Robot) {
        let near = |value: f64, nominal: f64, share: f64| value.clamp(nominal * (1.0 - share), nominal * (1.0 + share));
        match bound {
            bounds::WHEELS_RADIUS => {
                self.wheel_radius_m =
                    self.wheel_radius_m.map(|m| near(m, robot.wheel_radius_m, robot.wheel_radius_tolerance));
            }
            bounds::WHEELS_TRACK => self.track_m = near(self.track_m, robot.track_m, robot.track_tolerance),
            _ => {}
        }
    }
}

/// The keys of the base that tell the localizer a bound.
pub(crate) fn told_keys(robot: &mut Robot) -> Vec<ToldKey<'_>> {
    vec![
        ToldKey::is_share_of(&[bounds::WHEELS_RADIUS], &mut robot.wheel_radius_tolerance, robot.wheel_radius_m),
        ToldKey::is_share_of(&[bounds::WHEELS_TRACK], &mut robot.track_tolerance, robot.track_m),
        ToldKey::is(&[bounds::BASE_STAMP], &mut robot.delivery.stamp_tolerance_s),
    ]
}

/// What the localizer is told of the wheels.
pub(crate) fn wheel_model(robot: &Robot, bounds: &Bounds) -> WheelModel {
    let radius_m: Interval = relative(robot.wheel_radius_m, robot.wheel_radius_tolerance);
    WheelModel {
        radius_m: [radius_m, radius_m],
        track_m: relative(robot.track_m, robot.track_tolerance),
        ticks_per_turn: f64::from(robot.encoders.ticks_per_turn),
        slip_ratio: bounds.slip_ratio,
        slip_floor_m: bounds.slip_floor_m,
        side_slip_ratio: bounds.side_slip_ratio,
        side_slip_floor_m: bounds.side_slip_floor_m,
        slip_window_s: bounds.slip_window_s,
    }
}
