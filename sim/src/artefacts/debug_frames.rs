//! Debug frames: what a camera gave, and what the localizer made of it.

use std::{fmt, path::Path, str::FromStr};

use image::{GrayImage, RgbImage};
use localizer::Reading;

use crate::{
    artefacts::run_files::{RecordError, naming},
    run::{ImageRecord, RunRecord},
    scene::{RangeCamera, SceneFile},
};

mod camera_view;
mod canvas;
mod contact_sheet;
mod errand_map;
mod figure;
mod map_view;
mod palette;
mod range_view;
mod tones;

pub use contact_sheet::{Column, contact_sheet};
pub use tones::tone_mapped;

/// Of which images a run leaves debug frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FramesPolicy {
    /// Of none.
    #[default]
    None,
    /// Of those after which the truth is outside the estimate, or that emptied it; of the one that left the widest box when
    /// a run without any of those misses an expectation.
    Failures,
    /// Of every n-th, the first included.
    Every(usize),
    /// Of all.
    All,
}

impl FramesPolicy {
    /// Whether to keep image `number`; `failed` when the truth is outside the estimate after it, or it emptied the estimate.
    pub fn keeps(self, number: usize, failed: bool) -> bool {
        match self {
            FramesPolicy::None => false,
            FramesPolicy::Failures => failed,
            FramesPolicy::Every(n) => number.is_multiple_of(n),
            FramesPolicy::All => true,
        }
    }
}

impl FromStr for FramesPolicy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let every = text.strip_prefix("every=").and_then(|n| n.parse().ok()).filter(|n| *n > 0);
        match (text, every) {
            ("none", _) => Ok(FramesPolicy::None),
            ("failures", _) => Ok(FramesPolicy::Failures),
            ("all", _) => Ok(FramesPolicy::All),
            (_, Some(n)) => Ok(FramesPolicy::Every(n)),
            _ => Err("expected none, failures, every=N with N at least 1, or all".to_owned()),
        }
    }
}

impl fmt::Display for FramesPolicy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FramesPolicy::None => f.write_str("none"),
            FramesPolicy::Failures => f.write_str("failures"),
            FramesPolicy::Every(n) => write!(f, "every={n}"),
            FramesPolicy::All => f.write_str("all"),
        }
    }
}

/// Draws what the localizer saw in an image beside where that put the robot; none when the record did not keep the image.
pub fn figure(file: &SceneFile, record: &RunRecord, image: &ImageRecord) -> Option<RgbImage> {
    Some(figure::draw(file, record, image, &Seen::of(file, image.reading.as_ref()?)?))
}

/// Writes `image_*.png` as a camera gave it and `figure_*.png` for every reading that `record` kept, and says of how many.
pub(crate) fn write(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<usize, RecordError> {
    let mut count = 0;
    for image in &record.images {
        let Some(seen) = image.reading.as_ref().and_then(|reading| Seen::of(file, reading)) else { continue };
        write_one(folder, file, record, image, &seen)?;
        count += 1;
    }
    Ok(count)
}

/// Writes `errands.png`, the map of a run's errands, if it had any.
pub(crate) fn write_errands(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<(), RecordError> {
    if record.errands.is_none() {
        return Ok(());
    }
    let path = folder.join("errands.png");
    naming("write", &path, errand_map::draw(file, record).save(&path).map_err(std::io::Error::other))
}

/// Writes the same of the reading that left the widest box.
pub(crate) fn write_widest(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<(), RecordError> {
    let widest = record.widest_image.as_ref();
    let Some((image, reading)) = widest.and_then(|(index, reading)| Some((record.images.get(*index)?, reading))) else {
        return Ok(());
    };
    Seen::of(file, reading).map_or(Ok(()), |seen| write_one(folder, file, record, image, &seen))
}

fn write_one(
    folder: &Path,
    file: &SceneFile,
    record: &RunRecord,
    image: &ImageRecord,
    seen: &Seen,
) -> Result<(), RecordError> {
    let number = image.number;
    if let Seen::Image { pixels, .. } = seen {
        let raw = folder.join(format!("image_{number:05}.png"));
        naming("write", &raw, pixels.save(&raw).map_err(std::io::Error::other))?;
    }
    let drawn = folder.join(format!("figure_{number:05}.png"));
    let figure = figure::draw(file, record, image, seen);
    naming("write", &drawn, figure.save(&drawn).map_err(std::io::Error::other))
}

/// What a figure shows at its left.
enum Seen<'a> {
    /// Grey levels, and how long they were exposed.
    Image { pixels: &'a GrayImage, exposure_s: f64 },
    /// Codes that a range camera measured.
    Codes { camera: &'a RangeCamera },
}

impl<'a> Seen<'a> {
    fn of(file: &'a SceneFile, reading: &'a Reading) -> Option<Self> {
        match reading {
            Reading::Camera { image, exposure_s, .. } => Some(Seen::Image { pixels: image, exposure_s: *exposure_s }),
            Reading::Range { .. } => Some(Seen::Codes { camera: file.scene.robot.range_camera.as_ref()? }),
            Reading::Wheels { .. } | Reading::Gyro { .. } | Reading::Flow { .. } => None,
        }
    }
}
