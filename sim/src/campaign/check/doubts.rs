//! What the pictures of a scene's way show that is perhaps not as its author meant it, in sentences.

use nalgebra::Point3;

use crate::{
    place::building::{Enclosure, enclosures},
    scene::{MethodName, Scene},
};

use super::{CameraCheck, MethodCheck, SceneCheck, significant};

/// At least at this share of the places some method should learn something.
const LEAST_PLACES: f64 = 0.5;
/// Of markers that are wholly in view, at least this share should be read.
const LEAST_READ: f64 = 0.9;
/// Mean grey level below which a picture may be too dark for a method.
const DARK_GREY: f64 = 20.0;
/// Share of white pixels beyond which a picture is overexposed.
const MOST_WHITE: f64 = 0.05;

/// All doubts about the scene: those that need no pictures, and those by the pictures of each camera.
pub(super) fn of(scene: &Scene, found: &SceneCheck) -> Vec<String> {
    let mut doubts = scene.remarks();
    doubts.extend(anywhere(scene));
    let lacks_map = lacks_map(scene);
    if lacks_map && scene.localizer.methods.len() == 1 {
        doubts.push(MAP_MISSING.to_owned());
    }
    let needs_map = |method: &MethodCheck| lacks_map && method.method == MAPPED_LANDMARKS;
    for camera in &found.cameras {
        doubts.extend(overexposed(camera));
        doubts.extend(markers(camera));
        let told = camera.methods.iter().filter(|method| !needs_map(method));
        doubts.extend(told.filter_map(|method| never(camera, method)));
        doubts.extend(camera.methods.iter().filter_map(|method| claims(camera, method)));
    }
    // Without a map, pictures of single places say nothing of what the method will see.
    doubts.extend(places(found).filter(|_| doubts.iter().all(|doubt| doubt != MAP_MISSING)));
    doubts
}

/// The method that locates the robot by landmarks of a map, by its name.
const MAPPED_LANDMARKS: &str = "mapped_landmarks";
/// The doubt about a scene whose only method needs a map and has none.
const MAP_MISSING: &str = "`localizer.mapped_landmarks.map`: without a map, single pictures tell nothing about the pose; expected the map that `wherein repeat` \
                           will give the scene, as with `--set localizer.mapped_landmarks.map=FILE`";

/// Whether landmarks are to be seen in pictures, and no map tells of any.
fn lacks_map(scene: &Scene) -> bool {
    scene.localizer.methods.contains(&MethodName::MappedLandmarks) && scene.localizer.mapped_landmarks().known.is_none()
}

/// Ceiling markers tell a robot that is put down anywhere where it is, if every room has some.
fn anywhere(scene: &Scene) -> Option<String> {
    let markers = scene.markers.as_ref().filter(|_| scene.localizer.methods.contains(&MethodName::CeilingMarkers))?;
    let has_markers = |room: &Enclosure| {
        markers.all().iter().any(|marker| room.contains(Point3::new(marker.x_m, marker.y_m, room.corner.z)))
    };
    // The first enclosure is the robot's own room.
    let bare = enclosures(scene)[1..].iter().position(|room| !has_markers(room));
    let bare = bare.filter(|_| scene.start.anywhere)?;
    Some(format!(
        "`building.room[{bare}]`: the robot may be put down there by `start.anywhere`, where no markers are and where it stays until the end; expected \
         markers in every room"
    ))
}

fn overexposed(camera: &CameraCheck) -> Option<String> {
    (camera.white_share_max > MOST_WHITE).then(|| {
        format!(
            "`robot.{}_camera`: up to {:.0} % of a picture is white; expected at most {:.0} %, by a shorter exposure or less light",
            camera.camera,
            100.0 * camera.white_share_max,
            100.0 * MOST_WHITE
        )
    })
}

fn markers(camera: &CameraCheck) -> Option<String> {
    let (in_view, read) = (camera.markers_in_view?, camera.markers_read?);
    ((read as f64) < LEAST_READ * in_view as f64).then(|| {
        format!(
            "`robot.{}_camera`: {read} of {in_view} markers in view are read; expected at least {:.0} %, by another exposure, a \
             sharper lens, larger images, or a lower ceiling",
            camera.camera,
            100.0 * LEAST_READ
        )
    })
}

fn never(camera: &CameraCheck, method: &MethodCheck) -> Option<String> {
    (method.constraints == 0 && method.pictures > 0).then(|| {
        // A dark picture is a reason that its author can mend.
        let dark = if camera.mean_grey[1] < DARK_GREY {
            format!(
                ", whose mean grey level is at most {:.0} in 255 with exposures of up to {} ms",
                camera.mean_grey[1],
                significant(1e3 * camera.exposure_s[1])
            )
        } else {
            String::new()
        };
        format!(
            "`localizer.methods`: `{}` learns nothing about the pose from any of {} pictures of the {} camera{dark}; expected it to, or to be left out",
            method.method, method.pictures, camera.camera
        )
    })
}

fn claims(camera: &CameraCheck, method: &MethodCheck) -> Option<String> {
    (method.beyond_quota > 0).then(|| {
        format!(
            "`localizer.methods`: in {} of {} pictures of the {} camera `{}` makes more false claims than its quota allows; expected none, as long as \
             all declared bounds hold",
            method.beyond_quota, method.pictures, camera.camera, method.method
        )
    })
}

fn places(found: &SceneCheck) -> Option<String> {
    // Where the scene has methods that read something else, those may tell of the pose.
    let any_reads = found.cameras.iter().any(|camera| !camera.methods.is_empty());
    let few = (found.places_with_constraint as f64) < LEAST_PLACES * found.n_places as f64;
    (any_reads && few).then(|| {
        let of_markers = |camera: &CameraCheck| {
            let with_marker = camera.pictures_with_marker.filter(|&with_marker| with_marker < found.n_places)?;
            Some(format!(" (a whole marker is in view at {with_marker}; `[markers.layout]` lays out enough of them)"))
        };
        let reason = found.cameras.iter().find_map(of_markers).unwrap_or_default();
        format!(
            "`localizer.methods`: at {} of {} places some method learns something about the pose from a picture{reason}; expected at least {:.0} %",
            found.places_with_constraint,
            found.n_places,
            100.0 * LEAST_PLACES
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::LandmarkMap;

    /// What a camera showed that tells a method nothing about the pose, at ten places.
    fn nothing_told_to(methods: &[&'static str]) -> SceneCheck {
        let method = |&method: &&'static str| MethodCheck {
            method,
            pictures: 10,
            constraints: 0,
            claims: 0,
            false_claims: 0,
            beyond_quota: 0,
        };
        let camera = CameraCheck {
            camera: "forward",
            exposure_s: [0.01; 2],
            mean_grey: [90.0; 2],
            white_share_max: 0.0,
            markers_in_view: None,
            markers_read: None,
            pictures_with_marker: None,
            methods: methods.iter().map(method).collect(),
        };
        SceneCheck {
            seed: 0,
            n_places: 10,
            way_m: Some(5.0),
            floor_lux: [300.0; 2],
            places_with_constraint: 0,
            without_position: Vec::new(),
            cameras: vec![camera],
            doubts: Vec::new(),
        }
    }

    #[test]
    fn a_scene_that_gets_its_map_later_is_told_how_to_be_checked_with_one() {
        let text = "duration_s = 1.0\n[room]\nwidth_m = 5.0\ndepth_m = 5.0\n[robot]\nfloor_camera = false\nforward_camera = true\n\
                    [localizer]\nmethods = [\"wall_directions\"]\n[start]\nx_m = 1.0\ny_m = 1.0\n\
                    [[route.waypoint]]\nx_m = 3.0\ny_m = 1.0\n";
        let mut scene = Scene::parse(text, "scene.toml").unwrap();
        scene.localizer.methods = vec![MethodName::MappedLandmarks];
        let found = nothing_told_to(&[MAPPED_LANDMARKS]);
        assert_eq!(of(&scene, &found), [MAP_MISSING]);
        // A scene that teaches a map has another method, which is looked at alone.
        scene.localizer.methods = vec![MethodName::WallDirections, MethodName::MappedLandmarks];
        let doubts = of(&scene, &nothing_told_to(&["wall_directions", MAPPED_LANDMARKS]));
        assert_eq!(doubts.iter().filter(|doubt| doubt.contains("learns nothing")).count(), 1, "{doubts:?}");
        assert!(doubts.iter().all(|doubt| !doubt.contains(MAPPED_LANDMARKS)), "{doubts:?}");
        // With a map, pictures that tell nothing are doubtful.
        scene.localizer.methods = vec![MethodName::MappedLandmarks];
        let (landmarks, looks) = (Vec::new(), Vec::new());
        let (views, true_eyes) = (Default::default(), Vec::new());
        let known = LandmarkMap { room_m: [5.0; 2], relies_on: Vec::new(), landmarks, looks, views, true_eyes };
        scene.localizer.mapped_landmarks.get_or_insert_default().known = Some(known);
        let doubts = of(&scene, &found);
        assert!(doubts.len() == 2 && doubts[0].contains("`mapped_landmarks` learns nothing"), "{doubts:?}");
    }
}
