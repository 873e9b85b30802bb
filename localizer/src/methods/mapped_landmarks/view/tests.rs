use std::sync::Arc;

use interval::{Interval, contractor::Contractor};
use nalgebra::Vector3;

use super::*;
use crate::{
    graph::{
        Constant, Domain, Relations, Stray, Variable,
        trial::{Draw, rounds},
    },
    map::{Anchor, SpacePoint, ViewPicture},
    methods::mapped_landmarks::{
        few_wrong::FewWrong,
        pose_rows::{NearView, PoseRows},
        relate::Points,
        trial::{At, True, around, boxed, homogeneous, is_within, look, walls},
    },
};

/// A robot that sees landmarks which a teacher with a camera of its own has seen from nearby.
struct Trial {
    optics: Arc<Optics>,
    sights: Vec<Sight>,
    truth: True,
    at: At,
    teacher: True,
    taught: At,
    landmarks: Vec<Vector3<f64>>,
    pose: PoseBox,
}

impl Trial {
    /// Boxes of landmarks hold them, with slopes and inverse depths known to `half`.
    fn new(draw: &mut Draw, half: f64) -> Trial {
        let [truth, teacher] = [0, 1].map(|_| True::new(draw, 0.2));
        let landmarks = walls(draw, 150);
        let turn_rad = draw.between(-3.0, 3.0);
        let at = truth.turned(draw, [0.5, -0.3], turn_rad);
        let near = [0.5 + draw.between(-0.2, 0.2), -0.3 + draw.between(-0.2, 0.2)];
        let taught = teacher.turned(draw, near, turn_rad);
        let shown = look(&teacher, draw, &taught, &landmarks);
        let taught_box = boxed(draw, taught.pose, [0.01, 0.01, 0.004]);
        let mut sights = Vec::new();
        for seen in look(&truth, draw, &at, &landmarks) {
            let Some(view) = shown.iter().find(|one| one.landmark == seen.landmark) else { continue };
            let landmark = landmarks[seen.landmark.0 as usize];
            let axis = if landmark.x.abs() > landmark.y.abs() { 0 } else { 1 };
            let anchor = Anchor { from_m: [0.1, 0.2, 0.4], axis, is_positive: landmark[axis] > 0.0 };
            let value = homogeneous(&anchor, landmark).map(|one| around(draw, one, half));
            let sight = ViewSight { picture: 5, at_px: view.at_px, error_px: [teacher.camera.error_px; 2] };
            sights.push(Sight {
                landmark: seen.landmark,
                point: SpacePoint { anchor, value },
                at_px: seen.at_px,
                error_px: [truth.camera.error_px; 2],
                view: Some(View { sight, camera: 0, pose: taught_box }),
                thing: None,
            });
        }
        sights.truncate(24);
        let mut optics = Optics::new(truth.camera, truth.body);
        optics.taught = vec![super::optics(&kept(&Optics::new(teacher.camera, teacher.body)))];
        let pose = boxed(draw, at.pose, [0.1, 0.1, 0.05]);
        Trial { optics: Arc::new(optics), sights, truth, at, teacher, taught, landmarks, pose }
    }

    /// The true value of a quantity.
    fn value(&self, variable: Variable, sight: &Sight) -> f64 {
        match variable {
            Variable::Pose(_, axis) => self.at.pose[axis],
            Variable::ViewPose(_, axis) => self.taught.pose[axis],
            Variable::BodyTilt(_, axis) => self.at.lean[axis],
            Variable::Constant(one) => self.truth.constants[&one],
            Variable::ViewConstant(_, one) => self.teacher.constants[&one],
            Variable::Point(landmark, k) => homogeneous(&sight.point.anchor, self.landmarks[landmark.0 as usize])[k],
            other => panic!("{other:?}"),
        }
    }

    fn without_views(&self) -> Vec<Sight> {
        self.sights.iter().map(|sight| Sight { view: None, ..*sight }).collect()
    }
}

#[test]
fn the_truth_satisfies_the_rows_of_a_view_with_a_camera_of_its_own() {
    let mut draw = Draw::new(20_261_128);
    for round in 0..rounds(200) {
        let trial = Trial::new(&mut draw, 0.01);
        for sight in trial.sights.iter().take(4) {
            let points = Points { optics: Arc::clone(&trial.optics), seen: vec![*sight] };
            let mut domain = Domain::default();
            domain.put_pose(0, &trial.pose);
            points.quantities(0, &trial.pose).into_iter().for_each(|(variable, value)| domain.put(variable, value));
            let rows = points.rows(0, &domain);
            assert_eq!(rows.len(), 4);
            for row in &rows {
                let value = row.value_at(|variable| trial.value(variable, sight) - domain.reference(variable));
                assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {}", row.sides);
            }
            // The view's rows name the pose of the view and the other camera's constants, and neither the robot's pose nor its camera.
            let named = |row: &crate::graph::Row| row.terms.iter().map(|(variable, _)| *variable).collect::<Vec<_>>();
            for row in &rows[2..] {
                assert!(named(row).contains(&Variable::ViewPose(5, 2)) || row.terms.is_empty());
                let is_own = |one: &Variable| matches!(one, Variable::Pose(..) | Variable::Constant(_));
                assert!(!named(row).iter().any(is_own), "{:?}", named(row));
            }
        }
    }
}

#[test]
fn the_true_pose_stays_with_wrong_views_among_the_sightings() {
    let mut draw = Draw::new(20_261_129);
    let mut n_contracted = 0;
    let n_rounds = rounds(30);
    for round in 0..n_rounds {
        let mut trial = Trial::new(&mut draw, 0.03);
        assert!(trial.sights.len() > 12, "{}", trial.sights.len());
        let n_wrong = round % 3;
        for sight in trial.sights.iter_mut().take(n_wrong) {
            let view = sight.view.as_mut().unwrap();
            view.sight.at_px = view.sight.at_px.map(|px| px + draw.between(-9.0, 9.0));
        }
        let mut left = trial.pose;
        FewWrong::new(&trial.optics, Stray::default(), &trial.sights, n_wrong).contract(&mut left);
        assert!(is_within(trial.at.pose, &left), "round {round}: {:?} {left:?}", trial.at.pose);
        n_contracted += usize::from(left != trial.pose);
    }
    assert!(2 * n_contracted > n_rounds, "{n_contracted}");
}

#[test]
fn rows_of_the_pose_relative_to_a_view_hold_and_are_narrow_whatever_the_heading_of_the_view() {
    let mut draw = Draw::new(20_261_130);
    let n_rounds = rounds(15);
    let mut n_narrow = 0;
    for round in 0..n_rounds {
        let trial = Trial::new(&mut draw, 0.03);
        let view = trial.sights[0].view.unwrap();
        // The heading of another view is 0.1 rad less, and the turn since is known to a milliradian.
        let turned_since = vec![(3, around(&mut draw, 0.1, 1e-3)), (4, Interval::ZERO)];
        let near = NearView { picture: 5, pose: view.pose, turned_since };
        let sightings = FewWrong::new(&trial.optics, Stray::default(), &trial.sights, 1);
        let rows = PoseRows::new(sightings, 0.0, true, Some(near));
        let mut domain = Domain::default();
        domain.put_pose(7, &trial.pose);
        rows.quantities(7, &trial.pose).into_iter().for_each(|(variable, value)| domain.put(variable, value));
        domain.put(Variable::ViewPose(3, 2), view.pose[2].inflate(0.2));
        let value = |variable: Variable| match variable {
            Variable::Pose(7, axis) => trial.at.pose[axis],
            Variable::ViewPose(5, axis) => trial.taught.pose[axis],
            Variable::ViewPose(3, 2) => trial.taught.pose[2] - 0.1,
            other => panic!("{other:?}"),
        };
        let made = rows.rows(7, &domain);
        // Three functions of the pose, and the turn since the one earlier view that the domain has.
        assert_eq!(made.len(), 4);
        for row in &made {
            let found = row.value_at(|variable| value(variable) - domain.reference(variable));
            assert!(row.sides.inflate(1e-9).contains(found), "round {round}: {found} {}", row.sides);
        }
        assert!(made[3].sides.width() < 2.1e-3);
        let range = |row: &crate::graph::Row| {
            row.terms.iter().map(|&(variable, a)| a.abs() * domain.value(variable).width()).sum::<f64>()
        };
        n_narrow += usize::from(made[..3].iter().any(|row| row.sides.width() < 0.25 * range(row)));
    }
    assert!(3 * n_narrow >= 2 * n_rounds, "{n_narrow} of {n_rounds}");
}

#[test]
fn of_the_pictures_that_show_enough_of_the_landmarks_the_nearest_one_is_chosen() {
    let mut draw = Draw::new(20_261_131);
    let trial = Trial::new(&mut draw, 0.01);
    let mut sights: Vec<Sight> = trial.without_views()[..10].to_vec();
    let picture = |x_m: f64| ViewPicture {
        stamp_s: x_m,
        camera: 0,
        pose: PoseBox::from([x_m, 0.0, 0.0].map(|at| Interval::centred(at, 0.01))),
        turned_since: Vec::new(),
    };
    let views = Views {
        cameras: vec![kept(&trial.optics)],
        pictures: vec![picture(0.0), picture(1.0), picture(2.0)],
        sights: Vec::new(),
    };
    // The picture at the robot's place shows two landmarks, the next one eight, and the third all ten.
    let numbers: Vec<LandmarkId> = sights.iter().map(|sight| sight.landmark).collect();
    let views_of = |landmark: LandmarkId| {
        let at = numbers.iter().position(|one| *one == landmark).unwrap();
        let first = if at < 2 {
            0
        } else if at < 8 {
            1
        } else {
            2
        };
        (first..3).map(|picture| ViewSight { picture, at_px: [0.0; 2], error_px: [0.5; 2] }).collect()
    };
    let here = PoseBox::from([Interval::ZERO; 3]);
    choose(&mut sights, &views, views_of, &here);
    let chosen: Vec<Option<usize>> = sights.iter().map(|sight| sight.view.map(|view| view.sight.picture)).collect();
    assert_eq!(chosen, [vec![Some(1); 8], vec![None; 2]].concat());
    assert_eq!(super::optics(&views.cameras[0]).camera.focal_px, trial.truth.camera.focal_px);
    assert!(trial.truth.constants.contains_key(&Constant::PointFocal));
}
