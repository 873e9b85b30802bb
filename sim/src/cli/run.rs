//! `wherein run`: runs scenes and seeds one after another, and records each run as soon as it is done.

use std::{collections::BTreeMap, io::Write, path::PathBuf, process::ExitCode};

use clap::Args;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::Value;

use crate::{
    artefacts::{
        debug_frames::Reel,
        recording::{Form, LiveServer, Recording},
        result_table::{Kind, Outcome, Shown, as_text, lines},
        run_files::{self, FILM, Followed, SUBJECT_LOG, program_digest, scene_digest},
    },
    campaign::{
        cases::{CaseResult, Results, program, quoted},
        judged_run::{Progress, run_judged},
        report::{Overview, broken_bounds, first_outside_of},
        sweep,
    },
    judge::honesty,
    loading::SceneFile,
    render::Renderer,
    run::{FramesPolicy, RunOptions},
    subject::SubjectChoice,
};

use super::{
    CommandError, conclude::write_junit, github::tell_github, print, scenes_and_seeds::ScenesAndSeeds, tested::Tested,
};

/// Arguments of `wherein run`.
#[derive(Debug, Args)]
#[command(after_help = RUN_AFTER_HELP)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub(super) which: ScenesAndSeeds,
    #[command(flatten)]
    pub(super) tested: Tested,
    /// Run other methods on the same readings too, to compare with: the papers' own and what a careful engineer would use. Their time is not counted
    /// in the speed. Without this option only odometry is run, and what the scene's [expect] names.
    #[arg(long)]
    baselines: bool,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    pub(super) out: PathBuf,
    /// Images for which the run writes debug frames, pictures of what the vision found: none, failures, every=N or all.
    #[arg(long, value_name = "WHICH", default_value = "none")]
    frames: FramesPolicy,
    /// Write film.png too, an animated PNG of 10 to 20 seconds: what each camera sees, the map with the boxes, and the outcome.
    #[arg(long)]
    film: bool,
    /// Columns of the printed table: all, or names with commas between them, such as run,checks,speed. Without this option those that a reader
    /// needs first, eight at most.
    #[arg(long, value_name = "NAMES", conflicts_with = "json", value_parser = Shown::of_result_table)]
    columns: Option<Shown>,
    /// Print the summaries as a JSON list instead of a table.
    #[arg(long)]
    json: bool,
    /// Write recording.mcap too: images, readings, poses, boxes and log messages, for Foxglove, Rerun and `wherein replay`.
    #[arg(long)]
    record: bool,
    /// Write the recording as rosbag2/, a bag that ROS 2 and `evo` open; boxes are stored as ROS 2 markers.
    #[arg(long)]
    ros2: bool,
    /// Serve the run in real time to viewers such as Foxglove; the first run begins when a viewer has connected.
    #[cfg(feature = "live")]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    live: Option<std::net::SocketAddr>,
    /// Write the results as JUnit XML into this file, too.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Skip runs that this build of the program has already recorded for the same scene, to continue an interrupted command. Runs of a command given
    /// by --subject are never skipped, as its program may have changed.
    #[arg(long)]
    resume: bool,
}

const RUN_AFTER_HELP: &str = "\
Each run leaves DIR/<scene>/<seed>/ with summary.json (all figures, and whether the scene's [expect] was met),
timing.json, truth.tum and estimate.tum (poses), boxes.csv (every box), and the frames, the film and the recording
asked for.

In the table, a check is one step of 10 ms. `contained`: the true pose is in a box. If it is not, the cause is named.
`bound broken`: a declared bound was exceeded, and the run simulated again with this bound kept holds the true pose.
`perception`: the vision claimed something that is not there, and the run without these claims holds the true pose.
`unsound`: neither of the two, so that the localizer is at fault.
Errors are root mean squares over the worst third of a run, widths are full widths of the box.";

/// One run, read back from the files of its record.
struct Recorded {
    folder: PathBuf,
    file: SceneFile,
    summary: Value,
    timing: Value,
    outcome: Outcome,
}

/// Runs every scene with every seed that the arguments name, and prints the results. The exit code says whether all expectations were met.
pub(super) fn run_scenes(arguments: &RunArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    let files = arguments.which.load()?;
    // Methods are the interval localizer's: another localizer reads what it likes.
    let methods_matter = matches!(arguments.tested.choice(), SubjectChoice::Intervals);
    for file in files.iter().filter(|_| methods_matter) {
        file.scene.remarks().iter().for_each(|remark| eprintln!("wherein: {}: {remark}", file.path.display()));
    }
    run_files::prepare(&arguments.out)?;
    arguments.junit.as_deref().map_or(Ok(()), run_files::prepare_for)?;
    // Opening a graphics adapter takes a moment, and a scene without a camera needs none.
    let mut renderer = None;
    if files.iter().any(|file| file.scene.has_camera()) {
        renderer = Some(Renderer::on_adapter(adapter)?);
    }
    #[cfg(feature = "live")]
    let live = arguments.live.map(awaited).transpose()?;
    #[cfg(not(feature = "live"))]
    let live: Option<LiveServer> = None;
    let seeds = arguments.which.seeds();
    let bar =
        progress_bar(files.iter().map(|file| file.scene.simulated_s()).sum::<f64>() * seeds.clone().count() as f64);
    let mut recorded = Vec::new();
    for file in &files {
        for seed in seeds.clone() {
            bar.set_message(format!("{} seed {seed}", file.name));
            let (start, length) = (bar.position(), bar.length().unwrap_or(0));
            let one = match resumed(arguments, file, seed)? {
                Some(earlier) => earlier,
                None => run_one(arguments, file, seed, renderer.as_mut(), live.as_ref(), &bar)?,
            };
            let replayed = bar.length().unwrap_or(length) - length;
            bar.set_position(start + replayed + milliseconds(file.scene.simulated_s()));
            recorded.push(one);
        }
    }
    bar.finish_and_clear();
    announce(arguments, &recorded)?;
    let results = results(&recorded);
    write_junit(&results, arguments.junit.as_ref())?;
    tell_github(&Overview::of(&results), &results)?;
    let all_passed = recorded.iter().all(|one| one.outcome.passed);
    Ok(ExitCode::from(u8::from(!all_passed)))
}

/// Starts a server for live viewers and waits until a viewer has connected.
#[cfg(feature = "live")]
fn awaited(address: std::net::SocketAddr) -> Result<LiveServer, CommandError> {
    let server = LiveServer::start(address)?;
    eprintln!("Waiting for a viewer: open a Foxglove WebSocket connection to ws://{}", server.address());
    server.await_viewer();
    Ok(server)
}

/// Runs one scene with one seed, judges the run, writes its record into the folder for the results, and reads the record back.
fn run_one(
    arguments: &RunArguments,
    file: &SceneFile,
    seed: u64,
    renderer: Option<&mut Renderer>,
    live: Option<&LiveServer>,
    bar: &ProgressBar,
) -> Result<Recorded, CommandError> {
    let mut start = bar.position();
    let renderer = renderer.filter(|_| file.scene.has_camera());
    let options = RunOptions { keep_images: arguments.frames, baselines: arguments.baselines };
    let recording =
        |is_asked: bool, form: Form| is_asked.then(|| Recording::begin(&arguments.out, file, seed, form)).transpose();
    let recordings = (recording(arguments.record, Form::Foxglove)?, recording(arguments.ros2, Form::Ros2)?);
    let reel = arguments.film.then(Reel::default);
    let mut witnesses = ((recordings, reel), live.map(|server| server.begin(&file.scene)));
    let mut progress = |progress| match progress {
        Progress::At { simulated_s } => bar.set_position(start + milliseconds(simulated_s)),
        Progress::Again { number, lasts_s } => {
            bar.set_message(format!("{} seed {seed}: whose fault? replay {number}", file.name));
            start = bar.position();
            bar.inc_length(milliseconds(lasts_s));
        }
        Progress::Ended { lasts_s } => bar.set_position(start + milliseconds(lasts_s)),
    };
    let choice = arguments.tested.choice();
    let (run_record, verdict) =
        run_judged(&file.scene, seed, &choice, &options, renderer, &mut witnesses, &mut progress)?;
    let (((foxglove, ros2), reel), _) = witnesses;
    let followed = Followed { recordings: foxglove.into_iter().chain(ros2).collect(), reel };
    let folder = run_files::write_with(&arguments.out, file, &run_record, &verdict, followed)?;
    read_back(file, folder.clone())?.ok_or(CommandError::NoResults(folder))
}

/// Returns the forms of recordings that the user asks for.
fn forms(arguments: &RunArguments) -> impl Iterator<Item = Form> + use<> {
    let asked = [(arguments.record, Form::Foxglove), (arguments.ros2, Form::Ros2)];
    asked.into_iter().filter_map(|(is_asked, form)| is_asked.then_some(form))
}

/// Returns the run as an earlier process recorded it, if that record is of the same scene and program and has all files that the user asks for.
fn resumed(arguments: &RunArguments, file: &SceneFile, seed: u64) -> Result<Option<Recorded>, CommandError> {
    let folder = run_files::folder(&arguments.out, &file.name, seed);
    if !arguments.resume || arguments.tested.choice().may_have_changed() {
        return Ok(None);
    }
    // An unreadable record is no reason to stop: the run is done again and replaces the record.
    let Ok(Some((summary, timing))) = run_files::read(&folder) else { return Ok(None) };
    let wants_baselines = arguments.baselines || file.scene.expect.needs_baselines();
    if forms(arguments).any(|form| !folder.join(form.path()).exists())
        || arguments.film && !folder.join(FILM).exists()
        || wants_baselines && timing["stages_ms"]["baselines"].is_null()
    {
        return Ok(None);
    }
    let is_same = summary["digest"]["scene"] == scene_digest(&file.scene).as_str()
        && summary["subject"] == arguments.tested.choice().to_string().as_str()
        && program_digest().is_some_and(|program| timing["program"] == program);
    if is_same { read_back(file, folder) } else { Ok(None) }
}

/// Reads the record of a run back from its files. The results table is made from these files, so that it cannot differ from a table that is made from
/// them later.
fn read_back(file: &SceneFile, folder: PathBuf) -> Result<Option<Recorded>, CommandError> {
    let Some((summary, timing)) = run_files::read(&folder)? else { return Ok(None) };
    let outcome = Outcome::of(&summary, &timing);
    Ok(Some(Recorded { folder, file: file.clone(), summary, timing, outcome }))
}

/// Converts the runs into cases, for the output that CI systems read.
fn results(recorded: &[Recorded]) -> Results {
    let case = |one: &Recorded| CaseResult {
        id: String::new(),
        scene: one.outcome.scene.clone(),
        scene_path: one.file.path.clone(),
        settings: one.file.settings.clone(),
        seed: one.outcome.seed,
        subject: one.outcome.subject.clone(),
        subject_is_elsewhere: false,
        folder: one.folder.clone(),
        recorded: sweep::Recorded::Done { summary: one.summary.clone(), timing: one.timing.clone() },
    };
    Results { title: "runs".to_owned(), plan: None, cases: recorded.iter().map(case).collect() }
}

fn announce(arguments: &RunArguments, recorded: &[Recorded]) -> Result<(), CommandError> {
    if arguments.json {
        let summaries: Value = recorded.iter().map(|one| one.summary.clone()).collect();
        print(&format!("{summaries:#}\n"))?;
    } else {
        let outcomes: Vec<Outcome> = recorded.iter().map(|one| one.outcome.clone()).collect();
        print(&as_text(&lines(&outcomes, true), &arguments.columns.clone().unwrap_or_default()))?;
        print(&not_applicable(recorded))?;
        print(&honesty_told(&outcomes))?;
        print(&broken_all_the_same(recorded))?;
        if !arguments.baselines {
            print("\nOdometry is the only other method that was run; --baselines runs the papers' and others.\n")?;
        }
        print(&format!("\nRecorded in {}\n", arguments.out.display()))?;
    }
    let mut stderr = std::io::stderr().lock();
    for one in recorded.iter().filter(|one| !one.outcome.passed) {
        // A closed standard error is no failure of its own: the exit code still shows the result.
        let _ = write!(stderr, "{}", failure(arguments, one));
    }
    Ok(())
}

/// A line for each scene and localizer that states distributions: whether it is overconfident.
fn honesty_told(outcomes: &[Outcome]) -> String {
    let told = lines(outcomes, false).into_iter().filter(|line| line.kind == Kind::Runs);
    let told =
        told.filter_map(|line| Some(format!("\n{}, {}: {}\n", line.scene, line.subject, honesty(&line.figures)?)));
    told.collect()
}

/// A line for each scene of which runs passed in which declared bounds were broken, though no event of the scene explains it: that the boxes held the
/// truth was luck then.
fn broken_all_the_same(recorded: &[Recorded]) -> String {
    let mut scenes: BTreeMap<&str, (usize, BTreeMap<&str, f64>)> = BTreeMap::new();
    for one in recorded.iter().filter(|one| one.outcome.passed && one.file.scene.events.is_empty()) {
        let violations = one.summary["violations"].as_array().map_or(&[][..], Vec::as_slice);
        if violations.is_empty() {
            continue;
        }
        let (n_runs, bounds) = scenes.entry(&one.outcome.scene).or_default();
        *n_runs += 1;
        for violation in violations {
            let value = |key: &str| violation[key].as_f64().unwrap_or(f64::NAN);
            let worst = bounds.entry(violation["bound"].as_str().unwrap_or_default()).or_default();
            *worst = worst.max(value("true") / value("declared"));
        }
    }
    let told = |(scene, (n_runs, bounds)): (&str, (usize, BTreeMap<&str, f64>))| {
        let times = |(bound, ratio): (&&str, &f64)| match ratio.is_finite() {
            true => format!("{bound} {ratio:.2} times"),
            false => format!("{bound}, declared as 0"),
        };
        let bounds: Vec<String> = bounds.iter().map(times).collect();
        let runs = if n_runs == 1 { "run that passed" } else { "runs that passed" };
        format!("\n{scene}: bounds were broken in {n_runs} {runs}, at most by: {}\n", bounds.join(", "))
    };
    scenes.into_iter().map(told).collect()
}

/// A line for each scene with expectations that do not apply to the localizer under test.
fn not_applicable(recorded: &[Recorded]) -> String {
    let named = recorded.iter().filter_map(|one| {
        let names = one.summary["verdict"]["not_applicable"].as_array()?.iter().filter_map(Value::as_str);
        Some((one.outcome.scene.as_str(), names.collect::<Vec<_>>().join(", ")))
    });
    let line =
        |(scene, names)| format!("\n{scene}: not applied, as the localizer states nothing of the kind: {names}\n");
    named.collect::<BTreeMap<_, _>>().into_iter().map(line).collect()
}

/// Describes a failed run: the expectations that it missed, its first failure, and the command that runs it again.
fn failure(arguments: &RunArguments, one: &Recorded) -> String {
    let mut text = format!("\nFAILED {} seed {}\n", one.outcome.scene, one.outcome.seed);
    for line in one.summary["verdict"]["failed"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        text += &format!("  {line}\n");
    }
    let first = &one.summary["containment"]["first_failure"];
    if let Some(told) = first_outside_of(first) {
        text += &format!("  {told}\n");
        if let Some(because) = first["because"].as_str().filter(|because| first["blame"] != **because) {
            text += &format!("  {because}\n");
        }
    }
    for bound in broken_bounds(&one.summary) {
        text += &format!("  {bound}\n");
    }
    let program = program().iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    text += &format!("  recorded in {}\n", one.folder.display());
    let log = one.folder.join(SUBJECT_LOG);
    if one.summary["subject_failure"].is_object() && log.exists() {
        text += &format!("  what the command wrote to its standard error: {}\n", log.display());
    }
    text += &format!(
        "  replay: {} run {}{}{} --seed {} --frames failures --out {}\n",
        program,
        quoted(&one.file.path.display().to_string()),
        arguments.which.set.iter().map(|set| format!(" --set {}", quoted(&set.to_string()))).collect::<String>(),
        arguments.tested.options(),
        one.outcome.seed,
        quoted(&arguments.out.display().to_string()),
    );
    text
}

/// Creates a progress bar over the simulated time of all runs, in milliseconds. The bar stays hidden when standard error is no terminal.
fn progress_bar(total_s: f64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(milliseconds(total_s)), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}  {elapsed_precise}, {eta} left");
    // The template of the progress bar is fixed text; should the library refuse it, the default style serves.
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn milliseconds(seconds: f64) -> u64 {
    // A scene lasts some hours at most, so that the conversion to whole milliseconds is exact enough; negative times do not occur.
    (seconds * 1e3).round() as u64
}
