//! Summary of a search for failing scenes: how much ran, which failures it found, and what follows for the rate at which runs fail.

use std::{collections::BTreeMap, fmt};

use serde::Serialize;

use super::{
    journal::Done,
    probe::Witnesses,
    wish::{Hit, Wish},
};

/// Summary of all cases of a search.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Seed of the search.
    pub seed: u64,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs with cameras.
    pub with_cameras: usize,
    /// Number of runs with a witness at some instant; 0 where the search does not seek any.
    pub with_witnesses: usize,
    /// Number of runs in which no declared bound was exceeded.
    pub bounds_held: usize,
    /// Number of steps of all runs whose estimates were checked against the truth.
    pub steps: usize,
    /// Simulated time of all runs in seconds.
    pub simulated_s: f64,
    /// Number of scenes that were drawn and refused as invalid.
    pub refused: usize,
    /// For each scene key, the number of scenes that were refused because this key was invalid.
    pub refusals: BTreeMap<String, usize>,
    /// For each declared bound, the number of runs in which it was exceeded.
    pub broken: BTreeMap<String, usize>,
    /// For each kind of failure, the runs that showed it.
    pub hits: BTreeMap<&'static str, Hits>,
    /// Number of runs that showed a failure of a kind that the user asks for.
    pub failed: usize,
    /// Number of failed runs in which no declared bound was exceeded.
    pub failed_where_bounds_held: usize,
    /// Upper 95 % confidence bound on the share of runs that fail.
    pub failure_rate_upper_95: f64,
    /// Upper 95 % confidence bound on the share of failures among runs in which no declared bound was exceeded.
    pub failure_rate_upper_95_where_bounds_held: f64,
}

/// The runs of a search that showed one kind of failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Hits {
    /// Number of runs that showed the failure.
    pub runs: usize,
    /// Numbers of the cases that showed the failure, grouped by the failure's signature, a text that distinguishes failures of different causes.
    pub cases: BTreeMap<String, Vec<u64>>,
}

impl Summary {
    /// Sums up the cases of a search that are done. A run counts as failed if it shows a failure of a kind that the search looks for, as `wishes`
    /// lists.
    pub fn of(seed: u64, done: &[Done], wishes: &[Wish]) -> Summary {
        let mut summary = Summary { seed, runs: done.len(), ..Summary::default() };
        for case in done {
            summary.with_cameras += usize::from(case.has_cameras);
            summary.with_witnesses += usize::from(case.witnesses == Some(Witnesses::Found));
            summary.bounds_held += usize::from(case.broken.is_empty());
            summary.steps += case.steps;
            summary.simulated_s += case.simulated_s;
            summary.refused += case.refused.len();
            case.refused.iter().for_each(|key| *summary.refusals.entry(key.clone()).or_default() += 1);
            case.broken.iter().for_each(|bound| *summary.broken.entry(bound.clone()).or_default() += 1);
            for Hit { wish, signature, .. } in &case.hits {
                let hits = summary.hits.entry(wish.name()).or_default();
                hits.runs += 1;
                hits.cases.entry(signature.clone()).or_default().push(case.case);
            }
            let is_failure = case.hits.iter().any(|hit| wishes.contains(&hit.wish));
            summary.failed += usize::from(is_failure);
            summary.failed_where_bounds_held += usize::from(is_failure && case.broken.is_empty());
        }
        summary.failure_rate_upper_95 = upper_bound(summary.failed, summary.runs);
        summary.failure_rate_upper_95_where_bounds_held =
            upper_bound(summary.failed_where_bounds_held, summary.bounds_held);
        summary
    }
}

/// Upper end of the one-sided 95 % interval by Clopper and Pearson (1934) for the probability of an event seen `k` times in `n` trials:
/// the p at which `k` or fewer events have a probability of 5 %, Σᵢ₌₀ᵏ C(n, i) pⁱ (1 − p)ⁿ⁻ⁱ = 0.05. For k = 0 it is 1 − 0.05^(1/n).
pub fn upper_bound(k: usize, n: usize) -> f64 {
    const MISSED: f64 = 0.05;
    if k >= n {
        return 1.0;
    }
    let at_most_k = |p: f64| {
        let mut log_choose = 0.0_f64;
        let mut sum = 0.0;
        for i in 0..=k {
            if i > 0 {
                log_choose += ((n - i + 1) as f64).ln() - (i as f64).ln();
            }
            sum += (log_choose + i as f64 * p.ln() + (n - i) as f64 * (-p).ln_1p()).exp();
        }
        sum
    };
    let (mut least, mut most) = (k as f64 / n as f64, 1.0);
    // Bisection: each halving of the interval that holds p adds one bit of precision; doubles have 53 bits.
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        if at_most_k(middle) > MISSED { least = middle } else { most = middle }
    }
    most
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drawn = self.runs + self.refused;
        writeln!(
            f,
            "{} runs of {:.0} s in all, {} steps, {} with cameras; no bound was exceeded in {}; {} of {drawn} scenes drawn were refused",
            self.runs, self.simulated_s, self.steps, self.with_cameras, self.bounds_held, self.refused
        )?;
        if self.with_witnesses > 0 {
            writeln!(
                f,
                "{} runs had a witness: another history than the true one that keeps every bound",
                self.with_witnesses
            )?;
        }
        for wish in Wish::ALL {
            let Some(hits) = self.hits.get(wish.name()) else { continue };
            writeln!(f, "{}: {} runs", wish.name().replace('_', " "), hits.runs)?;
            for (signature, cases) in &hits.cases {
                let shown: Vec<String> = cases.iter().take(8).map(u64::to_string).collect();
                let more = if cases.len() > 8 { ", …" } else { "" };
                writeln!(f, "  {signature}: {} ({}{more})", cases.len(), shown.join(", "))?;
            }
        }
        writeln!(
            f,
            "{} runs failed; with 95 % confidence a run fails in at most {:.3} % of such scenes, and of those in which no bound was exceeded in at most {:.3} %",
            self.failed,
            100.0 * self.failure_rate_upper_95,
            100.0 * self.failure_rate_upper_95_where_bounds_held
        )
    }
}

#[cfg(test)]
mod tests {
    use super::upper_bound;

    #[test]
    fn the_bound_on_a_rate_is_that_of_the_tables() {
        // For 0 of n the bound is 1 − 0.05^(1/n), which is close to 3/n, the rule of three.
        assert!((upper_bound(0, 300) - (1.0 - 0.05_f64.powf(1.0 / 300.0))).abs() < 1e-12);
        // The expected values are of the two-sided 90 % tables of Clopper and Pearson: 1 of 10 gives 0.3942, 5 of 20 gives 0.4556.
        assert!((upper_bound(1, 10) - 0.3942).abs() < 5e-5, "{}", upper_bound(1, 10));
        assert!((upper_bound(5, 20) - 0.4556).abs() < 5e-5, "{}", upper_bound(5, 20));
        assert_eq!(upper_bound(4, 4), 1.0);
        assert_eq!(upper_bound(0, 0), 1.0);
    }
}
