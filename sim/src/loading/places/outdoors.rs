//! Contradictions of a scene outdoors, and of its facades.

use super::building::{is_off, off_walls};
use crate::{
    loading::contradiction::Contradiction,
    place::building::{enclosures, standing_walls},
    scene::Scene,
};

/// All contradictions in `scene` about what is under the open sky, and about facades.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    facades(scene, found);
    let Some(outdoors) = &scene.outdoors else { return };
    let elevation_deg = outdoors.sun_elevation_deg();
    if elevation_deg <= 0.0 {
        let expected = format!(
            "puts the sun {:.1}° below the horizon, expected a time of day at {}° of latitude, as there are no lamps outdoors",
            -elevation_deg, outdoors.latitude_deg
        );
        found.push(Contradiction { key: "outdoors.solar_hour".to_owned(), expected });
    }
    let mut refuse = |is_there: bool, key: &str, expected: &str| {
        if is_there {
            found.push(Contradiction { key: key.to_owned(), expected: expected.to_owned() });
        }
    };
    let no_lamps = "stands beside `[outdoors]`, where sun and sky give the light, expected one of the two";
    refuse(!scene.lamps.is_empty(), "lamp", no_lamps);
    let has_light_event = scene.events.iter().any(|event| matches!(event, crate::scene::Event::Light { .. }));
    refuse(
        has_light_event,
        "event",
        "switches lamps, expected none beside `[outdoors]`, where sun and sky give the light",
    );
    let is_measured = scene.light.illuminance_at_camera_lux.is_some();
    let no_measure = "stands beside `[outdoors]`, whose place and time tell how bright it is, expected one of the two";
    refuse(is_measured, "light.illuminance_at_camera_lux", no_measure);
    let no_ceiling = "stands beside `[outdoors]`, where there is no ceiling, expected one of the two";
    refuse(scene.markers.is_some(), "markers", no_ceiling);
    refuse(scene.robot.ceiling_camera.is_some(), "robot.ceiling_camera", no_ceiling);
    let no_floor = "expected `floor_camera = false` beside `[outdoors]`, as the light that it is given is a room's";
    refuse(scene.robot.floor_camera.is_some(), "robot.floor_camera", no_floor);
}

/// Finds facades without a width, and facades off the walls.
fn facades(scene: &Scene, found: &mut Vec<Contradiction>) {
    if scene.building.facades.is_empty() {
        return;
    }
    let rooms = enclosures(scene);
    let walls = standing_walls(&rooms);
    for (index, facade) in scene.building.facades.iter().enumerate() {
        if facade.from_m == facade.to_m {
            let expected = "expected another place than `from_m`, as a facade has a width".to_owned();
            found.push(Contradiction { key: format!("building.facade[{index}].to_m"), expected });
        }
        for (key, foot_m) in [("from_m", facade.from_m), ("to_m", facade.to_m)] {
            if is_off(&walls, foot_m) {
                let expected = off_walls("stands", &rooms, foot_m);
                found.push(Contradiction { key: format!("building.facade[{index}].{key}"), expected });
            }
        }
    }
}
