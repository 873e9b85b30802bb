//! Planar rigid motion, linearised about a heading: four rows for each landmark, and four landmarks in a group of lanes.
//!
//! With a = t + R(θ) b, θ = θ₀ + δ, t = t₀ + τ, |δ| ≤ h and (c, s) = (cos θ₀, sin θ₀), each landmark, with a in its box A and b in its box B, says
//! that the coordinates of τ along four directions (the axes of A, and those of B rotated by θ₀) are an affine function of δ, plus or minus a
//! bound:
//!
//! ```text
//! along x:  τx           ∈ mx + δ gx ± ex     mx = ax − t₀x − (c bx − s by)      gx =   s bx + c by
//! along y:  τy           ∈ my + δ gy ± ey     my = ay − t₀y − (s bx + c by)      gy = −(c bx − s by)
//! along p:  c τx + s τy  ∈ mp + δ gp ± ep     mp = c wx + s wy − bx              gp = −s wx + c wy      w = a − t₀
//! along q: −s τx + c τy  ∈ mq + δ gq ± eq     mq = −s wx + c wy − by             gq = −(c wx + s wy)
//! ```
//!
//! The bounds e contain the radii of the boxes rotated by any angle allowed, Lagrange's remainder h²/2 · ‖b‖ or h²/2 · ‖w‖ of a rotation (whose
//! second derivative is minus itself), and the products of δ and τ. All is computed in round-to-nearest; what rounding may have lost is far
//! below `SLACK` times the sum of the magnitudes involved, which is added.

use interval::Interval;

/// Number of landmarks in a group that is computed together.
pub(super) const LANES: usize = 4;

/// Relative slack for rounding errors, 2⁻⁴⁶: about thirty roundings of 2⁻⁵³ contribute to a bound, and sine and cosine are off by less than two
/// more.
pub(super) const SLACK: f64 = 1.0 / (1u64 << 46) as f64;

/// Absolute part of the slack for rounding errors, above anything that underflow to zero can lose.
pub(super) const TINY: f64 = 1e-290;

/// The boxes (x, y) of one landmark: first in the frame in which the pose is expressed (the world), then in the frame that moves (the robot's).
pub type Landmark = ([Interval; 2], [Interval; 2]);

/// Four landmarks, each by the midpoints and radii of its boxes in both frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    a_x: [f64; LANES],
    a_y: [f64; LANES],
    a_radius_x: [f64; LANES],
    a_radius_y: [f64; LANES],
    b_x: [f64; LANES],
    b_y: [f64; LANES],
    b_radius_x: [f64; LANES],
    b_radius_y: [f64; LANES],
    b_norm: [f64; LANES],
}

/// The linearised constraints of four landmarks along one direction: the translation's coordinate along it is in m + δ g ± e, with the deviation δ
/// of the heading from the one about which the rotation is linearised.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) m: [f64; LANES],
    pub(super) g: [f64; LANES],
    pub(super) e: [f64; LANES],
}

/// Pose about which the motion is linearised, and how far the motion may be from that pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct About {
    pub(super) heading: f64,
    pub(super) cosine: f64,
    pub(super) sine: f64,
    /// Largest deviation |δ| of the heading from the heading about which the motion is linearised.
    pub(super) reach: f64,
    pub(super) translation: [f64; 2],
    /// Largest deviation |τ|, along x and along y, of the translation from the one about which the motion is linearised.
    pub(super) translation_radius: [f64; 2],
}

impl About {
    pub(super) fn new(heading: Interval, translation: [Interval; 2]) -> About {
        let middle = heading.mid();
        let (sine, cosine) = pxfm::f_sincos(middle);
        About {
            heading: middle,
            cosine,
            sine,
            reach: heading.radius(),
            translation: translation.map(Interval::mid),
            translation_radius: translation.map(Interval::radius),
        }
    }
}

impl Lanes {
    /// Groups of four landmarks. The last group is filled up by repeating its last landmark; as all results are intersections over the landmarks,
    /// that changes none of them.
    pub(super) fn groups(landmarks: &[Landmark]) -> Vec<Lanes> {
        landmarks
            .chunks(LANES)
            .map(|chunk| {
                let lane = |value: &dyn Fn(&Landmark) -> f64| -> [f64; LANES] {
                    std::array::from_fn(|idx| value(&chunk[idx.min(chunk.len() - 1)]))
                };
                Lanes {
                    a_x: lane(&|(a, _)| a[0].mid()),
                    a_y: lane(&|(a, _)| a[1].mid()),
                    a_radius_x: lane(&|(a, _)| a[0].radius()),
                    a_radius_y: lane(&|(a, _)| a[1].radius()),
                    b_x: lane(&|(_, b)| b[0].mid()),
                    b_y: lane(&|(_, b)| b[1].mid()),
                    b_radius_x: lane(&|(_, b)| b[0].radius()),
                    b_radius_y: lane(&|(_, b)| b[1].radius()),
                    b_norm: lane(&|(_, b)| Interval::point(b[0].mid()).hypot(Interval::point(b[1].mid())).hi()),
                }
            })
            .collect()
    }

    /// The linearised constraints (rows) of the four landmarks along four directions: the axes x and y of the frame of the pose, and the axes p and
    /// q, which are x and y rotated by the middle heading.
    #[inline]
    pub(super) fn rows(&self, about: &About) -> [Row; 4] {
        let (c, s, h) = (about.cosine, about.sine, about.reach);
        let curvature = 0.5 * h * h;
        // Upper bounds of |cos θ − c|, |sin θ − s|, |cos θ| and |sin θ| for all headings θ within h of the middle heading θ₀, whose cosine and sine
        // are c and s.
        let (cosine_moves, sine_moves) = (s.abs() * h + curvature, c.abs() * h + curvature);
        let (most_c, most_s) = ((c.abs() + cosine_moves).min(1.0), (s.abs() + sine_moves).min(1.0));
        let [t_x, t_y] = about.translation;
        let [tau_x, tau_y] = about.translation_radius;
        let bilinear_p = cosine_moves * tau_x + sine_moves * tau_y;
        let bilinear_q = sine_moves * tau_x + cosine_moves * tau_y;
        let t_size = t_x.abs() + t_y.abs();
        let empty = Row { m: [0.0; LANES], g: [0.0; LANES], e: [0.0; LANES] };
        let [mut x, mut y, mut p, mut q] = [empty; 4];
        for lane in 0..LANES {
            let (b_x, b_y) = (self.b_x[lane], self.b_y[lane]);
            let (w_x, w_y) = (self.a_x[lane] - t_x, self.a_y[lane] - t_y);
            let (turned_b_x, turned_b_y) = (c * b_x - s * b_y, s * b_x + c * b_y);
            let (turned_w_x, turned_w_y) = (c * w_x + s * w_y, c * w_y - s * w_x);
            let size = self.a_x[lane].abs() + self.a_y[lane].abs() + t_size + b_x.abs() + b_y.abs();
            let remainder_b = curvature * self.b_norm[lane];
            // The length ‖w‖ of the vector from the translation to the landmark is computed with a square root: the sum of absolute coordinates
            // would bound it without one, but too loosely.
            let remainder_w = curvature * (w_x * w_x + w_y * w_y).sqrt();
            let slack = SLACK * size + TINY;
            let (ra_x, ra_y) = (self.a_radius_x[lane], self.a_radius_y[lane]);
            let (rb_x, rb_y) = (self.b_radius_x[lane], self.b_radius_y[lane]);
            x.m[lane] = w_x - turned_b_x;
            y.m[lane] = w_y - turned_b_y;
            p.m[lane] = turned_w_x - b_x;
            q.m[lane] = turned_w_y - b_y;
            x.g[lane] = turned_b_y;
            y.g[lane] = -turned_b_x;
            p.g[lane] = turned_w_y;
            q.g[lane] = -turned_w_x;
            // The slack for rounding also covers that of the slopes g, which are multiplied by heading deviations up to h; hence the factor 1 + h.
            let widen = 1.0 + SLACK;
            let slack = slack * (1.0 + h);
            x.e[lane] = (ra_x + most_c * rb_x + most_s * rb_y + remainder_b) * widen + slack;
            y.e[lane] = (ra_y + most_s * rb_x + most_c * rb_y + remainder_b) * widen + slack;
            p.e[lane] = (rb_x + most_c * ra_x + most_s * ra_y + remainder_w + bilinear_p) * widen + slack;
            q.e[lane] = (rb_y + most_s * ra_x + most_c * ra_y + remainder_w + bilinear_q) * widen + slack;
        }
        [x, y, p, q]
    }
}

impl Row {
    /// Range of the translation's coordinate along the row's direction for any heading deviation |δ| ≤ `reach`: the intersection of m ± (|g| ·
    /// `reach` + e) over the four landmarks.
    #[inline]
    pub(super) fn range(&self, reach: f64) -> (f64, f64) {
        let mut lo = [0.0; LANES];
        let mut hi = [0.0; LANES];
        for lane in 0..LANES {
            let radius = (self.g[lane].abs() * reach + self.e[lane]) * (1.0 + SLACK) + SLACK * self.m[lane].abs();
            lo[lane] = self.m[lane] - radius;
            hi[lane] = self.m[lane] + radius;
        }
        (greatest(lo), least(hi))
    }

    /// Range of the heading's deviation δ when the translation's coordinate along the row's direction is in `mid ± radius`: the intersection, over
    /// the four landmarks, of the δ for which m + δ g ± e can meet that range.
    #[inline]
    pub(super) fn turn(&self, mid: f64, radius: f64) -> (f64, f64) {
        let mut lo = [0.0; LANES];
        let mut hi = [0.0; LANES];
        for lane in 0..LANES {
            // A slope g smaller than this says nothing about the heading's deviation δ. It is replaced by 1 in the division, and the resulting
            // bounds are not used.
            let slope = self.g[lane];
            let is_flat = slope.abs() < 1e-9;
            let inverse = 1.0 / if is_flat { 1.0 } else { slope };
            let quotient = (mid - self.m[lane]) * inverse;
            let size = (mid.abs() + self.m[lane].abs()) * SLACK;
            let spread = (radius + self.e[lane] + size) * inverse.abs() * (1.0 + SLACK) + SLACK * quotient.abs();
            lo[lane] = if is_flat { f64::NEG_INFINITY } else { quotient - spread };
            hi[lane] = if is_flat { f64::INFINITY } else { quotient + spread };
        }
        (greatest(lo), least(hi))
    }
}

#[inline]
fn greatest(lanes: [f64; LANES]) -> f64 {
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    greater(greater(lanes[0], lanes[1]), greater(lanes[2], lanes[3]))
}

#[inline]
fn least(lanes: [f64; LANES]) -> f64 {
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    lesser(lesser(lanes[0], lanes[1]), lesser(lanes[2], lanes[3]))
}
