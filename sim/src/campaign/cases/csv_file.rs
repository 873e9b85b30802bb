//! Tables of results as CSV (RFC 4180), with all digits of every number.

use csv::{ReaderBuilder, StringRecord, WriterBuilder};

use super::{Cell, Table};

/// Writes a table of results as CSV. The first line has the names of the columns.
pub fn to_csv(table: &Table) -> String {
    let rows = table.rows.iter().map(|row| row.iter().map(text).collect::<StringRecord>());
    let mut writer = WriterBuilder::new().from_writer(Vec::new());
    for record in std::iter::once(table.columns.iter().collect()).chain(rows) {
        // Writing cannot fail: the rows go into memory, and every row has as many fields as there are columns.
        let _ = writer.write_record(&record);
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

fn text(cell: &Cell) -> String {
    match cell {
        Cell::Empty => String::new(),
        Cell::Text(text) => text.clone(),
        Cell::Number(number) => number.to_string(),
        Cell::Whole(number) => number.to_string(),
        Cell::Truth(truth) => truth.to_string(),
    }
}

/// Returns the names of the columns and all rows of a CSV text, as texts, or a message that says what is wrong with the text.
pub fn from_csv(text: &str) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    // The library that reads CSV accepts a file that ends within quotes. Such a file has been cut off, so that it is refused here.
    if !text.matches('"').count().is_multiple_of(2) {
        return Err("a quote that is never closed".to_owned());
    }
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let records: Result<Vec<StringRecord>, csv::Error> = reader.records().collect();
    let records = records.map_err(|error| error.to_string())?;
    let mut rows = records.iter().map(|record| record.iter().map(str::to_owned).collect::<Vec<String>>());
    let Some(columns) = rows.next() else {
        return Err("an empty file, expected a line with the names of columns".to_owned());
    };
    let rows: Vec<Vec<String>> = rows.collect();
    match rows.iter().position(|row| row.len() != columns.len()) {
        Some(index) => {
            let (found, wanted) = (rows[index].len(), columns.len());
            Err(format!("row {} has {found} fields, expected {wanted} like the first line", index + 2))
        }
        None => Ok((columns, rows)),
    }
}
