//! Facades: stretches of walls of brick, with windows and doors.

use nalgebra::vector;

use super::{DOOR_TO_WALL_M, Side};
use crate::{
    place::building::{Material, Panel, Part, Texture, raised},
    scene::{Facade, Scene},
};

/// A stretch of a room's side, as shares of its length, cut where facades begin and end. Each part has the first facade that covers it.
pub(super) fn cut<'a>(scene: &'a Scene, side: &Side, [low, high]: [f64; 2]) -> Vec<(Option<&'a Facade>, [f64; 2])> {
    let facades = scene.building.facades.iter();
    let placed: Vec<(&Facade, [f64; 2])> =
        facades.filter_map(|facade| Some((facade, stretch(facade, side)?))).collect();
    let mut cuts: Vec<f64> =
        placed.iter().flat_map(|(_, shares)| *shares).filter(|at| *at > low && *at < high).collect();
    cuts.extend([low, high]);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let of_part = |ends: &[f64]| {
        let middle = 0.5 * (ends[0] + ends[1]);
        let covering = placed.iter().find(|(_, shares)| (shares[0]..shares[1]).contains(&middle));
        (covering.map(|(facade, _)| *facade), [ends[0], ends[1]])
    };
    cuts.windows(2).map(of_part).collect()
}

/// The part of a room's side along which a facade stands, as shares of its length; `None` if the facade is on another line. A facade may go on along a
/// side of the next room.
fn stretch(facade: &Facade, side: &Side) -> Option<[f64; 2]> {
    let along = side.to - side.from;
    let feet = [facade.from_m, facade.to_m].map(|foot| raised(foot, 0.0) - side.from);
    if feet.iter().any(|foot| side.inward.dot(foot).abs() > DOOR_TO_WALL_M) {
        return None;
    }
    let [one, other] = feet.map(|foot| (foot.dot(&along) / along.norm_squared()).clamp(0.0, 1.0));
    (one != other).then(|| [one.min(other), one.max(other)])
}

/// The flat face of a facade over a part of a wall, between two heights.
pub(super) fn panel(facade: &Facade, side: &Side, shares: [f64; 2], between_m: [f64; 2], room: usize) -> Panel {
    let way = side.to - side.from;
    Panel {
        corner: side.from + way * shares[1] + vector![0.0, 0.0, between_m[0]],
        along: way * (shares[0] - shares[1]),
        up: vector![0.0, 0.0, between_m[1] - between_m[0]],
        material: Material { seed: facade.number, ..Material::matt(facade.albedo).with(Texture::Facade) },
        part: Part::Wall,
        room,
        outline: None,
    }
}
