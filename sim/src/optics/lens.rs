//! A lens before a sensor: projection with distortion, and its inverse.

use crate::scene::Band;

/// A lens before a sensor: its projection, and what else it does to the light (vignetting, defocus, filter), with the times at which the rows are
/// exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Width and height of the image.
    pub size_px: [u32; 2],
    /// Focal lengths of the lens along the image axes u and v.
    pub focal_px: [f64; 2],
    /// Principal point, where the optical axis meets the image.
    pub principal_point_px: [f64; 2],
    /// Distortion coefficients k1, k2, p1, p2, k3 of Brown and Conrady.
    pub distortion: [f64; 5],
    /// Whether the image darkens away from its middle by the fourth power of the cosine of the angle off the optical axis.
    pub vignetting: bool,
    /// Diameter of the disc into which defocus blurs a point.
    pub defocus_px: f64,
    /// Time from the start of one row's exposure to the start of the next row's.
    pub row_time_s: f64,
    /// Band of wavelengths that passes the filter before the sensor.
    pub band: Band,
    /// Intensity of the ring of light-emitting diodes around the lens, in equivalent candela of the infrared band; 0 without a ring.
    pub ring_candela: f64,
}

impl Lens {
    /// An ideal lens with one focal length, whose principal point is the middle of the image, without distortion and vignetting.
    pub fn ideal(size_px: [u32; 2], focal_px: f64) -> Lens {
        Lens {
            size_px,
            focal_px: [focal_px; 2],
            principal_point_px: size_px.map(|size| (f64::from(size) - 1.0) / 2.0),
            distortion: [0.0; 5],
            vignetting: false,
            defocus_px: 0.0,
            row_time_s: 0.0,
            band: Band::Visible,
            ring_candela: 0.0,
        }
    }

    /// Time after the stamp of an image, which is that of its middle row, at which a row is exposed; negative above the middle row.
    pub fn after_stamp_s(&self, v_px: f64) -> f64 {
        (v_px - 0.5 * f64::from(self.size_px[1] - 1)) * self.row_time_s
    }

    /// Time from the start of the first row's exposure to the start of the last row's.
    pub fn readout_s(&self) -> f64 {
        self.row_time_s * f64::from(self.size_px[1] - 1)
    }

    /// Whether the lens distorts the image that a pinhole would give.
    pub fn bends(&self) -> bool {
        self.distortion != [0.0; 5]
    }

    /// Pixel at which the lens shows a point `[x, y]` of the plane at depth 1. The distorted point (Brown 1966, in OpenCV's terms) is x' = x·(1 +
    /// k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2x²), and y' likewise with p1 and p2 exchanged; focal lengths and principal point make it a
    /// pixel.
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let bent = [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        [0, 1].map(|axis| self.focal_px[axis] * bent[axis] + self.principal_point_px[axis])
    }

    /// Distortion coefficients of another lens, which differs from this one in k1 only. What it shows at the farthest corner of the image lies
    /// `off_px` farther out than through this lens, and everything else less far out.
    pub fn bent_further(&self, off_px: f64) -> [f64; 5] {
        /// Number of iterations for k1. Which points the corners of the image show changes with k1, by a share of `off_px` over the corner's distance
        /// from the middle; each iteration multiplies the error by that share.
        const STEPS: usize = 6;
        let [k1, k2, p1, p2, k3] = self.distortion;
        let mut bent = self.clone();
        for _ in 0..if off_px == 0.0 { 0 } else { STEPS } {
            let off_by_k1_px = |[x, y]: [f64; 2]| (self.focal_px[0] * x).hypot(self.focal_px[1] * y) * (x * x + y * y);
            let most_px = bent.corners().into_iter().map(off_by_k1_px).fold(0.0, f64::max);
            if most_px > 0.0 {
                bent.distortion[0] = k1 + off_px / most_px;
            }
        }
        [bent.distortion[0], k2, p1, p2, k3]
    }

    /// The points in the plane at depth 1 that the four corners of the image show. Corners where the distortion polynomial folds back are left out.
    pub fn corners(&self) -> Vec<[f64; 2]> {
        let [width, height] = self.size_px.map(f64::from);
        let corners = [[-0.5, -0.5], [width - 0.5, -0.5], [-0.5, height - 0.5], [width - 0.5, height - 0.5]];
        corners.into_iter().filter_map(|corner| self.ray(corner)).collect()
    }

    /// Point in the plane at depth 1 that a pixel shows, by Newton's method; `None` where the distortion polynomial folds back.
    pub fn ray(&self, pixel: [f64; 2]) -> Option<[f64; 2]> {
        let pinhole = [0, 1].map(|axis| (pixel[axis] - self.principal_point_px[axis]) / self.focal_px[axis]);
        let mut at = pinhole;
        for _ in 0..30 {
            let seen = self.pixel(at);
            let off = [seen[0] - pixel[0], seen[1] - pixel[1]];
            if off[0].hypot(off[1]) < 1e-7 {
                return Some(at);
            }
            let [[a, b], [c, d]] = self.slope(at);
            let determinant = a * d - b * c;
            if determinant <= 0.0 {
                return None;
            }
            at = [at[0] - (d * off[0] - b * off[1]) / determinant, at[1] - (a * off[1] - c * off[0]) / determinant];
        }
        None
    }

    /// Derivative ∂pixel/∂point of the projection of a point in the plane at depth 1, row by row.
    fn slope(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let growth = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let mixed = x * y * growth + 2.0 * p1 * x + 2.0 * p2 * y;
        let [fu, fv] = self.focal_px;
        [
            [fu * (radial + x * x * growth + 2.0 * p1 * y + 6.0 * p2 * x), fu * mixed],
            [fv * mixed, fv * (radial + y * y * growth + 6.0 * p1 * y + 2.0 * p2 * x)],
        ]
    }
}
