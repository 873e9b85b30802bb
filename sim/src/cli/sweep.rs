//! `wherein sweep` and `wherein merge`: many runs of one scene, and the results of all of them.

use std::{
    io::Write,
    process::ExitCode,
    sync::atomic::AtomicBool,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::{
    artefacts::{machine::cores, run_files},
    campaign::sweep::{Begun, Case, Finished, Seeds, Shard, Store, Sweep, SweepError, Work, merge, run_cases},
    loading::SceneTemplate,
    run::RunOptions,
    subject::SubjectChoice,
};

use super::{CommandError, MergeArguments, SweepArguments, conclude::conclude_sweep};

/// Runs every case of a sweep that is not recorded yet, and writes the results of all cases.
pub(super) fn sweep(arguments: &SweepArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    let sweep = asked(arguments)?;
    arguments.outputs.junit.as_deref().map_or(Ok(()), run_files::prepare_for)?;
    let mut begun = Begun::of(&sweep, arguments.out.as_deref(), adapter)?;
    if matches!(sweep.subject, SubjectChoice::Intervals) {
        let path = sweep.scene.display();
        let remarks = SceneTemplate::load(&sweep.scene)?.file().scene.remarks();
        remarks.iter().for_each(|remark| eprintln!("wherein: {path}: {remark}"));
    }
    let renderer = begun.renderer.take();
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let (todo, n_meant) = begun.todo(shard, arguments.frames);
    let jobs = arguments.jobs.map_or_else(cores, usize::from);
    let began = Instant::now();
    run_all(Work {
        cases: &todo,
        subject: &sweep.subject,
        jobs,
        options: RunOptions { keep_images: arguments.frames, baselines: sweep.baselines },
        renderer,
        store: &begun.store,
        stop: &AtomicBool::new(false),
    })?;
    say(&Ran { todo: &todo, n_meant, took: began.elapsed() }.to_string());
    conclude_sweep(&begun.out, begun.plan, &|index| shard.holds(index), &arguments.outputs)
}

/// Merges the parts of a sweep and writes the results of the whole.
pub(super) fn merge_folders(arguments: &MergeArguments) -> Result<ExitCode, CommandError> {
    arguments.outputs.junit.as_deref().map_or(Ok(()), run_files::prepare_for)?;
    let store = Store::open(&arguments.out)?;
    let plan = merge(&arguments.folders, &store)?;
    conclude_sweep(&arguments.out, plan, &|_| true, &arguments.outputs)
}

/// Returns the sweep that a sweep file and the command line state together.
fn asked(arguments: &SweepArguments) -> Result<Sweep, SweepError> {
    let from_file = Sweep::load(&arguments.scene)?;
    let mut sweep = from_file.unwrap_or_else(|| Sweep {
        scene: arguments.scene.clone(),
        vary: Vec::new(),
        seeds: 0..1,
        subject: SubjectChoice::default(),
        baselines: false,
    });
    sweep.vary.extend(arguments.vary.iter().cloned());
    sweep.subject = arguments.tested.choice_or(&sweep.subject);
    sweep.baselines |= arguments.baselines;
    if let Some(Seeds(seeds)) = &arguments.seeds {
        sweep.seeds = seeds.clone();
    }
    Ok(sweep)
}

fn run_all(work: Work<'_>) -> Result<(), SweepError> {
    let bar = progress_bar(work.cases.len());
    let (mut missed, mut failed) = (0, 0);
    let outcome = run_cases(work, &mut |finished| {
        match finished {
            Finished::Passed => {}
            Finished::Missed => missed += 1,
            Finished::Failed => failed += 1,
        }
        bar.set_message(tally(missed, failed));
        bar.inc(1);
    });
    bar.finish_and_clear();
    outcome
}

fn tally(missed: usize, failed: usize) -> String {
    match (missed, failed) {
        (0, 0) => "all passed so far".to_owned(),
        (_, 0) => format!("{missed} FAILED so far"),
        _ => format!("{missed} FAILED and {failed} could not run so far"),
    }
}

/// Creates a progress bar over the cases of a sweep. The bar stays hidden when standard error is no terminal.
fn progress_bar(cases: usize) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(cases as u64), ProgressDrawTarget::stderr());
    let template = "{bar:32} {pos}/{len} cases, {per_sec}, {eta} left, {msg}";
    // The template of the progress bar is fixed text; should the library refuse it, the default style serves.
    let bar = bar.with_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(tally(0, 0));
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// The number of cases of a sweep that ran, and the time that they took, to be printed as one sentence.
struct Ran<'a> {
    todo: &'a [&'a Case],
    n_meant: usize,
    took: Duration,
}

impl std::fmt::Display for Ran<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let simulated_s: f64 = self.todo.iter().map(|case| case.file.scene.simulated_s()).sum();
        let took_s = self.took.as_secs_f64();
        let (ran, recorded) = (self.todo.len(), self.n_meant - self.todo.len());
        write!(f, "{} run in {took_s:.1} s", plural(ran, "case"))?;
        if ran > 0 {
            write!(f, " ({:.1} cases/min, {:.1} × real time)", 60.0 * ran as f64 / took_s, simulated_s / took_s)?;
        }
        if recorded > 0 {
            write!(f, ", {recorded} recorded earlier")?;
        }
        Ok(())
    }
}

fn plural(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// Writes a message for people to standard error, apart from the results. A closed standard error is no failure: the results are still printed.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
