//! The floor under a point: its properties by region, which events may change.

use crate::scene::{Event, Region, Scene};

/// Properties of the floor at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// Friction coefficient between tyre and floor.
    pub(crate) friction: f64,
    /// Stiffness of the carpet's pile, which combines with that of the tyre like two springs in series; `None` on a hard floor.
    pub(crate) pile_stiffness: Option<f64>,
    /// Displacement of a wheel by the carpet's nap for every metre rolled, world frame.
    pub(crate) nap: [f64; 2],
    /// Drag of the floor on wheels and casters, as a share of their load.
    pub(crate) drag: f64,
    /// Height of the surface that wheels roll on.
    pub(crate) height_m: f64,
    /// Slope of the surface that wheels roll on: its rise per metre along world x and y.
    pub(crate) slope: [f64; 2],
    /// Height of the tips of the carpet's pile above the surface that wheels roll on.
    pub(crate) pile_height_m: f64,
    /// Share of a flow sensor's periods in which it finds nothing on the floor to follow.
    pub(crate) flow_dropout: f64,
}

/// The floor's regions, and those changes of the floor by the scene's events that are still to come.
#[derive(Clone, Debug)]
pub(crate) struct Floor {
    elsewhere: Ground,
    regions: Vec<Patchwork>,
    changes: Vec<Change>,
    next_change: usize,
}

#[derive(Clone, Debug)]
struct Patchwork {
    region: Region,
    /// Properties of the floor well inside the region, where the ramps at the region's edges have ended.
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
    pub(crate) fn new(scene: &Scene) -> Self {
        let floor = &scene.floor;
        let elsewhere = Ground {
            friction: floor.friction,
            pile_stiffness: None,
            nap: [0.0; 2],
            drag: 0.0,
            height_m: 0.0,
            slope: [0.0; 2],
            pile_height_m: 0.0,
            flow_dropout: floor.flow_dropout,
        };
        let regions = floor.regions.iter().map(|region| Patchwork::new(region, &elsewhere)).collect();
        let mut changes: Vec<Change> = scene.events.iter().filter_map(|event| change(event, scene)).collect();
        changes.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Floor { elsewhere, regions, changes, next_change: 0 }
    }

    /// Applies every change of the floor by an event of the scene that is due at `time_s`.
    pub(crate) fn advance_to(&mut self, time_s: f64) {
        while let Some(change) = self.changes.get(self.next_change).filter(|change| change.at_s <= time_s) {
            match change.region_idx {
                Some(region_idx) => self.regions[region_idx].ground.friction = change.friction,
                None => self.elsewhere.friction = change.friction,
            }
            self.next_change += 1;
        }
    }

    /// Properties of the floor at a point of the world. Where regions overlap, the last one listed holds.
    pub(crate) fn at(&self, x_m: f64, y_m: f64) -> Ground {
        let covers = |patch: &&Patchwork| patch.region.covers([x_m, y_m]);
        self.regions.iter().rev().find(covers).map_or(self.elsewhere, |patch| patch.at([x_m, y_m]))
    }
}

impl Patchwork {
    fn new(region: &Region, elsewhere: &Ground) -> Self {
        let (sin, cos) = region.nap_direction_deg.to_radians().sin_cos();
        let ground = Ground {
            friction: region.friction,
            pile_stiffness: region.pile_stiffness,
            nap: [region.nap_drift * cos, region.nap_drift * sin],
            drag: region.drag,
            height_m: region.height_m,
            slope: [0.0; 2],
            pile_height_m: region.pile_height_m,
            flow_dropout: region.flow_dropout.unwrap_or(elsewhere.flow_dropout),
        };
        Patchwork { region: region.clone(), ground }
    }

    /// Properties of the floor at a point inside the region. Along the region's edges runs a ramp; over its width the height rises evenly with
    /// the distance from the nearest edge.
    fn at(&self, at_m: [f64; 2]) -> Ground {
        let region = &self.region;
        let [x_m, y_m] = region.unturned(at_m);
        let inwards = [
            (x_m - region.x_m[0], [1.0, 0.0]),
            (region.x_m[1] - x_m, [-1.0, 0.0]),
            (y_m - region.y_m[0], [0.0, 1.0]),
            (region.y_m[1] - y_m, [0.0, -1.0]),
        ];
        let from = |nearest: (f64, [f64; 2]), edge: (f64, [f64; 2])| if edge.0 < nearest.0 { edge } else { nearest };
        let (inside_m, direction) = inwards.into_iter().fold((region.ramp_m, [0.0; 2]), from);
        if self.ground.height_m == 0.0 || inside_m >= region.ramp_m {
            return self.ground;
        }
        let rise = self.ground.height_m / region.ramp_m;
        let slope = region.direction_in_world(direction).map(|along| rise * along);
        Ground { height_m: rise * inside_m, slope, ..self.ground }
    }
}

/// The change that an event makes to the floor's friction: in the region that it names, or outside all regions if it names none. An event that names
/// a region which the scene does not have changes nothing.
fn change(event: &Event, scene: &Scene) -> Option<Change> {
    let Event::Friction { at_s, region, friction } = event else { return None };
    let region_idx = match region {
        Some(name) => Some(scene.floor.regions.iter().position(|candidate| candidate.name == *name)?),
        None => None,
    };
    Some(Change { at_s: *at_s, region_idx, friction: *friction })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A carpet of 1 m by 0.5 m about (2, 1.5), turned by 30°, with ramps of 0.1 m up to a height of 0.02 m.
    fn floor() -> Floor {
        let text = "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[start]\nx_m = 0.5\ny_m = 0.5\n[[route.waypoint]]\nx_m = 2.0\n\
                    y_m = 1.5\n[floor]\nfriction = 0.8\n[[floor.region]]\nname = \"carpet\"\nx_m = [1.5, 2.5]\n\
                    y_m = [1.25, 1.75]\nrotation_deg = 30\nfriction = 0.4\nheight_m = 0.02\nramp_m = 0.1\n";
        let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        Floor::new(&scene)
    }

    /// The point that is so far along and across the turned carpet from its middle.
    fn on_carpet(along_m: f64, across_m: f64) -> [f64; 2] {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        [2.0 + cos * along_m - sin * across_m, 1.5 + sin * along_m + cos * across_m]
    }

    #[test]
    fn a_turned_region_lies_where_its_corners_are_turned_to() {
        let floor = floor();
        let friction = |along_m: f64, across_m: f64| {
            let [x_m, y_m] = on_carpet(along_m, across_m);
            floor.at(x_m, y_m).friction
        };
        for (along, across) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            assert_eq!(friction(0.49 * along, 0.24 * across), 0.4);
            assert_eq!(friction(0.51 * along, 0.24 * across), 0.8);
            assert_eq!(friction(0.49 * along, 0.26 * across), 0.8);
        }
        // The corner of the region before it was turned.
        assert_eq!(floor.at(2.49, 1.26).friction, 0.8);
    }

    #[test]
    fn the_slope_of_a_turned_ramp_is_the_derivative_of_its_height() {
        let floor = floor();
        let places = [((0.45, 0.0), 0.01), ((-0.47, 0.05), 0.006), ((0.1, 0.22), 0.006), ((0.2, -0.2), 0.01)];
        for ((along_m, across_m), height_m) in places {
            let [x_m, y_m] = on_carpet(along_m, across_m);
            let ground = floor.at(x_m, y_m);
            assert!((ground.height_m - height_m).abs() < 1e-12, "{ground:?}");
            let height = |dx: f64, dy: f64| floor.at(x_m + dx, y_m + dy).height_m;
            let by_difference = [height(1e-6, 0.0) - height(-1e-6, 0.0), height(0.0, 1e-6) - height(0.0, -1e-6)];
            for (slope, difference) in ground.slope.into_iter().zip(by_difference) {
                assert!((slope - difference / 2e-6).abs() < 1e-6, "{ground:?}");
            }
        }
        let middle = floor.at(2.0, 1.5);
        assert_eq!((middle.height_m, middle.slope), (0.02, [0.0; 2]));
    }
}
