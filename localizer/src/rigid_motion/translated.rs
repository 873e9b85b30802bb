//! The motion without the turn: the position from landmarks, with the heading as it is known.

use interval::contractor::{Contractor, Outcome, q_intersection, settle};
use interval::{Interval, IntervalBox};

use super::Landmark;
use super::rigid_planar::CAUSE;

/// The first `N` coordinates of the position from landmarks of which at most `q` are wrong.
///
/// **Constraint.** a = t + R(θ) b for all landmarks but at most q, of which only t is contracted; with `N` = 1 only its x.
///
/// **Sound.** For any heading in the box, t = a − R(θ) b for each right landmark, so t is in all but q of the boxes a − R(\[θ\]) b.
///
/// **Optimal** for q = 0 and a known heading: a is added once, b turned once. With an uncertain heading its dependency on all landmarks is lost.
///
/// **Source.** M. Mustafa et al., "Rigid transformation using interval analysis for robot motion estimation", CSCS 2015, Table II (`N` = 1, a
/// robot on a line) and Table III (`N` = 2, translation). The paper assumes θ = 0; here it is an interval, so that it holds for any motion.
#[derive(Clone, Debug)]
pub struct Translated<const N: usize> {
    /// The landmarks in both frames.
    pub landmarks: Vec<Landmark>,
    /// How many of them may be wrong.
    pub q: usize,
}

impl<const N: usize> Contractor<3> for Translated<N> {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let (cosine, sine) = (domain[2].cos(), domain[2].sin());
        let known = IntervalBox::<N>::new(std::array::from_fn(|axis| domain[axis]));
        let boxes: Vec<IntervalBox<N>> = self
            .landmarks
            .iter()
            .map(|(a, b)| {
                let turned: [Interval; 2] = [cosine * b[0] - sine * b[1], sine * b[0] + cosine * b[1]];
                // Tables II and III, rows 03 to 08: t = a − z with z = R(θ) b.
                known.intersect(&IntervalBox::new(std::array::from_fn(|axis| a[axis] - turned[axis])))
            })
            .collect();
        let kept = known.intersect(&q_intersection(&boxes, self.q));
        let left = IntervalBox::new(std::array::from_fn(|axis| if axis < N { kept[axis] } else { domain[axis] }));
        settle(domain, left, CAUSE)
    }
}
