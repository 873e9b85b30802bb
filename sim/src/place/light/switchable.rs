//! Light of lamps that are switched one by one. Light adds up: that of each group of lamps, reflections included, is computed once, and the light of
//! any state of the lamps is the sum over the groups, each weighted by the share of its light that it then gives.

use super::{
    Illuminance, LightMap, Lighting,
    ambient::Ambient,
    lightmap::{Baking, dimming},
};
use crate::{place::building::Building, scene::Scene};

/// The light of a building in which some lamps are switched during a run.
#[derive(Debug)]
pub struct SwitchableLight {
    /// The lighting with all lamps on.
    lighting: Lighting,
    /// Groups of lamps: those that no event switches, then those of each name that events switch, in the order of [`Scene::switched_lamps`].
    groups: Vec<Group>,
}

/// The light of lamps that are switched together.
#[derive(Debug)]
struct Group {
    /// Indices of the lamps among the building's sources.
    sources: Vec<usize>,
    map: LightMap,
    ambient: Ambient,
}

impl SwitchableLight {
    /// Computes all light in a building, for each name by which the scene's events switch lamps separately; each such name takes about as long as
    /// the light of all lamps does.
    pub fn new(scene: &Scene, building: &Building) -> SwitchableLight {
        let mut lighting = Lighting::direct(scene, building);
        let names = scene.switched_lamps();
        let group_of = |source: usize| {
            let name = scene.lamps.get(source).and_then(|lamp| lamp.name.as_deref());
            name.and_then(|name| names.iter().position(|switched| *switched == name)).map_or(0, |index| index + 1)
        };
        let baking = Baking::new(building, &lighting.sources, &lighting.occluders);
        let of_group = |group: usize| {
            let sources: Vec<usize> = (0..lighting.sources.len()).filter(|source| group_of(*source) == group).collect();
            let lamps: Vec<_> = sources.iter().map(|source| &lighting.sources[*source]).collect();
            let (map, ambient) = baking.light_of(&lamps, lighting.daylight.as_ref());
            Group { sources, map, ambient }
        };
        let groups: Vec<Group> = (0..=names.len()).map(of_group).collect();
        lighting.ambient = Ambient::sum(groups.iter().map(|group| (1.0, &group.ambient)));
        let mean_at_floor_lux = mean_at_floor(&groups, |_| 1.0).lux;
        lighting.dimming = dimming(scene, building, &lighting, mean_at_floor_lux);
        SwitchableLight { lighting, groups }
    }

    /// Number of names by which lamps are switched.
    pub fn n_switched(&self) -> usize {
        self.groups.len() - 1
    }

    /// The lighting and the light map in a state of the lamps: `shares` are those of their light that the lamps of each name give, in the order of
    /// [`Scene::switched_lamps`].
    pub fn under(&self, shares: &[f64]) -> (Lighting, LightMap) {
        let mut lighting = self.lighting.clone();
        let weighted = || self.groups.iter().enumerate().map(|(index, group)| (share_of(shares, index), group));
        for (share, group) in weighted() {
            group.sources.iter().for_each(|source| lighting.sources[*source].lumens *= share);
        }
        lighting.ambient = Ambient::sum(weighted().map(|(share, group)| (share, &group.ambient)));
        let mut map = self.groups[0].map.clone();
        for (share, group) in weighted().skip(1) {
            for (sum, node) in map.nodes.iter_mut().zip(&group.map.nodes) {
                *sum = [0, 1].map(|band| (f64::from(sum[band]) + share * f64::from(node[band])) as f32);
            }
        }
        map.mean_at_floor = mean_at_floor(&self.groups, |index| share_of(shares, index));
        (lighting, map)
    }

    /// Mean illuminance over the floor of the robot's room in a state of the lamps, over that with all lamps on.
    pub fn floor_share(&self, shares: &[f64]) -> f64 {
        let lux = |shares: &[f64]| mean_at_floor(&self.groups, |index| share_of(shares, index)).lux;
        let all_on_lux = lux(&[]);
        if all_on_lux > 0.0 { lux(shares) / all_on_lux } else { 1.0 }
    }
}

/// Computes all light in a building, with all lamps on: the reflected light, the factor on all lamps, and the light map (illuminance over all faces
/// of the building).
pub fn bake(scene: &Scene, building: &Building) -> (Lighting, LightMap) {
    SwitchableLight::new(scene, building).under(&[])
}

/// Share of its light that a group gives. The first group is always on, and so are those of which nothing is said.
fn share_of(shares: &[f64], group: usize) -> f64 {
    group.checked_sub(1).and_then(|index| shares.get(index)).copied().unwrap_or(1.0)
}

/// Mean illuminance over the floor of the robot's room by groups of lamps, each of which gives a share of its light.
fn mean_at_floor(groups: &[Group], share: impl Fn(usize) -> f64) -> Illuminance {
    let add = |sum: Illuminance, (index, group): (usize, &Group)| sum.plus(share(index), group.map.mean_at_floor);
    groups.iter().enumerate().fold(Illuminance::default(), add)
}
