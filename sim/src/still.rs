//! One picture of each camera of a robot that stands still, exposed as its automatic exposure settles.

use image::GrayImage;
use localizer::Pose;

use crate::{
    drawn::Drawn,
    randomness,
    render::{NoiseKey, RenderError, RenderedWorld, Renderer, View},
    scene::{FloorCamera, Scene},
    sensors::{
        camera::{AutoExposure, Exposure, Photosites, floor_camera_intrinsics, world_from_floor_camera},
        lens::{Lens, world_from_camera},
    },
    truth::Truth,
};

/// Cameras of a robot by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CameraName {
    /// Looks down.
    Floor,
    /// Looks ahead.
    Forward,
    /// Looks up.
    Ceiling,
}

/// One picture with how it was exposed.
#[derive(Clone, Debug)]
pub struct Still {
    /// The camera that took it.
    pub camera: CameraName,
    /// Grey levels as the sensor gave them.
    pub image: GrayImage,
    /// How it was exposed.
    pub exposure: Exposure,
}

impl CameraName {
    /// All of them.
    pub const ALL: [CameraName; 3] = [CameraName::Floor, CameraName::Forward, CameraName::Ceiling];

    /// As scenes, commands and files call it.
    pub fn as_str(self) -> &'static str {
        match self {
            CameraName::Floor => "floor",
            CameraName::Forward => "forward",
            CameraName::Ceiling => "ceiling",
        }
    }

    /// Those of the scene's robot.
    pub fn fitted(scene: &Scene) -> Vec<CameraName> {
        let robot = &scene.robot;
        let is_fitted = |name: &CameraName| match name {
            CameraName::Floor => robot.floor_camera.is_some(),
            CameraName::Forward => robot.forward_camera.is_some(),
            CameraName::Ceiling => robot.ceiling_camera.is_some(),
        };
        CameraName::ALL.into_iter().filter(is_fitted).collect()
    }
}

/// The first views of cameras that stand still, exposed for office light.
pub fn views_at(
    scene: &Scene,
    drawn: &Drawn,
    pose: Pose,
    illuminance_at_floor_lux: f64,
    cameras: &[CameraName],
    seed: u64,
) -> Vec<View> {
    let truth = Truth { pose, ..Truth::default() };
    let stations =
        cameras.iter().filter_map(|camera| station(*camera, scene, drawn, &truth, illuminance_at_floor_lux, seed));
    stations.map(|station| station.exposed(0)).collect()
}

/// A camera that stands still: everything of its view but the exposure.
struct Station {
    view: View,
    control: AutoExposure,
}

/// Takes a picture with each of the cameras, which the robot must have; all of them at once, until exposures have settled.
///
/// # Errors
/// As [`Renderer::draw`].
pub fn take(
    renderer: &mut Renderer,
    world: &RenderedWorld,
    scene: &Scene,
    drawn: &Drawn,
    pose: Pose,
    illuminance_at_floor_lux: f64,
    (cameras, seed): (&[CameraName], u64),
) -> Result<Vec<Still>, RenderError> {
    // From office light to a tenth of a lux or to the sun takes four steps of the control; two more settle it.
    const SETTLING: u32 = 6;
    let truth = Truth { pose, ..Truth::default() };
    let mut stations: Vec<(CameraName, Station)> = cameras
        .iter()
        .filter_map(|&camera| Some((camera, station(camera, scene, drawn, &truth, illuminance_at_floor_lux, seed)?)))
        .collect();
    for image in 0..SETTLING {
        let views: Vec<View> = stations.iter().map(|(_, station)| station.exposed(image)).collect();
        let images = renderer.draw(world, &views)?;
        if image + 1 == SETTLING {
            let still = |((camera, station), image): ((CameraName, Station), GrayImage)| Still {
                camera,
                image,
                exposure: station.control.exposure(),
            };
            return Ok(stations.into_iter().zip(images).map(still).collect());
        }
        for ((_, station), image) in stations.iter_mut().zip(&images) {
            station.control.meter(image);
        }
    }
    Ok(Vec::new())
}

impl Station {
    fn exposed(&self, image: u32) -> View {
        let exposure = self.control.exposure();
        View {
            exposure_s: exposure.exposure_s,
            gain_levels_per_electron: exposure.gain_levels_per_electron,
            noise: NoiseKey { image, ..self.view.noise },
            ..self.view.clone()
        }
    }
}

fn station(
    name: CameraName,
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
    illuminance_at_floor_lux: f64,
    seed: u64,
) -> Option<Station> {
    let robot = &scene.robot;
    let (lens, electronics, pose) = match name {
        CameraName::Floor => {
            (None, robot.floor_camera.clone()?, world_from_floor_camera(truth, drawn.floor_camera.as_ref()?))
        }
        CameraName::Forward => {
            let (camera, mount) = (robot.forward_camera.as_ref()?, drawn.forward_camera.as_ref()?);
            let lens = Lens::forward(camera, mount);
            (Some(lens), electronics(camera.exposure_s), world_from_camera(truth, mount))
        }
        CameraName::Ceiling => {
            let (camera, mount) = (robot.ceiling_camera.as_ref()?, drawn.ceiling_camera.as_ref()?);
            let lens = Lens::ceiling(camera, mount);
            (Some(lens), electronics(camera.exposure_s), world_from_camera(truth, mount))
        }
    };
    let intrinsics = match (&lens, drawn.floor_camera.as_ref()) {
        (Some(lens), _) => lens.intrinsics(),
        (None, mount) => floor_camera_intrinsics(&electronics, mount?),
    };
    let control = AutoExposure::new(&electronics);
    let exposure = control.exposure();
    let view = View {
        intrinsics,
        photosites: Photosites::from(&electronics),
        world_from_camera: vec![pose],
        exposure_s: exposure.exposure_s,
        gain_levels_per_electron: exposure.gain_levels_per_electron,
        illuminance_at_floor_lux,
        noise: NoiseKey { seed: noise_seed(seed, name), image: 0 },
        lens,
    };
    Some(Station { view, control })
}

/// What turns light into grey levels behind the lenses of the forward and the ceiling camera: pixels of 3 µm at f/2.
fn electronics(exposure_s: f64) -> FloorCamera {
    FloorCamera { exposure_s, pixel_pitch_m: 3e-6, read_noise_electrons: 3.0, ..FloorCamera::default() }
}

/// The floor camera keeps the run's own seed; each other one has noise of its own.
fn noise_seed(seed: u64, name: CameraName) -> u64 {
    use rand::Rng;
    match name {
        CameraName::Floor => seed,
        _ => randomness::stream(seed, &format!("{}_camera.noise", name.as_str())).next_u64(),
    }
}
