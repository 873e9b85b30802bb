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
    /// Norms before normalisation: depth = projection / norm.
    step_norm: f32,
    strip_norm: f32,
    /// What a strip of unit depth has in common with the unit step.
    strip_on_step: f32,
}

/// Best fit of one profile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Position of the joint's centre relative to the middle sample.
    pub(super) shift_px: f32,
    /// Height of the strip in units of the profile: negative where the joint is darker.
    pub(super) depth: f32,
    /// Height of the step from the tile on one side to that on the other.
    pub(super) step: f32,
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
            let step_norm = normalise(&mut step);
            let strip_on_step = dot(&strip, &step);
            remove(&mut strip, [&ground[0], &ground[1], &step]);
            let strip_norm = normalise(&mut strip);
            shifts.push(Shift { step, strip, step_norm, strip_norm, strip_on_step });
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
        let (mut best, mut best_depth, mut best_step) = (None, 0.0, 0.0);
        for index in from..=to {
            let shift = &self.shifts[index];
            let (step, strip) = (dot(y, &shift.step), dot(y, &shift.strip));
            explained[index] = step * step + strip * strip;
            if (strip < 0.0) == dark && best.is_none_or(|best: usize| explained[index] > explained[best]) {
                let depth = strip / shift.strip_norm;
                (best, best_depth) = (Some(index), depth);
                best_step = (step - depth * shift.strip_on_step) / shift.step_norm;
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
            step: best_step,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of 5 px at a place on a slope, with half of a step to another tile at each edge: pixels average what they cover.
    fn profile(half: usize, centre_px: f64, depth: f64, step: f64) -> Vec<f32> {
        let left_of = |x: f64, edge: f64| (edge - x + 0.5).clamp(0.0, 1.0);
        (0..=2 * half)
            .map(|sample| {
                let x = sample as f64 - half as f64;
                let (before, after) = (left_of(x, centre_px - 2.5), left_of(x, centre_px + 2.5));
                let inside = after - before;
                (4.0 + 0.01 * x + depth * inside + step * (1.0 - after + 0.5 * inside)) as f32
            })
            .collect()
    }

    #[test]
    fn the_centre_is_found_whatever_the_level_the_slope_and_the_step() {
        let half = JointFilter::half_for(5.0, 0.0, 4.0);
        let filter = JointFilter::new(5.0, 0.0, 4.0, half);
        for centre_px in [-2.3, -0.6, 0.0, 0.25, 1.8] {
            for step in [-0.3, 0.0, 0.3] {
                let fit = filter.fit(&profile(half, centre_px, -0.5, step), true, 0.0, 4.0);
                let Some(fit) = fit else { panic!("no strip at {centre_px} px with a step of {step}") };
                assert!((f64::from(fit.shift_px) - centre_px).abs() < 0.06, "{fit:?} at {centre_px}, step {step}");
                assert!((fit.depth + 0.5).abs() < 0.05);
            }
        }
    }

    #[test]
    fn a_strip_of_the_other_polarity_is_none() {
        let half = JointFilter::half_for(5.0, 0.0, 4.0);
        let filter = JointFilter::new(5.0, 0.0, 4.0, half);
        assert!(filter.fit(&profile(half, 0.3, 0.5, 0.0), true, 0.0, 1.0).is_none());
    }

    #[test]
    fn a_single_edge_shows_as_a_step_twice_as_high_as_the_strip_is_deep() {
        // Half of the step at either edge of the strip, and a strip that takes one half back: that is a single edge.
        let half = JointFilter::half_for(5.0, 0.0, 4.0);
        let filter = JointFilter::new(5.0, 0.0, 4.0, half);
        let edge: Vec<f32> = (0..=2 * half).map(|sample| if sample < half { 4.0 } else { 4.5 }).collect();
        let Some(fit) = filter.fit(&edge, true, 0.0, 4.0) else { panic!("an edge passes for one side of a strip") };
        assert!((fit.step / fit.depth).abs() > 1.8, "{fit:?}");
    }
}
