//! A debug frame of a case, which shows a camera image and what the vision found in it, scaled down so that it can be embedded in the report's page.

use std::{fs, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use image::{ImageReader, codecs::jpeg::JpegEncoder, imageops::FilterType};

use crate::campaign::cases::CaseResult;

/// Width of the debug frame in the report's page: wide enough that the frame's title can be read on a phone.
const WIDTH_PX: u32 = 760;
const QUALITY: u8 = 68;

/// Returns the debug frame nearest to the case's first loss of the truth, or the first frame if the truth was never lost, as a `data:` URL that
/// embeds the picture.
pub(super) fn data_url(case: &CaseResult) -> Option<String> {
    let figures = figures(&case.folder);
    let wanted = failing_image(case).unwrap_or(0);
    let (_, name) = figures.into_iter().min_by_key(|(number, _)| number.abs_diff(wanted))?;
    // The report shows what can be read; a debug frame that cannot be read is left out.
    let figure = ImageReader::open(case.folder.join(name)).ok()?.decode().ok()?.into_rgb8();
    let height_px = (figure.height() * WIDTH_PX).div_ceil(figure.width().max(1));
    let small = image::imageops::resize(&figure, WIDTH_PX, height_px, FilterType::Triangle);
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&small).ok()?;
    Some(format!("data:image/jpeg;base64,{}", STANDARD.encode(&bytes)))
}

/// Returns the image numbers and names of all debug frames in a folder, which are files `figure_*.png`.
fn figures(folder: &Path) -> Vec<(u64, String)> {
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let number = |name: &str| name.strip_prefix("figure_")?.strip_suffix(".png")?.parse().ok();
    let mut figures: Vec<(u64, String)> = names.filter_map(|name| Some((number(&name)?, name))).collect();
    figures.sort();
    figures
}

/// Estimates the number of the camera image that was taken when the truth was first outside the estimate, assuming that images come at equal
/// intervals.
fn failing_image(case: &CaseResult) -> Option<u64> {
    let summary = case.summary()?;
    let share = summary["containment"]["first_failure"]["time_s"].as_f64()? / summary["duration_s"].as_f64()?;
    let methods = summary["methods"].as_object()?.values();
    let images = methods.filter_map(|method| method["readings"].as_u64()).max()?;
    Some((share * images as f64).round() as u64)
}
