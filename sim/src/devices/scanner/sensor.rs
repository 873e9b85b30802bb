//! A planar range scanner over a drive: what its beams meet, and how far the measured distances are off.

use localizer::{
    Reading, bounds,
    methods::wall_ranges::{DEVICE, Scan},
};
use nalgebra::{Isometry3, Vector3};

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::{Bystander, sight::Obstacles},
    scene::{Scanner, Scene},
    truth::{
        Truth,
        randomness::{Repeated, stream},
    },
};

use super::DrawnScanner;

/// A planar range scanner, which makes a scan every period.
pub struct ScannerSensor {
    keys: Scanner,
    body_from_scanner: Isometry3<f64>,
    obstacles: Obstacles,
    noise: Repeated,
    clock: Repeated,
    n_readings: u64,
}

impl ScannerSensor {
    /// The scanner, mounted as drawn, among what stands in the scene.
    pub fn new(keys: &Scanner, mount: &DrawnScanner, scene: &Scene, seed: u64) -> Self {
        ScannerSensor {
            keys: keys.clone(),
            body_from_scanner: mount.body_from_scanner(keys),
            obstacles: Obstacles::new(scene),
            noise: Repeated::new(scene.robot.errors, stream(seed, "scanner.noise")),
            clock: Repeated::new(scene.robot.errors, stream(seed, "scanner.clock")),
            n_readings: 0,
        }
    }
}

impl Sensor for ScannerSensor {
    /// Returns a scan when one is due; the first one is due at once.
    fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the scan due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.keys.period_s {
            return None;
        }
        self.n_readings += 1;
        let world_from_scanner = truth.world_from_body() * self.body_from_scanner;
        let eye = world_from_scanner.translation.vector.into();
        let scan = Scan {
            first_rad: -0.5 * self.keys.field_deg.to_radians(),
            step_rad: self.keys.step_rad(),
            distances_m: Vec::new(),
        };
        let mut worst_m: f64 = 0.0;
        let beams = (0..self.keys.beams).map(|index| {
            let (sin, cos) = (scan.first_rad + index as f64 * scan.step_rad).sin_cos();
            let direction = world_from_scanner.rotation * Vector3::new(cos, sin, 0.0);
            // The error is drawn whether or not the beam meets something, so that what it meets changes no other beam's error.
            let error_m = self.noise.one_way(self.keys.tolerance_m);
            let nearest_m = self.obstacles.nearest_m(eye, direction, self.keys.range_m, people)?;
            worst_m = worst_m.max(error_m.abs());
            Some((nearest_m + error_m).max(0.0))
        });
        let scan = Scan { distances_m: beams.collect(), ..scan };
        let measured_s = truth.time_s + self.clock.one_way(self.keys.stamp_tolerance_s);
        let arrived_s = truth.time_s + self.keys.latency_s;
        let check =
            |bound, declared, true_value| BoundCheck { bound, span_s: [truth.time_s, arrived_s], declared, true_value };
        let checks = vec![
            check(bounds::SCANNER_RANGE, self.keys.tolerance_m, worst_m),
            check(bounds::SCANNER_STAMP, self.keys.stamp_tolerance_s, (measured_s - truth.time_s).abs()),
        ];
        let reading = Reading::Other { measured_s, arrived_s, device: DEVICE.to_owned(), numbers: scan.numbers() };
        Some(Observation { checks, ..Observation::new(reading, *truth) })
    }
}
