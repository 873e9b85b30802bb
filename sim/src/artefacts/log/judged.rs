//! Estimates that any program made from the recording of a run, compared with the run's true poses.

use std::{collections::BTreeMap, fmt::Write, path::Path};

use localizer::Pose;
use serde_json::{Value, json};

use super::{
    LogError,
    containment::{Compared, compare},
    estimate_file::{self, Stated},
    gathered::Stamped,
    messages,
    truth::TruePath,
};
use crate::{
    artefacts::recording::{
        RecordingError,
        reader::{self, Part},
    },
    scene::LoggedTruth,
};

/// What a comparison of estimates with the true poses of a recording found.
#[derive(Clone, Debug)]
pub struct JudgedEstimates {
    /// All that was found, with the units in the names of its entries.
    pub summary: Value,
    /// The same as a text for the terminal.
    pub text: String,
    /// Whether no box missed the truth. Poses without a region promise nothing, and pass.
    pub passed: bool,
}

/// Longest time between two true poses between which the robot is taken to move evenly. A recording has one each 10 ms.
const LONGEST_GAP_S: f64 = 0.05;

/// Compares the estimates of a file with the true poses of a recording. The file has boxes as `boxes.csv` of a run does, or poses in the TUM format; its
/// times are seconds since the begin of the run. Estimates at times of which the recording has no true pose are counted and left out.
///
/// Errors if either file cannot be read, or if no estimate is at a time of the run.
pub fn judge_estimates(recording: &Path, estimates: &Path) -> Result<JudgedEstimates, LogError> {
    let run = Run::read(recording)?;
    let stated = estimate_file::read(estimates)?;
    // Recorded poses are the true ones themselves.
    let exact = LoggedTruth { tolerance_m: 0.0, tolerance_deg: 0.0, ..LoggedTruth::default() };
    let truth = TruePath::of(&run.truths, 0, &exact, LONGEST_GAP_S);
    let compared = compare(&stated.estimates, &truth, &exact);
    if compared.checks == 0 {
        let [from_s, to_s] = truth.span_s().unwrap_or_default();
        let first_s = stated.estimates.first().map_or(0.0, |first| first.time_s);
        let last_s = stated.estimates.last().map_or(0.0, |last| last.time_s);
        let found = format!(
            "its times are from {first_s:.3} s to {last_s:.3} s, expected seconds since the begin of the run, which has true poses from {from_s:.3} s \
             to {to_s:.3} s"
        );
        return Err(LogError::Estimates { path: estimates.to_owned(), found });
    }
    Ok(run.judged(&stated, &compared))
}

/// What a recording tells of its run.
#[derive(Debug, Default)]
struct Run {
    truths: Vec<Stamped<Pose>>,
    /// Times and sentences of the bounds that the run broke.
    broken: Vec<(f64, String)>,
    facts: BTreeMap<String, String>,
}

impl Run {
    fn read(path: &Path) -> Result<Run, LogError> {
        let mut run = Run::default();
        reader::read(path, &mut |part| -> Result<(), LogError> {
            match part {
                Part::Scene(_) => {}
                Part::Message { topic: "/truth", message } => {
                    let pose = messages::odometry(message).and_then(|(header, pose)| Some((header, pose.planar()?)));
                    let Some((header, value)) = pose else { return Err(unlike(path, "/truth")) };
                    let (stamp_ns, number) = (header.stamp_ns, run.truths.len());
                    run.truths.push(Stamped { stamp_ns, logged_ns: stamp_ns, number, value });
                }
                Part::Message { topic: "/log", message } => {
                    let Some((stamp_ns, name, text)) = messages::log(message) else { return Err(unlike(path, "/log")) };
                    if name == "violation" {
                        run.broken.push((stamp_ns as f64 * 1e-9, text));
                    }
                }
                Part::Message { .. } => {}
                Part::Facts(facts) => run.facts = facts.clone(),
            }
            Ok(())
        })?;
        Ok(run)
    }

    fn judged(&self, stated: &Stated, compared: &Compared) -> JudgedEstimates {
        let fact = |name: &str| self.facts.get(name).cloned().unwrap_or_default();
        let n_estimates = stated.estimates.len();
        let broken: Vec<&str> = self.broken.iter().map(|(_, text)| text.as_str()).collect();
        let mut summary = json!({
            "scene": fact("scene"), "seed": fact("seed"), "estimates": n_estimates, "checks": compared.checks,
            "without_truth": n_estimates - compared.checks, "error": compared.error, "broken_bounds": broken,
        });
        let (scene, seed, checks) = (fact("scene"), fact("seed"), compared.checks);
        let mut text = format!("{scene} seed {seed}: {n_estimates} estimates, {checks} of them at times of the run\n");
        // Writing to a `String` cannot fail.
        let error = &compared.error;
        let _ = writeln!(
            text,
            "error{}: RMSE {:.1} mm along x, {:.1} mm along y, {:.3}° of heading; position at most {:.1} mm",
            if stated.has_boxes { " of the middle" } else { "" },
            1e3 * error.x_m.rmse,
            1e3 * error.y_m.rmse,
            error.heading_rad.rmse.to_degrees(),
            1e3 * error.position_m.max
        );
        if stated.has_boxes {
            summary["containment"] = compared.to_json();
            let widths = mean_widths(stated);
            summary["mean_width"] = json!({ "x_m": widths[0], "y_m": widths[1], "heading_rad": widths[2] });
            let [x_m, y_m, rad] = widths;
            let (x_mm, y_mm, deg) = (1e3 * x_m, 1e3 * y_m, rad.to_degrees());
            let _ = writeln!(text, "boxes: {x_mm:.1} mm × {y_mm:.1} mm × {deg:.2}° wide on average");
            let _ = writeln!(text, "truth: inside the boxes in {} of {checks} checks", compared.contained);
            if let Some(first) = compared.first_outside {
                let (time_s, axis, margin) = (first.time_s, first.axis, first.margin);
                let _ = writeln!(text, "  first outside at {time_s:.3} s, along {axis} by {margin:.4}");
            }
        }
        let heading = if broken.is_empty() {
            "declared bounds that the run broke: none"
        } else {
            "declared bounds that the run broke:"
        };
        let _ = writeln!(text, "{heading}");
        broken.iter().for_each(|broken| text += &format!("  {broken}\n"));
        JudgedEstimates { summary, text, passed: !stated.has_boxes || compared.contained == checks }
    }
}

/// Mean full widths of the boxes around the unions: along x and y in metres, and of heading in radians.
fn mean_widths(stated: &Stated) -> [f64; 3] {
    let n_estimates = stated.estimates.len() as f64;
    [0, 1, 2].map(|axis| {
        stated.estimates.iter().map(|estimate| estimate.pose.hull()[axis].width()).sum::<f64>() / n_estimates
    })
}

fn unlike(path: &Path, topic: &str) -> LogError {
    RecordingError::Message { path: path.to_owned(), topic: topic.to_owned() }.into()
}
