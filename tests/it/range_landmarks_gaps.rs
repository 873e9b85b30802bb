//! What must not be taken for consecutive, and what must not outlive a doubt.

use localizer::{
    Constraint, Contractor, Interval, Localizer, Map, Method, PoseBox, PoseUnion, Reading,
    method::Twist,
    methods::range_landmarks::{Freedom, RangeLandmarks, Solver},
    reading::Sighting,
};
use nalgebra::Point3;

use crate::range_landmarks_setup::{HEIGHT_M, Landmark, Only, TrueCamera, random, robot, says};

/// A robot at rest in the origin that sees one landmark, or another one that is taken for it.
struct Stand {
    method: RangeLandmarks,
    right: Sighting,
    wrong: Sighting,
    truth: [f64; 2],
}

impl Stand {
    fn new(wrong_spacing: usize) -> Stand {
        let mut rng = random(30);
        let camera = TrueCamera::drawn(&mut rng);
        let [own, other] = [[2.5, 1.2], [1.8, 0.2]]
            .map(|[x, y]| Landmark { code: localizer::reading::LandmarkId(4), place: Point3::new(x, y, HEIGHT_M) });
        let mut sight = |mark: &Landmark| camera.sight([0.0; 3], mark, &mut rng).expect("in view");
        Stand {
            right: sight(&own),
            wrong: sight(&other),
            truth: own.xy(),
            method: RangeLandmarks::new(&robot(1, wrong_spacing), Freedom::Full, Solver::OneShot).expect("a camera"),
        }
    }

    fn read(&mut self, stamp_s: f64, sighting: Sighting, is_learnt: bool) {
        let pose = PoseUnion::single(PoseBox::point(&[0.0; 3]));
        let reading = Reading::Range { measured_s: stamp_s, arrived_s: stamp_s, sightings: vec![sighting] };
        self.method.constrain(&reading, &pose, &Twist::default());
        if is_learnt {
            self.method.learn(&pose, &|_, _| Some(PoseBox::point(&[0.0; 3])));
        }
        for (_, [x, y]) in self.method.landmarks() {
            assert!(x.contains(self.truth[0]) && y.contains(self.truth[1]), "{x:?}, {y:?} after {stamp_s} s");
        }
    }
}

#[test]
fn a_use_that_is_not_learnt_from_ends_a_window() {
    let mut stand = Stand::new(1);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    stand.read(0.2, right, false);
    stand.read(0.4, wrong, true);
    stand.read(0.6, right, true);
    stand.read(0.8, right, true);
    assert_eq!(stand.method.landmarks().len(), 1);
}

#[test]
fn what_is_unlearnt_ends_a_window() {
    let mut stand = Stand::new(2);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    stand.read(0.2, right, true);
    stand.method.forget_since(0.1);
    for (stamp_s, sighting) in [(0.4, right), (0.6, wrong), (0.8, right), (1.0, right), (1.2, wrong), (1.4, right)] {
        stand.read(stamp_s, sighting, true);
    }
    assert_eq!(stand.method.landmarks().len(), 1);
}

#[test]
fn a_robot_that_is_put_elsewhere_ends_a_window() {
    let mut stand = Stand::new(1);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    stand.method.clock_set_back();
    stand.read(0.0, wrong, true);
    stand.read(0.2, right, true);
}

/// Says x = 0 as long as it remembers what it learnt, and afterwards what its readings say: x = 0.5.
struct Believer {
    has_forgotten: bool,
    n_readings: usize,
}

impl Method for Believer {
    fn name(&self) -> &'static str {
        "believer"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn constrain(&mut self, reading: &Reading, _prior: &PoseUnion, _twist: &Twist) -> Option<Constraint> {
        self.n_readings += 1;
        let x_m = if self.n_readings == 1 { 0.0 } else { 0.5 };
        Some(says(self.name(), reading, 0, Interval::centred(x_m, 0.01)))
    }

    fn forget_since(&mut self, _since_s: f64) {
        self.has_forgotten = true;
    }

    fn renewed(&self, _stamp_s: f64) -> Option<Box<dyn Contractor<3> + Send + Sync>> {
        self.has_forgotten
            .then(|| Box::new(Only(0, Interval::centred(0.5, 0.01))) as Box<dyn Contractor<3> + Send + Sync>)
    }
}

#[test]
fn constraints_that_stood_on_what_is_unlearnt_are_made_anew() {
    let start =
        PoseBox::from([Interval::centred(0.5, 0.6), Interval::centred(0.5, 0.01), Interval::centred(0.0, 0.01)]);
    let map = Map {
        room_m: [Interval::new(-1.0, 4.0), Interval::new(-1.0, 3.0)],
        tiles: None,
        markers: None,
        wall_directions_rad: Vec::new(),
    };
    let mut localizer =
        Localizer::new(map, robot(0, 1), vec![Box::new(Believer { has_forgotten: false, n_readings: 0 })], start);
    let look = |time_s: f64| Reading::Range { measured_s: time_s, arrived_s: time_s, sightings: Vec::new() };
    for step in 0..=300 {
        let time_s = f64::from(step) * 0.01;
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
        if step == 290 || step == 300 {
            localizer.observe(&look(time_s));
        }
    }
    // At 2.9 s it said 0, at 3.0 s 0.5, which no robot can do. What it said at 2.9 s came of what it has since unlearnt.
    let hull = localizer.estimate().pose.hull();
    assert!(hull[0].contains(0.5) && hull[0].width() < 0.05, "{:?}", hull[0]);
}
