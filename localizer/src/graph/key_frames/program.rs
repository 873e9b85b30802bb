//! The linear program of all key frames: the boxes of its quantities, and its rows.

use std::collections::{BTreeMap, BTreeSet};

use interval::{Interval, linear_program::ProgramError};

use crate::{bounds, bounds::Assumption, reading::LandmarkId, robot::GyroModel};

use super::{
    super::{Constant, Domain, Related, Row, Stray, Suspect, Variable, related::Origin},
    FrameReading, KeyFrame, KeyFrames, Place,
};

/// The gyroscope's errors that are constant over a run.
const GYRO_ERRORS: [Variable; 2] = [Variable::Constant(Constant::GyroBias), Variable::Constant(Constant::GyroScale)];

impl KeyFrames {
    /// The linear program of all key frames. `known` are places of landmarks that follow from other readings.
    pub fn related(&self, known: &[(LandmarkId, Place)]) -> Result<Related, ProgramError> {
        let mut domain = self.domain(known);
        let whole_s = [self.frames.front(), self.frames.back()].map(|frame| frame.map_or(0.0, |frame| frame.stamp_s));
        let learnt = Origin { is_learnt: true, ..Origin::over(whole_s) };
        let mut rows: Vec<(Row, Origin)> = self.gyro_rows(&domain).into_iter().map(|row| (row, learnt)).collect();
        let shown = Shown::new(self, &domain);
        let mut before: Option<&KeyFrame> = None;
        for frame in &self.frames {
            if let (Some(before), Some(link)) = (before, &frame.link) {
                let origin = Origin::over([before.stamp_s, frame.stamp_s]);
                let between = link.rows([before.number, frame.number], &domain).into_iter();
                rows.extend(between.chain(self.drift_row(before, frame, &domain)).map(|row| (row, origin)));
            }
            for reading in &frame.readings {
                let void_without = reading.relations.void_without();
                let origin = Origin { void_without, ..Origin::over([frame.stamp_s; 2]) };
                rows.extend(shown.rows(reading).into_iter().map(|row| (row, origin)));
            }
            before = Some(frame);
        }
        // Quantities that no row names are left out.
        let named = rows.iter().flat_map(|(row, _)| &row.terms).map(|&(variable, _)| variable);
        let named: BTreeSet<Variable> = named.collect();
        rows.extend(self.disc_rows(&named, &domain).into_iter().map(|row| (row, Origin::over(whole_s))));
        domain.retain(|variable| named.contains(&variable) || matches!(variable, Variable::Pose(..)));
        let labels = self.frames.iter().filter_map(|frame| Some((frame, frame.label?)));
        let boxes = labels.flat_map(|(frame, label)| {
            (0..3).filter(move |&axis| label.axes[axis]).map(move |axis| (Variable::Pose(frame.number, axis), label))
        });
        let mut related = Related::new(domain, rows, boxes.collect())?;
        for variable in GYRO_ERRORS.into_iter().filter(|_| !self.gyro_errors.is_empty()) {
            // What is known of it now was learnt from earlier headings.
            let made_by = related.made_by.get_mut(&variable).into_iter();
            made_by.for_each(|made_by| made_by.extend(made_by.first().map(|&(_, half)| (Suspect::Earlier, half))));
        }
        for reading in self.readings() {
            for axis in 0..3 {
                if let Some(made_by) = related.made_by.get_mut(&Variable::Shift(reading.number, axis)) {
                    let parts = reading.shift_parts(axis).into_iter();
                    *made_by = parts.map(|(bound, half)| (Suspect::Bound(bound), half)).collect();
                }
            }
        }
        Ok(related)
    }

    /// The boxes of all quantities: of the landmarks, all that are seen from two key frames or more.
    pub(super) fn domain(&self, known: &[(LandmarkId, Place)]) -> Domain {
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
            for reading in &frame.readings {
                let displaced = reading.displaced();
                for axis in (0..3).filter(|&axis| displaced.of_axis(axis) > 0.0) {
                    domain.put(Variable::Shift(reading.number, axis), Interval::centred(0.0, displaced.of_axis(axis)));
                }
            }
            let quantities = frame.readings.iter().flat_map(|one| one.relations.quantities(one.number, &frame.pose));
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

    /// All readings at key frames.
    fn readings(&self) -> impl Iterator<Item = &FrameReading> {
        self.frames.iter().flat_map(|frame| &frame.readings)
    }

    /// Declared bounds with the parts that they make of a quantity's interval.
    fn parts(&self, variable: Variable, domain: &Domain) -> Vec<(Assumption, f64)> {
        match (variable, variable.bound()) {
            (_, Some(bound)) => vec![(bound, domain.value(variable).radius())],
            (Variable::Shift(number, axis), None) => {
                self.readings().find(|one| one.number == number).map_or_else(Vec::new, |one| one.shift_parts(axis))
            }
            _ => Vec::new(),
        }
    }

    /// Rows that cut the corners off the square about each disc of quantities that other rows name: with components a and b of length r at most,
    /// |a ± b| ≤ √2·r.
    fn disc_rows(&self, named: &BTreeSet<Variable>, domain: &Domain) -> Vec<Row> {
        let of_readings = self.readings().flat_map(|reading| {
            let shift = ([0, 1].map(|axis| Variable::Shift(reading.number, axis)), reading.displaced().metres);
            let shift = Some(shift).filter(|&(_, shift_m)| shift_m > 0.0);
            reading.relations.discs(reading.number).into_iter().chain(shift)
        });
        let mut discs: BTreeMap<[Variable; 2], f64> = of_readings.collect();
        discs.extend(self.discs.iter().copied());
        let cut = |([a, b], radius): ([Variable; 2], f64)| {
            let most = (Interval::point(2.0).sqrt() * radius).hi();
            [1.0, -1.0].map(|sign| {
                let at_reference = Interval::point(domain.reference(a)) + Interval::point(domain.reference(b)) * sign;
                let sides = Interval::centred(0.0, most) - at_reference;
                let row = Row::new(domain, &[(a, Interval::ONE), (b, Interval::point(sign))], sides);
                row.with_parts(std::f64::consts::SQRT_2, &self.parts(a, domain))
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

/// The poses that the readings at all key frames show.
struct Shown {
    /// The domain of all quantities, with the poses that the readings show, by the readings' numbers.
    domain: Domain,
    /// The number of each reading's key frame, and how far the pose that it shows may be from that at the key frame.
    displaced: BTreeMap<usize, (usize, Stray)>,
}

impl Shown {
    fn new(frames: &KeyFrames, domain: &Domain) -> Shown {
        let mut shown = Shown { domain: domain.clone(), displaced: BTreeMap::new() };
        for frame in &frames.frames {
            for reading in &frame.readings {
                let displaced = reading.displaced();
                shown.domain.displace(domain, [frame.number, reading.number], &displaced);
                shown.displaced.insert(reading.number, (frame.number, displaced));
            }
        }
        shown
    }

    /// The rows of a reading. They hold for the poses that readings show, which are the sums of the key frames' poses and the displacements.
    fn rows(&self, reading: &FrameReading) -> Vec<Row> {
        let mut rows = reading.relations.rows(reading.number, &self.domain);
        for row in &mut rows {
            let mut shifts = Vec::new();
            for (variable, coefficient) in &mut row.terms {
                if let Variable::Pose(number, axis) = *variable
                    && let Some((frame, displaced)) = self.displaced.get(&number)
                {
                    if displaced.of_axis(axis) > 0.0 && *coefficient != 0.0 {
                        shifts.push((Variable::Shift(number, axis), *coefficient));
                    }
                    *variable = Variable::Pose(*frame, axis);
                }
            }
            row.terms.append(&mut shifts);
        }
        rows
    }
}

impl FrameReading {
    /// Declared bounds with the parts that they make of the displacement along an axis of the pose that the reading shows.
    fn shift_parts(&self, axis: usize) -> Vec<(Assumption, f64)> {
        match axis {
            2 => [self.relations.stamp_bound(), bounds::REACH_TURN_RATE].map(|one| (one, self.stray.radians)).to_vec(),
            _ => self.relations.shift_parts(&self.stray),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
