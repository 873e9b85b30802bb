//! Tests of the turns in which landmarks are bounded.

use interval::Interval;

use super::*;
use crate::{
    PoseBox,
    bounds::{self, Assumption},
    graph::{Domain, FrameReading, Relations, Row, Stray, trial::robot},
};

/// A reading that shows where some landmarks are in the plane.
struct Shows(Vec<u32>);

impl Relations for Shows {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let of =
            |&code: &u32| [0, 1].map(|axis| (Variable::Landmark(LandmarkId(code), axis), Interval::centred(0.0, 1.0)));
        self.0.iter().flat_map(of).collect()
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
