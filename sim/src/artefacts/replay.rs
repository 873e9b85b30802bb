//! Replays a recording through a localizer, without the simulator: the same readings give the same estimates, bit for bit.

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

use localizer::{Estimate, reading::Camera};
use thiserror::Error;

use crate::{
    artefacts::{
        recording::{
            RecordingError,
            cameras::topics,
            exact::{self, ImageStamp, RecordedEstimate, Start},
            reader::{self, Part},
        },
        run_files::estimates_digest,
    },
    loading::upgraded,
    scene::{Scene, SceneError},
    subject::{Failure, Subject, SubjectChoice, subject},
};

/// Reason why a recording cannot be replayed. The error's text is phrased to follow "failed to".
#[derive(Debug, Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The scene in the recording is not valid in this version.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene in the recording names a map of landmarks by a path from a folder that is not known.
    #[error(
        "replay {}: `localizer.mapped_landmarks.map = {map:?}` is a path from the folder of a scene that is not here, expected a whole path, as \
         `wherein repeat` records it",
        path.display()
    )]
    NoMap {
        /// Path of the recording.
        path: PathBuf,
        /// Path of the map, as the scene states it.
        map: String,
    },
}

/// The localizer's estimates in a replay, and how they compare with the recorded ones.
#[derive(Clone, Debug, Default)]
pub struct Replay {
    /// Name of the recorded scene.
    pub scene: String,
    /// Seed of the recorded run.
    pub seed: String,
    /// The replayed estimates, one for each recorded one.
    pub estimates: Vec<Estimate>,
    /// Number of replayed estimates that differ from the recorded ones in any bit of their time, status or boxes.
    pub n_different: usize,
    /// Time of the first estimate that differs from the recorded one.
    pub first_different_s: Option<f64>,
    /// The digest `digest.estimates` of the recorded run.
    pub recorded_digest: String,
    /// Name of the localizer of the recorded run; empty in recordings of versions that did not tell it.
    pub recorded_subject: String,
    /// Why the localizer could not go on, if it could not: the replay ends there.
    pub failure: Option<Failure>,
}

impl Replay {
    /// The digest `digest.estimates` of the replay.
    pub fn digest(&self) -> String {
        estimates_digest(&self.estimates)
    }
}

/// Replays a recording with the localizer `choice`, set up by the recorded scene or by the scene `other` if given. Whatever the localizer answers, the
/// readings stay those of the recorded drive.
pub fn replay(path: &Path, other: Option<&Scene>, choice: &SubjectChoice) -> Result<Replay, ReplayError> {
    let subject = match other {
        Some(scene) => {
            let told = told(scene, path)?;
            Some((scene.clone(), subject(choice, &told)))
        }
        None => None,
    };
    let mut replayer = Replayer { path, choice, subject, stamp: None, offset_s: 0.0, found: Replay::default() };
    reader::read(path, &mut |part| replayer.hear(part))?;
    Ok(replayer.found)
}

/// A scene as the localizer of the recorded run was told it. What its seed has drawn of that is at the recording's end, so that the recording is read
/// once more where it matters.
fn told<'a>(scene: &'a Scene, path: &Path) -> Result<Cow<'a, Scene>, ReplayError> {
    if !scene.localizer.mapped_landmarks().confuses() {
        return Ok(Cow::Borrowed(scene));
    }
    let mut seed = 0;
    reader::read::<ReplayError>(path, &mut |part| {
        if let Part::Facts(facts) = part {
            seed = facts.get("seed").and_then(|seed| seed.parse().ok()).unwrap_or(0);
        }
        Ok(())
    })?;
    Ok(scene.told(seed))
}

struct Replayer<'a> {
    path: &'a Path,
    choice: &'a SubjectChoice,
    /// The localizer, and the scene from which it was built.
    subject: Option<(Scene, Box<dyn Subject>)>,
    /// Stamp of the image whose pixels come next in the recording.
    stamp: Option<ImageStamp>,
    offset_s: f64,
    found: Replay,
}

impl Replayer<'_> {
    fn hear(&mut self, part: Part<'_>) -> Result<(), ReplayError> {
        match part {
            Part::Scene(text) => {
                if self.subject.is_none() {
                    let file = format!("scene.toml in {}", self.path.display());
                    // The scene of an older recording is rewritten for this version. One that cannot be is refused with what is wrong in it.
                    let text = upgraded(text).map_or_else(|_| text.to_owned(), |upgraded| upgraded.text);
                    let scene = Scene::parse_beside(&text, &file, None)?;
                    let setup = scene.localizer.mapped_landmarks();
                    if let Some(map) = setup.map.filter(|_| setup.known.is_none()) {
                        return Err(ReplayError::NoMap { path: self.path.to_owned(), map });
                    }
                    let localizer = {
                        let told = told(&scene, self.path)?;
                        subject(self.choice, &told)
                    };
                    self.subject = Some((scene, localizer));
                }
            }
            Part::Message { .. } if self.found.failure.is_some() => {}
            Part::Message { topic, message } => self.take(topic, message).ok_or_else(|| {
                let (path, topic) = (self.path.to_owned(), topic.to_owned());
                RecordingError::Message { path, topic }
            })?,
            Part::Facts(facts) => {
                let fact = |name: &str| facts.get(name).cloned().unwrap_or_default();
                self.found.scene = fact("scene");
                self.found.seed = fact("seed");
                self.found.recorded_digest = fact("digest.estimates");
                self.found.recorded_subject = fact("subject");
            }
        }
        Ok(())
    }

    /// Hands the content of a message to the localizer; `None` when the message does not have the content that its topic requires.
    fn take(&mut self, topic: &str, message: &[u8]) -> Option<()> {
        let (scene, localizer) = self.subject.as_mut()?;
        match topic {
            exact::START => {
                let start = Start::decode(message)?;
                self.offset_s = start.offset_s;
                let start_box = match start.station {
                    Some(index) => scene.at_station(scene.stations.get(index)?).start_box(),
                    None => scene.start_box(),
                };
                localizer.start(&start_box);
            }
            exact::IMAGE_STAMP => self.stamp = Some(ImageStamp::decode(message)?),
            exact::WHEELS | exact::GYRO | exact::FLOW | exact::RANGE | exact::OTHER => {
                localizer.observe(&exact::decode(topic, message)?);
            }
            exact::ESTIMATE => {
                let recorded = RecordedEstimate::decode(message)?;
                let time_s = recorded.time_s - self.offset_s;
                let answer = localizer.estimate_at(time_s);
                if let Some(failure) = localizer.failure() {
                    self.found.failure = Some(failure.clone().begin_later(self.offset_s));
                    return Some(());
                }
                let mut estimate = answer.into_estimate(time_s);
                estimate.time_s += self.offset_s;
                // Encoded bytes are compared instead of numbers, because −0 equals 0 and NaN does not equal itself.
                if RecordedEstimate::of(&estimate).encode() != message {
                    self.found.n_different += 1;
                    self.found.first_different_s.get_or_insert(recorded.time_s);
                }
                self.found.estimates.push(estimate);
            }
            // Messages for viewers, and those that only the simulator needs, are skipped.
            _ if Camera::ALL.iter().all(|camera| topics(*camera).image != topic) => {}
            _image => {
                localizer.observe(&self.stamp.take()?.with_image(message)?);
            }
        }
        Some(())
    }
}
