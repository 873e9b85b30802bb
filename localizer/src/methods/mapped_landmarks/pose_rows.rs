//! What a picture says of the pose, as rows of the graph of key frames.
//!
//! A box of the pose keeps little of what a picture says: a picture of a wall ahead tells the heading well if the place across is known, and the place
//! if the heading is, but neither alone. So the pose is bounded along the directions in the space of x, y and heading that the picture tells best, and
//! the graph relates them to what pictures from other places tell.

use std::sync::OnceLock;

use interval::Interval;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::{
    PoseBox,
    bounds::{self, Assumption},
    graph::{Domain, Relations, Row, Stray, Variable},
};

use super::few_wrong::{FewWrong, hull};

/// Number of the key frame in a program of one picture.
const FRAME: usize = 0;

/// Rows of the pose by the sightings of a picture, of which a few may be wrong.
pub(super) struct PoseRows {
    sightings: FewWrong,
    stamp_error_s: f64,
    /// Whether the landmarks are those of a map, and none that the drive teaches.
    is_of_the_map: bool,
    /// The picture of the teaching drive relative to which the sightings tell the pose.
    view: Option<NearView>,
    /// Coefficients of quantities, with bounds of their sum over all poses that the picture may show: made when they are first needed.
    rows: OnceLock<Vec<(Function, Interval)>>,
}

/// Coefficients of quantities.
type Function = Vec<(Variable, f64)>;

/// A picture of the drive that taught the map, from near the pose.
#[derive(Clone, Debug)]
pub(super) struct NearView {
    /// Index of the picture.
    pub(super) picture: usize,
    /// Box of the pose from which it was taken.
    pub(super) pose: PoseBox,
    /// Earlier pictures by their indices, with the turn since.
    pub(super) turned_since: Vec<(usize, Interval)>,
}

impl PoseRows {
    pub(super) fn new(
        sightings: FewWrong,
        stamp_error_s: f64,
        is_of_the_map: bool,
        view: Option<NearView>,
    ) -> PoseRows {
        PoseRows { sightings, stamp_error_s, is_of_the_map, view, rows: OnceLock::new() }
    }

    /// The rows for a picture from a pose within a box: bounds over all parts of the box that the sightings do not exclude.
    fn make(&self, pose: &PoseBox) -> Vec<(Function, Interval)> {
        let Some(program) = self.sightings.program(pose) else { return Vec::new() };
        let best = told_best(&program.on_pose(), [0, 1, 2].map(|axis| 0.5 * pose.width(axis)));
        let functions: Vec<Function> = best.into_iter().map(|of_pose| self.relative(of_pose, pose)).collect();
        let bounds =
            parts(pose).into_iter().filter_map(|part| self.sightings.program(&part)?.bounds_of_all(&functions));
        hull(bounds).map_or_else(Vec::new, |hull| functions.into_iter().zip(hull).collect())
    }
}

impl PoseRows {
    /// A function of the pose, less that function of the pose of the view by which the difference stays as it is where both are displaced and turned
    /// together.
    fn relative(&self, of_pose: [f64; 3], pose: &PoseBox) -> Function {
        let mut function: Function = (0..3).map(|axis| (Variable::Pose(FRAME, axis), of_pose[axis])).collect();
        if let Some(view) = &self.view {
            let [x_m, y_m] = [0, 1].map(|axis| pose[axis].mid() - view.pose[axis].mid());
            let of_turn = of_pose[2] - of_pose[0] * y_m + of_pose[1] * x_m;
            let of_view = [of_pose[0], of_pose[1], of_turn];
            function.extend((0..3).map(|axis| (Variable::ViewPose(view.picture, axis), -of_view[axis])));
        }
        function
    }

    /// Rows of the turn from earlier views that the domain has to this one's.
    fn turns(&self, domain: &Domain) -> Vec<Row> {
        let Some(view) = &self.view else { return Vec::new() };
        let here = Variable::ViewPose(view.picture, 2);
        let known = |&&(earlier, _): &&(usize, Interval)| !domain.value(Variable::ViewPose(earlier, 2)).is_empty();
        let row = |&(earlier, turn): &(usize, Interval)| {
            let there = Variable::ViewPose(earlier, 2);
            let at_reference = Interval::point(domain.reference(here)) - Interval::point(domain.reference(there));
            Row::new(domain, &[(here, Interval::ONE), (there, -Interval::ONE)], turn - at_reference)
        };
        view.turned_since.iter().filter(known).map(row).collect()
    }
}

/// A box in eight parts, each half as wide along every axis. What is not linear in the rows is about a quarter in a part of what it is in the box.
fn parts(pose: &PoseBox) -> Vec<PoseBox> {
    (0..3).fold(vec![*pose], |parts, axis| {
        parts.iter().flat_map(|part| <[PoseBox; 2]>::from(part.bisect(axis))).collect()
    })
}

/// The directions in the space of a pose that rows tell best: the principal axes of Σ a·aᵀ/s², with the coefficients a of a row and the half width s of
/// its sides. All coordinates are counted in half widths of the pose's box.
fn told_best(rows: &[([f64; 3], f64)], halves: [f64; 3]) -> Vec<[f64; 3]> {
    let halves = halves.map(|half| half.max(1e-9));
    let mut sum = Matrix3::zeros();
    for (coefficients, side) in rows {
        let scaled = Vector3::from_fn(|axis, _| coefficients[axis] * halves[axis] / side.max(1e-9));
        sum += scaled * scaled.transpose();
    }
    let axes = SymmetricEigen::new(sum).eigenvectors;
    let axes: Vec<Vector3<f64>> = axes.column_iter().map(|axis| axis.into_owned()).collect();
    axes.iter().map(|axis| [0, 1, 2].map(|k| axis[k] / halves[k])).collect()
}

impl Relations for PoseRows {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let of_view = |view: &NearView| [0, 1, 2].map(|axis| (Variable::ViewPose(view.picture, axis), view.pose[axis]));
        self.view.iter().flat_map(of_view).collect()
    }

    fn is_of_the_map(&self) -> bool {
        self.is_of_the_map
    }

    fn stamp_error_s(&self) -> f64 {
        self.stamp_error_s
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::FORWARD_CAMERA_STAMP
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        [bounds::FORWARD_CAMERA_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres)).to_vec()
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let pose = PoseBox::from([0, 1, 2].map(|axis| domain.value(Variable::Pose(frame, axis))));
        let rows = self.rows.get_or_init(|| self.make(&pose));
        let row = |(function, sides): &(Function, Interval)| {
            let at_frame =
                |variable| if let Variable::Pose(_, axis) = variable { Variable::Pose(frame, axis) } else { variable };
            let terms: Vec<(Variable, Interval)> =
                function.iter().map(|&(variable, a)| (at_frame(variable), Interval::point(a))).collect();
            let at_reference = terms.iter().fold(Interval::ZERO, |sum, &(variable, coefficient)| {
                sum + coefficient * Interval::point(domain.reference(variable))
            });
            Row::new(domain, &terms, *sides - at_reference).by_device("forward_camera")
        };
        rows.iter().map(row).chain(self.turns(domain)).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{
        graph::trial::{Draw, rounds},
        methods::mapped_landmarks::few_wrong::{
            MostWrong,
            tests::{trial, with_moved_thing},
        },
    };

    #[test]
    fn the_true_pose_satisfies_the_rows_of_a_picture_with_wrong_sightings() {
        let mut draw = Draw::new(20_261_203);
        let n_rounds = rounds(15);
        let mut n_narrow = 0;
        for round in 0..n_rounds {
            let n_wrong = round % 3;
            let (optics, sights, pose, truth) = trial(&mut draw, n_wrong);
            // Of every other picture all sightings of one thing are wrong, too.
            let (mut sights, things) = (sights, round % 2);
            if things > 0 {
                with_moved_thing(&mut sights, (round % 3) as u32, [30.0, 20.0]);
            }
            let most_wrong = MostWrong { items: n_wrong, things };
            let rows = PoseRows::new(FewWrong::new(&optics, Stray::default(), &sights, most_wrong), 0.0, true, None);
            let mut domain = Domain::default();
            domain.put_pose(4, &pose);
            let made = rows.rows(4, &domain);
            assert_eq!(made.len(), 3);
            // In a narrower domain the same rows hold, though their reference values have moved.
            let narrower = [0, 1, 2].map(|axis| pose[axis].intersect(Interval::centred(truth[axis], 0.01)));
            domain.put_pose(4, &PoseBox::from(narrower));
            for row in rows.rows(4, &domain).iter().chain(&made) {
                let reference = |variable| domain.reference(variable);
                let at_first = |variable: Variable| pose[axis_of(variable)].mid();
                let is_first = made.contains(row);
                let value = row.value_at(|variable| {
                    truth[axis_of(variable)] - if is_first { at_first(variable) } else { reference(variable) }
                });
                assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {}", row.sides);
            }
            // The best told direction is far narrower than the box of the pose allows.
            let range = |row: &Row| {
                row.terms.iter().map(|&(variable, a)| a.abs() * pose[axis_of(variable)].width()).sum::<f64>()
            };
            n_narrow += usize::from(made.iter().any(|row| row.sides.width() < 0.2 * range(row)));
        }
        assert!(3 * n_narrow >= 2 * n_rounds, "{n_narrow}");
    }

    #[test]
    fn the_parts_of_a_box_are_half_as_wide_and_cover_it() {
        let mut draw = Draw::new(20_261_127);
        let pose = PoseBox::from([Interval::new(-0.3, 0.1), Interval::new(2.0, 2.7), Interval::new(-3.2, -3.1)]);
        let parts = parts(&pose);
        assert!(parts.iter().all(|part| (0..3).all(|axis| part.width(axis) < 0.51 * pose.width(axis))));
        for _ in 0..1000 {
            let at = [0, 1, 2].map(|axis| draw.within(pose[axis]));
            assert!(parts.iter().any(|part| (0..3).all(|axis| part[axis].contains(at[axis]))), "{at:?}");
        }
    }

    fn axis_of(variable: Variable) -> usize {
        (0..3).find(|&axis| variable == Variable::Pose(4, axis)).unwrap()
    }

    #[test]
    fn the_direction_that_rows_tell_best_is_theirs() {
        // One row tells x + 2 m/rad · heading to a millimetre; nothing else is told. The box is 0.2 m and 0.1 rad wide.
        let best = told_best(&[([1.0, 0.0, 2.0], 1e-3)], [0.1, 0.1, 0.05]);
        let like_it =
            |[x, y, heading]: &[f64; 3]| y.abs() < 1e-9 * x.abs() && (heading - 2.0 * x).abs() < 1e-9 * x.abs();
        assert_eq!(best.iter().filter(|one| like_it(one)).count(), 1, "{best:?}");
    }
}
