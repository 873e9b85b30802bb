//! The matched filter of a joint: a blurred strip of known width, whatever the level, the slope and the step under it.
//!
//! A profile across a joint between two tiles is modelled as
//! `y(x) = a + b·x + c·step(x − s) + d·strip(x − s)`, with `E` the blurred unit edge, `w` the joint's width,
//! `step = (E(x + w/2) + E(x − w/2) − 1)/2·2` (half of the way from tile to tile happens at each edge of the joint) and
//! `strip = E(x + w/2) − E(x − w/2)`. For every shift `s` the four coefficients are a linear fit; the best shift is the
//! one that leaves the least.

/// Shifts tried per pixel: the residual is a parabola over half a pixel because the sharpest edge is wider than that.
const SHIFTS_PER_PX: usize = 2;
/// Undisturbed tile on either side of the farthest joint: enough to tell level, slope and step from the strip.
const SURROUND_PX: f64 = 5.0;
/// Standard deviation of an edge's blur without motion: pixel aperture, interpolation and lens together.
const EDGE_SIGMA_PX: f64 = 0.65;

/// Filters for one width, one blur and shifts within a reach.
pub(super) struct JointFilter {
    /// Samples are taken at `-half..=half` pixels.
    pub(super) half: usize,
    /// Greatest shift in either direction.
    reach_px: f64,
    /// Orthonormal basis of level and slope.
    ground: [Vec<f32>; 2],
    shifts: Vec<Shift>,
    /// Norm of what a unit strip's derivative leaves outside of the four-dimensional model: position sd = noise / (depth · this).
    position_gain: f32,
}

/// Basis vectors of one shift, orthonormal together with the ground's.
struct Shift {
    step: Vec<f32>,
    strip: Vec<f32>,
    /// Norm of the strip before normalisation: depth = projection / norm.
    strip_norm: f32,
}

/// Best fit of one profile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Position of the joint's centre relative to the middle sample.
    pub(super) shift_px: f32,
    /// Height of the strip in units of the profile: negative where the joint is darker.
    pub(super) depth: f32,
    /// Root mean square of what the model leaves, per degree of freedom.
    pub(super) residual: f32,
}

impl JointFilter {
    /// Samples needed on either side of the middle.
    pub(super) fn half_for(width_px: f64, blur_px: f64, reach_px: f64) -> usize {
        (0.5 * (width_px + blur_px) + reach_px + SURROUND_PX).ceil() as usize
    }

    /// The filters for joints of a width under a blur, at shifts within a reach, on `2·half + 1` samples.
    pub(super) fn new(width_px: f64, blur_px: f64, reach_px: f64, half: usize) -> Self {
        let xs = || (0..=2 * half).map(|sample| sample as f64 - half as f64);
        let mut ground = [vec![1.0; 2 * half + 1], xs().map(|x| x as f32).collect()];
        for vector in &mut ground {
            normalise(vector);
        }
        let mut shifts = Vec::new();
        let count = (2.0 * reach_px).round() as usize * SHIFTS_PER_PX + 1;
        for index in 0..count {
            let shift_px = index as f64 / SHIFTS_PER_PX as f64 - reach_px;
            let edge = |x: f64| blurred_edge(x, blur_px);
            let (mut step, mut strip) = (Vec::with_capacity(2 * half + 1), Vec::with_capacity(2 * half + 1));
            for x in xs() {
                let (left, right) = (edge(x - shift_px + 0.5 * width_px), edge(x - shift_px - 0.5 * width_px));
                step.push((0.5 * (left + right - 1.0)) as f32);
                strip.push((left - right) as f32);
            }
            remove(&mut step, [&ground[0], &ground[1]]);
            normalise(&mut step);
            remove(&mut strip, [&ground[0], &ground[1], &step]);
            let strip_norm = normalise(&mut strip);
            shifts.push(Shift { step, strip, strip_norm });
        }
        let middle = &shifts[count / 2];
        let edge = |x: f64| blurred_edge(x, blur_px);
        let strip = |x: f64| edge(x + 0.5 * width_px) - edge(x - 0.5 * width_px);
        let mut derivative: Vec<f32> = xs().map(|x| ((strip(x + 0.05) - strip(x - 0.05)) / 0.1) as f32).collect();
        remove(&mut derivative, [&ground[0], &ground[1], &middle.step, &middle.strip]);
        let position_gain = dot(&derivative, &derivative).sqrt();
        JointFilter { half, reach_px, ground, shifts, position_gain }
    }

    /// Standard deviation of a position measured with this depth under this noise per sample.
    pub(super) fn position_sd_px(&self, depth: f32, noise: f32) -> f32 {
        noise / (depth.abs() * self.position_gain).max(1e-6)
    }

    /// Fits a profile of at least `2·half + 1` samples, of which the middle ones are used, at shifts within
    /// `within_px` of `around_px`. `None` where no such shift shows a strip of the wanted polarity inside of its neighbours.
    pub(super) fn fit(&self, profile: &[f32], dark: bool, around_px: f32, within_px: f32) -> Option<Fit> {
        let margin = profile.len() / 2 - self.half;
        let mut y = [0f32; MAX_SAMPLES];
        let y = &mut y[..2 * self.half + 1];
        y.copy_from_slice(&profile[margin..margin + 2 * self.half + 1]);
        remove(y, [&self.ground[0], &self.ground[1]]);
        let total = dot(y, y);
        let to_index = |shift_px: f32| (shift_px + self.reach_px as f32) * SHIFTS_PER_PX as f32;
        let last = self.shifts.len() - 1;
        let from = to_index(around_px - within_px).floor().clamp(0.0, last as f32) as usize;
        let to = to_index(around_px + within_px).ceil().clamp(0.0, last as f32) as usize;
        let mut explained = [0f32; MAX_SHIFTS];
        let (mut best, mut best_depth) = (None, 0.0);
        for index in from..=to {
            let shift = &self.shifts[index];
            let (step, strip) = (dot(y, &shift.step), dot(y, &shift.strip));
            explained[index] = step * step + strip * strip;
            if (strip < 0.0) == dark && best.is_none_or(|best: usize| explained[index] > explained[best]) {
                (best, best_depth) = (Some(index), strip / shift.strip_norm);
            }
        }
        // A maximum at either end of the search is no maximum.
        let best = best.filter(|&index| index > from && index < to)?;
        let [before, here, after] = [best - 1, best, best + 1].map(|index| explained[index]);
        let bend = 2.0 * here - before - after;
        if before > here || after > here || bend <= 0.0 {
            return None;
        }
        let offset = 0.5 * (after - before) / bend;
        let left = (total - here - 0.25 * (after - before) * offset).max(0.0);
        Some(Fit {
            shift_px: (best as f32 + offset) / SHIFTS_PER_PX as f32 - self.reach_px as f32,
            depth: best_depth,
            residual: (left / (2 * self.half + 1 - 5) as f32).sqrt(),
        })
    }
}

/// Room for the widest profile: a joint of 16 px under 24 px of blur.
pub(super) const MAX_SAMPLES: usize = 96;
/// Room for shifts within ±12 px.
const MAX_SHIFTS: usize = 64;

/// A unit edge after motion over `blur_px` and the optics' blur, 0 far left, 1 far right.
fn blurred_edge(x: f64, blur_px: f64) -> f64 {
    let z = x / EDGE_SIGMA_PX;
    if blur_px < 0.05 {
        return normal_cdf(z);
    }
    let half = 0.5 * blur_px / EDGE_SIGMA_PX;
    (normal_cdf_integral(z + half) - normal_cdf_integral(z - half)) / (2.0 * half)
}

/// Normal distribution function to 2·10⁻⁴ (Page 1977), odd about one half, so that templates stay symmetric.
fn normal_cdf(z: f64) -> f64 {
    0.5 * (1.0 + (0.797_884_560_8 * (z + 0.044_715 * z * z * z)).tanh())
}

/// ∫ of the normal distribution function from −∞: `z·Φ(z) + φ(z)`.
fn normal_cdf_integral(z: f64) -> f64 {
    z * normal_cdf(z) + 0.398_942_280_4 * (-0.5 * z * z).exp()
}

#[inline]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    // Eight running sums let the compiler use vector registers; a single one forces an order of addition.
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f32 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    let mut sums = [0f32; 8];
    for (x, y) in a8.zip(b8) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f32>() + tail
}

/// Subtracts the projections on orthonormal vectors.
fn remove<const N: usize>(vector: &mut [f32], basis: [&[f32]; N]) {
    for direction in basis {
        let share = dot(vector, direction);
        vector.iter_mut().zip(direction).for_each(|(value, unit)| *value -= share * unit);
    }
}

/// Scales to unit length and answers with the length it had.
fn normalise(vector: &mut [f32]) -> f32 {
    let length = dot(vector, vector).sqrt().max(1e-12);
    vector.iter_mut().for_each(|value| *value /= length);
    length
}
