//! A command that follows its target with limited rate and limited jerk, so that tyres are loaded gently.

/// A command smoothed by limits on its rate and jerk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    value: f64,
    rate: f64,
    max_rate: f64,
    max_jerk: f64,
}

impl Ramp {
    /// A smoothed command that starts at 0 and at rest. Its rate takes `rise_s` to reach `max_rate`.
    pub(super) fn new(max_rate: f64, rise_s: f64) -> Self {
        Ramp { value: 0.0, rate: 0.0, max_rate, max_jerk: max_rate / rise_s }
    }

    /// Present value of the smoothed command.
    pub(super) fn value(&self) -> f64 {
        self.value
    }

    /// Moves the command towards a target for one time step.
    pub(super) fn follow(&mut self, target: f64, step_s: f64) -> f64 {
        let gap = target - self.value;
        let jerk_step = self.max_jerk * step_s;
        if gap.abs() <= jerk_step * step_s && self.rate.abs() <= jerk_step {
            (self.value, self.rate) = (target, 0.0);
            return target;
        }
        // The greatest rate from which the limited jerk can still bring the command to rest exactly on the target follows from rate² =
        // 2·jerk·gap, with the gap that remains to the target. The factor 2 is reduced by a fifth, because the steps are coarse.
        let wanted = gap.signum() * self.max_rate.min((1.6 * self.max_jerk * gap.abs()).sqrt());
        self.rate += (wanted - self.rate).clamp(-jerk_step, jerk_step);
        self.value += self.rate * step_s;
        self.value
    }
}
