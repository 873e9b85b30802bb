//! Grids as the files of ROS's map_server: a YAML file beside a PGM picture, trinary.
//!
//! The picture's first row has the greatest y. A pixel `x` is occupied with `p = (255 − x)/255`, or `p = x/255` when negated;
//! `p > occupied_thresh` is occupied, `p < free_thresh` free, all between unknown (wiki.ros.org/map_server, "Value
//! interpretation").

use std::{
    fs, io,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use super::{Cell, OccupancyGrid};

/// Grey levels that map_saver writes.
const FREE: u8 = 254;
const UNKNOWN: u8 = 205;
const OCCUPIED: u8 = 0;

/// Sizes of cells that are planned on: finer ones are slower and not better, coarser ones have no room for a robot.
const RESOLUTIONS_M: RangeInclusive<f64> = 0.01..=1.0;

/// What the YAML file says.
#[derive(Clone, Debug, PartialEq)]
struct Header {
    image: String,
    resolution_m: f64,
    origin_m: [f64; 2],
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
}

/// Why a map cannot be used. Its text follows "failed to".
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file cannot be read.
    #[error("read map {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("write map {}: {source}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file does not hold what it should.
    #[error("read map {}: {expected}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What was found and expected.
        expected: String,
    },
}

/// Writes `NAME.yaml` and `NAME.pgm` into a folder and returns the path of the first.
pub fn write(grid: &OccupancyGrid, folder: &Path, name: &str) -> Result<PathBuf, MapError> {
    let yaml = folder.join(format!("{name}.yaml"));
    for (path, bytes) in [(&folder.join(format!("{name}.pgm")), pgm(grid)), (&yaml, header(grid, name).into_bytes())] {
        fs::write(path, bytes).map_err(|source| MapError::Unwritable { path: path.clone(), source })?;
    }
    Ok(yaml)
}

/// Reads a map by its YAML file.
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
    let (size, levels) = parse_pgm(&bytes).map_err(invalid(&picture))?;
    let cells = (0..size[1]).rev().flat_map(|row| &levels[row * size[0]..(row + 1) * size[0]]);
    Ok(OccupancyGrid {
        resolution_m: header.resolution_m,
        origin_m: header.origin_m,
        size,
        cells: cells.map(|&level| header.cell(level)).collect(),
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

/// The picture of a grid, 8 bits a pixel.
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

/// The text of the YAML file.
pub(crate) fn header(grid: &OccupancyGrid, name: &str) -> String {
    let [x_m, y_m] = grid.origin_m;
    format!(
        "image: {name}.pgm\nmode: trinary\nresolution: {:?}\norigin: [{x_m:?}, {y_m:?}, 0.0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        grid.resolution_m
    )
}

/// The flat `key: value` lines that map_server's YAML consists of.
fn parse_header(text: &str) -> Result<Header, String> {
    let value = |key: &str| {
        text.lines().find_map(|line| {
            let line = line.split(" #").next().unwrap_or_default();
            let (name, value) = line.split_once(':')?;
            (name.trim() == key).then(|| value.trim().trim_matches(['"', '\'']).to_owned())
        })
    };
    let wanted = |key: &str| value(key).ok_or_else(|| format!("`{key}` is missing"));
    let number = |key: &str| -> Result<f64, String> {
        let text = wanted(key)?;
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("`{key}: {text}`, expected a finite number"))
    };
    let mode = value("mode").unwrap_or_else(|| "trinary".to_owned());
    if mode != "trinary" {
        return Err(format!("`mode: {mode}`, expected trinary, the only mode that is read"));
    }
    let resolution_m = number("resolution")?;
    if !RESOLUTIONS_M.contains(&resolution_m) {
        let (least_m, most_m) = (RESOLUTIONS_M.start(), RESOLUTIONS_M.end());
        return Err(format!("`resolution: {resolution_m}`, expected a number of metres from {least_m} to {most_m}"));
    }
    let origin = wanted("origin")?;
    let parts: Option<Vec<f64>> = origin.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).and_then(|list| {
        list.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
    });
    let Some([x_m, y_m, yaw_rad]) = parts.as_deref() else {
        return Err(format!("`origin: {origin}`, expected [x, y, yaw] in metres and radians"));
    };
    if *yaw_rad != 0.0 {
        return Err(format!("`origin: {origin}`, expected a yaw of 0: turned maps are not read"));
    }
    let negate = match wanted("negate")?.as_str() {
        "0" | "false" => false,
        "1" | "true" => true,
        other => return Err(format!("`negate: {other}`, expected 0 or 1")),
    };
    let (occupied_thresh, free_thresh) = (number("occupied_thresh")?, number("free_thresh")?);
    if !(0.0 <= free_thresh && free_thresh <= occupied_thresh && occupied_thresh <= 1.0) {
        return Err(format!("thresholds {free_thresh} and {occupied_thresh}, expected 0 ≤ free ≤ occupied ≤ 1"));
    }
    let image = wanted("image")?;
    Ok(Header { image, resolution_m, origin_m: [*x_m, *y_m], negate, occupied_thresh, free_thresh })
}

/// Width and height, and the levels from the upper left, of a binary PGM picture of 8 bits.
fn parse_pgm(bytes: &[u8]) -> Result<([usize; 2], &[u8]), String> {
    let mut at = 0;
    let mut word = || {
        while let Some(&byte) = bytes.get(at) {
            if byte == b'#' {
                at += bytes[at..].iter().take_while(|&&byte| byte != b'\n').count();
            } else if byte.is_ascii_whitespace() {
                at += 1;
            } else {
                break;
            }
        }
        let n_bytes = bytes[at..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        at += n_bytes;
        (String::from_utf8_lossy(&bytes[at - n_bytes..at]).into_owned(), at)
    };
    let (kind, _) = word();
    if kind != "P5" {
        return Err(format!("begins with `{}`, expected P5, a binary PGM", kind.chars().take(8).collect::<String>()));
    }
    let mut number = |what: &str, most: usize| -> Result<(usize, usize), String> {
        let (text, end) = word();
        let number = text.parse::<usize>().ok().filter(|number| (1..=most).contains(number));
        number.map(|number| (number, end)).ok_or_else(|| format!("{what} `{text}`, expected a number from 1 to {most}"))
    };
    let ((width, _), (height, _)) = (number("width", 100_000)?, number("height", 100_000)?);
    let (greatest, end) = number("greatest level", 65_535)?;
    if greatest != 255 {
        return Err(format!("greatest level {greatest}, expected 255"));
    }
    let levels = bytes.get(end + 1..).unwrap_or_default();
    if levels.len() != width * height {
        return Err(format!("{} bytes of pixels, expected {} for {width} × {height}", levels.len(), width * height));
    }
    Ok(([width, height], levels))
}
