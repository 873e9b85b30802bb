//! What a search wishes for: each a way to break the promise.

use localizer::Status;
use serde::{Deserialize, Serialize};

use crate::{
    judge::{Judgement, Verdict, false_claims, misperceived},
    run::RunRecord,
    scene::Scene,
};

/// A way to break the promise, the gravest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wish {
    /// The process ended by itself: a panic, an abort, or more memory than any run needs.
    Crash,
    /// The run takes far longer than its like.
    Hang,
    /// The truth is outside though every bound held and the claims were true.
    Unsound,
    /// The truth is outside for more than a second, *sound* said all the while, and no bound was exceeded until then.
    SoundButOutside,
    /// The same run gives other bytes the second time.
    DigestDiffers,
    /// No pose is left.
    EmptyBox,
    /// A box, *sound*, that is wider than what the walls leave to the robot.
    WiderThanRoom,
    /// The truth is outside because more claims were false than declared.
    Perception,
}

impl Wish {
    /// All of them.
    pub const ALL: [Wish; 8] = [
        Wish::Crash,
        Wish::Hang,
        Wish::Unsound,
        Wish::SoundButOutside,
        Wish::DigestDiffers,
        Wish::EmptyBox,
        Wish::WiderThanRoom,
        Wish::Perception,
    ];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Wish::Crash => "crash",
            Wish::Hang => "hang",
            Wish::Unsound => "unsound",
            Wish::SoundButOutside => "sound_but_outside",
            Wish::DigestDiffers => "digest_differs",
            Wish::EmptyBox => "empty_box",
            Wish::WiderThanRoom => "wider_than_room",
            Wish::Perception => "perception",
        }
    }

    /// Those that make a search fail unless others are asked for: what vision sees wrongly is counted apart.
    pub fn usual() -> Vec<Wish> {
        Wish::ALL.into_iter().filter(|wish| *wish != Wish::Perception).collect()
    }
}

/// A wish that came true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    /// Which.
    pub wish: Wish,
    /// When it first did, in simulated time.
    pub at_s: f64,
    /// What tells hits of one cause from those of another: where a panic was, which methods a wrong box relied on.
    pub signature: String,
    /// What was seen, in words.
    pub seen: String,
}

/// The truth may be outside so long before *sound* is called wrong: a second is what the localizer has to notice.
const OUTSIDE_S: f64 = 1.0;

/// Everything that a run's record shows of wishes, those apart that only its process shows.
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

/// The first time that the truth is outside for long, *sound* said at every step, with nothing to excuse it: by then no bound was exceeded
/// that any estimate relied on, and no reading had more false claims than its method declares.
///
/// It does not ask the judge whose fault it is, so that a judge who is too lenient does not hide it.
fn sound_but_outside(scene: &Scene, record: &RunRecord, verdict: &Verdict) -> Option<Hit> {
    let excused_from_s = broken_from_s(record, verdict).min(misread_from_s(scene, record));
    let mut since: Option<usize> = None;
    for (index, (truth, estimate)) in record.truths.iter().zip(&record.estimates).enumerate() {
        let is_wrong = estimate.status == Status::Sound && !estimate.pose.contains(truth.pose);
        let is_excused = truth.time_s >= excused_from_s;
        // A robot that is put at a station is not where it was.
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

/// From when on a bound was exceeded that an estimate has relied on; infinite when none ever was.
fn broken_from_s(record: &RunRecord, verdict: &Verdict) -> f64 {
    let relied_on_s = |bound: &str| {
        record.estimates.iter().find(|estimate| estimate.relies_on.contains(&bound)).map(|estimate| estimate.time_s)
    };
    let excuses = verdict.violations.iter().filter_map(|broken| Some(relied_on_s(&broken.bound)?.max(broken.from_s)));
    excuses.fold(f64::INFINITY, f64::min)
}

/// From when on a reading had arrived that claims more falsely than declared; infinite when none ever did.
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

/// The localizer is told the walls and the body, so that no box that is sound reaches where the body would stand in a wall.
fn wider_than_room(scene: &Scene, record: &RunRecord) -> Option<Hit> {
    let most_m = scene.left_to_origin_m();
    // Interval arithmetic rounds outwards; nobody means a wall that finely.
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

/// The methods of a scene and the sensors of its motion, in words.
fn methods(scene: &Scene) -> String {
    let methods = scene.localizer.methods.iter();
    let named = methods.filter_map(|method| Some(serde_json::to_value(method).ok()?.as_str()?.to_owned()));
    let devices = [("gyro", scene.robot.gyro.is_some()), ("flow", scene.robot.flow.is_some())];
    let fitted = devices.into_iter().filter(|(_, is_fitted)| *is_fitted).map(|(name, _)| name.to_owned());
    let late = (scene.robot.delivery.late_s > 0.0).then(|| "late".to_owned());
    let all: Vec<String> = named.chain(fitted).chain(late).collect();
    if all.is_empty() { "wheels alone".to_owned() } else { all.join(" + ") }
}
