//! Planar rigid motion between two views of the same landmarks.

use interval::contractor::{Contractor, Outcome, settle};
use interval::{Interval, IntervalBox};

use super::rigid_rows::{About, Landmark, Lanes, SLACK};

pub(super) const CAUSE: &str = "no rigid motion carries the landmarks of one view into those of the other";

/// Contractor of the planar pose from boxes of the same landmarks in two frames.
///
/// **Constraint.** aᵢ = t + R(θ) bᵢ for all landmarks i, with aᵢ and bᵢ in boxes; the variables are tx, ty, θ. With aᵢ in the world frame and bᵢ
/// in the robot frame they are the robot's pose. Correspondences are known; see `QRelaxed` when some may be wrong.
///
/// **Sound.** The two boxes of each landmark are compared along the axes of both, linearised about the middle heading with Lagrange's remainder
/// (`rigid_rows`). A pose box so large that the remainder dominates is cut along the heading first. The direction of the vector from one
/// landmark to another, which no translation changes, bounds θ before any bisection.
///
/// **Optimal** in the limit of small boxes: for one heading, two rectangles, one of them rotated, have a point in common exactly if none of the
/// directions of their four axes separates them, and the translations left by these directions are bounded exactly.
///
/// **Source.** M. Mustafa et al., "Rigid transformation using interval analysis for robot motion estimation", CSCS 2015, Table IV. As printed,
/// its rows 31 and 32 keep the truth for a quarter of all headings only (`arccos` and `arcsin` have one branch); this contractor has no inverse
/// functions of which to choose a branch.
#[derive(Clone, Debug)]
pub struct RigidPlanar {
    groups: Vec<Lanes>,
    heading: Option<Interval>,
    landmarks: Vec<Landmark>,
}

impl RigidPlanar {
    /// A contractor for landmarks given as pairs of boxes (x, y): the first box is in the frame in which the pose is expressed, the second in the
    /// frame that moves (for a robot's pose: the world frame and the robot frame).
    ///
    /// A landmark with an unbounded box constrains nothing; a landmark with an empty box leaves no pose.
    pub fn new(landmarks: &[Landmark]) -> RigidPlanar {
        let is_within =
            |limit: f64| move |(a, b): &&Landmark| [a[0], a[1], b[0], b[1]].iter().all(|x| x.magnitude() <= limit);
        let is_possible = !landmarks.iter().any(|(a, b)| [a[0], a[1], b[0], b[1]].iter().any(|x| x.is_empty()));
        // Landmarks with coordinates beyond this limit are left out, because products of still larger ones would overflow.
        let bounded: Vec<Landmark> = landmarks.iter().filter(is_within(1e100)).copied().collect();
        RigidPlanar {
            groups: Lanes::groups(&bounded),
            heading: if is_possible { heading_between_views(&bounded) } else { Some(Interval::EMPTY) },
            landmarks: bounded,
        }
    }

    /// Headings that agree with the vectors from landmark to landmark in both frames, as an interval less than half a turn wide, modulo whole
    /// turns; `None` when these vectors do not decide on the heading.
    pub fn heading(&self) -> Option<Interval> {
        self.heading
    }

    /// The landmarks that constrain the motion: those with bounded boxes.
    pub fn landmarks(&self) -> &[Landmark] {
        &self.landmarks
    }

    pub(super) fn groups(&self) -> &[Lanes] {
        &self.groups
    }

    /// The parts of an interval of headings that agree with the vectors from landmark to landmark in both frames, one part for each turn; the whole
    /// interval when these vectors do not decide on the heading.
    pub fn turns(&self, heading: Interval) -> Vec<Interval> {
        let Some(allowed) = self.heading else {
            return vec![heading];
        };
        if allowed.is_empty() || heading.is_empty() {
            return Vec::new();
        }
        let turn = 2.0 * Interval::PI;
        let quotient = (heading - allowed) / turn;
        let (first, last) = (quotient.lo().ceil(), quotient.hi().floor());
        // Headings of so many turns, or so far from 0, stay one interval: cutting them into turns would narrow nothing that matters.
        if last - first > 1024.0 || first.abs() > 1e9 {
            return vec![heading];
        }
        let parts = (first as i64..=last as i64).map(|k| (allowed + k as f64 * turn).intersect(heading));
        parts.filter(|part| !part.is_empty()).collect()
    }

    /// One pass of the contractor: bounds translation and heading by all landmarks, with their constraints linearised about the middle of the pose
    /// box.
    pub(super) fn pass(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        let about = About::new(domain[2], [domain[0], domain[1]]);
        let h = about.reach;
        let [tau_x, tau_y] = about.translation_radius;
        let mut ranges = [(-tau_x, tau_x), (-tau_y, tau_y), UNKNOWN, UNKNOWN];
        let mut turn = (-h, h);
        // For each group of four landmarks the linearised constraints (rows) are computed once, and bound first the translation and then the
        // heading. So when there is a single group, the heading profits at once from the bounds on the translation.
        for lanes in &self.groups {
            let rows = lanes.rows(&about);
            for (range, row) in ranges.iter_mut().zip(&rows) {
                *range = common(*range, row.range(h));
            }
            if self.groups.len() == 1 {
                ranges = bound_translation(ranges, about.cosine, about.sine);
            }
            for (range, row) in ranges.iter().zip(&rows) {
                let (mid, radius) = mid_radius(*range);
                turn = common(turn, row.turn(mid, radius));
            }
        }
        if self.groups.len() > 1 {
            ranges = bound_translation(ranges, about.cosine, about.sine);
        }
        if ranges.iter().chain([&turn]).any(|(lo, hi)| lo > hi) {
            return IntervalBox::EMPTY;
        }
        let left = |origin: f64, (lo, hi): (f64, f64)| Interval::new(lo, hi) + origin;
        IntervalBox::new([
            domain[0].intersect(left(about.translation[0], ranges[0])),
            domain[1].intersect(left(about.translation[1], ranges[1])),
            domain[2].intersect(left(about.heading, turn)),
        ])
    }

    /// Contracts a pose box by halving its heading interval until the parts are narrow enough for the linearised constraints, contracting each
    /// part, and joining the results.
    ///
    /// An interval of many turns is not cut into parts: it contains every direction again and again, so that a single turn decides about the
    /// translation, and the heading stays as it is.
    pub(super) fn contract_turn(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        if domain.is_empty() {
            return IntervalBox::EMPTY;
        }
        if is_divisible(domain[2]) {
            return self.contract_parts(domain);
        }
        if domain[2].width() <= WIDEST_HEADING {
            return self.pass(domain);
        }
        let one_turn = IntervalBox::new([domain[0], domain[1], Interval::new(0.0, (2.0 * Interval::PI).hi())]);
        let left = self.contract_parts(&one_turn);
        if left.is_empty() { left } else { IntervalBox::new([left[0], left[1], domain[2]]) }
    }

    fn contract_parts(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        if domain[2].width() <= WIDEST_HEADING {
            return self.pass(domain);
        }
        let (left, right) = domain.bisect(2);
        self.contract_parts(&left).hull(&self.contract_parts(&right))
    }
}

/// Width in radians of a heading interval above which it is halved before the constraints are linearised. The error of linearising, Lagrange's
/// remainder h²/2 for headings up to h off the middle, reaches an eighth there, and two halves give tighter bounds than the whole.
const WIDEST_HEADING: f64 = 1.0;

/// Whether a heading interval is worth halving until the parts are narrow: it must not be so wide that it contains every direction many times, nor
/// so far from 0 that the doubles there are too coarse to halve it.
pub(super) fn is_divisible(heading: Interval) -> bool {
    heading.width() < WIDEST_RAD && heading.magnitude() < FARTHEST_RAD
}

/// Width in radians from which on a heading interval is not halved, because it contains every direction many times.
const WIDEST_RAD: f64 = 100.0;
/// Absolute heading in radians from which on an interval is not halved. Doubles are 10⁻⁷ apart here, far less than the width of any slice of
/// headings.
const FARTHEST_RAD: f64 = 1e9;

const UNKNOWN: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl Contractor<3> for RigidPlanar {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        if domain.is_empty() || self.heading.is_some_and(Interval::is_empty) {
            return settle(domain, IntervalBox::EMPTY, CAUSE);
        }
        let left = if domain[2].width() <= WIDEST_HEADING && domain[0].is_bounded() && domain[1].is_bounded() {
            self.pass(domain)
        } else {
            self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch))
        };
        settle(domain, left, CAUSE)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let parts = self.turns(domain[2]).into_iter().map(|heading| {
            let part = IntervalBox::new([domain[0], domain[1], heading]);
            let bounded = self.bound_by_lengths(&part);
            if bounded.is_empty() { bounded } else { self.contract_turn(&bounded) }
        });
        parts.filter(|part| !part.is_empty()).collect()
    }
}

impl RigidPlanar {
    /// A guess of the translation, not a bound: it brings the mean of one view's landmarks, rotated by `heading`, onto the mean of the other
    /// view's.
    pub(super) fn aligned_centroids(&self, heading: f64) -> [f64; 2] {
        let (sine, cosine) = pxfm::f_sincos(heading);
        let mut sum = [0.0; 2];
        for (a, b) in &self.landmarks {
            let (b_x, b_y) = (b[0].mid(), b[1].mid());
            sum[0] += a[0].mid() - (cosine * b_x - sine * b_y);
            sum[1] += a[1].mid() - (sine * b_x + cosine * b_y);
        }
        sum.map(|total| total / self.landmarks.len().max(1) as f64)
    }

    /// Bounds each coordinate of the translation t by |t − a| = |b| for every landmark, at a in the frame of the pose and at b in the frame that
    /// moves. This holds for any heading, and gives a bounded box to start from.
    pub(super) fn bound_by_lengths(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        let mut left = *domain;
        for (a, b) in &self.landmarks {
            let length = b[0].hypot(b[1]);
            let reach = Interval::new(-length.hi(), length.hi());
            left[0] = left[0].intersect(a[0] + reach);
            left[1] = left[1].intersect(a[1] + reach);
        }
        left
    }
}

/// Bounds a point's coordinates along x and y and along the axes p and q, which are rotated by the angle with the cosine c and sine s, by each
/// other: p = c x + s y, q = −s x + c y. An optimal corner of a planar linear problem lies on two of its lines, so that all pairs of these
/// directions give the exact bounds.
fn bound_translation(ranges: [(f64, f64); 4], c: f64, s: f64) -> [(f64, f64); 4] {
    let [x, y, p, q] = ranges;
    let nearly_axis = 0.05;
    let mut bounded_x = common(x, combine(p, c, q, -s));
    let mut bounded_y = common(y, combine(p, s, q, c));
    if c.abs() > nearly_axis {
        bounded_x = common(bounded_x, combine(p, 1.0 / c, y, -s / c));
        bounded_y = common(bounded_y, combine(q, 1.0 / c, x, s / c));
    }
    if s.abs() > nearly_axis {
        bounded_x = common(bounded_x, combine(y, c / s, q, -1.0 / s));
        bounded_y = common(bounded_y, combine(p, 1.0 / s, x, -c / s));
    }
    let bounded_p = common(p, combine(bounded_x, c, bounded_y, s));
    let bounded_q = common(q, combine(bounded_x, -s, bounded_y, c));
    [bounded_x, bounded_y, bounded_p, bounded_q]
}

/// The range factor · range + other_factor · other, widened by what rounding of the result and of the two factors may have lost.
#[inline]
fn combine(range: (f64, f64), factor: f64, other: (f64, f64), other_factor: f64) -> (f64, f64) {
    let ((mid, radius), (other_mid, other_radius)) = (mid_radius(range), mid_radius(other));
    let middle = factor * mid + other_factor * other_mid;
    let size = factor.abs() * (mid.abs() + radius) + other_factor.abs() * (other_mid.abs() + other_radius);
    let spread = factor.abs() * radius + other_factor.abs() * other_radius + SLACK * size;
    (middle - spread, middle + spread)
}

#[inline]
fn mid_radius((lo, hi): (f64, f64)) -> (f64, f64) {
    // Middle and radius of the range are rounded; every caller widens its result by far more than that.
    (0.5 * (lo + hi), 0.5 * (hi - lo))
}

/// Intersection of two ranges. A bound of `b` that is NaN, as overflow may make it, is ignored.
#[inline]
pub(super) fn common(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (if b.0 > a.0 { b.0 } else { a.0 }, if b.1 < a.1 { b.1 } else { a.1 })
}

/// Intersection of the headings that carry the vectors between landmarks of one view into those of the other; `None` when no such vector decides
/// on the heading.
fn heading_between_views(landmarks: &[Landmark]) -> Option<Interval> {
    let mut heading: Option<Interval> = None;
    for (idx, (a, b)) in landmarks.iter().enumerate() {
        for (other_a, other_b) in &landmarks[..idx] {
            let Some(angle_a) = direction(other_a[0] - a[0], other_a[1] - a[1]) else {
                continue;
            };
            let Some(angle_b) = direction(other_b[0] - b[0], other_b[1] - b[1]) else {
                continue;
            };
            let turned = angle_a - angle_b;
            // Two arcs of headings that are narrower than half a turn meet in one arc, after one of them is moved by the whole turns between
            // their middles.
            if turned.width() > 3.0 {
                continue;
            }
            heading = Some(match heading {
                None => turned,
                Some(known) => {
                    let n_turns = ((known.mid() - turned.mid()) / std::f64::consts::TAU).round();
                    known.intersect(turned + n_turns * (2.0 * Interval::PI))
                }
            });
        }
        // The vectors between a few landmarks are enough to find the heading to less than half a turn, and the linearised constraints narrow it
        // further; the number of all pairs would be quadratic.
        if idx >= 5 && heading.is_some() {
            break;
        }
    }
    heading
}

/// Interval of the directions of the vectors in a box, less than half a turn wide; `None` when the box contains the origin.
pub(super) fn direction(x: Interval, y: Interval) -> Option<Interval> {
    if x.contains_zero() && y.contains_zero() {
        return None;
    }
    // For a box of vectors on the left, where the arc tangent has its cut, the direction is that of the opposite vectors plus half a turn.
    Some(if x.hi() < 0.0 { (-y).atan2(-x) + Interval::PI } else { y.atan2(x) })
}
