//! What the tests of the graph share: draws at the corners of bounds, and a range camera, and drives whose every error is known.

use interval::Interval;

use crate::robot::{GyroModel, RangeCameraModel, Reach, WheelModel};

/// A generator of numbers that prefers the ends of intervals.
pub(super) struct Draw(u64);

impl Draw {
    pub(super) fn new(seed: u64) -> Draw {
        Draw(seed | 1)
    }

    /// A number from 0 to 1, by the generator xorshift64.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A size between two, evenly on a logarithmic scale.
    pub(super) fn size(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    /// The given number, or, one time in two, 0.
    pub(super) fn or_zero(&mut self, value: f64) -> f64 {
        if self.unit() < 0.5 { 0.0 } else { value }
    }

    /// A number in an interval, three times in four at one of its ends.
    pub(super) fn within(&mut self, values: Interval) -> f64 {
        match self.unit() {
            share if share < 0.375 => values.lo(),
            share if share < 0.75 => values.hi(),
            _ => self.between(values.lo(), values.hi()),
        }
    }
}

/// The range camera of the tests, whose bounds are those that each test puts into its domain.
pub(super) fn camera() -> RangeCameraModel {
    RangeCameraModel {
        focal_px: Interval::centred(400.0, 0.4),
        baseline_m: Interval::centred(0.12, 0.0003),
        centre_px: 319.5,
        step_px: [0.125; 2],
        position_m: [Interval::ZERO; 2],
        height_m: 0.3,
        yaw_rad: Interval::ZERO,
        tilt_rad: 0.0,
        height_span_m: 0.3,
        stamp_error_s: 0.0,
        latency_s: Interval::ZERO,
        period_s: 0.1,
        q_items: 0,
        wrong_spacing: 0,
    }
}

/// Slip ratio of the wheels and of the side slip in the tests.
pub(super) const SLIP: f64 = 0.02;
/// Greatest acceleration of a wheel in the tests.
const ACCELERATION_M_PER_S2: f64 = 1.5;
/// Greatest noise of one gyroscope reading in the tests.
const NOISE_RAD_PER_S: f64 = 0.004;
/// Bound `gyro.angle` in the tests: its constant part, and its part for each second.
const ANGLE_RAD: [f64; 2] = [0.0004, 0.0001];

pub(super) fn wheels() -> WheelModel {
    WheelModel {
        radius_m: [Interval::centred(0.05, 0.0001); 2],
        track_m: Interval::centred(0.33, 0.001),
        ticks_per_turn: 1024.0,
        slip_ratio: SLIP,
        slip_floor_m: 0.0002,
        side_slip_ratio: SLIP,
        side_slip_floor_m: 0.0002,
        slip_window_s: 0.2,
    }
}

pub(super) fn reach() -> Reach {
    Reach { speed_m_per_s: 2.0, turn_rate_rad_per_s: 4.0, acceleration_m_per_s2: ACCELERATION_M_PER_S2 * (1.0 + SLIP) }
}

pub(super) fn gyro(has_angle: bool) -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.001, 0.002),
        scale: Interval::centred(1.0, 0.003),
        noise_rad_per_s: NOISE_RAD_PER_S,
        angle_floor_rad: if has_angle { ANGLE_RAD[0] } else { f64::INFINITY },
        angle_rad_per_s: if has_angle { ANGLE_RAD[1] } else { f64::INFINITY },
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.01,
    }
}

/// A drive with all true values, at the corners of the bounds above.
pub(super) struct Drive {
    /// Stamp, ticks and turn rate as read, every 10 ms.
    pub(super) readings: Vec<(f64, [i64; 2], f64)>,
    /// The stamps of the two key frames, and the true poses there.
    pub(super) span_s: [f64; 2],
    pub(super) poses: [[f64; 3]; 2],
    pub(super) metres_per_tick: [f64; 2],
    pub(super) track_m: f64,
    pub(super) scale: f64,
    pub(super) bias: f64,
    /// Bounded part of the accumulated angle error at the two key frames, and the greatest size that it may have.
    pub(super) angle_rad: [f64; 2],
    pub(super) angle_half_rad: f64,
}

/// Draws a drive of 1 to 4 s, integrated in steps of 0.1 ms by the midpoint rule.
pub(super) fn drive(draw: &mut Draw, has_angle: bool) -> Drive {
    let metres_per_tick = [0, 1].map(|wheel| draw.within(wheels().metres_per_tick(wheel)));
    let track_m = draw.within(wheels().track_m);
    let (scale, bias) = (draw.within(gyro(has_angle).scale), draw.within(gyro(has_angle).bias_rad_per_s));
    let slip = [0, 1].map(|_| draw.within(Interval::centred(0.0, SLIP)));
    let side = draw.within(Interval::centred(0.0, SLIP));
    // Part of the accumulated angle error that grows with time.
    let drift_rad_per_s = draw.within(Interval::centred(0.0, ANGLE_RAD[1]));
    let n_steps = 100 + (draw.unit() * 300.0) as u32;
    // Key frames on a reading or between two.
    let between = |draw: &mut Draw| if draw.unit() < 0.5 { 0 } else { (draw.unit() * 100.0) as u32 };
    let ends = [between(draw), 100 * n_steps - between(draw)];
    let mut speed = [draw.between(-0.3, 0.5), draw.between(-0.3, 0.5)];
    let (mut pose, mut rolled_m) =
        ([draw.between(-3.0, 3.0), draw.between(-3.0, 3.0), draw.between(-4.0, 4.0)], [0.0; 2]);
    let (mut readings, mut poses, mut angle_rad) = (vec![(0.0, [0; 2], 0.0)], [pose; 2], [0.0; 2]);
    let (mut push, mut noise, mut summed_rad, mut turned_rad) = ([0.0; 2], 0.0, 0.0, 0.0);
    for fine in 0..100 * n_steps {
        if fine % 100 == 0 {
            // Another acceleration, and another noise, in every tenth reading; else the same, so that errors add up.
            if draw.unit() < 0.1 {
                push = [0, 1].map(|_| draw.within(Interval::centred(0.0, ACCELERATION_M_PER_S2)));
            }
            if draw.unit() < 0.1 || fine == 0 {
                noise = draw.within(Interval::centred(0.0, NOISE_RAD_PER_S));
            }
            for wheel in 0..2 {
                if (speed[wheel] + 0.01 * push[wheel]).abs() > 0.6 {
                    push[wheel] = 0.0;
                }
            }
        }
        if fine == ends[0] {
            poses[0] = pose;
            angle_rad[0] = summed_rad;
        }
        let middle = [0, 1].map(|wheel| speed[wheel] + 0.5e-4 * push[wheel]);
        let travel = [0, 1].map(|wheel| middle[wheel] * 1e-4 * (1.0 + slip[wheel]));
        let aside_m = side * 0.5e-4 * (middle[0] + middle[1]);
        let (ahead_m, turn) = (0.5 * (travel[0] + travel[1]), (travel[1] - travel[0]) / track_m);
        let heading = pose[2] + 0.5 * turn;
        pose[0] += ahead_m * heading.cos() - aside_m * heading.sin();
        pose[1] += ahead_m * heading.sin() + aside_m * heading.cos();
        pose[2] += turn;
        turned_rad += turn;
        for wheel in 0..2 {
            rolled_m[wheel] += middle[wheel] * 1e-4;
            speed[wheel] += 1e-4 * push[wheel];
        }
        if fine % 100 == 99 {
            // Where the accumulated angle is bounded, noise that would make it more is drawn back to the bound.
            let half = 0.5 * ANGLE_RAD[0];
            let rate = if has_angle {
                let next = (summed_rad + noise * 0.01).clamp(-half, half);
                let kept = (next - summed_rad) / 0.01;
                summed_rad = next;
                kept + drift_rad_per_s
            } else {
                noise
            };
            let ticks = [0, 1].map(|wheel| (rolled_m[wheel] / metres_per_tick[wheel]).floor() as i64);
            readings.push((f64::from(fine + 1) * 1e-4, ticks, scale * turned_rad / 0.01 + bias + rate));
            turned_rad = 0.0;
        }
        if fine + 1 == ends[1] {
            poses[1] = pose;
            angle_rad[1] = summed_rad;
        }
    }
    let span_s = ends.map(|fine| f64::from(fine) * 1e-4);
    Drive {
        readings,
        span_s,
        poses,
        metres_per_tick,
        track_m,
        scale,
        bias,
        angle_rad,
        angle_half_rad: 0.5 * ANGLE_RAD[0],
    }
}
