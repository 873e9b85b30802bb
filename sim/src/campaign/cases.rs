//! The cases of a sweep, or the runs below a folder, with what became of each: what tables, reports and comparisons read.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;

use crate::{
    artefacts::run_files::{self, RecordError, naming},
    campaign::sweep::{Plan, Recorded, SweepError, case_folder, read_case, read_plan},
    judge::figures::{Figures, figures},
    loading::{Setting, shown},
};

mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;
mod command;
mod table;

pub use command::{Replay, program, quoted};
pub use csv_file::{from_csv, to_csv};
#[cfg(feature = "parquet")]
pub use parquet_file::to_parquet;
pub use table::{Cell, Table};

/// All cases in a stable order.
#[derive(Clone, Debug)]
pub struct Results {
    /// What they are results of: the scene of a sweep, or the folder of runs.
    pub title: String,
    /// The sweep; none for a folder of runs.
    pub plan: Option<Plan>,
    /// What became of each case.
    pub cases: Vec<CaseResult>,
}

/// What became of one case.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// The case's name in its sweep; empty for a run.
    pub id: String,
    /// Name of the scene.
    pub scene: String,
    /// The scene's file; empty when it is not known.
    pub scene_path: PathBuf,
    /// What was set in the scene.
    pub settings: Vec<Setting>,
    /// The seed.
    pub seed: u64,
    /// Where its files lie.
    pub folder: PathBuf,
    /// Whether it ran, and with what result.
    pub recorded: Recorded,
}

impl Results {
    /// Reads the folder of a sweep, or every run below a folder of runs.
    pub fn read(folder: &Path) -> Result<Results, SweepError> {
        match read_plan(folder)? {
            Some(plan) => Ok(Results::of_sweep(folder, plan, &|_| true)),
            None => Ok(Results::of_runs(folder)?),
        }
    }

    /// The cases of a sweep whose index in the plan `is_meant`.
    pub fn of_sweep(folder: &Path, plan: Plan, is_meant: &dyn Fn(usize) -> bool) -> Results {
        let meant = plan.planned().into_iter().filter(|case| is_meant(case.index));
        let result = |case: crate::campaign::sweep::PlannedCase| CaseResult {
            scene: plan.scene.clone(),
            scene_path: plan.path.clone(),
            folder: case_folder(folder, &case.id),
            recorded: read_case(folder, &case.id),
            id: case.id,
            settings: case.settings,
            seed: case.seed,
        };
        let cases = meant.map(result).collect();
        Results { title: plan.scene.clone(), plan: Some(plan), cases }
    }

    /// Every run below a folder, ordered by scene, settings and seed.
    pub fn of_runs(folder: &Path) -> Result<Results, RecordError> {
        let mut cases = Vec::new();
        collect(folder, &mut cases)?;
        let order = |case: &CaseResult| (case.scene.clone(), case.label(), case.seed);
        cases.sort_by_cached_key(order);
        let mut scenes: Vec<&str> = cases.iter().map(|case| case.scene.as_str()).collect();
        scenes.dedup();
        let title = match scenes.as_slice() {
            [only] => (*only).to_owned(),
            several => format!("{} scenes", several.len()),
        };
        Ok(Results { title, plan: None, cases })
    }

    /// Keys that differ among the cases, in the order of the sweep.
    pub fn keys(&self) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        for setting in self.cases.iter().flat_map(|case| &case.settings) {
            if !keys.contains(&setting.key) {
                keys.push(setting.key.clone());
            }
        }
        keys
    }

    /// Cases of which nothing is there.
    pub fn missing(&self) -> impl Iterator<Item = &CaseResult> {
        self.cases.iter().filter(|case| case.recorded == Recorded::Missing)
    }

    /// Cases that could not run, with the reason.
    pub fn failed(&self) -> impl Iterator<Item = (&CaseResult, &str)> {
        self.cases.iter().filter_map(|case| match &case.recorded {
            Recorded::Failed(reason) => Some((case, reason.as_str())),
            _ => None,
        })
    }

    /// Cases that ran and missed an expectation.
    pub fn missed(&self) -> impl Iterator<Item = &CaseResult> {
        self.cases.iter().filter(|case| case.passed() == Some(false))
    }
}

impl CaseResult {
    /// `summary.json`, if the case ran.
    pub fn summary(&self) -> Option<&Value> {
        match &self.recorded {
            Recorded::Done { summary, .. } => Some(summary),
            _ => None,
        }
    }

    /// `timing.json`, if the case ran.
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

    /// The expectations that were not met, one text each.
    pub fn missed_expectations(&self) -> Vec<&str> {
        let failed = self.summary().and_then(|summary| summary["verdict"]["failed"].as_array());
        failed.into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// The first step at which the truth was outside; null when there was none.
    pub fn first_failure(&self) -> &Value {
        self.summary().map_or(&Value::Null, |summary| &summary["containment"]["first_failure"])
    }

    /// All figures; none when the case did not run.
    pub fn figures(&self) -> Figures {
        self.summary().map(figures).unwrap_or_default()
    }

    /// What tells the case from others of its seed: `key=value key=value`, empty when nothing was set.
    pub fn label(&self) -> String {
        self.settings.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    }

    /// What `key` is set to, as text.
    pub fn value(&self, key: &str) -> String {
        let setting = self.settings.iter().find(|setting| setting.key == key);
        setting.map(|setting| shown(&setting.value)).unwrap_or_default()
    }

    /// One line for people: settings and seed, with the scene where `with_scene`.
    pub fn describe(&self, with_scene: bool) -> String {
        let scene = if with_scene { self.scene.clone() } else { String::new() };
        let parts = [scene, self.label(), format!("seed {}", self.seed)];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// Runs below `folder`; sweeps below it are results of their own and left out.
fn collect(folder: &Path, cases: &mut Vec<CaseResult>) -> Result<(), RecordError> {
    if let Some((summary, timing)) = run_files::read(folder)? {
        let settings = timing["set"].as_array().into_iter().flatten().filter_map(|set| set.as_str()?.parse().ok());
        cases.push(CaseResult {
            id: String::new(),
            scene: summary["scene"].as_str().unwrap_or_default().to_owned(),
            scene_path: timing["scene_path"].as_str().unwrap_or_default().into(),
            settings: settings.collect(),
            seed: summary["seed"].as_u64().unwrap_or_default(),
            folder: folder.to_owned(),
            recorded: Recorded::Done { summary, timing },
        });
        return Ok(());
    }
    for entry in naming("read the folder", folder, fs::read_dir(folder))? {
        let path = naming("read the folder", folder, entry)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !is_hidden && !path.join("sweep.json").exists() {
            collect(&path, cases)?;
        }
    }
    Ok(())
}
