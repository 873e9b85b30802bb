//! The result table as text for a terminal and as Markdown.

use super::{
    Kind, Line, Row,
    columns::{COLUMNS, Column, RUN, SCENE},
    shown::Shown,
};

/// The table as text: aligned columns under headings of two lines, each scene's name above its lines, and tables of runs, methods and
/// baselines in that order. Where columns are left out of any of them, a last line says how to see them.
pub fn as_text(lines: &[Line], shown: &Shown) -> String {
    let rows: Vec<Row> = lines.iter().map(Row::from).collect();
    let (tables, n_left_out): (Vec<String>, Vec<usize>) =
        tables(&rows).into_iter().map(|(kind, rows)| aligned(kind, &rows, shown)).unzip();
    match n_left_out.into_iter().max() {
        Some(n @ 1..) if *shown == Shown::Usual => {
            let columns = if n == 1 { "one more column" } else { &format!("up to {n} more columns") };
            format!("{}\n--columns all shows {columns}.\n", tables.join("\n"))
        }
        _ => tables.join("\n"),
    }
}

/// The same result table as Markdown.
pub fn as_markdown(rows: &[Row], shown: &Shown) -> String {
    tables(rows).into_iter().map(|(kind, rows)| markdown(kind, &rows, shown)).collect::<Vec<_>>().join("\n")
}

/// The table's rows grouped by kind (runs, methods, baselines), because rows of different kinds fill different columns.
fn tables(rows: &[Row]) -> Vec<(Kind, Vec<&Row>)> {
    let of = |kind: Kind| (kind, rows.iter().filter(|row| row.kind == kind).collect::<Vec<_>>());
    [Kind::Runs, Kind::Method, Kind::Baseline].map(of).into_iter().filter(|(_, rows)| !rows.is_empty()).collect()
}

/// The aligned table of rows of one kind, and the number of columns that are left out of it.
fn aligned(kind: Kind, table: &[&Row], shown: &Shown) -> (String, usize) {
    let rows: Vec<&[String]> = table.iter().map(|row| row.cells.as_slice()).collect();
    // The scene's name has a line of its own, so that its column is left out.
    let (shown, n_left_out) = shown.columns(&rows, Some(SCENE));
    let (upper, lower): (Vec<String>, Vec<String>) =
        COLUMNS.iter().map(|column| heading_lines(heading(column, kind), column.unit)).unzip();
    let width = |column: usize| {
        let texts = [upper.as_slice(), &lower].into_iter().chain(rows.iter().copied());
        texts.map(|row| row[column].chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
    let aligned = |row: &[String]| {
        let cells: Vec<String> =
            shown.iter().map(|column| align(&row[*column], &COLUMNS[*column], widths[*column])).collect();
        format!("  {}\n", cells.join("  ")).trim_end().to_owned() + "\n"
    };
    let mut text = aligned(&upper) + &aligned(&lower);
    let mut scene = "";
    for row in table {
        if row.scene() != scene {
            scene = row.scene();
            text += &format!("{scene}\n");
        }
        text += &aligned(&row.cells);
    }
    (text, n_left_out)
}

fn markdown(kind: Kind, rows: &[&Row], shown: &Shown) -> String {
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let heading = |column: &Column| match (heading(column, kind), column.unit) {
        (heading, "") => heading.to_owned(),
        (heading, unit) => format!("{heading}, {unit}"),
    };
    let rule = |column: &Column| if column.is_text { ":--" } else { "--:" }.to_owned();
    let rows: Vec<&[String]> = rows.iter().map(|row| row.cells.as_slice()).collect();
    let (shown, _) = shown.columns(&rows, None);
    let shown_of = |cell: &dyn Fn(usize) -> String| row(shown.iter().map(|column| cell(*column)).collect());
    let mut text = shown_of(&|column| heading(&COLUMNS[column]));
    text += &shown_of(&|column| rule(&COLUMNS[column]));
    text.extend(rows.iter().map(|row| shown_of(&|column| row[column].clone())));
    text
}

/// The heading of a column. In the tables of methods and of baselines the column that otherwise names runs is headed `method` or `baseline`.
fn heading(column: &Column, kind: Kind) -> &'static str {
    match (column.heading, kind) {
        (RUN, Kind::Method) => "method",
        (RUN, Kind::Baseline) => "baseline",
        (heading, _) => heading,
    }
}

/// A heading above its unit, or in two lines when it has several words and no unit.
fn heading_lines(heading: &str, unit: &str) -> (String, String) {
    match (unit, heading.split_once(' ')) {
        ("", Some((first, second))) => (first.to_owned(), second.to_owned()),
        (unit, _) => (heading.to_owned(), unit.to_owned()),
    }
}

fn align(cell: &str, column: &Column, width: usize) -> String {
    if column.is_text { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
}
