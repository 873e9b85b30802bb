//! The report on more cases than memory holds. Rows of results are read one after the other; what is kept of them does not grow with their number.
//!
//! ```text
//! folder of a sweep ──> pieces of 1000 cases ──> results/part-*  ┐
//! tables of parts   ──> pieces of rows, each case once ──────────┴─> Sketch ──> Overview and the worst cases ──> report
//! ```
//!
//! Counts, means, root mean squares and extremes are those of all cases, as [`Overview::of`] has them but for rounding. Quantiles over the cases come
//! from histograms. Of the cases, the worst are kept, and the first of those that did not run.

mod joined;
mod kept;
mod quantiles;
mod tally;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use crate::{
    artefacts::{
        result_table::{Shown, pooled},
        run_files::{RecordError, naming},
    },
    campaign::{
        cases::{CaseResult, Cell, PARTS, Results, Table, read_pieces},
        report::{Group, MEASURES, Overview, Sketched, as_html, as_markdown},
        sweep::{Plan, SweepError, write_whole},
    },
    judge::figures::Figures,
};

use joined::{Joined, Status};
use kept::{Kept, Origin};
use quantiles::{ACCURACY, Quantiles};
use tally::{Columns, Names, Tally};

/// Greatest number of cases of a sweep whose report is made of all cases at once. Each takes about 0.1 MB of memory.
pub const MOST_WHOLE: usize = 5000;
/// Number of cases in each table that is written of a sweep with more cases.
const PER_PART: usize = 1000;
/// Greatest number of combinations of scene, localizer and settings that are listed.
const MOST_GROUPS: usize = 1000;
/// Greatest number of versions and of adapters that are named.
const MOST_NAMED: usize = 20;

/// Beginnings of the names of the figures that a report shows. The other columns of a table are not read.
const SHOWN: [&str; 12] = [
    "containment.",
    "width.x_m.mean",
    "width.y_m.mean",
    "error.position_m.",
    "availability",
    "power.after_5_s.",
    "distribution.nees.mean",
    "distribution.within_3_sigma_share",
    "metrics.errands",
    "metrics.goals_reached",
    "methods.",
    "set.",
];

/// What is kept of the cases that were added so far.
#[derive(Debug, Default)]
pub struct Sketch {
    names: Names,
    all: Tally,
    groups: BTreeMap<GroupKey, Tally>,
    n_unlisted: usize,
    n_missed: usize,
    n_failed: usize,
    n_missing: usize,
    spreads: Vec<Quantiles>,
    kept: Kept,
    scenes: BTreeSet<String>,
    versions: BTreeSet<String>,
    adapters: BTreeSet<String>,
}

/// Scene, localizer and settings of a combination. Combinations are in the order of their values, numbers before texts.
type GroupKey = (String, String, Vec<(String, tally::Ordered)>);

impl Sketch {
    /// Adds all cases of tables of results: of files, and of folders that sweeps wrote, such as the parts of a sweep, whose plan is returned.
    ///
    /// Each case counts once, however many tables have it: as run where one of them says so, and otherwise as failed where one of them says so. Where
    /// a folder holds a sweep's plan, the cases of the plan that no table has are missing, and tables of another sweep are refused.
    pub fn of_tables(paths: &[PathBuf]) -> Result<(Sketch, Option<Plan>), SweepError> {
        let mut sketch = Sketch::default();
        let (mut joined, mut tables) = Joined::of(paths)?;
        for status in Status::ALL {
            for table in &mut tables {
                // A table is read once more only if it has such cases. Which cases of a plan are missing does not stand in tables.
                let is_needed =
                    table.postponed.contains(&status) && (status != Status::Missing || joined.plan().is_none());
                if status == Status::Ran || is_needed {
                    let (file, origin) = (table.file.clone(), table.origin.clone());
                    read_pieces(&file, &is_shown, &mut |piece| {
                        let mut takes = |columns: &Columns<'_>, row: &[Cell]| joined.takes(table, status, columns, row);
                        sketch.add(piece, &origin, &mut takes);
                    })?;
                    joined.expect_no_other()?;
                }
            }
        }
        if let Some((folder, plan)) = joined.plan() {
            let origin = Origin { folder: folder.clone(), scene_path: plan.path.clone() };
            let missing = plan.planned().filter(|case| joined.is_missing(&case.id));
            let mut missing = missing.map(|case| CaseResult::missing(folder, plan, case));
            while let Some(table) = next_piece(&mut missing, plan) {
                sketch.add(&table, &origin, &mut |_, _| true);
            }
        }
        Ok((sketch, joined.into_plan()))
    }

    /// Reads those cases of a sweep for whose index `is_meant` is true, piece by piece, and writes each piece into the folder `results` of the
    /// sweep's folder as a table.
    pub fn of_sweep(folder: &Path, plan: &Plan, is_meant: &dyn Fn(usize) -> bool) -> Result<Sketch, SweepError> {
        let parts = folder.join(PARTS);
        // Tables of an earlier report may be of other pieces.
        if parts.exists() {
            naming("delete", &parts, fs::remove_dir_all(&parts))?;
        }
        naming("create", &parts, fs::create_dir_all(&parts))?;
        let mut sketch = Sketch::default();
        let origin = Origin { folder: folder.to_owned(), scene_path: plan.path.clone() };
        let meant = plan.planned().filter(|case| is_meant(case.index));
        let mut meant = meant.map(|case| CaseResult::of_sweep(folder, plan, case));
        for number in 0.. {
            let Some(table) = next_piece(&mut meant, plan) else { break };
            write_part(&table, &parts, number)?;
            sketch.add(&table, &origin, &mut |_, _| true);
        }
        Ok(sketch)
    }

    /// Adds those rows of a table for which `is_taken` is true. Their cases were run where `origin` says.
    fn add(&mut self, table: &Table, origin: &Origin, is_taken: &mut dyn FnMut(&Columns<'_>, &[Cell]) -> bool) {
        let columns = Columns::of(table, &mut self.names);
        self.spreads.resize_with(MEASURES.len(), Quantiles::default);
        for row in table.rows.iter().filter(|row| is_taken(&columns, row)) {
            let case = columns.identity(row);
            match (case.status, case.passed) {
                ("failed", _) => self.n_failed += 1,
                ("missing", _) => self.n_missing += 1,
                (_, passed) => self.n_missed += usize::from(passed != Some(true)),
            }
            let figures: Figures = columns.figures(row).map(|(name, value)| (name.to_owned(), value)).collect();
            for (measure, spread) in MEASURES.iter().zip(&mut self.spreads) {
                if let Some(value) = (measure.value)(&figures) {
                    spread.add(value);
                }
            }
            self.all.add(case.passed, columns.slots(row));
            let key = (case.scene.to_owned(), case.subject.to_owned(), columns.settings(row));
            if self.groups.len() < MOST_GROUPS || self.groups.contains_key(&key) {
                self.groups.entry(key).or_default().add(case.passed, columns.slots(row));
            } else {
                self.n_unlisted += 1;
            }
            self.kept.add(&case, &figures, &columns, row, origin);
            for (names, name) in
                [(&mut self.scenes, case.scene), (&mut self.versions, case.version), (&mut self.adapters, case.adapter)]
            {
                if !name.is_empty() && names.len() < MOST_NAMED && !names.contains(name) {
                    names.insert(name.to_owned());
                }
            }
        }
    }

    /// Returns the number of all cases that were added.
    pub fn n_cases(&self) -> usize {
        self.all.n_cases
    }

    /// Returns what a report shows of all cases, and those cases that are kept, in place of all of them.
    pub fn finish(self, plan: Option<Plan>) -> (Overview, Results) {
        let title = match self.scenes.iter().collect::<Vec<_>>().as_slice() {
            [only] => (*only).clone(),
            several => format!("{} scenes", several.len()),
        };
        let mut groups = Vec::new();
        for ((scene, subject, settings), tally) in &self.groups {
            let settings = settings.iter().map(|(key, value)| value.setting(key)).collect();
            groups.push(Group {
                scene: scene.clone(),
                subject: subject.clone(),
                settings,
                n_cases: tally.n_cases,
                n_passed: tally.n_passed,
                figures: pooled(tally.moments(&self.names)),
            });
        }
        let cases = self.kept.into_cases();
        let results = Results { title, plan, cases };
        let spreads = MEASURES.iter().zip(&self.spreads).filter_map(|(measure, spread)| {
            let quantiles: Option<Vec<f64>> = Sketched::SHARES.iter().map(|share| spread.quantile(*share)).collect();
            Some((measure, quantiles?.try_into().ok()?))
        });
        let sketched = Sketched {
            most_whole: MOST_WHOLE,
            n_kept: results.cases.iter().filter(|case| case.summary().is_some()).count(),
            accuracy: ACCURACY,
            spreads: spreads.collect(),
            n_unlisted: self.n_unlisted,
            versions: self.versions,
            adapters: self.adapters,
        };
        // Keys that vary and the order of the kept cases are found as for any results.
        let of_kept = Overview::of(&results);
        let varies = |key: &String| groups.iter().any(|group| group.value(key) != groups[0].value(key));
        let mut keys: Vec<String> = Vec::new();
        for setting in groups.iter().flat_map(|group| &group.settings) {
            if !keys.contains(&setting.key) && varies(&setting.key) {
                keys.push(setting.key.clone());
            }
        }
        let overview = Overview {
            n_passed: self.all.n_passed,
            n_missed: self.n_missed,
            n_failed: self.n_failed,
            n_missing: self.n_missing,
            has_scenes: groups.iter().any(|group| group.scene != groups[0].scene),
            has_subjects: groups.iter().any(|group| group.subject != groups[0].subject),
            keys,
            figures: pooled(self.all.moments(&self.names)),
            groups,
            worst: of_kept.worst,
            sketched: Some(sketched),
            shown: Shown::Usual,
        };
        (overview, results)
    }
}

/// Writes the report of a sketch into `folder`: report.html and summary.md.
pub fn write(overview: &Overview, results: &Results, folder: &Path) -> Result<(), RecordError> {
    write_whole(&folder.join("report.html"), as_html(overview, results).as_bytes())?;
    write_whole(&folder.join("summary.md"), as_markdown(overview, results).as_bytes())
}

/// Returns the table of the next cases; none when there are no more.
fn next_piece(cases: &mut dyn Iterator<Item = CaseResult>, plan: &Plan) -> Option<Table> {
    let cases: Vec<CaseResult> = cases.take(PER_PART).collect();
    (!cases.is_empty()).then(|| Table::of(&Results { title: plan.scene.clone(), plan: None, cases }))
}

/// Whether a report reads the column with this name.
fn is_shown(name: &str) -> bool {
    !name.contains('.') || SHOWN.iter().any(|beginning| name.starts_with(beginning))
}

/// Writes one table of the folder `results`: as Parquet if the program was built with that, otherwise as CSV.
fn write_part(table: &Table, parts: &Path, number: usize) -> Result<(), RecordError> {
    let path = |ending: &str| parts.join(format!("part-{number:05}.{ending}"));
    #[cfg(feature = "parquet")]
    {
        let path = path("parquet");
        let bytes = crate::campaign::cases::to_parquet(table).map_err(std::io::Error::other);
        write_whole(&path, &naming("write", &path, bytes)?)
    }
    #[cfg(not(feature = "parquet"))]
    write_whole(&path("csv"), crate::campaign::cases::to_csv(table).as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_that_a_report_shows_is_read_from_tables() {
        // The names of figures are the texts with a dot or a known name in the source of the shown results.
        let source = include_str!("report/measure.rs").replace("{axis}", "x_m");
        let texts: Vec<&str> = source.split('"').skip(1).step_by(2).collect();
        let is_name =
            |text: &&&str| text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "._".contains(c));
        let names: Vec<&&str> = texts
            .iter()
            .filter(is_name)
            .filter(|text| text.contains('.') && text.starts_with(char::is_alphabetic))
            .collect();
        assert!(names.len() >= 12, "{names:?}");
        for name in names {
            assert!(is_shown(name), "{name}");
        }
        assert!(is_shown("availability") && is_shown("set.floor.friction") && !is_shown("width.x_m.p95"));
    }
}
