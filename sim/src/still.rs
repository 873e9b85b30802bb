//! One picture of each camera of a robot that stands still, exposed as its automatic exposure settles.

use image::GrayImage;
use localizer::Pose;

use crate::{
    drawn::Drawn,
    randomness,
    render::{DeepImage, NoiseKey, RenderError, RenderedWorld, Renderer, View},
    scene::{BitDepth, Scene, SensorModel},
    sensors::{
        camera::{AutoExposure, Exposure, floor_camera_intrinsics, world_from_floor_camera},
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
    /// The eight most significant bits of what the sensor gave, which is what the localizer gets.
    pub image: GrayImage,
    /// Grey levels as the sensor gave them.
    pub levels: DeepImage,
    /// The sensor.
    pub sensor: SensorModel,
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
        if image + 1 == SETTLING {
            let still = |((camera, station), levels): ((CameraName, Station), DeepImage)| Still {
                camera,
                image: most_significant(&levels, station.view.sensor.bits),
                levels,
                sensor: station.view.sensor,
                exposure: station.control.exposure(),
            };
            return Ok(stations.into_iter().zip(renderer.draw_deep(world, &views)?).map(still).collect());
        }
        let images = renderer.draw(world, &views)?;
        for ((_, station), image) in stations.iter_mut().zip(&images) {
            station.control.meter(image);
        }
    }
    Ok(Vec::new())
}

/// The eight most significant bits of each level.
fn most_significant(levels: &DeepImage, bits: BitDepth) -> GrayImage {
    GrayImage::from_fn(levels.width(), levels.height(), |u, v| {
        image::Luma([bits.most_significant(levels.get_pixel(u, v).0[0])])
    })
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
    let (lens, sensor, pose) = match name {
        CameraName::Floor => (
            None,
            robot.floor_camera.as_ref()?.sensor_model(),
            world_from_floor_camera(truth, drawn.floor_camera.as_ref()?),
        ),
        CameraName::Forward => {
            let (camera, mount) = (robot.forward_camera.as_ref()?, drawn.forward_camera.as_ref()?);
            let lens = Lens::forward(camera, mount);
            (Some(lens), camera.sensor_model(), world_from_camera(truth, mount))
        }
        CameraName::Ceiling => {
            let (camera, mount) = (robot.ceiling_camera.as_ref()?, drawn.ceiling_camera.as_ref()?);
            let lens = Lens::ceiling(camera, mount);
            (Some(lens), camera.sensor_model(), world_from_camera(truth, mount))
        }
    };
    let intrinsics = match (&lens, drawn.floor_camera.as_ref()) {
        (Some(lens), _) => lens.intrinsics(),
        (None, mount) => floor_camera_intrinsics(robot.floor_camera.as_ref()?, mount?),
    };
    let control = AutoExposure::new(&sensor);
    let exposure = control.exposure();
    let view = View {
        intrinsics,
        sensor,
        world_from_camera: vec![pose],
        exposure_s: exposure.exposure_s,
        gain_levels_per_electron: exposure.gain_levels_per_electron,
        illuminance_at_floor_lux,
        noise: NoiseKey { seed: noise_seed(seed, name), image: 0 },
        lens,
    };
    Some(Station { view, control })
}

/// The floor camera keeps the run's own seed; each other one has noise of its own.
fn noise_seed(seed: u64, name: CameraName) -> u64 {
    use rand::Rng;
    match name {
        CameraName::Floor => seed,
        _ => randomness::stream(seed, &format!("{}_camera.noise", name.as_str())).next_u64(),
    }
}
