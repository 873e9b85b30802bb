//! Reads the text of a scene and makes a valid `Scene` of it.

use std::{path::Path, time::Instant};

use serde::Deserialize;
use toml::{
    Deserializer, Spanned, Table,
    de::{DeTable, DeValue},
};

use crate::{
    place::{landmark_map, navigation::map_server},
    scene::{MethodName, Scene, SceneError, Sources, conform, problem::Problem},
};

use super::{contradiction::Contradiction, places};

impl Scene {
    /// Reads the text of a scene. Errors name the text by `file`; a map that the scene names lies beside that file.
    ///
    /// Errs when the text is not TOML, extends another file, departs from the schema, or describes what is impossible: something outside the room, an
    /// event after the end, an errand to which no path leads, an expectation of an unknown figure.
    pub fn parse(text: &str, file: &str) -> Result<Scene, SceneError> {
        Scene::parse_beside(text, file, Path::new(file).parent())
    }

    /// Reads the text of a scene like [`Scene::parse`], with the map file that it names in `folder`. Without a folder the map is not read, and no
    /// paths can be planned on it.
    pub(crate) fn parse_beside(text: &str, file: &str, folder: Option<&Path>) -> Result<Scene, SceneError> {
        read(Sources::alone(text, file), folder).map(|(scene, _)| scene)
    }
}

/// Reads the scene that `sources` state; a map file that it names lies in `folder`. Also returns the whole scene as one text.
pub(super) fn read(sources: Sources, folder: Option<&Path>) -> Result<(Scene, String), SceneError> {
    let whole = sources.merged().and_then(|document| {
        let scene = valid(&document, &sources, folder)?;
        if sources.is_one() {
            return Ok((scene, sources.text().to_owned()));
        }
        let whole =
            Table::deserialize(Deserializer::from(document)).map_err(|error| vec![Problem::of_toml(&error, 0)])?;
        Ok((scene, whole.to_string()))
    });
    whole.map_err(|problems| sources.refuse(problems))
}

/// Makes a valid scene of `document`, which was merged from `sources`.
fn valid(document: &Spanned<DeTable<'_>>, sources: &Sources, folder: Option<&Path>) -> Result<Scene, Vec<Problem>> {
    let departures = conform::departures(document, sources);
    if !departures.is_empty() {
        return Err(departures);
    }
    // The schema has accepted the document, so this fails only on what a schema cannot say, such as a whole number too large for its type. The
    // derived function of the same name would leave out the bounds that `bounds_from` fills in.
    let mut scene = <Scene as Deserialize>::deserialize(Deserializer::from(document.clone()))
        .map_err(|error| vec![Problem::of_toml(&error, 0)])?;
    scene.spread_stations();
    let unreadable = survey(&mut scene, folder).and_then(|()| recall(&mut scene, folder)).err();
    let misplaced: Vec<Problem> = unreadable
        .map_or_else(|| places::contradictions(&scene), |unreadable| vec![unreadable])
        .into_iter()
        .chain(stated_twice(document))
        .map(|contradiction| contradiction.in_text(document, sources.text()))
        .collect();
    if !misplaced.is_empty() {
        return Err(misplaced);
    }
    // Markers can be laid out only for a scene that is valid otherwise.
    scene.lay_out_markers().map_err(|contradiction| vec![contradiction.in_text(document, sources.text())])?;
    Ok(scene)
}

/// The contradiction of a scene that states its light both at the floor and at the forward camera. It is found in the document, as a `Scene` does not
/// show which of its values were stated and which are defaults.
fn stated_twice(document: &Spanned<DeTable<'_>>) -> Option<Contradiction> {
    let DeValue::Table(light) = document.get_ref().get("light")?.get_ref() else { return None };
    let is_twice =
        ["illuminance_at_floor_lux", "illuminance_at_camera_lux"].iter().all(|key| light.get(*key).is_some());
    is_twice.then(|| Contradiction {
        key: "light.illuminance_at_floor_lux".to_owned(),
        expected: "stands beside `illuminance_at_camera_lux`, expected one of the two".to_owned(),
    })
}

/// Reads the map file that a scene names.
fn survey(scene: &mut Scene, folder: Option<&Path>) -> Result<(), Contradiction> {
    let Some(navigation) = &mut scene.navigation else { return Ok(()) };
    let Some((map, folder)) = navigation.map.as_ref().zip(folder) else { return Ok(()) };
    let unreadable = |error| Contradiction { key: "navigation.map".to_owned(), expected: format!("failed to {error}") };
    navigation.surveyed = Some(map_server::read(&folder.join(map)).map_err(unreadable)?);
    Ok(())
}

/// Reads the map of landmarks that a scene names.
fn recall(scene: &mut Scene, folder: Option<&Path>) -> Result<(), Contradiction> {
    let room_m = [scene.room.width_m, scene.room.depth_m];
    let (robot, methods) = (&scene.robot, &scene.localizer.methods);
    let in_pictures = methods.iter().any(|name| robot.shows_landmarks(*name));
    let Some(setup) = &mut scene.localizer.mapped_landmarks else { return Ok(()) };
    if setup.confuses() && !in_pictures && methods.contains(&MethodName::MappedLandmarks) {
        return Err(Contradiction {
            key: "localizer.mapped_landmarks.confused_share".to_owned(),
            expected: "landmarks without looks cannot be confused, expected 0, or a forward camera and no point camera"
                .to_owned(),
        });
    }
    if setup.wrong_things.is_some_and(|things| things > 0) && !in_pictures {
        return Err(Contradiction {
            key: "localizer.mapped_landmarks.wrong_things".to_owned(),
            expected: "nothing sees landmarks in pictures, expected 0, or the method `mapped_landmarks` with a forward camera and no point camera"
                .to_owned(),
        });
    }
    if setup.teaches && !setup.learns {
        return Err(Contradiction {
            key: "localizer.mapped_landmarks.teaches".to_owned(),
            expected: "a drive that learns nothing teaches nothing, expected false, or `learns = true`".to_owned(),
        });
    }
    let Some(map) = &setup.map else { return Ok(()) };
    // A whole path needs no folder.
    let folder = folder.or(Path::new(map).is_absolute().then_some(Path::new("/")));
    let Some(folder) = folder else { return Ok(()) };
    let refused = |expected| Contradiction { key: "localizer.mapped_landmarks.map".to_owned(), expected };
    let began = Instant::now();
    let known = landmark_map::read(&folder.join(map)).map_err(|error| refused(format!("failed to {error}")))?;
    let reading_s = began.elapsed().as_secs_f64();
    if known.landmarks.is_empty() {
        return Err(refused(format!("{map} has no landmark, expected a map that `wherein teach` has written")));
    }
    if known.room_m != room_m {
        let expected =
            format!("{map} is of a room of {:?} m, expected a map of this room of {room_m:?} m", known.room_m);
        return Err(refused(expected));
    }
    if in_pictures == known.looks.is_empty() {
        let [taught, wanted] = if in_pictures { ["point", "forward"] } else { ["forward", "point"] };
        return Err(refused(format!(
            "{map} was taught by a {taught} camera, expected a map taught by a {wanted} camera"
        )));
    }
    (setup.known, setup.reading_s) = (Some(known), Some(reading_s));
    Ok(())
}
