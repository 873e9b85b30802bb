//! What the rows of a point that a camera sees lose because they are linear: each part alone, for a point that is made for it.

use super::*;

/// A point at a place in the robot frame that is exactly known.
fn seen(middle_m: [f64; 2]) -> SeenPlace {
    SeenPlace {
        device: "floor_camera",
        yaw: Some((Constant::FloorYaw, 0.0)),
        middle_m: middle_m.map(Interval::point),
        terms: Vec::new(),
        noise_m: Vec::new(),
        turn_rad: 0.0,
    }
}

/// Checks the rows of a point along world x and y, and its coordinates, for a robot at the origin whose heading is known to 0 ± `off_rad` and truly
/// `off_rad`. The point truly lies at `place_m` in the robot frame, and beside that turned by `beside_rad`.
fn assert_holds(seen: &SeenPlace, place_m: [f64; 2], off_rad: f64, beside_rad: f64) {
    let mut domain = Domain::default();
    (0..2).for_each(|axis| domain.put(Variable::Pose(0, axis), Interval::ZERO));
    domain.put(Variable::Pose(0, 2), Interval::centred(0.0, off_rad));
    domain.put(Variable::Constant(Constant::FloorYaw), Interval::ZERO);
    let (sin, cos) = (off_rad + beside_rad).sin_cos();
    let world_m = [cos * place_m[0] - sin * place_m[1], sin * place_m[0] + cos * place_m[1]];
    let at = seen.at(0, &domain);
    for (axis, direction) in [[Interval::ONE, Interval::ZERO], [Interval::ZERO, Interval::ONE]].into_iter().enumerate()
    {
        let along_m = at.along(direction);
        assert!(along_m.inflate(1e-12).contains(world_m[axis]), "axis {axis}: {} not in {along_m}", world_m[axis]);
        let row = at.row(direction, Interval::point(world_m[axis]), &[]);
        let value = row.value_at(|variable| if variable == Variable::Pose(0, 2) { off_rad } else { 0.0 });
        assert!(row.sides.inflate(1e-12).contains(value), "axis {axis}: {value} {}", row.sides);
    }
}

#[test]
fn what_a_turn_is_not_linear_is_in_the_sides() {
    // 1 m ahead, turned by 0.3 rad: the point moves back by 1 − cos 0.3 = 44.7 mm, of at most 0.3²/2 = 45 mm, and to the left by sin 0.3, which is
    // 4.48 mm less than 0.3, of at most 0.3³/6 = 4.5 mm. A point to the left moves likewise.
    assert_holds(&seen([1.0, 0.0]), [1.0, 0.0], 0.3, 0.0);
    assert_holds(&seen([0.0, 1.0]), [0.0, 1.0], 0.3, 0.0);
}

#[test]
fn what_a_turn_moves_of_a_place_that_is_not_known_is_in_the_sides() {
    // 0 ± 0.1 m ahead or to the left, truly 0.1 m: turned by 0.1 rad, the point moves across by 0.1 m · sin 0.1, while the row takes that of the
    // middle, which is nothing.
    for direction in [[Interval::ONE, Interval::ZERO], [Interval::ZERO, Interval::ONE]] {
        let noise_m = vec![(direction, Interval::centred(0.0, 0.1), None)];
        let place_m = direction.map(|side| 0.1 * side.mid());
        assert_holds(&SeenPlace { noise_m, ..seen([0.0; 2]) }, place_m, 0.1, 0.0);
    }
}

#[test]
fn what_a_turn_beside_the_heading_moves_is_in_the_sides() {
    // The picture is turned by 10 mrad more than heading and yaw tell: 1 m ahead, the point is 10 mm farther to the left.
    assert_holds(&SeenPlace { turn_rad: 0.01, ..seen([1.0, 0.0]) }, [1.0, 0.0], 0.0, 0.01);
}
