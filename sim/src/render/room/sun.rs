//! Direct sunlight on the graphics device: where the sun stands, how strong it is, and the people who stand in it.

use bytemuck::{Pod, Zeroable};

use crate::place::{
    building::UprightBody,
    light::{Daylight, Lighting},
};

/// Greatest number of people who cast shadows in the sun, as in world.wgsl: as many as a small uniform buffer holds.
const MOST_SHADES: usize = 64;

/// Device layout of `Sun` of world.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct SunOnDevice {
    towards: [f32; 4],
    n_people: u32,
    padding: [u32; 3],
    people: [[[f32; 4]; 2]; MOST_SHADES],
}

impl SunOnDevice {
    /// The sun of a building in one band (visible or infrared), and the people before it; all zero without a sky.
    pub(super) fn new(lighting: &Lighting, people: &[UprightBody], band: usize) -> SunOnDevice {
        let mut sun = SunOnDevice::zeroed();
        let Some(Daylight { to_sun, direct_normal, .. }) = &lighting.daylight else { return sun };
        sun.towards = [to_sun.x, to_sun.y, to_sun.z, direct_normal.by_band[band]].map(|number| number as f32);
        sun.n_people = people.len().min(MOST_SHADES) as u32;
        for (place, person) in sun.people.iter_mut().zip(people) {
            let ([x, y], [along_x, along_y]) = (person.middle_m, person.velocity_m_per_s);
            let numbers = [[x, y, person.radius_m, person.height_m], [along_x, along_y, 0.0, 0.0]];
            *place = numbers.map(|row| row.map(|number| number as f32));
        }
        sun
    }
}
