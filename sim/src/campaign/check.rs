//! A look at a scene before it is run: what the robot's cameras would show along its way, and what the localizer's methods would make of it.
//!
//! ```text
//! Scene ──> way: places and headings ──> a picture of each camera at each place ──> every method that reads it ──> SceneCheck ──> doubts
//! ```
//!
//! The pictures are taken by a robot that stands still, with the exposure on which automatic exposure settles, so that motion blur and slip are not
//! in them. Lamps are as they are at the start. A method sees each picture by itself, with a prior that is no better than what is known of the start.

mod doubts;
mod stretches;
mod way;

use interval::Interval;
use localizer::{
    Claim, Method, PoseBox, Reading,
    method::{Constraint, Context, Restricts},
    pose::PoseUnion,
    quota::{Counting, Quota, share_of},
    reading::Camera,
};
use serde::Serialize;

use crate::{
    devices,
    judge::{is_true, of_most_things, wholly_in_view},
    place::{building::UprightBody, sight::Obstacles},
    render::{RenderError, Renderer},
    run::sensors::{
        LampState, LampStates,
        still::{Still, take},
    },
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use stretches::{Told, stretches};
use way::{Way, way};

pub use stretches::Stretch;

/// What was found along the way of a scene's robot.
#[derive(Clone, Debug, Serialize)]
pub struct SceneCheck {
    /// Seed of all that was drawn at random.
    pub seed: u64,
    /// Number of places at which pictures were taken.
    pub n_places: usize,
    /// Length of the way on which they lie; `None` for a scene with stations.
    pub way_m: Option<f64>,
    /// Least and greatest illuminance at the floor at these places.
    pub floor_lux: [f64; 2],
    /// Number of places at which some method learns something about the pose from a picture.
    pub places_with_constraint: usize,
    /// Stretches of the way on which no picture bounds the position; none for a scene with stations.
    pub without_position: Vec<Stretch>,
    /// What each camera showed.
    pub cameras: Vec<CameraCheck>,
    /// Sentences on what is perhaps not as its author meant it; none if nothing was found.
    pub doubts: Vec<String>,
}

/// What one camera showed at all places.
#[derive(Clone, Debug, Serialize)]
pub struct CameraCheck {
    /// The camera's name in the scene: `floor`, `forward` or `ceiling`.
    pub camera: &'static str,
    /// Shortest and longest exposure.
    pub exposure_s: [f64; 2],
    /// Least and greatest mean grey level of a picture, 0 to 255.
    pub mean_grey: [f64; 2],
    /// Greatest share of a picture's pixels that are white: clipped at the greatest grey level.
    pub white_share_max: f64,
    /// Number of markers of the map that were wholly in view, summed over all pictures; `None` for a camera that looks at no markers.
    pub markers_in_view: Option<usize>,
    /// Number of these that were read.
    pub markers_read: Option<usize>,
    /// Number of pictures with a marker of the map wholly in view.
    pub pictures_with_marker: Option<usize>,
    /// What each of the scene's methods that read this camera's pictures made of them.
    pub methods: Vec<MethodCheck>,
}

/// What one method made of a camera's pictures.
#[derive(Clone, Debug, Serialize)]
pub struct MethodCheck {
    /// The method's name.
    pub method: &'static str,
    /// Number of pictures.
    pub pictures: usize,
    /// Number of pictures that told something about the pose.
    pub constraints: usize,
    /// Number of claims about what was seen in them.
    pub claims: usize,
    /// Number of claims that are not true.
    pub false_claims: usize,
    /// Number of pictures of which more claims are false than the scene's quota of false claims allows for one picture.
    pub beyond_quota: usize,
}

/// Takes pictures along the way of the scene's robot and has the localizer's methods look at them. `at_place` is called after each place with the
/// number of places that are done and of all.
///
/// # Errors
/// Returns an error where a picture cannot be drawn.
pub fn check(
    scene: &Scene,
    seed: u64,
    renderer: &mut Renderer,
    mut at_place: impl FnMut(usize, usize),
) -> Result<SceneCheck, RenderError> {
    let drawn = Drawn::draw(scene, seed);
    let built = scene.as_built(&drawn.place);
    let mut world = renderer.upload_room(&built, &drawn)?;
    let LampState { illuminance_at_floor_lux: mean_lux, shares, .. } = LampStates::new(scene, &world).at(0.0).clone();
    world.switch_lamps(&shares);
    world.place_bodies(&scene.people.iter().filter_map(UprightBody::setting_out).collect::<Vec<_>>());
    let obstacles = Obstacles::new(&built);
    let Way { places, length_m } = way(scene, &drawn.goals_m);
    let cameras = scene.robot.cameras();
    let mut looks: Vec<Look> = cameras.iter().map(|&camera| Look::of(camera, scene)).collect();
    let (mut floor_lux, mut told) = ([f64::INFINITY, 0.0_f64], Vec::new());
    for (nth, pose) in places.iter().enumerate() {
        let lux = world.illuminance_at_lux([pose.x_m, pose.y_m]).unwrap_or(mean_lux);
        floor_lux = [floor_lux[0].min(lux), floor_lux[1].max(lux)];
        let truth = Truth { pose: *pose, ..Truth::default() };
        let stills = take(renderer, &world, scene, &drawn, *pose, mean_lux, (cameras.as_slice(), seed))?;
        let by_camera = looks.iter_mut().zip(&stills);
        let by_camera = by_camera.map(|(look, still)| look.add(still, scene, &drawn, &truth, &obstacles));
        told.push(by_camera.max().unwrap_or(Told::Nothing));
        at_place(nth + 1, places.len());
    }
    let cameras: Vec<CameraCheck> = looks.into_iter().map(|look| look.found).collect();
    let mut found = SceneCheck {
        seed,
        n_places: places.len(),
        way_m: length_m,
        floor_lux,
        places_with_constraint: told.iter().filter(|told| **told != Told::Nothing).count(),
        without_position: length_m.map(|length_m| stretches(&places, &told, length_m)).unwrap_or_default(),
        cameras,
        doubts: Vec::new(),
    };
    found.doubts = doubts::of(scene, &found);
    Ok(found)
}

/// Names of the scene's methods that read no camera, and are therefore not looked at.
pub fn without_camera(scene: &Scene) -> Vec<&'static str> {
    let reads_none = |method: &dyn Method| !Camera::ALL.iter().any(|&camera| method.reads(&reading(camera, None)));
    methods(scene).iter().filter(|method| reads_none(method.as_ref())).map(|method| method.name()).collect()
}

/// A number with about three significant digits.
pub fn significant(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.decimals$}")
}

/// One camera's figures while the pictures are taken.
struct Look {
    camera: Camera,
    found: CameraCheck,
}

impl Look {
    fn of(camera: Camera, scene: &Scene) -> Look {
        let has_markers = camera == Camera::Ceiling && scene.markers.is_some();
        let none = has_markers.then_some(0);
        let methods = methods(scene).into_iter().filter(|method| method.reads(&reading(camera, None)));
        let found = CameraCheck {
            camera: camera.as_str(),
            exposure_s: [f64::INFINITY, 0.0],
            mean_grey: [f64::INFINITY, 0.0],
            white_share_max: 0.0,
            markers_in_view: none,
            markers_read: none,
            pictures_with_marker: none,
            methods: methods
                .map(|method| MethodCheck {
                    method: method.name(),
                    pictures: 0,
                    constraints: 0,
                    claims: 0,
                    false_claims: 0,
                    beyond_quota: 0,
                })
                .collect(),
        };
        Look { camera, found }
    }

    /// Adds a picture; returns what a method learns about the pose from it.
    fn add(&mut self, still: &Still, scene: &Scene, drawn: &Drawn, truth: &Truth, obstacles: &Obstacles) -> Told {
        let found = &mut self.found;
        let n_pixels = still.image.as_raw().len().max(1) as f64;
        let mean_grey = still.image.as_raw().iter().map(|&grey| f64::from(grey)).sum::<f64>() / n_pixels;
        let n_white = still.image.as_raw().iter().filter(|&&grey| grey == u8::MAX).count();
        let exposure_s = still.exposure.exposure_s;
        found.exposure_s = [found.exposure_s[0].min(exposure_s), found.exposure_s[1].max(exposure_s)];
        found.mean_grey = [found.mean_grey[0].min(mean_grey), found.mean_grey[1].max(mean_grey)];
        found.white_share_max = found.white_share_max.max(n_white as f64 / n_pixels);
        let (reading, prior) = (reading(self.camera, Some(still)), prior(scene, truth));
        let (mut claimed, mut tells) = (Vec::new(), Told::Nothing);
        // A method may remember pictures; here each one is looked at by itself.
        for mut method in methods(scene).into_iter().filter(|method| method.reads(&reading)) {
            let Some(seen) = found.methods.iter_mut().find(|seen| seen.method == method.name()) else { continue };
            seen.pictures += 1;
            // A constraint without claims that counts as no evidence rules out no pose: a method returns it to learn from a picture.
            let says_something = |constraint: &Constraint| constraint.decides || !constraint.claims.is_empty();
            let constraint = method.constrain(&reading, &Context::at_rest(&prior)).filter(says_something);
            let Some(constraint) = constraint else { continue };
            seen.constraints += 1;
            seen.claims += constraint.claims.len();
            let wrong: Vec<&Claim> =
                constraint.claims.iter().filter(|claim| !is_true(claim, scene, drawn, truth)).collect();
            seen.false_claims += wrong.len();
            seen.beyond_quota += usize::from(is_beyond_quota(&constraint, &wrong));
            tells = tells.max(match constraint.restricts {
                Restricts::Heading => Told::Heading,
                Restricts::Pose => Told::Position,
            });
            claimed.extend(constraint.claims);
        }
        if let (Some(in_view), Some(read), Some(with_marker)) =
            (&mut found.markers_in_view, &mut found.markers_read, &mut found.pictures_with_marker)
        {
            let whole = wholly_in_view(scene, drawn, truth, obstacles);
            let is_read =
                |id| claimed.iter().any(|claim| matches!(claim, Claim::Marker { marker, .. } if *marker == id));
            *in_view += whole.len();
            *read += whole.iter().filter(|&&id| is_read(id)).count();
            *with_marker += usize::from(!whole.is_empty());
        }
        tells
    }
}

/// Whether more of a picture's claims are false than the quota of its constraint allows, if no other picture counts.
fn is_beyond_quota(constraint: &Constraint, wrong: &[&Claim]) -> bool {
    let Quota { items, things, upright, counting } = constraint.quota;
    let together = match counting {
        Counting::Alone | Counting::Readings { .. } => 0,
        Counting::Together { share, more, .. } => share_of(share, constraint.claims.len()) + more,
    };
    wrong.len() - of_most_things(wrong.iter().copied(), things) > upright + items.max(together)
}

fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    scene.localizer.methods.iter().filter_map(|name| devices::method(*name, scene, &map, &robot)).collect()
}

/// The reading that a picture is, or one without a picture.
fn reading(camera: Camera, still: Option<&Still>) -> Reading {
    Reading::Camera {
        measured_s: 0.0,
        arrived_s: 0.0,
        camera,
        exposure_s: still.map_or(0.0, |still| still.exposure.exposure_s),
        image: still.map(|still| still.image.clone()).unwrap_or_default().into(),
    }
}

/// The poses that a localizer would still hold for possible: around the true one, as far as the true start may be from the stated one.
fn prior(scene: &Scene, truth: &Truth) -> PoseUnion {
    let [x_m, y_m, heading_rad] = truth.pose.to_array();
    let around_m = |at_m: f64| Interval::centred(at_m, scene.start.tolerance_m);
    let heading = Interval::centred(heading_rad, scene.start.tolerance_deg.to_radians());
    PoseUnion::single(PoseBox::from([around_m(x_m), around_m(y_m), heading]))
}
