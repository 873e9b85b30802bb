//! Lattices of ceiling markers, and the search for the smallest lattice that covers a room.

use std::f64::consts::TAU;

use localizer::Pose;

use super::{Field, Place, search};

/// The task of a lattice of ceiling markers: where the robot can be, where markers may be, and how many the ceiling camera has to see.
#[derive(Clone, Debug)]
pub struct Ceiling {
    /// Ranges of world x and y in which the robot's origin stays.
    pub reach_m: [[f64; 2]; 2],
    /// Ranges of world x and y to which the middles of markers are limited.
    pub markers_m: [[f64; 2]; 2],
    /// Height of the markers above the floor.
    pub height_m: f64,
    /// Number of markers that have to be in the ceiling camera's view at once.
    pub seen_at_once: usize,
    /// Greatest number of markers that the lattice may have, which is the number of marker identities.
    pub most_markers: usize,
}

/// Reason why no lattice of ceiling markers was found that gives the ceiling camera enough markers from every pose of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlaid {
    /// No lattice of up to 64 × 64 markers gives the ceiling camera enough markers from every pose of the robot.
    Uncovered,
    /// Every lattice that may give the ceiling camera enough markers has at least this many, more than there are marker identities.
    TooMany(usize),
}

/// How every second row of a marker lattice differs from the first row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Between {
    /// Every second row of the lattice equals the first row.
    Same,
    /// Every second row of the lattice is shifted by half a spacing.
    Shifted,
    /// Every second row of the lattice has one marker less, and its markers lie between those of the first row.
    Fewer,
    /// Every second row of the lattice has one marker more, on both sides of each marker of the first row.
    More,
}

/// A lattice of markers: parallel rows over a rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lattice {
    between: Between,
    /// Whether the rows of the marker lattice run along world y.
    along_y: bool,
    n_rows: usize,
    /// Number of markers in the lattice's first row.
    first: usize,
    /// Distances from the ends of the longest row, and from the outermost rows, to the edge of the area in which the robot's origin can be.
    /// They are in units of the spacing of markers in a row, and of rows.
    inset: [f64; 2],
}

/// Distances that are tried between the outermost markers and the edge of the area in which the robot's origin can be, in units of the
/// markers' spacing: from markers on the edge to markers a little more than half a spacing inside it.
const INSETS: [f64; 6] = [0.0, 0.15, 0.28, 0.36, 0.44, 0.52];
/// Greatest ratio, among the lattices that are tried, of the distance between rows to the spacing within a row. An image has a ratio of
/// about 4 to 3, so that more stretched lattices waste markers.
const MOST_STRETCHED: f64 = 2.5;
/// Length on the ceiling by which the camera's field of view is narrowed while a lattice is tested, so that one that passes has a margin to
/// spare when its proof is tried. With a centimetre a proof takes a fraction of a second.
const TO_SPARE_M: f64 = 0.01;
/// Number of poses that are remembered because too few markers of a lattice were seen from them; they are tried first on the next lattice.
const REMEMBERED: usize = 64;
/// Greatest number of rows, and of markers in a row: 64 × 64 = 4096 markers in all, one for each marker identity there is.
const MOST: usize = 64;

/// The smallest of the marker lattices tried that is proven to give the ceiling camera enough markers from every pose of the robot.
///
/// Rows along x and along y are tried, in square, hexagonal and stretched lattices. For each number of rows, the fewest markers in a row
/// are found by bisection, tested on a sample of poses. Lattices that pass are then proven, the smallest first. A proof takes seconds in a
/// large hall, and is not begun for a lattice with more markers than there are marker identities.
pub fn smallest(field: &Field, ceiling: &Ceiling) -> Result<Vec<Place>, Unlaid> {
    let (narrowed, mut rim) = (field.narrowed(TO_SPARE_M), Rim::new(&ceiling.reach_m));
    let kinds = || {
        let between = [Between::Same, Between::Shifted, Between::Fewer, Between::More];
        [false, true].into_iter().flat_map(move |along_y| between.map(|between| (along_y, between)))
    };
    let of_rows = |n_rows: usize| {
        kinds().map(move |(along_y, between)| Lattice { between, along_y, n_rows, first: 0, inset: [0.0; 2] })
    };
    let mut candidates: Vec<(Lattice, Vec<Place>)> =
        (1..=MOST).flat_map(of_rows).filter_map(|rows| rows.fewest(&narrowed, ceiling, &mut rim)).collect();
    candidates.sort_by_key(|(_, places)| places.len());
    let is_proven = |places: &Vec<Place>| search(field, places, &ceiling.reach_m, ceiling.seen_at_once, 0).is_none();
    let mut best: Option<Vec<Place>> = None;
    let mut needed = None;
    for (lattice, places) in candidates {
        let fewer_than = best.as_ref().map_or(usize::MAX, Vec::len);
        if places.len() > ceiling.most_markers {
            needed = needed.or(Some(places.len()));
            break;
        }
        if places.len() >= fewer_than {
            break;
        }
        // A proof is tried of each lattice as it is, and then with one more marker in its first row; if neither is proven, a longer search
        // is not worth its time.
        let proven = Some(places).filter(is_proven).or_else(|| {
            let wider = Lattice { first: lattice.first + 1, ..lattice }.passing(&narrowed, ceiling, &mut rim);
            let too_many = wider.as_ref().map(Vec::len).filter(|n_markers| *n_markers > ceiling.most_markers);
            needed = needed.or(too_many);
            wider.filter(|places| places.len() < fewer_than && too_many.is_none()).filter(is_proven)
        });
        best = proven.or(best);
    }
    best.ok_or(needed.map_or(Unlaid::Uncovered, Unlaid::TooMany))
}

impl Lattice {
    /// Number of markers in every second row of the lattice.
    fn second(&self) -> usize {
        match self.between {
            Between::Same | Between::Shifted => self.first,
            Between::Fewer => self.first - 1,
            Between::More => self.first + 1,
        }
    }

    /// This lattice with the smallest number of markers in its first row at which it passes the test on sample poses, and the positions of
    /// all its markers.
    fn fewest(self, field: &Field, ceiling: &Ceiling, rim: &mut Rim) -> Option<(Lattice, Vec<Place>)> {
        let of = |first| Lattice { first, ..self };
        let most = (1..=MOST).rev().find(|first| !of(*first).is_narrow(ceiling))?;
        let mut found = of(most).passing(field, ceiling, rim)?;
        let (mut failing, mut passing) = (0, most);
        while passing - failing > 1 {
            let middle = (failing + passing) / 2;
            match of(middle).passing(field, ceiling, rim) {
                Some(places) => (found, passing) = (places, middle),
                None => failing = middle,
            }
        }
        Some((of(passing), found))
    }

    /// Positions of the lattice's markers with the first of the tried distances to the edge at which the camera sees enough markers from
    /// all sample poses, both between four markers and along the rim of the robot's area.
    fn passing(self, field: &Field, ceiling: &Ceiling, rim: &mut Rim) -> Option<Vec<Place>> {
        let insets = INSETS.iter().flat_map(|along| INSETS.iter().map(move |across| [*along, *across]));
        insets.map(|inset| Lattice { inset, ..self }).filter(|lattice| lattice.covers_inside(field, ceiling)).find_map(
            |lattice| {
                let places = lattice.places(ceiling);
                rim.is_covered(field, &places, ceiling.seen_at_once).then_some(places)
            },
        )
    }

    /// Whether the camera sees enough markers of the lattice from sample poses far from all walls.
    fn covers_inside(&self, field: &Field, ceiling: &Ceiling) -> bool {
        const N: i32 = 6;
        const REACH: i32 = 3;
        let axes = self.axes();
        let ([_, along_m], [_, across_m]) = self.spacing(ceiling);
        let shifts = self.shifts();
        let at = |along: f64, row: f64| {
            let mut at_m = [0.0; 2];
            (at_m[axes[0]], at_m[axes[1]]) = (along * along_m, row * across_m);
            at_m
        };
        let mut places = Vec::new();
        for (row, n) in (-REACH..=REACH).flat_map(|row| (-REACH..=REACH).map(move |n| (row, n))) {
            let [x_m, y_m] = at(f64::from(n) + shifts[row.rem_euclid(2) as usize], f64::from(row));
            places.push([x_m, y_m, ceiling.height_m]);
        }
        (0..N * N).all(|cell| {
            let [x_m, y_m] = at(f64::from(cell % N) / f64::from(N), f64::from(cell / N) / f64::from(N));
            headings()
                .all(|heading_rad| sees_enough(field, &places, &Pose { x_m, y_m, heading_rad }, ceiling.seen_at_once))
        })
    }

    /// Whether the lattice's markers are so much nearer to each other along a row than the rows are to each other that the lattice is not
    /// tried.
    fn is_narrow(&self, ceiling: &Ceiling) -> bool {
        let ([_, along_m], [_, across_m]) = self.spacing(ceiling);
        self.first > 1 && across_m > MOST_STRETCHED * along_m
    }

    /// World axes along a row of the lattice and across the rows: 0 for x, 1 for y.
    fn axes(&self) -> [usize; 2] {
        if self.along_y { [1, 0] } else { [0, 1] }
    }

    /// Shifts, along the rows, of the lattice's first row and of every second row, in units of the spacing of markers in a row.
    fn shifts(&self) -> [f64; 2] {
        match self.between {
            Between::Same => [0.0, 0.0],
            Between::Shifted | Between::Fewer => [0.0, 0.5],
            Between::More => [0.5, 0.0],
        }
    }

    /// Position of the lattice's first marker and distance to the next one, along a row and across the rows.
    fn spacing(&self, ceiling: &Ceiling) -> ([f64; 2], [f64; 2]) {
        let [along, across] = self.axes().map(|axis| ceiling.reach_m[axis]);
        let end = |row: usize| self.shifts()[row] + [self.first, self.second()][row] as f64 - 1.0;
        let spacings = end(0).max(if self.n_rows > 1 { end(1) } else { 0.0 });
        (spread_over(along, spacings, self.inset[0]), spread_over(across, self.n_rows as f64 - 1.0, self.inset[1]))
    }

    fn places(&self, ceiling: &Ceiling) -> Vec<Place> {
        let (axes, shifts) = (self.axes(), self.shifts());
        let ([first_m, along_m], [first_row_m, across_m]) = self.spacing(ceiling);
        let mut places = Vec::new();
        for row in 0..self.n_rows {
            let n_markers = if row % 2 == 0 { self.first } else { self.second() };
            for index in 0..n_markers {
                let mut place_m = [0.0; 2];
                place_m[axes[0]] = first_m + (index as f64 + shifts[row % 2]) * along_m;
                place_m[axes[1]] = first_row_m + row as f64 * across_m;
                let [x_m, y_m] = [0, 1].map(|axis| {
                    let [least_m, most_m] = ceiling.markers_m[axis];
                    // Positions of markers are rounded to whole millimetres, which is what a tape measure shows.
                    (place_m[axis].clamp(least_m, most_m) * 1e3).round() / 1e3
                });
                places.push([x_m, y_m, ceiling.height_m]);
            }
        }
        places
    }
}

fn sees_enough(field: &Field, places: &[Place], pose: &Pose, seen_at_once: usize) -> bool {
    let seen = places.iter().filter(|place| field.surely_sees_from(pose, place));
    seen.take(seen_at_once).count() == seen_at_once
}

/// Headings at which sample poses are tried.
fn headings() -> impl Iterator<Item = f64> {
    const N: usize = 12;
    (0..N).map(|heading| heading as f64 * TAU / N as f64)
}

/// Coordinate of the first of several evenly spaced places and the distance between neighbours. The outermost places are `inset` times this
/// distance away from the ends of the range.
fn spread_over([from_m, to_m]: [f64; 2], spacings: f64, inset: f64) -> [f64; 2] {
    let all = spacings + 2.0 * inset;
    if spacings > 0.0 {
        [from_m + inset * (to_m - from_m) / all, (to_m - from_m) / all]
    } else {
        // A single place is put in the middle; the distance returned with it is so large that a next place would lie beyond the walls.
        [0.5 * (from_m + to_m), to_m - from_m]
    }
}

/// Sample poses of the robot along the rim of the area in which its origin can be.
struct Rim {
    places_m: Vec<[f64; 2]>,
    /// Poses from which too few markers of lattices tested before were seen, the latest such pose first.
    refuting: Vec<Pose>,
}

impl Rim {
    fn new(reach_m: &[[f64; 2]; 2]) -> Rim {
        const STEP_M: f64 = 0.2;
        let [x_m, y_m] = *reach_m;
        let mut places_m = Vec::new();
        for (axis, [from_m, to_m]) in reach_m.iter().copied().enumerate() {
            let n_steps = ((to_m - from_m) / STEP_M).ceil().max(1.0);
            for step in 0..=n_steps as usize {
                let at_m = from_m + (to_m - from_m) * step as f64 / n_steps;
                places_m.extend(if axis == 0 { y_m.map(|y_m| [at_m, y_m]) } else { x_m.map(|x_m| [x_m, at_m]) });
            }
        }
        Rim { places_m, refuting: Vec::new() }
    }

    /// Whether the camera sees enough markers from all sample poses along the rim of the robot's area, at all headings tried.
    fn is_covered(&mut self, field: &Field, places: &[Place], seen_at_once: usize) -> bool {
        let near = |at_m: [f64; 2]| -> Vec<Place> {
            places.iter().filter(|place| field.reaches(at_m, place)).copied().collect()
        };
        let refutes = |pose: &Pose, places: &[Place]| !sees_enough(field, places, pose, seen_at_once);
        if let Some(at) = self.refuting.iter().position(|pose| refutes(pose, &near([pose.x_m, pose.y_m]))) {
            self.refuting[..=at].rotate_right(1);
            return false;
        }
        let found = self.places_m.iter().find_map(|[x_m, y_m]| {
            // Markers too far away to be in view at any heading are left out, which leaves only few to test.
            let near = near([*x_m, *y_m]);
            let mut poses = headings().map(|heading_rad| Pose { x_m: *x_m, y_m: *y_m, heading_rad });
            poses.find(|pose| refutes(pose, &near))
        });
        if let Some(pose) = found {
            self.refuting.insert(0, pose);
            self.refuting.truncate(REMEMBERED);
        }
        found.is_none()
    }
}
