//! Rigid motion from landmarks of which some are matched wrongly.

use interval::contractor::{Contractor, Outcome, q_intersection, settle};
use interval::{Interval, IntervalBox};

use super::Landmark;
use super::rigid_planar::{CAUSE, is_divisible};

/// Contractor of the planar pose from boxes of landmarks in two frames, of which at most `q` pairs belong to different landmarks.
///
/// **Constraint.** a = t + R(θ) b for all landmarks but at most q; the variables are tx, ty, θ.
///
/// **Sound.** The headings are covered by thin slices. For any heading of a slice, every rightly matched landmark puts t into the box a −
/// R(\[θ\]) b, along the axes of the world and along those of the rotated boxes. So t is in all but q of these boxes, and a slice without a
/// point in so many of them is dropped. No pair of landmarks is compared, because a pair is wrong as soon as one of the two is.
///
/// **Not optimal.** The q-intersection projects on axes, and a slice of width w leaves an uncertainty of |b|·w/2. The slicing is repeated while
/// it narrows the heading, so that in the end each slice has a sixteenth of the remaining width.
///
/// **Source.** L. Jaulin, "Robust set-membership state estimation", Automatica 45 (2009), on the problem of Table IV of M. Mustafa et al.,
/// CSCS 2015.
#[derive(Clone, Debug)]
pub struct RelaxedPose {
    /// The matched landmarks, each as a box in the world frame and a box in the robot frame.
    pub landmarks: Vec<Landmark>,
    /// Greatest number of landmarks that may be matched wrongly.
    pub q: usize,
}

/// Heading intervals wider than this are halved before they are cut into slices. For a landmark at 5 m, an interval this wide leaves a decimetre of
/// uncertainty, about the distance from which on two landmarks can be told apart.
const COARSE_RAD: f64 = 0.02;
/// Number of slices into which a heading interval is cut that is narrow enough not to be halved any more.
const N_SLICES: usize = 16;
/// Cutting a heading interval into slices, which drops those that fit no pose, is repeated as long as it narrows the interval to less than this
/// fraction of its width.
const WORTHWHILE: f64 = 0.7;
/// Greatest number of times that a heading interval is cut into slices.
const MOST_ROUNDS: usize = 4;

impl RelaxedPose {
    /// The part of a pose box that all but q landmarks allow; the box's heading is a thin slice.
    fn slice(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        let heading = domain[2];
        let (cosine, sine) = (heading.cos(), heading.sin());
        let place = IntervalBox::new([domain[0], domain[1]]);
        let place = self.places(place, |&(a, b)| {
            let turned = rotated(cosine, sine, b);
            [a[0] - turned[0], a[1] - turned[1]]
        });
        if place.is_empty() {
            return IntervalBox::EMPTY;
        }
        // The slice is contracted again in a frame rotated by the middle heading, in which the landmarks' boxes in the robot frame keep their axes.
        let middle = Interval::point(heading.mid());
        let (cosine, sine) = (middle.cos(), middle.sin());
        let rest = heading - middle;
        let (rest_cosine, rest_sine) = (rest.cos(), rest.sin());
        let along = self.places(IntervalBox::new(rotated(cosine, -sine, place.components())), |&(a, b)| {
            let (a, b) = (rotated(cosine, -sine, a), rotated(rest_cosine, rest_sine, b));
            [a[0] - b[0], a[1] - b[1]]
        });
        if along.is_empty() {
            return IntervalBox::EMPTY;
        }
        let place = place.intersect(&IntervalBox::new(rotated(cosine, sine, along.components())));
        if place.is_empty() { IntervalBox::EMPTY } else { IntervalBox::new([place[0], place[1], heading]) }
    }

    /// A box around the positions in the box `known` that all but q landmarks allow; `allowed` gives the box of positions that one landmark allows.
    fn places(&self, known: IntervalBox<2>, allowed: impl Fn(&Landmark) -> [Interval; 2]) -> IntervalBox<2> {
        let boxes: Vec<IntervalBox<2>> =
            self.landmarks.iter().map(|landmark| known.intersect(&IntervalBox::new(allowed(landmark)))).collect();
        if boxes.iter().filter(|one| one.is_empty()).count() > self.q {
            return IntervalBox::EMPTY;
        }
        known.intersect(&q_intersection(&boxes, self.q))
    }

    /// Halves the heading interval of a pose box until the parts are narrow enough to be cut into slices, drops the parts that fit no pose, and
    /// joins neighbouring ones again.
    fn coarse(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let mut parts: Vec<IntervalBox<3>> = Vec::new();
        let mut pending = vec![*domain];
        while let Some(candidate) = pending.pop() {
            let left = self.slice(&candidate);
            if left.is_empty() {
                continue;
            }
            if left.width(2) > COARSE_RAD && is_divisible(domain[2]) {
                let (lower, upper) = left.bisect(2);
                pending.extend([upper, lower]);
                continue;
            }
            match parts.last_mut() {
                Some(last) if last[2].overlaps(left[2]) => *last = last.hull(&left),
                _ => parts.push(left),
            }
        }
        parts
    }

    /// Cuts the heading interval of a pose box into thin slices and drops those that fit no pose, repeatedly, until that does not narrow the
    /// interval any more.
    fn fine(&self, mut part: IntervalBox<3>) -> IntervalBox<3> {
        // A heading interval of many turns contains all directions again and again, so that no slicing narrows it.
        if !is_divisible(part[2]) {
            return part;
        }
        for _ in 0..MOST_ROUNDS {
            let (lo, hi, width) = (part[2].lo(), part[2].hi(), part.width(2));
            let end =
                |idx: usize| if idx == N_SLICES { hi } else { (lo + width * idx as f64 / N_SLICES as f64).min(hi) };
            let slices = (0..N_SLICES)
                .map(|idx| self.slice(&IntervalBox::new([part[0], part[1], Interval::new(end(idx), end(idx + 1))])));
            let left = slices.fold(IntervalBox::EMPTY, |hull, slice| hull.hull(&slice));
            let narrowed = left.is_empty() || left.width(2) < WORTHWHILE * width;
            part = left;
            if part.is_empty() || !narrowed {
                break;
            }
        }
        part
    }
}

/// Rotates a box of vectors by an angle with the given cosine and sine.
fn rotated(cosine: Interval, sine: Interval, [x, y]: [Interval; 2]) -> [Interval; 2] {
    [cosine * x - sine * y, sine * x + cosine * y]
}

impl Contractor<3> for RelaxedPose {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let left = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        settle(domain, left, CAUSE)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if domain.is_empty() {
            return Vec::new();
        }
        if self.q >= self.landmarks.len() {
            return vec![*domain];
        }
        let parts = self.coarse(domain).into_iter().map(|part| self.fine(part));
        parts.filter(|part| !part.is_empty()).collect()
    }
}
