//! Tables as CSV (RFC 4180), with all digits of every number.

use std::fmt::Write;

use super::{Cell, Table};

/// The table as CSV, its first line the names of the columns.
pub fn to_csv(table: &Table) -> String {
    let mut text = line(table.columns.iter().map(|name| escaped(name)));
    for row in &table.rows {
        text += &line(row.iter().map(|cell| match cell {
            Cell::Empty => String::new(),
            Cell::Text(text) => escaped(text),
            Cell::Number(number) => number.to_string(),
            Cell::Whole(number) => number.to_string(),
            Cell::Truth(truth) => truth.to_string(),
        }));
    }
    text
}

/// Names of the columns and all rows of a CSV text, as texts; what is wrong with it otherwise.
pub fn from_csv(text: &str) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    let mut rows = parse(text)?;
    if rows.is_empty() {
        return Err("an empty file, expected a line with the names of columns".to_owned());
    }
    let columns = rows.remove(0);
    match rows.iter().position(|row| row.len() != columns.len()) {
        Some(index) => {
            let (found, wanted) = (rows[index].len(), columns.len());
            Err(format!("row {} has {found} fields, expected {wanted} like the first line", index + 2))
        }
        None => Ok((columns, rows)),
    }
}

fn line(cells: impl Iterator<Item = String>) -> String {
    let mut line = cells.collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

fn escaped(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

fn parse(text: &str) -> Result<Vec<Vec<String>>, String> {
    let (mut rows, mut row, mut field) = (Vec::new(), Vec::new(), String::new());
    let (mut is_quoted, mut characters) = (false, text.chars().peekable());
    while let Some(character) = characters.next() {
        match (character, is_quoted) {
            ('"', true) if characters.peek() == Some(&'"') => {
                characters.next();
                field.push('"');
            }
            ('"', _) => is_quoted = !is_quoted,
            (',', false) => row.push(std::mem::take(&mut field)),
            ('\r', false) => {}
            ('\n', false) => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            // Writing to a `String` cannot fail.
            _ => _ = field.write_char(character),
        }
    }
    if is_quoted {
        return Err("a quote that is never closed".to_owned());
    }
    if !field.is_empty() || !row.is_empty() {
        row.push(field);
        rows.push(row);
    }
    Ok(rows)
}
