//! The differential drive: two driven wheels side by side, and two casters before and behind them.

use crate::scene::{Base, Differential, Robot};

use super::{DrawnBase, DriveCommand, Drivetrain, Foot, FootKind};

/// Share of the weight on the two wheels; the casters bear the rest. A smaller share means less traction and more slip.
const WHEEL_SHARE: f64 = 0.85;

/// Distance of the casters from the axle over the body's radius. Closer ones let the body pitch more.
const CASTER_OVER_RADIUS: f64 = 0.8;

impl Drivetrain for Differential {
    fn feet(&self, robot: &Robot, drawn: &DrawnBase) -> Vec<Foot> {
        let half_track_m = 0.5 * drawn.track_m;
        let caster_m = CASTER_OVER_RADIUS * robot.body_radius_m;
        let wheel = |left_m: f64| Foot {
            place_m: [0.0, left_m],
            weight_share: 0.5 * WHEEL_SHARE,
            relative_stiffness: 1.0,
            kind: FootKind::Driven,
        };
        let caster = |forward_m: f64| Foot {
            place_m: [forward_m, 0.0],
            weight_share: 0.5 * (1.0 - WHEEL_SHARE),
            relative_stiffness: self.caster_stiffness,
            kind: FootKind::Caster,
        };
        vec![wheel(half_track_m), wheel(-half_track_m), caster(caster_m), caster(-caster_m)]
    }

    fn wheel_speeds_rad_per_s(&self, base: &Base, command: DriveCommand, _steering_rad: f64) -> [f64; 2] {
        base.spins_rad_per_s(command)
    }
}
