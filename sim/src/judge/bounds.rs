//! Compares every declared bound with the true value behind it.

mod markers;
mod monitor;
mod motion;
mod tiles;
mod walls;

use std::collections::BTreeSet;

use crate::{run::RunRecord, scene::Scene};

use super::verdict::Violation;
use monitor::Monitor;

/// All time ranges in which a declared bound was exceeded, in the order in which they begin.
pub fn violations(scene: &Scene, record: &RunRecord) -> Vec<Violation> {
    let mut found: Vec<Violation> = monitors(scene, record).into_iter().flat_map(Monitor::finish).collect();
    found.sort_by(|a, b| a.from_s.total_cmp(&b.from_s).then_with(|| a.bound.cmp(&b.bound)));
    found
}

/// Names of all bounds that are watched in a run of the scene: those that an estimate may rely on.
pub fn watched(scene: &Scene, record: &RunRecord) -> BTreeSet<&'static str> {
    monitors(scene, record).iter().map(Monitor::bound).collect()
}

/// A monitor for every declared bound of the scene, with the true values of the run.
fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let mut all = motion::monitors(scene, record);
    let mut constants = record.drawn.base.constants(&scene.robot);
    constants.extend(record.drawn.devices.constants(scene));
    all.extend(
        constants.into_iter().map(|(bound, declared, true_value)| constant(record, bound, declared, true_value)),
    );
    all.extend(of_readings(record));
    all.extend(tiles::monitors(scene, record));
    all.extend(markers::monitors(scene, record));
    all.extend(walls::monitors(scene, record));
    all
}

/// Monitors of the bounds that are checked reading by reading, such as those on stamps and noise.
fn of_readings(record: &RunRecord) -> impl Iterator<Item = Monitor> {
    record.bounds.greatest.keys().map(|bound| {
        let mut monitor = Monitor::new(bound);
        for check in record.bounds.exceeded.iter().filter(|check| check.bound == *bound) {
            monitor.watch(check.span_s, check.declared, check.true_value);
        }
        monitor
    })
}

/// Makes a monitor of a bound on a value that is the same over the whole run.
fn constant(record: &RunRecord, bound: &'static str, declared: f64, true_value: f64) -> Monitor {
    let end_s = record.truths.last().map_or(0.0, |truth| truth.time_s);
    let mut monitor = Monitor::new(bound);
    monitor.watch([0.0, end_s], declared, true_value);
    monitor
}
