//! The result table as a CSV file with all columns, for programs and for readers who miss a column in a table for people.

use std::io;

use csv::{Reader, StringRecord, Writer};
use thiserror::Error;

use super::{
    Kind, Row,
    columns::{COLUMNS, SCENE},
};

const KINDS: [(Kind, &str); 3] = [(Kind::Runs, "runs"), (Kind::Method, "method"), (Kind::Baseline, "baseline")];

/// Writes rows as CSV: a column `line` that says what each row is about, and all columns of the result table by the names that `--columns` takes.
pub fn as_csv(rows: &[Row]) -> csv::Result<Vec<u8>> {
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record(&head())?;
    for row in rows {
        let kind = KINDS.iter().find(|(kind, _)| *kind == row.kind).map_or("", |(_, name)| name);
        writer.write_record([kind].into_iter().chain(row.cells.iter().map(String::as_str)))?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// A file that does not have the columns of the result table: another file, or one of another version of the program.
#[derive(Debug, Error)]
#[error(
    "not a table of this program: expected a first line that begins with line,scene, and the names of all columns, or no such file"
)]
struct OtherColumns;

/// Reads the rows of such a file; none of an empty text.
///
/// # Errors
/// Returns an error for a text with other columns, or that is no CSV.
pub fn from_csv(text: &str) -> io::Result<Vec<Row>> {
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let mut reader = Reader::from_reader(text.as_bytes());
    if *reader.headers().map_err(io::Error::other)? != head() {
        return Err(io::Error::other(OtherColumns));
    }
    let row = |record: StringRecord| {
        let (kind, _) = KINDS.iter().find(|(_, name)| record.get(0) == Some(*name))?;
        Some(Row { kind: *kind, cells: record.iter().skip(1).map(str::to_owned).collect() })
    };
    let rows: csv::Result<_> = reader.into_records().filter_map(|record| record.map(row).transpose()).collect();
    rows.map_err(io::Error::other)
}

/// The rows of some scenes together with those of `before` that are of other scenes, in the order of the scenes' names.
pub fn joined(rows: &[Row], before: Vec<Row>) -> Vec<Row> {
    let is_of_another = |earlier: &Row| rows.iter().all(|row| row.scene() != earlier.scene());
    let mut all: Vec<Row> = before.into_iter().filter(is_of_another).chain(rows.iter().cloned()).collect();
    // Rows of one scene keep their order.
    all.sort_by(|one, other| one.cells[SCENE].cmp(&other.cells[SCENE]));
    all
}

fn head() -> StringRecord {
    ["line"].into_iter().chain(COLUMNS.iter().map(|column| column.name)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{artefacts::result_table::Line, judge::figures::Figures};

    use super::*;

    fn row(scene: &str, run: &str) -> Row {
        Row::from(&Line {
            scene: scene.to_owned(),
            subject: String::new(),
            kind: Kind::Runs,
            run: run.to_owned(),
            verdict: "1/2 passed".to_owned(),
            figures: Figures::from([("width.x_m.mean".to_owned(), 0.01), ("width.y_m.mean".to_owned(), 0.02)]),
        })
    }

    #[test]
    fn what_is_written_is_read_again() {
        let rows = [row("a, \"b\"", "3 seeds"), Row { kind: Kind::Baseline, ..row("a", "odometry") }];
        let csv = String::from_utf8(as_csv(&rows).unwrap()).unwrap();
        assert!(csv.starts_with("line,scene,localizer,run,checks,") && csv.contains(",20.0,"), "{csv}");
        assert_eq!(from_csv(&csv).unwrap(), rows);
        assert_eq!(from_csv("").unwrap(), []);
        assert!(from_csv("# Notes\n").unwrap_err().to_string().contains("expected a first line"));
    }

    #[test]
    fn scenes_that_ran_are_replaced_and_the_others_stay() {
        let before = vec![row("b", "old"), row("c", "kept")];
        let all = joined(&[row("b", "one"), row("b", "another"), row("a", "new")], before);
        assert_eq!(all, [row("a", "new"), row("b", "one"), row("b", "another"), row("c", "kept")]);
    }
}
