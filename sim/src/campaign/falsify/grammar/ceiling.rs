//! Places ceiling markers of the scene's coding so that none overlap, and damages some of them.

use localizer::markers;
use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Dice, Draws},
    scene::{Coding, Marker, Robot},
};

use super::{
    building::inside,
    tables::{meaning, place, table, text},
};

/// Half the diagonal of a marker, which is the greatest distance of its corners from its middle.
const REACH_M: f64 = 0.115;

/// Completes the table `[markers]` of a scene drawn at random. The table is removed if the robot has no ceiling camera, the only device that sees
/// markers.
pub(super) fn settle(scene: &mut Table, draws: &Draws, room_m: [f64; 2], robot: &Robot) {
    if robot.ceiling_camera.is_none() {
        scene.remove("markers");
        return;
    }
    let markers = table(scene, "markers");
    let mut dice = draws.dice("markers");
    // A key for an automatic layout, by which the program itself places the markers, is drawn seldom: the proof that the ceiling camera sees enough
    // markers from everywhere in the room takes seconds, and for most cameras drawn at random it fails.
    if dice.chance(0.1) {
        markers.remove("marker");
        table(markers, "layout");
        return;
    }
    markers.remove("layout");
    let coding = text(markers, "coding")
        .and_then(|name| Value::String(name).try_into::<Coding>().ok())
        .unwrap_or(Coding::Hexads);
    let mut words = markers::Coding::from(coding).identities();
    let mut places: Vec<[f64; 2]> = Vec::new();
    let Some(list) = markers.get_mut("marker").and_then(Value::as_array_mut) else { return };
    list.retain_mut(|marker| {
        let Value::Table(marker) = marker else { return false };
        let word = words.swap_remove(dice.whole(0, words.len() as i64 - 1) as usize);
        // A marker that was moved since the map was made still has to lie on the ceiling, so that its place keeps more distance from the walls.
        let moved_m = if marker.contains_key("misplaced_m") { 0.1 } else { 0.0 };
        let Some(at_m) = free(&mut dice, room_m, moved_m, &places) else { return false };
        places.push(at_m);
        place(marker, at_m);
        marker.insert("id".to_owned(), Value::Integer(i64::from(word.0)));
        marker.remove("height_m");
        damage(marker, &mut dice);
        true
    });
    if list.is_empty() {
        markers.remove("marker");
    }
}

/// Draws a position on the ceiling where a marker overlaps no other; none when no such position is found.
fn free(dice: &mut Dice, room_m: [f64; 2], moved_m: f64, places: &[[f64; 2]]) -> Option<[f64; 2]> {
    /// Number of positions to try for one marker. In a room full of markers most positions are taken; a marker that finds none is left out, as a
    /// scene with fewer markers is just as useful.
    const TRIES: usize = 40;
    let is_free =
        |at_m: &[f64; 2]| places.iter().all(|other| (at_m[0] - other[0]).hypot(at_m[1] - other[1]) > 2.0 * REACH_M);
    (0..TRIES).map(|_| inside(dice, room_m, REACH_M + moved_m + 0.005)).find(is_free)
}

/// Damages some markers: a dot fell off, or dirt looks like a dot.
fn damage(marker: &mut Table, dice: &mut Dice) {
    let Some(meant) = meaning::<Marker>(marker) else { return };
    let places = (0..4_u8).flat_map(|row| (0..4_u8).map(move |column| [row, column]));
    let (printed, bare): (Vec<[u8; 2]>, Vec<[u8; 2]>) = places.partition(|place| meant.is_printed(*place));
    for (key, places, share) in [("missing_dots", printed, 0.1), ("extra_dots", bare, 0.05)] {
        if dice.chance(share) && !places.is_empty() {
            let dot = dice.choose(&places).map(|index| Value::Integer(i64::from(index)));
            marker.insert(key.to_owned(), Value::Array(vec![Value::Array(dot.to_vec())]));
        }
    }
}
