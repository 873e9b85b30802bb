//! One picture from each camera of a robot that stands still, with the exposure at which automatic exposure settles.

use image::GrayImage;
use localizer::{Pose, reading::Camera};

use crate::{
    optics::{AutoExposure, Exposure},
    render::{DeepImage, RenderError, RenderedWorld, Renderer, View},
    run::sensors::FittedCamera,
    scene::{BitDepth, Scene, SensorModel},
    truth::Truth,
    world::Drawn,
};

/// One picture together with its exposure.
#[derive(Clone, Debug)]
pub struct Still {
    /// The camera that took it.
    pub camera: Camera,
    /// The picture in the eight most significant bits of the sensor's grey levels, which is what the localizer gets.
    pub image: GrayImage,
    /// Grey levels of the picture, with all bits that the sensor gave.
    pub levels: DeepImage,
    /// Model of the image sensor.
    pub sensor: SensorModel,
    /// Exposure time and gain of the picture.
    pub exposure: Exposure,
}

/// The first views (pictures to take) of cameras on a robot that stands still. They are exposed for office light, before automatic exposure
/// settles.
pub fn views_at(
    scene: &Scene,
    drawn: &Drawn,
    pose: Pose,
    illuminance_at_floor_lux: f64,
    cameras: &[Camera],
    seed: u64,
) -> Vec<View> {
    stations(scene, drawn, pose, illuminance_at_floor_lux, (cameras, seed)).map(|station| station.exposed(0)).collect()
}

/// A camera of a robot that stands still, with its automatic exposure.
struct Station {
    camera: FittedCamera,
    control: AutoExposure,
    truth: Truth,
    illuminance_at_floor_lux: f64,
}

fn stations<'a>(
    scene: &'a Scene,
    drawn: &'a Drawn,
    pose: Pose,
    illuminance_at_floor_lux: f64,
    (cameras, seed): (&'a [Camera], u64),
) -> impl Iterator<Item = Station> + 'a {
    let truth = Truth { pose, ..Truth::default() };
    let fitted = cameras.iter().filter_map(move |camera| FittedCamera::new(*camera, scene, drawn, seed));
    fitted.map(move |camera| Station::new(camera, truth, illuminance_at_floor_lux))
}

/// Takes a picture with each of the given cameras, which the robot must have, all at once; pictures are repeated until exposures have settled.
///
/// # Errors
/// Returns an error where [`Renderer::draw`] does.
pub fn take(
    renderer: &mut Renderer,
    world: &RenderedWorld,
    scene: &Scene,
    drawn: &Drawn,
    pose: Pose,
    illuminance_at_floor_lux: f64,
    (cameras, seed): (&[Camera], u64),
) -> Result<Vec<Still>, RenderError> {
    // From office light to a tenth of a lux or to sunlight takes four steps of the exposure control; two more settle it.
    const SETTLING: u32 = 6;
    let mut stations: Vec<Station> = stations(scene, drawn, pose, illuminance_at_floor_lux, (cameras, seed)).collect();
    for image in 0..SETTLING {
        let views: Vec<View> = stations.iter().map(|station| station.exposed(image)).collect();
        if image + 1 == SETTLING {
            let still = |(station, levels): (Station, DeepImage)| Still {
                camera: station.camera.name,
                image: most_significant(&levels, station.camera.sensor.bits),
                levels,
                sensor: station.camera.sensor,
                exposure: station.control.exposure(),
            };
            return Ok(stations.into_iter().zip(renderer.draw_deep(world, &views)?).map(still).collect());
        }
        let images = renderer.draw(world, &views)?;
        for (station, image) in stations.iter_mut().zip(&images) {
            station.control.meter(image);
        }
    }
    Ok(Vec::new())
}

/// The eight most significant bits of each grey level.
fn most_significant(levels: &DeepImage, bits: BitDepth) -> GrayImage {
    GrayImage::from_fn(levels.width(), levels.height(), |u, v| {
        image::Luma([bits.most_significant(levels.get_pixel(u, v).0[0])])
    })
}

impl Station {
    fn new(camera: FittedCamera, truth: Truth, illuminance_at_floor_lux: f64) -> Station {
        Station { control: AutoExposure::new(&camera.sensor), camera, truth, illuminance_at_floor_lux }
    }

    fn exposed(&self, image: u32) -> View {
        self.camera.view(&[self.truth], self.control.exposure(), self.illuminance_at_floor_lux, image)
    }
}
