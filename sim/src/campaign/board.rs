//! Calibration of a camera from pictures of a chessboard, and the keys of a scene that declare it.

use std::path::{Path, PathBuf};

use localizer::{
    calibration::{
        TOLERATED_DEVIATIONS,
        chessboard::{Bend, Calibration, Corner, Deviations, calibrate, corners, deviations},
    },
    reading::Camera,
};
use serde_json::{Value, json};
use toml::Value as Toml;

use crate::loading::Setting;

/// Why pictures of a board calibrate no camera. The text of the error follows "failed to".
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// A picture cannot be read.
    #[error("read picture {}: {source}", path.display())]
    Unreadable {
        /// The file of the picture.
        path: PathBuf,
        /// What the decoder says.
        source: image::ImageError,
    },
    /// A picture has another size than the first one.
    #[error("calibrate by {}: {}×{} px, where {} has {}×{} px, expected pictures of one camera", path.display(), found[0], found[1], first.display(), expected[0], expected[1])]
    Size {
        /// The file of the picture.
        path: PathBuf,
        /// Its width and height.
        found: [u32; 2],
        /// The file of the first picture.
        first: PathBuf,
        /// Width and height of the first picture.
        expected: [u32; 2],
    },
    /// Too few pictures show the whole board.
    #[error(
        "calibrate by {n_pictures} pictures: {n_found} show all {columns}×{rows} squares, expected at least {least}{}",
        told(missed)
    )]
    FewBoards {
        /// Number of pictures.
        n_pictures: usize,
        /// Number of pictures that show the board.
        n_found: usize,
        /// Squares of the board along its length.
        columns: usize,
        /// Squares of the board along its width.
        rows: usize,
        /// Least number of pictures that have to show the board.
        least: usize,
        /// The pictures that do not show it.
        missed: Vec<PathBuf>,
    },
    /// The views do not determine a camera.
    #[error(
        "calibrate by {0} views of the board: they determine no camera, expected boards that lean in several directions"
    )]
    Undetermined(usize),
    /// The camera's focal length is no key of a scene.
    #[error(
        "calibrate the floor camera by a board: its focal length follows from `footprint_width_m` and `height_m`, expected the ceiling or the forward camera"
    )]
    FloorCamera,
}

fn told(missed: &[PathBuf]) -> String {
    let names: Vec<String> = missed.iter().take(5).map(|path| path.display().to_string()).collect();
    let more = if missed.len() > 5 { format!(" and {} more", missed.len() - 5) } else { String::new() };
    if names.is_empty() { String::new() } else { format!("; not in {}{more}", names.join(", ")) }
}

/// Least number of views of the board: with fewer, leaving one out leaves too little.
const LEAST_VIEWS: usize = 6;

/// A camera that pictures of a board have calibrated.
#[derive(Clone, Debug)]
pub struct BoardCalibration {
    /// Width and height of the pictures.
    pub size_px: [u32; 2],
    /// Number of pictures in which the board was found.
    pub n_views: usize,
    /// Pictures that do not show the whole board.
    pub missed: Vec<PathBuf>,
    /// The camera, and the residual of the fit.
    pub found: Calibration,
    /// How well the views determine it.
    pub deviations: Deviations,
    /// Keys of the scene that declare the camera, with their values.
    pub keys: Vec<Setting>,
}

/// Calibrates the camera that took these pictures of a board.
pub fn calibrate_board(
    pictures: &[PathBuf],
    board: &corners::Board,
    bend: Bend,
    camera: Camera,
) -> Result<BoardCalibration, BoardError> {
    if camera == Camera::Floor {
        return Err(BoardError::FloorCamera);
    }
    let mut size_px: Option<(&Path, [u32; 2])> = None;
    let (mut views, mut missed): (Vec<Vec<Corner>>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    for path in pictures {
        let picture = decoded(path)?;
        let found = [picture.width(), picture.height()];
        match size_px {
            Some((first, expected)) if expected != found => {
                return Err(BoardError::Size { path: path.clone(), found, first: first.to_owned(), expected });
            }
            Some(_) => {}
            None => size_px = Some((path, found)),
        }
        match corners::find(&picture, board) {
            Some(corners) => views.push(corners),
            None => missed.push(path.clone()),
        }
    }
    let (Some((_, size_px)), true) = (size_px, views.len() >= LEAST_VIEWS) else {
        return Err(BoardError::FewBoards {
            n_pictures: pictures.len(),
            n_found: views.len(),
            columns: board.columns,
            rows: board.rows,
            least: LEAST_VIEWS,
            missed,
        });
    };
    let n_views = views.len();
    let found = calibrate(&views, bend).ok_or(BoardError::Undetermined(n_views))?;
    let deviations = deviations(&views, bend, size_px).ok_or(BoardError::Undetermined(n_views))?;
    let keys = keys_of(&found, &deviations, size_px, camera);
    Ok(BoardCalibration { size_px, n_views, missed, found, deviations, keys })
}

/// A picture from a file, in grey.
pub(super) fn decoded(path: &Path) -> Result<image::GrayImage, BoardError> {
    let read = image::ImageReader::open(path).map_err(image::ImageError::IoError);
    let read = read.and_then(|reader| reader.with_guessed_format().map_err(image::ImageError::IoError));
    let picture = read.and_then(image::ImageReader::decode);
    let picture = picture.map_err(|source| BoardError::Unreadable { path: path.to_owned(), source })?;
    Ok(picture.into_luma8())
}

/// Keys of the scene that declare a camera as it was found.
fn keys_of(found: &Calibration, deviations: &Deviations, size_px: [u32; 2], camera: Camera) -> Vec<Setting> {
    let within = |deviation: f64| TOLERATED_DEVIATIONS * deviation;
    let intrinsics = &found.intrinsics;
    let [focal_u_px, focal_v_px] = intrinsics.focal_px;
    let named = |name: &str| format!("robot.{}.{name}", camera.device());
    let number = |name: &str, value: f64| Setting::number(&named(name), value);
    let numbers = |name: &str, values: &[f64]| {
        let list = values.iter().map(|value| number(name, *value).value).collect();
        Setting { key: named(name), value: Toml::Array(list) }
    };
    let count = |name: &str, value: u32| Setting { key: named(name), value: Toml::Integer(value.into()) };
    let relative = within((deviations.focal_px[0] / focal_u_px).max(deviations.focal_px[1] / focal_v_px));
    let [k1, k2, p1, p2] = intrinsics.distortion;
    let mut keys = vec![
        count("width_px", size_px[0]),
        count("height_px", size_px[1]),
        numbers("lens.distortion", &[k1, k2, p1, p2, 0.0]),
        number("calibration.distortion_tolerance_px", within(deviations.bend_px)),
    ];
    let centre_px = within(deviations.centre_px[0].max(deviations.centre_px[1]));
    if camera == Camera::Ceiling {
        keys.extend([
            numbers("focal_px", &intrinsics.focal_px),
            numbers("principal_point_px", &intrinsics.centre_px),
            number("calibration.focal_tolerance", relative),
            number("calibration.principal_point_tolerance_px", centre_px),
        ]);
    } else {
        // The forward camera has one focal length, and its principal point in the middle of the image.
        let focal_px = 0.5 * (focal_u_px + focal_v_px);
        let middle_px = size_px.map(|pixels| 0.5 * (f64::from(pixels) - 1.0));
        let off_px = (0..2).map(|axis| (intrinsics.centre_px[axis] - middle_px[axis]).abs()).fold(0.0, f64::max);
        let view_rad = 2.0 * (0.5 * f64::from(size_px[0]) / focal_px).atan();
        let unequal = 0.5 * (focal_u_px - focal_v_px).abs() / focal_px;
        keys.extend([
            number("horizontal_view_deg", view_rad.to_degrees()),
            number("calibration.focal_tolerance", unequal + relative),
            number("calibration.principal_point_tolerance_px", off_px + centre_px),
        ]);
    }
    keys
}

impl BoardCalibration {
    /// What the terminal shows.
    pub fn text(&self) -> String {
        let (intrinsics, deviations) = (&self.found.intrinsics, &self.deviations);
        let within = |deviation: f64| TOLERATED_DEVIATIONS * deviation;
        let mut text = format!(
            "{} views of the board in pictures of {} × {} px, {:.3} px from the corners in the root mean square\n{:<20} {:>12} {:>12}\n",
            self.n_views, self.size_px[0], self.size_px[1], self.found.rms_px, "constant", "found", "± 3 σ"
        );
        for (name, value, deviation) in [
            ("focal length u, px", intrinsics.focal_px[0], deviations.focal_px[0]),
            ("focal length v, px", intrinsics.focal_px[1], deviations.focal_px[1]),
            ("principal point u, px", intrinsics.centre_px[0], deviations.centre_px[0]),
            ("principal point v, px", intrinsics.centre_px[1], deviations.centre_px[1]),
        ] {
            text.push_str(&format!("{name:<22} {value:>10.3} {:>12.3}\n", within(deviation)));
        }
        let [k1, k2, p1, p2] = intrinsics.distortion;
        text.push_str(&format!(
            "lens k1 {k1:.5}, k2 {k2:.5}, p1 {p1:.6}, p2 {p2:.6}: pixels are off by at most {:.3} px (3 σ)\n",
            within(deviations.bend_px)
        ));
        if !self.missed.is_empty() {
            text.push_str(&format!(
                "not all of the board is found in {} pictures{}\n",
                self.missed.len(),
                told(&self.missed)
            ));
        }
        text
    }

    /// All that was found, as JSON.
    pub fn to_json(&self) -> Value {
        let (intrinsics, deviations) = (&self.found.intrinsics, &self.deviations);
        json!({
            "size_px": self.size_px, "views": self.n_views, "missed": self.missed, "rms_px": self.found.rms_px,
            "focal_px": intrinsics.focal_px, "principal_point_px": intrinsics.centre_px, "distortion": intrinsics.distortion,
            "deviations": {
                "focal_px": deviations.focal_px, "principal_point_px": deviations.centre_px, "bend_px": deviations.bend_px,
            },
            "keys": self.keys.iter().map(|one| (one.key.clone(), json!(one.value))).collect::<serde_json::Map<_, _>>(),
        })
    }
}
