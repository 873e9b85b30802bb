//! The cases of a sweep (one run each), or the runs below a folder, with their results. Tables, reports and comparisons are made from these results.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::{
    artefacts::run_files::{self, RecordError, run_folders, subject_of},
    campaign::sweep::{Plan, PlannedCase, Recorded, SweepError, case_folder, read_case, read_plan},
    judge::figures::{Figures, figures},
    loading::{Setting, shown},
    subject::SubjectChoice,
};

mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;
mod command;
mod table;
mod table_file;

pub use command::{Replay, program, quoted, subject_option};
pub use csv_file::{from_csv, to_csv};
#[cfg(feature = "parquet")]
pub use parquet_file::to_parquet;
pub use table::{Cell, Table};
pub use table_file::{PARTS, read_pieces, table_files};

/// Results of all cases of a sweep or of a folder of runs, in a stable order.
#[derive(Clone, Debug)]
pub struct Results {
    /// Title of the results: the scene of a sweep, or for a folder of runs its only scene or the number of its scenes.
    pub title: String,
    /// Plan of the sweep; none for a folder of runs.
    pub plan: Option<Plan>,
    /// Result of each case.
    pub cases: Vec<CaseResult>,
}

/// Result of one case: one run of a scene with some settings and a seed.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// Name of the case in its sweep; empty for a run that belongs to no sweep.
    pub id: String,
    /// Name of the case's scene.
    pub scene: String,
    /// Path of the scene's file; empty when it is not known.
    pub scene_path: PathBuf,
    /// Keys of the scene that were set for the case.
    pub settings: Vec<Setting>,
    /// Seed of the run.
    pub seed: u64,
    /// Name of the localizer under test.
    pub subject: String,
    /// Whether that localizer lives in another program, so that the option `--subject` cannot start it again by its name.
    pub subject_is_elsewhere: bool,
    /// Folder with the files of the case.
    pub folder: PathBuf,
    /// Whether the case ran, and with what result.
    pub recorded: Recorded,
}

impl Results {
    /// Reads the results of a sweep's folder, or of every run below a folder of runs.
    pub fn read(folder: &Path) -> Result<Results, SweepError> {
        match read_plan(folder)? {
            Some(plan) => Ok(Results::of_sweep(folder, plan, &|_| true)),
            None => Ok(Results::of_runs(folder)?),
        }
    }

    /// Reads the results of some cases of a sweep: those for which `is_meant` is true of the case's index in the plan.
    pub fn of_sweep(folder: &Path, plan: Plan, is_meant: &dyn Fn(usize) -> bool) -> Results {
        let meant = plan.planned().filter(|case| is_meant(case.index));
        let cases = meant.map(|case| CaseResult::of_sweep(folder, &plan, case)).collect();
        Results { title: plan.scene.clone(), plan: Some(plan), cases }
    }

    /// Reads every run below a folder; the runs are ordered by scene, localizer, settings and seed.
    pub fn of_runs(folder: &Path) -> Result<Results, RecordError> {
        // Sweeps below the folder are left out, as they are results of their own.
        let folders = run_folders(folder, &|below| !below.join("sweep.json").exists())?;
        let cases: Result<Vec<Option<CaseResult>>, RecordError> = folders.into_iter().map(CaseResult::read).collect();
        let mut cases: Vec<CaseResult> = cases?.into_iter().flatten().collect();
        let order = |case: &CaseResult| (case.scene.clone(), case.subject.clone(), case.label(), case.seed);
        cases.sort_by_cached_key(order);
        let mut scenes: Vec<&str> = cases.iter().map(|case| case.scene.as_str()).collect();
        scenes.dedup();
        let title = match scenes.as_slice() {
            [only] => (*only).to_owned(),
            several => format!("{} scenes", several.len()),
        };
        Ok(Results { title, plan: None, cases })
    }

    /// Returns the keys that are set in any case, in the order of the sweep.
    pub fn keys(&self) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        for setting in self.cases.iter().flat_map(|case| &case.settings) {
            if !keys.contains(&setting.key) {
                keys.push(setting.key.clone());
            }
        }
        keys
    }

    /// Returns the cases without a record, which have not run.
    pub fn missing(&self) -> impl Iterator<Item = &CaseResult> {
        self.cases.iter().filter(|case| case.recorded == Recorded::Missing)
    }

    /// Returns the cases that could not run, with the reason for each.
    pub fn failed(&self) -> impl Iterator<Item = (&CaseResult, &str)> {
        self.cases.iter().filter_map(|case| match &case.recorded {
            Recorded::Failed(reason) => Some((case, reason.as_str())),
            _ => None,
        })
    }

    /// Returns the cases that ran and missed an expectation of their scene.
    pub fn missed(&self) -> impl Iterator<Item = &CaseResult> {
        self.cases.iter().filter(|case| case.passed() == Some(false))
    }
}

impl CaseResult {
    /// Reads the result of one case of the sweep in `folder`.
    pub fn of_sweep(folder: &Path, plan: &Plan, case: PlannedCase) -> CaseResult {
        let recorded = read_case(folder, &case.id);
        CaseResult { recorded, ..CaseResult::missing(folder, plan, case) }
    }

    /// Returns the result of one case of the sweep in `folder` as if it had not run.
    pub fn missing(folder: &Path, plan: &Plan, case: PlannedCase) -> CaseResult {
        CaseResult {
            scene: plan.scene.clone(),
            scene_path: plan.path.clone(),
            folder: case_folder(folder, &case.id),
            recorded: Recorded::Missing,
            id: case.id,
            settings: case.settings,
            seed: case.seed,
            // A sweep's own file tells its localizer by name alone.
            subject_is_elsewhere: !is_known(&plan.subject),
            subject: plan.subject.clone(),
        }
    }

    /// Reads the run that `folder` holds; `None` where it holds none.
    pub fn read(folder: PathBuf) -> Result<Option<CaseResult>, RecordError> {
        let Some((summary, timing)) = run_files::read(&folder)? else { return Ok(None) };
        let settings = timing["set"].as_array().into_iter().flatten().filter_map(|set| set.as_str()?.parse().ok());
        Ok(Some(CaseResult {
            id: String::new(),
            scene: summary["scene"].as_str().unwrap_or_default().to_owned(),
            scene_path: timing["scene_path"].as_str().unwrap_or_default().into(),
            settings: settings.collect(),
            seed: summary["seed"].as_u64().unwrap_or_default(),
            subject_is_elsewhere: timing["subject_is_elsewhere"].as_bool().unwrap_or(false)
                || !is_known(&subject_of(&summary)),
            subject: subject_of(&summary),
            folder,
            recorded: Recorded::Done { summary, timing },
        }))
    }

    /// Returns the contents of `summary.json`, if the case ran.
    pub fn summary(&self) -> Option<&Value> {
        match &self.recorded {
            Recorded::Done { summary, .. } => Some(summary),
            _ => None,
        }
    }

    /// Returns the contents of `timing.json`, if the case ran.
    pub fn timing(&self) -> Option<&Value> {
        match &self.recorded {
            Recorded::Done { timing, .. } => Some(timing),
            _ => None,
        }
    }

    /// Whether the scene's expectations were met; none when the case did not run.
    pub fn passed(&self) -> Option<bool> {
        Some(self.summary()?["verdict"]["passed"].as_bool().unwrap_or_default())
    }

    /// Returns the expectations of the scene that were not met, one text each.
    pub fn missed_expectations(&self) -> Vec<&str> {
        let failed = self.summary().and_then(|summary| summary["verdict"]["failed"].as_array());
        failed.into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// Returns the record of the first step at which the truth was outside the estimate; null when there was no such step.
    pub fn first_failure(&self) -> &Value {
        self.summary().map_or(&Value::Null, |summary| &summary["containment"]["first_failure"])
    }

    /// Returns all numerical results of the case; none when the case did not run.
    pub fn figures(&self) -> Figures {
        self.summary().map(figures).unwrap_or_default()
    }

    /// Returns the settings of the case, which distinguish it from other cases of the same seed: `key=value key=value`, empty when nothing was set.
    pub fn label(&self) -> String {
        self.settings.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    }

    /// Returns the value to which `key` is set in the case, as text; empty when the key is not set.
    pub fn value(&self, key: &str) -> String {
        let setting = self.settings.iter().find(|setting| setting.key == key);
        setting.map(|setting| shown(&setting.value)).unwrap_or_default()
    }

    /// Describes the case in one line for people: settings and seed, with the scene's name before them if `with_scene`, and the name of the localizer
    /// unless it is the usual one.
    pub fn describe(&self, with_scene: bool) -> String {
        let scene = if with_scene { self.scene.clone() } else { String::new() };
        let is_usual = self.subject == SubjectChoice::default().to_string();
        let subject = if is_usual { String::new() } else { self.subject.clone() };
        let parts = [scene, subject, self.label(), format!("seed {}", self.seed)];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// Whether the option `--subject` takes this name of a localizer, or this command.
fn is_known(subject: &str) -> bool {
    subject.parse::<SubjectChoice>().is_ok()
}
