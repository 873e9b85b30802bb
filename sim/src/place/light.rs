//! Light in a building: lamps, how much of their light arrives where, and the indirect light that floors, walls and ceilings reflect.
//!
//! Everything here is double precision on the processor and free of graphics; the renderer reads the result from light maps.
//!
//! Unit: light is counted by its photons. An *equivalent* lumen, lux or candela of a band is that number of photons which a lumen, lux or
//! candela of 555 nm has, so that one conversion to electrons serves all spectra and both bands.

mod ambient;
mod daylight;
mod floor_field;
mod footprint;
mod gathered;
mod lightmap;
mod nodes;
mod occlusion;
mod parallel;
mod people;
mod radiosity;
mod reflector;
mod shadows;
mod sky;
mod source;
mod switchable;

pub use daylight::Daylight;
pub use floor_field::FloorField;
pub use lightmap::LightMap;
pub use nodes::Patch;
pub use occlusion::Occluders;
pub use people::nodes_with_people;
pub use shadows::Shadows;
pub use source::{Shape, Source, polygon_irradiance};
pub use switchable::{SwitchableLight, bake};

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use ambient::Ambient;
use sky::Horizon;

use crate::{optics::Photons, place::building::Building, scene::Scene};

/// The lighting of a building: its lamps, the things that cast shadows, and the light reflected between surfaces.
#[derive(Clone, Debug)]
pub struct Lighting {
    /// Light sources of the building, none of which moves.
    pub sources: Vec<Source>,
    /// Sun and sky of a scene outdoors.
    pub daylight: Option<Daylight>,
    /// What hides parts of the sky outdoors.
    horizon: Option<Arc<Horizon>>,
    /// Furniture and walls that cast shadows.
    pub occluders: Occluders,
    /// Light that arrives by reflection anywhere in each room.
    ambient: Ambient,
    /// Factor on all light, chosen so that the illuminance is that which the scene states.
    pub dimming: f64,
}

/// Illuminance at a point: in photometric units, and as counted by photons of the visible and of the infrared band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Illuminance {
    /// Illuminance as a luxmeter reads it.
    pub lux: f64,
    /// Illuminance in equivalent lux, in the visible and in the infrared band.
    pub by_band: [f64; 2],
}

impl Illuminance {
    /// Adds `lux` of light of one spectrum: to each band, `lux` times the photons that this spectrum has in the band per lux.
    fn add(&mut self, lux: f64, photons: Photons) {
        self.lux += lux;
        self.by_band[0] += lux * photons.visible;
        self.by_band[1] += lux * photons.infrared;
    }

    /// This illuminance plus another one times a factor.
    pub fn plus(self, factor: f64, other: Illuminance) -> Illuminance {
        Illuminance {
            lux: self.lux + factor * other.lux,
            by_band: [0, 1].map(|band| self.by_band[band] + factor * other.by_band[band]),
        }
    }

    /// This illuminance times a factor, in all units.
    pub fn times(self, factor: f64) -> Illuminance {
        Illuminance::default().plus(factor, self)
    }
}

impl Lighting {
    /// The lighting by the scene's lamps alone, without reflected light and with a factor of 1 on all light.
    pub fn direct(scene: &Scene, building: &Building) -> Lighting {
        Lighting {
            sources: if scene.outdoors.is_some() { Vec::new() } else { source::sources(scene, building) },
            daylight: scene.outdoors.as_ref().map(Daylight::new),
            horizon: scene.outdoors.is_some().then(|| Arc::new(Horizon::new(building))),
            occluders: Occluders::new(building),
            ambient: Ambient::default(),
            dimming: 1.0,
        }
    }

    /// Direct light of lamps, or of sun and sky, at a point of a surface, shadows included. Each lamp is sampled at `samples` × `samples` points.
    pub fn direct_at(&self, at: Point3<f64>, normal: Vector3<f64>, samples: usize) -> Illuminance {
        let mut sum = Illuminance::default();
        if let (Some(daylight), Some(horizon)) = (&self.daylight, &self.horizon) {
            let of_sky = daylight.diffuse_horizontal.times(horizon.share(at, normal));
            sum = daylight.direct_at(at, normal, &self.occluders).plus(1.0, of_sky);
        }
        for source in &self.sources {
            let unshadowed = source.illuminance(at, normal);
            if unshadowed > 0.0 {
                sum.add(unshadowed * self.occluders.visible_share(source, at, normal, samples), source.photons);
            }
        }
        sum.times(self.dimming)
    }

    /// Direct and reflected light at a point of a surface in a room. Each lamp is sampled at `samples` × `samples` points.
    pub fn at(&self, at: Point3<f64>, normal: Vector3<f64>, room: usize, samples: usize) -> Illuminance {
        let direct = self.direct_at(at, normal, samples);
        direct.plus(self.dimming, self.bounced(at, normal, room))
    }

    /// Light reflected onto a point of a surface in a room, before the factor on all light that yields the illuminance which the scene states.
    pub(crate) fn bounced(&self, at: Point3<f64>, normal: Vector3<f64>, room: usize) -> Illuminance {
        self.ambient.at(room, at, normal)
    }
}
