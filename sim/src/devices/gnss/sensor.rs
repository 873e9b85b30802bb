//! A receiver of satellite navigation over a drive: what reception the sky allows, and how far positions are off.

use localizer::{
    Reading, bounds,
    methods::gnss_positions::{DEVICE, Position},
};
use nalgebra::Point3;

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::Bystander,
    scene::{Gnss, Outage, Reception, Scene, Shadow},
    truth::{
        Truth,
        randomness::{Repeated, stream},
    },
};

use super::DrawnGnss;

/// Time between two drawn position errors, between which the error changes linearly. Errors of the sky and of echoes change over seconds,
/// so that no average over a second removes them.
const NODE_S: f64 = 5.0;

/// A satellite navigation receiver. It reports a position every period, as long as it has a solution.
pub struct GnssSensor {
    gnss: Gnss,
    mount: DrawnGnss,
    /// Position errors along x and y as shares of the tolerance for the kind of solution (fixed or floating), in the order in which they are drawn.
    errors: Repeated,
    /// Position errors at the drawn instants (nodes) before and after the present time, and the number of the first of these nodes.
    nodes: [[f64; 2]; 2],
    node: u64,
    clock: Repeated,
    n_readings: u64,
}

impl GnssSensor {
    /// The receiver, its antenna mounted as drawn.
    pub fn new(gnss: &Gnss, mount: &DrawnGnss, scene: &Scene, seed: u64) -> Self {
        let mut errors = Repeated::new(scene.robot.errors, stream(seed, "gnss.errors"));
        let nodes = [0; 2].map(|_| [0; 2].map(|_| errors.one_way(1.0)));
        GnssSensor {
            gnss: gnss.clone(),
            mount: *mount,
            errors,
            nodes,
            node: 0,
            clock: Repeated::new(scene.robot.errors, stream(seed, "gnss.clock")),
            n_readings: 0,
        }
    }

    /// True position of the satellite navigation antenna, world x and y.
    fn antenna_m(&self, truth: &Truth) -> [f64; 2] {
        let [forward_m, left_m] = self.mount.position_m;
        let antenna = truth.world_from_body() * Point3::new(forward_m, left_m, self.gnss.height_m);
        [antenna.x, antenna.y]
    }

    /// The worst kind of satellite solution to which the scene's outages at this time and shadows at this position reduce reception.
    fn reception(&self, time_s: f64, [x_m, y_m]: [f64; 2]) -> Reception {
        let is_now = |outage: &&Outage| (outage.at_s..outage.at_s + outage.lasts_s).contains(&time_s);
        let is_here = |shadow: &&Shadow| {
            let [long_m, wide_m] = shadow.size_m;
            (x_m - shadow.x_m).abs() <= 0.5 * long_m && (y_m - shadow.y_m).abs() <= 0.5 * wide_m
        };
        let (now, here) = (self.gnss.outages.iter().filter(is_now), self.gnss.shadows.iter().filter(is_here));
        let left = now.map(|outage| outage.leaves).chain(here.map(|shadow| shadow.leaves));
        left.min().unwrap_or(Reception::Fixed)
    }

    /// The position error along either axis at a time, as a share of the tolerance for the kind of solution.
    fn error_at(&mut self, time_s: f64) -> [f64; 2] {
        while time_s >= (self.node + 1) as f64 * NODE_S {
            self.nodes = [self.nodes[1], [0; 2].map(|_| self.errors.one_way(1.0))];
            self.node += 1;
        }
        let share = time_s / NODE_S - self.node as f64;
        [0, 1].map(|axis| self.nodes[0][axis] + share * (self.nodes[1][axis] - self.nodes[0][axis]))
    }
}

impl Sensor for GnssSensor {
    /// Returns a position when one is due and the receiver has a solution.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < (self.n_readings + 1) as f64 * self.gnss.period_s {
            return None;
        }
        self.n_readings += 1;
        let (antenna_m, error) = (self.antenna_m(truth), self.error_at(truth.time_s));
        // The clock's errors are drawn whether or not there is a position, so that an outage does not change what comes after it.
        let measured_s = truth.time_s + self.clock.one_way(self.gnss.stamp_tolerance_s);
        let late_s = self.gnss.latency_s + self.clock.in_turn(self.gnss.latency_tolerance_s);
        let arrived_s = truth.time_s + late_s.max(0.0);
        let (is_fixed, grade, declared_m) = match self.reception(truth.time_s, antenna_m) {
            Reception::None => return None,
            Reception::Floating => (false, bounds::GNSS_FLOATING, self.gnss.floating_tolerance_m),
            Reception::Fixed => (true, bounds::GNSS_FIXED, self.gnss.fixed_tolerance_m),
        };
        let off_m = error.map(|share| share * declared_m);
        let told = Position { at_m: [0, 1].map(|axis| antenna_m[axis] + off_m[axis]), is_fixed };
        let span_s = [truth.time_s, arrived_s];
        let check = |bound, declared, true_value| BoundCheck { bound, span_s, declared, true_value };
        let checks = vec![
            check(grade, declared_m, off_m[0].abs().max(off_m[1].abs())),
            check(bounds::GNSS_STAMP, self.gnss.stamp_tolerance_s, (measured_s - truth.time_s).abs()),
        ];
        let reading = Reading::Other { measured_s, arrived_s, device: DEVICE.to_owned(), numbers: told.numbers() };
        Some(Observation { checks, ..Observation::new(reading, *truth) })
    }
}
