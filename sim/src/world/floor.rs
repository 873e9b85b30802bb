//! The floor under a patch: its properties by region, as events change them.

use crate::scene::{Event, Scene};

/// Properties of the floor at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// Friction coefficient between tyre and floor.
    pub(super) friction: f64,
}

/// The floor's regions and the changes that are still to come.
#[derive(Clone, Debug)]
pub(super) struct Floor {
    elsewhere: Ground,
    regions: Vec<Patchwork>,
    changes: Vec<Change>,
    next_change: usize,
}

#[derive(Clone, Debug)]
struct Patchwork {
    x_m: [f64; 2],
    y_m: [f64; 2],
    ground: Ground,
}

#[derive(Clone, Debug)]
struct Change {
    at_s: f64,
    region_idx: Option<usize>,
    friction: f64,
}

impl Floor {
    /// The floor of a scene at time 0.
    pub(super) fn new(scene: &Scene) -> Self {
        let floor = &scene.floor;
        let regions = floor
            .regions
            .iter()
            .map(|region| Patchwork { x_m: region.x_m, y_m: region.y_m, ground: Ground { friction: region.friction } })
            .collect();
        let mut changes: Vec<Change> = scene.events.iter().filter_map(|event| change(event, scene)).collect();
        changes.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Floor { elsewhere: Ground { friction: floor.friction }, regions, changes, next_change: 0 }
    }

    /// Makes every change that is due at `time_s`.
    pub(super) fn advance_to(&mut self, time_s: f64) {
        while let Some(change) = self.changes.get(self.next_change).filter(|change| change.at_s <= time_s) {
            match change.region_idx {
                Some(region_idx) => self.regions[region_idx].ground.friction = change.friction,
                None => self.elsewhere.friction = change.friction,
            }
            self.next_change += 1;
        }
    }

    /// Properties at a point of the world; of overlapping regions the last one listed.
    pub(super) fn at(&self, x_m: f64, y_m: f64) -> Ground {
        let covers = |region: &&Patchwork| {
            region.x_m[0] <= x_m && x_m <= region.x_m[1] && region.y_m[0] <= y_m && y_m <= region.y_m[1]
        };
        self.regions.iter().rev().find(covers).map_or(self.elsewhere, |region| region.ground)
    }
}

/// The change that an event makes to the floor; an event that names no region of the scene changes nothing.
fn change(event: &Event, scene: &Scene) -> Option<Change> {
    let Event::Friction { at_s, region, friction } = event else { return None };
    let region_idx = match region {
        Some(name) => Some(scene.floor.regions.iter().position(|candidate| candidate.name == *name)?),
        None => None,
    };
    Some(Change { at_s: *at_s, region_idx, friction: *friction })
}
