//! What a guarantee costs, and what overconfidence costs: several localizers side by side on the same readings, scene by scene.

use std::{collections::BTreeMap, fs, path::Path};

use crate::{
    artefacts::result_table::pool,
    campaign::cases::{CaseResult, Results},
    judge::{corridor, figures::Figures},
};

/// One line of the table: all runs of a localizer in a scene with the same settings.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    /// The scene, with the keys that are set.
    pub scene: String,
    /// Name of the localizer.
    pub subject: String,
    /// Texts of the cells below [`HEADINGS`].
    pub cells: [String; HEADINGS.len()],
    /// Texts of the cells below [`CALIBRATION`], for a localizer that states distributions.
    pub calibration: Option<[String; CALIBRATION.len()]>,
}

/// Headings of the table, after those of scene and localizer.
pub(super) const HEADINGS: [&str; 6] =
    ["RMSE, mm, °", "NEES, in corridor, %", "truth held, %", "width, mm, °", "per reading, age, ms", "goals, %"];

/// Headings of the table of calibration, after those of scene and localizer.
pub(super) const CALIBRATION: [&str; 6] = ["50 %", "90 %", "95 %", "99 %", "99.7 %", "width of 95 %, mm, °"];

/// Sentence that explains the table of calibration.
pub(super) const CALIBRATION_NOTE: &str = "How often the truth was in the region that the localizer says holds it at so many percent, in percent of the \
    steps; and the mean full width of the interval that holds 95 % along an axis, for the wider of x and y, and for the heading.";

/// Sentences that explain the table.
pub(super) const NOTE: &str = "RMSE: root mean square distance of the stated position (middle of the boxes, mean of a distribution), and that of the \
    heading. NEES: normalised error squared, 3 where the stated covariance is right, more where it is overconfident. In corridor: share of the whole \
    seconds at which the mean over several runs is where 95 % of right filters have it. Truth held: share of steps with the truth in the boxes, or within \
    3σ along x, y and heading at once. Width: mean full width of the box or of 3σ, the wider of x and y, and that of the heading. Per reading: mean time \
    that a reading took. Age: mean age of the newest reading in the answer, where the localizer tells it.";

/// The lines of the table; empty unless a localizer states distributions or several localizers ran.
pub(super) fn costs(results: &Results) -> Vec<Cost> {
    let mut groups: BTreeMap<(String, String), Vec<&CaseResult>> = BTreeMap::new();
    for case in results.cases.iter().filter(|case| case.summary().is_some()) {
        let scene = [case.scene.as_str(), &case.label()].join(" ").trim_end().to_owned();
        groups.entry((scene, case.subject.clone())).or_default().push(case);
    }
    let has_several = groups.keys().any(|(_, subject)| Some(subject) != groups.keys().next().map(|(_, first)| first));
    let lines: Vec<(Cost, bool)> = groups.into_iter().map(|(key, cases)| cost(key, &cases)).collect();
    let is_asked = has_several || lines.iter().any(|(_, is_distribution)| *is_distribution);
    lines.into_iter().filter(|_| is_asked).map(|(cost, _)| cost).collect()
}

/// The line of a localizer's runs in a scene, and whether it states distributions.
fn cost((scene, subject): (String, String), cases: &[&CaseResult]) -> (Cost, bool) {
    let figures: Vec<Figures> = cases.iter().map(|case| case.figures()).collect();
    let pooled = pool(&figures.iter().collect::<Vec<_>>());
    let figure = |name: &str| pooled.get(name).copied();
    let wider = |table: &str| {
        let along = |axis: &str| figure(&format!("{table}.{axis}.mean"));
        Some(along("x_m")?.max(along("y_m")?))
    };
    let position_m = || Some(figure("error.x_m.rmse")?.hypot(figure("error.y_m.rmse")?));
    let share = |part: Option<f64>| part.map(|share| 1e2 * share);
    let goals = || Some(figure("metrics.goals_reached")? / figure("metrics.errands").filter(|errands| *errands > 0.0)?);
    let times_ms: Vec<f64> =
        cases.iter().filter_map(|case| case.timing()?["per_reading_ms"]["mean"].as_f64()).collect();
    let per_reading_ms = (!times_ms.is_empty()).then(|| times_ms.iter().sum::<f64>() / times_ms.len() as f64);
    let heading = |name: &str| figure(name).map(f64::to_degrees);
    let region = "distribution.region_3_sigma";
    let shown = |value: Option<f64>, digits: usize| value.map(|value| format!("{value:.digits$}")).unwrap_or_default();
    let heading_width = heading("width.heading_rad.mean").or_else(|| heading(&format!("{region}.heading_rad.mean")));
    let cells = [
        both(shown(position_m().map(|m| 1e3 * m), 1), shown(heading("error.heading_rad.rmse"), 3)),
        both(shown(figure("distribution.nees.mean"), 1), shown(share(in_corridor_share(cases)), 0)),
        held(figure("containment.contained_share").or_else(|| figure("distribution.within_3_sigma_share"))),
        both(shown(wider("width").or_else(|| wider(region)).map(|m| 1e3 * m), 1), shown(heading_width, 2)),
        both(shown(per_reading_ms, 3), shown(figure("latency_s.mean").map(|age_s| 1e3 * age_s), 1)),
        shown(share(goals()), 0),
    ];
    let within = |percent: &str| shown(share(figure(&format!("distribution.calibration.within_{percent}"))), 1);
    let region = "distribution.region_95";
    let calibration = figure("distribution.checks").map(|_| {
        let [half, most, more, nearly, all] = ["50", "90", "95", "99", "99_7"].map(within);
        let width_mm = shown(wider(region).map(|m| 1e3 * m), 1);
        [half, most, more, nearly, all, both(width_mm, shown(heading(&format!("{region}.heading_rad.mean")), 2))]
    });
    let is_distribution = calibration.is_some();
    (Cost { scene, subject, cells, calibration }, is_distribution)
}

/// Two figures in one cell, of which either may be missing.
fn both(first: String, second: String) -> String {
    [first, second].into_iter().filter(|figure| !figure.is_empty()).collect::<Vec<_>>().join(", ")
}

/// A share in percent that reads 100 only when it is complete.
fn held(share: Option<f64>) -> String {
    match share {
        None => String::new(),
        Some(share) if share >= 1.0 => "100".to_owned(),
        Some(share) => format!("{:.2}", (1e2 * share).min(99.99)),
    }
}

/// Share of the whole seconds of several runs at which the mean of their normalised errors is in the corridor of so many runs; `None` for a single
/// run, and for runs without distributions.
fn in_corridor_share(cases: &[&CaseResult]) -> Option<f64> {
    let runs: Vec<BTreeMap<u64, f64>> = cases.iter().map(|case| nees_by_second(&case.folder)).collect();
    let (first, others) = runs.split_first().filter(|(_, others)| !others.is_empty())?;
    let [low, high] = corridor(runs.len());
    let mean = |second: &u64| -> Option<f64> {
        let sum = others.iter().try_fold(*first.get(second)?, |sum, run| Some(sum + run.get(second)?))?;
        Some(sum / runs.len() as f64)
    };
    let means: Vec<f64> = first.keys().filter_map(mean).collect();
    let n_within = means.iter().filter(|mean| (low..=high).contains(*mean)).count();
    (!means.is_empty()).then(|| n_within as f64 / means.len() as f64)
}

/// The normalised errors of a run at whole seconds, from its `distribution.csv`; none when it has no such file that can be read.
fn nees_by_second(folder: &Path) -> BTreeMap<u64, f64> {
    let Ok(text) = fs::read_to_string(folder.join("distribution.csv")) else { return BTreeMap::new() };
    let of_line = |line: &str| {
        let (time_s, rest) = line.split_once(',')?;
        let second = time_s.strip_suffix(".000")?.parse().ok()?;
        Some((second, rest.rsplit(',').next()?.parse().ok()?))
    };
    text.lines().skip(1).filter_map(of_line).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::path::PathBuf;

    use crate::campaign::sweep::Recorded;

    use super::*;

    /// A run in a folder of its own, with these normalised errors at whole seconds.
    fn case(name: &str, nees: &[f64]) -> CaseResult {
        let folder = std::env::temp_dir().join(format!("wherein_costs_{name}_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let lines: String =
            nees.iter().enumerate().map(|(second, nees)| format!("{second}.000,0,0,{nees}\n")).collect();
        fs::write(folder.join("distribution.csv"), format!("time_s,x,y,nees\n{lines}")).unwrap();
        CaseResult {
            id: String::new(),
            scene: "x".to_owned(),
            scene_path: PathBuf::new(),
            settings: Vec::new(),
            seed: 1,
            subject: "ekf".to_owned(),
            subject_is_elsewhere: false,
            folder,
            recorded: Recorded::Missing,
        }
    }

    #[test]
    fn the_mean_over_two_runs_has_the_corridor_of_two_runs() {
        // χ² at 2.5 % and 97.5 % is 0.216 and 9.348 with three degrees of freedom, and 1.237 and 14.449 with six: the mean of two runs is from 0.619
        // to 7.225. The means are 8, 0.5 and 7.
        let cases = [case("one", &[9.0, 0.4, 13.0]), case("other", &[7.0, 0.6, 1.0])];
        let share = in_corridor_share(&cases.iter().collect::<Vec<_>>());
        cases.iter().for_each(|case| fs::remove_dir_all(&case.folder).unwrap());
        assert_eq!(share, Some(1.0 / 3.0));
    }
}
