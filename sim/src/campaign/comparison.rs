//! Two sets of results against each other, paired case by case.
//!
//! Both ran the same scenes with the same seeds, so that each case has a difference of its own. Cases of one seed share
//! everything drawn with it, however many values of a key they run over; they are no independent witnesses. The unit is
//! therefore the seed: the mean difference over its cases. On those a paired t interval: if the two do not differ, exchanging
//! them changes nothing, hence a difference is symmetric about 0, and for symmetric differences the tails of t are no
//! heavier than Student's (Efron, J. Am. Stat. Assoc. 64, 1969). All intervals hold together with the stated confidence,
//! by Bonferroni's division, so that a long list of figures does not make chance look like a finding.
//!
//! What is promised is refuted by one case, and no statistics are asked: a case that loses the truth where the first side kept it, that is
//! unsound or misperceives more often, that misses an expectation which was met, or that is not there any more.

mod load;
mod student;
mod text;

use std::collections::BTreeMap;

pub use load::{Side, SideError};
pub use student::quantile;
pub use text::as_text;

/// How sure all intervals together are unless stated otherwise.
pub const CONFIDENCE: f64 = 0.99;

/// Differences relative to the values below this are rounding.
const ROUNDING: f64 = 1e-9;

/// A figure that is compared.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// Its name in `results.csv`.
    pub figure: &'static str,
    /// What people call it.
    pub name: &'static str,
    /// The unit shown.
    pub unit: &'static str,
    /// From the file's unit to that one.
    pub scale: f64,
    /// Whether less is better.
    pub less_is_better: bool,
}

/// What is compared: few figures that do not repeat each other, as each one more widens the intervals of all.
pub const COMPARED: [Compared; 7] = [
    figure("containment.contained_share", "contained", "%", 1e2, false),
    figure("error.position_m.mean", "position error", "mm", 1e3, true),
    figure("error.heading_rad.rmse", "heading error", "°", DEGREES, true),
    figure("width.x_m.mean", "width in x", "mm", 1e3, true),
    figure("width.y_m.mean", "width in y", "mm", 1e3, true),
    figure("width.heading_rad.mean", "width in heading", "°", DEGREES, true),
    figure("availability", "available", "%", 1e2, false),
];

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const fn figure(
    figure: &'static str,
    name: &'static str,
    unit: &'static str,
    scale: f64,
    less_is_better: bool,
) -> Compared {
    Compared { figure, name, unit, scale, less_is_better }
}

/// What a comparison says of the second side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Better than the first.
    Better,
    /// Worse than the first.
    Worse,
    /// The difference may be chance, or there is none.
    NotDistinguishable,
}

/// One figure of both sides.
#[derive(Clone, Debug)]
pub struct Line {
    /// What is compared.
    pub compared: Compared,
    /// Means of both sides over the seeds, in the figure's own unit.
    pub means: [f64; 2],
    /// Interval of the mean difference, second less first; unbounded when there are too few seeds.
    pub difference: [f64; 2],
    /// What follows.
    pub finding: Finding,
}

/// Everything that two sides say about each other.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Pairs of cases that both sides ran.
    pub n_pairs: usize,
    /// Seeds among them.
    pub n_seeds: usize,
    /// Cases that only one side ran, first and second.
    pub unpaired: [Vec<String>; 2],
    /// Cases contained at every step by the first side and not by the second, and the other way round.
    pub lost: Vec<String>,
    /// See `lost`.
    pub won: Vec<String>,
    /// Cases with more unsound steps, or more that perception is to blame for, than the first side had.
    pub graver: Vec<String>,
    /// Cases that met the scene's expectations in the first side and do not in the second.
    pub missed: Vec<String>,
    /// Cases that the first side ran and the second was to run and could not.
    pub failed: Vec<String>,
    /// Figures that one side has of a pair and the other has not.
    pub half_known: Vec<&'static str>,
    /// One line for each figure.
    pub lines: Vec<Line>,
    /// How sure all intervals together are.
    pub confidence: f64,
}

/// Compares two sides; `confidence` between 0 and 1 is that of all intervals together.
pub fn compare(first: &Side, second: &Side, confidence: f64) -> Comparison {
    let pairs: Vec<(&String, &load::Case, &load::Case)> =
        first.cases.iter().filter_map(|(name, case)| Some((name, case, second.cases.get(name)?))).collect();
    let knows = |side: &Side, name: &str| side.cases.contains_key(name) || side.not_run.contains(name);
    let only = |one: &Side, other: &Side| one.cases.keys().filter(|name| !knows(other, name)).cloned().collect();
    let keeps = |case: &load::Case| case.figures.get("containment.contained_share").is_some_and(|share| *share >= 1.0);
    let named = |wanted: &dyn Fn(&load::Case, &load::Case) -> bool| -> Vec<String> {
        pairs.iter().filter(|(_, one, other)| wanted(one, other)).map(|(name, _, _)| (*name).clone()).collect()
    };
    let lost = named(&|one, other| keeps(one) && !keeps(other));
    let won = named(&|one, other| !keeps(one) && keeps(other));
    let count = |case: &load::Case, cause: &str| case.figures.get(cause).copied().unwrap_or(0.0);
    let grew = |one: &load::Case, other: &load::Case, cause: &str| count(other, cause) > count(one, cause);
    let graver = named(&|one, other| {
        ["containment.unsound", "containment.perception"].iter().any(|cause| grew(one, other, cause))
    });
    let missed = named(&|one, other| one.passed == Some(true) && other.passed == Some(false));
    let is_half_known = |figure: &str| {
        pairs.iter().any(|(_, one, other)| one.figures.contains_key(figure) != other.figures.contains_key(figure))
    };
    let half_known = COMPARED.iter().map(|compared| compared.figure).filter(|figure| is_half_known(figure)).collect();
    let lines = COMPARED.iter().filter_map(|compared| line(*compared, &pairs, confidence)).collect();
    let mut seeds: Vec<u64> = pairs.iter().map(|(_, case, _)| case.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let mut comparison = Comparison {
        n_pairs: pairs.len(),
        n_seeds: seeds.len(),
        unpaired: [only(first, second), only(second, first)],
        lost,
        won,
        graver,
        missed,
        failed: second.not_run.iter().filter(|name| first.cases.contains_key(*name)).cloned().collect(),
        half_known,
        lines,
        confidence,
    };
    comparison.hold_to_the_guarantee();
    comparison
}

impl Comparison {
    /// Whether anything is worse, or is not there any more.
    pub fn is_worse(&self) -> bool {
        let refuting = [&self.lost, &self.graver, &self.missed, &self.failed, &self.unpaired[0]];
        refuting.iter().any(|cases| !cases.is_empty())
            || !self.half_known.is_empty()
            || self.lines.iter().any(|line| line.finding == Finding::Worse)
    }

    /// One case that lost the truth is worse, whatever the mean; cases that keep it now are better if none is lost.
    fn hold_to_the_guarantee(&mut self) {
        let finding = match (self.lost.is_empty(), self.won.is_empty()) {
            (false, _) => Finding::Worse,
            (true, false) => Finding::Better,
            (true, true) => return,
        };
        let contained = self.lines.iter_mut().find(|line| line.compared.figure == "containment.contained_share");
        contained.into_iter().for_each(|line| line.finding = finding);
    }
}

/// One figure; none when no pair has it.
fn line(compared: Compared, pairs: &[(&String, &load::Case, &load::Case)], confidence: f64) -> Option<Line> {
    let mut by_seed: BTreeMap<u64, Vec<[f64; 2]>> = BTreeMap::new();
    for (_, one, other) in pairs {
        if let (Some(one_value), Some(other_value)) =
            (one.figures.get(compared.figure), other.figures.get(compared.figure))
        {
            by_seed.entry(one.seed).or_default().push([*one_value, *other_value]);
        }
    }
    if by_seed.is_empty() {
        return None;
    }
    let seeds: Vec<[f64; 2]> = by_seed
        .values()
        .map(|values| [0, 1].map(|side| values.iter().map(|value| value[side]).sum::<f64>() / values.len() as f64))
        .collect();
    let means = [0, 1].map(|side| seeds.iter().map(|seed| seed[side]).sum::<f64>() / seeds.len() as f64);
    let rounding = ROUNDING * means[0].abs().max(means[1].abs());
    let differences: Vec<f64> = seeds
        .iter()
        .map(|[one, other]| other - one)
        .map(|difference| if difference.abs() <= rounding { 0.0 } else { difference })
        .collect();
    let difference = interval(&differences, (1.0 - confidence) / COMPARED.len() as f64);
    let finding = match (difference, compared.less_is_better) {
        ([low, _], less_is_better) if low > 0.0 => {
            if less_is_better {
                Finding::Worse
            } else {
                Finding::Better
            }
        }
        ([_, high], less_is_better) if high < 0.0 => {
            if less_is_better {
                Finding::Better
            } else {
                Finding::Worse
            }
        }
        _ => Finding::NotDistinguishable,
    };
    Some(Line { compared, means, difference, finding })
}

/// Student's interval of the mean of `differences` that misses it with probability `miss`:  d̄ ± t(1 − miss/2, n − 1) s/√n.
fn interval(differences: &[f64], miss: f64) -> [f64; 2] {
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let squares: f64 = differences.iter().map(|difference| (difference - mean).powi(2)).sum();
    if differences.iter().all(|difference| *difference == 0.0) {
        return [0.0, 0.0];
    }
    if differences.len() < 2 {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    let half = quantile(1.0 - miss / 2.0, n - 1.0) * (squares / (n - 1.0) / n).sqrt();
    [mean - half, mean + half]
}
