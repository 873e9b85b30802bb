//! Tables of results in files, read in pieces so that a table may have more rows than memory holds.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use csv::{ReaderBuilder, StringRecord};

use crate::artefacts::run_files::{RecordError, naming};

use super::{Cell, Table};

/// Greatest number of rows of a piece that is read from a CSV file.
const MOST_ROWS: usize = 1000;
/// Name of the folder in which a sweep of many cases has its tables.
pub const PARTS: &str = "results";

/// Returns the files with tables of results that a path stands for: itself if it is a file; otherwise those in the folder's folder `results`, or the
/// folder's `results.parquet`, or its `results.csv`.
pub fn table_files(path: &Path) -> Result<Vec<PathBuf>, RecordError> {
    if path.is_file() {
        return Ok(vec![path.to_owned()]);
    }
    let parts = path.join(PARTS);
    if parts.is_dir() {
        let entries =
            naming("read the folder", &parts, fs::read_dir(&parts).and_then(Iterator::collect::<Result<Vec<_>, _>>))?;
        let mut files: Vec<PathBuf> =
            entries.into_iter().map(|entry| entry.path()).filter(|file| is_table(file)).collect();
        files.sort();
        return Ok(files);
    }
    let whole = ["results.parquet", "results.csv"].map(|name| path.join(name));
    let found = whole.into_iter().find(|file| file.is_file() && is_table(file));
    let nothing = || {
        io::Error::new(
            io::ErrorKind::NotFound,
            "expected results.parquet or results.csv in it, which `wherein report` writes for a folder of runs",
        )
    };
    Ok(vec![naming("find a table of results in", path, found.ok_or_else(nothing))?])
}

/// Whether this program reads the file as a table, by the ending of its name.
fn is_table(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending == Some("csv") || cfg!(feature = "parquet") && ending == Some("parquet")
}

/// Reads those columns of a table whose names are wanted, and calls `see` for each piece of the table with some of its rows.
pub fn read_pieces(
    path: &Path,
    is_wanted: &dyn Fn(&str) -> bool,
    see: &mut dyn FnMut(&Table),
) -> Result<(), RecordError> {
    let file = naming("read", path, File::open(path))?;
    let ending = path.extension().and_then(|ending| ending.to_str());
    let read = match ending {
        Some("csv") => from_csv(file, is_wanted, see),
        Some("parquet") => from_parquet(file, is_wanted, see),
        _ => Err("expected a table of results, results.csv or results.parquet".to_owned()),
    };
    naming("read", path, read.map_err(io::Error::other))
}

#[cfg(feature = "parquet")]
fn from_parquet(file: File, is_wanted: &dyn Fn(&str) -> bool, see: &mut dyn FnMut(&Table)) -> Result<(), String> {
    super::parquet_file::read_pieces(file, is_wanted, see).map_err(|error| error.to_string())
}

#[cfg(not(feature = "parquet"))]
fn from_parquet(_: File, _: &dyn Fn(&str) -> bool, _: &mut dyn FnMut(&Table)) -> Result<(), String> {
    Err("this program was built without the feature `parquet`, expected results.csv".to_owned())
}

fn from_csv(file: File, is_wanted: &dyn Fn(&str) -> bool, see: &mut dyn FnMut(&Table)) -> Result<(), String> {
    // Rows with more or fewer fields than the first line are refused, as a table that was cut off has them.
    let mut reader = ReaderBuilder::new().from_reader(io::BufReader::new(file));
    let names: Vec<String> = reader.headers().map_err(|error| error.to_string())?.iter().map(str::to_owned).collect();
    let wanted: Vec<usize> = (0..names.len()).filter(|column| is_wanted(&names[*column])).collect();
    let columns: Vec<String> = wanted.iter().map(|column| names[*column].clone()).collect();
    let mut piece = Table { columns, rows: Vec::new() };
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| error.to_string())? {
        piece.rows.push(wanted.iter().map(|column| cell(&names[*column], &record[*column])).collect());
        if piece.rows.len() >= MOST_ROWS {
            see(&piece);
            piece.rows.clear();
        }
    }
    see(&piece);
    Ok(())
}

/// The cell of a column with this name, from its text in a CSV file.
fn cell(name: &str, text: &str) -> Cell {
    let other = || if text.is_empty() { Cell::Empty } else { Cell::Text(text.to_owned()) };
    if super::table::is_text(name) {
        return other();
    }
    let whole = || (name == "seed").then(|| text.parse().ok().map(Cell::Whole)).flatten();
    let number = || text.parse().ok().map(Cell::Number);
    let truth = || text.parse().ok().map(Cell::Truth);
    whole().or_else(number).or_else(truth).unwrap_or_else(other)
}
