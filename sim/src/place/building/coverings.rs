//! Floors as geometry: the floor of each room, and the coverings that lie on parts of it.

use nalgebra::{Point3, vector};

use super::{Building, LAYER_M, Material, Panel, Part, Texture, walls::layers};
use crate::scene::{Covering, Scene};

/// Flat faces (panels) of the building's geometry for the floors of all rooms, and above them those for the coverings of the scene's floor
/// regions.
pub(super) fn floor_panels(scene: &Scene, building: &Building) -> Vec<Panel> {
    let base = usual(scene);
    let layers = layers(&building.rooms);
    let mut panels: Vec<Panel> = building
        .rooms
        .iter()
        .enumerate()
        .map(|(room, enclosure)| {
            let [along, up] = enclosure.axes();
            let corner = enclosure.corner - vector![0.0, 0.0, LAYER_M * layers[room] as f64];
            let outline = enclosure.outline_on(corner, [along, up]);
            Panel { corner, along, up, material: base, part: Part::Floor, room, outline }
        })
        .collect();
    let covered =
        scene.floor.regions.iter().enumerate().filter_map(|(index, region)| Some((index, region, region.covering?)));
    for (index, region, covering) in covered {
        let [corner, along_to, opposite, up_to] = region.corners_m();
        let to = |[x, y]: [f64; 2]| vector![x - corner[0], y - corner[1], 0.0];
        let middle = [0, 1].map(|axis| (corner[axis] + opposite[axis]) / 2.0);
        panels.push(Panel {
            corner: Point3::new(corner[0], corner[1], LAYER_M * (index + 1) as f64),
            along: to(along_to),
            up: to(up_to),
            // In a wet region of the floor, the usual floor is seen through the water.
            material: if covering == Covering::Wet { wet(base) } else { material(covering, index as u32) },
            part: Part::Floor,
            room: building.room_at(Point3::new(middle[0], middle[1], 0.0)),
            outline: None,
        });
    }
    panels
}

/// Material of the floor where no region of it has another covering.
pub(super) fn usual(scene: &Scene) -> Material {
    let usual = match &scene.floor.tiles {
        Some(tiles) => Material::matt(tiles.tile_albedo).with(Texture::Tiles).glossy(0.03, 0.035),
        None => material(scene.floor.covering, 0),
    };
    usual.glossy(scene.floor.gloss.unwrap_or(usual.mirrored), usual.roughness_rad)
}

/// Mean visible albedo of a floor covering.
pub(crate) fn covering_albedo(covering: Covering) -> f64 {
    material(covering, 0).albedo[0]
}

/// Material of water that lies on another floor covering; that covering is seen through the water and around it. The water's reflectance at
/// normal incidence, ((1.33 − 1)/(1.33 + 1))² = 0.02, is also that of most varnishes.
fn wet(below: Material) -> Material {
    let seed = if below.texture == Texture::Wet { below.seed } else { below.texture as u32 };
    Material { texture: Texture::Wet, mirrored: below.mirrored.max(0.02), seed, ..below }
}

fn material(covering: Covering, seed: u32) -> Material {
    let matt = |albedo: f64, texture| Material { seed, ..Material::matt(albedo).with(texture) };
    match covering {
        Covering::Screed => matt(0.4, Texture::Plain),
        Covering::Concrete => matt(0.4, Texture::Concrete).glossy(0.03, 0.08),
        Covering::Wood => matt(0.35, Texture::Wood).glossy(0.04, 0.05),
        Covering::Carpet => matt(0.22, Texture::Carpet),
        Covering::Asphalt => matt(0.16, Texture::Asphalt),
        // A floor that is wet as a whole is taken to be wet concrete.
        Covering::Wet => Material { seed: Texture::Concrete as u32, ..matt(0.28, Texture::Wet).glossy(0.02, 0.0) },
    }
}
