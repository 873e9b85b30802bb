//! Runs, sweeps and comparisons: what the commands do, with tables as results.

use std::{ops::Range, path::PathBuf};

use pyo3::{IntoPyObjectExt, exceptions::PyValueError, prelude::*, types::PyDict};
use sim::{
    artefacts::{machine::cores, result_table::Shown, run_files},
    campaign::{
        cases::{CaseResult, Cell, Results, Table},
        comparison::{Demand, Finding, Side, as_text, compare as compare_sides},
        judged_run::run_judged,
        junit::to_junit,
        report,
        sweep::{Begun, Seeds, Shard, Sweep, Variable, Work, run_cases, write_whole},
    },
    loading::SceneFile,
    render::Renderer,
    run::RunOptions,
};

use crate::{
    asked::{frames_policy, scene_file, toml_of},
    called::subject_choice,
    errors::{self, WhereinError},
    stop::{Stop, interruptible},
};

/// Runs scenes with seeds one after another and records each; returns the columns of the table of results.
#[pyfunction]
#[pyo3(signature = (paths, seeds, subject, set, out, frames, adapter, baselines))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run_scenes(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    seeds: &Bound<'_, PyAny>,
    subject: Option<&Bound<'_, PyAny>>,
    set: Option<&Bound<'_, PyAny>>,
    out: PathBuf,
    frames: &str,
    adapter: Option<String>,
    baselines: bool,
) -> PyResult<Py<PyDict>> {
    let stop = Stop::default();
    let (seeds, choice, keep_images) = (range(seeds)?, subject_choice(subject, &stop)?, frames_policy(frames)?);
    let files = SceneFile::load_all(&paths).map_err(|error| errors::of_scene(&error))?;
    let files = files.iter().map(|file| scene_file(&file.path, set)).collect::<PyResult<Vec<SceneFile>>>()?;
    run_files::prepare(&out).map_err(|error| errors::of_record(&error))?;
    let has_camera = files.iter().any(|file| file.scene.has_camera());
    let (asked, choice) = (stop.clone(), choice.until(stop.flag()));
    let folders = interruptible(py, &stop, move || {
        let mut renderer = if has_camera { Some(Renderer::on_adapter(adapter.as_deref())?) } else { None };
        let mut folders = Vec::new();
        for (file, seed) in files.iter().flat_map(|file| seeds.clone().map(move |seed| (file, seed))) {
            let used = renderer.as_mut().filter(|_| file.scene.has_camera());
            let options = RunOptions { keep_images, baselines };
            let (record, verdict) = run_judged(&file.scene, seed, &choice, &options, used, &mut (), &mut |_| {})?;
            if asked.is_set() {
                return Ok(None);
            }
            folders.push(run_files::write(&out, file, &record, &verdict)?);
        }
        Ok(Some(folders))
    })?;
    let cases = folders.into_iter().filter_map(|folder| CaseResult::read(folder).transpose()).collect::<Result<_, _>>();
    let results =
        Results { title: "runs".to_owned(), plan: None, cases: cases.map_err(|error| errors::of_record(&error))? };
    columns(py, &results)
}

/// Runs every combination of the values of some keys with every seed, and writes the report; returns the columns of the table of results.
#[pyfunction]
#[pyo3(signature = (scene, vary, seeds, subject, out, jobs, frames, adapter, baselines))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run_sweep(
    py: Python<'_>,
    scene: PathBuf,
    vary: &Bound<'_, PyDict>,
    seeds: &Bound<'_, PyAny>,
    subject: Option<&Bound<'_, PyAny>>,
    out: Option<PathBuf>,
    jobs: Option<usize>,
    frames: &str,
    adapter: Option<String>,
    baselines: bool,
) -> PyResult<Py<PyDict>> {
    let vary =
        vary.iter().map(|(key, values)| variable(&key.extract::<String>()?, &values)).collect::<PyResult<_>>()?;
    let stop = Stop::default();
    let sweep = Sweep { scene, vary, seeds: range(seeds)?, subject: subject_choice(subject, &stop)?, baselines };
    let (frames, jobs) = (frames_policy(frames)?, jobs.unwrap_or_else(cores));
    let asked = stop.clone();
    let results = interruptible(py, &stop, move || {
        let mut begun = Begun::of(&sweep, out.as_deref(), adapter.as_deref())?;
        let renderer = begun.renderer.take();
        let (todo, _) = begun.todo(Shard::WHOLE, frames);
        let subject = sweep.subject.until(asked.flag());
        let options = RunOptions { keep_images: frames, baselines };
        run_cases(
            Work { cases: &todo, subject: &subject, jobs, options, renderer, store: &begun.store, stop: asked.flag() },
            &mut |_| {},
        )?;
        if asked.is_set() {
            return Ok(None);
        }
        let results = Results::of_sweep(&begun.out, begun.plan, &|_| true);
        report::write(&results, &Shown::Usual, &begun.out)?;
        Ok(Some(results))
    })?;
    columns(py, &results)
}

/// Writes the report of a folder of results: report.html, summary.md and results.csv, and JUnit XML into a file; returns the columns of the table of
/// results.
#[pyfunction]
#[pyo3(signature = (folder, junit))]
pub(crate) fn report_folder(py: Python<'_>, folder: PathBuf, junit: Option<PathBuf>) -> PyResult<Py<PyDict>> {
    let results = Results::read(&folder).map_err(|error| errors::of_sweep(&error))?;
    if results.cases.is_empty() {
        let folder = folder.display();
        return Err(WhereinError::new_err(format!(
            "failed to find results in {folder}: expected summary.json files of runs, or a sweep"
        )));
    }
    report::write(&results, &Shown::Usual, &folder).map_err(|error| errors::of_record(&error))?;
    if let Some(path) = junit {
        let text = to_junit(&results).map_err(|error| WhereinError::new_err(error.to_string()))?;
        write_whole(&path, text.as_bytes()).map_err(|error| errors::of_record(&error))?;
    }
    columns(py, &results)
}

/// Compares two sets of results: columns with one entry for each quantity, the text that the command prints, and whether the second is worse.
#[pyfunction]
pub(crate) fn compare_results(
    py: Python<'_>,
    first: PathBuf,
    second: PathBuf,
    confidence: f64,
    tolerance: f64,
) -> PyResult<(Py<PyDict>, String, bool)> {
    if !(0.0..1.0).contains(&confidence) || tolerance.is_nan() || tolerance < 0.0 {
        return Err(PyValueError::new_err(format!(
            "expected a confidence from 0 to below 1 and a tolerance of at least 0, found {confidence} and {tolerance}"
        )));
    }
    let side = |path: &PathBuf| Side::load(path).map_err(|error| errors::of_side(&error));
    let comparison = compare_sides(&side(&first)?, &side(&second)?, Demand { confidence, tolerance });
    if comparison.n_pairs == 0 {
        let (first, second) = (first.display(), second.display());
        return Err(WhereinError::new_err(format!(
            "failed to compare {first} and {second}: no case ran in both, expected the same scenes, settings and seeds"
        )));
    }
    let lines = &comparison.lines;
    let finding = |finding| match finding {
        Finding::Better => "better",
        Finding::Worse => "worse",
        Finding::NotDistinguishable => "not distinguishable",
        Finding::Inconclusive => "inconclusive",
    };
    let table = PyDict::new(py);
    table.set_item("figure", lines.iter().map(|line| line.compared.figure).collect::<Vec<_>>())?;
    table.set_item("first", lines.iter().map(|line| line.means[0]).collect::<Vec<_>>())?;
    table.set_item("second", lines.iter().map(|line| line.means[1]).collect::<Vec<_>>())?;
    table.set_item("difference_low", lines.iter().map(|line| line.difference[0]).collect::<Vec<_>>())?;
    table.set_item("difference_high", lines.iter().map(|line| line.difference[1]).collect::<Vec<_>>())?;
    table.set_item("finding", lines.iter().map(|line| finding(line.finding)).collect::<Vec<_>>())?;
    Ok((table.unbind(), as_text(&comparison), comparison.is_worse()))
}

/// Seeds as a `range`, a number, or a text `A..B`.
fn range(seeds: &Bound<'_, PyAny>) -> PyResult<Range<u64>> {
    if let Ok(seed) = seeds.extract::<u64>() {
        return Ok(seed..seed + 1);
    }
    if let Ok(text) = seeds.extract::<String>() {
        let parsed: Result<Seeds, String> = text.parse();
        return parsed.map(|Seeds(seeds)| seeds).map_err(|reason| PyValueError::new_err(format!("seeds: {reason}")));
    }
    let wrong =
        || PyValueError::new_err(format!("seeds: expected a number or range(A, B) with A below B, found {seeds}"));
    let part = |name: &str| seeds.getattr(name).and_then(|part| part.extract::<u64>()).map_err(|_| wrong());
    let (start, stop, step) = (part("start")?, part("stop")?, part("step")?);
    if step == 1 && start < stop { Ok(start..stop) } else { Err(wrong()) }
}

/// A key that varies: a list of its values, or the text that the command has after `key=`.
fn variable(key: &str, values: &Bound<'_, PyAny>) -> PyResult<Variable> {
    let text = match values.extract::<String>() {
        Ok(text) => text,
        Err(_) => {
            let values: Vec<String> = values.try_iter()?.map(|value| toml_of(&value?)).collect::<PyResult<_>>()?;
            values.join(",")
        }
    };
    format!("{key}={text}").parse().map_err(|reason| PyValueError::new_err(format!("vary: {key}={text}: {reason}")))
}

/// The table of results as a dict of columns.
fn columns(py: Python<'_>, results: &Results) -> PyResult<Py<PyDict>> {
    let table = Table::of(results);
    let columns = PyDict::new(py);
    for (index, name) in table.columns.iter().enumerate() {
        let cell = |row: &Vec<Cell>| match &row[index] {
            Cell::Empty => Ok(py.None()),
            Cell::Text(text) => text.into_py_any(py),
            Cell::Number(number) => number.into_py_any(py),
            Cell::Whole(number) => number.into_py_any(py),
            Cell::Truth(truth) => truth.into_py_any(py),
        };
        columns.set_item(name, table.rows.iter().map(cell).collect::<PyResult<Vec<_>>>()?)?;
    }
    let folders = results.cases.iter().map(|case| case.folder.display().to_string()).collect::<Vec<_>>();
    columns.set_item("folder", folders)?;
    Ok(columns.unbind())
}

/// Says in which file this library is, so that results are known as those of its build.
#[pyfunction]
pub(crate) fn be_library(path: PathBuf) {
    run_files::run_as_library(path);
}
