//! The optical flow sensor, which counts its own travel over the floor's surface along two axes.

use localizer::{Reading, bounds};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::{Bystander, floor::Floor},
    scene::{Distribution, Event, Flow, Region, Scene},
    truth::{
        Truth,
        randomness::{Repeated, draw_phase, draw_within, stream},
    },
};

use super::DrawnFlow;

/// The simulated flow sensor, which moves with the robot over the scene's floor.
pub struct FlowSensor {
    flow: Flow,
    mount: DrawnFlow,
    floor: Floor,
    regions: Vec<Region>,
    /// Relative error of the flow sensor's counts per metre on each floor region; the last entry is for the floor around the regions.
    surfaces: Vec<f64>,
    noise: Repeated,
    /// Further relative error of the counts per metre, caused by noise in the present period.
    noise_share: f64,
    blind: Vec<Event>,
    /// With the error distribution `drift`: the direction in the world along which all travel is counted too long. Travel against it is counted too
    /// short.
    drifts_to: Option<[f64; 2]>,
    dropouts: ChaCha8Rng,
    /// Position of each axis within a count at the start, in `[0, 1)`.
    phase: [f64; 2],
    n_readings: u64,
    before: Option<Truth>,
    period: Period,
    /// Travel that the flow sensor has counted since the start, in counts.
    followed_counts: [f64; 2],
    blind_periods: u64,
    /// Two values of the previous period, both 0 when the sensor did not follow the motion. This one is the greatest deviation of the counts per
    /// metre from those at the mounted height, as a share of the nominal counts per metre. The value `back_and_forth_m` is by how much the path was
    /// longer than the net travel that is counted, along the sensor's axis where this was greatest.
    scale_change: f64,
    back_and_forth_m: f64,
}

/// What the flow sensor has measured in the present period.
#[derive(Clone, Copy, Debug, Default)]
struct Period {
    counts: [f64; 2],
    travel_m: [f64; 2],
    path_m: [f64; 2],
    greatest_scale_change: f64,
    lost: bool,
}

impl FlowSensor {
    /// The flow sensor with its mount as drawn at random.
    pub fn new(flow: &Flow, mount: &DrawnFlow, scene: &Scene, seed: u64) -> Self {
        let (mut rng, errors) = (stream(seed, "flow.phase"), scene.robot.errors);
        let drifts_to = (errors == Distribution::Drift).then(|| {
            let (sin, cos) = stream(seed, "flow.drift").random_range(0.0..std::f64::consts::TAU).sin_cos();
            [cos, sin]
        });
        let mut surfaces = stream(seed, "flow.surfaces");
        let regions = scene.floor.regions.clone();
        let mut noise = Repeated::new(errors, stream(seed, "flow.noise"));
        let is_blind = |event: &&Event| matches!(event, Event::FlowBlind { .. });
        FlowSensor {
            mount: *mount,
            floor: Floor::new(scene),
            blind: scene.events.iter().filter(is_blind).cloned().collect(),
            surfaces: (0..=regions.len()).map(|_| draw_within(flow.surface_tolerance, errors, &mut surfaces)).collect(),
            regions,
            noise_share: noise.one_way(flow.noise_tolerance),
            noise,
            drifts_to,
            dropouts: stream(seed, "flow.dropouts"),
            phase: [draw_phase(errors, &mut rng), draw_phase(errors, &mut rng)],
            n_readings: 0,
            before: None,
            period: Period::default(),
            followed_counts: [0.0; 2],
            blind_periods: 0,
            scale_change: 0.0,
            back_and_forth_m: 0.0,
            flow: flow.clone(),
        }
    }
}

impl Sensor for FlowSensor {
    /// Returns a reading at the end of each period.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        if let Some(before) = self.before.replace(*truth) {
            self.follow(&before, truth);
        }
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.flow.period_s {
            return None;
        }
        self.n_readings += 1;
        let travel_m = self.period.travel_m;
        self.close_period(truth);
        let counted = [0, 1].map(|axis| self.followed_counts[axis] + self.phase[axis]);
        let counts = counted.map(|counted| counted.floor() as i64);
        let reading = Reading::Flow {
            measured_s: truth.time_s,
            arrived_s: truth.time_s,
            counts,
            blind_periods: self.blind_periods,
        };
        let span_s = [truth.time_s - self.flow.period_s, truth.time_s];
        let check = |bound, declared, true_value| BoundCheck { bound, span_s, declared, true_value };
        let checks = vec![
            check(bounds::FLOW_SCALE, self.flow.varying_share(), self.scale_change),
            check(bounds::FLOW_BACK_AND_FORTH, self.flow.back_and_forth_m, self.back_and_forth_m),
        ];
        Some(Observation { checks, travel_m, counted, ..Observation::new(reading, *truth) })
    }
}

impl FlowSensor {
    /// Adds the robot's travel in one physics step to the present period, as seen along the flow sensor's own axes and by its optics.
    fn follow(&mut self, before: &Truth, truth: &Truth) {
        let (from_m, to_m) = (self.place(before), self.place(truth));
        let moved = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
        let facing_rad = 0.5 * (before.pose.heading_rad + truth.pose.heading_rad) + self.mount.yaw_rad;
        let (sin, cos) = facing_rad.sin_cos();
        let travel_m = [cos * moved[0] + sin * moved[1], cos * moved[1] - sin * moved[0]];

        let ground = self.floor.at(to_m[0], to_m[1]);
        // The seen surface is closer where the carpet's pile stands up below the sensor, and farther where the body rises.
        let closer_m = ground.height_m + ground.pile_height_m - to_m[2];
        let surface = self.surface(to_m) + self.noise_share;
        let seen = self.mount.scale * (1.0 + self.flow.optics.share_per_m() * closer_m + surface);
        let scale = self.drifting(seen.max(0.0), moved);
        let speed_m_per_s = travel_m[0].hypot(travel_m[1]) / (truth.time_s - before.time_s);
        let period = &mut self.period;
        period.lost |= closer_m.abs() > self.flow.focus_range_m
            || speed_m_per_s > self.flow.greatest_speed_m_per_s
            || self.blind.iter().any(|event| event.is_on(before.time_s));
        period.greatest_scale_change = period.greatest_scale_change.max((scale - self.mount.scale).abs());
        for (axis, travel_m) in travel_m.into_iter().enumerate() {
            period.counts[axis] += travel_m * scale * self.flow.counts_per_m;
            period.travel_m[axis] += travel_m;
            period.path_m[axis] += travel_m.abs();
        }
    }

    /// Relative error of the flow sensor's counts per metre that the floor's surface at a position causes.
    fn surface(&self, [x_m, y_m, _]: [f64; 3]) -> f64 {
        let covers = |region: &Region| region.covers([x_m, y_m]);
        let region_idx = self.regions.iter().rposition(covers).unwrap_or(self.regions.len());
        self.surfaces[region_idx]
    }

    /// Counts per metre, over nominal, in one physics step: as optics and height make them or, with the error distribution `drift`, as far off as the
    /// bound `flow.scale` allows in addition to the calibration's error.
    ///
    /// Travel that is counted too long one way and too short on the way back adds up to an error, which a constant wrong scale would not.
    fn drifting(&self, scale: f64, moved: [f64; 2]) -> f64 {
        let left = (self.flow.scale_tolerance - self.flow.calibration_tolerance).max(0.0);
        let Some(to) = self.drifts_to.filter(|_| (scale - self.mount.scale).abs() <= left) else { return scale };
        self.mount.scale + left.copysign(to[0] * moved[0] + to[1] * moved[1])
    }

    /// Ends a period of the flow sensor: adds the period's counts or, when the sensor did not follow the motion, only one to the number of blind
    /// periods.
    fn close_period(&mut self, truth: &Truth) {
        let period = std::mem::take(&mut self.period);
        self.noise_share = self.noise.one_way(self.flow.noise_tolerance);
        let at_m = self.place(truth);
        // The random number for a drop-out is drawn whether or not it matters, so that one drop-out does not change the next.
        let luck: f64 = self.dropouts.random_range(0.0..1.0);
        if period.lost || luck < self.floor.at(at_m[0], at_m[1]).flow_dropout {
            self.blind_periods += 1;
            (self.scale_change, self.back_and_forth_m) = (0.0, 0.0);
            return;
        }
        (0..2).for_each(|axis| self.followed_counts[axis] += period.counts[axis]);
        let excess_m = [0, 1].map(|axis| period.path_m[axis] - period.travel_m[axis].abs());
        (self.scale_change, self.back_and_forth_m) = (period.greatest_scale_change, excess_m[0].max(excess_m[1]));
    }

    /// Position of the sensor in the world, and its height above the mounted height.
    fn place(&self, truth: &Truth) -> [f64; 3] {
        let [forward_m, left_m] = self.mount.position_m;
        let (sin, cos) = truth.pose.heading_rad.sin_cos();
        let [roll_rad, pitch_rad] = truth.tilt_rad;
        [
            truth.pose.x_m + cos * forward_m - sin * left_m,
            truth.pose.y_m + sin * forward_m + cos * left_m,
            truth.heave_m + left_m * roll_rad.sin() - forward_m * pitch_rad.sin(),
        ]
    }
}
