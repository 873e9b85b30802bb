//! The child process that a search starts for one run: it reads a scene, runs it, and reports on standard output, line by line, what happens.

use std::{
    io::{self, BufRead, Read, Write},
    process, thread,
};

use localizer::reading::Camera;
use serde::{Deserialize, Serialize};

use crate::{
    artefacts::run_files::Summary,
    campaign::sharpness::{ReadingLog, Sharpness, SharpnessError, measure, refuse_unsupported},
    judge::judge,
    loading::SceneFile,
    render::Renderer,
    run::{RunOptions, run_otherwise, run_witnessed},
    scene::{Scene, SceneError, SharedKeys},
    subject::IntervalLocalizer,
};

use super::wish::{Hit, hits, witness_outside};

/// Number of instants at which witnesses are searched for.
const N_INSTANTS: usize = 3;
/// The search for witnesses may take as much processor time as a simulation of this length without cameras.
const WITNESSES_S: f64 = 600.0;

/// One line that the child process of a run reports to the search, as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Told {
    /// The scene is not valid, or no witness of it could be checked where witnesses are searched for. The text is the path of the first key that is
    /// refused, without the indices of list items.
    Refused(String),
    /// A simulation begins: the run of a valid scene, or a repetition of the run to find out the cause of a failure. The report tells how much has to
    /// be simulated in all.
    Began {
        /// Simulated time of the run and of all its repetitions so far, in seconds.
        simulated_s: f64,
        /// Number of pixels that all cameras take in a second of simulated time.
        pixels_per_s: f64,
    },
    /// Simulated time that the run has reached.
    At(f64),
    /// The run could not be made, as there is no graphics adapter or it failed. The text is the reason.
    CouldNotRun(String),
    /// The run has ended.
    Ran(Outcome),
}

/// What the search for witnesses of a run found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Witnesses {
    /// None were searched for: the search does not ask for [`super::Wish::WitnessOutside`].
    NotSought,
    /// There is none. The text names the bound that the truth, or the last candidate, breaks.
    None(String),
    /// There is one at some instant.
    Found,
}

impl Witnesses {
    fn of(sharpness: &Sharpness) -> Witnesses {
        if sharpness.instants.iter().any(|instant| (0..3).any(|axis| instant.spanned(axis) > 0.0)) {
            return Witnesses::Found;
        }
        let broken = sharpness.instants.iter().rev().find_map(|instant| instant.broken.clone());
        Witnesses::None(broken.unwrap_or_default())
    }
}

/// Results of a run that reached its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Number of steps of the run whose estimates were checked against the truth.
    pub steps: usize,
    /// Simulated time of the run in seconds.
    pub simulated_s: f64,
    /// Whether images were rendered in the run.
    pub has_cameras: bool,
    /// What the search for witnesses found.
    pub witnesses: Witnesses,
    /// Names of the declared bounds that were exceeded in the run.
    pub broken: Vec<String>,
    /// Failures that the run showed.
    pub hits: Vec<Hit>,
    /// Digests of the true poses, the readings and the estimates, by which two runs are compared.
    pub digest: String,
}

/// Reads a scene from standard input, after a line that states the number of its bytes; runs the scene with `seed`, and reports on standard output.
/// The process ends when standard input is closed, because the search that waited for it has ended. With `seeks_witnesses` a
/// scene of which none can be checked is refused.
pub fn probe(seed: u64, adapter: Option<&str>, seeks_witnesses: bool) -> io::Result<()> {
    let mut input = io::stdin().lock();
    let mut line = String::new();
    input.read_line(&mut line)?;
    let length = line.trim().parse().map_err(io::Error::other)?;
    let mut text = vec![0; length];
    input.read_exact(&mut text)?;
    drop(input);
    thread::spawn(|| {
        // The search sends nothing more on standard input, so that this reading returns only when the search closes the pipe or ends.
        let _ = io::stdin().lock().read(&mut [0]);
        process::exit(2);
    });
    let text = String::from_utf8(text).map_err(io::Error::other)?;
    tell(&run_told(text, seed, adapter, seeks_witnesses))
}

fn run_told(text: String, seed: u64, adapter: Option<&str>, seeks_witnesses: bool) -> Told {
    let scene = match Scene::parse(&text, "drawn.toml") {
        Ok(scene) => scene,
        Err(error) => return Told::Refused(reason(&error)),
    };
    if seeks_witnesses && let Err(SharpnessError::Unsupported { key, .. }) = refuse_unsupported(&scene, "drawn") {
        return Told::Refused(key.to_owned());
    }
    let pixels_per_s = pixels_per_s(&scene);
    // An error of writing to the search is ignored: a search that has stopped reading has ended, and this process ends with it.
    let _ = tell(&Told::Began { simulated_s: scene.simulated_s(), pixels_per_s });
    let mut renderer = match scene.has_camera().then(|| Renderer::on_adapter(adapter)).transpose() {
        Ok(renderer) => renderer,
        Err(error) => return Told::CouldNotRun(error.to_string()),
    };
    let has_cameras = renderer.is_some();
    let mut progress = |simulated_s: f64| drop(tell(&Told::At(simulated_s)));
    let mut subject = IntervalLocalizer::of(&scene);
    let (options, mut log) = (RunOptions::default(), ReadingLog::default());
    let ran = run_witnessed(&scene, seed, &mut subject, renderer.as_mut(), &options, &mut log, &mut progress);
    let record = match ran {
        Ok(record) => record,
        Err(error) => return Told::CouldNotRun(error.to_string()),
    };
    let mut all_s = scene.simulated_s();
    let verdict = judge(&scene, &record, &mut |asked| {
        // To find the cause of a failure the run is repeated under changed conditions, several times over. Each repetition is reported, so that the
        // search allows more time.
        all_s += asked.until_s.unwrap_or(scene.simulated_s());
        let _ = tell(&Told::Began { simulated_s: all_s, pixels_per_s });
        run_otherwise(&scene, &record, asked, &IntervalLocalizer::boxed, renderer.as_mut(), &mut |_| {})
    });
    let verdict = match verdict {
        Ok(verdict) => verdict,
        Err(error) => return Told::CouldNotRun(error.to_string()),
    };
    let mut broken: Vec<String> = verdict.violations.iter().map(|broken| broken.bound.clone()).collect();
    broken.sort();
    broken.dedup();
    let mut hits = hits(&scene, &record, &verdict);
    let mut witnesses = Witnesses::NotSought;
    if seeks_witnesses {
        let _ = tell(&Told::Began { simulated_s: all_s + WITNESSES_S, pixels_per_s });
        witnesses = match measure(&scene, "drawn", &record, &log, N_INSTANTS, &mut |_| {}) {
            Ok(sharpness) => {
                hits.extend(witness_outside(&scene, &record, &sharpness));
                Witnesses::of(&sharpness)
            }
            Err(error) => return Told::CouldNotRun(error.to_string()),
        };
    }
    let file = SceneFile { name: "drawn".to_owned(), path: "drawn.toml".into(), scene, text, settings: Vec::new() };
    let summary = Summary::of(&file, &record, &verdict);
    let digest = format!("{} {} {}", summary.digest.truth, summary.digest.readings, summary.digest.estimates);
    Told::Ran(Outcome {
        steps: record.truths.len(),
        simulated_s: summary.duration_s,
        has_cameras,
        witnesses,
        broken,
        hits,
        digest,
    })
}

/// Returns the first key for which a scene was refused, without indices of lists.
fn reason(error: &SceneError) -> String {
    match error {
        SceneError::Invalid { problems, .. } => problems.0.first().map_or_else(String::new, |problem| {
            let is_digit = |c: char| c.is_ascii_digit();
            problem.key.replace(is_digit, "").replace("[]", "")
        }),
        other => other.to_string(),
    }
}

fn pixels_per_s(scene: &Scene) -> f64 {
    let of = |name: Camera| {
        let SharedKeys { size_px: [width, height], period_s, .. } = scene.robot.camera(name)?.shared();
        Some(f64::from(width) * f64::from(height) / period_s)
    };
    Camera::ALL.into_iter().filter_map(of).sum()
}

fn tell(told: &Told) -> io::Result<()> {
    let mut output = io::stdout().lock();
    serde_json::to_writer(&mut output, told)?;
    output.write_all(b"\n")?;
    output.flush()
}
