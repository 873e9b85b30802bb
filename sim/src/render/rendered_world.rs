//! A world on the graphics device, in the state that the next pictures show: how its lamps are switched, and where people are.

use nalgebra::Vector2;

use super::{device::Graphics, floor::Floor, room::RoomWorld};
use crate::{
    place::{
        building::{Building, UprightBody},
        light::{FloorField, LightMap, Lighting, SwitchableLight},
    },
    scene::Scene,
    world::Drawn,
};

/// A world prepared on the graphics device for drawing, made by [`Renderer::upload`](super::Renderer::upload).
#[derive(Debug)]
pub struct RenderedWorld {
    pub(super) floor: Floor,
    pub(super) room: Option<RoomWorld>,
    pub(super) lamps: Option<Lamps>,
    pub(super) graphics: Graphics,
}

/// The lamps of a world and the state in which they are.
#[derive(Debug)]
pub(super) struct Lamps {
    pub(super) building: Building,
    light: SwitchableLight,
    /// Mean illuminance at the floor of the robot's room with all lamps on.
    all_on_lux: f64,
    /// Share of their light that the lamps of each name give that events switch.
    shares: Vec<f64>,
}

impl RenderedWorld {
    /// Mean illuminance at the floor of the robot's room by the scene's lamps as they are switched, all on at first; `None` if the scene states no
    /// lamps and only the floor was uploaded.
    pub fn illuminance_at_floor_lux(&self) -> Option<f64> {
        self.lamps.as_ref().map(|lamps| lamps.all_on_lux * lamps.light.floor_share(&lamps.shares))
    }

    /// Mean illuminance at the floor of the robot's room over that with all lamps on, if the lamps of each name that the scene's events switch give
    /// these shares of their light. The names are in the order of [`Scene::switched_lamps`].
    pub fn floor_share(&self, shares: &[f64]) -> f64 {
        self.lamps.as_ref().map_or(1.0, |lamps| lamps.light.floor_share(shares))
    }

    /// Illuminance at a place of the floor by the scene's lamps, of which photons of any wavelength count like those at 555 nm; `None` where
    /// [`illuminance_at_floor_lux`](Self::illuminance_at_floor_lux) is.
    pub fn illuminance_at_lux(&self, place_m: [f64; 2]) -> Option<f64> {
        Some(self.illuminance_at_floor_lux()? * self.floor.lamplight.as_ref()?.at(Vector2::from(place_m)))
    }

    /// Switches the lamps of each name that the scene's events switch to a share of their light, in the order of [`Scene::switched_lamps`]. People
    /// have to be placed anew afterwards.
    pub fn switch_lamps(&mut self, shares: &[f64]) {
        let Some(lamps) = self.lamps.as_mut().filter(|lamps| lamps.shares != shares) else { return };
        lamps.shares = shares.to_vec();
        let (lighting, map) = lamps.light.under(shares);
        if self.floor.lamplight.is_some() {
            self.floor.lamplight = FloorField::new(&lamps.building, &map, &map.nodes);
        }
        if let Some(room) = &mut self.room {
            room.light_up(&self.graphics, (lighting, map));
        }
    }

    /// Sets where people are at the end of the exposure of the next pictures; during the exposure they walk there. Their shadows are computed
    /// here, once for all pictures.
    pub fn place_bodies(&mut self, bodies: &[UprightBody]) {
        let Some(room) = &mut self.room else { return };
        if let Some(nodes) = room.place_bodies(&self.graphics, bodies)
            && self.floor.lamplight.is_some()
        {
            self.floor.lamplight = room.floor_field(&nodes);
        }
    }
}

impl Lamps {
    /// The lamps of a scene, and their light while all are on.
    pub(super) fn of(scene: &Scene, drawn: &Drawn) -> (Lamps, (Lighting, LightMap)) {
        let building = Building::new(scene, &drawn.place);
        let light = SwitchableLight::new(scene, &building);
        let shares = vec![1.0; light.n_switched()];
        let (lighting, map) = light.under(&shares);
        let all_on_lux = map.mean_at_floor.lux * lighting.dimming;
        (Lamps { building, light, all_on_lux, shares }, (lighting, map))
    }
}
