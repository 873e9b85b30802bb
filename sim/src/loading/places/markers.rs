//! Contradictions about ceiling markers: impossible places, and markers that cannot be told apart.

use crate::{
    loading::contradiction::Contradiction,
    place::building::GroundPlan,
    scene::{Marker, Markers, Scene, UNDER_CEILING_M},
};
use localizer::markers::{self, MarkerId};

/// Half the side of the square that a marker takes up: half a spacing of dots more than the distance of its outermost dots' centres from its middle.
const HALF_WIDTH_M: f64 = 0.08;

/// Distance by which rounding may move the corner of a marker into a wall.
const ROUNDING_M: f64 = 1e-9;

/// All contradictions in `scene` about its markers.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let Some(markers) = &scene.markers else { return };
    let words = markers::Coding::from(markers.coding).identities();
    for (index, marker) in markers.markers.iter().enumerate() {
        let earlier = &markers.markers[..index];
        let problems = [
            word_problem(marker, markers, &words),
            twice(marker, earlier),
            outside(marker, scene),
            overlap(marker, earlier),
            too_high(marker, markers, scene),
            too_low(marker, markers, scene),
            misplaced_outside(marker, scene),
            wrong_dots(marker),
        ];
        found.extend(
            problems
                .into_iter()
                .flatten()
                .map(|(key, expected)| Contradiction { key: format!("markers.marker[{index}].{key}"), expected }),
        );
    }
}

type Problem = Option<(&'static str, String)>;

fn word_problem(marker: &Marker, markers: &Markers, words: &[MarkerId]) -> Problem {
    let distance = |word: &MarkerId| (word.0 ^ marker.id).count_ones();
    let least = words.iter().map(distance).min()?;
    if least == 0 {
        return None;
    }
    const SHOWN: usize = 5;
    let nearest: Vec<String> =
        words.iter().filter(|word| distance(word) == least).take(SHOWN).map(|word| word.0.to_string()).collect();
    let dots = if least == 1 { "1 dot".to_owned() } else { format!("{least} dots") };
    let coding = markers.coding.as_str();
    Some(("id", format!("no word of the {coding}, expected one such as {} ({dots} away)", nearest.join(", "))))
}

fn twice(marker: &Marker, earlier: &[Marker]) -> Problem {
    let first = earlier.iter().position(|other| other.id == marker.id && other.on_map && marker.on_map)?;
    Some((
        "id",
        format!(
            "that of markers.marker[{first}] too, expected each once on the map, or `on_map = false` for one of them"
        ),
    ))
}

/// Whether the whole square of a marker is in a room or in several that go over into each other.
fn hangs_in_a_further_room(marker: &Marker, scene: &Scene) -> bool {
    let (sin, cos) = marker.rotation_deg.to_radians().sin_cos();
    let plan = GroundPlan::of(scene);
    let is_inside = |[along, across]: [f64; 2]| {
        let [along_m, across_m] = [along * HALF_WIDTH_M, across * HALF_WIDTH_M];
        let corner_m = [marker.x_m + cos * along_m - sin * across_m, marker.y_m + sin * along_m + cos * across_m];
        plan.wall_distance_m(corner_m) >= -ROUNDING_M
    };
    plan.has_further_rooms() && [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].into_iter().all(is_inside)
}

fn outside(marker: &Marker, scene: &Scene) -> Problem {
    if hangs_in_a_further_room(marker, scene) {
        return None;
    }
    let (sin, cos) = marker.rotation_deg.to_radians().sin_cos();
    let reach_m = HALF_WIDTH_M * (sin.abs() + cos.abs());
    for (key, at_m, extent_m) in [("x_m", marker.x_m, scene.room.width_m), ("y_m", marker.y_m, scene.room.depth_m)] {
        if !(reach_m..=extent_m - reach_m).contains(&at_m) {
            let [least_m, most_m] = [reach_m, extent_m - reach_m].map(super::short);
            let further =
                if scene.building.rooms.is_empty() { "" } else { ", or a place wholly in a `[[building.room]]`" };
            return Some((
                key,
                format!("reaches out of the room, expected a number from {least_m} to {most_m}{further}"),
            ));
        }
    }
    None
}

fn overlap(marker: &Marker, earlier: &[Marker]) -> Problem {
    let other = earlier.iter().position(|other| other.pasted && marker.pasted && overlaps(marker, other))?;
    Some(("x_m", format!("on top of markers.marker[{other}], expected a place of its own, 0.16 m wide and deep")))
}

/// Whether the squares of two markers overlap. They do unless the whole of one square is on the outer side of one side of the other.
fn overlaps(one: &Marker, other: &Marker) -> bool {
    let between_m = [other.x_m - one.x_m, other.y_m - one.y_m];
    let turn_rad = (other.rotation_deg - one.rotation_deg).to_radians();
    // Half the extents of both markers' squares, added up, along the normal of one of their sides.
    let reach_m = HALF_WIDTH_M * (1.0 + turn_rad.sin().abs() + turn_rad.cos().abs());
    [one, other].iter().all(|marker| {
        let (sin, cos) = marker.rotation_deg.to_radians().sin_cos();
        let along_m = [cos * between_m[0] + sin * between_m[1], cos * between_m[1] - sin * between_m[0]];
        along_m.iter().all(|distance_m| distance_m.abs() < reach_m - 1e-9)
    })
}

fn too_high(marker: &Marker, markers: &Markers, scene: &Scene) -> Problem {
    let most_m = scene.building.ceiling_height_m - UNDER_CEILING_M - markers.height_tolerance_m;
    let is_too_high = marker.height_m.is_some_and(|height_m| height_m > most_m + 1e-9);
    is_too_high.then(|| {
        let (most_m, tolerance_m) = (super::short(most_m), markers.height_tolerance_m);
        ("height_m", format!("in the ceiling, expected at most {most_m}, as heights are drawn within {tolerance_m} m"))
    })
}

/// Checks that a marker hangs above the ceiling camera, at least 0.1 m above it so that an image of the marker can be taken.
fn too_low(marker: &Marker, markers: &Markers, scene: &Scene) -> Problem {
    const LEAST_RISE_M: f64 = 0.1;
    let camera = scene.robot.ceiling_camera.as_ref()?;
    let least_m = camera.height_m + camera.calibration.position_tolerance_m + markers.height_tolerance_m + LEAST_RISE_M;
    let is_too_low = markers.height_m(marker, scene) < least_m;
    is_too_low.then(|| {
        let (least_m, above_m) = (super::short(least_m), camera.height_m);
        ("height_m", format!("too near to the ceiling camera at {above_m} m, expected at least {least_m}"))
    })
}

/// Checks that a marker that was moved since the survey is still on the ceiling.
fn misplaced_outside(marker: &Marker, scene: &Scene) -> Problem {
    let moved =
        Marker { x_m: marker.x_m + marker.misplaced_m[0], y_m: marker.y_m + marker.misplaced_m[1], ..marker.clone() };
    let (_, expected) = outside(&moved, scene).filter(|_| marker.misplaced_m != [0.0; 2])?;
    Some(("misplaced_m", format!("moves it out of the room: {expected} for its place then")))
}

fn wrong_dots(marker: &Marker) -> Problem {
    let is_place = |place: &[u8; 2]| place.iter().all(|index| *index < 4);
    if let Some(place) = marker.missing_dots.iter().find(|place| !is_place(place) || !marker.is_printed(**place)) {
        return Some((
            "missing_dots",
            format!("no dot is printed at {place:?}, expected a place of its grid that has one"),
        ));
    }
    if let Some(place) = marker.extra_dots.iter().find(|place| !is_place(place) || marker.is_printed(**place)) {
        return Some((
            "extra_dots",
            format!("{place:?} cannot be one, expected a place of its grid, 0 to 3 both ways, without a dot"),
        ));
    }
    None
}
