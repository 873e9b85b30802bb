//! Names for contradictions: once readings contradict each other, the declared bounds and the readings of which not all can be true.
//!
//! A contradiction is found as soon as an intersection is empty, when it is still small and many bounds might explain it. So the localizer waits a
//! little, in which the contradiction mostly grows. Then it makes a linear program of the time around it, with the readings' own boxes of the pose and
//! the ways between them, and searches it for a small set of bounds ([`ConflictSearch`]). The work is spread over the wheel readings. It explains
//! only: no estimate depends on it.

use std::fmt;

use interval::{Interval, IntervalBox};

use crate::{
    PoseBox, PoseUnion, bounds,
    bounds::Assumption,
    graph::{BoxLabel, ConflictSearch, FrameReading, KeyFrames, Readings, Related, Stray},
    motion::moved_union,
};

use super::{Localizer, moves::motion_between, ring::Slot};

/// Time before a contradiction from which on readings are searched for its cause: as long as a doubt reaches back.
const BEFORE_S: f64 = 1.0;
/// Number of wheel readings after a contradiction that are awaited: with one every 10 ms, half a second, in which a push or a slip mostly ends.
const AWAITED: usize = 50;
/// Least time between two poses of the programs that are tried, one after the other, until one of them shows a contradiction. Many short ways tell
/// what each image says. Slip's constant part and quantisation count for each way, so that one long way tells most of a motion that lasts.
const APART_S: [f64; 2] = [0.25, f64::INFINITY];
/// Distance and angle from the predicted pose within which a reading's own box of the pose is sought. A robot that is pushed farther is not followed
/// on floor tiles, which repeat every 0.3 m; and what is not linear in the program grows with the square of the angle.
const SOUGHT: [f64; 3] = [0.3, 0.3, 0.15];
/// Share of a box's width up to which a box by a reading counts as narrower along an axis.
const NARROWER: f64 = 0.99;
/// Greatest number of bounds that are named where the relations alone do not show the contradiction.
const MOST_NAMED: usize = 3;
/// Beginnings of the names of bounds on the robot's motion and posture, which most readings rely on beside their own.
const OF_MOTION: [&str; 4] = ["wheels.", "reach.", "body.", "base."];

/// Declared bounds of which not all can be true, and the readings that show it.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Time at which the contradiction was found.
    pub found_s: f64,
    /// The bounds, the most doubtful first. At least one of them is broken, or another one by more than `factor`.
    pub bounds: Vec<Assumption>,
    /// Whether, in place of these bounds, what was known before the readings can be false: where the robot and landmarks were, and what was learnt of
    /// the gyroscope. Then a bound was broken earlier.
    pub is_earlier: bool,
    /// The readings that contradict each other under these bounds.
    pub readings: Vec<Readings>,
    /// How many times its declared value another bound would have to be if those named were kept. `None` where the named bounds are only the most
    /// doubtful ones of what was intersected.
    pub factor: Option<f64>,
}

impl Contradiction {
    /// Adds a time to all stamps, as of a drive that began later.
    pub fn begin_later(&mut self, by_s: f64) {
        self.found_s += by_s;
        self.readings.iter_mut().flat_map(|readings| &mut readings.span_s).for_each(|stamp_s| *stamp_s += by_s);
    }
}

impl fmt::Display for Contradiction {
    /// One sentence that says what cannot be true.
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bounds = self.bounds.join(", ");
        match (self.factor, self.is_earlier, self.bounds.is_empty()) {
            (Some(factor), false, _) => {
                write!(to, "of {bounds} one is broken, or another bound more than {factor:.1} times exceeded")?
            }
            (Some(factor), true, false) => write!(
                to,
                "of {bounds} one is broken, or what was known before was false, or another bound more than {factor:.1} times exceeded"
            )?,
            (Some(factor), true, true) => {
                write!(to, "what was known before was false, or a bound more than {factor:.1} times exceeded")?
            }
            (None, ..) => write!(to, "an assumption is false, most likely one of {bounds}")?,
        }
        for (index, Readings { device, span_s: [from_s, to_s] }) in self.readings.iter().enumerate() {
            to.write_str(if index == 0 { ", by the readings of " } else { ", " })?;
            match from_s < to_s {
                true => write!(to, "{device} from {from_s:.3} s to {to_s:.3} s")?,
                false => write!(to, "{device} at {from_s:.3} s")?,
            }
        }
        Ok(())
    }
}

/// What was intersected when a contradiction was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Intersected {
    /// The prediction with the constraint at a stamp.
    Constraint(f64),
    /// The motion by the wheels with that by the flow sensor.
    WheelsAndFlow,
    /// Anything else that was known with the motion.
    Known,
}

/// The work on the latest contradiction's names.
#[derive(Default)]
pub(super) struct Naming {
    pending: Option<Pending>,
    /// The latest contradiction with names.
    pub(super) latest: Option<Contradiction>,
}

/// A contradiction that has no names yet.
struct Pending {
    found_s: f64,
    intersected: Intersected,
    /// The declared bounds that the estimate relied on.
    relies_on: Vec<Assumption>,
    /// Number of wheel readings since it was found.
    n_steps: usize,
    /// Stamp and box of the pose from which on the cause is sought.
    from: Option<(f64, PoseBox)>,
    search: Option<ConflictSearch>,
    /// Number of programs that were tried before.
    n_tried: usize,
}

impl Localizer {
    /// Notes that a contradiction was found, before anything of what was believed is changed. While the names of an earlier one are sought, it counts
    /// as the same.
    pub(super) fn note_contradiction(&mut self, intersected: Intersected, related: Option<Related>) {
        if self.naming.pending.is_some() {
            return;
        }
        let from = self.ring.before(self.now_s - BEFORE_S).or_else(|| self.ring.first());
        let from = from.map(|slot| (slot.stamp_s, slot.merged().hull())).filter(|(_, pose)| !pose.is_empty());
        let search = related.map(ConflictSearch::new);
        let (found_s, relies_on) = (self.now_s, self.relies_on.clone());
        self.naming.pending = Some(Pending { found_s, intersected, relies_on, n_steps: 0, from, search, n_tried: 0 });
    }

    /// Goes on with the work on the names of a contradiction: a fixed part of it at each wheel reading.
    pub(super) fn work_on_names(&mut self) {
        let Some(mut pending) = self.naming.pending.take() else { return };
        pending.n_steps += 1;
        if let Some(search) = &mut pending.search {
            if search.advance() {
                if let Some(conflict) = search.found().cloned() {
                    self.naming.latest = Some(Contradiction {
                        found_s: pending.found_s,
                        bounds: conflict.bounds,
                        is_earlier: conflict.is_earlier,
                        readings: conflict.readings,
                        factor: conflict.factor,
                    });
                    return;
                }
                pending.search = None;
            }
        } else if pending.n_steps >= AWAITED {
            let Some((from, &apart_s)) = pending.from.zip(APART_S.get(pending.n_tried)) else {
                self.naming.latest = Some(most_doubtful(&pending, self.ring.at(pending.stamp_s())));
                return;
            };
            pending.n_tried += 1;
            pending.search = self.around(from, pending.intersected, apart_s).map(ConflictSearch::new);
        }
        self.naming.pending = Some(pending);
    }

    /// The program of the time since a known pose: the poses at constraints' stamps, in the boxes that the constraints alone allow, and the ways
    /// between them.
    fn around(&self, (from_s, from): (f64, PoseBox), intersected: Intersected, apart_s: f64) -> Option<Related> {
        let mut frames = KeyFrames::new(&self.robot);
        frames.know_gyro(self.fixes.as_ref().and_then(|fixes| fixes.corners()).unwrap_or_default());
        frames.push_beside(from_s, from, None);
        let (mut before_s, mut believed) = (from_s, from);
        for index in 0..self.ring.len() {
            let slot = &self.ring[index];
            let is_asked = intersected == Intersected::Constraint(slot.stamp_s);
            let is_apart = slot.stamp_s >= before_s + if is_asked { 0.0 } else { apart_s };
            if slot.constraint.is_none() || slot.stamp_s <= before_s || !is_apart {
                continue;
            }
            believed = self.add_pose(&mut frames, before_s, &believed, slot.stamp_s, Some(slot));
            before_s = slot.stamp_s;
        }
        if self.now_s > before_s {
            self.add_pose(&mut frames, before_s, &believed, self.now_s, None);
        }
        let known = self.landmarks();
        frames.related(&known).ok()
    }

    /// Adds the pose at a stamp after another pose. Returns its box by the constraint or, where that is too wide or missing, by the motion.
    fn add_pose(
        &self,
        frames: &mut KeyFrames,
        before_s: f64,
        before: &PoseBox,
        stamp_s: f64,
        slot: Option<&Slot>,
    ) -> PoseBox {
        let (wheels, robot) = (&self.wheels, &self.robot);
        let motion =
            motion_between(wheels, robot, &self.slip, false, [before_s, stamp_s]).filter(|one| !one.is_empty());
        let motion = motion.unwrap_or_else(|| wheels.reach_motion(before_s, stamp_s, &robot.reach));
        let predicted = moved_union(&PoseUnion::single(*before), &motion).hull();
        let sought = IntervalBox::from([0, 1, 2].map(|axis| predicted[axis].inflate(SOUGHT[axis])));
        let constraint = slot.and_then(|slot| slot.constraint.as_ref());
        // What a reading of things that no map has relates is in its rows; the box that it allows would tell the same again. Of things on the map the
        // box tells it, under the one bound that is most doubtful.
        let relations = constraint.and_then(|constraint| constraint.relations.clone());
        let relations = relations.filter(|relations| !relations.is_of_the_map());
        let alone = constraint.filter(|_| relations.is_none()).and_then(|constraint| {
            let middle = predicted.midpoint();
            let away = |branch: &PoseBox| {
                (0..3).map(|axis| distance(branch[axis], middle[axis]) / SOUGHT[axis]).fold(0.0, f64::max)
            };
            let union = PoseUnion::single(sought).contracted(constraint.on_pose.as_ref());
            union.branches.into_iter().filter(|one| !one.is_empty()).min_by(|a, b| away(a).total_cmp(&away(b)))
        });
        let source = constraint.map_or("", |constraint| constraint.method);
        let reading = relations.map(|relations| {
            let stray = Stray::by_reach(relations.stamp_error_s(), &robot.reach);
            FrameReading::new(source, relations, stray)
        });
        frames.push_beside(stamp_s, alone.unwrap_or(sought), reading);
        let narrower = alone.map(|alone| [0, 1, 2].map(|axis| is_narrower(alone[axis], sought[axis])));
        frames.label_latest(narrower.zip(slot.and_then(Slot::label)).map(|(axes, label)| BoxLabel {
            axes,
            is_alone: true,
            ..label
        }));
        let way = wheels.way(before_s, stamp_s, &robot.wheels, &robot.reach);
        let flow = wheels.flow_way(before_s, stamp_s, before[2], &robot.wheels, &robot.reach);
        frames.link(frames.latest_number(), way, flow, &[]);
        let both = alone.map(|alone| alone.intersect(&predicted));
        both.filter(|both| !both.is_empty()).or(alone).unwrap_or(predicted)
    }
}

impl Pending {
    /// Stamp of the constraint that left no pose; not a number where there is none.
    fn stamp_s(&self) -> f64 {
        match self.intersected {
            Intersected::Constraint(stamp_s) => stamp_s,
            Intersected::WheelsAndFlow | Intersected::Known => f64::NAN,
        }
    }
}

/// The most doubtful bounds of what was intersected, where relations do not show the contradiction. `slot` is that of the constraint, if it was one.
fn most_doubtful(pending: &Pending, slot: Option<&Slot>) -> Contradiction {
    let of_reading = slot.and_then(|slot| slot.constraint.as_ref()).map_or(&[][..], |one| &one.relies_on);
    let bounds = named(&pending.relies_on, of_reading);
    let readings = slot.and_then(Slot::reading).into_iter().collect();
    Contradiction { found_s: pending.found_s, bounds, is_earlier: false, readings, factor: None }
}

/// The most doubtful of the bounds that the estimate and the contradicting reading rely on. One of the reading's own is always named, if it has any:
/// the motion relies on bounds so doubtful that they would hide all others.
fn named(of_estimate: &[Assumption], of_reading: &[Assumption]) -> Vec<Assumption> {
    let mut bounds = [of_estimate, of_reading].concat();
    bounds.sort_by_key(|bound| (bounds::doubtfulness(bound), *bound));
    bounds.dedup();
    bounds.truncate(MOST_NAMED);
    let is_of_motion = |bound: &Assumption| OF_MOTION.iter().any(|kind| bound.starts_with(kind));
    let own = of_reading.iter().filter(|bound| !is_of_motion(bound)).min_by_key(|bound| bounds::doubtfulness(bound));
    if let Some(own) = own.filter(|own| !bounds.contains(own)) {
        bounds.truncate(MOST_NAMED - 1);
        bounds.push(own);
    }
    bounds
}

impl Slot {
    /// The reading that the slot's constraint is made of.
    fn reading(&self) -> Option<Readings> {
        let span_s = [self.stamp_s; 2];
        self.constraint.is_some().then_some(Readings { device: self.device, span_s })
    }

    /// The reading with the most doubtful bound that its constraint relies on.
    pub(super) fn label(&self) -> Option<BoxLabel> {
        let relies_on = &self.constraint.as_ref()?.relies_on;
        let bound = *relies_on.iter().min_by_key(|bound| bounds::doubtfulness(bound))?;
        Some(BoxLabel { bound, is_alone: false, reading: self.reading()?, axes: self.narrows })
    }
}

/// Whether an interval is narrower than another by more than rounding and the like make.
pub(super) fn is_narrower(one: Interval, other: Interval) -> bool {
    one.width() < NARROWER * other.width()
}

/// Distance of a number from an interval.
fn distance(interval: Interval, from: f64) -> f64 {
    (interval.lo() - from).max(from - interval.hi()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_of_the_contradicting_reading_itself_is_always_named() {
        let of_motion = [bounds::REACH_ACCELERATION, bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, bounds::BODY_TILT];
        // A bound of the table, and one that only a user's own method knows.
        for own in [bounds::SCANNER_RANGE, "beacon.range"] {
            let named = named(&of_motion, &[own, "beacon.stamp", bounds::BODY_TILT, bounds::REACH_SPEED]);
            assert_eq!(named, [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, own]);
        }
        // A placed marker is as doubtful as slip, and is named anyway; a reading of the motion has no bound of its own.
        let by_marker = named(&of_motion, &[bounds::MARKERS_PLACEMENT]);
        assert_eq!(by_marker, [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, bounds::MARKERS_PLACEMENT]);
        let by_motion = named(&of_motion, &[bounds::WHEELS_REST]);
        assert_eq!(by_motion, [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, bounds::REACH_ACCELERATION]);
    }

    #[test]
    fn a_factor_is_said_with_one_decimal() {
        let found = Contradiction {
            found_s: 1.0,
            bounds: vec![bounds::WHEELS_SLIP],
            is_earlier: false,
            readings: Vec::new(),
            factor: Some(300.0_f64.sqrt()),
        };
        assert_eq!(found.to_string(), "of wheels.slip one is broken, or another bound more than 17.3 times exceeded");
    }
}
