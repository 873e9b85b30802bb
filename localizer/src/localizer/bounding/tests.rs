//! Tests of the turns in which landmarks are bounded, and of the branches of a pose.

use interval::Interval;

use super::*;
use crate::{
    Map, PoseBox,
    bounds::{self, Assumption},
    graph::{Domain, FrameReading, Relations, Row, Stray, trial::robot},
    localizer::relating::Relating,
};

/// A reading that shows where some landmarks are in the plane.
struct Shows(Vec<u32>);

impl Relations for Shows {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let of =
            |&code: &u32| [0, 1].map(|axis| (Variable::Landmark(LandmarkId(code), axis), Interval::centred(0.0, 1.0)));
        self.0.iter().flat_map(of).collect()
    }

    fn is_found_anew(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        0.0
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::GNSS_STAMP
    }

    fn shift_m(&self, _stray: &Stray) -> f64 {
        0.0
    }

    fn shift_parts(&self, _stray: &Stray) -> Vec<(Assumption, f64)> {
        Vec::new()
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let row = |(variable, _): (Variable, Interval)| {
            let axis = match variable {
                Variable::Landmark(_, axis) => axis,
                _ => return None,
            };
            let terms = [(variable, Interval::ONE), (Variable::Pose(frame, axis), -Interval::ONE)];
            Some(Row::new(domain, &terms, Interval::centred(0.0, 0.1)))
        };
        self.quantities(frame, &PoseBox::from([Interval::ZERO; 3])).into_iter().filter_map(row).collect()
    }
}

#[test]
fn all_landmarks_of_the_program_take_turns() {
    let mut graph = Graph::new(&robot());
    let pose = PoseBox::from([Interval::centred(0.0, 0.1); 3]);
    for stamp_s in [0.0, 1.0] {
        let shows = std::sync::Arc::new(Shows(vec![3, 5, 7, 11, 13]));
        graph.frames.push_beside(stamp_s, pose, Some(FrameReading::new("", shows, Stray::default())));
    }
    let related = graph.frames.related(&[]).unwrap();
    let mut turn = || -> Vec<u32> {
        let wanted = graph.wanted_landmarks(&related);
        assert!(wanted.len() <= COORDINATES);
        let code = |variable: &Variable| match variable {
            Variable::Landmark(LandmarkId(code), 0) => Some(*code),
            _ => None,
        };
        wanted.iter().filter_map(code).collect()
    };
    assert_eq!([turn(), turn(), turn()], [vec![3, 5], vec![7, 11], vec![13, 3]]);
}

/// What is left of the branches of a resting robot's pose by the graph. 0.8 s before, its pose was known to 10 cm and 0.1 rad about 0, and both
/// times it is within 10 cm of the same landmark. Where `is_told_to_rest` says no, neither wheels nor gyroscope tell that it rests.
fn left_of(branches: Vec<PoseBox>, is_told_to_rest: bool) -> Option<PoseUnion> {
    let map = Map::of_room([Interval::new(-5.0, 5.0); 2]);
    let start = PoseBox::from([Interval::centred(0.0, 0.1); 3]);
    let mut localizer = Localizer::new(map, RobotModel { flow: None, ..robot() }, Vec::new(), start);
    for step in (0..=100_u32).filter(|_| is_told_to_rest) {
        let time_s = 0.01 * f64::from(step);
        localizer.wheels.push(time_s, [0; 2]);
        localizer.wheels.push_rate(time_s, 0.0);
    }
    for (stamp_s, branches) in [(0.0, vec![start]), (0.8, branches)] {
        let (source, shows) = ("", std::sync::Arc::new(Shows(vec![7])));
        let union = PoseUnion { branches };
        localizer.ring.push(Slot::anchor(stamp_s, vec![union.clone()]));
        localizer.relate(stamp_s, &union, Some(Relating { source, relations: shows, shown: None }));
    }
    (0..1000).for_each(|_| localizer.work_on_graph());
    localizer.ring.at(0.8).and_then(|slot| slot.related.clone())
}

fn about(x_m: f64, heading_rad: f64) -> PoseBox {
    PoseBox::from([(x_m, 0.3), (0.0, 0.3), (heading_rad, 0.1)].map(|(mid, half)| Interval::centred(mid, half)))
}

#[test]
fn a_branch_that_contradicts_the_graph_is_left_out() {
    let alone = left_of(vec![about(0.0, 0.0)], true).unwrap();
    assert!(alone.branches.len() == 1 && alone.contains(crate::Pose::default()), "{alone:?}");
    // One metre from the landmark; or the other way round, which a resting robot does not turn to.
    for other in [about(1.0, 0.0), about(0.0, 3.0), about(1.0, 3.0)] {
        assert_eq!(left_of(vec![about(0.0, 0.0), other], true).unwrap(), alone, "{other:?}");
        assert_eq!(left_of(vec![other, about(0.0, 0.0)], true).unwrap(), alone, "{other:?}");
    }
}

#[test]
fn of_each_possible_branch_what_the_graph_leaves_is_kept() {
    // Two poses beside each other, both possible: what is between them is not.
    let [left, right] = [-0.06, 0.06].map(|x_m| {
        PoseBox::from([(x_m, 0.02), (0.0, 0.3), (0.0, 0.1)].map(|(mid, half)| Interval::centred(mid, half)))
    });
    let union = left_of(vec![left, right], true).unwrap();
    assert_eq!(union.branches.len(), 2, "{union:?}");
    assert!(union.contains(crate::Pose { x_m: -0.06, ..Default::default() }), "{union:?}");
    assert!(union.contains(crate::Pose { x_m: 0.06, ..Default::default() }), "{union:?}");
    assert!(!union.contains(crate::Pose::default()), "{union:?}");
    assert!(union.branches.iter().all(|branch| branch[1].width() < 0.5), "{union:?}");
}

#[test]
fn a_pose_of_up_to_four_headings_is_bounded_about_each_of_them() {
    let facing = |n_headings: u32| (0..n_headings).map(|at| about(0.0, 1.5 * f64::from(at))).collect::<Vec<PoseBox>>();
    for n_headings in 1..=4 {
        let left = left_of(facing(n_headings), false).unwrap();
        assert_eq!(left.branches.len(), n_headings as usize, "{left:?}");
        // Within 10 cm of the landmark, which is within 10 cm of where the robot was; and as long a way off along y.
        assert!(left.branches.iter().all(|branch| (0..2).all(|axis| branch[axis].width() < 0.62)), "{left:?}");
        for branch in facing(n_headings) {
            let heading_rad = branch[2].mid();
            assert!(left.contains(crate::Pose { heading_rad, ..Default::default() }), "{heading_rad}: {left:?}");
        }
    }
    assert_eq!(left_of(facing(5), false), None);
}

#[test]
fn a_pose_in_more_branches_than_four_about_one_heading_is_bounded_by_its_hull() {
    let five = |apart_rad: f64| (0..5).map(|at| about(0.7 * f64::from(at) - 1.4, apart_rad * f64::from(at))).collect();
    assert_eq!(left_of(five(0.01), true).unwrap().branches.len(), 1);
    let too_wide = [(0.0, 0.1), (0.0, 0.1), (0.0, 0.16)].map(|(mid, half)| Interval::centred(mid, half));
    assert_eq!(left_of(vec![PoseBox::from(too_wide)], true), None);
}
