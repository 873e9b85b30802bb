//! Key frames of a drive, and the linear program that relates them.

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    sync::Arc,
};

use interval::{Interval, linear_program::ProgramError};

use crate::{
    PoseBox, RobotModel, bounds,
    motion::{FlowWay, Way},
    reading::LandmarkId,
    robot::{GyroModel, cayley_radius},
};

use super::{
    BoxLabel, Constant, Disc, Domain, Related, Relations, Row, Stray, Variable,
    link::{Link, Read},
};

/// Greatest number of key frames that are kept. With one every two seconds these are the last 200 seconds; older ones are farther apart.
const MOST: usize = 100;
/// Greatest time from a key frame to the next one, if there are readings: the latest key frame is replaced by the next until that would be exceeded.
const APART_S: f64 = 2.3;

/// The gyroscope's errors that are constant over a run.
const GYRO_ERRORS: [Variable; 2] = [Variable::Constant(Constant::GyroBias), Variable::Constant(Constant::GyroScale)];

/// Box of a landmark's world x and y.
pub type Place = [Interval; 2];

/// One stamp of the drive at which the pose is bounded.
#[derive(Clone)]
struct KeyFrame {
    number: usize,
    stamp_s: f64,
    /// Box of the pose: as it was known when the key frame was made, narrowed since by bounds of the linear program.
    pose: PoseBox,
    /// The reading that makes the pose's box, if it is of one.
    label: Option<BoxLabel>,
    /// The way from the key frame before; `None` for the first one, and where no reading of the motion is to be believed.
    link: Option<Link>,
    /// What a reading at this stamp relates, if there is one.
    relations: Option<Arc<dyn Relations>>,
    /// How far the robot can have gone between the reading's stamp and its true instant.
    stray: Stray,
    /// The greatest error of the flow sensor's place by its counts, and the stamps of the readings that the counts are of.
    place: Option<(f64, [f64; 2])>,
}

/// The key frames of a drive.
#[derive(Clone)]
pub struct KeyFrames {
    frames: VecDeque<KeyFrame>,
    constants: Domain,
    /// Pairs of constants that are together within a radius of (0, 0).
    discs: Vec<Disc>,
    gyro: Option<GyroModel>,
    flow_scale_change: f64,
    /// Corners (bias, scale) of a polygon that contains the gyroscope's bias over the whole run and its scale; none where only their intervals are
    /// known.
    gyro_errors: Vec<[f64; 2]>,
    next_number: usize,
}

impl KeyFrames {
    /// No key frames yet, for a robot with the given constants.
    pub fn new(robot: &RobotModel) -> KeyFrames {
        KeyFrames {
            frames: VecDeque::new(),
            constants: Domain::of_constants(robot),
            discs: discs_of_constants(robot),
            gyro: robot.gyro,
            flow_scale_change: robot.flow.map_or(0.0, |flow| flow.scale_change),
            gyro_errors: Vec::new(),
            next_number: 0,
        }
    }

    /// Stamp of the latest key frame.
    pub fn latest_s(&self) -> Option<f64> {
        self.frames.back().map(|latest| latest.stamp_s)
    }

    /// Number of the latest key frame; 0 before the first one.
    pub fn latest_number(&self) -> usize {
        self.frames.back().map_or(0, |latest| latest.number)
    }

    /// Stamps of the last but one and of the latest key frame.
    pub fn span_before_latest_s(&self) -> Option<[f64; 2]> {
        let before = self.frames.len().checked_sub(2)?;
        Some([self.frames[before].stamp_s, self.frames[before + 1].stamp_s])
    }

    /// Box of the headings at the last but one key frame.
    pub fn heading_before_latest(&self) -> Interval {
        self.frames.len().checked_sub(2).map_or(Interval::EMPTY, |before| self.frames[before].pose[2])
    }

    /// Adds a key frame with a later stamp than all others. It takes the place of the latest one where the key frame before that is near. `pose`
    /// encloses the pose at its stamp. The way to it is not known yet.
    pub fn push(&mut self, stamp_s: f64, pose: PoseBox, stray: Stray, relations: Option<Arc<dyn Relations>>) {
        if self.span_before_latest_s().is_some_and(|[before_s, _]| stamp_s - before_s <= APART_S) {
            self.frames.pop_back();
        }
        self.push_beside(stamp_s, pose, stray, relations);
        if self.frames.len() > MOST {
            self.drop_one();
        }
    }

    /// Adds a key frame with a later stamp than all others, however near to them.
    pub fn push_beside(&mut self, stamp_s: f64, pose: PoseBox, stray: Stray, relations: Option<Arc<dyn Relations>>) {
        let number = self.next_number;
        self.next_number += 1;
        let (label, link, place) = (None, None, None);
        self.frames.push_back(KeyFrame { number, stamp_s, pose, label, link, relations, stray, place });
    }

    /// Says which reading makes the box of the latest key frame's pose.
    pub fn label_latest(&mut self, label: Option<BoxLabel>) {
        if let Some(latest) = self.frames.back_mut() {
            latest.label = label;
        }
    }

    /// Sets what is known of the gyroscope's bias over the whole run and of its scale, by the corners of a polygon that contains both.
    pub fn know_gyro(&mut self, corners: Vec<[f64; 2]>) {
        self.gyro_errors = corners;
    }

    /// Whether a reading at the latest key frame relates its pose to other quantities.
    pub fn latest_relates(&self) -> bool {
        self.frames.back().is_some_and(|latest| latest.relations.is_some())
    }

    /// Greatest error of the stamp of the latest key frame's reading.
    pub fn latest_stamp_error_s(&self) -> f64 {
        self.frames.back().and_then(|latest| latest.relations.as_ref()).map_or(0.0, |latest| latest.stamp_error_s())
    }

    /// Sets the way from the last but one key frame to the latest one, and how far the robot can have gone within the error of the latter's stamp.
    pub fn set_latest(&mut self, way: Option<Way>, flow: Option<FlowWay>, stray: Stray) {
        let Some(mut latest) = self.frames.pop_back() else { return };
        latest.stray = stray;
        if let Some(before) = self.frames.back_mut().filter(|_| way.is_some() || flow.is_some()) {
            let place = flow.as_ref().map(|flow| [0, 1].map(|end| (flow.end_error_m[end], flow.end_readings_s[end])));
            let shares_error = place.is_some_and(|[first, _]| *before.place.get_or_insert(first) == first);
            latest.place = place.map(|[_, last]| last);
            let scale_change = self.flow_scale_change;
            latest.link = Some(Link::Read(Read { way, flow, shares_error, scale_change }));
        }
        if latest.link.is_none() && self.frames.iter().all(|frame| frame.relations.is_none()) {
            // Nothing relates the key frames before to this one.
            self.frames.clear();
        }
        self.frames.push_back(latest);
    }

    /// Narrows the pose of the latest key frame.
    pub fn narrow_latest(&mut self, pose: &PoseBox) {
        if let Some(latest) = self.frames.back_mut() {
            latest.pose = latest.pose.intersect(pose);
        }
    }

    /// Number of the key frame that is so many key frames older than the latest one.
    pub fn number_before_latest(&self, n_frames: usize) -> Option<usize> {
        Some(self.frames.get(self.frames.len().checked_sub(n_frames + 1)?)?.number)
    }

    /// Narrows the heading at the key frame with the given number.
    pub fn narrow_heading(&mut self, number: usize, heading: Interval) {
        if let Some(frame) = self.frames.iter_mut().find(|frame| frame.number == number) {
            frame.pose[2] = frame.pose[2].intersect(heading);
        }
    }

    /// Forgets all key frames, and what was known of the gyroscope.
    pub fn clear(&mut self) {
        self.frames.clear();
        self.gyro_errors.clear();
    }

    /// Drops the key frame whose neighbours are nearest in time, measured by their age, so that older key frames are farther apart than newer ones.
    /// The first one stays: where the drive began is often known best.
    fn drop_one(&mut self) {
        let Some(latest_s) = self.latest_s() else { return };
        let gap = |idx: usize| {
            let (before, after) = (&self.frames[idx - 1], &self.frames[idx + 1]);
            (after.stamp_s - before.stamp_s) / (latest_s - before.stamp_s)
        };
        let Some(at) = (1..self.frames.len() - 1).min_by(|&a, &b| gap(a).total_cmp(&gap(b))) else { return };
        let link = match (&self.frames[at].link, &self.frames[at + 1].link) {
            (Some(before), Some(after)) => {
                let numbers = [at - 1, at, at + 1].map(|at| self.frames[at].number);
                before.join(after, numbers, &self.domain(&[]))
            }
            _ => None,
        };
        self.frames[at + 1].link = link;
        self.frames.remove(at);
    }

    /// The linear program of all key frames. `known` are places of landmarks that follow from other readings.
    pub fn related(&self, known: &[(LandmarkId, Place)]) -> Result<Related, ProgramError> {
        let mut domain = self.domain(known);
        let whole_s = [self.frames.front(), self.frames.back()].map(|frame| frame.map_or(0.0, |frame| frame.stamp_s));
        let mut rows: Vec<(Row, [f64; 2])> = self.gyro_rows(&domain).into_iter().map(|row| (row, whole_s)).collect();
        let mut before: Option<&KeyFrame> = None;
        for frame in &self.frames {
            if let (Some(before), Some(link)) = (before, &frame.link) {
                let span_s = [before.stamp_s, frame.stamp_s];
                let between = link.rows([before.number, frame.number], &domain).into_iter();
                rows.extend(between.chain(self.drift_row(before, frame, &domain)).map(|row| (row, span_s)));
            }
            rows.extend(frame.rows(&domain).into_iter().map(|row| (row, [frame.stamp_s; 2])));
            before = Some(frame);
        }
        // Quantities that no row names are left out.
        let named = rows.iter().flat_map(|(row, _)| &row.terms).map(|&(variable, _)| variable);
        let named: BTreeSet<Variable> = named.collect();
        rows.extend(self.disc_rows(&named, &domain).into_iter().map(|row| (row, whole_s)));
        domain.retain(|variable| named.contains(&variable) || matches!(variable, Variable::Pose(..)));
        let labels = self.frames.iter().filter_map(|frame| Some((frame, frame.label?)));
        let boxes = labels.flat_map(|(frame, label)| {
            (0..3).filter(move |&axis| label.axes[axis]).map(move |axis| (Variable::Pose(frame.number, axis), label))
        });
        Related::new(domain, rows, boxes.collect())
    }

    /// The boxes of all quantities: of the landmarks, all that are seen from two key frames or more.
    fn domain(&self, known: &[(LandmarkId, Place)]) -> Domain {
        let mut domain = self.constants.clone();
        for (side, variable) in GYRO_ERRORS.into_iter().enumerate() {
            let known = self.gyro_errors.iter().map(|corner| Interval::point(corner[side])).reduce(Interval::hull);
            // A corner may be outside of the declared interval by a rounding error.
            let value = domain.value(variable).intersect(known.unwrap_or(Interval::ENTIRE));
            if !value.is_empty() {
                domain.put(variable, value);
            }
        }
        let known = known
            .iter()
            .flat_map(|&(landmark, place)| [0, 1].map(|axis| (Variable::Landmark(landmark, axis), (0, place[axis]))));
        let mut named: BTreeMap<Variable, (usize, Interval)> = known.collect();
        for frame in &self.frames {
            domain.put_pose(frame.number, &frame.pose);
            let shift_m = frame.shift_m();
            if shift_m > 0.0 {
                (0..2)
                    .for_each(|axis| domain.put(Variable::Shift(frame.number, axis), Interval::centred(0.0, shift_m)));
            }
            let quantities = frame.relations.iter().flat_map(|one| one.quantities(frame.number, &frame.pose));
            for (variable, value) in quantities {
                let (n_named, best) = named.entry(variable).or_insert((0, Interval::ENTIRE));
                *n_named += 1;
                *best = best.intersect(value);
            }
            if let Some(gyro) = self.gyro.filter(|gyro| frame.link.is_some() && gyro.drifts_from_way_to_way()) {
                domain.put(Variable::GyroBias(frame.number), gyro.bias_rad_per_s);
            }
            if let Some((error_m, _)) = frame.place {
                (0..2).for_each(|axis| {
                    domain.put(Variable::FlowPlace(frame.number, axis), Interval::centred(0.0, error_m))
                });
            }
            if let Some(gyro) = self.gyro.filter(GyroModel::bounds_angle) {
                let half_rad = 0.5 * gyro.angle_floor_rad;
                domain.put(Variable::GyroAngle(frame.number), Interval::centred(0.0, half_rad));
            }
        }
        for (variable, (n_named, value)) in named {
            if value.is_bounded() && (n_named > 1 || !matches!(variable, Variable::Landmark(..))) {
                domain.put(variable, value);
            }
        }
        domain
    }

    /// Rows that cut the corners off the square about each disc of quantities that other rows name: with components a and b of length r at most,
    /// |a ± b| ≤ √2·r.
    fn disc_rows(&self, named: &BTreeSet<Variable>, domain: &Domain) -> Vec<Row> {
        let of_readings = self.frames.iter().flat_map(|frame| {
            let shift = ([0, 1].map(|axis| Variable::Shift(frame.number, axis)), frame.shift_m());
            let shift = Some(shift).filter(|&(_, shift_m)| shift_m > 0.0);
            frame.relations.iter().flat_map(|relations| relations.discs(frame.number)).chain(shift)
        });
        let mut discs: BTreeMap<[Variable; 2], f64> = of_readings.collect();
        discs.extend(self.discs.iter().copied());
        let cut = |([a, b], radius): ([Variable; 2], f64)| {
            let most = (Interval::point(2.0).sqrt() * radius).hi();
            [1.0, -1.0].map(|sign| {
                let at_reference = Interval::point(domain.reference(a)) + Interval::point(domain.reference(b)) * sign;
                let sides = Interval::centred(0.0, most) - at_reference;
                Row::new(domain, &[(a, Interval::ONE), (b, Interval::point(sign))], sides)
            })
        };
        discs.retain(|pair, _| pair.iter().all(|variable| named.contains(variable)));
        discs.into_iter().flat_map(cut).collect()
    }

    /// A row for each side of the polygon that contains the gyroscope's bias and scale.
    fn gyro_rows(&self, domain: &Domain) -> Vec<Row> {
        let corners = &self.gyro_errors;
        let across = |(at, corner): (usize, &[f64; 2])| {
            let next = corners[(at + 1) % corners.len()];
            let normal = [next[1] - corner[1], corner[0] - next[0]].map(Interval::point);
            let side = |[bias, scale]: [f64; 2]| normal[0] * bias + normal[1] * scale;
            let sides = corners.iter().map(|&corner| side(corner)).fold(Interval::EMPTY, Interval::hull);
            let reference = GYRO_ERRORS.map(|variable| domain.reference(variable));
            Row::new(domain, &[(GYRO_ERRORS[0], normal[0]), (GYRO_ERRORS[1], normal[1])], sides - side(reference))
                .with_part(bounds::GYRO_BIAS, sides.radius())
                .by_device("gyro")
        };
        corners.iter().enumerate().map(across).collect()
    }

    /// The mean biases on two ways, one after the other, differ by at most what the bias drifts between their middles.
    fn drift_row(&self, before: &KeyFrame, frame: &KeyFrame, domain: &Domain) -> Option<Row> {
        let wander_rad_per_s2 = self.gyro?.bias_wander_rad_per_s2;
        let spans_s = before.link.as_ref()?.read()?.span_s()? + frame.link.as_ref()?.read()?.span_s()?;
        let biases = [before, frame].map(|frame| Variable::GyroBias(frame.number));
        if biases.iter().any(|&bias| domain.value(bias).is_empty()) {
            return None;
        }
        let drift = Interval::point(wander_rad_per_s2) * spans_s * 0.5;
        let one = Interval::point(1.0);
        let at_reference = Interval::point(domain.reference(biases[1])) - domain.reference(biases[0]);
        let sides = Interval::ZERO.hull(drift).hull(-drift) - at_reference;
        let row = Row::new(domain, &[(biases[1], one), (biases[0], -one)], sides);
        Some(row.with_part(bounds::GYRO_WANDER, drift.hi()).by_device("gyro"))
    }
}

impl KeyFrame {
    /// The rows of the reading at the key frame.
    fn rows(&self, domain: &Domain) -> Vec<Row> {
        let Some(relations) = &self.relations else { return Vec::new() };
        let shift_m = self.shift_m();
        if shift_m == 0.0 {
            return relations.rows(self.number, &self.stray, domain);
        }
        let mut rows = relations.rows(self.number, &self.stray, &domain.displaced(self.number, shift_m));
        // The rows hold for the displaced position, which is the sum of the position and the displacement.
        for row in &mut rows {
            for axis in 0..2 {
                match row.coefficient(Variable::Pose(self.number, axis)) {
                    0.0 => {}
                    coefficient => row.terms.push((Variable::Shift(self.number, axis), coefficient)),
                }
            }
        }
        rows
    }

    fn shift_m(&self) -> f64 {
        self.relations.as_ref().map_or(0.0, |relations| relations.shift_m(&self.stray))
    }
}

/// The tilts of the cameras' mounts, which are within discs.
fn discs_of_constants(robot: &RobotModel) -> Vec<Disc> {
    let pair = |of_axis: fn(usize) -> Constant| [0, 1].map(|axis| Variable::Constant(of_axis(axis)));
    let floor = robot.floor_camera.iter().map(|camera| (pair(Constant::FloorTilt), cayley_radius(camera.tilt_rad)));
    let ceiling =
        robot.ceiling_camera.iter().map(|camera| (pair(Constant::CeilingTilt), cayley_radius(camera.tilt_rad)));
    floor.chain(ceiling).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::IntervalBox;

    use super::*;
    use crate::graph::{
        Hull,
        trial::{Draw, Drive, reach, robot, wheels},
    };

    #[test]
    fn hundreds_of_seconds_on_few_key_frames_keep_the_truth_and_are_narrower_than_what_adds_up() {
        for round in 0..6 {
            let mut draw = Draw::new(20_261_127 + round);
            let drive = Drive::new(&mut draw, true, 260.0, 120);
            let history = drive.history(true);
            let mut frames = KeyFrames::new(&robot());
            let around = |at: f64, half: f64, draw: &mut Draw| {
                let off = draw.within(Interval::centred(0.0, half));
                Interval::centred(at + off, half * (1.0 + 1e-9))
            };
            let mut widths_m = Vec::new();
            for (at, (&stamp_s, truth)) in drive.stamps_s.iter().zip(&drive.poses).enumerate() {
                // The heading is known to 10 mrad at each key frame, as by walls, the position to 1 mm at the first one and to 2 m at the others.
                let half_m = if at == 0 { 0.001 } else { 2.0 };
                let pose =
                    [(0, half_m), (1, half_m), (2, 0.01)].map(|(axis, half)| around(truth[axis], half, &mut draw));
                frames.push(stamp_s, IntervalBox::from(pose), Stray::default(), None);
                if let Some([from_s, to_s]) = frames.span_before_latest_s() {
                    let flow = history.flow_way(from_s, to_s, frames.heading_before_latest(), &wheels(), &reach());
                    let way = history.way(from_s, to_s, &wheels(), &reach()).filter(|_| round % 2 == 0);
                    frames.set_latest(way, flow.filter(|_| round % 3 < 2), Stray::default());
                }
                assert!(frames.frames.len() <= MOST);
                let number = frames.latest_number();
                let wanted = (0..3).map(|axis| Variable::Pose(number, axis)).collect();
                let mut hull = Hull::new(frames.related(&[]).unwrap(), wanted);
                while !hull.advance() {}
                let bounds = hull.bounds().unwrap();
                for (axis, bound) in bounds.iter().enumerate() {
                    assert!(
                        bound.inflate(1e-6).contains(truth[axis]),
                        "round {round}, {stamp_s} s: {} not in {bound}",
                        truth[axis]
                    );
                }
                frames.narrow_latest(&IntervalBox::from([bounds[0], bounds[1], bounds[2]]));
                widths_m.push(bounds[0].width().max(bounds[1].width()));
            }
            let last_m = widths_m[widths_m.len() - 1];
            // By the flow sensor: 0.4 % of a path of at most 0.5 m/s on either side, and a few millimetres for each way. Headings that are off by 10
            // mrad on every way, all to the same side, would add twice 1 % of the path.
            let path_m: f64 = drive.path_m;
            assert!(round % 3 == 2 || last_m < 2.0 * 0.0085 * path_m, "round {round}: {last_m} m after {path_m} m");
        }
    }

    /// A reading of the position, displaced by at most 1 cm.
    struct Displaced([f64; 2]);

    impl Relations for Displaced {
        fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
            Vec::new()
        }

        fn stamp_error_s(&self) -> f64 {
            0.0
        }

        fn shift_m(&self, _stray: &Stray) -> f64 {
            0.01
        }

        fn rows(&self, frame: usize, _stray: &Stray, domain: &Domain) -> Vec<Row> {
            let row = |axis: usize| {
                let position = Variable::Pose(frame, axis);
                let sides = Interval::point(self.0[axis]) - domain.reference(position);
                Row::new(domain, &[(position, Interval::ONE)], sides.inflate(1e-4))
            };
            vec![row(0), row(1)]
        }
    }

    #[test]
    fn what_displaces_a_reading_displaces_neither_the_pose_nor_the_way() {
        let mut draw = Draw::new(20_261_131);
        for round in 0..20 {
            let drive = Drive::new(&mut draw, true, 1.0, 2);
            let history = drive.history(true);
            let displaced =
                |truth: &[f64; 3], course: f64| [truth[0] + 0.01 * course.cos(), truth[1] + 0.01 * course.sin()];
            let courses = [0, 1].map(|_| draw.between(-3.2, 3.2));
            // The bounds with readings of the position at both key frames, and those by the way alone.
            let widths = [true, false].map(|is_read| {
                let mut frames = KeyFrames::new(&robot());
                for (at, (&stamp_s, truth)) in drive.stamps_s.iter().zip(&drive.poses).enumerate() {
                    let read = Displaced(displaced(truth, courses[at]));
                    // The first position is known to 1 mm, the second one to 0.1 m.
                    let half_m = if at == 0 { 0.001 } else { 0.1 };
                    let pose = [half_m, half_m, 0.001];
                    let pose = IntervalBox::from([0, 1, 2].map(|axis| Interval::centred(truth[axis], pose[axis])));
                    frames.push(stamp_s, pose, Stray::default(), is_read.then(|| Arc::new(read) as _));
                }
                let [from_s, to_s] = frames.span_before_latest_s().unwrap();
                let flow = history.flow_way(from_s, to_s, frames.heading_before_latest(), &wheels(), &reach());
                frames.set_latest(None, flow, Stray::default());
                let number = frames.latest_number();
                let wanted = (0..3).map(|axis| Variable::Pose(number, axis)).collect();
                let mut hull = Hull::new(frames.related(&[]).unwrap(), wanted);
                while !hull.advance() {}
                let bounds = hull.bounds().unwrap();
                for (bound, truth) in bounds.iter().zip(drive.poses[1]) {
                    assert!(bound.inflate(1e-9).contains(truth), "round {round}: {truth} not in {bound}");
                }
                bounds[0].width().max(bounds[1].width())
            });
            assert!(widths[0] <= widths[1].min(0.0202) + 1e-6, "round {round}: {widths:?}");
        }
    }
}
