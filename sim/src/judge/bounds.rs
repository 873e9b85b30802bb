//! Compares every declared bound with the true value behind it.

mod monitor;
mod motion;
mod steering;

use std::collections::BTreeSet;

use crate::{
    devices::{Look, Surroundings, WatchedBound},
    run::RunRecord,
    scene::Scene,
};

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
    all.extend(of_surroundings(scene, record));
    all
}

/// Monitors of the bounds on the robot's surroundings, which the devices compare with what truly stands there.
fn of_surroundings(scene: &Scene, record: &RunRecord) -> impl Iterator<Item = Monitor> {
    let looks = record.images.iter().map(|image| Look {
        camera: image.camera,
        truth: &image.truth,
        arrived_s: image.arrived_s,
        claims: &image.claims,
    });
    let surroundings = Surroundings { place: &record.drawn.place, end_s: end_s(record), looks: looks.collect() };
    record.drawn.devices.surroundings(scene, &surroundings).into_iter().map(|WatchedBound { bound, checks }| {
        let mut monitor = Monitor::new(bound);
        checks.iter().for_each(|check| monitor.watch(check.span_s, check.declared, check.true_value));
        monitor
    })
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
    let mut monitor = Monitor::new(bound);
    monitor.watch([0.0, end_s(record)], declared, true_value);
    monitor
}

/// Time at which the run ended.
fn end_s(record: &RunRecord) -> f64 {
    record.truths.last().map_or(0.0, |truth| truth.time_s)
}
