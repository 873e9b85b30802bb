//! What the readings between two key frames tell of the way from one to the other.
//!
//! **Dropping a key frame.** The rows of the ways before and after it are added, so that its position cancels. Its heading is left with some
//! coefficient γ; multiples of the gyroscope's rows of both ways are added so that it cancels, too, and with it the gyroscope's bias as far as the
//! time is shared: θ_b is then, but for the gyroscope's error, between θ_a and θ_c in proportion to the time. Whatever is left of the dropped key
//! frame is enclosed over its box. A sum of rows is a row, so that nothing is assumed by any of this; only width is lost.

use crate::motion::{FlowWay, Way};

use super::{
    Domain, Row, Variable, flow_rows,
    way::{displacement_rows, gyro_rows, way_rows},
};

/// The way from one key frame to the next.
#[derive(Clone, Debug)]
pub(super) enum Link {
    /// By the readings between the two.
    Read(Read),
    /// By the rows of several ways, of which the key frames between were dropped.
    Joined(Joined),
}

/// The way between two key frames by the readings between them.
#[derive(Clone, Debug)]
pub(super) struct Read {
    /// By the wheels and the gyroscope; `None` where the wheels are not to be believed.
    pub(super) way: Option<Way>,
    /// By the flow sensor and the gyroscope; `None` where the flow sensor saw nothing.
    pub(super) flow: Option<FlowWay>,
    /// Whether the flow sensor's place at the first key frame has the same error as in the way before.
    pub(super) shares_error: bool,
    /// Share by which the flow sensor's scale varies.
    pub(super) scale_change: f64,
}

/// Rows of a way whose values, not deviations, are within their sides, so that they hold whatever the reference values.
#[derive(Clone, Debug)]
pub(super) struct Joined {
    span_s: f64,
    /// Rows of the displacement along world x and y by the flow sensor, and by the wheels.
    displacements: [Option<[Row; 2]>; 2],
    turn: Option<Row>,
}

impl Link {
    /// The rows between two key frames.
    pub(super) fn rows(&self, frames: [usize; 2], domain: &Domain) -> Vec<Row> {
        match self {
            Link::Read(read) => {
                let mut rows: Vec<Row> = read.flow_rows(frames, domain).into_iter().flatten().collect();
                match (&read.way, &read.flow) {
                    (Some(way), _) => rows.extend(way_rows(way, frames[0], frames[1], domain)),
                    (None, Some(flow)) => rows.extend(gyro_rows(&flow.gyro, flow.span_s, frames, domain)),
                    (None, None) => {}
                }
                rows
            }
            Link::Joined(joined) => {
                let displacements = joined.displacements.iter().flatten().flatten();
                displacements.chain(&joined.turn).map(|row| row.about(domain)).collect()
            }
        }
    }

    /// Whether the link tells the way by the flow sensor, and whether by the wheels.
    pub(super) fn tells(&self) -> [bool; 2] {
        match self {
            Link::Read(read) => [read.flow.is_some(), read.way.is_some()],
            Link::Joined(joined) => [0, 1].map(|source| joined.displacements[source].is_some()),
        }
    }

    /// The way by the readings between the key frames.
    pub(super) fn read(&self) -> Option<&Read> {
        match self {
            Link::Read(read) => Some(read),
            Link::Joined(_) => None,
        }
    }

    /// The way over this link and the next one, without the key frame between them. `None` where one of them tells nothing of the displacement.
    pub(super) fn join(&self, next: &Link, [first, middle, last]: [usize; 3], domain: &Domain) -> Option<Link> {
        let before = self.in_values([first, middle], domain);
        let after = next.in_values([middle, last], domain);
        let dropped = |variable: Variable| variable.frame() == Some(middle);
        let [turn_before, turn_after] = [before.turn.as_ref()?, after.turn.as_ref()?];
        let total_s = before.span_s + after.span_s;
        let heading = Variable::Pose(middle, 2);
        let join = |a: &Row, b: &Row| {
            let left = a.coefficient(heading) + b.coefficient(heading);
            // Shares of the gyroscope's rows that cancel the heading, and between them the bias. A heading that is known exactly is in no row.
            let share = |turn: &Row, other_s: f64| match turn.coefficient(heading) {
                0.0 => 0.0,
                coefficient => -left * (other_s / total_s) / coefficient,
            };
            let (by_before, by_after) = (share(turn_before, after.span_s), share(turn_after, before.span_s));
            Row::sum(&[(1.0, a), (1.0, b), (by_before, turn_before), (by_after, turn_after)], dropped, domain)
        };
        let has = |source: usize| before.displacements[source].is_some() || after.displacements[source].is_some();
        let displacements = [0, 1].map(|source| {
            let either = |joined: &Joined| {
                joined.displacements[source].clone().or_else(|| joined.displacements[1 - source].clone())
            };
            let (a, b) = (either(&before)?, either(&after)?);
            has(source).then(|| [0, 1].map(|axis| join(&a[axis], &b[axis])))
        });
        let turn = Row::sum(&[(1.0, turn_before), (1.0, turn_after)], dropped, domain);
        displacements.iter().any(Option::is_some).then_some(Link::Joined(Joined {
            span_s: total_s,
            displacements,
            turn: Some(turn),
        }))
    }

    fn in_values(&self, frames: [usize; 2], domain: &Domain) -> Joined {
        match self {
            Link::Joined(joined) => joined.clone(),
            Link::Read(read) => read.in_values(frames, domain),
        }
    }
}

impl Read {
    /// Length of time of the way.
    pub(super) fn span_s(&self) -> Option<f64> {
        self.way.as_ref().map(|way| way.span_s).or_else(|| self.flow.as_ref().map(|flow| flow.span_s))
    }

    fn flow_rows(&self, frames: [usize; 2], domain: &Domain) -> Option<[Row; 2]> {
        Some(flow_rows(self.flow.as_ref()?, frames, self.shares_error, self.scale_change, domain))
    }

    fn in_values(&self, frames: [usize; 2], domain: &Domain) -> Joined {
        let mut joined = Joined { span_s: 0.0, displacements: [None, None], turn: None };
        if let Some(flow) = &self.flow {
            joined.span_s = flow.span_s;
            joined.displacements[0] = self.flow_rows(frames, domain).map(|rows| rows.map(|row| row.in_values(domain)));
        }
        if let Some(way) = &self.way {
            joined.span_s = way.span_s;
            joined.displacements[1] = Some(displacement_rows(way, frames, domain));
        }
        let read = self.way.as_ref().and_then(|way| way.gyro).or(self.flow.as_ref().map(|flow| flow.gyro));
        let turn = read.and_then(|read| gyro_rows(&read, joined.span_s, frames, domain).pop());
        joined.turn = turn.map(|row| row.in_values(domain));
        joined
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeMap;

    use interval::Interval;

    use super::*;
    use crate::graph::trial::{DOMAINS_OF_A_WAY, Draw, Drive, domains, flow, reach, rounds, wheels};
    use crate::{bounds, motion::WheelHistory};

    #[test]
    fn the_true_way_satisfies_the_rows_of_two_ways_joined() {
        let mut draw = Draw::new(20_261_126);
        for round in 0..rounds(900) {
            let drive = Drive::short(&mut draw, round % 2 == 0);
            let history = drive.history(true);
            let mut links = Vec::new();
            for nth in 0..domains() {
                let (mut domain, truth) = drive.domain(&mut draw);
                if nth % DOMAINS_OF_A_WAY == 0 {
                    // By both, by the flow sensor alone, or by one in the first way and by the other in the second one.
                    let by_wheels_by_flow =
                        [[(true, true); 2], [(false, true); 2], [(true, false), (false, true)]][round % 3];
                    links = both_links(&drive, &history, &domain, by_wheels_by_flow);
                }
                assert_satisfied(&links, if round % 3 == 1 { 3 } else { 5 }, &mut domain, &truth);
            }
        }
    }

    /// The links between the three key frames of a drive: for each whether it is by wheels, and whether by the flow sensor.
    fn both_links(
        drive: &Drive,
        history: &WheelHistory,
        domain: &Domain,
        by_wheels_by_flow: [(bool, bool); 2],
    ) -> Vec<Link> {
        let link = |at: usize| {
            let [from_s, to_s] = [drive.stamps_s[at], drive.stamps_s[at + 1]];
            let heading = domain.value(Variable::Pose(at, 2));
            let (has_way, has_flow) = by_wheels_by_flow[at];
            Link::Read(Read {
                way: history.way(from_s, to_s, &wheels(), &reach()).filter(|_| has_way),
                flow: history.flow_way(from_s, to_s, heading, &wheels(), &reach()).filter(|_| has_flow),
                shares_error: true,
                scale_change: flow().scale_change,
            })
        };
        vec![link(0), link(1)]
    }

    /// Checks that the true values satisfy the rows of both links joined, with some errors of the flow sensor's place.
    fn assert_satisfied(links: &[Link], n_rows: usize, domain: &mut Domain, truth: &BTreeMap<Variable, f64>) {
        let error = Interval::centred(0.0, 2e-3);
        for frame in 0..3 {
            (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), error));
        }
        let scale_m =
            |link: &Link| link.read().and_then(|read| read.flow.as_ref()).map_or(0.0, |flow| flow.scale_error_m[0]);
        let scales_m = scale_m(&links[0]) + scale_m(&links[1]);
        let joined = links[0].join(&links[1], [0, 1, 2], domain).unwrap();
        let rows = joined.rows([0, 2], domain);
        assert_eq!(rows.len(), n_rows);
        // Along x the parts of a varying scale of both ways add up.
        let part = rows[0].parts.iter().find(|(bound, _)| *bound == bounds::FLOW_SCALE).map_or(0.0, |part| part.1);
        assert!((part - scales_m).abs() < 1e-12, "{part} of {scales_m}");
        for (idx, row) in rows.iter().enumerate() {
            assert!(row.named_half() <= row.sides.radius() * (1.0 + 1e-9), "{row:?}");
            assert!(row.terms.iter().all(|&(variable, _)| variable.frame() != Some(1)), "{row:?}");
            let mut sides = row.sides.inflate(1e-7);
            let value = row.value_at(|variable| match variable {
                Variable::FlowPlace(..) => 0.0,
                _ => truth[&variable] - domain.reference(variable),
            });
            for &(variable, coefficient) in &row.terms {
                if let Variable::FlowPlace(..) = variable {
                    sides -= error * coefficient;
                }
            }
            assert!(sides.contains(value), "row {idx}: {value}, {sides}");
        }
    }
}
