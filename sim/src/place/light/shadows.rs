//! Shadows in direct sunlight as polygons on the faces that they fall on, from which the renderer tells for each pixel what of it the sun lights.
//!
//! Everything that casts shadows is convex, and so is its shadow: the hull of its corners, moved along the sunlight into the plane of the face. Faces
//! are divided into cells, each with a list of those shadow edges that cross it, so that few edges are asked for a pixel.

use nalgebra::{Point3, Vector2, Vector3, vector};

use super::parallel::in_parallel;
use crate::place::building::{Building, Panel};

/// Wanted side of the cells of a face.
const CELL_M: f64 = 0.5;
/// Greatest number of cells along a side of a face.
const MOST_CELLS: f64 = 512.0;
/// Distance around a cell within which shadow edges count as crossing it, as the pixels at its border reach beyond.
const MARGIN_M: f64 = 0.05;
/// Height over a face up to which something counts as standing on it, rather than before it.
const CONTACT_M: f64 = 1e-5;
/// What is no higher than this over a face, such as a coplanar wall, casts no shadow on it.
const LEAST_HEIGHT_M: f64 = 1e-3;
/// Number of words before the cells of a face: columns, rows, cells per metre along both sides.
const HEADER: usize = 4;
/// Entries of cells that are wholly in the sun and wholly in shadow; all others are places of lists.
const LIT: u32 = 0;
const SHADED: u32 = 1;

/// Shadows over all faces of a building, as sun.wgsl reads them: words that are whole numbers or the bits of numbers in single precision.
///
/// A face has a header and its cells, row by row. The list of a cell has the number of its polygons and for each the number of its edges. An edge is
/// four numbers: the unit normal (x, y) into the shadow, c, and b. A pixel of width w across the edge is in shadow by (n·p + c)/w + b, from 0 to 1.
/// The bias b is 0.5, and 1 for an edge along which what casts the shadow stands on the face.
#[derive(Clone, Debug)]
pub struct Shadows {
    /// All words.
    pub words: Vec<u32>,
    /// For each panel (flat face) of the building the place of its header; 0 for those that the sun does not shine on.
    pub faces: Vec<u32>,
}

/// A shadow: its edges, of which it is on the inner side.
type Polygon = Vec<Edge>;

/// The line along one side of a shadow.
#[derive(Clone, Copy, Debug)]
struct Edge {
    inward: Vector2<f64>,
    offset_m: f64,
    stands_there: bool,
}

/// A convex thing that casts shadows: its corners, and the pairs of them that its edges join.
struct Caster {
    corners: Vec<Point3<f64>>,
    edges: Vec<[usize; 2]>,
}

impl Shadows {
    /// The shadows of walls and furniture on all faces of a building, for a sun in the given direction.
    pub fn new(building: &Building, to_sun: Vector3<f64>) -> Shadows {
        let casters = casters(building);
        let of_faces = in_parallel(&building.panels, |panel| face(panel, &casters, to_sun));
        // Place 0 means that the sun does not shine on a face.
        let (mut words, mut faces) = (vec![0_u32], Vec::new());
        for of_face in of_faces {
            let Some(mut own) = of_face else {
                faces.push(0);
                continue;
            };
            let first = words.len() as u32;
            let n_cells = (own[0] * own[1]) as usize;
            own[HEADER..HEADER + n_cells].iter_mut().filter(|cell| **cell > SHADED).for_each(|cell| *cell += first);
            faces.push(first);
            words.extend(own);
        }
        Shadows { words, faces }
    }

    /// No shadows and no sun, for a building with the given number of faces.
    pub fn none(n_faces: usize) -> Shadows {
        Shadows { words: vec![0], faces: vec![0; n_faces] }
    }
}

fn casters(building: &Building) -> Vec<Caster> {
    let walls = building.walls().map(|wall| Caster {
        corners: wall.corners().to_vec(),
        edges: (0..4).map(|index| [index, (index + 1) % 4]).collect(),
    });
    let around = |first: usize| (0..4).map(move |index| [first + index, first + (index + 1) % 4]);
    let boxes = building.boxes.iter().map(|piece| Caster {
        corners: piece.corners().to_vec(),
        edges: around(0).chain(around(4)).chain((0..4).map(|index| [index, index + 4])).collect(),
    });
    walls.chain(boxes).collect()
}

/// The words of one face, in which places of lists count from its header; `None` if it faces away from the sun.
fn face(panel: &Panel, casters: &[Caster], to_sun: Vector3<f64>) -> Option<Vec<u32>> {
    let cosine = panel.normal().dot(&to_sun);
    if cosine <= 1e-6 {
        return None;
    }
    let size_m = Vector2::from(panel.size_m());
    let polygons: Vec<Polygon> =
        casters.iter().filter_map(|caster| shadow(panel, caster, to_sun / cosine, size_m)).collect();
    let count = [size_m.x, size_m.y].map(|side_m| (side_m / CELL_M).ceil().clamp(1.0, MOST_CELLS) as usize);
    let cell_m = vector![size_m.x / count[0] as f64, size_m.y / count[1] as f64];
    let per_m = cell_m.map(|side_m| ((1.0 / side_m) as f32).to_bits());
    let mut words = vec![count[0] as u32, count[1] as u32, per_m.x, per_m.y];
    words.resize(HEADER + count[0] * count[1], LIT);
    for (row, column) in (0..count[1]).flat_map(|row| (0..count[0]).map(move |column| (row, column))) {
        let middle = vector![(column as f64 + 0.5) * cell_m.x, (row as f64 + 0.5) * cell_m.y];
        let list: Option<Vec<Polygon>> = in_cell(&polygons, middle, 0.5 * cell_m);
        let at = HEADER + row * count[0] + column;
        match list {
            None => words[at] = SHADED,
            Some(list) if list.is_empty() => {}
            Some(list) => {
                words[at] = words.len() as u32;
                write(&mut words, &list);
            }
        }
    }
    Some(words)
}

fn write(words: &mut Vec<u32>, list: &[Polygon]) {
    words.push(list.len() as u32);
    for polygon in list {
        words.push(polygon.len() as u32);
        for edge in polygon {
            let bias = if edge.stands_there { 1.0 } else { 0.5 };
            let numbers = [edge.inward.x, edge.inward.y, edge.offset_m, bias];
            words.extend(numbers.map(|number| (number as f32).to_bits()));
        }
    }
}

/// The shadows that cross a cell, each with the edges that do; `None` if one of them covers the whole cell.
fn in_cell(polygons: &[Polygon], middle: Vector2<f64>, half: Vector2<f64>) -> Option<Vec<Polygon>> {
    let mut list = Vec::new();
    for polygon in polygons {
        let mut crossing = Vec::new();
        let mut is_off = false;
        for edge in polygon {
            let reach_m = edge.inward.x.abs() * half.x + edge.inward.y.abs() * half.y + MARGIN_M;
            let inside_m = edge.inward.dot(&middle) + edge.offset_m;
            if inside_m < -reach_m {
                is_off = true;
                break;
            }
            if inside_m < reach_m {
                crossing.push(*edge);
            }
        }
        if is_off {
            continue;
        }
        if crossing.is_empty() {
            return None;
        }
        list.push(crossing);
    }
    Some(list)
}

/// The shadow of a thing on the plane of a face, in metres along the face's sides; `None` if none falls on the face. `sunward` leads from the plane
/// towards the sun, to a height of 1 m over the plane.
fn shadow(panel: &Panel, caster: &Caster, sunward: Vector3<f64>, size_m: Vector2<f64>) -> Option<Polygon> {
    let normal = panel.normal();
    let heights_m: Vec<f64> = caster.corners.iter().map(|corner| normal.dot(&(corner - panel.corner))).collect();
    if heights_m.iter().all(|height_m| *height_m < LEAST_HEIGHT_M) {
        return None;
    }
    let sides = [panel.along.normalize(), panel.up.normalize()];
    let cast = |at: Point3<f64>, height_m: f64| {
        let from_corner = at - sunward * height_m - panel.corner;
        (vector![sides[0].dot(&from_corner), sides[1].dot(&from_corner)], height_m < CONTACT_M)
    };
    let mut points: Vec<(Vector2<f64>, bool)> = Vec::new();
    for (corner, height_m) in caster.corners.iter().zip(&heights_m) {
        if *height_m >= 0.0 {
            points.push(cast(*corner, *height_m));
        }
    }
    // What of the thing is behind the plane is cut off.
    for [one, other] in &caster.edges {
        let (low, high) = (heights_m[*one], heights_m[*other]);
        if (low < 0.0) != (high < 0.0) {
            let share = low / (low - high);
            points.push(cast(caster.corners[*one] + (caster.corners[*other] - caster.corners[*one]) * share, 0.0));
        }
    }
    let hull = hull(points);
    let beyond = |axis: usize| {
        hull.iter().all(|(at, _)| at[axis] < -MARGIN_M) || hull.iter().all(|(at, _)| at[axis] > size_m[axis] + MARGIN_M)
    };
    if hull.len() < 3 || beyond(0) || beyond(1) {
        return None;
    }
    let edge = |index: usize| {
        let ((from, stands), (to, also)) = (hull[index], hull[(index + 1) % hull.len()]);
        let along = (to - from).normalize();
        let inward = vector![-along.y, along.x];
        Edge { inward, offset_m: -inward.dot(&from), stands_there: stands && also }
    };
    Some((0..hull.len()).map(edge).collect())
}

/// The convex hull of points, counter-clockwise (Andrew, Another efficient algorithm for convex hulls in two dimensions, 1979). Each point keeps its
/// mark.
fn hull(mut points: Vec<(Vector2<f64>, bool)>) -> Vec<(Vector2<f64>, bool)> {
    /// Area below which three points are in line.
    const FLAT_M2: f64 = 1e-9;
    /// Distance below which two points are the same.
    const SAME_M: f64 = 1e-6;
    points.sort_by(|(one, _), (other, _)| one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y)));
    points.dedup_by(|next, kept| {
        let is_same = (next.0 - kept.0).norm() < SAME_M;
        kept.1 |= is_same && next.1;
        is_same
    });
    let half = |points: &mut dyn Iterator<Item = (Vector2<f64>, bool)>| {
        let mut chain: Vec<(Vector2<f64>, bool)> = Vec::new();
        for point in points {
            while let [.., (before, _), (last, _)] = chain.as_slice() {
                if (last - before).perp(&(point.0 - last)) > FLAT_M2 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut around = half(&mut points.iter().copied());
    around.extend(half(&mut points.iter().rev().copied()));
    around
}
