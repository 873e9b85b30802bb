//! A constraint on the heading after a turn of the robot, applied to the heading before that turn.

use interval::contractor::{Contractor, Outcome};
use interval::{Interval, IntervalBox};

/// Constraint on the robot's heading before a turn, made from the interval `turn` of the turn's angle and the constraint `on_pose` on the
/// heading after the turn; x and y are not narrowed.
pub(super) struct AfterTurn {
    pub(super) turn: Interval,
    pub(super) on_pose: Box<dyn Contractor<3> + Send + Sync>,
}

impl AfterTurn {
    fn turned(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        IntervalBox::from([domain[0], domain[1], domain[2] + self.turn])
    }

    fn back(&self, domain: &IntervalBox<3>, turned: &IntervalBox<3>) -> IntervalBox<3> {
        if turned.is_empty() {
            return IntervalBox::EMPTY;
        }
        IntervalBox::from([domain[0], domain[1], domain[2].intersect(turned[2] - self.turn)])
    }
}

impl Contractor<3> for AfterTurn {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let mut turned = self.turned(domain);
        let outcome = self.on_pose.contract(&mut turned);
        *domain = self.back(domain, &turned);
        outcome
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let branches = self.on_pose.branches(&self.turned(domain));
        branches.iter().map(|turned| self.back(domain, turned)).filter(|branch| !branch.is_empty()).collect()
    }
}
