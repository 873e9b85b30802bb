//! Arguments of the commands that make or read many results: sweep, merge, report and compare.

use std::{num::NonZeroUsize, path::PathBuf};

use clap::Args;

use crate::{
    artefacts::result_table::Shown,
    campaign::{
        comparison::{CONFIDENCE, TOLERANCE},
        report::shown_figures,
        sweep::{Seeds, Shard, Variable},
    },
    run::FramesPolicy,
};

use super::tested::Tested;

/// Arguments of `wherein sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_AFTER_HELP)]
pub(super) struct SweepArguments {
    /// A scene file, or a sweep file with the keys `scene`, `seeds`, `subject` and `baselines` and a table `[vary]`.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// A key of the scene and its values: KEY=A,B,C or KEY=LOW..HIGH/N for N values evenly spaced; may be given several times.
    #[arg(long, value_name = "KEY=VALUES")]
    pub(super) vary: Vec<Variable>,
    /// Seeds with which each combination of the keys' values runs, A included and B not.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(super) seeds: Option<Seeds>,
    #[command(flatten)]
    pub(super) tested: Tested,
    /// Run other methods on the same readings too, to compare with: the papers' own and what a careful engineer would use. Their time is not counted
    /// in the speed. Without this option only odometry is run, and what the scene's [expect] names.
    #[arg(long)]
    pub(super) baselines: bool,
    /// Number of runs at the same time. By default the number of processor cores.
    #[arg(long, value_name = "N", value_parser = number_of_jobs)]
    pub(super) jobs: Option<NonZeroUsize>,
    /// Folder for the results. By default sweeps/<scene>.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Images for which the run writes debug frames, pictures of what the vision found: none, failures, every=N or all.
    #[arg(long, value_name = "WHICH", default_value = "none")]
    pub(super) frames: FramesPolicy,
    /// Run only the I-th of N parts, for N machines; `wherein merge` joins the parts afterwards.
    #[arg(long, value_name = "I/N")]
    pub(super) shard: Option<Shard>,
    #[command(flatten)]
    pub(super) outputs: Outputs,
}

/// Arguments of `wherein merge`.
#[derive(Debug, Args)]
pub(super) struct MergeArguments {
    /// Folders that `wherein sweep --shard` wrote.
    #[arg(required = true, value_name = "DIR")]
    pub(super) folders: Vec<PathBuf>,
    /// Folder for the merged sweep.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    #[command(flatten)]
    pub(super) outputs: Outputs,
}

/// Arguments of `wherein report`.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// A folder that `wherein sweep`, `wherein merge` or `wherein run` wrote; the report is written into the same folder. With --out, tables of results:
    /// any number of such folders, of files results.csv, or of files results.parquet where the program was built with Parquet. Folders of one sweep's
    /// parts count each case once, and what no part has is missing; parts of different sweeps are refused.
    #[arg(required = true, value_name = "DIR")]
    pub(super) folders: Vec<PathBuf>,
    /// Write the report into this folder, and make it of tables of results alone, row by row: for more cases than memory or patience suffice for.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) outputs: Outputs,
}

/// Arguments of `wherein compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_AFTER_HELP)]
pub(super) struct CompareArguments {
    /// Results to compare with: a folder of results, or a results.csv kept as a baseline.
    #[arg(value_name = "FIRST")]
    pub(super) first: PathBuf,
    /// Results to judge: a folder of results, or a results.csv.
    #[arg(value_name = "SECOND")]
    pub(super) second: PathBuf,
    /// Probability with which all confidence intervals together hold the true differences.
    #[arg(long, value_name = "P", default_value_t = CONFIDENCE, value_parser = confidence)]
    pub(super) confidence: f64,
    /// Greatest worsening that may stay unseen, in percent of the first side's mean. A figure that may be worse by more, though the difference may be
    /// chance, is `inconclusive`: there are too few seeds.
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0 * TOLERANCE, value_parser = percent, allow_negative_numbers = true)]
    pub(super) tolerance_percent: f64,
    /// End with exit code 1 where a figure is inconclusive.
    #[arg(long)]
    pub(super) fail_if_inconclusive: bool,
}

/// Arguments for further output of the commands that have results.
#[derive(Debug, Args)]
pub(super) struct Outputs {
    /// Write the results as JUnit XML into this file, too.
    #[arg(long, value_name = "FILE")]
    pub(super) junit: Option<PathBuf>,
    /// Figures that the report's tables have of each combination: all, or names with commas between them, such as contained,width,error. Without this
    /// option as many as have room in eight columns.
    #[arg(long, value_name = "NAMES", value_parser = shown_figures)]
    pub(super) columns: Option<Shown>,
}

const COMPARE_AFTER_HELP: &str = "\
Cases are paired by scene, settings and seed. Seeds are the independent witnesses: a figure's differences are averaged over
the cases of each seed, and a paired t interval says whether their mean is zero. All intervals together hold with the
confidence asked for. A side that contained the truth at every step is better than one that did not, whatever the interval.

`least seen` is the least difference that these seeds would tell from chance: with more seeds it shrinks. It is unknown where all seeds
have the same difference.

Exit code: 0 nothing is worse, 1 something is or could not run any more, 2 could not compare.";

/// Reads a number of runs at the same time.
pub(super) fn number_of_jobs(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number of at least 1".to_owned())
}

fn confidence(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|p| (0.5..1.0).contains(p))
        .ok_or_else(|| "expected a number of at least 0.5 and below 1".to_owned())
}

fn percent(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|percent: &f64| *percent >= 0.0 && percent.is_finite())
        .ok_or_else(|| "expected a number from 0".to_owned())
}

const SWEEP_AFTER_HELP: &str = "\
Examples:
  wherein sweep scenes/tiles.toml --vary light.illuminance_at_floor_lux=1,10,100 --seeds 0..10
  wherein sweep scenes/broken/slip.toml --vary floor.region.oil.friction=0.02,0.1,0.4 --vary duration_s=10
  wherein sweep grid.toml --shard 3/16 --out part3        with grid.toml:   scene = \"scenes/tiles.toml\"
                                                                            seeds = \"0..20\"
                                                                            [vary]
                                                                            floor.friction = [0.2, 0.4, 0.8]

Any key of the scene can vary; an item of a list is picked by its name or its index: route.waypoint[2].speed_m_per_s.
DIR holds sweep.json (what was asked), cases/<id>/ (what each run left), results.csv (one row a case), report.html (for
people) and summary.md (for the summary of a CI job).
A sweep that was interrupted goes on where it stopped when the same command is given again.

Exit code: 0 every case met the scene's expectations, 1 some did not, 2 some could not run.";
