//! What a satellite position relates: the robot's pose and the antenna's position on the robot.

use interval::Interval;

use crate::{
    PoseBox,
    bounds::{self, Assumption},
    graph::{Constant, Domain, Relations, Row, SeenPlace, Stray, Variable},
};

use super::DEVICE;

/// The antenna at the place that the receiver reported.
pub(super) struct AntennaAt {
    /// World x and y of the antenna, as reported.
    pub(super) told_m: [f64; 2],
    /// The bound on the error of either coordinate, and its value.
    pub(super) within: (Assumption, f64),
    /// Position of the antenna in the robot frame: forward and left.
    pub(super) position_m: [Interval; 2],
    /// How far the body's lean may displace the antenna forward or left.
    pub(super) lean_m: Interval,
    /// Greatest error of the position's stamp.
    pub(super) stamp_error_s: f64,
}

impl Relations for AntennaAt {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        [0, 1].map(|axis| (position(axis), self.position_m[axis])).to_vec()
    }

    fn is_found_anew(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        self.stamp_error_s
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::GNSS_STAMP
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        [bounds::GNSS_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres)).to_vec()
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let axes = [[Interval::ONE, Interval::ZERO], [Interval::ZERO, Interval::ONE]];
        let middle_m = self.position_m.map(|side| Interval::point(side.mid()));
        let antenna = SeenPlace {
            device: DEVICE,
            yaw: None,
            middle_m,
            terms: [0, 1].map(|axis| (position(axis), self.position_m[axis].mid(), axes[axis])).to_vec(),
            noise_m: axes.map(|axis| (axis, self.lean_m, Some(bounds::BODY_TILT))).to_vec(),
            turn_rad: 0.0,
        };
        let (bound, within_m) = self.within;
        let along = |axis: usize| {
            let told = Interval::centred(self.told_m[axis], within_m);
            antenna.at(frame, domain).row(axes[axis], told, &[]).with_part(bound, within_m)
        };
        vec![along(0), along(1)]
    }
}

fn position(axis: usize) -> Variable {
    Variable::Constant(Constant::GnssPosition(axis))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::graph::trial::{Draw, rounds};

    #[test]
    fn the_truth_satisfies_the_rows_of_a_position_at_the_corners_of_all_bounds() {
        let mut draw = Draw::new(20_261_125);
        let mut n_tight = 0;
        for round in 0..rounds(20_000) {
            let pose = [draw.between(-20.0, 20.0), draw.between(-20.0, 20.0), draw.between(-4.0, 4.0)];
            let (within_m, lean_m) = (draw.size(1e-6, 0.5), draw.size(1e-6, 0.05));
            let position_m = [0, 1].map(|_| {
                let half_m = draw.size(1e-6, 0.02);
                Interval::centred(draw.between(-0.5, 0.5), half_m)
            });
            let mut truth: BTreeMap<Variable, f64> =
                (0..2).map(|axis| (position(axis), draw.within(position_m[axis]))).collect();
            let lean_m = Interval::centred(0.0, lean_m);
            let [forward, left] = [0, 1].map(|axis| truth[&position(axis)] + draw.within(lean_m));
            let (sin, cos) = f64::sin_cos(pose[2]);
            let antenna_m = [pose[0] + cos * forward - sin * left, pose[1] + sin * forward + cos * left];
            let told_m = antenna_m.map(|at| at + draw.within(Interval::centred(0.0, within_m)));
            let reading =
                AntennaAt { told_m, within: (bounds::GNSS_FIXED, within_m), position_m, lean_m, stamp_error_s: 0.0 };
            let mut domain = Domain::default();
            for (axis, at) in pose.into_iter().enumerate() {
                let half = draw.size(1e-6, 0.3);
                let off = draw.within(Interval::centred(0.0, half));
                domain.put(Variable::Pose(0, axis), Interval::centred(at + off, half * (1.0 + 1e-9)));
                truth.insert(Variable::Pose(0, axis), at);
            }
            let quantities = reading.quantities(0, &PoseBox::from([Interval::ZERO; 3]));
            quantities.into_iter().for_each(|(variable, value)| domain.put(variable, value));
            for row in reading.rows(0, &domain) {
                let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {row:?}");
                n_tight += usize::from(row.sides.radius() < 1.5 * row.named_half());
            }
        }
        // In most rounds the sides are hardly wider than the error of the position and the lean make them.
        assert!(n_tight > rounds(20_000), "{n_tight}");
    }
}
