//! A picture of real numbers.

use image::GrayImage;

/// Values of pixels, row-major, height × width.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// All rows, the top one first.
    pub values: Vec<f32>,
}

impl Picture {
    /// A picture of one value.
    pub fn filled(width: usize, height: usize, value: f32) -> Picture {
        Picture { width, height, values: vec![value; width * height] }
    }

    /// The value of a pixel.
    pub fn at(&self, u: usize, v: usize) -> f32 {
        self.values[v * self.width + u]
    }

    /// Every value replaced.
    pub fn map(&self, change: impl Fn(f32) -> f32) -> Picture {
        Picture { values: self.values.iter().map(|&value| change(value)).collect(), ..*self }
    }

    /// The mean of each 2 × 2 block; an odd last row or column is left out.
    ///
    /// Pixel (u, v) of the answer lies at (2u + ½, 2v + ½).
    pub fn binned(&self) -> Picture {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut values = Vec::with_capacity(width * height);
        for v in 0..height {
            let (top, bottom) = (&self.values[2 * v * self.width..], &self.values[(2 * v + 1) * self.width..]);
            values.extend((0..width).map(|u| 0.25 * (top[2 * u] + top[2 * u + 1] + bottom[2 * u] + bottom[2 * u + 1])));
        }
        Picture { width, height, values }
    }

    /// The value between pixels, bilinear; the border's outside of the picture.
    pub fn between(&self, u_px: f64, v_px: f64) -> f64 {
        let u = u_px.clamp(0.0, (self.width - 1) as f64);
        let v = v_px.clamp(0.0, (self.height - 1) as f64);
        let (u0, v0) = ((u as usize).min(self.width.max(2) - 2), (v as usize).min(self.height.max(2) - 2));
        let (du, dv) = (u - u0 as f64, v - v0 as f64);
        let [a, b, c, d] =
            [self.at(u0, v0), self.at(u0 + 1, v0), self.at(u0, v0 + 1), self.at(u0 + 1, v0 + 1)].map(f64::from);
        (a * (1.0 - du) + b * du) * (1.0 - dv) + (c * (1.0 - du) + d * du) * dv
    }
}

impl From<&GrayImage> for Picture {
    fn from(image: &GrayImage) -> Picture {
        let (width, height) = (image.width() as usize, image.height() as usize);
        Picture { width, height, values: image.as_raw().iter().map(|&level| f32::from(level)).collect() }
    }
}
