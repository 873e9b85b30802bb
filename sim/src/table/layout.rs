//! The table as text for a terminal and as Markdown.

use super::{
    Line,
    columns::{COLUMNS, Column},
};

/// Aligned columns under a heading of two lines.
pub fn as_text(lines: &[Line]) -> String {
    let rows: Vec<Vec<String>> = lines.iter().map(cells).collect();
    // A column that no line fills only takes room.
    let shown: Vec<usize> =
        (0..COLUMNS.len()).filter(|column| rows.iter().any(|row| !row[*column].is_empty())).collect();
    let headings: [Vec<String>; 2] = [
        COLUMNS.iter().map(|column| column.heading.to_owned()).collect(),
        COLUMNS.iter().map(|column| column.unit.to_owned()).collect(),
    ];
    let all: Vec<&Vec<String>> = headings.iter().chain(&rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
    let mut text = String::new();
    for row in all {
        let aligned: Vec<String> =
            shown.iter().map(|column| align(&row[*column], &COLUMNS[*column], widths[*column])).collect();
        text.push_str(aligned.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// A Markdown table.
pub fn as_markdown(lines: &[Line]) -> String {
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let heading = |column: &Column| match column.unit {
        "" => column.heading.to_owned(),
        unit => format!("{}, {unit}", column.heading),
    };
    let rule = |column: &Column| if column.is_text { ":--" } else { "--:" }.to_owned();
    let mut text = row(COLUMNS.iter().map(heading).collect());
    text += &row(COLUMNS.iter().map(rule).collect());
    text.extend(lines.iter().map(|line| row(cells(line))));
    text
}

fn cells(line: &Line) -> Vec<String> {
    COLUMNS.iter().map(|column| (column.cell)(line)).collect()
}

fn align(cell: &str, column: &Column, width: usize) -> String {
    if column.is_text { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
}
