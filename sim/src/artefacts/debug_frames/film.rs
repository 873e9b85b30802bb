//! The film of a run: a time lapse of what each camera saw, of the map with what the localizer stated, and of the outcome.

use std::{fs::File, io, path::Path};

use image::RgbImage;
use png::EncodingError;

use crate::{
    artefacts::files::{RecordError, naming},
    judge::Verdict,
    loading::SceneFile,
    run::RunRecord,
};

mod animation;
mod drawing;
mod layout;
mod reel;
mod status;
mod widths;

use animation::Animation;
use drawing::{Drawing, Moment};
pub use reel::Reel;

/// Name of the film in the folder of a run.
pub(crate) const FILE: &str = "film.png";

/// How long the outcome is shown at the end, in hundredths of a second.
const OUTCOME_HUNDREDTHS: u16 = 200;

/// Draws the film of a run and writes it into the run's folder, frame by frame, so that no more than two frames are in memory at once.
pub(crate) fn write(
    folder: &Path,
    file: &SceneFile,
    record: &RunRecord,
    verdict: &Verdict,
    reel: &Reel,
) -> Result<(), RecordError> {
    let path = folder.join(FILE);
    let stream = naming("create", &path, File::create(&path))?;
    let written = encode(io::BufWriter::new(stream), file, record, verdict, reel);
    naming("write", &path, written.map_err(io::Error::other))
}

fn encode(
    out: impl io::Write,
    file: &SceneFile,
    record: &RunRecord,
    verdict: &Verdict,
    reel: &Reel,
) -> Result<(), EncodingError> {
    let drawing = Drawing::new(file, record, verdict, reel);
    let mut animation = Animation::begin(out, drawing.size_px(), reel.samples().len() + 1)?;
    for sample in reel.samples() {
        let moment = Moment { step: Some(sample.step), pictures: &sample.pictures, is_end: false };
        animation.add(&drawing.draw(&moment), reel::FRAME_HUNDREDTHS)?;
    }
    animation.add(&last_frame(&drawing, record, reel), OUTCOME_HUNDREDTHS)?;
    animation.finish()
}

/// The frame that shows the outcome, over what was seen and stated last.
fn last_frame(drawing: &Drawing<'_>, record: &RunRecord, reel: &Reel) -> RgbImage {
    let step = record.truths.len().checked_sub(1);
    drawing.draw(&Moment { step, pictures: &reel.last_pictures(), is_end: true })
}
