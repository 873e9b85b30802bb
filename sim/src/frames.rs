//! Debug frames: what a camera gave, and what the localizer made of it.

use std::{path::Path, str::FromStr};

use image::{GrayImage, RgbImage};
use localizer::Reading;

use crate::{
    record::{RecordError, naming},
    run::{ImageRecord, RunRecord},
    scene::SceneFile,
};

mod camera_view;
mod canvas;
mod contact_sheet;
mod figure;
mod map_view;
mod palette;

pub use contact_sheet::{Column, contact_sheet, tone_mapped};

/// Of which images a run leaves debug frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FramesPolicy {
    /// Of none.
    #[default]
    None,
    /// Of those after which the truth is outside the estimate, or that emptied it.
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

/// Draws what the localizer saw in an image beside where that put the robot; none when the record did not keep the image.
pub fn figure(file: &SceneFile, record: &RunRecord, image: &ImageRecord) -> Option<RgbImage> {
    let (pixels, exposure_s) = camera_image(image)?;
    Some(figure::draw(file, record, image, pixels, exposure_s))
}

/// Writes `image_*.png` as the sensor gave it and `figure_*.png` for every image that `record` kept.
pub(crate) fn write(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<(), RecordError> {
    for image in &record.images {
        let Some((pixels, exposure_s)) = camera_image(image) else { continue };
        let number = image.number;
        let raw = folder.join(format!("image_{number:05}.png"));
        naming("write", &raw, pixels.save(&raw).map_err(std::io::Error::other))?;
        let drawn = folder.join(format!("figure_{number:05}.png"));
        let figure = figure::draw(file, record, image, pixels, exposure_s);
        naming("write", &drawn, figure.save(&drawn).map_err(std::io::Error::other))?;
    }
    Ok(())
}

fn camera_image(image: &ImageRecord) -> Option<(&GrayImage, f64)> {
    match image.reading.as_ref()? {
        Reading::Camera { image, exposure_s, .. } => Some((image, *exposure_s)),
        _ => None,
    }
}
