//! Reads markers from dots: finds triples of corner dots, the grid that they span, and the dots on that grid.
//!
//! A marker is read only if nothing about it is doubtful: three corners at right angles, every bright dot in the marker's area on its grid,
//! every empty place dark, dots of equal brightness, and an identity that the code contains. Anything else is refused: a marker that is not
//! read costs little, a wrong one costs the guarantee.

use image::GrayImage;

use super::clipping::with_clipping;
use super::confidence::confidence;
use super::{CeilingMarkers, CeilingView, Dot, SeenMarker, lens::Bend};
use crate::markers::{EMPTY_CORNER, GRID, GridPlace, MarkerId};

/// Least radius of the image of a marker's dots. The rims of neighbouring dots are two radii apart; if that is less than 3 px, soft edges of one dot
/// fall into the window over which the light of the next is summed, and shift its centroid by more than its bound.
pub const LEAST_RADIUS_PX: f64 = 1.5;
/// Greatest distance, in pitches of the grid, of a dot from its place on the grid that a marker's corner dots span.
const OFF_GRID: f64 = 0.2;
/// A dot counts as part of a marker up to this distance beyond the edge of the marker's grid, in pitches.
const MARGIN: f64 = 0.6;
/// Greatest relative difference of a dot's flux (summed grey levels) from the median flux of its marker's dots; with a greater one the marker is
/// refused.
const FLUX_SPREAD: f64 = 0.3;
/// Up to this share, a difference of a dot's flux (summed grey levels) from the median of its marker may come from light that falls off over the
/// marker. A greater difference is taken to mean that part of the dot's area is missing.
const UNEVEN_FLUX: f64 = 0.04;
/// Up to this share, a difference of a dot's flux (summed grey levels) from the flux that the marker's other dots predict is taken for noise and does
/// not widen the dot's bound. For a radius of 4 pixels such a difference shifts the centroid by less than a hundredth of a pixel.
const FLUX_NOISE: f64 = 0.0015;
/// A place of the marker's grid that has no dot must not be brighter, above its background, than this share of the dots' grey level.
const EMPTY_LEVEL: f64 = 0.3;
/// Greatest distance of a marker dot from the best-fitting affine grid, in addition to the dots' error bounds and the effect of perspective.
const MISFIT_PX: f64 = 0.12;

/// A dot, and what the lens does about it.
#[derive(Clone, Copy)]
struct Sight {
    dot: Dot,
    bend: Bend,
}

impl Sight {
    fn pinhole_px(&self) -> [f64; 2] {
        self.bend.pinhole_px
    }

    /// Sum of the dot's grey levels that a pinhole would show: a lens spreads light over more or less area.
    fn flux(&self) -> f64 {
        self.dot.flux / self.bend.area()
    }
}

/// Reads every marker that the detected dots form.
pub fn read(image: &GrayImage, dots: &[Dot], view: &CeilingView, is_word: &[bool]) -> CeilingMarkers {
    let mut found = CeilingMarkers::default();
    let sight = |dot: &Dot| view.about(dot.centre_px).map(|bend| Sight { dot: *dot, bend });
    let sights: Vec<Sight> = dots.iter().filter_map(sight).collect();
    let mut taken = vec![false; sights.len()];
    for corners in corner_triples(&sights, view) {
        let [_, x, y] = corners.map(|index| sights[index].dot.centre_px);
        match read_grid(image, &sights, view, corners) {
            Some((marker, members)) if is_word.get(usize::from(marker.id.0)) == Some(&true) => {
                // A dot that would belong to two markers is assigned to neither: both are rejected.
                if members.iter().any(|index| taken[*index]) {
                    found.markers.retain(|other| !shares_dot(other, &marker));
                    found.rejected_px.push([x[0], x[1], y[0], y[1]]);
                } else {
                    found.markers.push(marker);
                }
                members.iter().for_each(|index| taken[*index] = true);
            }
            Some(_) => found.rejected_px.push([x[0], x[1], y[0], y[1]]),
            // Most triples of dots are no corners of a marker and are passed over silently. Only a triple with a right angle at its middle dot O may
            // be a damaged marker and is recorded as rejected.
            None if is_square(corners.map(|index| sights[index].pinhole_px())) => {
                found.rejected_px.push([x[0], x[1], y[0], y[1]]);
            }
            None => {}
        }
    }
    found
}

fn shares_dot(one: &SeenMarker, other: &SeenMarker) -> bool {
    one.dots.iter().any(|(_, dot)| other.dots.iter().any(|(_, second)| dot.centre_px == second.centre_px))
}

fn is_square([o, x, y]: [[f64; 2]; 3]) -> bool {
    let (a, b) = (minus(x, o), minus(y, o));
    (a[0] * b[0] + a[1] * b[1]).abs() < 0.1 * norm(a) * norm(b)
}

/// Triples of dots that may be three corners of a marker: O at the right angle, X and Y at the ends of the two sides. Both sides are three pitches
/// long and at right angles, as far as perspective allows.
///
/// Which of the two end dots is X follows from the sense of rotation: seen from below, the turn from side OX to side OY is clockwise, which is a
/// positive cross product with v down (Eq. 4 of paper 5 gives the wrong axis for half of all headings, erratum I2).
fn corner_triples(dots: &[Sight], view: &CeilingView) -> Vec<[usize; 3]> {
    // A pitch of the marker's grid is four dot radii, and a side is three pitches long.
    let side_px = [0, 1].map(|end| 12.0 * view.dot_radius_px[end]);
    let mut triples = Vec::new();
    for o in 0..dots.len() {
        let sides: Vec<(usize, [f64; 2])> = (0..dots.len())
            .filter(|&index| index != o)
            .map(|index| (index, minus(dots[index].pinhole_px(), dots[o].pinhole_px())))
            .filter(|(_, side)| (side_px[0]..=side_px[1]).contains(&norm(*side)))
            .collect();
        for (position, &(a, side_a)) in sides.iter().enumerate() {
            for &(b, side_b) in &sides[position + 1..] {
                let (length_a, length_b) = (norm(side_a), norm(side_b));
                let cosine = (side_a[0] * side_b[0] + side_a[1] * side_b[1]) / (length_a * length_b);
                let skew = 0.1 + view.lean;
                if cosine.abs() > skew || (length_a - length_b).abs() > skew * length_a.max(length_b) {
                    continue;
                }
                triples.push(if cross(side_a, side_b) > 0.0 { [o, a, b] } else { [o, b, a] });
            }
        }
    }
    triples
}

/// Reads the marker whose corner dots O, X, Y are given by their indices; also returns the indices of all dots that form the marker. `None` if
/// anything about it is doubtful.
fn read_grid(
    image: &GrayImage,
    dots: &[Sight],
    view: &CeilingView,
    [o, x, y]: [usize; 3],
) -> Option<(SeenMarker, Vec<usize>)> {
    let origin = dots[o].pinhole_px();
    let step =
        [minus(dots[x].pinhole_px(), origin), minus(dots[y].pinhole_px(), origin)].map(|[u, v]| [u / 3.0, v / 3.0]);
    let determinant = cross(step[0], step[1]);
    // A pitch of the marker's grid is four dot radii.
    let shrunk = dots[o].bend.stretch[0];
    if step.iter().any(|pitch| shrunk * norm(*pitch) < 4.0 * LEAST_RADIUS_PX) {
        return None;
    }
    let radius_px = 0.25 * determinant.abs().sqrt();
    let mut members: Vec<(GridPlace, usize)> = Vec::new();
    for (index, dot) in dots.iter().enumerate() {
        let away = minus(dot.pinhole_px(), origin);
        let place = [cross(away, step[1]) / determinant, cross(step[0], away) / determinant];
        if place.iter().any(|along| !(-MARGIN..=f64::from(GRID - 1) + MARGIN).contains(along)) {
            continue;
        }
        let nearest = place.map(f64::round);
        let off = norm(minus(place, nearest));
        if off > OFF_GRID || nearest.iter().any(|along| !(0.0..=3.0).contains(along)) {
            return None;
        }
        members.push((nearest.map(|along| along as u8), index));
    }
    members.sort_unstable();
    if members.windows(2).any(|pair| pair[0].0 == pair[1].0) || members.iter().any(|(place, _)| *place == EMPTY_CORNER)
    {
        return None;
    }
    let median_flux = median(members.iter().map(|(_, index)| dots[*index].flux()));
    let median_level = median(members.iter().map(|(_, index)| dots[*index].dot.level));
    let is_equal = |flux: f64| (flux / median_flux - 1.0).abs() <= FLUX_SPREAD;
    if !members.iter().all(|(_, index)| is_equal(dots[*index].flux())) {
        return None;
    }
    let seen = |place: GridPlace| members.iter().any(|(member, _)| *member == place);
    for place in (0..GRID).flat_map(|i| (0..GRID).map(move |j| [i, j])) {
        let at =
            [0, 1].map(|axis| origin[axis] + f64::from(place[0]) * step[0][axis] + f64::from(place[1]) * step[1][axis]);
        // The whole grid must lie in the image, so that a dot beyond the image's edge is not taken for one that is missing.
        let brightness = disc_mean(image, view.bent_px(at), 0.6 * view.dot_radius_px[0] * shrunk)?;
        let surroundings = dots[o].dot.level.min(median_level);
        if !seen(place) && brightness > background(image, at, step, view) + EMPTY_LEVEL * surroundings {
            return None;
        }
    }
    let id = MarkerId::from_dots(members.iter().map(|(place, _)| *place));
    let placed: Vec<(GridPlace, Sight)> = members
        .iter()
        .map(|(place, index)| {
            let sight = dots[*index];
            (*place, Sight { dot: with_clipping(sight.dot, radius_px * sight.bend.area().sqrt()), ..sight })
        })
        .collect();
    if !fits_grid(&placed, view) {
        return None;
    }
    let grown = with_missing_area(&placed);
    let confidence = confidence(grown.iter().flat_map(|(_, dot)| disc_greys(image, dot.centre_px, dot.radius_px)));
    Some((SeenMarker { id, dots: grown, confidence }, members.into_iter().map(|(_, index)| index).collect()))
}

/// Widens the bounds of a marker's dots for area that may be missing from a dot, for example because it is scratched. A dot that lacks a share s of
/// its area may have its centroid off by up to r·s/(1 − s), because no part of the dot is farther than its radius r from its centre.
///
/// Light falls off evenly over a marker, so that a plane through the fluxes (summed grey levels) of the other dots predicts the flux of a whole dot:
/// with the residual e from the plane through all dots and the leverage h, the dot's flux differs by e/(1 − h) from that prediction. If a single dot
/// is damaged, its missing flux is found in full; it makes the bounds of the other dots wider, never narrower.
fn with_missing_area(dots: &[(GridPlace, Sight)]) -> Vec<(GridPlace, Dot)> {
    let row = |place: GridPlace| nalgebra::Vector3::new(1.0, f64::from(place[0]), f64::from(place[1]));
    let (mut normal, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for (place, dot) in dots {
        normal += row(*place) * row(*place).transpose();
        right += row(*place) * dot.flux();
    }
    let inverse = normal.try_inverse().unwrap_or_default();
    let plane = inverse * right;
    let foretold = |place: GridPlace, flux: f64| {
        let row = row(place);
        let leverage = (row.transpose() * inverse * row)[0];
        // A plane through the fluxes of three dots fits any values, so that only a comparison with the median flux can show a damaged dot.
        if leverage > 0.95 { None } else { Some(flux - (flux - row.dot(&plane)) / (1.0 - leverage)) }
    };
    let usual = median(dots.iter().map(|(_, dot)| dot.flux()));
    let grown = |(place, sight): &(GridPlace, Sight)| {
        let (dot, flux) = (sight.dot, sight.flux());
        let whole = foretold(*place, flux).filter(|flux| *flux > 0.0).unwrap_or(usual);
        // If a whole row of the marker's dots is damaged, the plane through their fluxes does not show it, but a comparison with the median flux
        // does.
        let from_usual = (1.0 - flux / usual).abs();
        let unusual = if from_usual > UNEVEN_FLUX { from_usual } else { 0.0 };
        let share = ((1.0 - flux / whole).abs() - FLUX_NOISE).max(unusual).clamp(0.0, 0.9);
        (*place, Dot { bound_px: dot.bound_px + dot.radius_px * share / (1.0 - share), ..dot })
    };
    dots.iter().map(grown).collect()
}

/// Whether a marker's dots lie on one affine grid, within their error bounds and what the perspective of a leaning camera adds.
fn fits_grid(dots: &[(GridPlace, Sight)], view: &CeilingView) -> bool {
    if dots.len() == 3 {
        return true;
    }
    let mut normal = nalgebra::Matrix3::zeros();
    let mut right = nalgebra::Matrix3x2::zeros();
    for (place, dot) in dots {
        let row = nalgebra::Vector3::new(1.0, f64::from(place[0]), f64::from(place[1]));
        normal += row * row.transpose();
        right += row * nalgebra::RowVector2::from(dot.pinhole_px());
    }
    let Some(inverse) = normal.try_inverse() else { return false };
    let grid = inverse * right;
    // Half of a marker is 6 dot radii long; perspective bends its grid by the square of that over the focal length.
    let bend_px = (6.0 * view.dot_radius_px[1]).powi(2) / view.focal_px * (view.lean + 0.02) * 2.0;
    dots.iter().all(|(place, sight)| {
        let (at_px, bound_px) = (sight.pinhole_px(), sight.dot.bound_px / sight.bend.stretch[0]);
        let row = nalgebra::RowVector3::new(1.0, f64::from(place[0]), f64::from(place[1]));
        let fitted = row * grid;
        (0..2).all(|axis| (fitted[axis] - at_px[axis]).abs() <= 2.0 * bound_px + MISFIT_PX + bend_px)
    })
}

/// Median of the mean grey levels half-way to the four diagonal neighbours of a grid place: these points are as far
/// from all dots as is possible on the grid.
fn background(image: &GrayImage, at: [f64; 2], step: [[f64; 2]; 2], view: &CeilingView) -> f64 {
    let mut greys: Vec<f64> = Vec::with_capacity(4);
    for (i, j) in [(0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)] {
        let between = [0, 1].map(|axis| at[axis] + i * step[0][axis] + j * step[1][axis]);
        greys.extend(disc_mean(image, view.bent_px(between), 1.0));
    }
    median(greys.into_iter())
}

fn disc_greys(image: &GrayImage, centre_px: [f64; 2], radius_px: f64) -> Vec<u8> {
    let reach = radius_px.ceil() as i64;
    let (u0, v0) = (centre_px[0].round() as i64, centre_px[1].round() as i64);
    let mut greys = Vec::new();
    for v in v0 - reach..=v0 + reach {
        for u in u0 - reach..=u0 + reach {
            let inside = (u as f64 - centre_px[0]).hypot(v as f64 - centre_px[1]) <= radius_px.max(0.71);
            if inside && u >= 0 && v >= 0 && u < i64::from(image.width()) && v < i64::from(image.height()) {
                greys.push(image.get_pixel(u as u32, v as u32)[0]);
            }
        }
    }
    greys
}

/// Mean grey level of a small disc; `None` if the disc's centre is nearer to the image's edge than its radius.
fn disc_mean(image: &GrayImage, centre_px: [f64; 2], radius_px: f64) -> Option<f64> {
    let inside = |at: f64, size: u32| at >= radius_px && at <= f64::from(size) - 1.0 - radius_px;
    if !inside(centre_px[0], image.width()) || !inside(centre_px[1], image.height()) {
        return None;
    }
    let greys = disc_greys(image, centre_px, radius_px);
    Some(greys.iter().map(|grey| f64::from(*grey)).sum::<f64>() / greys.len() as f64)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn norm([u, v]: [f64; 2]) -> f64 {
    u.hypot(v)
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
