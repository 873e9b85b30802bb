//! Incremental encoders: whole ticks of each wheel since the start.

use std::f64::consts::TAU;

use localizer::{Reading, bounds};

use crate::{
    place::Bystander,
    randomness::{draw_phase, stream},
    scene::{Distribution, Encoders, Scene},
    truth::Truth,
};

use super::{BoundCheck, Observation, Sensor};

/// After their last count, wheels may roll on for so long.
const SETTLED_S: f64 = 0.5;

/// Counters of both wheels.
#[derive(Clone, Debug)]
pub struct Encoder {
    ticks_per_turn: f64,
    /// Where in a tick each wheel stood at the start, `[0, 1)`.
    phase: [f64; 2],
}

impl Encoder {
    /// Encoders whose wheels stand anywhere within a tick at the start, or at its very begin or end where errors are drawn at corners.
    pub fn new(encoders: &Encoders, errors: Distribution, seed: u64) -> Self {
        let mut rng = stream(seed, "encoder.phase");
        let phase = [draw_phase(errors, &mut rng), draw_phase(errors, &mut rng)];
        Encoder { ticks_per_turn: f64::from(encoders.ticks_per_turn), phase }
    }

    /// Cumulative ticks of the left and of the right wheel: `⌊angle/2π·ticks_per_turn + phase⌋`, 0 at the start.
    pub fn latch(&self, truth: &Truth) -> [i64; 2] {
        [0, 1]
            .map(|wheel| (truth.wheel_angle_rad[wheel] / TAU * self.ticks_per_turn + self.phase[wheel]).floor() as i64)
    }
}

/// The encoders of a robot, read every period.
pub struct WheelSensor {
    encoder: Encoder,
    period_s: f64,
    n_readings: u64,
    /// What `wheels.rest` allows, where anybody relies on it.
    rest_turn_rad: Option<f64>,
    rest: Option<Rest>,
}

/// Since when the encoders have counted nothing.
#[derive(Clone, Copy, Debug)]
struct Rest {
    ticks: [i64; 2],
    since_s: f64,
    /// Once settled: since when, the heading then, and the greatest turn since.
    settled: Option<(f64, f64, f64)>,
}

impl WheelSensor {
    /// The scene's.
    pub fn new(scene: &Scene, seed: u64) -> Self {
        let encoders = &scene.robot.encoders;
        WheelSensor {
            encoder: Encoder::new(encoders, scene.robot.errors, seed),
            period_s: encoders.period_s,
            n_readings: 0,
            rest_turn_rad: scene.bounds.rest_turn_deg.filter(|_| scene.localizer.learns_gyro).map(f64::to_radians),
            rest: None,
        }
    }

    /// The turn of the body while nothing is counted.
    fn check(&mut self, truth: &Truth, ticks: [i64; 2]) -> Option<BoundCheck> {
        let declared = self.rest_turn_rad?;
        let heading_rad = truth.pose.heading_rad;
        let anew = Rest { ticks, since_s: truth.time_s, settled: None };
        let mut rest = self.rest.filter(|rest| rest.ticks == ticks).unwrap_or(anew);
        if truth.time_s >= rest.since_s + SETTLED_S {
            let (begin_s, from_rad, most_rad) = rest.settled.unwrap_or((truth.time_s, heading_rad, 0.0));
            rest.settled = Some((begin_s, from_rad, most_rad.max((heading_rad - from_rad).abs())));
        }
        self.rest = Some(rest);
        let (begin_s, _, true_value) = rest.settled.unwrap_or((truth.time_s, heading_rad, 0.0));
        Some(BoundCheck { bound: bounds::WHEELS_REST, span_s: [begin_s, truth.time_s], declared, true_value })
    }
}

impl Sensor for WheelSensor {
    /// Answers with counts when they are due.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack, so that a period in decimal seconds falls on its step.
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.period_s {
            return None;
        }
        self.n_readings += 1;
        let ticks = self.encoder.latch(truth);
        let checks = Vec::from_iter(self.check(truth, ticks));
        let reading = Reading::Wheels { measured_s: truth.time_s, arrived_s: truth.time_s, ticks };
        Some(Observation { checks, ..Observation::new(reading, *truth) })
    }
}
