//! The rigid motion when some landmarks are wrong.

use interval::contractor::{Contractor, Outcome, q_intersection, settle};
use interval::{Interval, IntervalBox};

use super::Landmark;
use super::rigid_planar::{CAUSE, is_divisible};

/// Boxes of the same landmarks in two frames, of which at most `q` are of different ones.
///
/// **Constraint.** a = t + R(θ) b for all landmarks but at most q; the variables are tx, ty, θ.
///
/// **Sound.** The headings are covered by thin slices. For any heading of a slice every right landmark puts t into the box a − R(\[θ\]) b, along the
/// axes of the world and along those of the turned boxes; t is in all but q of them, and a slice in which no point is goes. No pair of
/// landmarks is compared: a pair is wrong as soon as one of the two is.
///
/// **Not optimal.** The q-intersection projects on axes, and a slice of width w leaves |b|·w/2 open. Slices are renewed while they narrow the
/// heading, so that what is left in the end is a sixteenth of its width.
///
/// **Source.** L. Jaulin, "Robust set-membership state estimation", Automatica 45 (2009), on the problem of Table IV of M. Mustafa et al.,
/// CSCS 2015.
#[derive(Clone, Debug)]
pub struct RelaxedPose {
    /// The landmarks in both frames.
    pub landmarks: Vec<Landmark>,
    /// How many of them may be wrong.
    pub q: usize,
}

/// Headings wider than this are halved first: at 5 m such a slice leaves a decimetre open, about what tells landmarks apart.
const COARSE_RAD: f64 = 0.02;
/// Slices of what the halving leaves.
const N_SLICES: usize = 16;
/// New slices are worth their time while the last ones narrowed the heading to this share.
const WORTHWHILE: f64 = 0.7;
/// Rounds of slices at most.
const MOST_ROUNDS: usize = 4;

impl RelaxedPose {
    /// What all but q landmarks leave of a box whose heading is a thin slice.
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
        // The same, seen from a frame turned to the middle heading: boxes b keep their axes there.
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

    /// The part of `known` that all but q landmarks allow, each of which allows a box.
    fn places(&self, known: IntervalBox<2>, allowed: impl Fn(&Landmark) -> [Interval; 2]) -> IntervalBox<2> {
        let boxes: Vec<IntervalBox<2>> =
            self.landmarks.iter().map(|landmark| known.intersect(&IntervalBox::new(allowed(landmark)))).collect();
        if boxes.iter().filter(|one| one.is_empty()).count() > self.q {
            return IntervalBox::EMPTY;
        }
        known.intersect(&q_intersection(&boxes, self.q))
    }

    /// Halves the headings until they are narrow enough to be sliced; neighbours are joined again.
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

    /// Slices of a part of the headings, until they narrow it no more.
    fn fine(&self, mut part: IntervalBox<3>) -> IntervalBox<3> {
        // All directions are in there, again and again: no slice of them is any narrower.
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

/// A box of vectors, turned.
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
