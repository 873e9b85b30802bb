//! Tests against a camera that is projected with rotation matrices of `nalgebra`, written for these tests alone.

use std::collections::BTreeMap;

use interval::Interval;

use super::{
    trial::{True, around, boxed, depth, homogeneous, look, reading, walls},
    *,
};
use crate::{
    PoseBox,
    graph::{
        Domain, Relations, Variable,
        trial::{Draw, robot, rounds},
    },
    map::{Anchor, SpacePoint},
    method::Context,
};

#[test]
fn the_truth_satisfies_the_rows_of_image_points_at_the_corners_of_all_bounds() {
    let mut draw = Draw::new(20_261_126);
    let mut nearest: f64 = 0.0;
    for round in 0..rounds(20_000) {
        let truth = True::new(&mut draw, 1.0);
        let at = truth.at(&mut draw, 3.0, -2.0);
        let depth_m = depth(&mut draw, 0.4);
        let landmark = truth.seen_point(&mut draw, &at, depth_m);
        let (exact_px, _) = truth.project(&at, landmark);
        let at_px = truth.with_error(&mut draw, exact_px);
        // An anchor near a pose from which the landmark was seen before, or near the present one.
        let centre = truth.camera_at(&at).0;
        let reach = 0.3 * depth_m.min(10.0);
        let from_m = [0, 1, 2].map(|k| centre[k] + draw.between(-reach, reach));
        let from = [0, 1, 2].map(|k| landmark[k] - from_m[k]);
        let axis = (0..3).max_by(|&a, &b| from[a].abs().total_cmp(&from[b].abs())).unwrap();
        let anchor = Anchor { from_m, axis, is_positive: from[axis] > 0.0 };
        let true_point = homogeneous(&anchor, landmark);
        let size = draw.size(1e-6, 0.05);
        let value = true_point.map(|one| around(&mut draw, one, size));
        let optics = Arc::new(Optics::new(truth.camera, truth.body));
        let id = LandmarkId(9);
        let error_px = [truth.camera.error_px; 2];
        let points = Points {
            optics,
            seen: vec![Sight {
                landmark: id,
                point: SpacePoint { anchor, value },
                at_px,
                error_px,
                view: None,
                thing: None,
            }],
        };
        let mut values: BTreeMap<Variable, f64> =
            truth.constants.iter().map(|(&constant, &value)| (Variable::Constant(constant), value)).collect();
        let mut domain = Domain::default();
        for (variable, value) in points.quantities(4, &PoseBox::from([Interval::ZERO; 3])) {
            domain.put(variable, value);
        }
        for (k, truly) in true_point.into_iter().enumerate() {
            let half = draw.size(1e-6, if k == 2 { 0.1 } else { 0.3 });
            domain.put(Variable::Pose(4, k), around(&mut draw, at.pose[k], half));
            values.insert(Variable::Pose(4, k), at.pose[k]);
            values.insert(Variable::Point(id, k), truly);
        }
        (0..2).for_each(|k| {
            values.insert(Variable::BodyTilt(4, k), at.lean[k]);
        });
        for (variable, value) in domain.iter() {
            assert!(value.inflate(1e-12).contains(values[&variable]), "{variable:?}: {} {value}", values[&variable]);
        }
        let rows = points.rows(4, &domain);
        assert_eq!(rows.len(), 2);
        for row in rows {
            let value = row.value_at(|variable| values[&variable] - domain.reference(variable));
            assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {}", row.sides);
            nearest = nearest.max((value - row.sides.mid()).abs() / row.sides.radius());
        }
    }
    assert!(nearest > 0.98, "{nearest}");
}

#[test]
fn a_landmark_is_within_its_box_from_its_first_sighting_on() {
    let mut draw = Draw::new(20_261_127);
    let mut nearest: f64 = 0.0;
    for round in 0..rounds(20_000) {
        let truth = True::new(&mut draw, 1.0);
        let at = truth.at(&mut draw, 3.0, -2.0);
        let depth_m = depth(&mut draw, 0.4);
        let landmark = truth.seen_point(&mut draw, &at, depth_m);
        let (exact_px, _) = truth.project(&at, landmark);
        let at_px = truth.with_error(&mut draw, exact_px);
        let pose = PoseBox::from([0, 1, 2].map(|k| {
            let half = draw.size(1e-6, if k == 2 { 0.02 } else { 0.05 });
            around(&mut draw, at.pose[k], half)
        }));
        let point = Optics::new(truth.camera, truth.body).first_seen(&pose, at_px, [truth.camera.error_px; 2]).unwrap();
        let expected = homogeneous(&point.anchor, landmark);
        for (k, (value, truly)) in point.value.into_iter().zip(expected).enumerate() {
            assert!(value.inflate(1e-12).contains(truly), "round {round}, {k}: {truly} {value}");
            nearest = nearest.max((truly - value.mid()).abs() / value.radius());
        }
    }
    assert!(nearest > 0.9, "{nearest}");
}

#[test]
fn what_was_learnt_since_a_failed_assumption_is_taken_back() {
    let mut draw = Draw::new(20_261_129);
    let truth = True::new(&mut draw, 0.2);
    let landmarks = walls(&mut draw, 40);
    let robot = RobotModel { body: truth.body, ..robot() };
    let mut method = MappedLandmarks::new(truth.camera, &robot, &[], Learning::Teaches);
    let (mut at_five, mut at_five_s) = (Vec::new(), None);
    for step in 0..30 {
        let at = truth.turned(&mut draw, [0.1 * f64::from(step), 0.0], 0.3);
        // From the sixth second on the pose is told 3 m wrong.
        let wrong_m = if step > 5 { 3.0 } else { 0.0 };
        let known = boxed(&mut draw, [at.pose[0], at.pose[1] + wrong_m, at.pose[2]], [0.01, 0.01, 0.005]);
        let seen = look(&truth, &mut draw, &at, &landmarks);
        let known = PoseUnion::single(known);
        let constraint = method.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&known)).unwrap();
        method.learn(&constraint.shown.unwrap(), Some(&known));
        if step == 5 {
            at_five = method.atlas.points().collect::<Vec<_>>();
            at_five_s = method.knowledge();
        }
    }
    method.go_back(&at_five_s.unwrap());
    let left: Vec<_> = method.atlas.points().collect();
    assert_eq!(left, at_five);
    for (landmark, point) in left {
        let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
        assert!((0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k])), "{landmark:?} {point:?}");
    }
}
