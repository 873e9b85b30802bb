//! Incremental encoders, which count the whole ticks of each wheel since the start.

use std::f64::consts::TAU;

use localizer::{Reading, bounds};

use crate::{
    place::Bystander,
    scene::{Distribution, Encoders, Scene},
    truth::{
        Truth,
        randomness::{draw_phase, stream},
    },
};

use super::{BoundCheck, Observation, Sensor};

/// Time for which wheels may roll on after the encoders' last count, before they are taken to be at rest.
const SETTLED_S: f64 = 0.5;

/// The tick counters of both wheels.
#[derive(Clone, Debug)]
pub struct Encoder {
    ticks_per_turn: f64,
    /// Position of each wheel within a tick at the start, in `[0, 1)`.
    phase: [f64; 2],
}

impl Encoder {
    /// Encoders whose wheels stand anywhere within a tick at the start, or with the error distribution `corner` at the very beginning or
    /// end of a tick.
    pub fn new(encoders: &Encoders, errors: Distribution, seed: u64) -> Self {
        let mut rng = stream(seed, "encoder.phase");
        let phase = [draw_phase(errors, &mut rng), draw_phase(errors, &mut rng)];
        Encoder { ticks_per_turn: f64::from(encoders.ticks_per_turn), phase }
    }

    /// Cumulative ticks of the left and of the right wheel, `⌊angle/2π·ticks_per_turn + phase⌋`, which is 0 at the start.
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
    /// Greatest turn of the robot's body that the bound `wheels.rest` allows while the encoders count nothing; `None` where the localizer does not
    /// rely on that bound.
    rest_turn_rad: Option<f64>,
    rest: Option<Rest>,
}

/// A time of rest: since when the encoders have counted nothing.
#[derive(Clone, Copy, Debug)]
struct Rest {
    ticks: [i64; 2],
    since_s: f64,
    /// For wheels that have settled, because the encoders have counted nothing for a while: the time at which they settled, the heading at that time,
    /// and the greatest turn of the body since then.
    settled: Option<(f64, f64, f64)>,
}

impl WheelSensor {
    /// The wheel sensor with the encoders that the scene states.
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

    /// Checks the bound `wheels.rest` on the turn of the body while the encoders count nothing.
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
    /// Returns the tick counts when they are due.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
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
