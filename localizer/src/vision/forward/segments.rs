//! Finds straight edges as regions of pixels whose gradients have similar directions, after LSD (Grompone von Gioi et al., PAMI 2010).
//!
//! LSD's test for meaningful regions is replaced by a threshold on the gradient, which is possible because the noise is the same everywhere.

use super::Picture;

/// Least gradient, per pixel, that is not caused by noise: in an image whose noise was made equal everywhere and that was filtered.
pub const NOISE_FLOOR: f32 = 0.08;
/// Cosine of the greatest difference between the gradient directions of a region: 22.5°, the value of LSD.
const ANGLE_TOLERANCE_COS: f32 = 0.923_879_5;
/// Least number of pixels of a region that can become a segment.
const FEWEST_PIXELS: usize = 14;
/// Least ratio of a region's length to its width.
const ELONGATION: f64 = 4.0;

/// A straight edge found in an image, as a line segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// First and last point of the segment, each `[u, v]`.
    pub ends_px: [[f64; 2]; 2],
}

impl Segment {
    /// Length of the segment: the distance between its ends.
    pub fn length_px(&self) -> f64 {
        let [a, b] = self.ends_px;
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    /// Unit vector from the segment's first end to its last.
    pub fn along(&self) -> [f64; 2] {
        let ([a, b], length) = (self.ends_px, self.length_px());
        [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
    }

    /// A segment found in an image at half resolution, converted to pixels of the image at full resolution.
    pub fn unbinned(&self) -> Segment {
        Segment { ends_px: self.ends_px.map(|end| end.map(|at| 2.0 * at + 0.5)) }
    }

    /// The segment shortened by `by_px` at either end; `None` when nothing is left of it.
    pub fn trimmed(&self, by_px: f64) -> Option<Segment> {
        let ([a, b], along) = (self.ends_px, self.along());
        (self.length_px() > 2.0 * by_px).then(|| Segment {
            ends_px: [
                [a[0] + by_px * along[0], a[1] + by_px * along[1]],
                [b[0] - by_px * along[0], b[1] - by_px * along[1]],
            ],
        })
    }

    /// The part of the segment that keeps a distance of `border_px` from the image's border; `None` when there is no such part.
    pub fn within(&self, width: usize, height: usize, border_px: f64) -> Option<Segment> {
        let [a, b] = self.ends_px;
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (axis, size) in [width, height].into_iter().enumerate() {
            let (least, greatest) = (border_px, size as f64 - 1.0 - border_px);
            // An image this narrow has no inside: all of its pixels belong to the border.
            if least > greatest {
                return None;
            }
            let step = b[axis] - a[axis];
            if step == 0.0 {
                if !(least..=greatest).contains(&a[axis]) {
                    return None;
                }
                continue;
            }
            let crossings = [(least - a[axis]) / step, (greatest - a[axis]) / step];
            from = from.max(crossings[0].min(crossings[1]));
            to = to.min(crossings[0].max(crossings[1]));
        }
        let at = |share: f64| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        (from < to).then(|| Segment { ends_px: [at(from), at(to)] })
    }
}

/// All segments of an image whose gradient exceeds `least_gradient`; regions grow from the pixels with the strongest gradient first.
pub fn segments(picture: &Picture, least_gradient: f32) -> Vec<Segment> {
    let field = Gradients::of(picture);
    let mut seeds: Vec<u32> =
        (0..field.strength.len() as u32).filter(|&at| field.strength[at as usize] > least_gradient).collect();
    seeds.sort_by(|&a, &b| field.strength[b as usize].total_cmp(&field.strength[a as usize]).then(a.cmp(&b)));
    let mut taken: Vec<bool> = field.strength.iter().map(|&strength| strength <= least_gradient).collect();
    let mut found = Vec::new();
    for seed in seeds {
        if taken[seed as usize] {
            continue;
        }
        let region = field.grow(seed as usize, &mut taken);
        if region.len() >= FEWEST_PIXELS {
            found.extend(field.fit(&region));
        }
    }
    found
}

/// Gradients of 2 × 2 blocks of pixels; block (u, v) is centred at (u + ½, v + ½).
struct Gradients {
    width: usize,
    strength: Vec<f32>,
    /// Gradient of each block of 2 × 2 pixels, along u and along v.
    gradient: Vec<[f32; 2]>,
}

impl Gradients {
    fn of(picture: &Picture) -> Gradients {
        // An image of a single row or column has no block of 2 × 2 pixels.
        let (width, height) = (picture.width.saturating_sub(1), picture.height.saturating_sub(1));
        let mut gradient = Vec::with_capacity(width * height);
        for v in 0..height {
            let (top, bottom) = (&picture.values[v * picture.width..], &picture.values[(v + 1) * picture.width..]);
            gradient.extend((0..width).map(|u| {
                let (a, b, c, d) = (top[u], top[u + 1], bottom[u], bottom[u + 1]);
                [0.5 * (b + d - a - c), 0.5 * (c + d - a - b)]
            }));
        }
        let strength = gradient.iter().map(|[du, dv]| (du * du + dv * dv).sqrt()).collect();
        Gradients { width, strength, gradient }
    }

    /// Grows a region from a seed pixel: neighbours, and neighbours of these, are added if their gradient has about the direction of the region's.
    fn grow(&self, seed: usize, taken: &mut [bool]) -> Vec<usize> {
        let mut region = vec![seed];
        taken[seed] = true;
        let unit = |at: usize| self.gradient[at].map(|part| part / self.strength[at]);
        let [mut cos, mut sin] = unit(seed);
        let height = self.strength.len() / self.width;
        let mut next = 0;
        while let Some(&at) = region.get(next) {
            next += 1;
            let (u, v) = (at % self.width, at / self.width);
            let least = ANGLE_TOLERANCE_COS * (cos * cos + sin * sin).sqrt();
            let (mean_cos, mean_sin) = (cos, sin);
            for row in v.saturating_sub(1)..=(v + 1).min(height - 1) {
                for column in u.saturating_sub(1)..=(u + 1).min(self.width - 1) {
                    let other = row * self.width + column;
                    if taken[other] {
                        continue;
                    }
                    let [c, s] = unit(other);
                    if c * mean_cos + s * mean_sin < least {
                        continue;
                    }
                    taken[other] = true;
                    region.push(other);
                    (sin, cos) = (sin + s, cos + c);
                }
            }
        }
        region
    }

    /// Fits a segment to a region of pixels with similar gradient direction: along the region's main axis, with pixels weighted by their gradient,
    /// from the first pixel to the last. `None` for a region that is not elongated.
    fn fit(&self, region: &[usize]) -> Option<Segment> {
        let place = |at: usize| [(at % self.width) as f64 + 0.5, (at / self.width) as f64 + 0.5];
        let (mut total, mut mean) = (0.0, [0.0; 2]);
        for &at in region {
            let (weight, [u, v]) = (f64::from(self.strength[at]), place(at));
            total += weight;
            mean = [mean[0] + weight * u, mean[1] + weight * v];
        }
        let mean = mean.map(|sum| sum / total);
        let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
        for &at in region {
            let (weight, [u, v]) = (f64::from(self.strength[at]) / total, place(at));
            let (du, dv) = (u - mean[0], v - mean[1]);
            (uu, uv, vv) = (uu + weight * du * du, uv + weight * du * dv, vv + weight * dv * dv);
        }
        let (sin, cos) = (0.5 * (2.0 * uv).atan2(uu - vv)).sin_cos();
        let across = uu * sin * sin - 2.0 * uv * sin * cos + vv * cos * cos;
        let along = uu * cos * cos + 2.0 * uv * sin * cos + vv * sin * sin;
        if along < ELONGATION * ELONGATION * across {
            return None;
        }
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for &at in region {
            let [u, v] = place(at);
            let on = (u - mean[0]) * cos + (v - mean[1]) * sin;
            (least, greatest) = (least.min(on), greatest.max(on));
        }
        let at = |on: f64| [mean[0] + on * cos, mean[1] + on * sin];
        Some(Segment { ends_px: [at(least), at(greatest)] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_that_is_all_border_has_no_inside() {
        let level = Segment { ends_px: [[0.0, 10.0], [100.0, 11.0]] };
        // By hand: 14 px of border above and below leave nothing of 20 rows, and of 40 rows the rows 14 to 25, which the segment does not reach.
        assert_eq!(level.within(200, 20, 14.0), None);
        assert_eq!(level.within(200, 40, 14.0), None);
        // With a border of 9.5 px, v = 9.5 to 10.5 remains of 21 rows. The segment is at 10.5 half-way, where u = 50.
        let inside = level.within(101, 21, 9.5).map(|part| part.ends_px);
        assert_eq!(inside.map(|ends_px| ends_px.map(|end| end[0])), Some([9.5, 50.0]));
    }
}
