//! What the replay of a log leaves: the files of its folder, and the text on the terminal.
//!
//! | file | content |
//! |---|---|
//! | `summary.json` | all that was found; equal bytes for equal log, robot's file and version |
//! | `timing.json` | how long the replay took |
//! | `estimate.tum`, `boxes.csv` | the estimates, in seconds since the log's first reading of the wheels |
//! | `truth.tum` | the true poses at the times of estimates, if the robot's file says where they are |
//! | `subject.log` | what a localizer in a process of its own wrote to its standard error, if anything |
//! | `map.png` | the boxes, and the true path, on the map of the rooms |

mod text;

pub use text::text as log_text;

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

use localizer::{Estimate, PoseBox, localizer::Contradiction};
use serde_json::{Value, json};

use super::{
    account::Topic,
    containment::{Compared, Outside, compare, start_outside},
    lenses::LensFound,
    open_log::OpenLog,
    player::Played,
    tightness::{Tightness, tightness},
    truth::TruePath,
};
use crate::{
    artefacts::{
        debug_frames::log_map,
        machine::machine,
        run_files::{self, RecordError, estimates_digest, naming, scene_digest, width_of},
    },
    judge::{Passed, figures::figures, fix_width, honesty, judge_distributions},
    loading::SceneFile,
    scene::Scene,
};

/// Everything that a replay has come to know about a log.
pub(super) struct Told<'a> {
    pub(super) robot: &'a SceneFile,
    pub(super) path: &'a Path,
    pub(super) log: &'a OpenLog<'a>,
    pub(super) played: &'a Played,
    /// The box in which the localizer was told that the robot begins.
    pub(super) start: &'a PoseBox,
    pub(super) wall_s: f64,
}

/// The replay of a log that another program recorded.
#[derive(Clone, Debug)]
pub struct LogReplay {
    /// Name of the log: that of its file or folder, without the ending.
    pub name: String,
    /// The estimates, with times since the log's first reading of the wheels.
    pub estimates: Vec<Estimate>,
    /// The content of `summary.json`.
    pub summary: Value,
    /// What the terminal shows.
    pub text: String,
    /// Whether nothing speaks against what is declared: no true pose was outside of the boxes, no declared bound was exceeded, no readings
    /// contradicted each other, and the limits of `[expect]` were kept.
    pub passed: bool,
    timing: Value,
    scene: Scene,
    truths: Vec<(f64, localizer::Pose)>,
    subject_log: Option<String>,
}

impl LogReplay {
    /// Puts together what a replay has found.
    pub(super) fn of(told: &Told<'_>) -> LogReplay {
        let name = name_of(told.path);
        let truth_keys = told.log.keys.truth.as_ref();
        let compared =
            told.log.truth.as_ref().zip(truth_keys).map(|(truth, keys)| compare(&told.played.estimates, truth, keys));
        let tight = told.log.truth.as_ref().zip(truth_keys).map_or_else(Vec::new, |(truth, keys)| {
            tightness(&told.log.told, &told.log.motion, [&told.log.positions, &told.log.scans], truth, keys)
        });
        let mut summary = summary(told, &name, compared.as_ref(), &tight);
        let mut failed = failures(told, compared.as_ref(), &tight);
        let mut judged = summary.clone();
        if told.played.has_boxes && compared.is_none() {
            // Limits of boxes apply although no truth is known; only those of containment are then not measured.
            judged["containment"] = json!({});
        }
        let Passed { failed: missed, not_applicable, .. } = told.robot.scene.expect.evaluate(&judged);
        failed.extend(missed);
        let passed = Passed { passed: failed.is_empty(), failed: failed.clone(), not_applicable };
        summary["verdict"] = serde_json::to_value(passed).unwrap_or_default();
        let mut text = text::text(&summary);
        if let Some(honesty) = honesty(&figures(&summary)) {
            text.push_str(&format!("{honesty}\n"));
        }
        text::verdict(&mut text, &failed);
        let duration_s = summary["duration_s"].as_f64().unwrap_or_default();
        let timing = json!({
            "wall_s": told.wall_s, "real_time_factor": duration_s / told.wall_s, "machine": machine(),
            "scene_path": told.robot.path, "log_path": told.path, "set": [], "program": run_files::program_digest(),
        });
        LogReplay {
            name,
            estimates: told.played.estimates.clone(),
            summary,
            text,
            passed: failed.is_empty(),
            timing,
            scene: told.log.told.clone(),
            truths: compared.map(|compared| compared.truths).unwrap_or_default(),
            subject_log: told.played.subject_log.clone(),
        }
    }

    /// Writes the files of the replay into the folder of the log's name below `out`, and returns that folder. An existing one is replaced.
    pub fn write(&self, out: &Path) -> Result<PathBuf, RecordError> {
        let target = out.join(&self.name);
        run_files::replace_whole(&target, |partial| {
            let write = |name: &str, content: String| {
                let path = partial.join(name);
                naming("write", &path, fs::write(&path, content))
            };
            run_files::write_estimates(partial, &self.estimates)?;
            if !self.truths.is_empty() {
                write("truth.tum", run_files::poses_tum(&self.truths))?;
            }
            let map = partial.join("map.png");
            let drawn = log_map(&self.scene, &self.estimates, &self.truths);
            naming("write", &map, drawn.save(&map).map_err(io::Error::other))?;
            if let Some(log) = self.subject_log.as_ref().filter(|log| !log.is_empty()) {
                write(run_files::SUBJECT_LOG, log.clone())?;
            }
            write("timing.json", format!("{:#}\n", self.timing))?;
            write("summary.json", format!("{:#}\n", self.summary))
        })?;
        Ok(target)
    }
}

/// Name of a log: that of its file or folder, without the ending.
fn name_of(log: &Path) -> String {
    let name = log.canonicalize().unwrap_or_else(|_| log.to_owned());
    let name = name.file_name().map_or_else(|| "log".to_owned(), |name| name.to_string_lossy().into_owned());
    let endings = [".zstd", ".mcap", ".db3"];
    endings.iter().fold(name, |name, ending| name.strip_suffix(ending).map_or(name.clone(), str::to_owned))
}

/// All that speaks against what is declared.
fn failures(told: &Told<'_>, compared: Option<&Compared>, tight: &[Tightness]) -> Vec<String> {
    let mut failed: Vec<String> = told.played.failure.iter().map(ToString::to_string).collect();
    if let Some(compared) = compared.filter(|compared| told.played.has_boxes && compared.contained < compared.checks) {
        failed.push(format!("outside = {} of {} checks", compared.checks - compared.contained, compared.checks));
    }
    let truth = told.log.truth.as_ref().zip(told.log.keys.truth.as_ref());
    if let Some(Outside { axis, margin, .. }) = truth.and_then(|(truth, keys)| start_outside(told.start, truth, keys)) {
        failed.push(format!("the declared start does not hold the true pose at 0 s: {axis} is {margin:.4} outside"));
    }
    let exceeded = tight.iter().filter(|one| one.exceeded > 0);
    failed.extend(exceeded.map(|one| {
        let [from_s, to_s] = one.span_s;
        format!(
            "{} exceeded in {} of {} spans, most from {from_s:.3} s to {to_s:.3} s",
            one.bound, one.exceeded, one.compared
        )
    }));
    failed.extend(
        told.played.contradictions.iter().map(|found| format!("contradiction at {:.3} s: {found}", found.found_s)),
    );
    for lens in &told.log.lenses {
        failed.extend(lens.departing().map(|(name, stated, declared, within)| {
            format!(
                "{} lens: {name} is {stated:.6} in the log, where {declared:.6} ± {within:.6} is declared",
                lens.camera.device()
            )
        }));
    }
    failed
}

/// The content of `summary.json`, but for the verdict.
fn summary(told: &Told<'_>, name: &str, compared: Option<&Compared>, tight: &[Tightness]) -> Value {
    let played = told.played;
    let hulls: Vec<PoseBox> = played.estimates.iter().map(|estimate| estimate.pose.hull()).collect();
    let mut width = serde_json::to_value(fix_width(&hulls)).unwrap_or_default();
    width["at_fix"] = serde_json::to_value(fix_width(&played.fixes)).unwrap_or_default();
    let methods: BTreeMap<&str, Value> = played
        .methods
        .iter()
        .map(|(method, counts)| {
            let counts = json!({
                "readings": counts.readings, "constraints": counts.constraints, "empty": counts.empty, "claims": counts.claims,
            });
            (*method, counts)
        })
        .collect();
    let recovering = played.estimates.iter().filter(|one| one.status == localizer::Status::Recovering).count();
    let empty = played.estimates.iter().filter(|one| one.pose.is_empty()).count();
    json!({
        "scene": name,
        "seed": 0,
        "subject": played.subject,
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": Value::Null,
        "duration_s": played.estimates.last().map_or(0.0, |last| last.time_s),
        "containment": compared.filter(|_| played.has_boxes).map(Compared::to_json),
        "bounds": tight.iter().map(|one| one.to_json()).collect::<Vec<_>>(),
        "distribution": told.log.truth.as_ref().and_then(|truth| stated_against(played, truth)),
        "error": compared.map(|compared| serde_json::to_value(&compared.error).unwrap_or_default()),
        "width": if played.has_boxes { width } else { Value::Null },
        "methods": methods,
        "metrics": {
            "estimates": played.estimates.len(),
            "recovering_share": recovering as f64 / played.estimates.len().max(1) as f64,
            "empty_estimates": empty,
            "readings_without_effect": played.n_unused,
        },
        "contradictions": played.contradictions.iter().map(contradiction).collect::<Vec<_>>(),
        "width_by_bound": width_of(&played.widths),
        "log": log(told),
        "digest": {
            "scene": scene_digest(&told.robot.scene),
            "readings": played.readings_digest,
            "estimates": estimates_digest(&played.estimates),
        },
    })
}

/// How well the distributions that a localizer stated agree with the true poses; `None` where it stated none, or no true pose is known.
fn stated_against(played: &Played, truth: &TruePath) -> Option<Value> {
    let times_s = played.estimates.iter().map(|estimate| estimate.time_s);
    let steps = played.stated.iter().zip(times_s);
    let known: Vec<_> = steps.filter_map(|(stated, time_s)| Some((stated.as_ref()?, truth.at(time_s)?))).collect();
    judge_distributions(&known).and_then(|judged| serde_json::to_value(judged).ok())
}

fn contradiction(found: &Contradiction) -> Value {
    let readings = found.readings.iter();
    json!({
        "time_s": found.found_s, "bounds": found.bounds, "earlier": found.is_earlier, "factor": found.factor,
        "readings": readings.map(|one| json!({ "device": one.device, "from_s": one.span_s[0], "to_s": one.span_s[1] })).collect::<Vec<_>>(),
    })
}

/// The entry `log` of the summary: what the log itself is like.
fn log(told: &Told<'_>) -> Value {
    let usual_ns = told.log.gathered.topics.values().find_map(|topic| topic.delay_ns).unwrap_or(0);
    let topics: BTreeMap<&String, Value> = told
        .log
        .gathered
        .topics
        .iter()
        .map(|(name, topic)| (name, of_topic(topic, told.log.zero_ns, usual_ns)))
        .collect();
    let since_s = |logged_ns: i64| seconds_since(logged_ns.saturating_sub(usual_ns), told.log.zero_ns);
    let mut damage: Vec<Value> = told
        .log
        .damage
        .iter()
        .map(|one| {
            let after = one.after.as_ref();
            json!({
                "what": one.what,
                "after_topic": after.map(|(topic, _)| topic),
                "after_s": after.map(|(_, logged_ns)| since_s(*logged_ns)),
            })
        })
        .collect();
    damage.extend(told.log.gathered.set_back.as_ref().map(|set_back| {
        json!({ "what": set_back.what(), "after_topic": set_back.topic, "after_s": since_s(set_back.logged_ns) })
    }));
    json!({
        "without_readings": told.log.without_readings(),
        "first_stamp_s": told.log.zero_ns as f64 * 1e-9,
        "topics": topics,
        "damage": damage,
        "jumps_of_wheels_s": told.log.motion.jumps_s,
        "sideways_odometry_m": told.log.motion.aside_m,
        "lenses": told.log.lenses.iter().map(LensFound::to_json).collect::<Vec<_>>(),
    })
}

fn of_topic(topic: &Topic, zero_ns: i64, usual_ns: i64) -> Value {
    let delay_ns = topic.delay_ns.unwrap_or(usual_ns);
    let since_s = |logged_ns: i64| seconds_since(logged_ns.saturating_sub(delay_ns), zero_ns);
    let dropped: BTreeMap<&str, Value> = topic
        .account
        .dropped
        .iter()
        .map(|(reason, dropped)| {
            let [from_s, to_s] = dropped.logged_ns.map(since_s);
            (*reason, json!({ "count": dropped.count, "first_s": from_s, "last_s": to_s, "first": dropped.first }))
        })
        .collect();
    let gaps = topic.gaps_ns.iter().map(|gap| gap.map(|stamp_ns| seconds_since(stamp_ns, zero_ns)));
    json!({
        "type": topic.kind,
        "read_as": topic.role.map(|role| role.name()),
        "messages": topic.n_messages,
        "dropped": topic.account.n_dropped(),
        "first_s": topic.span_ns.map(|span_ns| seconds_since(span_ns[0], zero_ns)),
        "last_s": topic.span_ns.map(|span_ns| seconds_since(span_ns[1], zero_ns)),
        "period_s": topic.period_s,
        "delay_s": topic.delay_ns.map(|delay_ns| delay_ns as f64 * 1e-9),
        "out_of_order": topic.n_out_of_order,
        "gaps_s": gaps.collect::<Vec<_>>(),
        "dropped_by_reason": dropped,
    })
}

fn seconds_since(stamp_ns: i64, zero_ns: i64) -> f64 {
    stamp_ns.saturating_sub(zero_ns) as f64 * 1e-9
}
