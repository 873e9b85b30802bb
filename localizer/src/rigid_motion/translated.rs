//! The position from landmarks when the heading is known beforehand: only the translation of the rigid motion is contracted.

use interval::contractor::{Contractor, Outcome, q_intersection, settle};
use interval::{Interval, IntervalBox};

use super::Landmark;
use super::rigid_planar::CAUSE;

/// Contractor of the first `N` coordinates of the position, from landmarks of which at most `q` are matched wrongly.
///
/// **Constraint.** a = t + R(θ) b for all landmarks but at most q. Only t is contracted; with `N` = 1 only its x.
///
/// **Sound.** For any heading in the box, t = a − R(θ) b for each rightly matched landmark, so t is in all but q of the boxes a − R(\[θ\]) b.
///
/// **Optimal** for q = 0 and an exactly known heading: a is added once, and b is rotated once. With an uncertain heading the result does not use
/// that the heading is the same for all landmarks.
///
/// **Source.** M. Mustafa et al., "Rigid transformation using interval analysis for robot motion estimation", CSCS 2015, Table II (`N` = 1, a
/// robot on a line) and Table III (`N` = 2, translation). The paper assumes θ = 0; here it is an interval, so that the constraint holds for any
/// motion.
#[derive(Clone, Debug)]
pub struct Translated<const N: usize> {
    /// The matched landmarks in both frames.
    pub landmarks: Vec<Landmark>,
    /// Greatest number of landmarks that may be matched wrongly.
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
                // Rows 03 to 08 of paper 3's Tables II and III: t = a − z with z = R(θ) b.
                known.intersect(&IntervalBox::new(std::array::from_fn(|axis| a[axis] - turned[axis])))
            })
            .collect();
        let kept = known.intersect(&q_intersection(&boxes, self.q));
        let left = IntervalBox::new(std::array::from_fn(|axis| if axis < N { kept[axis] } else { domain[axis] }));
        settle(domain, left, CAUSE)
    }
}
