//! Heading fixes: what earlier headings say about the gyroscope's bias and scale, and about the present heading. A heading fix is a heading interval
//! known at one stamp.
//!
//! If the gyroscope carries a heading from one stored pose to the next, it becomes wider at every stamp that lies inside the averaging span of a
//! gyroscope reading, because the reading has to be split there. Carried directly from the stamp of its fix to the present, it becomes wider only
//! once. Therefore all recent fixes are carried directly, and a good view of walls still helps while views are poor.

use std::collections::VecDeque;

use interval::{Interval, contractor::Outcome};

use crate::{
    bounds,
    bounds::Assumption,
    motion::{GyroErrors, GyroHistory, SumSince, sudden_change_rad_per_s2},
    robot::{GyroModel, Reach},
};

/// Name of the declared bound that the gyroscope's bias relies on if it is learnt while the robot stands.
const REST: Assumption = bounds::WHEELS_REST;

/// Age up to which heading fixes and gyroscope readings are kept. Two fixes 900 s apart determine the bias to the sum of their widths divided by
/// 900 s; older fixes would add little, as the bias itself drifts meanwhile.
const KEEP_S: f64 = 900.0;
/// `[max age, window]` of each age class of heading fixes (headings known at single stamps): up to the maximum age, the narrowest fix of every window
/// is kept, and the others are dropped.
const WHILES_S: [[f64; 2]; 3] = [[10.0, 1.0], [60.0, 5.0], [KEEP_S, 30.0]];
/// Time without an encoder tick after which the robot counts as standing: braking wheels may roll on by less than a tick during it.
const SETTLED_S: f64 = 0.5;
/// Period at which the gyroscope's bias is learnt again while the robot stands.
const REST_AGAIN_S: f64 = 1.0;
/// Age up to which a heading fix is carried to the present by the gyroscope. By then the errors of scale and bias have added up, so that older fixes
/// have become wider than newer ones.
const CARRY_S: f64 = 60.0;

/// What is known of the gyroscope's bias and scale, and the heading fixes (headings known at single stamps) from which these are learnt.
pub(super) struct HeadingFixes {
    model: GyroModel,
    /// Greatest change of the robot's turn rate per time.
    change_rad_per_s2: f64,
    /// Greatest angle by which the body turns while the robot stands, if it is declared.
    rest_turn_rad: Option<f64>,
    errors: GyroErrors,
    readings: GyroHistory,
    fixes: VecDeque<Fix>,
    /// Time at which the gyroscope's bias was last learnt at rest.
    rested_s: f64,
}

/// What was known of the gyroscope's errors and of headings at one time.
pub(super) struct KnownFixes {
    errors: GyroErrors,
    fixes: VecDeque<Fix>,
}

/// A heading that is known at a stamp.
#[derive(Clone, Copy, Debug)]
struct Fix {
    stamp_s: f64,
    heading: Interval,
    /// Sum of the gyroscope's readings since the stamp.
    read: SumSince,
}

impl Fix {
    fn new(stamp_s: f64, heading: Interval) -> Fix {
        Fix { stamp_s, heading, read: SumSince::new(stamp_s) }
    }
}

impl HeadingFixes {
    /// Heading fixes for a gyroscope on a robot whose turn rate changes by at most `change_rad_per_s2` and which turns by an angle of at most
    /// `rest_turn_rad` while it stands.
    pub(super) fn new(model: GyroModel, change_rad_per_s2: f64, rest_turn_rad: Option<f64>) -> Self {
        HeadingFixes {
            model,
            change_rad_per_s2,
            rest_turn_rad,
            errors: GyroErrors::new(&model),
            readings: GyroHistory::new(model, KEEP_S),
            fixes: VecDeque::new(),
            rested_s: 0.0,
        }
    }

    /// Forgets all heading fixes, and begins again with the heading at time 0.
    pub(super) fn begin(&mut self, heading: Interval) {
        *self = Self::new(self.model, self.change_rad_per_s2, self.rest_turn_rad);
        self.fixes.push_back(Fix::new(0.0, heading));
    }

    /// The declared bounds that the learnt bias and scale of the gyroscope rely on.
    pub(super) fn relies_on(&self) -> impl Iterator<Item = Assumption> + use<> {
        std::iter::once(self.errors.relies_on()).chain(self.rest_turn_rad.map(|_| REST))
    }

    /// Learns the gyroscope's bias from a time span in which the encoders counted nothing.
    pub(super) fn rest(&mut self, [since_s, now_s]: [f64; 2]) -> Outcome {
        let from_s = since_s + SETTLED_S;
        let Some(turn_rad) = self.rest_turn_rad.filter(|_| now_s >= self.rested_s.max(from_s) + REST_AGAIN_S) else {
            return Outcome::Feasible;
        };
        self.rested_s = now_s;
        let turn = Interval::centred(0.0, turn_rad);
        match self.readings.sum(from_s, now_s, self.change_rad_per_s2) {
            Some(read) => self.errors.learn([from_s, now_s], read, turn),
            None => Outcome::Feasible,
        }
    }

    pub(super) fn read(&mut self, time_s: f64, rate_rad_per_s: f64) {
        self.readings.push(time_s, rate_rad_per_s);
    }

    /// Learns the gyroscope's errors from a heading that is known at a stamp. A heading that contradicts the earlier ones is not kept.
    pub(super) fn learn(&mut self, stamp_s: f64, heading: Interval) -> Outcome {
        for fix in &mut self.fixes {
            let (span_s, turn) = ([fix.stamp_s, stamp_s], heading - fix.heading);
            if let Some(read) = self.readings.sum_since(&mut fix.read, stamp_s, self.change_rad_per_s2)
                && let contradiction @ Outcome::Empty(_) = self.errors.learn(span_s, read, turn)
            {
                return contradiction;
            }
        }
        self.fixes.push_back(Fix::new(stamp_s, heading));
        self.thin_out(stamp_s);
        Outcome::Feasible
    }

    /// Keeps, of all heading fixes (headings known at single stamps), the narrowest one of every time window of each age class.
    fn thin_out(&mut self, now_s: f64) {
        let while_of = |fixed_s: f64| {
            let [_, while_s] = WHILES_S.into_iter().find(|[old_s, _]| now_s - fixed_s <= *old_s)?;
            Some((while_s, (fixed_s / while_s).floor()))
        };
        let mut kept: VecDeque<Fix> = VecDeque::with_capacity(self.fixes.len());
        for fix in self.fixes.iter().filter(|fix| while_of(fix.stamp_s).is_some()) {
            match kept.back_mut().filter(|last| while_of(last.stamp_s) == while_of(fix.stamp_s)) {
                Some(last) if fix.heading.width() < last.heading.width() => *last = *fix,
                Some(_) => {}
                None => kept.push_back(*fix),
            }
        }
        self.fixes = kept;
    }

    /// Heading at a stamp: the intersection of all heading fixes (headings known at earlier stamps) up to [`CARRY_S`] old, each carried to the stamp
    /// by the gyroscope.
    pub(super) fn heading(&self, stamp_s: f64) -> Interval {
        let carried = self.fixes.iter().filter(|fix| (stamp_s - CARRY_S..=stamp_s).contains(&fix.stamp_s));
        carried.fold(Interval::ENTIRE, |heading, fix| match self.turn(fix.stamp_s, stamp_s) {
            Some(turn) => heading.intersect(fix.heading + turn),
            None => heading,
        })
    }

    /// Turn between two stamps by the gyroscope alone, for a robot whose wheels keep their declared bound on acceleration.
    pub(super) fn turn(&self, from_s: f64, to_s: f64) -> Option<Interval> {
        self.turn_at_change(from_s, to_s, self.change_rad_per_s2)
    }

    /// Turn between two stamps by the gyroscope alone, also if the robot is pushed, as long as its motion stays within the physical limits
    /// `reach`.
    pub(super) fn turn_if_pushed(&self, from_s: f64, to_s: f64, reach: &Reach) -> Option<Interval> {
        self.turn_at_change(from_s, to_s, sudden_change_rad_per_s2(reach, self.model.period_s))
    }

    fn turn_at_change(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        let read = self.readings.sum(from_s, to_s, change_rad_per_s2)?;
        Some(self.errors.turn([from_s, to_s], read))
    }

    /// Enclosure of the gyroscope's bias over the last `span_s` before a time.
    pub(super) fn bias_over(&self, span_s: f64, now_s: f64) -> Interval {
        self.errors.bias_over([now_s - span_s, now_s])
    }

    /// Corners of what is known of the gyroscope's bias over the whole run and of its scale.
    pub(super) fn corners(&self) -> Option<Vec<[f64; 2]>> {
        self.errors.corners()
    }

    /// Enclosure of the gyroscope's scale.
    pub(super) fn scale(&self) -> Interval {
        self.errors.scale()
    }

    /// What is known of the gyroscope's errors and of headings now.
    pub(super) fn known(&self) -> KnownFixes {
        KnownFixes { errors: self.errors.clone(), fixes: self.fixes.clone() }
    }

    /// Takes back what was learnt of the gyroscope's errors, and all headings, since the time at which that was known.
    pub(super) fn go_back(&mut self, known: &KnownFixes) {
        self.errors.clone_from(&known.errors);
        self.fixes.clone_from(&known.fixes);
    }

    /// Takes back all that was learnt of the gyroscope's errors, and all headings.
    pub(super) fn forget(&mut self) {
        self.errors = GyroErrors::new(&self.model);
        self.fixes.clear();
    }
}
