//! Matched filter for a joint: a blurred strip of known width, independent of the level, the slope and the step of the background.
//!
//! A profile across a joint between two tiles is modelled as `y(x) = a + b·x + c·step(x − s) + d·strip(x − s)`: `a` and `b` are level and slope of
//! the tiles' brightness, and `d` is the joint's depth. With the blurred unit edge `E` and the joint's width `w`, `step = (E(x + w/2) + E(x − w/2) −
//! 1)/2` (half of the step from tile to tile happens at each edge of the joint) and `strip = E(x + w/2) − E(x − w/2)`. For every shift `s` the four
//! coefficients are a linear fit; the best shift is the one with the smallest residual.

/// Number of shifts of the matched filter tried per pixel. Two suffice, because over half a pixel the fit's residual is a parabola of the shift, even
/// for the sharpest edge.
const SHIFTS_PER_PX: usize = 2;
/// Width of undisturbed tile that a profile contains on either side of the joint, even at the greatest shift: enough to separate level, slope and
/// step of the background from the joint's strip.
const SURROUND_PX: f64 = 5.0;
/// Standard deviation of the blur of an edge in the image without motion, from pixel aperture, interpolation and lens together.
const EDGE_SIGMA_PX: f64 = 0.65;

/// Matched filters for tile joints of one width under one motion blur: one filter for each shift of the joint within a given distance.
pub(super) struct JointFilter {
    /// Half width of the matched filter: it uses the samples of a profile from `-half` to `half` pixels about the middle one.
    pub(super) half: usize,
    /// Greatest shift of the tile joint, in either direction, for which there is a filter.
    reach_px: f64,
    /// Orthonormal basis of the background's level and slope.
    ground: [Vec<f32>; 2],
    shifts: Vec<Shift>,
    /// Norm of that part of the strip's derivative with respect to its position which the filter's other parameters (level, slope, step and depth)
    /// cannot imitate. The standard deviation of a tile joint's measured position is noise / (depth · this norm).
    position_gain: f32,
}

/// The two basis vectors of the matched filter for one shift of the joint: step from tile to tile, and strip of the joint. They are orthonormal to
/// each other and to the background's level and slope.
struct Shift {
    step: Vec<f32>,
    strip: Vec<f32>,
    /// Norms of the filter's basis vectors step and strip before they were scaled to unit length. A joint's depth is the profile's projection on the
    /// strip vector over the strip's norm.
    step_norm: f32,
    strip_norm: f32,
    /// Projection of a strip of unit depth on the normalised step vector. It is needed to find the step's height, because the strip contributes to
    /// that projection, too.
    strip_on_step: f32,
}

/// Best fit of the matched filter to one profile across a tile joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Position of the tile joint's centre relative to the middle sample of the profile.
    pub(super) shift_px: f32,
    /// Brightness of a tile joint above that of the tiles, in units of the profile; negative where the joint is darker than the tiles.
    pub(super) depth: f32,
    /// Height of the step from the tile on one side of the joint to the tile on the other side.
    pub(super) step: f32,
    /// Root mean square of the differences between the profile and the fitted model, per degree of freedom.
    pub(super) residual: f32,
}

impl JointFilter {
    /// Number of samples that the matched filter for a tile joint needs on either side of a profile's middle sample.
    pub(super) fn half_for(width_px: f64, blur_px: f64, reach_px: f64) -> usize {
        (0.5 * (width_px + blur_px) + reach_px + SURROUND_PX).ceil() as usize
    }

    /// The filters for tile joints of a given width under a given blur, for shifts up to `reach_px`, on `2·half + 1` samples.
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

    /// Standard deviation of a tile joint's measured position, for a joint of this depth of contrast under this noise per sample.
    pub(super) fn position_sd_px(&self, depth: f32, noise: f32) -> f32 {
        noise / (depth.abs() * self.position_gain).max(1e-6)
    }

    /// Fits the model of a tile joint to a profile of at least `2·half + 1` samples, of which the middle ones are used. Only shifts within
    /// `within_px` of `around_px` are tried. `None` if the best of them lies at an end of that range, or none shows a strip of the wanted polarity
    /// (`dark` or light).
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
        // A best shift at either end of the searched range is not accepted, because a better one may lie beyond.
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

/// Greatest number of samples of a profile across a tile joint: enough for a joint of 16 px under 24 px of blur.
pub(super) const MAX_SAMPLES: usize = 96;
/// Greatest number of shifts of the tile joint for which a matched filter is kept: enough for shifts within ±12 px.
const MAX_SHIFTS: usize = 64;

/// Brightness profile of an edge of unit height, blurred by uniform motion over `blur_px` and by the optics: 0 far to the left, 1 far to the right.
fn blurred_edge(x: f64, blur_px: f64) -> f64 {
    let z = x / EDGE_SIGMA_PX;
    if blur_px < 0.05 {
        return normal_cdf(z);
    }
    let half = 0.5 * blur_px / EDGE_SIGMA_PX;
    (normal_cdf_integral(z + half) - normal_cdf_integral(z - half)) / (2.0 * half)
}

/// Normal distribution function to within 2·10⁻⁴ (Page 1977). The approximation is point-symmetric about one half, so
/// that filter templates stay symmetric.
fn normal_cdf(z: f64) -> f64 {
    0.5 * (1.0 + (0.797_884_560_8 * (z + 0.044_715 * z * z * z)).tanh())
}

/// Integral of the normal distribution function from −∞: `z·Φ(z) + φ(z)`.
fn normal_cdf_integral(z: f64) -> f64 {
    z * normal_cdf(z) + 0.398_942_280_4 * (-0.5 * z * z).exp()
}

#[inline]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    // Eight running sums let the compiler use vector registers; a single sum would prescribe the order of the additions.
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

/// Subtracts from a vector its projections on orthonormal vectors.
fn remove<const N: usize>(vector: &mut [f32], basis: [&[f32]; N]) {
    for direction in basis {
        let share = dot(vector, direction);
        vector.iter_mut().zip(direction).for_each(|(value, unit)| *value -= share * unit);
    }
}

/// Scales a vector to unit length and returns the length that it had.
fn normalise(vector: &mut [f32]) -> f32 {
    let length = dot(vector, vector).sqrt().max(1e-12);
    vector.iter_mut().for_each(|value| *value /= length);
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test profile across a strip 5 px wide on a sloping background, with half of a step to another tile at each edge of the strip; each pixel
    /// averages the area that it covers.
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
        // A single brightness edge is the sum of two half steps, one at either edge of a strip, and of a strip half as deep that cancels the half
        // step at one of them. So the fitted step is twice as high as the strip is deep.
        let half = JointFilter::half_for(5.0, 0.0, 4.0);
        let filter = JointFilter::new(5.0, 0.0, 4.0, half);
        let edge: Vec<f32> = (0..=2 * half).map(|sample| if sample < half { 4.0 } else { 4.5 }).collect();
        let Some(fit) = filter.fit(&edge, true, 0.0, 4.0) else { panic!("an edge passes for one side of a strip") };
        assert!((fit.step / fit.depth).abs() > 1.8, "{fit:?}");
    }
}
