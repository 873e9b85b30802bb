//! The car: two driven rear wheels, which are those of the axle, and two front wheels that roll freely and are steered by Ackermann geometry.
//!
//! With wheelbase L and steering angle δ the centre of the turn is on the line through the rear wheels, L/tan δ to the left of their middle (Rajamani,
//! *Vehicle Dynamics and Control*, section 2.2). Without slip the turn rate at a speed v is therefore v·tan δ/L.

use crate::scene::{Ackermann, Base, Robot};

use super::{DrawnBase, DriveCommand, Drivetrain, Foot, FootKind, TurningCircle};

impl Drivetrain for Ackermann {
    fn feet(&self, robot: &Robot, drawn: &DrawnBase) -> Vec<Foot> {
        let wheel = |forward_m: f64, left_m: f64, axle_share: f64, kind: FootKind| Foot {
            place_m: [forward_m, left_m],
            weight_share: 0.5 * axle_share,
            relative_stiffness: 1.0,
            kind,
        };
        let (rear_m, front_m) = (0.5 * drawn.track_m, 0.5 * self.front_track_m.unwrap_or(robot.base.track_m));
        let rear = |left_m: f64| wheel(0.0, left_m, 1.0 - self.front_share, FootKind::Driven);
        let front = |left_m: f64| wheel(drawn.wheelbase_m, left_m, self.front_share, FootKind::Steered);
        vec![rear(rear_m), rear(-rear_m), front(front_m), front(-front_m)]
    }

    fn wheel_speeds_rad_per_s(&self, base: &Base, command: DriveCommand, steering_rad: f64) -> [f64; 2] {
        let turn_rad_per_s = command.speed_m_per_s * steering_rad.tan() / self.wheelbase_m;
        base.spins_rad_per_s(DriveCommand { turn_rad_per_s, ..command })
    }

    /// A commanded motion of speed v and turn rate ω asks for the steering angle atan(L·ω/v), at standstill for the greatest one to that side. A robot
    /// that is to stand still keeps its steering angle.
    fn steered_rad(&self, command: DriveCommand, steering_rad: f64, step_s: f64) -> f64 {
        let DriveCommand { speed_m_per_s, turn_rad_per_s } = command;
        if speed_m_per_s == 0.0 && turn_rad_per_s == 0.0 {
            return steering_rad;
        }
        let most_rad = self.max_steering_deg.to_radians();
        let across_m_per_s = self.wheelbase_m * turn_rad_per_s * speed_m_per_s.signum();
        let wanted_rad = across_m_per_s.atan2(speed_m_per_s.abs()).clamp(-most_rad, most_rad);
        let step_rad = self.steering_rate_deg_per_s.to_radians() * step_s;
        steering_rad + (wanted_rad - steering_rad).clamp(-step_rad, step_rad)
    }

    /// A front wheel rolls at right angles to the line from the centre of the turn, `(0, L/tan δ)`, to the wheel at `(L, y)`: by the angle whose
    /// tangent is `L/(L/tan δ − y)`. The steering linkage is made for the nominal wheelbase L, wherever the front axle truly is.
    fn rolling_rad(&self, [_, left_m]: [f64; 2], steering_rad: f64) -> f64 {
        let tan = steering_rad.tan();
        (self.wheelbase_m * tan).atan2(self.wheelbase_m - left_m * tan)
    }

    fn turning_circle(&self) -> Option<TurningCircle> {
        Some(TurningCircle {
            radius_m: self.wheelbase_m / self.max_steering_deg.to_radians().tan(),
            lock_to_lock_s: 2.0 * self.max_steering_deg / self.steering_rate_deg_per_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a wheelbase of 0.5 m and a steering angle of atan(0.5) the centre of the turn is 1 m to the left of the rear axle's middle. The left front
    /// wheel, 0.2 m to the left, turns about it in a triangle of 0.5 m by 0.8 m, the right one in one of 0.5 m by 1.2 m.
    #[test]
    fn all_wheels_roll_about_one_centre() {
        let car = Ackermann::default();
        let steering_rad = 0.5_f64.atan();
        let tangent = |place_m| car.rolling_rad(place_m, steering_rad).tan();
        assert!((tangent([0.5, 0.2]) - 0.5 / 0.8).abs() < 1e-12, "{}", tangent([0.5, 0.2]));
        assert!((tangent([0.5, -0.2]) - 0.5 / 1.2).abs() < 1e-12, "{}", tangent([0.5, -0.2]));
        assert_eq!(car.rolling_rad([0.5, 0.2], 0.0), 0.0);
        let spins = car.wheel_speeds_rad_per_s(
            &Base { wheel_radius_m: 0.1, track_m: 0.4, ..Base::default() },
            DriveCommand { speed_m_per_s: 0.5, turn_rad_per_s: 0.0 },
            steering_rad,
        );
        // At 0.5 m/s on a circle of 1 m the wheels are 0.8 m and 1.2 m from the centre.
        assert!((spins[0] - 4.0).abs() < 1e-12 && (spins[1] - 6.0).abs() < 1e-12, "{spins:?}");
    }

    #[test]
    fn the_steering_angle_follows_its_command_within_rate_and_limit() {
        let car = Ackermann { steering_rate_deg_per_s: 100.0, ..Ackermann::default() };
        let steer = |speed_m_per_s, turn_rad_per_s, from_deg: f64, step_s| {
            let command = DriveCommand { speed_m_per_s, turn_rad_per_s };
            car.steered_rad(command, from_deg.to_radians(), step_s).to_degrees()
        };
        assert!((steer(1.0, 1.0, 0.0, 0.1) - 10.0).abs() < 1e-9, "by 100°/s in 0.1 s");
        assert!((steer(1.0, 1.0, 0.0, 1.0) - 0.5_f64.atan().to_degrees()).abs() < 1e-9, "atan(0.5 m · 1/m)");
        assert!(
            (steer(-1.0, 1.0, 0.0, 1.0) + 0.5_f64.atan().to_degrees()).abs() < 1e-9,
            "to the other side in reverse"
        );
        assert!((steer(0.5, 9.0, 0.0, 1.0) - 30.0).abs() < 1e-9, "no farther than the limit");
        assert!((steer(0.0, -1.0, 0.0, 1.0) + 30.0).abs() < 1e-9, "at standstill the wheels steer");
        assert!((steer(0.0, 0.0, 12.0, 1.0) - 12.0).abs() < 1e-9, "a robot at rest keeps its angle");
    }
}
