//! The files `summary.json` and `timing.json` of a run.

use std::{collections::BTreeMap, path::PathBuf};

use localizer::localizer::PoseWidth;
use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    artefacts::machine::machine,
    judge::Verdict,
    loading::{SceneFile, Setting},
    run::{self, RunRecord},
    subject::SubjectChoice,
};

use super::{
    digest::{estimates_digest, program_digest, scene_digest, truth_digest},
    occurrences::{Occurrence, occurrences},
    seen_again::MapSeen,
};

/// Everything that `summary.json` holds, in the file's order. It is equal for equal scene, seed, program version and graphics adapter.
#[derive(Clone, Debug, Serialize)]
pub struct Summary<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// Seed of the run.
    pub seed: u64,
    /// Name of the localizer under test.
    pub subject: &'a str,
    /// Version of Wherein.
    pub version: &'static str,
    /// Graphics adapter that rendered the images, if any were rendered.
    pub adapter: Option<&'a str>,
    /// Simulated duration of the run.
    pub duration_s: f64,
    /// The judge's verdict on the run.
    #[serde(flatten)]
    pub verdict: &'a Verdict,
    /// The scene's events that came about before the end of the run.
    pub events: Vec<Occurrence>,
    /// The contradictions between readings that the localizer found, with the bounds of which not all can be true.
    pub contradictions: Vec<Contradiction<'a>>,
    /// What makes the width of the boxes: the mean over the localizer's key frames, for each declared bound. Empty without key frames.
    pub width_by_bound: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    /// What the drive tells of the landmarks of its map; left out where none was looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_seen: Option<MapSeen>,
    /// Digests that identify the run.
    pub digest: Digests,
}

/// SHA-256 of a run's scene, truth, readings and estimates.
#[derive(Clone, Debug, Serialize)]
pub struct Digests {
    /// Digest of all that the scene states.
    pub scene: String,
    /// Digest of the truth at every step.
    pub truth: String,
    /// Digest of all readings in order of arrival.
    pub readings: String,
    /// Digest of the estimate at every step.
    pub estimates: String,
}

impl<'a> Summary<'a> {
    /// The summary of a run.
    pub fn of(file: &'a SceneFile, record: &'a RunRecord, verdict: &'a Verdict) -> Summary<'a> {
        Summary {
            scene: &file.name,
            seed: record.seed,
            subject: &record.subject,
            version: env!("CARGO_PKG_VERSION"),
            adapter: record.adapter.as_deref(),
            duration_s: duration_s(record),
            verdict,
            events: occurrences(&file.scene, record),
            contradictions: record.contradictions.iter().map(Contradiction::of).collect(),
            width_by_bound: width_by_bound(record),
            map_seen: MapSeen::of(&file.scene, record),
            digest: Digests {
                scene: scene_digest(&file.scene),
                truth: truth_digest(&record.truths),
                readings: record.readings_digest.clone(),
                estimates: estimates_digest(&record.estimates),
            },
        }
    }

    /// Text of the file `summary.json`.
    pub(super) fn to_text(&self) -> String {
        // The keys of a summary are texts, so that serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// A contradiction between readings, as the localizer told it without knowing the truth.
#[derive(Clone, Debug, Serialize)]
pub struct Contradiction<'a> {
    /// Time at which it was found.
    pub time_s: f64,
    /// The bounds of which not all can be true, the most doubtful first.
    pub bounds: &'a [&'static str],
    /// Whether what was known before the readings can be false instead.
    pub earlier: bool,
    /// How many times its declared value another bound would have to be if these were kept; `None` where that is not known.
    pub factor: Option<f64>,
    /// The readings that contradict each other.
    pub readings: Vec<Readings>,
}

/// Readings of one device in a span of time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Readings {
    pub device: &'static str,
    pub from_s: f64,
    pub to_s: f64,
}

impl<'a> Contradiction<'a> {
    fn of(found: &'a localizer::localizer::Contradiction) -> Contradiction<'a> {
        let readings = found.readings.iter();
        let readings = readings.map(|one| Readings { device: one.device, from_s: one.span_s[0], to_s: one.span_s[1] });
        Contradiction {
            time_s: found.found_s,
            bounds: &found.bounds,
            earlier: found.is_earlier,
            factor: found.factor,
            readings: readings.collect(),
        }
    }
}

/// What makes the width along each axis, on average over the key frames of a run: the part of each declared bound, that of the boxes of poses and
/// landmarks (`boxes`), and that of what has no name (`rest`), less what is `saved` because least and greatest value follow from different readings.
pub fn width_by_bound(record: &RunRecord) -> BTreeMap<&'static str, BTreeMap<&'static str, f64>> {
    width_of(&record.widths)
}

/// What makes the width along each axis, as [`width_by_bound`] tells it, for the widths at key frames.
pub(crate) fn width_of(widths: &[PoseWidth]) -> BTreeMap<&'static str, BTreeMap<&'static str, f64>> {
    let mut axes = BTreeMap::new();
    for width in widths {
        for (axis, parts) in [("x_m", &width.x_m), ("y_m", &width.y_m), ("heading_rad", &width.heading_rad)] {
            let of_axis: &mut BTreeMap<_, f64> = axes.entry(axis).or_default();
            let others = [("boxes", parts.by_boxes), ("rest", parts.rest), ("saved", -parts.saved)];
            for (name, part) in parts.by_bound.iter().map(|(&bound, &part)| (bound, part)).chain(others) {
                *of_axis.entry(name).or_default() += part / widths.len() as f64;
            }
        }
    }
    axes
}

/// Name of the localizer that a summary is about. A summary without a name was written when there was only one.
pub fn subject_of(summary: &Value) -> String {
    summary["subject"].as_str().map_or_else(|| SubjectChoice::default().to_string(), str::to_owned)
}

/// Everything that `timing.json` holds.
#[derive(Clone, Debug)]
pub struct Timing {
    duration_s: f64,
    images: usize,
    readings: usize,
    spent: run::Timing,
    /// Mean time in microseconds that each baseline solver (another localization method on the same readings) takes for one problem, by the solver's
    /// name.
    solve_us: BTreeMap<&'static str, f64>,
    scene_path: PathBuf,
    settings: Vec<Setting>,
    subject_is_elsewhere: bool,
    map_reading_s: Option<f64>,
}

impl Timing {
    /// The timing of a run.
    pub fn of(file: &SceneFile, record: &RunRecord) -> Timing {
        let solvers = record.range_baselines.solvers.iter();
        let mut solve_us: BTreeMap<&str, f64> =
            solvers.map(|(name, answers)| (*name, 1e6 * answers.spent_s / answers.problems as f64)).collect();
        solve_us.extend(record.marker_baselines.solve_us());
        Timing {
            duration_s: duration_s(record),
            images: record.images.len(),
            readings: record.n_readings,
            spent: record.timing,
            solve_us,
            scene_path: file.path.clone(),
            settings: file.settings.clone(),
            subject_is_elsewhere: record.subject_is_elsewhere,
            map_reading_s: file.scene.localizer.mapped_landmarks.as_ref().and_then(|setup| setup.reading_s),
        }
    }

    /// Content of the file `timing.json`. Its `program` is the digest of the executable, by which `--resume` recognises results of its own build; its
    /// `scene_path` and `set` (changed keys of the scene) are what a command that repeats the run has to name. No command repeats the run where
    /// `subject_is_elsewhere`: the localizer under test lives in another program, which had begun the run. The time of the `baselines` is no part of
    /// `wall_s`; it is null where they were not asked for. `map_reading_ms` is the time in which a map of landmarks was read and checked once; it is
    /// null where the scene names none.
    pub fn to_json(&self) -> Value {
        let spent = &self.spent;
        let per_image_ms = |stage_s: f64| (self.images > 0).then(|| 1e3 * stage_s / self.images as f64);
        json!({
            "wall_s": spent.wall_s,
            "real_time_factor": self.duration_s / spent.wall_s,
            "stages_ms": {
                "world": 1e3 * spent.world_s,
                "render": 1e3 * spent.render_s,
                "localizer": 1e3 * spent.localizer_s,
                "vision": 1e3 * spent.vision_s,
                "baselines": spent.baselines_s.map(|spent_s| 1e3 * spent_s),
            },
            "per_image_ms": {
                "render": per_image_ms(spent.render_s),
                "vision": per_image_ms(spent.vision_s),
            },
            "per_reading_ms": {
                "mean": 1e3 * (spent.localizer_s + spent.vision_s) / self.readings as f64,
                "max": 1e3 * spent.slowest_reading_s,
            },
            "map_reading_ms": self.map_reading_s.map(|reading_s| 1e3 * reading_s),
            "solve_us": self.solve_us,
            "program": program_digest(),
            "machine": machine(),
            "scene_path": self.scene_path,
            "set": self.settings.iter().map(Setting::to_string).collect::<Vec<_>>(),
            "subject_is_elsewhere": self.subject_is_elsewhere,
        })
    }
}

fn duration_s(record: &RunRecord) -> f64 {
    record.truths.last().map_or(0.0, |truth| truth.time_s)
}
