//! Ceiling markers as they were truly printed and pasted.

use localizer::markers::{GridPlace, MarkerId};
use nalgebra::{Point3, Rotation2, Vector2};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    scene::{Distribution, Marker, Markers, Scene},
    truth::randomness::{draw_within, stream},
};

/// Matrix Q of paper 5's Eq. (9) as printed, first row at the top: Y is top left, O bottom left, X bottom right. It is written here apart
/// from the localizer's copy, because the localizer reads what this one prints.
const WEIGHTS: [[u16; 4]; 4] =
    [[0, 0x020, 0x200, 0], [0x002, 0x010, 0x100, 0x800], [0x001, 0x008, 0x080, 0x400], [0, 0x004, 0x040, 0]];

/// Distance between neighbouring dots of a marker (paper 5, section 3.2).
pub const PITCH_M: f64 = 0.04;
/// Radius of every dot of a marker.
pub const DOT_RADIUS_M: f64 = 0.01;

/// A marker on the ceiling as it truly is, with all errors of printing and pasting.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnMarker {
    /// Identity that is printed on the marker.
    pub id: MarkerId,
    /// Index of the marker in the scene's list of markers.
    pub index: usize,
    /// True world x and y of the middle of the marker's grid.
    pub centre_m: [f64; 2],
    /// True angle from world x to the marker's direction from dot O to dot X.
    pub rotation_rad: f64,
    /// True height of the marker's dots above the floor.
    pub height_m: f64,
    /// All dots of the marker that reflect, including those where no dot is printed.
    pub dots: Vec<DrawnDot>,
}

/// A dot of a marker as it truly is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnDot {
    /// Cell of the marker's grid in which the dot is printed.
    pub place: GridPlace,
    /// True centre of the dot, world frame.
    pub centre_in_world: Point3<f64>,
}

impl DrawnMarker {
    /// Draws all markers that are on the ceiling.
    pub fn draw_all(scene: &Scene, seed: u64) -> Vec<DrawnMarker> {
        let Some(markers) = &scene.markers else { return Vec::new() };
        let mut rng = stream(seed, "markers");
        let errors = scene.robot.errors;
        let first = rng.clone();
        // Fallen markers use up their random numbers like the others, so that the fall of one does not change what is drawn for any other.
        let draw = |(index, marker): (usize, &Marker)| {
            let height_m = markers.height_m(marker, scene);
            if errors == Distribution::Drift {
                // With the distribution `Drift` all markers are off by the same error, as by a tape measure that is too long, so that no
                // number of markers reveals it.
                rng = first.clone();
            }
            let drawn = draw_marker((index, marker), markers, height_m, errors, &mut rng);
            marker.pasted.then_some(drawn)
        };
        let fallen = fallen(markers, seed);
        let drawn = markers.all().iter().enumerate().filter_map(draw);
        drawn.filter(|marker| !fallen.contains(&marker.index)).collect()
    }
}

/// Indices of the markers that have fallen off the ceiling, drawn at random.
fn fallen(markers: &Markers, seed: u64) -> Vec<usize> {
    let (share, n_markers) = (markers.share_missing, markers.all().len());
    let mut left: Vec<usize> = (0..n_markers).collect();
    let mut rng = stream(seed, "markers.missing");
    let n_fallen = (share * n_markers as f64).round() as usize;
    (0..n_fallen.min(n_markers)).map(|_| left.swap_remove(rng.random_range(0..left.len()))).collect()
}

fn draw_marker(
    (index, marker): (usize, &Marker),
    markers: &Markers,
    nominal_height_m: f64,
    errors: Distribution,
    rng: &mut ChaCha8Rng,
) -> DrawnMarker {
    let moved = Vector2::from(marker.misplaced_m);
    let centre =
        Vector2::new(marker.x_m, marker.y_m) + moved + draw_in_disc(markers.placement_tolerance_m, errors, rng);
    let turn_rad = draw_within(markers.rotation_tolerance_deg.to_radians(), errors, rng);
    let rotation_rad = marker.rotation_deg.to_radians() + turn_rad;
    let height_m = nominal_height_m + draw_within(markers.height_tolerance_m, errors, rng);
    let world_from_marker = Rotation2::new(rotation_rad);
    let mut dots = Vec::new();
    for place in (0..4).flat_map(|i| (0..4).map(move |j| [i, j])) {
        // Every cell of the marker's grid uses up its random numbers, so that a missing dot does not change what is drawn for any other dot.
        let misprint = draw_in_disc(markers.print_tolerance_m, errors, rng);
        if marker.shines_at(place) {
            let at = centre + world_from_marker * (marker.place_in_marker_m(place) + misprint);
            dots.push(DrawnDot { place, centre_in_world: Point3::new(at.x, at.y, height_m) });
        }
    }
    DrawnMarker { id: MarkerId(marker.id), index, centre_m: centre.into(), rotation_rad, height_m, dots }
}

/// Draws a vector whose length is bounded by the tolerance, in any direction.
fn draw_in_disc(radius_m: f64, errors: Distribution, rng: &mut ChaCha8Rng) -> Vector2<f64> {
    let distance_m = draw_within(radius_m, errors, rng);
    let direction_rad = draw_within(std::f64::consts::FRAC_PI_2, Distribution::Uniform, rng);
    Rotation2::new(direction_rad) * Vector2::new(distance_m, 0.0)
}

impl Marker {
    /// Whether a dot is printed in this cell of the marker's grid.
    pub fn is_printed(&self, [i, j]: GridPlace) -> bool {
        let weight = WEIGHTS[usize::from(3 - j)][usize::from(i)];
        [[0, 0], [3, 0], [0, 3]].contains(&[i, j]) || self.id & weight != 0
    }

    /// Whether anything reflects in this cell of the marker's grid: a printed dot, or something that shines where no dot is printed.
    fn shines_at(&self, place: GridPlace) -> bool {
        let is_dot = self.is_printed(place) && !self.missing_dots.contains(&place);
        // Width of the marker to which `covered_share` refers: from rim to rim of the outermost dots of the grid.
        let width_m = 3.0 * PITCH_M + 2.0 * DOT_RADIUS_M;
        let is_covered = along_m(place[0]) > width_m * (0.5 - self.covered_share);
        (is_dot || self.extra_dots.contains(&place)) && !is_covered
    }

    /// Position of a grid cell on the marker's film, with x from dot O to dot X and y from dot O to dot Y; on a film that is pasted the wrong way
    /// round, x and y change places.
    fn place_in_marker_m(&self, [i, j]: GridPlace) -> Vector2<f64> {
        if self.mirrored { Vector2::new(along_m(j), along_m(i)) } else { Vector2::new(along_m(i), along_m(j)) }
    }
}

/// Distance of a row or column of the marker's grid from the grid's middle.
fn along_m(index: u8) -> f64 {
    (f64::from(index) - 1.5) * PITCH_M
}
