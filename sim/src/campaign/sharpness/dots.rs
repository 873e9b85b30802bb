//! Images of the ceiling: what the method claims of the markers that it saw, and how markers may be printed and pasted.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{
    Claim, Map, bounds,
    map::{MarkerMap, PlacedMarker},
    markers::{GridPlace, dot_in_marker_m},
    reading::Camera,
};

use crate::{place::drawn::DrawnMarker, run::RunRecord};

use super::{
    eye::{Eye, Sight},
    history::{History, Quantity},
    kind::{Broken, Declared, Kind, Linearised, demand, within},
    number::{Number, Vector},
};

/// What is broken when more markers of an image are false than the scene's `robot.ceiling_camera.q_items` allows.
pub(super) const FALSE_MARKERS: &str = "ceiling_markers.q_items";

/// A marker as it was claimed in one image.
pub(super) struct Seen {
    pub(super) marker: PlacedMarker,
    /// Claimed dots: the place in the marker's grid, and the pixel with the bound along u and along v.
    pub(super) dots_px: Vec<(GridPlace, [f64; 3])>,
}

/// What was claimed of one image.
pub(super) struct Look {
    pub(super) stamp: usize,
    pub(super) measured_s: f64,
    /// The claimed markers that are where the map has them.
    pub(super) markers: Vec<Seen>,
    /// Number of the markers that may be false.
    pub(super) n_false: usize,
}

/// All images of the ceiling that have arrived by an instant.
pub(super) struct Dots {
    pub(super) eye: Eye,
    pub(super) map: MarkerMap,
    pub(super) looks: Vec<Look>,
}

impl Dots {
    /// What the method claimed of the images of the ceiling that have arrived by an instant.
    pub(super) fn of(record: &RunRecord, map: &Map, eye: Eye, history: &History, time_s: f64) -> Option<Dots> {
        let map = map.markers.clone()?;
        let mut dots = Dots { eye, map, looks: Vec::new() };
        let images = record.images.iter().filter(|image| image.camera == Some(Camera::Ceiling));
        for image in images.filter(|image| image.arrived_s <= time_s) {
            let Some(stamp) = history.stamp_at(image.truth.time_s) else { continue };
            let mut look =
                Look { stamp, measured_s: image.measured_s, markers: Vec::new(), n_false: image.quota.items };
            for claim in &image.claims {
                let Claim::Marker { marker, dots_px } = claim else { continue };
                let placed = dots.map.markers.iter().find(|placed| placed.id == *marker);
                let drawn = record.drawn.place.markers.iter().find(|drawn| drawn.id == *marker);
                let has = |place: GridPlace| drawn.is_some_and(|drawn| drawn.dots.iter().any(|dot| dot.place == place));
                match placed.filter(|_| dots_px.iter().all(|(place, _)| has(*place))) {
                    Some(placed) => look.markers.push(Seen { marker: *placed, dots_px: dots_px.clone() }),
                    // A marker that is not there bounds nothing, and uses up a part of the quota.
                    None => look.n_false = look.n_false.saturating_sub(1),
                }
            }
            if !look.markers.is_empty() {
                dots.looks.push(look);
            }
        }
        (!dots.looks.is_empty()).then_some(dots)
    }

    /// World coordinates of a dot.
    fn point_m<T: Number>(history: &History, marker: &PlacedMarker, place: GridPlace) -> Vector<T> {
        let id = marker.id.0;
        let value = |quantity: Quantity| T::of(history.value(quantity));
        let turn_rad = T::of(marker.rotation_rad) + value(Quantity::MarkerTurn(id));
        let (sin, cos) = (turn_rad.sin(), turn_rad.cos());
        let nominal_m = dot_in_marker_m(place);
        let [x, y] = [0, 1].map(|axis| T::of(nominal_m[axis]) + value(Quantity::Dot(id, place, axis)));
        let [centre_x, centre_y] = [0, 1].map(|axis| T::of(marker.centre_m[axis]) + value(Quantity::Marker(id, axis)));
        [centre_x + cos * x - sin * y, centre_y + sin * x + cos * y, value(Quantity::MarkerHeight(id))]
    }

    /// Whether every dot of a claimed marker is surely within its bound.
    fn holds(history: &History, sight: &Sight<Interval>, seen: &Seen) -> Result<(), [Interval; 2]> {
        for (place, [u, v, bound_px]) in &seen.dots_px {
            let (at_px, depth_m) = sight.pixel(Dots::point_m(history, &seen.marker, *place));
            for (at_px, claimed_px) in at_px.into_iter().zip([u, v]) {
                let off_px = at_px - Interval::point(*claimed_px);
                let allowed = Interval::new(-bound_px, *bound_px);
                if depth_m.lo() <= 0.0 || off_px.is_empty() || !off_px.is_subset_of(allowed) {
                    return Err([off_px, allowed]);
                }
            }
        }
        Ok(())
    }

    /// The markers that are seen, each once, with all their dots that are.
    fn seen(&self) -> BTreeMap<u16, (PlacedMarker, Vec<GridPlace>)> {
        let mut all = BTreeMap::new();
        for seen in self.looks.iter().flat_map(|look| &look.markers) {
            let (_, places) = all.entry(seen.marker.id.0).or_insert_with(|| (seen.marker, Vec::new()));
            places.extend(seen.dots_px.iter().map(|(place, _)| *place));
        }
        for (_, places) in all.values_mut() {
            places.sort_unstable();
            places.dedup();
        }
        all
    }

    /// Pairs of quantities that are limited as vectors, each with the greatest length and the bound's name.
    fn discs(&self) -> Vec<([Quantity; 2], f64, &'static str)> {
        let mut discs = Vec::new();
        for (id, (_, places)) in self.seen() {
            let placed = [0, 1].map(|axis| Quantity::Marker(id, axis));
            discs.push((placed, self.map.placement_m, bounds::MARKERS_PLACEMENT));
            let printed = places.into_iter().map(|place| [0, 1].map(|axis| Quantity::Dot(id, place, axis)));
            discs.extend(printed.map(|dot| (dot, self.map.print_m, bounds::MARKERS_PRINT)));
        }
        discs
    }
}

/// Displacement of a marker from its place on the map, its turn, its height, or the displacement of one of its dots, as it was drawn; `None` for any
/// other quantity.
pub(super) fn true_value(quantity: Quantity, map: &MarkerMap, drawn: &[DrawnMarker]) -> Option<f64> {
    let of = |id: u16| {
        let placed = map.markers.iter().find(|placed| placed.id.0 == id)?;
        Some((placed, drawn.iter().find(|drawn| drawn.id.0 == id)?))
    };
    match quantity {
        Quantity::Marker(id, axis) => of(id).map(|(placed, drawn)| drawn.centre_m[axis] - placed.centre_m[axis]),
        Quantity::MarkerTurn(id) => of(id).map(|(placed, drawn)| drawn.rotation_rad - placed.rotation_rad),
        Quantity::MarkerHeight(id) => of(id).map(|(_, drawn)| drawn.height_m),
        Quantity::Dot(id, place, axis) => {
            let (_, drawn) = of(id)?;
            let dot = drawn.dots.iter().find(|dot| dot.place == place)?;
            let off_m = [dot.centre_in_world.x - drawn.centre_m[0], dot.centre_in_world.y - drawn.centre_m[1]];
            let (sin, cos) = drawn.rotation_rad.sin_cos();
            let in_marker_m = [cos * off_m[0] + sin * off_m[1], cos * off_m[1] - sin * off_m[0]];
            Some(in_marker_m[axis] - dot_in_marker_m(place)[axis])
        }
        _ => None,
    }
}

impl Kind for Dots {
    fn declared(&self, history: &History) -> Vec<Declared> {
        let mut all = self.eye.declared(history, self.looks.iter().map(|look| (look.stamp, look.measured_s)));
        let mut put = |quantity, interval, bound| all.push(Declared { quantity, interval, bound });
        for (id, (placed, _)) in self.seen() {
            let most_rad = self.map.rotation_tolerance_rad;
            put(Quantity::MarkerTurn(id), Interval::new(-most_rad, most_rad), bounds::MARKERS_ROTATION);
            put(Quantity::MarkerHeight(id), placed.height_m, bounds::MARKERS_HEIGHT);
        }
        for (quantities, most_m, bound) in self.discs() {
            quantities.into_iter().for_each(|quantity| put(quantity, Interval::new(-most_m, most_m), bound));
        }
        all
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        self.eye.check_tilt(history, slack)?;
        for (quantities, most_m, bound) in self.discs() {
            let [x, y] = quantities.map(|quantity| Interval::point(history.value(quantity)));
            demand(slack, bound, history.stamps_s[0], x.hypot(y), within(Interval::point(most_m)))?;
        }
        for look in &self.looks {
            let sight = self.eye.sight(history, look.stamp);
            let mut n_left = look.n_false;
            for seen in &look.markers {
                if let Err([value, allowed]) = Dots::holds(history, &sight, seen) {
                    let time_s = history.stamps_s[look.stamp];
                    let broken = Broken { bound: FALSE_MARKERS, time_s, value, allowed };
                    n_left = n_left.checked_sub(1).ok_or(broken)?;
                }
            }
        }
        Ok(())
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        self.eye.add_tilt_rows(near);
        for (quantities, most_m, _) in self.discs() {
            near.add_disc(quantities, most_m);
        }
        for look in &self.looks {
            let slopes = self.eye.slopes(history, look.stamp);
            for seen in &look.markers {
                let id = seen.marker.id.0;
                let turn_rad = seen.marker.rotation_rad + history.value(Quantity::MarkerTurn(id));
                let (sin, cos) = turn_rad.sin_cos();
                for (place, [u, v, bound_px]) in &seen.dots_px {
                    let point_m = Dots::point_m(history, &seen.marker, *place);
                    let at_px = slopes.sight.pixel(point_m).0;
                    for (off_px, direction) in [(at_px[0] - u, [1.0, 0.0]), (at_px[1] - v, [0.0, 1.0])] {
                        let mut terms = slopes.terms(near, point_m, direction);
                        let [by_x, by_y, by_z] = slopes.by_point(point_m, direction);
                        let from_centre_m = [0, 1].map(|axis| {
                            point_m[axis] - seen.marker.centre_m[axis] - history.value(Quantity::Marker(id, axis))
                        });
                        terms.extend([
                            near.quantity(Quantity::Marker(id, 0), by_x),
                            near.quantity(Quantity::Marker(id, 1), by_y),
                            near.quantity(Quantity::MarkerTurn(id), by_y * from_centre_m[0] - by_x * from_centre_m[1]),
                            near.quantity(Quantity::MarkerHeight(id), by_z),
                            near.quantity(Quantity::Dot(id, *place, 0), by_x * cos + by_y * sin),
                            near.quantity(Quantity::Dot(id, *place, 1), by_y * cos - by_x * sin),
                        ]);
                        near.add(terms, off_px, Interval::new(-bound_px, *bound_px));
                    }
                }
            }
        }
    }
}
