//! The wheels' motion since a stamp, integrated one reading at a time.
//!
//! With R the distance rolled by the axle middle according to the ticks, e the error of its travel, L its lateral travel and φ the true heading
//! relative to the start, the displacement is ∫ (cos φ, sin φ) d(R + e) plus the side slip's ∫ (−sin φ, cos φ) dL. Only the totals |e| and |L|
//! are bounded, not their parts; summation by parts turns ∫ cos φ de into e·cos φ at the end and a remainder of at most |e| times the total
//! turning.

use interval::{Interval, IntervalBox};

use crate::robot::{Reach, WheelModel};

use super::{
    Motion, WheelSample,
    steering::{Steered, SteeringIntegral},
};

/// Motion by the wheels since a stamp.
#[derive(Clone, Debug)]
pub struct WheelIntegral {
    start: WheelSample,
    latest: WheelSample,
    /// For each wheel, the sum Σ Δn·cos φ of ticks times the heading's cosine over the readings, in ticks.
    cos_ticks: [Interval; 2],
    /// For each wheel, the sum Σ Δn·sin φ of ticks times the heading's sine over the readings, in ticks.
    sin_ticks: [Interval; 2],
    /// For each wheel, the sum Σ |Δn| of the ticks rolled without regard to sign.
    path_ticks: [f64; 2],
    /// Heading of the robot at the latest sample, relative to its heading at the start of the integral.
    turn_rad: Interval,
    /// Greatest total turning since the start: the sum of |Δφ| over the readings.
    turning_rad: f64,
    /// Bound on the displacement error, in metres, from using the heading at the middle of each step for the whole step (midpoint rule).
    remainder_m: f64,
    /// The turn by a car's steering.
    steering: SteeringIntegral,
}

/// What is known of the robot's turn from elsewhere than its wheels.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownTurns {
    /// Enclosure of the turn since the start of the integral.
    pub since_start_rad: Option<Interval>,
    /// Enclosure of the turn since the latest sample.
    pub in_step_rad: Option<Interval>,
    /// The steering of a car since the latest sample.
    pub steered: Option<Steered>,
}

impl WheelIntegral {
    /// An integral of the wheels' motion at its start, without motion.
    pub fn new(start: WheelSample) -> Self {
        WheelIntegral {
            start,
            latest: start,
            cos_ticks: [Interval::ZERO; 2],
            sin_ticks: [Interval::ZERO; 2],
            path_ticks: [0.0; 2],
            turn_rad: Interval::ZERO,
            turning_rad: 0.0,
            remainder_m: 0.0,
            steering: SteeringIntegral::new(&start),
        }
    }

    /// Stamp at which the integral of the wheels' motion begins.
    pub fn start_s(&self) -> f64 {
        self.start.time_s
    }

    /// Stamp of the latest sample up to which the motion is integrated.
    pub fn latest_s(&self) -> f64 {
        self.latest.time_s
    }

    /// Time since the start.
    fn lasts_s(&self) -> f64 {
        self.latest.time_s - self.start.time_s
    }

    /// Greatest total turning since the start: a bound on ∫ |dφ|.
    pub(super) fn turning_rad(&self) -> f64 {
        self.turning_rad
    }

    /// Carries the integral on to the next sample, which must be later than the latest one; a sample with the same stamp changes nothing.
    ///
    /// If the turn since the start that is known otherwise has nothing in common with the wheels' turn, the turn becomes empty.
    pub fn advance(&mut self, sample: &WheelSample, known: KnownTurns, wheels: &WheelModel, reach: &Reach) {
        let step_s = sample.time_s - self.latest.time_s;
        if step_s <= 0.0 {
            return;
        }
        let delta = [0, 1].map(|wheel| sample.ticks[wheel] - self.latest.ticks[wheel]);
        // Uncertainty of the ticks counted in the step: 1 for the encoder's quantisation, and more where the counts at an end are interpolated
        // between readings or extrapolated beyond the latest one.
        let counts = 1.0 + self.latest.ticks_error + sample.ticks_error;
        let turn_before = self.turn_rad;
        self.latest = *sample;
        (0..2).for_each(|wheel| self.path_ticks[wheel] += delta[wheel].abs());
        let travel = [self.travel(0, wheels), self.travel(1, wheels)];
        // θ̇ = (v_r − v_l)/W, Eq. (2c) of paper 1, with the track width W, is exact for the true travels of the two wheels' contact points.
        self.turn_rad = (travel[1] - travel[0]) / wheels.track_m;
        if let Some(turn_rad) = known.since_start_rad {
            self.turn_rad = self.turn_rad.intersect(turn_rad);
        }
        let travel_m = greatest_travel(delta, counts, step_s, wheels);
        self.steering.advance(known.steered.as_ref(), sample, delta, travel_m, step_s, reach);
        if let Some(turn_rad) = known.steered.and_then(|steered| self.steered_turn(&steered, wheels)) {
            self.turn_rad = self.turn_rad.intersect(turn_rad);
        }

        // The enclosures of the heading at the two ends of a step share the errors of all that happened since the start. So the turn in the step is
        // computed from the step's own ticks, which is much tighter than the difference of the two enclosures. A single tick of a coarse encoder
        // allows more turn than the robot can make in a step, so that what is known otherwise counts. Where the two exclude each other, a declared
        // bound is broken, and the turn by the ticks alone is kept: the turn since the start tells such contradictions.
        let by_ticks_rad = self.step_turn(delta, counts, step_s, wheels);
        let both_rad = known.in_step_rad.map_or(by_ticks_rad, |turn_rad| by_ticks_rad.intersect(turn_rad));
        let step_turn_rad = if both_rad.is_empty() { by_ticks_rad } else { both_rad };
        let middle = (turn_before + self.turn_rad) * 0.5;
        let half = 0.5 * step_turn_rad.magnitude();
        self.turning_rad += 2.0 * half + half * half / 6.0;
        // The chord of an arc of angle Δφ is sinc(h) times as long as the arc, with h = Δφ/2, and 1 − h²/6 ≤ sinc(h) ≤ 1.
        let chord = Interval::new(1.0 - half * half / 6.0 * (1.0 + 1e-9), 1.0);
        let (cos, sin) = (middle.cos() * chord, middle.sin() * chord);
        for (wheel, ticks) in delta.into_iter().enumerate() {
            self.cos_ticks[wheel] += cos * ticks;
            self.sin_ticks[wheel] += sin * ticks;
        }
        self.remainder_m += midpoint_remainder(delta, counts, step_turn_rad.magnitude(), step_s, wheels, reach);
    }

    /// Motion from the start of the integral to the latest sample.
    pub fn motion(&self, wheels: &WheelModel) -> Motion {
        let middle =
            |ticks: &[Interval; 2]| (wheels.metres_per_tick(0) * ticks[0] + wheels.metres_per_tick(1) * ticks[1]) * 0.5;
        let error_m = 0.5 * (self.travel_error(0, wheels) + self.travel_error(1, wheels));
        let side_m = self.side_slip(wheels);
        // The summation by parts leaves a remainder of the errors of travel and side slip, which may act in any direction as the robot turns, so
        // that both axes share one bound.
        let parts_m = (error_m + side_m) * self.turning_rad + self.remainder_m;
        let (cos, sin) = (self.turn_rad.cos(), self.turn_rad.sin());
        let (error, side) = (Interval::centred(0.0, error_m), Interval::centred(0.0, side_m));
        IntervalBox::from([
            (middle(&self.cos_ticks) + error * cos - side * sin).inflate(parts_m),
            (middle(&self.sin_ticks) + error * sin + side * cos).inflate(parts_m),
            self.turn_rad,
        ])
    }

    /// Enclosure of the true travel of one wheel's contact point since the start.
    fn travel(&self, wheel: usize, wheels: &WheelModel) -> Interval {
        let ticks = self.latest.ticks[wheel] - self.start.ticks[wheel];
        (wheels.metres_per_tick(wheel) * ticks).inflate(self.travel_error(wheel, wheels))
    }

    /// Bound on the error of a wheel's travel since the start: the quantisation once, slip in proportion to the rolled distance, and the constant
    /// part (floor) of the declared slip bound once for each time window of the length for which that bound is declared.
    pub(super) fn travel_error(&self, wheel: usize, wheels: &WheelModel) -> f64 {
        let per_tick_m = wheels.metres_per_tick(wheel).hi();
        let counts = 1.0 + self.start.ticks_error + self.latest.ticks_error;
        let rolled_m = (self.path_ticks[wheel] + counts) * per_tick_m;
        (counts * per_tick_m + wheels.slip_ratio * rolled_m + wheels.windows(self.lasts_s()) * wheels.slip_floor_m)
            * ABOVE
    }

    /// The part of the bound on the error of a wheel's travel since the start that slip makes.
    pub(super) fn slip_error(&self, wheel: usize, wheels: &WheelModel) -> f64 {
        let counts = 1.0 + self.start.ticks_error + self.latest.ticks_error;
        self.travel_error(wheel, wheels) - counts * wheels.metres_per_tick(wheel).hi()
    }

    /// Bound on the lateral travel of the axle middle since the start.
    fn side_slip(&self, wheels: &WheelModel) -> f64 {
        let rolled_m = self.greatest_rolled(wheels);
        (wheels.side_slip_ratio * rolled_m + wheels.windows(self.lasts_s()) * wheels.side_slip_floor_m) * ABOVE
    }

    /// Greatest distance that the middle of the axle has rolled since the start, forth and back.
    fn greatest_rolled(&self, wheels: &WheelModel) -> f64 {
        let counts = 2.0 + self.start.ticks_error + self.latest.ticks_error;
        0.5 * (0..2).map(|wheel| (self.path_ticks[wheel] + counts) * wheels.metres_per_tick(wheel).hi()).sum::<f64>()
    }

    /// Turn since the start by a car's steering; `None` where that was not known all the time.
    fn steered_turn(&self, steered: &Steered, wheels: &WheelModel) -> Option<Interval> {
        let slip_m = 0.5 * (self.slip_error(0, wheels) + self.slip_error(1, wheels));
        let (rolled_m, windows) = (self.greatest_rolled(wheels), wheels.windows(self.lasts_s()));
        self.steering.turn(&steered.model, wheels, slip_m, rolled_m, windows)
    }

    /// Enclosure of the true travel of the axle's middle since the start.
    pub(super) fn travel_of_middle(&self, wheels: &WheelModel) -> Interval {
        (self.travel(0, wheels) + self.travel(1, wheels)) * 0.5
    }

    /// Bounds that hold at every instant since the start: on how far the travel of the axle's middle departs from that by the ticks and the wheels'
    /// nominal radii, and on its side slip.
    pub(super) fn errors_of_middle(&self, wheels: &WheelModel) -> (f64, f64) {
        let by_radius_m = |wheel: usize| 0.5 * wheels.metres_per_tick(wheel).width() * self.path_ticks[wheel];
        let travel_m = (0..2).map(|wheel| 0.5 * (by_radius_m(wheel) + self.travel_error(wheel, wheels))).sum::<f64>();
        (travel_m * ABOVE, self.side_slip(wheels))
    }

    /// Greatest error of the turn by the ticks and the wheels' nominal dimensions, over any part of the time since the start.
    pub(super) fn greatest_turn_error(&self, wheels: &WheelModel) -> f64 {
        let track_m = wheels.track_m;
        let by_travel = 2.0 * self.errors_of_middle(wheels).0 / track_m.lo();
        let path_m: f64 = (0..2).map(|wheel| self.path_ticks[wheel] * wheels.metres_per_tick(wheel).hi()).sum();
        (by_travel + path_m * (1.0 / track_m.lo() - 1.0 / track_m.hi())) * ABOVE
    }

    /// Turn in one step alone, with the slip of that step and with counts that are off by up to `counts`.
    pub(super) fn step_turn(&self, delta: [f64; 2], counts: f64, step_s: f64, wheels: &WheelModel) -> Interval {
        let floor_m = wheels.windows(step_s) * wheels.slip_floor_m;
        let travel = [0, 1].map(|wheel| {
            let per_tick = wheels.metres_per_tick(wheel);
            let rolled_m = (delta[wheel].abs() + counts) * per_tick.hi();
            (per_tick * delta[wheel]).inflate((counts * per_tick.hi() + wheels.slip_ratio * rolled_m + floor_m) * ABOVE)
        });
        (travel[1] - travel[0]) / wheels.track_m
    }
}

impl WheelModel {
    /// Number of time windows, of the length for which the slip bounds are declared, that a span of time begins.
    pub(super) fn windows(&self, span_s: f64) -> f64 {
        // The quotient of time and window length is lowered by 10⁻⁶, so that a time of 0.2 s, which is inexact in binary, is one window of 0.2 s,
        // not two.
        (span_s / self.slip_window_s - 1e-6).ceil().max(1.0)
    }
}

/// Factor by which a sum of positive error bounds is increased, to make up for the few roundings of the sum.
const ABOVE: f64 = 1.0 + 1e-12;

/// Greatest distance along which the middle of the axle can have travelled between the ends of a step, with the slip of that step and with counts
/// that are off by up to `counts`.
fn greatest_travel(delta: [f64; 2], counts: f64, step_s: f64, wheels: &WheelModel) -> f64 {
    let rolled_m =
        0.5 * (0..2).map(|wheel| (delta[wheel].abs() + counts) * wheels.metres_per_tick(wheel).hi()).sum::<f64>();
    (rolled_m + wheels.slip_ratio * rolled_m + wheels.windows(step_s) * wheels.slip_floor_m) * ABOVE
}

/// Bound on |∫ (cos φ, sin φ) dS − chord| over one step, when speeds and turn rates change by at most their acceleration limits a and α:
/// P·α·T²/8 + a·|ω|·T³/8, with the length P of the path, the turn rate ω and the duration T, for counts that are off by up to `counts`.
///
/// The wheels' distance D is not the path: a robot that turns round within the step goes back and forth by at most a·T²/4, and it slips, which bends
/// with the heading as what it rolls does: P ≤ |D| + a·T²/4 and the step's slip ahead and aside.
pub(super) fn midpoint_remainder(
    delta: [f64; 2],
    counts: f64,
    turn_rad: f64,
    step_s: f64,
    wheels: &WheelModel,
    reach: &Reach,
) -> f64 {
    let acceleration = reach.acceleration_m_per_s2;
    let turn_acceleration = 2.0 * acceleration / wheels.track_m.lo();
    let rolled_m =
        0.5 * (0..2).map(|wheel| (delta[wheel].abs() + counts) * wheels.metres_per_tick(wheel).hi()).sum::<f64>();
    let slip_m = (wheels.slip_ratio + wheels.side_slip_ratio) * rolled_m
        + wheels.windows(step_s) * (wheels.slip_floor_m + wheels.side_slip_floor_m);
    let path_m = rolled_m + slip_m + 0.25 * acceleration * step_s * step_s;
    (path_m * turn_acceleration * step_s * step_s + acceleration * turn_rad * step_s * step_s) / 8.0
}

#[cfg(test)]
mod remainders;
