//! What makes the width of a bound: how much of it comes from which declared bound.
//!
//! The certificate of a bound adds up one term for each row and one for each box ([`interval::linear_program::shares`]). Each term is a multiple of
//! the half width of an interval, and that half width is divided among the declared bounds that make it. So one sees what to calibrate next: a
//! declared bound that is reduced by a small share reduces the width by that share of its part.

use std::collections::BTreeMap;

use interval::linear_program::Shares;

use crate::bounds::Assumption;

use super::{Related, Suspect, Variable};

/// What makes the width of a quantity's interval, in the quantity's unit. The parts less `saved` add up to the width.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WidthParts {
    /// The part that each declared bound makes.
    pub by_bound: BTreeMap<Assumption, f64>,
    /// The part of boxes of poses and landmarks, which come from many bounds.
    pub by_boxes: f64,
    /// The part of what has no name: quantisation, and what is lost by linearisation.
    pub rest: f64,
    /// What is saved because the least value follows from other readings than the greatest.
    pub saved: f64,
}

impl WidthParts {
    /// The parts of the width between two bounds, by the shares of the certificate of the least value of x and of that of the least value of −x.
    pub(super) fn new(related: &Related, sides: [&Shares; 2]) -> WidthParts {
        let mut parts = WidthParts { saved: sides[0].middle + sides[1].middle, ..WidthParts::default() };
        for side in sides {
            for (row, &share) in side.rows.iter().enumerate() {
                let half = related.program.sides(row).radius();
                let per_half = if share > 0.0 && half > 0.0 { share / half } else { continue };
                let named: f64 = related.rows[row].parts.iter().map(|(_, part)| part).sum();
                // Parts are estimates, which may exceed the whole by rounding.
                let scale = if named > half { half / named } else { 1.0 };
                for &(bound, part) in &related.rows[row].parts {
                    *parts.by_bound.entry(bound).or_default() += part * scale * per_half;
                }
                parts.rest += (half - named * scale) * per_half;
            }
            for (&variable, &share) in related.variables.iter().zip(&side.variables) {
                let makers = related.made_by.get(&variable).map_or(&[][..], Vec::as_slice);
                // Parts may overlap, so that they are taken for their shares of their sum.
                let whole: f64 = makers.iter().map(|(_, half)| half).sum();
                let named = makers.iter().filter_map(|&(suspect, half)| match suspect {
                    Suspect::Bound(bound) if whole > 0.0 => Some((bound, half / whole)),
                    _ => None,
                });
                // What a pose's box follows from are many bounds.
                let named: Vec<(Assumption, f64)> = named.filter(|_| !matches!(variable, Variable::Pose(..))).collect();
                named.iter().for_each(|&(bound, of)| *parts.by_bound.entry(bound).or_default() += of * share);
                parts.by_boxes += if named.is_empty() { share } else { 0.0 };
            }
        }
        parts.by_bound.retain(|_, part| *part > 0.0);
        parts
    }

    /// The declared bound that makes most of the width, with its part.
    pub fn greatest(&self) -> Option<(Assumption, f64)> {
        self.by_bound.iter().map(|(&bound, &part)| (bound, part)).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The whole width.
    pub fn width(&self) -> f64 {
        self.by_bound.values().sum::<f64>() + self.by_boxes + self.rest - self.saved
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::{Interval, IntervalBox};

    use super::*;
    use crate::{
        bounds,
        graph::{
            Constant, Domain, Hull, KeyFrames, Row, Unlinked, Variable,
            related::Origin,
            trial::{Draw, Drive, reach, robot, wheels},
        },
    };

    #[test]
    fn the_width_of_a_bound_is_divided_among_what_makes_it() {
        // x − 2·m is 0 ± 0.3, of which slip makes 0.2, and m is known to ± 0.05: x is known to ± 0.4.
        let (x, metres) = (Variable::Pose(0, 0), Variable::Constant(Constant::FlowMetresPerCount));
        let mut domain = Domain::default();
        domain.put(x, Interval::new(-1.0, 1.0));
        domain.put(metres, Interval::centred(1.0, 0.05));
        let sides = Interval::centred(0.0, 0.3);
        let row = Row { terms: vec![(x, 1.0), (metres, -2.0)], sides, parts: Vec::new(), devices: Vec::new() };
        let rows = vec![(row.with_part(bounds::WHEELS_SLIP, 0.2), Origin::over([0.0, 1.0]))];
        let mut hull = Hull::new(Related::new(domain, rows, BTreeMap::new()).unwrap(), vec![x]);
        while !hull.advance() {}
        // The solver stops at a thousandth of half the width of the box before, at either end.
        const GAP_M: f64 = 2e-3;
        let parts = &hull.width_parts()[0];
        let expected = [(bounds::FLOW_CALIBRATION, 0.2), (bounds::WHEELS_SLIP, 0.4)];
        for ((bound, part), (name, makes)) in parts.by_bound.iter().zip(expected) {
            assert!(*bound == name && (part - makes).abs() < GAP_M, "{parts:?}");
        }
        assert_eq!(parts.greatest().unwrap().0, bounds::WHEELS_SLIP);
        assert!((parts.rest - 0.2).abs() < GAP_M && parts.by_boxes < GAP_M && parts.saved.abs() < GAP_M, "{parts:?}");
        assert!((parts.width() - 0.8).abs() < GAP_M, "{parts:?}");
    }

    #[test]
    fn the_parts_of_a_drive_add_up_to_the_width_of_its_box() {
        let mut draw = Draw::new(20_261_124);
        let drive = Drive::new(&mut draw, true, 60.0, 30);
        let history = drive.history(true);
        let mut frames = KeyFrames::new(&robot());
        for (at, (&stamp_s, truth)) in drive.stamps_s.iter().zip(&drive.poses).enumerate() {
            let half_m = if at == 0 { 0.001 } else { 2.0 };
            let pose = [(0, half_m), (1, half_m), (2, 0.02)].map(|(axis, half)| Interval::centred(truth[axis], half));
            frames.push(stamp_s, IntervalBox::from(pose), None);
            let Unlinked { number, stamp_s: to_s, before, .. } = frames.unlinked().unwrap();
            let (way, flow) = before.map_or((None, None), |(from_s, heading)| {
                let flow = history.flow_way(from_s, to_s, heading, &wheels(), &reach());
                (history.way(from_s, to_s, &wheels(), &reach()), flow)
            });
            frames.link(number, way, flow, &[]);
        }
        let number = frames.latest_number();
        let mut hull =
            Hull::new(frames.related(&[]).unwrap(), (0..3).map(|axis| Variable::Pose(number, axis)).collect());
        while !hull.advance() {}
        for (axis, (parts, bound)) in hull.width_parts().iter().zip(hull.bounds().unwrap()).enumerate() {
            assert!((parts.width() - bound.width()).abs() < 1e-6, "axis {axis}: {parts:?} of {bound}");
            assert!(parts.by_bound.values().all(|part| *part >= 0.0) && parts.rest >= 0.0, "axis {axis}: {parts:?}");
        }
        // Along x and y the flow sensor tells most, whose scale varies by 0.4 %, far more than its quantisation adds.
        let flow = hull.width_parts()[0].by_bound[bounds::FLOW_SCALE];
        assert!(flow > 0.2 * hull.width_parts()[0].width(), "{flow}: {:?}", hull.width_parts()[0]);
    }
}
