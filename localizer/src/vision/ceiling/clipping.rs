//! How far the centroid of an overexposed marker dot may be off.
//!
//! Where a sensor clips at white, it cuts the same amount off every pixel that the dot covers wholly, which shifts nothing. A pixel at the rim, of
//! which the dot covers a share f, should be f times as bright as the middle; it is clipped as well if f exceeds the ratio a of white to the dot's
//! true brightness, and then keeps more than its share. The weight that a rim pixel gains lies between 0 and 1 - a and is as good as random, as the
//! rim falls on the pixels in any way. A disc of radius r has about 2 pi r rim pixels at distance r, and an area of pi r^2: were the gains
//! independent, the centroid's standard deviation would be 0.16 (1 - a) / sqrt(r) along each image axis.

use super::Dot;

/// Growth of the error bound of a dot's centroid, in pixels, with the share of its area that is clipped, with 1 - a, and with the inverse root of its
/// radius in pixels: 3.4 standard deviations of independent gains. Discs of radii from 1.5 to 4 px stay below it up to a hundred times the brightness
/// of white. Larger ones, whose soft rims are clipped too at such brightness, are taken for discs of 4 px.
const PER_CLIPPED: f64 = 0.55;
/// Greatest share of a dot's light that falls outside the window over which it is summed, or that noise hides.
const MISSED_LIGHT: f64 = 0.02;
/// Error of the radius, in pixels, that follows from the distances between a marker's dots.
const RADIUS_ERROR_PX: f64 = 0.02;

/// Widens the bound of a dot of the given radius by what clipping may have shifted its centroid.
pub(super) fn with_clipping(dot: Dot, radius_px: f64) -> Dot {
    let clipped_share = dot.clipped_px * dot.level / dot.flux;
    let shift_px = PER_CLIPPED / radius_px.min(4.0).sqrt() * clipped_share * (1.0 - least_white_share(&dot, radius_px));
    Dot { bound_px: dot.bound_px + shift_px, ..dot }
}

/// Least ratio of the level of white to the true brightness of a dot, both above the background; 1 without clipping, 0 if the true brightness cannot
/// be told.
///
/// The true light of the dot is its brightness L times its area A. The image shows the light F, and of each of its n clipped pixels at most L - W is
/// missing, where W is white: L A <= F + n (L - W), so that L <= (F - n W) / (A - n) for n < A.
fn least_white_share(dot: &Dot, radius_px: f64) -> f64 {
    let area_px = std::f64::consts::PI * (radius_px - RADIUS_ERROR_PX).powi(2);
    let whole_light = (1.0 + MISSED_LIGHT) * dot.flux - dot.clipped_px * dot.level;
    if dot.clipped_px >= area_px {
        return 0.0;
    }
    (dot.level * (area_px - dot.clipped_px) / whole_light).clamp(0.0, 1.0)
}
