//! Daylight outdoors: the sun, which casts shadows with sharp edges, and a sky of even luminance.

use nalgebra::{Point3, Vector3};

use super::{Illuminance, Occluders};
use crate::{
    optics::Photons,
    scene::{Outdoors, Spectrum},
};

/// Distance beyond everything in a site, from which the sun is looked at.
const FAR_M: f64 = 1e4;

/// The light of sun and sky at a place and time.
#[derive(Clone, Copy, Debug)]
pub struct Daylight {
    /// Unit vector towards the sun, world frame.
    pub to_sun: Vector3<f64>,
    /// Illuminance by direct sunlight on a plane across it.
    pub direct_normal: Illuminance,
    /// Illuminance by the whole sky on a level plane in the open.
    pub diffuse_horizontal: Illuminance,
}

impl Daylight {
    /// The daylight that a scene's place and time have.
    pub fn new(outdoors: &Outdoors) -> Daylight {
        let photons = Photons::of(Spectrum::Daylight);
        let of_lux = |lux: f64| {
            let mut light = Illuminance::default();
            light.add(lux, photons);
            light
        };
        Daylight {
            to_sun: Vector3::from(outdoors.towards_sun()),
            direct_normal: of_lux(outdoors.direct_normal_lux()),
            diffuse_horizontal: of_lux(outdoors.diffuse_horizontal_lux()),
        }
    }

    /// Direct sunlight at a point of a surface, shadows included.
    pub(crate) fn direct_at(&self, at: Point3<f64>, normal: Vector3<f64>, occluders: &Occluders) -> Illuminance {
        let cosine = normal.dot(&self.to_sun);
        let from = at + normal * 0.002;
        if cosine <= 0.0 || self.direct_normal.lux <= 0.0 || occluders.block(from, from + self.to_sun * FAR_M) {
            return Illuminance::default();
        }
        self.direct_normal.times(cosine)
    }
}
