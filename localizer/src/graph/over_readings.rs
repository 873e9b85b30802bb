//! Bounds of quantities by a few readings at once, each at a pose of which only a box is known.

use std::{collections::BTreeMap, sync::Arc};

use interval::{
    Interval, IntervalBox,
    contractor::{Contractor, Outcome, settle},
};

use crate::PoseBox;

use super::{Domain, Hull, Related, Relations, Row, Stray, Variable, WIDEST_RAD, related::Origin};

/// Bounds of quantities over all values that satisfy the rows of some readings, in the order in which they are asked for; `None` where the readings
/// contradict each other or what is known. Reading number k is at the key frame with the number k, whose pose is within the given box; nothing else
/// relates the poses. A quantity that no reading names is [`Interval::ENTIRE`].
pub(crate) fn bounds_over(readings: &[(PoseBox, &dyn Relations)], wanted: &[Variable]) -> Option<Vec<Interval>> {
    let mut values: BTreeMap<Variable, Interval> = BTreeMap::new();
    for (frame, (pose, relations)) in readings.iter().enumerate() {
        let of_pose = (0..3).map(|axis| (Variable::Pose(frame, axis), pose[axis]));
        for (variable, value) in of_pose.chain(relations.quantities(frame, pose)) {
            let known = values.entry(variable).or_insert(Interval::ENTIRE);
            *known = known.intersect(value);
        }
    }
    if values.values().any(|value| value.is_empty()) {
        return None;
    }
    let known: Vec<Interval> =
        wanted.iter().map(|variable| values.get(variable).copied().unwrap_or(Interval::ENTIRE)).collect();
    if values.values().any(|value| !value.is_bounded()) {
        return Some(known);
    }
    let mut domain = Domain::default();
    values.into_iter().for_each(|(variable, value)| domain.put(variable, value));
    let rows: Vec<(Row, Origin)> = readings
        .iter()
        .enumerate()
        .flat_map(|(frame, (_, relations))| relations.rows(frame, &domain))
        .map(|row| (row, Origin::default()))
        .collect();
    let Ok(related) = Related::new(domain, rows, BTreeMap::new()) else { return Some(known) };
    let asked: Vec<Variable> = wanted.iter().copied().filter(|&one| related.index(one).is_some()).collect();
    let mut hull = Hull::new(related, asked.clone());
    while !hull.advance() {}
    let bounds = hull.bounds()?;
    let bound = |variable: &Variable| asked.iter().position(|one| one == variable).map(|at| bounds[at]);
    Some(
        wanted.iter().zip(known).map(|(one, known)| bound(one).map_or(known, |bound| bound.intersect(known))).collect(),
    )
}

/// Whether rows about the middle of a box of poses are of use over all of it.
pub(crate) fn is_linear_over(pose: &PoseBox) -> bool {
    !pose.is_empty() && pose[2].width() <= WIDEST_RAD && (0..2).all(|axis| pose[axis].is_bounded())
}

/// Contractor of the pose at a reading's stamp by the reading's rows. It contracts only where the heading is known well enough for rows to be linear,
/// and where every quantity is bounded.
pub(crate) struct PoseByRows {
    /// What the reading relates.
    pub(crate) relations: Arc<dyn Relations>,
    /// How far the pose that the reading shows may be from the pose at its stamp.
    pub(crate) stray: Stray,
}

/// Greatest number of times that rows are made anew about what is left of a pose.
const MOST_PASSES: usize = 6;
/// Rows are made anew if some coordinate has become narrower than this share of its width.
const WORTHWHILE: f64 = 0.8;

impl PoseByRows {
    /// What the rows, made once about the middle of a box of poses, leave of the box.
    pub(crate) fn pass(&self, domain: &PoseBox) -> PoseBox {
        if !is_linear_over(domain) {
            return *domain;
        }
        let wanted = [0, 1, 2].map(|axis| Variable::Pose(0, axis));
        let bounds = bounds_over(&[(self.stray.around(domain), &*self.relations)], &wanted);
        bounds.map_or(PoseBox::EMPTY, |bounds| {
            let bounds = self.stray.around(&PoseBox::from([bounds[0], bounds[1], bounds[2]]));
            let left = PoseBox::from([0, 1, 2].map(|axis| bounds[axis].intersect(domain[axis])));
            if left.is_empty() { PoseBox::EMPTY } else { left }
        })
    }
}

impl Contractor<3> for PoseByRows {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        if !is_linear_over(domain) {
            return Outcome::Feasible;
        }
        let mut left = *domain;
        // What rows lose by linearisation becomes less with every pass.
        for _ in 0..MOST_PASSES {
            let before = left;
            left = self.pass(&left);
            if left.is_empty() || (0..3).all(|axis| left[axis].width() > WORTHWHILE * before[axis].width()) {
                break;
            }
        }
        settle(domain, left, "rows of a reading")
    }
}
