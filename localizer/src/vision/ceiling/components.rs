//! Connected bright areas of an image, with their moments.

/// A connected area of set pixels (with eight neighbours each), described by its first and second moments.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    pub(super) area_px: usize,
    pub(super) centre_px: [f64; 2],
    /// Standard deviations of the pixels of the bright area along its long and its short axis.
    pub(super) axes_px: [f64; 2],
}

impl Component {
    /// Ratio of the area's long axis to its short one; a single row of pixels counts as one pixel wide.
    pub(super) fn aspect(&self) -> f64 {
        self.axes_px[0].max(0.29) / self.axes_px[1].max(0.29)
    }
}

/// Finds all connected areas of set pixels in a binary mask, except those of more than `most_px` pixels. All pixels of the mask are unset afterwards.
pub(super) fn components(mask: &mut [bool], width: usize, most_px: usize) -> Vec<Component> {
    let mut found = Vec::new();
    let mut stack = Vec::new();
    for start in 0..mask.len() {
        if !mask[start] {
            continue;
        }
        mask[start] = false;
        stack.push(start);
        let mut moments = Moments::default();
        while let Some(index) = stack.pop() {
            let (u, v) = (index % width, index / width);
            moments.add(u as f64 - (start % width) as f64, v as f64 - (start / width) as f64);
            for next_v in v.saturating_sub(1)..=v + 1 {
                for next_u in u.saturating_sub(1)..=(u + 1).min(width - 1) {
                    let next = next_v * width + next_u;
                    if next < mask.len() && mask[next] {
                        mask[next] = false;
                        stack.push(next);
                    }
                }
            }
        }
        if moments.count <= most_px {
            found.push(moments.component([(start % width) as f64, (start / width) as f64]));
        }
    }
    found
}

#[derive(Default)]
struct Moments {
    count: usize,
    first: [f64; 2],
    /// Sums of u², v² and u·v over the pixels of a bright area, counted from the area's first pixel.
    second: [f64; 3],
}

impl Moments {
    fn add(&mut self, u: f64, v: f64) {
        self.count += 1;
        self.first[0] += u;
        self.first[1] += v;
        self.second[0] += u * u;
        self.second[1] += v * v;
        self.second[2] += u * v;
    }

    fn component(&self, origin_px: [f64; 2]) -> Component {
        let n = self.count as f64;
        let mean = self.first.map(|sum| sum / n);
        let (uu, vv) = (self.second[0] / n - mean[0] * mean[0], self.second[1] / n - mean[1] * mean[1]);
        let uv = self.second[2] / n - mean[0] * mean[1];
        let spread = (0.25 * (uu - vv).powi(2) + uv * uv).sqrt();
        let axes_px = [0.5 * (uu + vv) + spread, 0.5 * (uu + vv) - spread].map(|variance| variance.max(0.0).sqrt());
        Component { area_px: self.count, centre_px: [0, 1].map(|axis| origin_px[axis] + mean[axis]), axes_px }
    }
}
