//! Readings of the range camera: the columns at which its two views see landmarks.
//!
//! A sighting whose columns are not those of the landmark that its code names has a wrong code. In a witness other codes may be wrong than in truth, as
//! many and as far apart as declared.

mod codes;

use std::collections::BTreeSet;

use interval::Interval;
use localizer::{bounds, reading::Sighting, robot::RangeCameraModel};

use super::{
    history::{History, Looker, Quantity},
    kind::{Broken, Declared, Kind, Linearised, demand, within},
    number::{Number, turned_about, turned_by},
};
use codes::Codes;

/// What the range camera saw at one stamp.
pub(super) struct Look {
    pub(super) stamp: usize,
    /// Stamp that the camera gave the reading.
    pub(super) measured_s: f64,
    /// Sightings, each with the code that the camera gave it. One that names another landmark bounds nothing.
    pub(super) sightings: Vec<Sighting>,
}

/// All readings of the range camera that have arrived by an instant, in the order of measurement.
pub(super) struct Range {
    pub(super) looks: Vec<Look>,
    pub(super) model: RangeCameraModel,
    /// Greatest error of a stamp.
    pub(super) stamp_error_s: f64,
}

/// Number of quantities that a sighting depends on.
const N_INPUTS: usize = 16;

/// Step of the numeric differentiation: near the cube root of the rounding unit, for central differences.
const STEP: f64 = 1e-6;

/// What a sighting depends on: the pose (3), the body's roll and pitch, the landmark (3), position (2), yaw, tilt (2), focal length and baseline of
/// the camera, and the body's heave.
type Inputs<T> = [T; N_INPUTS];

/// Columns at which both views see a landmark, less the column of the optical axis, and the landmark's depth.
fn columns_px<T: Number>(inputs: &Inputs<T>, height_m: T) -> ([T; 2], T) {
    let &[x, y, heading, roll, pitch, lx, ly, lz, forward, left, yaw, tilt_x, tilt_y, focal, baseline, heave] = inputs;
    // The body is turned by Rz(heading)·Ry(pitch)·Rx(roll), the camera on it by its tilt and then by its yaw. All of it is undone, outermost first.
    let in_body = turned_about(2, -heading, [lx - x, ly - y, lz - heave]);
    let in_body = turned_about(0, -roll, turned_about(1, -pitch, in_body));
    let from_view = [in_body[0] - forward, in_body[1] - left, in_body[2] - height_m];
    let [ahead, to_left, _] = turned_about(2, -yaw, turned_by([-tilt_x, -tilt_y], from_view));
    let right = -to_left;
    ([(focal * right).over(ahead), (focal * (right - baseline)).over(ahead)], ahead)
}

impl Range {
    /// The quantities of the history that a sighting depends on, in the order of the inputs after the pose.
    fn quantities(stamp: usize, landmark: u32) -> [Quantity; N_INPUTS - 3] {
        [
            Quantity::BodyTilt(stamp, 0),
            Quantity::BodyTilt(stamp, 1),
            Quantity::Landmark(landmark, 0),
            Quantity::Landmark(landmark, 1),
            Quantity::Landmark(landmark, 2),
            Quantity::RangePosition(0),
            Quantity::RangePosition(1),
            Quantity::RangeYaw,
            Quantity::RangeTilt(0),
            Quantity::RangeTilt(1),
            Quantity::RangeFocal,
            Quantity::RangeBaseline,
            Quantity::Heave(stamp),
        ]
    }

    fn inputs<T: Number>(history: &History, look: &Look, quantities: &[Quantity; N_INPUTS - 3]) -> Inputs<T> {
        let pose = history.pose_at(history.value(Quantity::Instant(Looker::Range, look.stamp)));
        std::array::from_fn(|at| if at < 3 { pose[at] } else { T::of(history.value(quantities[at - 3])) })
    }

    /// Interval in which each view's column is, less the column of the optical axis.
    fn cells_px(&self, sighting: &Sighting) -> [Interval; 2] {
        let half = |view: usize| Interval::point(self.model.step_px[view]) * 0.5;
        let cell = |read_px: f64, view: usize| {
            let middle = Interval::point(read_px) - Interval::point(self.model.centre_px);
            Interval::new((middle - half(view)).hi(), (middle + half(view)).lo())
        };
        [cell(sighting.left_px, 0), cell(sighting.right_px, 1)]
    }

    /// How far a sighting's columns are from the middle of their cells, as a share of half a cell, where that share is greatest; infinite for a landmark
    /// that is not in front of the camera.
    fn used(&self, history: &History, look: &Look, sighting: &Sighting) -> f64 {
        let inputs: Inputs<f64> = Range::inputs(history, look, &Range::quantities(look.stamp, sighting.landmark.0));
        let (columns, depth_m) = columns_px(&inputs, self.model.height_m);
        let used =
            columns.into_iter().zip(self.cells_px(sighting)).map(|(at, cell)| (at - cell.mid()).abs() / cell.radius());
        if depth_m > 0.0 { used.fold(0.0, f64::max) } else { f64::INFINITY }
    }

    /// Demands that a sighting's columns surely are those of the landmark that its code names.
    fn check_columns(&self, history: &History, look: &Look, sighting: &Sighting, slack: f64) -> Result<(), Broken> {
        let time_s = history.stamps_s[look.stamp];
        let inputs: Inputs<Interval> =
            Range::inputs(history, look, &Range::quantities(look.stamp, sighting.landmark.0));
        let (columns, depth_m) = columns_px(&inputs, Interval::point(self.model.height_m));
        let ahead = Interval::new(0.0, f64::INFINITY);
        demand(slack, bounds::RANGE_CAMERA_COLUMNS, time_s, depth_m, ahead)?;
        for (column, cell) in columns.into_iter().zip(self.cells_px(sighting)) {
            demand(slack, bounds::RANGE_CAMERA_COLUMNS, time_s, column, cell)?;
        }
        Ok(())
    }

    fn codes(&self) -> Vec<u32> {
        let mut codes: Vec<u32> =
            self.looks.iter().flat_map(|look| look.sightings.iter().map(|sighting| sighting.landmark.0)).collect();
        codes.sort_unstable();
        codes.dedup();
        codes
    }
}

impl Range {
    /// The sightings, each given by its look and its place there, whose codes the search takes for wrong: those that are, and of those whose columns are
    /// nearly at the ends of their cells as many as may be.
    fn wrong(&self, history: &History) -> BTreeSet<(usize, usize)> {
        if self.model.q_items == 0 {
            return BTreeSet::new();
        }
        let looks = self.looks.iter().map(|look| {
            look.sightings.iter().map(|sighting| (sighting.landmark, self.used(history, look, sighting))).collect()
        });
        codes::most_used(&looks.collect::<Vec<_>>(), self.model.q_items, self.model.wrong_spacing)
    }
}

impl Kind for Range {
    fn declared(&self, history: &History) -> Vec<Declared> {
        let model = &self.model;
        let mut all = Vec::new();
        let mut put = |quantity, interval, bound| all.push(Declared { quantity, interval, bound });
        for axis in 0..2 {
            put(Quantity::RangePosition(axis), model.position_m[axis], bounds::RANGE_CAMERA_POSITION);
            put(Quantity::RangeTilt(axis), Interval::new(-model.tilt_rad, model.tilt_rad), bounds::RANGE_CAMERA_TILT);
        }
        put(Quantity::RangeYaw, model.yaw_rad, bounds::RANGE_CAMERA_YAW);
        put(Quantity::RangeFocal, model.focal_px, bounds::RANGE_CAMERA_FOCAL);
        put(Quantity::RangeBaseline, model.baseline_m, bounds::RANGE_CAMERA_BASELINE);
        let heights_m = Interval::new(model.height_m - model.height_span_m, model.height_m + model.height_span_m);
        for code in self.codes() {
            put(Quantity::Landmark(code, 0), Interval::ENTIRE, bounds::RANGE_CAMERA_COLUMNS);
            put(Quantity::Landmark(code, 1), Interval::ENTIRE, bounds::RANGE_CAMERA_COLUMNS);
            put(Quantity::Landmark(code, 2), heights_m, bounds::RANGE_CAMERA_HEIGHT_SPAN);
        }
        for look in &self.looks {
            let instants_s = history.instants_s(look.measured_s, self.stamp_error_s);
            put(Quantity::Instant(Looker::Range, look.stamp), instants_s, bounds::RANGE_CAMERA_STAMP);
        }
        all
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let tilt = [0, 1].map(|axis| Interval::point(history.value(Quantity::RangeTilt(axis))));
        let tilt_rad = tilt[0].hypot(tilt[1]);
        let most_rad = within(Interval::point(self.model.tilt_rad));
        demand(slack, bounds::RANGE_CAMERA_TILT, history.stamps_s[0], tilt_rad, most_rad)?;
        let mut codes = Codes::new(&self.model);
        for look in &self.looks {
            codes.begin(history.stamps_s[look.stamp]);
            for sighting in &look.sightings {
                codes.take(sighting.landmark, self.check_columns(history, look, sighting, slack))?;
            }
        }
        Ok(())
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        near.add_disc([0, 1].map(Quantity::RangeTilt), self.model.tilt_rad);
        let wrong = self.wrong(near.history);
        for (at_look, look) in self.looks.iter().enumerate() {
            let velocity = near.history.velocity_at(look.stamp);
            for (at_sighting, sighting) in look.sightings.iter().enumerate() {
                if wrong.contains(&(at_look, at_sighting)) {
                    continue;
                }
                let quantities = Range::quantities(look.stamp, sighting.landmark.0);
                let inputs: Inputs<f64> = Range::inputs(near.history, look, &quantities);
                let at = columns_px(&inputs, self.model.height_m).0;
                let mut terms = [Vec::with_capacity(N_INPUTS + 9), Vec::with_capacity(N_INPUTS + 9)];
                for input in 0..N_INPUTS {
                    let moved = [STEP, -STEP].map(|step| {
                        let mut moved = inputs;
                        moved[input] += step;
                        columns_px(&moved, self.model.height_m).0
                    });
                    for view in 0..2 {
                        let slope = (moved[0][view] - moved[1][view]) / (2.0 * STEP);
                        match input {
                            0..3 => {
                                terms[view].extend(near.pose(look.stamp, input, slope));
                                let instant = Quantity::Instant(Looker::Range, look.stamp);
                                terms[view].push(near.quantity(instant, slope * velocity[input]));
                            }
                            _ => terms[view].push(near.quantity(quantities[input - 3], slope)),
                        }
                    }
                }
                for ((terms, value), cell) in terms.into_iter().zip(at).zip(self.cells_px(sighting)) {
                    near.add(terms, value, cell);
                }
            }
        }
    }
}
