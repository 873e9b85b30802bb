//! Pools the figures of several runs into those of one.

use std::collections::BTreeMap;

use crate::judge::figures::Figures;

/// Names of the figures that count events on errands, such as collisions.
const ERRAND_COUNTS: [&str; 6] = ["errands", "goals_reached", "goals_missed", "arrivals_off", "replans", "collisions"];

/// Pools the figures of all `runs`: counts are added, root mean squares are pooled as squares, of greatest values the greatest is taken and of least
/// values the least, and everything else is averaged over the runs that measured it.
pub(crate) fn pool(runs: &[&Figures]) -> Figures {
    let mut by_name: BTreeMap<&str, Moments> = BTreeMap::new();
    for (name, value) in runs.iter().flat_map(|figures| figures.iter()) {
        by_name.entry(name).or_default().add(*value);
    }
    pooled(by_name.iter().map(|(name, moments)| (*name, moments)))
}

/// Pools a figure of each name from what was added up of it.
pub(crate) fn pooled<'a>(figures: impl Iterator<Item = (&'a str, &'a Moments)>) -> Figures {
    let mut pooled: Figures = figures.map(|(name, moments)| (name.to_owned(), moments.combine(name))).collect();
    derive(&mut pooled);
    pooled
}

/// What pooling needs of a figure of several runs, however many these are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    n: u64,
    sum: f64,
    sum_of_squares: f64,
    greatest: f64,
    least: f64,
}

impl Default for Moments {
    fn default() -> Moments {
        // The sum of no numbers is −0, as for the iterators of the standard library.
        Moments { n: 0, sum: -0.0, sum_of_squares: -0.0, greatest: f64::NEG_INFINITY, least: f64::INFINITY }
    }
}

impl Moments {
    /// Adds the figure of one more run.
    pub(crate) fn add(&mut self, value: f64) {
        self.n += 1;
        self.sum += value;
        self.sum_of_squares += value * value;
        self.greatest = self.greatest.max(value);
        self.least = self.least.min(value);
    }

    /// Whether no run has this figure.
    pub(crate) fn is_empty(&self) -> bool {
        self.n == 0
    }

    fn combine(&self, name: &str) -> f64 {
        let n = self.n as f64;
        // A baseline's figures are pooled like the localizer's own.
        let name =
            name.strip_prefix("baselines.").and_then(|name| name.split_once('.')).map_or(name, |(_, figure)| figure);
        let last = name.rsplit('.').next().unwrap_or(name);
        let is_count = name.starts_with("containment.")
            || name.starts_with("methods.")
            || ["violations", "distribution.checks", "distribution.unusable"].contains(&name)
            || name.strip_prefix("metrics.").is_some_and(|metric| ERRAND_COUNTS.contains(&metric));
        if is_count || name == "duration_s" || last == "wall_s" {
            self.sum
        } else if name.contains(".rmse") {
            (self.sum_of_squares / n).sqrt()
        } else if ["max", "p999"].contains(&last) || last.ends_with("_greatest_m") {
            self.greatest
        } else if last.ends_with("_least_m") {
            self.least
        } else {
            self.sum / n
        }
    }
}

/// For each baseline named in `figures`, its figures under the names that the localizer's own figures have.
pub(super) fn baselines(figures: &Figures) -> BTreeMap<String, Figures> {
    let mut baselines: BTreeMap<String, Figures> = BTreeMap::new();
    for (name, value) in figures {
        if let Some((baseline, figure)) = name.strip_prefix("baselines.").and_then(|name| name.split_once('.')) {
            baselines.entry(baseline.to_owned()).or_default().insert(figure.to_owned(), *value);
        }
    }
    baselines.values_mut().for_each(derive);
    baselines
}

/// For each of the localizer's methods in `figures`, its numbers of readings and of fixes, and its shares of all the times that methods halved the
/// widths of the estimate's box, in position and in heading; empty unless several methods contribute.
pub(crate) fn methods(figures: &Figures) -> BTreeMap<String, Figures> {
    let names = figures.keys().filter_map(|name| name.strip_prefix("methods.")?.strip_suffix(".constraints"));
    let names: Vec<&str> = names.collect();
    if names.len() < 2 {
        return BTreeMap::new();
    }
    let halved = |method: &str, axes: &[&str]| -> f64 {
        axes.iter().filter_map(|axis| figures.get(&format!("methods.{method}.halved.{axis}"))).sum()
    };
    let share = |method: &str, axes: &[&str]| {
        let all: f64 = names.iter().map(|name| halved(name, axes)).sum();
        if all > 0.0 { halved(method, axes) / all } else { 0.0 }
    };
    let part = |method: &&str| {
        let count = |what: &str| figures.get(&format!("methods.{method}.{what}")).copied().unwrap_or(0.0);
        let shares = [
            ("method.readings", count("readings")),
            ("method.constraints", count("constraints")),
            ("method.position_share", share(method, &["x_m", "y_m"])),
            ("method.heading_share", share(method, &["heading_rad"])),
        ];
        ((*method).to_owned(), shares.map(|(name, value)| (name.to_owned(), value)).into())
    };
    names.iter().map(part).collect()
}

/// Adds the figures that follow from the pooled figures rather than from those of each run, such as shares of pooled counts.
fn derive(pooled: &mut Figures) {
    let quotient = |figures: &Figures, part: &str, whole: &str| Some(figures.get(part)? / figures.get(whole)?);
    if let Some(share) = quotient(pooled, "containment.contained", "containment.checks") {
        pooled.insert("containment.contained_share".to_owned(), share);
    }
    if let Some(factor) = quotient(pooled, "duration_s", "timing.wall_s") {
        pooled.insert("timing.real_time_factor".to_owned(), factor);
    }
    let worst: Vec<(String, f64)> = pooled
        .keys()
        .filter_map(|name| name.strip_suffix("_worst_third"))
        .map(|stem| {
            let thirds = (1..=3).filter_map(|third| pooled.get(&format!("{stem}_by_third.{third}")));
            (format!("{stem}_worst_third"), thirds.fold(f64::NEG_INFINITY, |worst, third| worst.max(*third)))
        })
        .collect();
    pooled.extend(worst);
}
