//! The robot's motion from one reading of the wheels to the next, as wheels, gyroscope and flow sensor measure it.

use std::collections::VecDeque;

use localizer::{Reading, RobotModel, motion::Twist};

/// What the motion sensors measured between two readings of the wheels, by nominal calibration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Stamp of the later reading of the wheels.
    pub(crate) stamp_s: f64,
    /// Time since the earlier one.
    pub(crate) span_s: f64,
    /// Distance that the left and the right wheel rolled.
    pub(crate) rolled_m: [f64; 2],
    /// Turn and the number of its rates as the gyroscope measured them, neither bias nor scale taken out; `None` without a rate.
    pub(crate) turned: Option<(f64, f64)>,
    /// Travel over the floor along the flow sensor's own axes; `None` where it counted nothing or found nothing to follow.
    pub(crate) flowed_m: Option<[f64; 2]>,
}

/// Collects the readings of the motion sensors into steps.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    robot: RobotModel,
    ticks: Option<(f64, [i64; 2])>,
    /// Turn by the gyroscope since the latest reading of the wheels, and the number of its rates.
    turned: (f64, f64),
    /// Totals of the flow sensor at its latest reading: counts along both axes, periods without any, and its stamp.
    counts: Option<([i64; 2], u64, f64)>,
    /// Counts since the latest reading of the wheels; `None` where the sensor found nothing to follow or was not read.
    counted: Option<[i64; 2]>,
    latest: VecDeque<Step>,
    /// Way and turn so far by the wheels, without signs.
    gone: [f64; 2],
}

/// Number of steps over which the speed is averaged that predicts motion blur and the present pose: within one step of 10 ms the ticks of an encoder
/// say little.
const AVERAGED_STEPS: usize = 5;

impl Steps {
    pub(crate) fn new(robot: &RobotModel) -> Steps {
        Steps {
            robot: robot.clone(),
            ticks: None,
            turned: (0.0, 0.0),
            counts: None,
            counted: None,
            latest: VecDeque::new(),
            gone: [0.0; 2],
        }
    }

    /// Takes in a reading; a reading of the wheels that is later than the one before ends a step.
    pub(crate) fn take(&mut self, reading: &Reading) -> Option<Step> {
        match reading {
            Reading::Gyro { rate_rad_per_s, .. } => {
                let period_s = self.robot.gyro.as_ref()?.period_s;
                self.turned = (self.turned.0 + rate_rad_per_s * period_s, self.turned.1 + 1.0);
                None
            }
            Reading::Flow { counts, blind_periods, measured_s, .. } => {
                if let Some((before, blind_before, _)) = self.counts.filter(|(_, _, at_s)| *at_s < *measured_s) {
                    let since = [0, 1].map(|axis| counts[axis] - before[axis]);
                    let sum = self.counted.map_or(since, |sum| [sum[0] + since[0], sum[1] + since[1]]);
                    self.counted = (*blind_periods == blind_before).then_some(sum);
                }
                if self.counts.is_none_or(|(_, _, at_s)| at_s < *measured_s) {
                    self.counts = Some((*counts, *blind_periods, *measured_s));
                }
                None
            }
            Reading::Wheels { measured_s, ticks, .. } => self.end_step(*measured_s, *ticks),
            _ => None,
        }
    }

    /// Way in metres and turn in radians that the wheels have gone so far, forth and back both counted.
    pub(crate) fn gone(&self) -> [f64; 2] {
        self.gone
    }

    /// Mean velocity over the latest steps, by the wheels.
    pub(crate) fn twist(&self) -> Twist {
        let span_s: f64 = self.latest.iter().map(|step| step.span_s).sum();
        let rolled = |wheel: usize| self.latest.iter().map(|step| step.rolled_m[wheel]).sum::<f64>();
        let (left_m, right_m) = (rolled(0), rolled(1));
        let per_s = if span_s > 0.0 { 1.0 / span_s } else { 0.0 };
        Twist {
            forward_m_per_s: 0.5 * (left_m + right_m) * per_s,
            turn_rad_per_s: (right_m - left_m) / self.robot.wheels.track_m.mid() * per_s,
        }
    }

    fn end_step(&mut self, stamp_s: f64, ticks: [i64; 2]) -> Option<Step> {
        let Some((before_s, before)) = self.ticks else {
            (self.ticks, self.turned, self.counted) = (Some((stamp_s, ticks)), (0.0, 0.0), None);
            return None;
        };
        if stamp_s <= before_s {
            // A reading that was overtaken or doubled on its way: the counters of the later one hold its ticks, too.
            return None;
        }
        self.ticks = Some((stamp_s, ticks));
        let wheels = &self.robot.wheels;
        let rolled_m = [0, 1].map(|wheel| (ticks[wheel] - before[wheel]) as f64 * wheels.metres_per_tick(wheel).mid());
        let turned = Some(std::mem::take(&mut self.turned)).filter(|(_, n_rates)| *n_rates > 0.0);
        let per_count_m = self.robot.flow.map(|flow| flow.metres_per_count.mid());
        let flowed_m = self.counted.take().zip(per_count_m).map(|(counted, per)| counted.map(|one| one as f64 * per));
        let step = Step { stamp_s, span_s: stamp_s - before_s, rolled_m, turned, flowed_m };
        let turn_rad = (rolled_m[1] - rolled_m[0]) / wheels.track_m.mid();
        self.gone[0] += 0.5 * (rolled_m[0] + rolled_m[1]).abs();
        self.gone[1] += turn_rad.abs();
        self.latest.push_back(step);
        if self.latest.len() > AVERAGED_STEPS {
            self.latest.pop_front();
        }
        Some(step)
    }
}

impl Step {
    /// The parts of the step before and after a share of its time, for a measurement within it.
    pub(crate) fn split(&self, share: f64) -> [Step; 2] {
        let part = |share: f64, stamp_s: f64| Step {
            stamp_s,
            span_s: self.span_s * share,
            rolled_m: self.rolled_m.map(|rolled_m| rolled_m * share),
            turned: self.turned.map(|(turn_rad, n_rates)| (turn_rad * share, n_rates * share)),
            flowed_m: self.flowed_m.map(|flowed_m| flowed_m.map(|part_m| part_m * share)),
        };
        [part(share, self.stamp_s - (1.0 - share) * self.span_s), part(1.0 - share, self.stamp_s)]
    }
}
