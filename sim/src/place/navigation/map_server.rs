//! Occupancy grids as the files of ROS's map_server in its trinary mode: a YAML file beside a PGM picture.
//!
//! Any grey or colour picture that the image library decodes can be read, a PGM or a PNG; the picture that is written is a PGM.
//!
//! The picture's first row has the greatest y. A pixel of grey level `x` has the occupancy `p = (255 − x)/255`, or `p = x/255` when the
//! file says `negate`. The cell is occupied for `p > occupied_thresh`, free for `p < free_thresh`, and unknown between
//! (wiki.ros.org/map_server, "Value interpretation").

use std::{
    collections::BTreeMap,
    fmt, fs, io,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use image::ImageError;
use serde::{Deserialize, de::IgnoredAny};

use super::{Cell, OccupancyGrid};

/// Grey levels that map_saver of ROS writes for free, unknown and occupied cells.
const FREE: u8 = 254;
const UNKNOWN: u8 = 205;
const OCCUPIED: u8 = 0;

/// Range of cell sizes that a map may have: finer cells make planning slower and not better, coarser ones leave no room for a robot.
const RESOLUTIONS_M: RangeInclusive<f64> = 0.01..=1.0;

/// Contents of a map's YAML file.
#[derive(Clone, Debug, PartialEq)]
struct Header {
    image: String,
    resolution_m: f64,
    origin_m: [f64; 2],
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
}

/// Why a map cannot be used. The text of the error follows "failed to".
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file of the map cannot be read.
    #[error("read map {}: {source}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// A file of the map cannot be written.
    #[error("write map {}: {source}", path.display())]
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// A file of the map does not have the expected contents.
    #[error("read map {}: {expected}", path.display())]
    Invalid {
        /// Path of the file.
        path: PathBuf,
        /// Description of what was found and what was expected.
        expected: String,
    },
}

/// Writes a grid as `NAME.yaml` and `NAME.pgm` into a folder and returns the path of the YAML file.
pub fn write(grid: &OccupancyGrid, folder: &Path, name: &str) -> Result<PathBuf, MapError> {
    let yaml = folder.join(format!("{name}.yaml"));
    for (path, bytes) in [(&folder.join(format!("{name}.pgm")), pgm(grid)), (&yaml, header(grid, name).into_bytes())] {
        fs::write(path, bytes).map_err(|source| MapError::Unwritable { path: path.clone(), source })?;
    }
    Ok(yaml)
}

/// Reads an occupancy grid, given the path of its YAML file.
pub fn read(yaml: &Path) -> Result<OccupancyGrid, MapError> {
    let invalid = |path: &Path| {
        let path = path.to_owned();
        move |expected| MapError::Invalid { path, expected }
    };
    let text = String::from_utf8(bytes_of(yaml)?)
        .map_err(|_| MapError::Invalid { path: yaml.to_owned(), expected: "expected text in UTF-8".to_owned() })?;
    let header = parse_header(&text).map_err(invalid(yaml))?;
    let picture = yaml.parent().unwrap_or(Path::new("")).join(&header.image);
    let bytes = bytes_of(&picture)?;
    let not_a_picture = |error: ImageError| format!("expected a PGM or PNG picture: {error}");
    let levels = image::load_from_memory(&bytes).map_err(not_a_picture).map_err(invalid(&picture))?.into_luma8();
    let size = [levels.width(), levels.height()].map(|side| side as usize);
    if size.contains(&0) {
        return Err(invalid(&picture)(format!("{} × {} pixels, expected at least one", size[0], size[1])));
    }
    let cells = levels.rows().rev().flatten();
    Ok(OccupancyGrid {
        resolution_m: header.resolution_m,
        origin_m: header.origin_m,
        size,
        cells: cells.map(|level| header.cell(level[0])).collect(),
    })
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, MapError> {
    fs::read(path).map_err(|source| MapError::Unreadable { path: path.to_owned(), source })
}

impl Header {
    fn cell(&self, level: u8) -> Cell {
        let light = f64::from(level) / 255.0;
        let occupied = if self.negate { light } else { 1.0 - light };
        if occupied > self.occupied_thresh {
            Cell::Occupied
        } else if occupied < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

/// Returns the picture of a grid as the bytes of a binary PGM with 8 bits a pixel: a header with width, height and greatest grey level,
/// then the grey levels.
pub(crate) fn pgm(grid: &OccupancyGrid) -> Vec<u8> {
    let [n_columns, n_rows] = grid.size;
    let mut bytes = format!("P5\n{n_columns} {n_rows}\n255\n").into_bytes();
    for row in (0..n_rows).rev() {
        bytes.extend((0..n_columns).map(|column| match grid.at([column, row]) {
            Cell::Free => FREE,
            Cell::Occupied => OCCUPIED,
            Cell::Unknown => UNKNOWN,
        }));
    }
    bytes
}

/// Returns the text of a map's YAML file.
pub(crate) fn header(grid: &OccupancyGrid, name: &str) -> String {
    let [x_m, y_m] = grid.origin_m;
    format!(
        "image: {name}.pgm\nmode: trinary\nresolution: {:?}\norigin: [{x_m:?}, {y_m:?}, 0.0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        grid.resolution_m
    )
}

/// A value in a map's YAML file, before its type is checked.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Value {
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Value>),
    /// A value of a type that no key of a map's YAML file may have.
    Other(IgnoredAny),
}

impl Value {
    fn finite(&self) -> Option<f64> {
        match self {
            Value::Number(number) if number.is_finite() => Some(*number),
            _ => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Flag(flag) => write!(out, "{flag}"),
            Value::Number(number) => write!(out, "{number}"),
            Value::Text(text) => write!(out, "{text}"),
            Value::List(items) => {
                write!(out, "[{}]", items.iter().map(Value::to_string).collect::<Vec<_>>().join(", "))
            }
            Value::Other(_) => write!(out, "…"),
        }
    }
}

/// Parses the YAML file of a map. Further keys, which other programs read, such as thresholds of costs, are ignored.
fn parse_header(text: &str) -> Result<Header, String> {
    let keys: BTreeMap<String, Value> = serde_saphyr::from_str(text).map_err(|error| {
        let message = error.to_string();
        format!("expected YAML of keys and values: {}", message.lines().next().unwrap_or_default())
    })?;
    let wanted = |key: &str| keys.get(key).ok_or_else(|| format!("`{key}` is missing"));
    let number = |key: &str| {
        let value = wanted(key)?;
        value.finite().ok_or_else(|| format!("`{key}: {value}`, expected a finite number"))
    };
    if let Some(mode) = keys.get("mode").map(Value::to_string).filter(|mode| mode != "trinary") {
        return Err(format!("`mode: {mode}`, expected trinary, the only mode that is read"));
    }
    let resolution_m = number("resolution")?;
    if !RESOLUTIONS_M.contains(&resolution_m) {
        let (least_m, most_m) = (RESOLUTIONS_M.start(), RESOLUTIONS_M.end());
        return Err(format!("`resolution: {resolution_m}`, expected a number of metres from {least_m} to {most_m}"));
    }
    let origin = wanted("origin")?;
    let parts: Option<Vec<f64>> = match origin {
        Value::List(parts) => parts.iter().map(Value::finite).collect(),
        _ => None,
    };
    let Some([x_m, y_m, yaw_rad]) = parts.as_deref() else {
        return Err(format!("`origin: {origin}`, expected [x, y, yaw] in metres and radians"));
    };
    if *yaw_rad != 0.0 {
        return Err(format!("`origin: {origin}`, expected a yaw of 0: turned maps are not read"));
    }
    let negate = match wanted("negate")? {
        Value::Flag(flag) => *flag,
        Value::Number(0.0) => false,
        Value::Number(1.0) => true,
        other => return Err(format!("`negate: {other}`, expected 0 or 1")),
    };
    let (occupied_thresh, free_thresh) = (number("occupied_thresh")?, number("free_thresh")?);
    if !(0.0 <= free_thresh && free_thresh <= occupied_thresh && occupied_thresh <= 1.0) {
        return Err(format!("thresholds {free_thresh} and {occupied_thresh}, expected 0 ≤ free ≤ occupied ≤ 1"));
    }
    let image = wanted("image")?.to_string();
    Ok(Header { image, resolution_m, origin_m: [*x_m, *y_m], negate, occupied_thresh, free_thresh })
}
