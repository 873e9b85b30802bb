//! `wherein weaken`: measures how tight the declared bounds of scenes are.

use std::process::ExitCode;

use clap::Args;

use indicatif::ProgressBar;
use serde_json::{Value, json};

use crate::{
    campaign::weaken::{Weakened, weaken},
    judge::SETTLED_S,
    render::Renderer,
    run::{RunOptions, run},
    subject::IntervalLocalizer,
};

use super::{CommandError, print, scenes_and_seeds::ScenesAndSeeds};

/// Arguments of `wherein weaken`.
#[derive(Debug, Args)]
#[command(after_help = WEAKEN_AFTER_HELP)]
pub(super) struct WeakenArguments {
    #[command(flatten)]
    which: ScenesAndSeeds,
    /// Print a JSON list instead of a table.
    #[arg(long)]
    json: bool,
}

const WEAKEN_AFTER_HELP: &str = "\
Each run is simulated again by its own commands and with its own draws, while the localizer is given 0.9, 0.8, … 0.1 of every
bound that the scene declares, until the truth is outside the box, no box is left, or the localizer doubts an assumption. The
table shows 1 / that share: 1.0 for bounds that are used in full, above 3 where boxes a third as wide would pass unnoticed.
The box of start poses is given unchanged.
A loss in the first 5 s of a drive, or in the first half of a drive shorter than 10 s, counts only if it lasts beyond that time:
before, wheels and gyroscope are alone with errors at their corners, and no method has given a constraint.
With robot.errors=corner errors are as large as declared. Exit code: 0 the runs were simulated, 2 they could not be.";

/// Narrows the bounds of every run that the arguments name until the truth is lost, and prints at which share of the bounds that happens. The result
/// is a measurement, which cannot pass or fail, so that the exit code is 0.
pub(super) fn weaken_scenes(arguments: &WeakenArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    let files = arguments.which.load()?;
    let needs_renderer = files.iter().any(|file| file.scene.has_camera());
    let mut renderer = needs_renderer.then(|| Renderer::on_adapter(adapter)).transpose()?;
    let seeds = arguments.which.seeds();
    let bar = ProgressBar::new_spinner();
    let mut rows = Vec::new();
    for file in &files {
        for seed in seeds.clone() {
            let told = file.scene.told(seed);
            let scene = &*told;
            let mut used = renderer.as_mut().filter(|_| scene.has_camera());
            let mut progress = |share: f64, simulated_s: f64| {
                bar.set_message(format!(
                    "{} seed {seed}: told {share:.1} of its bounds, {simulated_s:.0} s",
                    file.name
                ));
                bar.tick();
            };
            let mut subject = IntervalLocalizer::of(scene);
            let mut first = |at_s| progress(1.0, at_s);
            let recorded = run(scene, seed, &mut subject, used.as_deref_mut(), &RunOptions::default(), &mut first)?;
            let weakened = weaken(scene, &recorded, &IntervalLocalizer::boxed, used, &mut progress)?;
            let is_drive = scene.stations.is_empty();
            rows.push(Row { scene: file.name.clone(), seed, is_drive, weakened });
        }
    }
    bar.finish_and_clear();
    print(&if arguments.json { as_json(&rows) } else { as_table(&rows) })?;
    Ok(ExitCode::SUCCESS)
}

/// One run of a scene with one seed, and the share of its declared bounds at which the localizer lost the true pose.
struct Row {
    scene: String,
    seed: u64,
    /// Whether the run is a drive, as opposed to a robot that stands still at stations.
    is_drive: bool,
    weakened: Weakened,
}

fn as_json(rows: &[Row]) -> String {
    let one = |row: &Row| {
        let is_too_short = row.too_short().is_some();
        json!({ "scene": row.scene, "seed": row.seed, "too_short": is_too_short, "weakened": row.weakened })
    };
    format!("{:#}\n", rows.iter().map(one).collect::<Value>())
}

fn as_table(rows: &[Row]) -> String {
    let longest = rows.iter().map(|row| row.scene.len()).max().unwrap_or(0).max("scene".len());
    let mut text = format!("{:longest$}  seed  loses the truth at  1 / that  lost at\n", "scene");
    for row in rows {
        let Row { scene, seed, weakened, .. } = row;
        if let Some(too_short) = row.too_short() {
            text += &format!("{scene:longest$}  {seed:4}  {too_short}\n");
            continue;
        }
        let (factor, tightness) = match (weakened.factor, weakened.tightness) {
            (Some(factor), Some(tightness)) => (format!("{factor:.1} of its bounds"), format!("{tightness:.2}")),
            _ => ("none".to_owned(), "> 10".to_owned()),
        };
        let lost_at = weakened.lost.zip(weakened.lost_at_s);
        let lost_at = lost_at.map_or("never".to_owned(), |(lost, at_s)| format!("{at_s:.2} s, {}", lost.name()));
        text += &format!("{scene:longest$}  {seed:4}  {factor:>18}  {tightness:>8}  {lost_at}\n");
    }
    text
}

impl Row {
    /// Returns a message if the drive was too short for a result: the truth was not lost, and the time in which a loss counts, the second half of the
    /// drive, is shorter than the 5 s that a loss may take to show.
    fn too_short(&self) -> Option<String> {
        let after_s = self.weakened.counted_after_s;
        let is_short = self.is_drive && self.weakened.factor.is_none() && after_s < SETTLED_S;
        let needed_s = 2.0 * SETTLED_S;
        is_short.then(|| {
            format!("too short to tell: losses count after {after_s:.2} s, expected a drive of {needed_s:.0} s or more")
        })
    }
}
