//! Debug frames: pictures of what a camera gave and of what the localizer made of it.

use std::path::Path;

use image::{GrayImage, RgbImage};
use localizer::Reading;

use crate::{
    artefacts::files::{RecordError, naming},
    loading::SceneFile,
    run::{ImageRecord, RunRecord},
    scene::RangeCamera,
};

mod camera_view;
mod canvas;
mod contact_sheet;
mod errand_map;
mod figure;
mod film;
mod legend;
mod log_map;
mod map_view;
mod palette;
mod range_view;
mod tones;

pub use contact_sheet::{Column, contact_sheet};
pub use film::Reel;
pub(crate) use film::{FILE as FILM, write as write_film};
pub(crate) use log_map::draw as log_map;
pub use tones::tone_mapped;

/// Draws the figure of an image: what the localizer saw in it, beside a map of where it put the robot. `None` when the run's record has not kept the
/// image.
pub fn figure(file: &SceneFile, record: &RunRecord, image: &ImageRecord) -> Option<RgbImage> {
    Some(figure::draw(file, record, image, &Seen::of(file, image.reading.as_ref()?)?))
}

/// Draws the map of a run: where the robot drove in truth, and where the localizer under test said that it was.
pub fn drive_map(file: &SceneFile, record: &RunRecord) -> RgbImage {
    errand_map::draw(file, record, true)
}

/// Writes the debug frames of every reading that the run's `record` has kept: `image_*.png`, the image as the camera gave it, and `figure_*.png`, the
/// image beside a map. Returns the number of these readings.
pub(crate) fn write(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<usize, RecordError> {
    let mut count = 0;
    for image in &record.images {
        let Some(seen) = image.reading.as_ref().and_then(|reading| Seen::of(file, reading)) else { continue };
        write_one(folder, file, record, image, &seen)?;
        count += 1;
    }
    Ok(count)
}

/// Writes `errands.png`, the map of a run's errands, if the run had errands.
pub(crate) fn write_errands(folder: &Path, file: &SceneFile, record: &RunRecord) -> Result<(), RecordError> {
    if record.errands.is_none() {
        return Ok(());
    }
    let path = folder.join("errands.png");
    naming("write", &path, errand_map::draw(file, record, false).save(&path).map_err(std::io::Error::other))
}

/// Writes the debug frames (`image_*.png` and `figure_*.png`) of the reading after which the localizer's box was widest.
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

/// What the left panel of a debug figure shows.
enum Seen<'a> {
    /// A camera image: its grey levels and its exposure time.
    Image { pixels: &'a GrayImage, exposure_s: f64 },
    /// Landmark codes that a range camera measured.
    Codes { camera: &'a RangeCamera },
}

impl<'a> Seen<'a> {
    fn of(file: &'a SceneFile, reading: &'a Reading) -> Option<Self> {
        match reading {
            Reading::Camera { image, exposure_s, .. } => Some(Seen::Image { pixels: image, exposure_s: *exposure_s }),
            Reading::Range { .. } => Some(Seen::Codes { camera: file.scene.robot.range_camera.as_ref()? }),
            Reading::Wheels { .. } | Reading::Gyro { .. } | Reading::Flow { .. } | Reading::Other { .. } => None,
        }
    }
}
