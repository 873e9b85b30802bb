//! Summary of all cases: counts, combinations, and the order from the worst case to the best.

use super::{MEASURES, Measure, Sketched};
use crate::{
    artefacts::result_table::{Shown, pool},
    campaign::cases::{CaseResult, Results},
    judge::{figures::Figures, honesty},
    loading::Setting,
};

/// Summary of all cases, from which the HTML page, the Markdown text and the terminal text of the report are made.
#[derive(Clone, Debug)]
pub struct Overview {
    /// Number of cases that ran and met their scene's expectations.
    pub n_passed: usize,
    /// Number of cases that ran and missed an expectation of their scene.
    pub n_missed: usize,
    /// Number of cases that could not run.
    pub n_failed: usize,
    /// Number of cases without a record.
    pub n_missing: usize,
    /// Whether the cases belong to more than one scene.
    pub has_scenes: bool,
    /// Whether the cases test more than one localizer.
    pub has_subjects: bool,
    /// Scene keys that have several values among the cases, in the order of the sweep.
    pub keys: Vec<String>,
    /// Numerical results pooled over all cases.
    pub figures: Figures,
    /// One group for each combination of scene, localizer and settings, in the order of the sweep.
    pub groups: Vec<Group>,
    /// Indices of the cases that ran, the worst first.
    pub worst: Vec<usize>,
    /// How the figures spread over the cases, where these are too many to be kept: the results then have the worst ones only.
    pub sketched: Option<Sketched>,
    /// The figures that the tables of the report show.
    pub shown: Shown,
}

/// The cases of all seeds of one combination of scene, localizer and settings.
#[derive(Clone, Debug)]
pub struct Group {
    /// Name of the scene of the combination.
    pub scene: String,
    /// Name of the localizer under test.
    pub subject: String,
    /// Keys that are set in the scene, with their values.
    pub settings: Vec<Setting>,
    /// Number of cases of the combination.
    pub n_cases: usize,
    /// Number of cases of the combination that passed.
    pub n_passed: usize,
    /// Numerical results pooled over those cases of the combination that ran.
    pub figures: Figures,
}

impl Overview {
    /// Sums up the cases of `results`.
    pub fn of(results: &Results) -> Overview {
        let groups = groups(results);
        let n_passed = groups.iter().map(|group| group.n_passed).sum();
        let varies = |key: &String| {
            let value = |group: &Group| group.settings.iter().find(|one| one.key == *key).map(ToString::to_string);
            groups.iter().any(|group| value(group) != value(&groups[0]))
        };
        let figures: Vec<Figures> = results.cases.iter().map(CaseResult::figures).collect();
        let ran: Vec<&Figures> = figures.iter().filter(|figures| !figures.is_empty()).collect();
        let mut worst: Vec<usize> = (0..figures.len()).filter(|index| !figures[*index].is_empty()).collect();
        // The sorting keeps equally bad cases in the order of the sweep.
        worst.sort_by(|one, other| {
            let badness = |index: usize| badness(results.cases[index].passed(), &figures[index]);
            badness(*other).partial_cmp(&badness(*one)).unwrap_or(std::cmp::Ordering::Equal)
        });
        Overview {
            n_passed,
            n_missed: results.missed().count(),
            n_failed: results.failed().count(),
            n_missing: results.missing().count(),
            has_subjects: groups.iter().any(|group| group.subject != groups[0].subject),
            has_scenes: groups.iter().any(|group| group.scene != groups[0].scene),
            keys: results.keys().into_iter().filter(varies).collect(),
            figures: pool(&ran),
            groups,
            worst,
            sketched: None,
            shown: Shown::Usual,
        }
    }

    /// Returns the number of all cases, whether or not they ran and passed.
    pub fn n_cases(&self) -> usize {
        self.n_passed + self.n_missed + self.n_failed + self.n_missing
    }

    /// Whether every case ran and passed.
    pub fn has_passed(&self) -> bool {
        self.n_passed == self.n_cases()
    }

    /// Returns the verdict on all cases in one line.
    pub fn headline(&self) -> String {
        let n_cases = self.n_cases();
        let cases = if n_cases == 1 { "case" } else { "cases" };
        if self.has_passed() {
            return match n_cases {
                0 => "There are no cases".to_owned(),
                1 => "The case met the scene's expectations".to_owned(),
                _ => format!("All {n_cases} cases met their scene's expectations"),
            };
        }
        let counts = [
            (self.n_missed, "missed an expectation"),
            (self.n_failed, "could not run"),
            (self.n_missing, if self.n_missing == 1 { "is missing" } else { "are missing" }),
        ];
        let told: Vec<String> = counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        format!("Of {n_cases} {cases}, {}", told.join(", "))
    }

    /// Whether localizers that state distributions are overconfident, in a sentence for each: over all cases of a localizer, whatever their scenes and
    /// settings.
    pub fn honesty(&self) -> Vec<String> {
        let mut subjects: Vec<&str> = self.groups.iter().map(|group| group.subject.as_str()).collect();
        subjects.sort_unstable();
        subjects.dedup();
        let of = |subject: &str| {
            let groups = self.groups.iter().filter(|group| group.subject == subject);
            let figures: Vec<&Figures> =
                groups.map(|group| &group.figures).filter(|figures| !figures.is_empty()).collect();
            Some(format!("{subject} is {}", honesty(&pool(&figures))?))
        };
        subjects.into_iter().filter_map(of).collect()
    }

    /// Returns those numerical results of a report for which at least one case has a value.
    pub fn measures(&self) -> impl Iterator<Item = &'static Measure> + '_ {
        MEASURES.iter().filter(|measure| (measure.value)(&self.figures).is_some())
    }

    /// Returns the number of steps with the truth outside the box for each cause: a declared bound that was exceeded, false claims of the vision, or
    /// the localizer. Where a log's truth is outside, no cause is known. Empty where no case has boxes and a truth.
    pub fn outside(&self) -> Vec<(&'static str, u64)> {
        let names = [
            ("bound broken", "bound_broken"),
            ("perception", "perception"),
            ("unsound", "unsound"),
            ("outside", "outside"),
        ];
        let count = |name: &str| self.figures.get(&format!("containment.{name}")).map(|count| *count as u64);
        names.into_iter().filter_map(|(shown, name)| Some((shown, count(name)?))).collect()
    }
}

impl Group {
    /// Returns the value to which the combination sets `key`, as text.
    pub fn value(&self, key: &str) -> String {
        let setting = self.settings.iter().find(|setting| setting.key == key);
        setting.map(|setting| crate::loading::shown(&setting.value)).unwrap_or_default()
    }
}

fn groups(results: &Results) -> Vec<Group> {
    let mut groups: Vec<(Group, Vec<Figures>)> = Vec::new();
    for case in &results.cases {
        let belongs = |group: &Group| {
            group.scene == case.scene && group.subject == case.subject && group.settings == case.settings
        };
        // Cases of one combination of settings follow each other, so that a case belongs to the last group or begins a new one.
        if !groups.last().is_some_and(|(group, _)| belongs(group)) {
            let (scene, subject, settings) = (case.scene.clone(), case.subject.clone(), case.settings.clone());
            groups.push((
                Group { scene, subject, settings, n_cases: 0, n_passed: 0, figures: Figures::new() },
                Vec::new(),
            ));
        }
        let Some((group, ran)) = groups.last_mut() else { continue };
        group.n_cases += 1;
        group.n_passed += usize::from(case.passed() == Some(true));
        ran.extend(case.summary().map(|_| case.figures()));
    }
    let pooled =
        |(group, ran): (Group, Vec<Figures>)| Group { figures: pool(&ran.iter().collect::<Vec<_>>()), ..group };
    groups.into_iter().map(pooled).collect()
}

/// Returns a key for sorting cases, greater for worse ones: missed expectations count first, then the gravest cause for which the truth was lost,
/// then the number of steps with the truth outside, then the greatest error.
pub(in crate::campaign) fn badness(passed: Option<bool>, figures: &Figures) -> (bool, u8, f64, f64) {
    let figure = |name: &str| figures.get(name).copied().unwrap_or_default();
    let counts = ["unsound", "perception", "bound_broken"].map(|name| figure(&format!("containment.{name}")));
    let gravest = counts.iter().position(|count| *count > 0.0).map_or(0, |index| 3 - index as u8);
    (passed == Some(false), gravest, counts.iter().sum(), figure("error.position_m.max"))
}
