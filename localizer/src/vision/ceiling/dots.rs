//! Detects bright marker dots in an infrared image and measures their centroids to less than a tenth of a pixel.

use image::GrayImage;

use super::components::{Component, components};
use super::{CeilingView, Dot, Lens, PictureMotion, lens::Bend};

/// Width of the soft edge of a marker dot's image beyond the dot's radius. The little light that falls farther out is equally strong on all sides of
/// the dot, so that leaving it out does not shift the centroid.
const SOFT_PX: f64 = 1.8;
/// Width of the ring around a marker dot's soft edge, from which the background's grey level is estimated.
const RING_PX: f64 = 1.8;
/// Least difference of grey level between a bright marker dot and its surroundings.
const LEAST_STEP: f64 = 14.0;
/// A marker dot whose centroid has a greater error bound than this is discarded.
const WORST_BOUND_PX: f64 = 0.5;

/// Contributions to the error bound of a marker dot's centroid: a constant in pixels, and a multiple of the standard deviation that the image's noise
/// gives to the centroid.
const FLOOR_PX: f64 = 0.008;
const SIGMAS: f64 = 5.5;
/// Growth of the error bound of a small dot's centroid, in pixels, with the inverse square of the dot's radius in pixels: the window's edge cuts
/// through few pixels, and their rounding does not average out. Sharp noiseless discs of radius 1.2 px are off by up to 0.024 px.
const PER_SMALLNESS: f64 = 0.035;
/// Growth of the error bound of a dot's centroid with structure in the background, such as a lamp's edge: in pixels per pixel of the dot's radius,
/// where structure is what the grey levels around the dot vary beyond noise, as a share of the dot's grey level.
const PER_STRUCTURE: f64 = 1.5;
/// Two contributions to the error bound of a dot's centroid: per pixel of image motion, and per pixel by which motion makes the soft edges of
/// neighbouring dots overlap.
const PER_MOTION: f64 = 0.006;
const PER_OVERLAP: f64 = 0.03;

/// Detects all bright dots of about the expected size in an image.
pub fn detect(image: &GrayImage, view: &CeilingView, motion: &PictureMotion) -> Vec<Dot> {
    let width = image.width() as usize;
    let [least_px, most_px] = view.dot_radius_px;
    let noise = noise_grey(image);
    let most_stretched_px = most_px * view.greatest_stretch([image.width(), image.height()].map(f64::from));
    // The window over which the surroundings' mean grey level is taken is about as wide as two pitches of a marker's grid, so that the marker's own
    // dots cover less than a quarter of it.
    let half = (4.0 * 0.5 * (least_px + most_px)).round().max(5.0) as usize;
    let mut mask = brighter_than_surroundings(image, half, LEAST_STEP.max(5.0 * noise));
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
        .map(|[u, v]| length(motion.at([u * width as f64, v * f64::from(image.height())])));
    let most_motion = corners.into_iter().fold(0.0, f64::max);
    let most_area =
        std::f64::consts::PI * (most_stretched_px + 1.2).powi(2) * 1.2 + 2.0 * (most_stretched_px + 1.0) * most_motion;
    let candidates = components(&mut mask, width, most_area as usize);
    let is_dot = |component: &Component, bend: &Bend| {
        let least_area = (0.4 * std::f64::consts::PI * least_px * least_px * bend.area()).max(4.0);
        let radius_px = (component.area_px as f64 / std::f64::consts::PI).sqrt().max(1.0);
        // The standard deviation of a disc along an axis is half of its radius.
        let motion = length(motion.at(component.centre_px));
        let longest = (0.25 * radius_px * radius_px + motion * motion / 12.0).sqrt() / (0.5 * radius_px);
        component.area_px as f64 >= least_area
            && component.aspect() <= 1.7 * longest * (bend.stretch[1] / bend.stretch[0])
    };
    let measure = |component: &Component| {
        let bend = view.about(component.centre_px).filter(|bend| is_dot(component, bend))?;
        measure(image, component, (view, bend), motion.at(component.centre_px))
    };
    let measured: Vec<Measured> = candidates.iter().filter_map(measure).collect();
    let ring_noise = pooled(measured.iter().map(|one| one.ring)).max(0.3);
    let bounded = |one: Measured| {
        let motion = length(motion.at(one.dot.centre_px));
        one.with_bound(view, motion, ring_noise)
    };
    measured.into_iter().map(bounded).filter(|dot| dot.bound_px < WORST_BOUND_PX).collect()
}

fn length([u, v]: [f64; 2]) -> f64 {
    u.hypot(v)
}

/// A marker dot whose centroid has been measured, with the quantities from which the centroid's error bound is computed later.
struct Measured {
    dot: Dot,
    bend: Bend,
    /// Sum of squares of what a fitted plane leaves of the background's grey levels around a dot, and their number less that of the fitted parameters
    /// (degrees of freedom).
    ring: [f64; 2],
    /// Sum over the pixels around a dot of the squared distance from its centroid, counted along one image axis: once as it is, once with each pixel
    /// weighted by its grey level above the background.
    window_moment: f64,
    grey_moment: f64,
}

impl Measured {
    fn with_bound(self, view: &CeilingView, motion: f64, ring_noise: f64) -> Dot {
        let dot = self.dot;
        // The noise of the background is measured in the image; the dot's own photons add shot noise.
        let variance = ring_noise * ring_noise * self.window_moment + self.grey_moment / view.electrons_per_grey;
        let noise_px = variance.sqrt() / dot.flux;
        let own_ring = (self.ring[0] / self.ring[1].max(1.0)).sqrt();
        let structure = (own_ring - 1.6 * ring_noise).max(0.0) / dot.level;
        // The rims of two neighbouring dots of a marker are two radii apart; where soft edges and motion together are wider, the dots' light
        // overlaps.
        let least_radius_px = view.dot_radius_px[0] * self.bend.stretch[0];
        let overlap = (2.0 * SOFT_PX + motion - 2.0 * least_radius_px).clamp(0.0, motion);
        // The centre of the ellipse as which a circle is seen is not the image of the circle's centre: they differ by r²/f times the slope
        // of the ray against the ceiling's normal.
        let perspective_px = 1.2 * dot.radius_px * dot.radius_px / view.focal_px * view.lean;
        // The pinhole's picture shows a dot as a disc that may be as large as declared.
        let by_lens = |lens: &Lens| lens.centroid_shift_px(self.bend.pinhole_px, view.dot_radius_px[1]);
        let lens_px = view.lens.as_ref().map_or(0.0, by_lens);
        let bound_px = FLOOR_PX
            + PER_SMALLNESS / least_radius_px.powi(2)
            + SIGMAS * noise_px
            + PER_STRUCTURE * structure * dot.radius_px
            + PER_MOTION * motion
            + PER_OVERLAP * overlap
            + perspective_px
            + lens_px;
        Dot { bound_px, ..dot }
    }
}

/// The area over which a moving dot spreads its light during the exposure: all points within the dot's radius of a line segment, whose middle is the
/// origin.
struct Track {
    radius_px: f64,
    /// Half of the dot's motion over the exposure: its length and its direction.
    half_px: f64,
    direction: [f64; 2],
}

impl Track {
    fn new(radius_px: f64, motion_px: [f64; 2]) -> Track {
        let motion = motion_px[0].hypot(motion_px[1]);
        let direction = if motion > 0.0 { motion_px.map(|along| along / motion) } else { [1.0, 0.0] };
        Track { radius_px, half_px: 0.5 * motion, direction }
    }

    fn wider(&self, by_px: f64) -> Track {
        Track { radius_px: self.radius_px + by_px, ..*self }
    }

    /// First column and row, and last column and row, of the pixels that a moving dot's track covers when it is centred at `centre_px`.
    fn extent(&self, centre_px: [f64; 2]) -> [[f64; 2]; 2] {
        let reach = [0, 1].map(|axis| self.radius_px + self.half_px * self.direction[axis].abs());
        [
            [0, 1].map(|axis| (centre_px[axis] - reach[axis]).ceil()),
            [0, 1].map(|axis| (centre_px[axis] + reach[axis]).floor()),
        ]
    }

    /// Whether the whole track of a moving dot lies within the image.
    fn is_within(&self, image: &GrayImage, centre_px: [f64; 2]) -> bool {
        let [low, high] = self.extent(centre_px);
        let size = [image.width(), image.height()].map(f64::from);
        (0..2).all(|axis| low[axis] >= 0.0 && high[axis] < size[axis])
    }

    /// Distance of a point beyond the edge of a moving dot's track; negative inside of the track.
    fn outside_px(&self, du: f64, dv: f64) -> f64 {
        let along = (du * self.direction[0] + dv * self.direction[1]).clamp(-self.half_px, self.half_px);
        (du - along * self.direction[0]).hypot(dv - along * self.direction[1]) - self.radius_px
    }
}

/// Measures the centroid of a dot over the track of its motion. A pixel's weight is its grey level above a plane that is fitted to the ring of
/// background around the track.
fn measure(
    image: &GrayImage,
    component: &Component,
    (view, bend): (&CeilingView, Bend),
    motion_px: [f64; 2],
) -> Option<Measured> {
    let motion = motion_px[0].hypot(motion_px[1]);
    // The area of the track of a dot of radius r with motion m is π r² + 2 r m.
    let area = component.area_px as f64;
    let radius_px = ((motion * motion + std::f64::consts::PI * area).sqrt() - motion) / std::f64::consts::PI;
    let [least_px, most_px] = [0, 1].map(|end| view.dot_radius_px[end] * bend.stretch[end]);
    let radius_px = radius_px.clamp(least_px, most_px + 0.5);
    let window = Track::new(radius_px + SOFT_PX, motion_px);
    let mut centre_px = component.centre_px;
    let mut last = None;
    for _ in 0..3 {
        let plane = ring_plane(image, centre_px, &window)?;
        let found = weigh(image, centre_px, &window, (&plane, bend))?;
        centre_px = found.dot.centre_px;
        last = Some(found);
    }
    last
}

/// Background around a dot as a plane of grey levels, b + gu·du + gv·dv at the distance (du, dv) from the dot's centre.
struct Plane {
    coefficients: [f64; 3],
    squares: f64,
    count: f64,
}

/// Fits a plane to the grey levels of the ring around a dot. Pixels far from the ring's median are left out: they are edges of neighbouring dots.
fn ring_plane(image: &GrayImage, centre_px: [f64; 2], window: &Track) -> Option<Plane> {
    let mut ring: Vec<[f64; 3]> = Vec::with_capacity(64);
    // The ring of background around a dot may be cut off by the image's border.
    for_track(image, centre_px, &window.wider(RING_PX), |du, dv, grey| {
        if window.outside_px(du, dv) > 0.5 {
            ring.push([du, dv, grey]);
        }
    });
    if ring.len() < 12 {
        return None;
    }
    let mut greys: Vec<f64> = ring.iter().map(|[_, _, grey]| *grey).collect();
    greys.sort_by(f64::total_cmp);
    let quantile = |share: f64| greys[(share * (greys.len() - 1) as f64) as usize];
    let (median, low) = (quantile(0.5), quantile(0.16));
    let reach = 4.0 + 4.0 * (median - low);
    ring.retain(|[_, _, grey]| (grey - median).abs() <= reach);
    let mut normal = nalgebra::Matrix3::zeros();
    let mut right = nalgebra::Vector3::zeros();
    for [du, dv, grey] in &ring {
        let row = nalgebra::Vector3::new(1.0, *du, *dv);
        normal += row * row.transpose();
        right += row * *grey;
    }
    let solved = normal.try_inverse()? * right;
    let coefficients = [solved[0], solved[1], solved[2]];
    let residual = |[du, dv, grey]: &[f64; 3]| grey - coefficients[0] - coefficients[1] * du - coefficients[2] * dv;
    let squares = ring.iter().map(|pixel| residual(pixel).powi(2)).sum();
    Some(Plane { coefficients, squares, count: ring.len() as f64 - 3.0 })
}

/// One iteration towards the centroid of a dot: the mean position of the light in a window that is centred at `centre_px`, the previous estimate. The
/// window's edge is soft, so that no pixel enters or leaves it abruptly.
fn weigh(image: &GrayImage, centre_px: [f64; 2], window: &Track, (plane, bend): (&Plane, Bend)) -> Option<Measured> {
    let [base, slope_u, slope_v] = plane.coefficients;
    let (mut flux, mut first, mut clipped) = (0.0, [0.0; 2], 0.0);
    let (mut window_moment, mut grey_moment, mut peak) = (0.0, 0.0, 0.0f64);
    let track = window.wider(0.5);
    if !track.is_within(image, centre_px) {
        return None;
    }
    for_track(image, centre_px, &track, |du, dv, grey| {
        let share = (0.5 - window.outside_px(du, dv)).min(1.0);
        let above = share * (grey - base - slope_u * du - slope_v * dv);
        flux += above;
        first[0] += above * du;
        first[1] += above * dv;
        window_moment += share * 0.5 * (du * du + dv * dv);
        grey_moment += above.max(0.0) * 0.5 * (du * du + dv * dv);
        peak = peak.max(above);
        if grey >= 255.0 {
            clipped += 1.0;
        }
    });
    if flux <= 0.0 || peak < LEAST_STEP {
        return None;
    }
    let area_px = flux / peak;
    let dot = Dot {
        centre_px: [0, 1].map(|axis| centre_px[axis] + first[axis] / flux),
        bound_px: f64::INFINITY,
        radius_px: (area_px / std::f64::consts::PI).sqrt(),
        level: peak,
        flux,
        clipped_px: clipped,
    };
    Some(Measured { dot, bend, ring: [plane.squares, plane.count], window_moment, grey_moment })
}

/// Calls `visit` for all pixels of a moving dot's track that lie in the image, with their position relative to the
/// track's middle and their grey level.
fn for_track(image: &GrayImage, centre_px: [f64; 2], track: &Track, mut visit: impl FnMut(f64, f64, f64)) {
    let width = image.width() as usize;
    let size = [image.width(), image.height()].map(f64::from);
    let [low, high] = track.extent(centre_px);
    let (low, high) = (low.map(|low| low.max(0.0)), [0, 1].map(|axis| high[axis].min(size[axis] - 1.0)));
    if (0..2).any(|axis| low[axis] > high[axis]) {
        return;
    }
    let pixels = image.as_raw();
    for v in low[1] as usize..=high[1] as usize {
        for u in low[0] as usize..=high[0] as usize {
            let (du, dv) = (u as f64 - centre_px[0], v as f64 - centre_px[1]);
            if track.outside_px(du, dv) <= 0.0 {
                visit(du, dv, f64::from(pixels[v * width + u]));
            }
        }
    }
}

/// Standard deviation of noise, from several groups of values that are each given as a sum of squares and a count. The median of the groups' mean
/// squares is used, so that a few disturbed groups do not matter.
fn pooled(samples: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut squares: Vec<f64> = samples.filter(|sample| sample[1] > 0.0).map(|sample| sample[0] / sample[1]).collect();
    squares.sort_by(f64::total_cmp);
    squares.get(squares.len() / 2).copied().unwrap_or(0.0).sqrt()
}

/// Standard deviation of the image's noise, from differences of neighbouring pixels. It takes their median, so that edges do not matter.
fn noise_grey(image: &GrayImage) -> f64 {
    let mut histogram = [0usize; 256];
    let pixels = image.as_raw();
    let mut count = 0;
    // Every 37th pair of pixels suffices, and 37 does not divide the length of usual rows, so that no column is preferred.
    for pair in pixels.windows(2).step_by(37) {
        histogram[usize::from(pair[0].abs_diff(pair[1]))] += 1;
        count += 1;
    }
    let mut below = 0;
    let median = histogram.iter().position(|number| {
        below += number;
        2 * below >= count
    });
    // The median of |a − b| for two normally distributed numbers is 0.954 of their standard deviation; half a grey level is added for the rounding.
    (median.unwrap_or(0) as f64 + 0.5) / 0.954
}

/// A mask of the pixels that are brighter, by more than `step`, than the mean over the square around them, whose side has 2·half + 1 pixels.
fn brighter_than_surroundings(image: &GrayImage, half: usize, step: f64) -> Vec<bool> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixels = image.as_raw();
    // The sums over the squares are updated as running sums, down the columns and then along the row: two additions a pixel.
    let mut columns = vec![0u32; width];
    let add_row = |columns: &mut [u32], row: usize| {
        columns.iter_mut().zip(&pixels[row * width..]).for_each(|(sum, grey)| *sum += u32::from(*grey));
    };
    let drop_row = |columns: &mut [u32], row: usize| {
        columns.iter_mut().zip(&pixels[row * width..]).for_each(|(sum, grey)| *sum -= u32::from(*grey));
    };
    (0..half.min(height)).for_each(|row| add_row(&mut columns, row));
    let mut mask = vec![false; width * height];
    for row in 0..height {
        if row + half < height {
            add_row(&mut columns, row + half);
        }
        if row > half {
            drop_row(&mut columns, row - half - 1);
        }
        let rows = (row + half).min(height - 1) - row.saturating_sub(half) + 1;
        let mut sum: u32 = columns[..half.min(width)].iter().sum();
        for column in 0..width {
            if column + half < width {
                sum += columns[column + half];
            }
            if column > half {
                sum -= columns[column - half - 1];
            }
            let count = rows * ((column + half).min(width - 1) - column.saturating_sub(half) + 1);
            let grey = f64::from(pixels[row * width + column]);
            mask[row * width + column] = (grey - step) * count as f64 > f64::from(sum);
        }
    }
    mask
}

#[cfg(test)]
mod tests;
