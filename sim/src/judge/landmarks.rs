//! Compares the boxes in which a method has learnt that landmarks lie with the landmarks' true positions.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{Status, reading::LandmarkId};

use crate::{run::RunRecord, scene::Scene};

/// Figures of the landmark boxes that a method has learnt; empty when none was learnt.
///
/// `landmarks_outside` counts boxes that do not hold their landmark, and `landmarks_outside_longest_s` is the longest time from a reading after which
/// there is such a box to one after which there is none, or to the last one. `landmarks_grown` counts boxes that are no subset of the same landmark's box one
/// reading earlier, except around a time at which the localizer doubts its assumptions and takes back what it learnt. A value other than 0 of either
/// means that something is wrong.
pub(super) fn metrics(scene: &Scene, record: &RunRecord) -> BTreeMap<String, f64> {
    let mut before: BTreeMap<LandmarkId, [Interval; 2]> = BTreeMap::new();
    let (mut outside, mut grown) = (0, 0);
    let (mut since_s, mut longest_s) = (None, 0.0_f64);
    for reading in record.images.iter().filter(|reading| !reading.landmarks.is_empty()) {
        let n_before = outside;
        for (landmark, place) in &reading.landmarks {
            let Some(truth) = scene.landmarks.get(landmark.0 as usize) else { continue };
            outside += usize::from(!(place[0].contains(truth.x_m) && place[1].contains(truth.y_m)));
            let is_subset = |old: &[Interval; 2]| (0..2).all(|axis| place[axis].is_subset_of(old[axis]));
            let is_taken_back = was_in_doubt(record, reading.measured_s);
            grown += usize::from(!is_taken_back && before.get(landmark).is_some_and(|old| !is_subset(old)));
        }
        before = reading.landmarks.iter().copied().collect();
        let began_s = since_s.take().or((outside > n_before).then_some(reading.arrived_s));
        longest_s = longest_s.max(began_s.map_or(0.0, |began_s: f64| reading.arrived_s - began_s));
        since_s = began_s.filter(|_| outside > n_before);
    }
    if before.is_empty() {
        return BTreeMap::new();
    }
    let widths = before.values().map(|place| place[0].width().max(place[1].width()));
    BTreeMap::from([
        ("landmarks_known".to_owned(), before.len() as f64),
        ("landmarks_outside".to_owned(), outside as f64),
        ("landmarks_outside_longest_s".to_owned(), longest_s),
        ("landmarks_grown".to_owned(), grown as f64),
        ("landmark_width_m".to_owned(), widths.sum::<f64>() / before.len() as f64),
    ])
}

/// Whether the localizer doubted an assumption (had the status `Recovering`) around `time_s`: in the second before it or half a second after it.
fn was_in_doubt(record: &RunRecord, time_s: f64) -> bool {
    let recent = record.estimates.iter().rev().skip_while(|estimate| estimate.time_s > time_s + 0.5);
    recent.take_while(|estimate| estimate.time_s > time_s - 1.0).any(|estimate| estimate.status == Status::Recovering)
}
