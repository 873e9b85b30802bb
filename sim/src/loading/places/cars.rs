//! Contradictions about bases that cannot turn in place: what such a robot cannot drive, and dimensions with which it could not be built.

use crate::{
    base::TurningCircle,
    loading::contradiction::Contradiction,
    scene::{BaseKind, FollowerName, Scene},
};

/// Dimensions of a car that do not fit together, and drives that a car cannot do.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let base = &scene.robot.base;
    if base.kind != BaseKind::Ackermann {
        if scene.robot.steering_encoder.is_some() {
            let expected = "the base steers nothing, expected `false`, or `robot.base.kind = \"ackermann\"`".to_owned();
            found.push(Contradiction { key: "robot.steering_encoder".to_owned(), expected });
        }
        return;
    }
    dimensions(scene, found);
    let mut refuse = |key: &str, expected: &str| {
        found.push(Contradiction { key: key.to_owned(), expected: expected.to_owned() });
    };
    if scene.has_errands() && scene.navigation().follower == FollowerName::TurnThenDrive {
        let expected = "a car cannot turn in place, expected \"pure_pursuit\", or `robot.base.kind = \"differential\"`";
        refuse("navigation.follower", expected);
    }
    if scene.start.anywhere {
        let expected = "true with a car, which cannot look around in place, expected false, or \
                        `robot.base.kind = \"differential\"`";
        refuse("start.anywhere", expected);
    }
    if let Some(circle) = base.drivetrain().turning_circle() {
        route(scene, circle, found);
    }
}

fn dimensions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let (base, car) = (&scene.robot.base, &scene.robot.base.ackermann);
    let front_m = car.front_track_m.unwrap_or(base.track_m);
    let wider_m = base.track_m.max(front_m);
    let circle_m = car.wheelbase_m / car.max_steering_deg.to_radians().tan();
    if circle_m <= 0.5 * wider_m {
        let expected = format!(
            "turns about a point {circle_m:.3} m from the middle of the rear axle, between the wheels, \
             expected a smaller angle, with which the point is more than {:.3} m away, half the track",
            0.5 * wider_m
        );
        found.push(Contradiction { key: "robot.base.ackermann.max_steering_deg".to_owned(), expected });
    }
    let reach_m = car.wheelbase_m.hypot(0.5 * front_m);
    if scene.robot.body_radius_m < reach_m {
        let expected = format!(
            "does not cover the front wheels, which touch the floor {reach_m:.3} m from the middle of the rear axle, \
             expected that or more"
        );
        found.push(Contradiction { key: "robot.body_radius_m".to_owned(), expected });
    }
}

fn route(scene: &Scene, circle: TurningCircle, found: &mut Vec<Contradiction>) {
    let Some(route) = &scene.route else { return };
    if let Some(refused) = circle.off_limits(scene.nominal_start(), route) {
        let key = format!("route.waypoint[{}].{}", refused.waypoint_idx, refused.key);
        found.push(Contradiction { key, expected: refused.expected });
    }
}
