//! `wherein falsify`: a search among random scenes for one in which the program or the localizer fails.

use std::{
    io::Write,
    ops::Range,
    path::PathBuf,
    process::ExitCode,
    time::{Duration, Instant},
};

use clap::{Args, builder::PossibleValue};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;

use crate::{
    artefacts::machine::cores,
    campaign::{
        cases::program,
        falsify::{Done, Profile, Progress, Search, Summary, Wish, probe, search},
        sweep::Seeds,
    },
};

use super::{CommandError, print, scenes_and_seeds::one_seed};

/// Arguments of `wherein falsify`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct FalsifyArguments {
    /// Seed of all scenes. This seed and a case's number determine the scene of the case.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = one_seed)]
    seed: u64,
    /// Numbers of the cases, A included and B not. By default 100 cases, or without end when --minutes is given.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    cases: Option<Seeds>,
    /// Begin no more cases after this many minutes.
    #[arg(long, value_name = "N", value_parser = minutes, allow_negative_numbers = true)]
    minutes: Option<f64>,
    /// Draw only scenes without rendered images, which run some ten times faster: wheels, gyroscope, flow sensor, range camera and
    /// satellite navigation.
    #[arg(long)]
    without_cameras: bool,
    /// Draw only scenes with at least one camera that renders images. Without this flag and --without-cameras one scene in ten has such a camera.
    #[arg(long, conflicts_with = "without_cameras")]
    with_cameras: bool,
    /// Kind of failure to search for and to shrink; may be given several times. By default all kinds but perception and
    /// witness_outside.
    #[arg(long, value_name = "WISH")]
    wish: Vec<Wish>,
    /// Number of smaller scenes to try for each failing scene; 0 leaves failing scenes as they were drawn.
    #[arg(long, value_name = "N", default_value_t = 300)]
    tries: usize,
    /// Run every N-th case twice and compare the bytes of both runs; 0 for no case.
    #[arg(long, value_name = "N", default_value_t = 20)]
    twice_every: u64,
    /// Number of runs at the same time. By default the number of processor cores.
    #[arg(long, value_name = "N", value_parser = super::results_arguments::number_of_jobs)]
    jobs: Option<std::num::NonZeroUsize>,
    /// Folder for the journal of the search and the failing scenes.
    #[arg(long, value_name = "DIR", default_value = "renders/falsify")]
    out: PathBuf,
    /// Print the summary of the search as JSON.
    #[arg(long)]
    json: bool,
    /// Run the scene on standard input with this seed and report the run on standard output; the search starts each case's process this way.
    #[arg(long, value_name = "SEED", hide = true)]
    probe: Option<u64>,
}

const AFTER_HELP: &str = "\
Each case is a scene drawn at random from all that the schema of scenes allows, run in a process of its own. A scene that fails
is reduced while it still fails in the same way, and written to DIR/found/ with the command that replays it.
The kinds of failure:
  crash              the process ended early: a panic, an abort, or more than 3 GB of memory
  hang               the run took far more processor time than runs of similar scenes
  unsound            the true pose was outside the box though every bound held and the claims of the vision were true
  witness_outside    a history other than the true one that keeps every bound was outside the box while the status was sound; if this
                     kind is named, only scenes that wherein sharpness can measure are drawn, and three instants are looked at
  sound_but_outside  the true pose was outside for more than a second while the status was sound, and until then no bound that an
                     estimate relied on was exceeded, whatever the judge says
  digest_differs     a second run of the same case gave other bytes
  empty_box          the localizer had no pose left
  wider_than_room    a box with the status sound was wider than the room
  perception         the true pose was outside because more claims of the vision were false than declared

A search that was interrupted continues where it stopped when the same command is given again.

Exit code: 0 no failure was found, 1 a failure was found, 2 the search could not run.";

/// Number of cases in a search for which the user states neither a number of cases nor a time.
const USUAL_CASES: u64 = 100;

fn minutes(text: &str) -> Result<f64, String> {
    let positive = text.parse().ok().filter(|minutes: &f64| *minutes > 0.0 && minutes.is_finite());
    positive.ok_or_else(|| "expected a number above 0".to_owned())
}

impl clap::ValueEnum for Wish {
    fn value_variants<'a>() -> &'a [Self] {
        &Wish::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

/// Runs the search and prints its summary.
pub(super) fn falsify(arguments: &FalsifyArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    if let Some(seed) = arguments.probe {
        probe(seed, adapter, arguments.wish.contains(&Wish::WitnessOutside))?;
        return Ok(ExitCode::SUCCESS);
    }
    let asked = asked(arguments, adapter);
    let began = Instant::now();
    let bar = progress_bar(&asked.cases);
    let (mut failed, mut n_done) = (0, 0);
    let done = search(&asked, &mut |progress| match progress {
        Progress::Resumed(n_earlier) => bar.inc(n_earlier as u64),
        Progress::Done(case) => {
            n_done += 1;
            failed += usize::from(is_failure(&case, &asked.wishes));
            bar.set_message(format!("{failed} found so far"));
            bar.inc(1);
            bar.suspend(|| tell(&case, &asked));
        }
    });
    bar.finish_and_clear();
    let done = done?;
    let took_s = began.elapsed().as_secs_f64();
    say(&format!("{n_done} cases run in {took_s:.1} s, {} recorded earlier", done.len() - n_done));
    let summary = Summary::of(asked.seed, &done, &asked.wishes);
    if arguments.json {
        let shrunk: Vec<&PathBuf> = done.iter().filter_map(|case| case.found.as_ref()).collect();
        print(&format!("{:#}\n", json!({ "summary": summary, "profile": asked.profile.name(), "found": shrunk })))?;
    } else {
        print(&summary.to_string())?;
    }
    Ok(ExitCode::from(u8::from(summary.failed > 0)))
}

fn asked(arguments: &FalsifyArguments, adapter: Option<&str>) -> Search {
    let end = if arguments.minutes.is_some() { u64::from(u32::MAX) } else { USUAL_CASES };
    let usual = Seeds(0..end);
    let Seeds(cases) = arguments.cases.clone().unwrap_or(usual);
    Search {
        seed: arguments.seed,
        cases,
        profile: match (arguments.without_cameras, arguments.with_cameras) {
            (true, _) => Profile::WithoutCameras,
            (false, true) => Profile::WithCameras,
            (false, false) => Profile::Mixed,
        },
        jobs: arguments.jobs.map_or_else(cores, usize::from),
        deadline: arguments.minutes.map(|minutes| Instant::now() + Duration::from_secs_f64(60.0 * minutes)),
        wishes: if arguments.wish.is_empty() { Wish::usual() } else { arguments.wish.clone() },
        tries: arguments.tries,
        twice_every: arguments.twice_every,
        out: arguments.out.clone(),
        adapter: adapter.map(str::to_owned),
    }
}

fn is_failure(case: &Done, wishes: &[Wish]) -> bool {
    case.hits.iter().any(|hit| wishes.contains(&hit.wish))
}

/// Prints at once what failed in a case, and the command that runs its scene again.
fn tell(case: &Done, asked: &Search) {
    for hit in case.hits.iter().filter(|hit| asked.wishes.contains(&hit.wish)) {
        say(&format!("case {}: {}: {} [{}]", case.case, hit.wish.name(), hit.seen, hit.signature));
    }
    if let Some(found) = &case.found {
        say(&format!("  replay: {} run {} --seed {}", program().join(" "), found.display(), case.run_seed));
    }
}

/// Creates a progress bar over the cases of a search. The bar stays hidden when standard error is no terminal.
fn progress_bar(cases: &Range<u64>) -> ProgressBar {
    let length = cases.end - cases.start;
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr());
    let is_endless = length > u64::from(u32::MAX) / 2;
    let template = if is_endless {
        "{pos} cases, {per_sec}, {elapsed}, {msg}"
    } else {
        "{bar:32} {pos}/{len} cases, {per_sec}, {eta} left, {msg}"
    };
    // The template of the progress bar is fixed text; should the library refuse it, the default style serves.
    let bar = bar.with_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message("nothing found so far");
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// Writes a message for people to standard error, apart from the results. A closed standard error is no failure: the results are still printed.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
