//! The files of a report.

use std::path::Path;

use crate::{
    artefacts::{result_table::Shown, run_files::RecordError},
    campaign::{
        cases::{Results, Table, to_csv},
        sweep::write_whole,
    },
};

use super::{Overview, as_html, as_markdown};

/// Writes the report on results into `folder`: results.csv, report.html, summary.md, and results.parquet where the program was built with that. The
/// tables of report.html and summary.md have the figures that are `shown`, results.csv and results.parquet have all.
pub fn write(results: &Results, shown: &Shown, folder: &Path) -> Result<Overview, RecordError> {
    let overview = Overview { shown: shown.clone(), ..Overview::of(results) };
    let table = Table::of(results);
    write_whole(&folder.join("results.csv"), to_csv(&table).as_bytes())?;
    #[cfg(feature = "parquet")]
    write_parquet(&table, folder)?;
    write_whole(&folder.join("report.html"), as_html(&overview, results).as_bytes())?;
    write_whole(&folder.join("summary.md"), as_markdown(&overview, results).as_bytes())?;
    Ok(overview)
}

#[cfg(feature = "parquet")]
fn write_parquet(table: &Table, folder: &Path) -> Result<(), RecordError> {
    use crate::artefacts::run_files::naming;
    let path = folder.join("results.parquet");
    let bytes = naming("write", &path, crate::campaign::cases::to_parquet(table).map_err(std::io::Error::other))?;
    write_whole(&path, &bytes)
}
