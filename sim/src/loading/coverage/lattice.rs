//! Lattices of ceiling markers, and the search for the smallest lattice that covers a room.

use std::f64::consts::TAU;

use localizer::Pose;

use super::{Field, Place, Poses, search};

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
    let (narrowed, mut samples) = (field.narrowed(TO_SPARE_M), Samples::new(&ceiling.reach_m));
    let kinds = || {
        let between = [Between::Same, Between::Shifted, Between::Fewer, Between::More];
        [false, true].into_iter().flat_map(move |along_y| between.map(|between| (along_y, between)))
    };
    let of_rows = |n_rows: usize| {
        kinds().map(move |(along_y, between)| Lattice { between, along_y, n_rows, first: 0, inset: [0.0; 2] })
    };
    let mut candidates: Vec<(Lattice, Vec<Place>)> =
        (1..=MOST).flat_map(of_rows).filter_map(|rows| rows.fewest(&narrowed, ceiling, &mut samples)).collect();
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
            let wider = Lattice { first: lattice.first + 1, ..lattice }.passing(&narrowed, ceiling, &mut samples);
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
    fn fewest(self, field: &Field, ceiling: &Ceiling, samples: &mut Samples) -> Option<(Lattice, Vec<Place>)> {
        let of = |first| Lattice { first, ..self };
        let most = (1..=MOST).rev().find(|first| !of(*first).is_narrow(ceiling))?;
        let mut found = of(most).passing(field, ceiling, samples)?;
        let (mut failing, mut passing) = (0, most);
        while passing - failing > 1 {
            let middle = (failing + passing) / 2;
            match of(middle).passing(field, ceiling, samples) {
                Some(places) => (found, passing) = (places, middle),
                None => failing = middle,
            }
        }
        Some((of(passing), found))
    }

    /// Positions of the lattice's markers with the first of the tried distances to the edge at which the camera sees enough markers from
    /// all sample poses, both between four markers and along the rim of the robot's area.
    fn passing(self, field: &Field, ceiling: &Ceiling, samples: &mut Samples) -> Option<Vec<Place>> {
        let insets = INSETS.iter().flat_map(|along| INSETS.iter().map(move |across| [*along, *across]));
        insets.map(|inset| Lattice { inset, ..self }).find_map(|lattice| {
            let (inside, seen_at_once) = (lattice.inside(ceiling), ceiling.seen_at_once);
            // The samples that refuted lattices before are tried first, because they refute most others too, in far less time than all samples take.
            if samples.inside.is_some_and(|sample| inside.is_refuted_by(sample, field, seen_at_once)) {
                return None;
            }
            let places = lattice.places(ceiling);
            if samples.refute_again(field, &places, seen_at_once) {
                return None;
            }
            if let Some(sample) = inside.refuting(field, seen_at_once) {
                samples.inside = Some(sample);
                return None;
            }
            samples.rim_is_covered(field, &places, seen_at_once).then_some(places)
        })
    }

    /// The part of the lattice far from all walls.
    fn inside(&self, ceiling: &Ceiling) -> Inside {
        const REACH: i32 = 3;
        let axes = self.axes();
        let ([_, along_m], [_, across_m]) = self.spacing(ceiling);
        let mut inside = Inside { places: Vec::new(), axes, spacing_m: [along_m, across_m] };
        let shifts = self.shifts();
        for (row, n) in (-REACH..=REACH).flat_map(|row| (-REACH..=REACH).map(move |n| (row, n))) {
            let [x_m, y_m] = inside.at_m(f64::from(n) + shifts[row.rem_euclid(2) as usize], f64::from(row));
            inside.places.push([x_m, y_m, ceiling.height_m]);
        }
        inside
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
    let poses = Poses::at(*pose);
    let view = field.view_from(&poses);
    // A marker that is surely seen is seen without errors too, which is quicker to test and false of most markers.
    let seen = places.iter().filter(|place| view.sees_without_errors(place) && view.surely_sees(place));
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

/// The part of a lattice far from all walls: the markers around one of them, which is at the origin.
struct Inside {
    places: Vec<Place>,
    /// World axes along a row and across the rows, and the spacing of the markers along each.
    axes: [usize; 2],
    spacing_m: [f64; 2],
}

/// A sample pose between four markers: its cell among the sample positions, and its heading.
#[derive(Clone, Copy, Debug)]
struct BetweenMarkers {
    cell: i32,
    heading_rad: f64,
}

impl Inside {
    /// Number of sample positions between two markers, along a row and across the rows.
    const N: i32 = 6;

    /// World x and y of a point, given in units of the markers' spacing along a row and across the rows.
    fn at_m(&self, along: f64, row: f64) -> [f64; 2] {
        let mut at_m = [0.0; 2];
        (at_m[self.axes[0]], at_m[self.axes[1]]) = (along * self.spacing_m[0], row * self.spacing_m[1]);
        at_m
    }

    /// The position of a sample, and the markers that may be in view there at some heading, which are only few of all.
    fn sample(&self, cell: i32, field: &Field) -> ([f64; 2], Vec<Place>) {
        let at_m =
            self.at_m(f64::from(cell % Self::N) / f64::from(Self::N), f64::from(cell / Self::N) / f64::from(Self::N));
        (at_m, near(at_m, field, &self.places))
    }

    /// Whether the camera sees too few markers from a sample pose.
    fn is_refuted_by(
        &self,
        BetweenMarkers { cell, heading_rad }: BetweenMarkers,
        field: &Field,
        seen_at_once: usize,
    ) -> bool {
        let ([x_m, y_m], near) = self.sample(cell, field);
        !sees_enough(field, &near, &Pose { x_m, y_m, heading_rad }, seen_at_once)
    }

    /// A sample pose from which the camera sees too few markers; `None` if it sees enough from all of them.
    fn refuting(&self, field: &Field, seen_at_once: usize) -> Option<BetweenMarkers> {
        (0..Self::N * Self::N).find_map(|cell| {
            let ([x_m, y_m], near) = self.sample(cell, field);
            let is_refuting = |heading_rad: &f64| {
                !sees_enough(field, &near, &Pose { x_m, y_m, heading_rad: *heading_rad }, seen_at_once)
            };
            headings().find(is_refuting).map(|heading_rad| BetweenMarkers { cell, heading_rad })
        })
    }
}

/// Sample poses along the rim of the area in which the robot's origin can be, and the samples that refuted lattices tested before.
struct Samples {
    rim_m: Vec<[f64; 2]>,
    /// Poses along the rim from which too few markers of lattices tested before were seen, the latest such pose first.
    at_rim: Vec<Pose>,
    /// The sample between four markers that was the last to refute a lattice.
    inside: Option<BetweenMarkers>,
}

impl Samples {
    fn new(reach_m: &[[f64; 2]; 2]) -> Samples {
        const STEP_M: f64 = 0.2;
        let [x_m, y_m] = *reach_m;
        let mut rim_m = Vec::new();
        for (axis, [from_m, to_m]) in reach_m.iter().copied().enumerate() {
            let n_steps = ((to_m - from_m) / STEP_M).ceil().max(1.0);
            for step in 0..=n_steps as usize {
                let at_m = from_m + (to_m - from_m) * step as f64 / n_steps;
                rim_m.extend(if axis == 0 { y_m.map(|y_m| [at_m, y_m]) } else { x_m.map(|x_m| [x_m, at_m]) });
            }
        }
        Samples { rim_m, at_rim: Vec::new(), inside: None }
    }

    /// Whether one of the poses along the rim that refuted other lattices refutes this one too.
    fn refute_again(&mut self, field: &Field, places: &[Place], seen_at_once: usize) -> bool {
        let refutes = |pose: &Pose| !sees_enough(field, &near([pose.x_m, pose.y_m], field, places), pose, seen_at_once);
        let found = self.at_rim.iter().position(refutes);
        if let Some(at) = found {
            self.at_rim[..=at].rotate_right(1);
        }
        found.is_some()
    }

    /// Whether the camera sees enough markers from all sample poses along the rim of the robot's area, at all headings tried.
    fn rim_is_covered(&mut self, field: &Field, places: &[Place], seen_at_once: usize) -> bool {
        let found = self.rim_m.iter().find_map(|[x_m, y_m]| {
            let near = near([*x_m, *y_m], field, places);
            let mut poses = headings().map(|heading_rad| Pose { x_m: *x_m, y_m: *y_m, heading_rad });
            poses.find(|pose| !sees_enough(field, &near, pose, seen_at_once))
        });
        if let Some(pose) = found {
            self.at_rim.insert(0, pose);
            self.at_rim.truncate(REMEMBERED);
        }
        found.is_none()
    }
}

/// Markers near enough to a position of the robot's origin to be in view at some heading, which are only few of all.
fn near(at_m: [f64; 2], field: &Field, places: &[Place]) -> Vec<Place> {
    places.iter().filter(|place| field.reaches(at_m, place)).copied().collect()
}
