//! The kinds of failure that a search looks for.

use localizer::Status;
use serde::{Deserialize, Serialize};

use crate::{
    campaign::sharpness::Sharpness,
    judge::{Judgement, Verdict, false_claims, misperceived},
    run::RunRecord,
    scene::Scene,
};

/// A kind of failure that a search looks for, in the order from the gravest to the least grave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wish {
    /// The process ended early: by a panic, by an abort, or because it took more memory than any run needs.
    Crash,
    /// The run takes far longer than runs of similar scenes.
    Hang,
    /// The true pose is outside the estimate, and neither a declared bound that was exceeded nor false claims of the vision (wrongly identified
    /// markers, joints, edges and the like) explain it.
    Unsound,
    /// A [witness](crate::campaign::sharpness) is outside the estimate, at an instant at which the localizer reports the status *sound*: another history
    /// than the true one, which keeps every declared bound on the readings that have arrived. The estimate is wrong, however the truth lies.
    WitnessOutside,
    /// The true pose is outside the estimate for more than a second, at every step of which the localizer reports the status *sound* (it doubts no
    /// assumption), and until then no declared bound that an estimate relied on was exceeded and no reading had more false claims than declared.
    SoundButOutside,
    /// A second run of the same scene and seed gives other results, compared byte by byte.
    DigestDiffers,
    /// The localizer's estimate is empty: no pose agrees with all readings and declared bounds.
    EmptyBox,
    /// The localizer reports the status *sound*, and yet the box of its estimate is wider than the space that the walls leave to the robot.
    WiderThanRoom,
    /// The true pose is outside the estimate because the vision made more false claims (wrongly identified markers, joints, edges and the like) than
    /// the declared number.
    Perception,
}

impl Wish {
    /// All kinds of failure, the gravest first.
    pub const ALL: [Wish; 9] = [
        Wish::Crash,
        Wish::Hang,
        Wish::Unsound,
        Wish::WitnessOutside,
        Wish::SoundButOutside,
        Wish::DigestDiffers,
        Wish::EmptyBox,
        Wish::WiderThanRoom,
        Wish::Perception,
    ];

    /// Returns the name of this kind of failure in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Wish::Crash => "crash",
            Wish::Hang => "hang",
            Wish::Unsound => "unsound",
            Wish::WitnessOutside => "witness_outside",
            Wish::SoundButOutside => "sound_but_outside",
            Wish::DigestDiffers => "digest_differs",
            Wish::EmptyBox => "empty_box",
            Wish::WiderThanRoom => "wider_than_room",
            Wish::Perception => "perception",
        }
    }

    /// Returns the kinds that make a search fail by default: all but [`Wish::Perception`], losses of the truth by false claims of the vision, which
    /// are only counted, and [`Wish::WitnessOutside`], as the search for witnesses takes longer than the run.
    pub fn usual() -> Vec<Wish> {
        let is_usual = |wish: &Wish| !matches!(wish, Wish::Perception | Wish::WitnessOutside);
        Wish::ALL.into_iter().filter(is_usual).collect()
    }
}

/// A failure that a run showed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    /// Kind of the failure.
    pub wish: Wish,
    /// Simulated time at which the failure first occurred.
    pub at_s: f64,
    /// Text that distinguishes failures of one cause from those of another: the place of a panic, or the methods and sensors of the scene.
    pub signature: String,
    /// Description of the failure in words.
    pub seen: String,
}

/// Time for which the true pose may be outside the estimate before the localizer's status *sound* counts as wrong: the localizer has one second to
/// notice.
const OUTSIDE_S: f64 = 1.0;

/// Time by which an instant of witnesses and the estimate at it may differ by rounding.
const SAME_S: f64 = 1e-6;

/// Finds every failure that the record of a completed run shows. Crashes, runs without end and results that differ between two runs are found by the
/// search itself, as no single record shows them.
pub fn hits(scene: &Scene, record: &RunRecord, verdict: &Verdict) -> Vec<Hit> {
    [
        judged(scene, record, verdict, Judgement::Unsound),
        judged(scene, record, verdict, Judgement::Perception),
        sound_but_outside(scene, record, verdict),
        empty_box(scene, record),
        wider_than_room(scene, record),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn judged(scene: &Scene, record: &RunRecord, verdict: &Verdict, judgement: Judgement) -> Option<Hit> {
    let wish = match judgement {
        Judgement::Unsound => Wish::Unsound,
        _ => Wish::Perception,
    };
    let count = verdict.judgements.iter().filter(|other| **other == judgement).count();
    let first = verdict.judgements.iter().position(|other| *other == judgement)?;
    let (truth, estimate) = (record.truths.get(first)?, record.estimates.get(first)?);
    let (hull, pose) = (estimate.pose.hull(), truth.pose.to_array());
    let outside = |axis: usize| (hull[axis].lo() - pose[axis]).max(pose[axis] - hull[axis].hi()).max(0.0);
    let seen = format!(
        "{count} of {} steps, first at {:.2} s: outside by {:.2} mm, {:.2} mm, {:.4} deg",
        verdict.judgements.len(),
        truth.time_s,
        1e3 * outside(0),
        1e3 * outside(1),
        outside(2).to_degrees()
    );
    Some(Hit { wish, at_s: truth.time_s, signature: methods(scene), seen })
}

/// Finds the first instant at which a witness is outside an estimate with the status *sound*.
pub fn witness_outside(scene: &Scene, record: &RunRecord, sharpness: &Sharpness) -> Option<Hit> {
    let is_sound = |time_s: f64| {
        let at = record.estimates.partition_point(|estimate| estimate.time_s < time_s - SAME_S);
        record.estimates.get(at).is_some_and(|estimate| estimate.status == Status::Sound)
    };
    let outside = sharpness.instants.iter().find(|instant| !instant.in_box && is_sound(instant.time_s))?;
    let power = outside.power.map(|power| power.map_or("none".to_owned(), |power| format!("{power:.4}")));
    let seen = format!("at {:.2} s, of the half widths from the middle: {}", outside.time_s, power.join(", "));
    Some(Hit { wish: Wish::WitnessOutside, at_s: outside.time_s, signature: methods(scene), seen })
}

/// Finds the first time that the true pose is outside the estimate for more than a second, with the status *sound* at every step, and without an
/// excuse: by then no declared bound that any estimate relied on was exceeded, and no reading had more false claims than its method declares.
///
/// The function does not use the causes that the judge finds for losses of the truth, so that a judge who is too lenient does not hide a failure.
fn sound_but_outside(scene: &Scene, record: &RunRecord, verdict: &Verdict) -> Option<Hit> {
    let excused_from_s = broken_from_s(record, verdict).min(misread_from_s(scene, record));
    let mut since: Option<usize> = None;
    for (index, (truth, estimate)) in record.truths.iter().zip(&record.estimates).enumerate() {
        let is_wrong = estimate.status == Status::Sound && !estimate.pose.contains(truth.pose);
        let is_excused = truth.time_s >= excused_from_s;
        // When the robot is lifted to its next station, the time for which the true pose is outside counts from zero again.
        if !is_wrong || is_excused || record.restarts.contains(&index) {
            since = None;
            continue;
        }
        let first = *since.get_or_insert(index);
        let lasted_s = truth.time_s - record.truths[first].time_s;
        if lasted_s > OUTSIDE_S {
            let at_s = record.truths[first].time_s;
            let seen = format!("outside and sound from {at_s:.2} s for more than {OUTSIDE_S} s");
            return Some(Hit { wish: Wish::SoundButOutside, at_s, signature: methods(scene), seen });
        }
    }
    None
}

/// Returns the first time at which a declared bound was exceeded and some estimate had relied on this bound; infinite if there is no such time.
fn broken_from_s(record: &RunRecord, verdict: &Verdict) -> f64 {
    let relied_on_s = |bound: &str| {
        record.estimates.iter().find(|estimate| estimate.relies_on.contains(&bound)).map(|estimate| estimate.time_s)
    };
    let excuses = verdict.violations.iter().filter_map(|broken| Some(relied_on_s(&broken.bound)?.max(broken.from_s)));
    excuses.fold(f64::INFINITY, f64::min)
}

/// Returns the arrival time of the first reading with more false claims of the vision than declared; infinite if there is no such reading.
fn misread_from_s(scene: &Scene, record: &RunRecord) -> f64 {
    let misperceived = misperceived(record, &false_claims(scene, record));
    let misread = record.images.iter().zip(misperceived).filter(|(_, is_misread)| *is_misread);
    misread.map(|(image, _)| image.arrived_s).fold(f64::INFINITY, f64::min)
}

fn empty_box(scene: &Scene, record: &RunRecord) -> Option<Hit> {
    let empty = record.estimates.iter().find(|estimate| estimate.pose.hull().is_empty())?;
    let status = if empty.status == Status::Sound { "sound" } else { "recovering" };
    let seen = format!("no pose is left at {:.2} s, {status}", empty.time_s);
    Some(Hit { wish: Wish::EmptyBox, at_s: empty.time_s, signature: format!("{status}, {}", methods(scene)), seen })
}

/// Finds an estimate with the status *sound* whose box is wider than the room leaves to the robot. The localizer knows the walls and the robot's
/// body, so that its box must not reach to poses at which the body would stand in a wall.
fn wider_than_room(scene: &Scene, record: &RunRecord) -> Option<Hit> {
    let most_m = scene.left_to_origin_m();
    // Interval arithmetic rounds outwards, so that a box may be wider by this much without being wrong.
    const ROUNDING_M: f64 = 1e-9;
    let is_wider = |axis: usize, width: f64| width > most_m[axis] + ROUNDING_M;
    let wide = record.estimates.iter().filter(|estimate| estimate.status == Status::Sound).find_map(|estimate| {
        let hull = estimate.pose.hull();
        let axis = (0..2).find(|axis| !hull.is_empty() && is_wider(*axis, hull[*axis].width()))?;
        Some((estimate.time_s, axis, hull[axis].width()))
    })?;
    let (at_s, axis, width_m) = wide;
    let seen =
        format!("{width_m:.3} m along {}, where walls leave {:.3} m, at {at_s:.2} s", ["x", "y"][axis], most_m[axis]);
    Some(Hit { wish: Wish::WiderThanRoom, at_s, signature: methods(scene), seen })
}

/// Lists the localization methods of a scene, its motion sensors beside the wheels, and whether readings come late, as a text that groups failures by
/// cause.
fn methods(scene: &Scene) -> String {
    let methods = scene.localizer.methods.iter();
    let named = methods.filter_map(|method| Some(serde_json::to_value(method).ok()?.as_str()?.to_owned()));
    let devices = [("gyro", scene.robot.gyro.is_some()), ("flow", scene.robot.flow.is_some())];
    let fitted = devices.into_iter().filter(|(_, is_fitted)| *is_fitted).map(|(name, _)| name.to_owned());
    let late = (scene.robot.delivery.late_s > 0.0).then(|| "late".to_owned());
    let all: Vec<String> = named.chain(fitted).chain(late).collect();
    if all.is_empty() { "wheels alone".to_owned() } else { all.join(" + ") }
}
