//! An image whose pixels are real numbers.

use image::GrayImage;

/// An image as an array of pixel values, row-major, height × width.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Number of pixels in a row of the image.
    pub width: usize,
    /// Number of rows of the image.
    pub height: usize,
    /// Pixel values of all rows, the top row first.
    pub values: Vec<f32>,
}

impl Picture {
    /// An image with the same value everywhere.
    pub fn filled(width: usize, height: usize, value: f32) -> Picture {
        Picture { width, height, values: vec![value; width * height] }
    }

    /// The value of the pixel in column `u` and row `v`.
    pub fn at(&self, u: usize, v: usize) -> f32 {
        self.values[v * self.width + u]
    }

    /// The image with a function applied to every value.
    pub fn map(&self, change: impl Fn(f32) -> f32) -> Picture {
        Picture { values: self.values.iter().map(|&value| change(value)).collect(), ..*self }
    }

    /// The image at half resolution: the mean of each 2 × 2 block. An odd last row or column is left out.
    ///
    /// Pixel (u, v) of the result lies at (2u + ½, 2v + ½) of this image.
    pub fn binned(&self) -> Picture {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut values = Vec::with_capacity(width * height);
        for v in 0..height {
            let (top, bottom) = (&self.values[2 * v * self.width..], &self.values[(2 * v + 1) * self.width..]);
            values.extend((0..width).map(|u| 0.25 * (top[2 * u] + top[2 * u + 1] + bottom[2 * u] + bottom[2 * u + 1])));
        }
        Picture { width, height, values }
    }

    /// Value at a position between pixels, interpolated bilinearly. Outside of the image it is the value at the nearest point of the
    /// border, and 0 if the image has no pixels.
    #[inline]
    pub fn between(&self, u_px: f64, v_px: f64) -> f64 {
        if self.values.is_empty() {
            return 0.0;
        }
        let [last_u, last_v] = [self.width, self.height].map(|size| size - 1);
        let (u, v) = (u_px.clamp(0.0, last_u as f64), v_px.clamp(0.0, last_v as f64));
        let (u0, v0) = ((u as usize).min(last_u.saturating_sub(1)), (v as usize).min(last_v.saturating_sub(1)));
        let (du, dv) = (u - u0 as f64, v - v0 as f64);
        let (u1, v1) = ((u0 + 1).min(last_u), (v0 + 1).min(last_v));
        let [a, b, c, d] = [self.at(u0, v0), self.at(u1, v0), self.at(u0, v1), self.at(u1, v1)].map(f64::from);
        (a * (1.0 - du) + b * du) * (1.0 - dv) + (c * (1.0 - du) + d * du) * dv
    }
}

impl From<&GrayImage> for Picture {
    fn from(image: &GrayImage) -> Picture {
        let (width, height) = (image.width() as usize, image.height() as usize);
        Picture { width, height, values: image.as_raw().iter().map(|&level| f32::from(level)).collect() }
    }
}
