//! The building as geometry: flat rectangles with their materials, built from the keys of a scene.

mod body;
mod coverings;
mod doorways;
mod ground_plan;
mod mapped_walls;
mod openings;
mod panel;
mod polygon;
mod upright_box;
mod wall_things;
mod walls;

pub use body::{BodyMesh, BodyVertex, STRIDE_M, UprightBody, body_mesh};
pub(crate) use coverings::covering_albedo;
pub(crate) use ground_plan::{Doorway, GroundPlan};
pub(crate) use openings::leads_into_a_room;
pub use panel::{Material, Panel, Part, Texture};
pub(crate) use polygon::Polygon;
pub(crate) use upright_box::BoxFrame;
pub use upright_box::UprightBox;
pub(crate) use wall_things::LEAST_BETWEEN_DOORS_M;
pub use walls::Enclosure;
pub(crate) use walls::{Side, between_doors_m, enclosures, standing_walls, wall_panels};

use nalgebra::{Point3, Vector3, vector};

use crate::{
    place::drawn::{DrawnPlace, LaidTiles, markers},
    scene::{Scene, Tiles, UNDER_CEILING_M},
};

/// Height by which one of two flat surfaces in the same plane is raised when drawn, such as a covering on a floor, so that the renderer's depth
/// buffer can tell which of them is in front.
const LAYER_M: f64 = 0.001;

/// The geometry of a building: everything in it that stands still.
#[derive(Clone, Debug)]
pub struct Building {
    /// Rooms of the building: first the one that the robot drives in, then all others.
    pub rooms: Vec<Enclosure>,
    /// Whether there is open sky in place of ceilings.
    pub is_open: bool,
    /// All visible faces of the building, those of boxes such as furniture included.
    pub panels: Vec<Panel>,
    /// Number of flat faces, at the start of `panels`, that are seen in reflections in puddles. Those of door frames and window bars come after
    /// them and are left out: in a puddle nobody misses them.
    pub n_large_panels: usize,
    /// Pieces of furniture, which cast shadows.
    pub boxes: Vec<UprightBox>,
    /// The floor's tiles: the scene's keys for them, and the joints as they were truly laid.
    pub tiles: Option<(Tiles, LaidTiles)>,
    /// Retro-reflective dots in the building: those that the scene states and those of the ceiling markers.
    pub dots: Vec<RetroDot>,
}

/// A round retro-reflective dot that faces down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RetroDot {
    /// Centre of the dot, world frame.
    pub centre: Point3<f64>,
    /// Radius of the dot.
    pub radius_m: f64,
    /// The dot's coefficient of retroreflection.
    pub retroreflection_cd_per_lux_m2: f64,
}

impl Building {
    /// Builds the geometry of a scene's building.
    pub fn new(scene: &Scene, drawn: &DrawnPlace) -> Building {
        Building::furnished(scene, drawn, scene.furniture.iter().map(UprightBox::from).collect())
    }

    /// Builds the geometry of a scene's building with the given upright boxes in place of the scene's furniture.
    pub fn furnished(scene: &Scene, drawn: &DrawnPlace, boxes: Vec<UprightBox>) -> Building {
        let rooms = walls::enclosures(scene);
        let mut building = Building {
            rooms,
            is_open: scene.outdoors.is_some(),
            panels: Vec::new(),
            n_large_panels: 0,
            boxes,
            tiles: scene.floor.tiles.clone().zip(drawn.tiles.clone()),
            dots: dots(scene, drawn),
        };
        let mut panels = walls::wall_panels(scene, &building.rooms);
        panels.extend(coverings::floor_panels(scene, &building));
        if !building.is_open {
            panels.extend(walls::ceiling_panels(scene, &building.rooms));
        }
        panels.extend(doorways::panels(scene, &building));
        for piece in &building.boxes {
            panels.extend(piece.panels(building.room_at(piece.middle())));
        }
        panels.extend(wall_things::pictures(scene, &building));
        building.n_large_panels = panels.len();
        let trim = wall_things::trim(scene, &building);
        for piece in &trim {
            let seen = |panel: &Panel| !trim.iter().any(|other| other.hides(panel));
            panels.extend(piece.panels(building.room_at(piece.middle())).into_iter().filter(seen));
        }
        building.panels = panels;
        building
    }

    /// The flat faces (panels) of the building that are walls of rooms.
    pub fn walls(&self) -> impl Iterator<Item = &Panel> {
        self.panels.iter().filter(|panel| panel.part == Part::Wall)
    }

    /// Index of the room that contains the given point; 0, the robot's room, if no room does.
    pub fn room_at(&self, at: Point3<f64>) -> usize {
        self.rooms.iter().position(|room| room.contains(at)).unwrap_or(0)
    }

    /// The given point moved onto the nearest wall of a room that faces in about the direction `facing`; the unchanged point if no wall does.
    pub fn on_wall(&self, at: Point3<f64>, facing: Vector3<f64>) -> Point3<f64> {
        let sides = self.rooms.iter().flat_map(Enclosure::sides);
        let nearest = sides
            .filter(|side| side.inward.dot(&facing) > 0.9)
            .map(|side| (side.inward, side.inward.dot(&(at - side.from))))
            .min_by(|one, other| one.1.abs().total_cmp(&other.1.abs()));
        nearest.map_or(at, |(inward, before_m)| at - inward * before_m)
    }
}

fn dots(scene: &Scene, drawn: &DrawnPlace) -> Vec<RetroDot> {
    let under_ceiling_m = scene.building.ceiling_height_m - UNDER_CEILING_M;
    let stated = scene.building.dots.iter().map(|dot| RetroDot {
        centre: Point3::new(dot.x_m, dot.y_m, dot.height_m.unwrap_or(under_ceiling_m)),
        radius_m: dot.radius_m,
        retroreflection_cd_per_lux_m2: dot.retroreflection_cd_per_lux_m2,
    });
    let of_markers = scene.markers.iter().flat_map(|markers| {
        drawn.markers.iter().flat_map(|marker| &marker.dots).map(|dot| RetroDot {
            centre: dot.centre_in_world,
            radius_m: markers::DOT_RADIUS_M,
            retroreflection_cd_per_lux_m2: markers.retroreflection_cd_per_lux_m2,
        })
    });
    stated.chain(of_markers).collect()
}

/// The point at the given height above a point of the floor plan.
fn raised([x, y]: [f64; 2], height_m: f64) -> Point3<f64> {
    Point3::new(x, y, height_m)
}

/// Horizontal unit vector along a heading.
pub(crate) fn level(heading_rad: f64) -> Vector3<f64> {
    vector![heading_rad.cos(), heading_rad.sin(), 0.0]
}
