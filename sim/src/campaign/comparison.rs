//! Comparison of two sets of results, paired case by case.
//!
//! Both sets of results, here called sides, are of the same scenes and seeds, so that each case has a difference of its own. Cases of one seed share
//! everything drawn with that seed, however many values of a key they run over; they are not independent samples. The unit of the statistics is
//! therefore the seed, with the mean difference over its cases, and the interval is a paired t interval over the seeds. If the two sides do not
//! differ, exchanging them changes nothing; hence a difference is symmetric about 0, and for symmetric differences the tails of t are no heavier than
//! Student's (Efron, J. Am. Stat. Assoc. 64, 1969). All intervals hold together with the stated confidence, by Bonferroni's division, so that chance
//! does not look like a finding in a long list of compared quantities.
//!
//! A single case refutes the guarantee, without any statistics: a case that loses the truth where the first side kept it, that has more steps at
//! which the localizer or its vision is to blame for the loss, that misses an expectation which the first side met, or that is missing in the second
//! side.

mod load;
mod student;
mod text;

use std::collections::BTreeMap;

pub use load::{Side, SideError};
pub use student::quantile;
pub use text::as_text;

/// Default confidence with which all intervals of a comparison hold together.
pub const CONFIDENCE: f64 = 0.99;

/// Default share of the first set's mean by which a quantity may worsen unseen: what a reviewer of a change would hardly object to.
pub const TOLERANCE: f64 = 0.1;

/// Greatest relative difference of two results that counts as an error of rounding and is set to 0.
const ROUNDING: f64 = 1e-9;

/// A numerical result, such as the mean width of the box, in which two sets of results are compared.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// Name of the compared quantity in `results.csv`.
    pub figure: &'static str,
    /// Name of the compared quantity for people.
    pub name: &'static str,
    /// Unit in which the compared quantity is shown.
    pub unit: &'static str,
    /// Factor that converts the compared quantity from its unit in `results.csv` to the shown unit.
    pub scale: f64,
    /// Whether a lower value of the compared quantity is better.
    pub less_is_better: bool,
}

/// The quantities in which results are compared. They are few and do not repeat each other, as each further one widens the confidence intervals of
/// all. Those of distributions are there for localizers that state some.
pub const COMPARED: [Compared; 11] = [
    figure("containment.contained_share", "contained", "%", 1e2, false),
    figure("error.position_m.mean", "position error", "mm", 1e3, true),
    figure("error.heading_rad.rmse", "heading error", "°", DEGREES, true),
    figure("width.x_m.mean", "width in x", "mm", 1e3, true),
    figure("width.y_m.mean", "width in y", "mm", 1e3, true),
    figure("width.heading_rad.mean", "width in heading", "°", DEGREES, true),
    figure("availability", "available", "%", 1e2, false),
    figure(load::NEES_OFF, "|ln(NEES / 3)|", "1", 1.0, true),
    figure("distribution.within_3_sigma_share", "in 3σ", "%", 1e2, false),
    figure("distribution.region_3_sigma.x_m.mean", "3σ width in x", "mm", 1e3, true),
    figure("distribution.region_3_sigma.y_m.mean", "3σ width in y", "mm", 1e3, true),
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

/// Whether the second of two sets of results is better or worse than the first in one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// In this quantity the second set of results is better than the first.
    Better,
    /// In this quantity the second set of results is worse than the first.
    Worse,
    /// The difference between the two sets of results may be chance, or there is none; a worsening by more than is tolerated would have been seen.
    NotDistinguishable,
    /// The difference between the two sets of results may be chance, and so may a worsening by more than is tolerated: there are too few seeds.
    Inconclusive,
}

/// Comparison of two sets of results in one quantity.
#[derive(Clone, Debug)]
pub struct Line {
    /// Figure that is compared.
    pub compared: Compared,
    /// Mean over the seeds in either set of results, in the unit of `results.csv`.
    pub means: [f64; 2],
    /// Confidence interval of the mean difference, second set of results minus first; unbounded when there are too few seeds.
    pub difference: [f64; 2],
    /// Least difference of the means that would be told from chance with the scatter and the number of seeds of these results, in the unit of
    /// `results.csv`; infinite when there are too few seeds.
    pub least_seen: f64,
    /// Whether the second set of results is better or worse in this quantity.
    pub finding: Finding,
}

/// Complete comparison of two sets of results.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Number of cases that both sets of results have.
    pub n_pairs: usize,
    /// Number of different seeds among the cases that both sets of results have.
    pub n_seeds: usize,
    /// Cases that only one of the two sets of results has: those of the first set, and those of the second.
    pub unpaired: [Vec<String>; 2],
    /// Cases in which the first set of results has the truth in the box at every step and the second does not.
    pub lost: Vec<String>,
    /// Cases in which the second set of results has the truth in the box at every step and the first does not.
    pub won: Vec<String>,
    /// Cases in which the second set of results has more steps than the first at which the truth is outside the estimate and the cause is a false
    /// claim of the vision, or no cause but the localizer is found.
    pub graver: Vec<String>,
    /// Cases that met the scene's expectations in the first set of results and do not meet them in the second.
    pub missed: Vec<String>,
    /// Cases that ran in the first set of results, and that failed or are missing in the second although its sweep includes them.
    pub failed: Vec<String>,
    /// Names of the compared quantities for which, in some pair of cases, only one of the two sets of results has a value.
    pub half_known: Vec<&'static str>,
    /// Number of pairs of cases with different localizers of which only one states boxes: figures of boxes and of distributions are not compared there.
    pub n_of_two_kinds: usize,
    /// Comparison in each single quantity.
    pub lines: Vec<Line>,
    /// How certain the comparison is to be.
    pub demand: Demand,
}

/// How certain a comparison is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Confidence with which all intervals hold together, between 0 and 1.
    pub confidence: f64,
    /// Greatest worsening that may stay unseen, as a share of the first set's mean.
    pub tolerance: f64,
}

impl Default for Demand {
    fn default() -> Self {
        Demand { confidence: CONFIDENCE, tolerance: TOLERANCE }
    }
}

/// Compares two sets of results.
pub fn compare(first: &Side, second: &Side, demand: Demand) -> Comparison {
    let pairs: Vec<(&String, &load::Case, &load::Case)> =
        first.cases.iter().filter_map(|(name, case)| Some((name, case, second.cases.get(name)?))).collect();
    let knows = |side: &Side, name: &str| side.cases.contains_key(name) || side.not_run.contains(name);
    let only = |one: &Side, other: &Side| one.cases.keys().filter(|name| !knows(other, name)).cloned().collect();
    let keeps = |case: &load::Case| case.figures.get("containment.contained_share").is_some_and(|share| *share >= 1.0);
    let named = |wanted: &dyn Fn(&load::Case, &load::Case) -> bool| -> Vec<String> {
        pairs.iter().filter(|(_, one, other)| wanted(one, other)).map(|(name, _, _)| (*name).clone()).collect()
    };
    // Two localizers of which only one states boxes are compared by what both have. The same localizer, though, has to go on stating boxes.
    let is_of_two_kinds =
        |one: &load::Case, other: &load::Case| one.has_boxes() != other.has_boxes() && one.subject != other.subject;
    let lost = named(&|one, other| keeps(one) && !keeps(other) && !is_of_two_kinds(one, other));
    let won = named(&|one, other| !keeps(one) && keeps(other) && !is_of_two_kinds(one, other));
    let count = |case: &load::Case, cause: &str| case.figures.get(cause).copied().unwrap_or(0.0);
    let grew = |one: &load::Case, other: &load::Case, cause: &str| count(other, cause) > count(one, cause);
    let graver = named(&|one, other| {
        ["containment.unsound", "containment.perception"].iter().any(|cause| grew(one, other, cause))
    });
    let missed = named(&|one, other| one.passed == Some(true) && other.passed == Some(false));
    let is_half_known = |figure: &str| {
        pairs.iter().any(|(_, one, other)| {
            one.figures.contains_key(figure) != other.figures.contains_key(figure) && !is_of_two_kinds(one, other)
        })
    };
    let n_of_two_kinds = pairs.iter().filter(|(_, one, other)| is_of_two_kinds(one, other)).count();
    let half_known = COMPARED.iter().map(|compared| compared.figure).filter(|figure| is_half_known(figure)).collect();
    let is_known = |compared: &&Compared| {
        let has = |case: &load::Case| case.figures.contains_key(compared.figure);
        pairs.iter().any(|(_, one, other)| has(one) && has(other))
    };
    let known: Vec<&Compared> = COMPARED.iter().filter(is_known).collect();
    let miss = (1.0 - demand.confidence) / known.len() as f64;
    let lines = known.iter().filter_map(|compared| line(**compared, &pairs, miss, demand.tolerance)).collect();
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
        n_of_two_kinds,
        lines,
        demand,
    };
    comparison.hold_to_the_guarantee();
    comparison
}

impl Comparison {
    /// Whether the second set of results is worse in anything, or either set lacks a quantity that the other has, or the second lacks cases of the
    /// first.
    pub fn is_worse(&self) -> bool {
        let refuting = [&self.lost, &self.graver, &self.missed, &self.failed, &self.unpaired[0]];
        refuting.iter().any(|cases| !cases.is_empty())
            || !self.half_known.is_empty()
            || self.lines.iter().any(|line| line.finding == Finding::Worse)
    }

    /// Whether too few seeds leave it open in some quantity whether the second set of results is worse by more than is tolerated.
    pub fn is_inconclusive(&self) -> bool {
        self.lines.iter().any(|line| line.finding == Finding::Inconclusive)
    }

    /// Replaces the statistical result for the share of steps with the truth in the box: a single case that lost the truth only in the second set
    /// makes this set worse, whatever the mean; without such a case, cases that regained the truth make it better.
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

/// Compares both sets of results in one quantity, with an interval that misses the mean difference with the probability `miss`; none when no case has a
/// value of it in both sets.
fn line(compared: Compared, pairs: &[(&String, &load::Case, &load::Case)], miss: f64, tolerance: f64) -> Option<Line> {
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
    let difference = interval(&differences, miss);
    let [low, high] = difference;
    let least_seen = 0.5 * (high - low);
    // A worsening that the interval still allows.
    let worst = if compared.less_is_better { high } else { -low };
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
        _ if worst > tolerance * means[0].abs() => Finding::Inconclusive,
        _ => Finding::NotDistinguishable,
    };
    Some(Line { compared, means, difference, least_seen, finding })
}

/// Student's confidence interval of the mean of `differences`, which misses the true mean with probability `miss`: d̄ ± t(1 − miss/2, n − 1) s/√n.
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
