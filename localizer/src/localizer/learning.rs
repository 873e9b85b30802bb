//! Learning of the gyroscope's bias and scale, at rest and from heading fixes, and what both give for the present heading.

use interval::{Interval, contractor::Outcome};

use crate::{Constraint, Localizer, PoseUnion, motion::greatest_change_rad_per_s2};

use super::{after_turn::AfterTurn, heading_fixes::HeadingFixes, moves::memory_s};

#[cfg(test)]
mod tests;

impl Localizer {
    /// The same localizer, set to learn the gyroscope's bias and scale between heading fixes (headings known at single stamps). If `rest_turn_rad` is
    /// given, it also learns the bias while the robot stands, as the body is then declared to turn by at most that angle.
    pub fn learning_gyro(mut self, rest_turn_rad: Option<f64>) -> Self {
        let change_rad_per_s2 = greatest_change_rad_per_s2(&self.robot.wheels, &self.robot.reach);
        self.fixes = self.robot.gyro.map(|model| HeadingFixes::new(model, change_rad_per_s2, rest_turn_rad));
        self.begin_fixes();
        self.begin_knowledge();
        self
    }

    /// Begins learning with the heading at the start as the first heading fix.
    pub(super) fn begin_fixes(&mut self) {
        if let Some(fixes) = &mut self.fixes {
            let known = self.relies_on.clone();
            self.relies_on.extend(fixes.relies_on().filter(|assumption| !known.contains(assumption)));
            fixes.begin(self.current.hull()[2]);
        }
    }

    /// Learns the gyroscope's bias while the wheel encoders count no tick.
    pub(super) fn learn_at_rest(&mut self, time_s: f64, ticks: [i64; 2]) {
        let (since_s, _) = *self.at_rest.take_if(|(_, before)| *before == ticks).get_or_insert((time_s, ticks));
        self.at_rest = Some((since_s, ticks));
        let is_doubted = self.is_doubted();
        if let Some(fixes) = self.fixes.as_mut().filter(|_| !is_doubted)
            && let Outcome::Empty(_) = fixes.rest([since_s, time_s])
        {
            self.begin_doubt(None);
        }
        self.tell_wheels_of_gyro();
    }

    /// Moves a constraint on the heading to the stamp of the wheel reading before it, by the gyroscope's turn in the few milliseconds between. A pose
    /// that is stored at any other stamp would split the span between two wheel readings, which would make the predicted motion wider.
    pub(super) fn on_a_reading(&self, constraint: Constraint) -> Constraint {
        let at_s = self.wheels.reading_before(constraint.stamp_s);
        let turn = at_s
            .and_then(|at_s| self.wheels.gyro_turn(at_s, constraint.stamp_s, &self.robot.wheels, &self.robot.reach));
        match at_s.zip(turn) {
            Some((stamp_s, turn)) => {
                let after = |on_pose| Box::new(AfterTurn { turn, on_pose }) as Box<_>;
                let by_itself = constraint.by_itself.map(after);
                Constraint { stamp_s, on_pose: after(constraint.on_pose), by_itself, ..constraint }
            }
            None => constraint,
        }
    }

    /// Learns the gyroscope's bias from a new heading fix (a heading known at one stamp), unless an assumption is doubted. Returns whether the fix
    /// agrees with what was known; if not, an assumption has failed.
    pub(super) fn learn_heading(&mut self, stamp_s: f64, heading: Interval) -> bool {
        let is_doubted = self.is_doubted();
        let Some(fixes) = &mut self.fixes else { return true };
        let agrees = is_doubted || heading.is_empty() || fixes.learn(stamp_s, heading) == Outcome::Feasible;
        self.tell_wheels_of_gyro();
        agrees
    }

    /// Passes the learnt bias and scale of the gyroscope to the wheel history. A bias that drifts is known less well the longer ago it was learnt.
    pub(super) fn tell_wheels_of_gyro(&mut self) {
        if let Some(fixes) = &self.fixes {
            self.wheels.learn_gyro(fixes.bias_over(memory_s(&self.robot), self.now_s), fixes.scale());
        }
    }

    /// A pose union at a stamp without the headings that earlier heading fixes, carried to that stamp by the gyroscope, rule out.
    pub(super) fn as_fixed_before(&self, mut union: PoseUnion, stamp_s: f64) -> PoseUnion {
        let Some(fixes) = self.fixes.as_ref().filter(|_| !self.is_doubted()) else { return union };
        let heading = fixes.heading(stamp_s);
        union.branches.iter_mut().for_each(|branch| branch[2] = branch[2].intersect(heading));
        union.branches.retain(|branch| !branch.is_empty());
        union
    }
}
