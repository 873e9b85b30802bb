//! `wherein sharpness`: compares the boxes of a run with what its readings and bounds leave open.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::Args;
use indicatif::ProgressBar;
use serde_json::{Value, json};

use crate::{
    artefacts::run_files,
    campaign::sharpness::{AXES, Dominant, N_INSTANTS, ReadingLog, Sharpness, measure, refuse_unsupported},
    loading::{SceneFile, SceneTemplate, Setting},
    render::Renderer,
    run::{RunOptions, run_witnessed},
    subject::IntervalLocalizer,
};

use super::{CommandError, print, scenes_and_seeds::one_seed};

/// Arguments of `wherein sharpness`.
#[derive(Debug, Args)]
#[command(after_help = SHARPNESS_AFTER_HELP)]
pub(super) struct SharpnessArguments {
    /// Folder that `wherein run` left for one scene and seed, or a scene file.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Seed of everything that is drawn at random in the run; for a scene file only, as a folder has its own.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = one_seed)]
    seed: Option<u64>,
    /// Set a key of the scene, such as robot.errors=corner; may be given several times, for a scene file only.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
    /// Print a JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

const SHARPNESS_AFTER_HELP: &str = "\
The run is simulated again. At 20 instants, evenly over its first 200 s at most, the command searches for witnesses: histories of
robot, landmarks and sensor errors other than the truth that keep every declared bound on the same readings. A guaranteed box has
to contain them all. The table shows the width of the box, the distance of the outermost witnesses, and their ratio: 1 for a box
that cannot be narrower. The search is not complete, so that a ratio is an upper bound of the true one. Last comes the declared bound
that makes most of the width at the latest key frame, with its part of the width that the graph gives there: what to calibrate next.
Where the boxes of older poses and of landmarks make more than that, their part is told before it.
Exit code: 0 all witnesses found are in the box, 1 a witness is outside of it, 2 the sharpness could not be measured.";

/// Measures the sharpness of one run and prints it.
pub(super) fn sharpness(arguments: &SharpnessArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    let Asked { file, seed, readings } = Asked::of(arguments)?;
    refuse_unsupported(&file.scene, &file.name)?;
    let mut renderer = file.scene.has_camera().then(|| Renderer::on_adapter(adapter)).transpose()?;
    let mut log = ReadingLog::default();
    let told = file.scene.told(seed);
    let mut subject = IntervalLocalizer::of(&told);
    let bar = ProgressBar::new((file.scene.simulated_s() * 1e3) as u64);
    let record = run_witnessed(
        &told,
        seed,
        &mut subject,
        renderer.as_mut(),
        &RunOptions::default(),
        &mut log,
        &mut |simulated_s| bar.set_position((simulated_s * 1e3) as u64),
    )?;
    bar.finish_and_clear();
    if let Some(recorded) = readings.filter(|recorded| *recorded != record.readings_digest) {
        let (run, now) = (arguments.run.clone(), record.readings_digest);
        return Err(CommandError::OtherReadings { run, recorded, now });
    }
    let bar = ProgressBar::new(N_INSTANTS as u64);
    let done = &mut |n_done| bar.set_position(n_done as u64);
    let measured = measure(&file.scene, &file.name, &record, &log, N_INSTANTS, done)?;
    bar.finish_and_clear();
    print(&if arguments.json { as_json(&file.name, seed, &measured) } else { as_table(&measured) })?;
    Ok(ExitCode::from(u8::from(n_outside(&measured) > 0)))
}

/// Number of instants at which a witness is outside the box.
fn n_outside(measured: &Sharpness) -> usize {
    measured.instants.iter().filter(|instant| !instant.in_box).count()
}

/// The scene and the seed that the arguments ask for.
struct Asked {
    file: SceneFile,
    seed: u64,
    /// Digest of the recorded run's readings.
    readings: Option<String>,
}

impl Asked {
    fn of(arguments: &SharpnessArguments) -> Result<Asked, CommandError> {
        if !arguments.run.is_dir() {
            let file = SceneTemplate::load(&arguments.run)?.with(&arguments.set)?;
            return Ok(Asked { file, seed: arguments.seed.unwrap_or(0), readings: None });
        }
        let Some((summary, timing)) = run_files::read(&arguments.run)? else {
            return Err(CommandError::NoResults(arguments.run.clone()));
        };
        let unknown = |key: &'static str, expected: &'static str| CommandError::UnknownRun {
            run: arguments.run.clone(),
            key,
            expected,
        };
        if arguments.seed.is_some() || !arguments.set.is_empty() {
            return Err(unknown("--seed or --set", "a scene file, as the folder of a run has its own seed and keys"));
        }
        let seed = summary["seed"].as_u64().ok_or_else(|| unknown("seed", "a whole number in summary.json"))?;
        let path = timing["scene_path"].as_str().ok_or_else(|| unknown("scene_path", "a path in timing.json"))?;
        let settings = timing["set"].as_array().into_iter().flatten();
        let settings: Option<Vec<Setting>> = settings.map(|set| set.as_str()?.parse().ok()).collect();
        let settings = settings.ok_or_else(|| unknown("set", "texts KEY=VALUE in timing.json"))?;
        let file = SceneTemplate::load(Path::new(path))?.with(&settings)?;
        let readings = summary["digest"]["readings"].as_str();
        let readings = readings.ok_or_else(|| unknown("digest.readings", "a digest in summary.json"))?;
        Ok(Asked { file, seed, readings: Some(readings.to_owned()) })
    }
}

fn as_json(scene: &str, seed: u64, measured: &Sharpness) -> String {
    let by_axis = |of: &dyn Fn(usize) -> Value| -> Value {
        AXES.iter()
            .enumerate()
            .map(|(axis, name)| ((*name).to_owned(), of(axis)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let instants = measured.instants.iter().map(|instant| {
        json!({
            "time_s": instant.time_s,
            "width": by_axis(&|axis| instant.width[axis].into()),
            "spanned": by_axis(&|axis| instant.spanned(axis).into()),
            "ratio": by_axis(&|axis| instant.ratio(axis).into()),
            "power": by_axis(&|axis| instant.power[axis].into()),
            "in_box": instant.in_box,
            "broken": instant.broken,
            "dominant": by_axis(&|axis| json!(instant.dominant[axis])),
        })
    });
    let found = json!({
        "scene": scene,
        "seed": seed,
        "instants": instants.collect::<Value>(),
        "mean_width": by_axis(&|axis| measured.means(axis).map(|[width, _]| width).into()),
        "mean_spanned": by_axis(&|axis| measured.means(axis).map(|[_, spanned]| spanned).into()),
        "median_ratio": by_axis(&|axis| measured.median(axis).into()),
        "power": by_axis(&|axis| measured.power(axis).into()),
        "instants_with_witnesses": measured.instants.iter().filter(|instant| instant.has_pair()).count(),
    });
    format!("{found:#}\n")
}

fn as_table(measured: &Sharpness) -> String {
    let mut text = " instant  axis         box     witnesses  ratio  makes most of it\n".to_owned();
    for instant in &measured.instants {
        for axis in 0..3 {
            let [width, spanned] = [instant.width[axis], instant.spanned(axis)].map(|value| shown(axis, value));
            let ratio = instant.ratio(axis).map_or("  none".to_owned(), |ratio| format!("{ratio:6.2}"));
            let dominant =
                instant.dominant[axis].as_ref().map_or(String::new(), |dominant| dominant_text(axis, dominant));
            text +=
                &format!("{:6.2} s  {:7}  {width}  {spanned}  {ratio}  {dominant}\n", instant.time_s, axis_name(axis));
        }
        if let Some(broken) = instant.broken.as_ref().filter(|_| !instant.has_pair()) {
            text += &format!("          no witnesses: {broken}\n");
        }
        if !instant.in_box {
            text += "          a witness is outside the box: the box excludes what may be true\n";
        }
    }
    let of_axes = |of: &dyn Fn(usize) -> Option<f64>| -> String {
        let shown = |axis| of(axis).map_or("none".to_owned(), |value| format!("{value:.2}"));
        [0, 1, 2].map(|axis| format!("{} {}", axis_name(axis), shown(axis))).join(", ")
    };
    let n_found = measured.instants.iter().filter(|instant| instant.has_pair()).count();
    let means = (0..3).map(|axis| match measured.means(axis) {
        Some(means) => {
            let [width, spanned] = means.map(|mean| shown(axis, mean));
            format!("mean     {:7}  {width}  {spanned}  {:6.2}\n", axis_name(axis), means[0] / means[1])
        }
        None => format!("mean     {:7}  none\n", axis_name(axis)),
    });
    text.push('\n');
    text.extend(means);
    text += &format!("\nmedian ratio: {}\n", of_axes(&|axis| measured.median(axis)));
    text += &format!(
        "power, the farthest witness from a box's middle over half its width: {}\n",
        of_axes(&|axis| measured.power(axis))
    );
    text += &format!("witnesses along every axis at {n_found} of {} instants\n", measured.instants.len());
    match n_outside(measured) {
        0 => {}
        n => {
            text += &format!("a witness is outside the box at {n} instants: the localizer excludes what may be true\n")
        }
    }
    text
}

/// The dominating bound with its part, and the boxes with theirs where it is greater.
fn dominant_text(axis: usize, Dominant { bound, part, boxes, width }: &Dominant) -> String {
    let [part_text, boxes_text, width_text] = [part, boxes, width].map(|value| shown(axis, *value).trim().to_owned());
    let by_boxes = if boxes > part { format!("boxes {boxes_text}, ") } else { String::new() };
    let by_bound = bound.map(|bound| format!("{bound} {part_text}, ")).unwrap_or_default();
    format!("{by_boxes}{by_bound}of {width_text}")
}

fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "heading"][axis]
}

fn shown(axis: usize, value: f64) -> String {
    if axis == 2 { format!("{:8.3} °", value.to_degrees()) } else { format!("{:7.1} mm", 1e3 * value) }
}
