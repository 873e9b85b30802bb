//! Which columns of the result table are shown.

use thiserror::Error;

use super::columns::{COLUMNS, FAULTS, FIRST};

/// Greatest number of columns of a table of which nobody asked for more.
pub const MOST_COLUMNS: usize = 8;

/// The columns that are shown of a table whose columns have names and an order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// The columns that a reader needs first, [`MOST_COLUMNS`] at most.
    #[default]
    Usual,
    /// All columns that have a cell with a text.
    All,
    /// The columns with these indices, in this order.
    These(Vec<usize>),
}

/// The name of no column.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("unknown column `{unknown}`, expected all, or some of {} with commas between them", names.join(", "))]
pub struct UnknownColumn {
    unknown: String,
    names: Vec<String>,
}

impl Shown {
    /// Reads `all`, or names of columns of the result table with commas between them.
    pub fn of_result_table(text: &str) -> Result<Shown, UnknownColumn> {
        Shown::among(text, &COLUMNS.map(|column| column.name))
    }

    /// Reads `all`, or names of columns with commas between them, for a table with columns of these names.
    pub fn among(text: &str, names: &[&str]) -> Result<Shown, UnknownColumn> {
        if text == "all" {
            return Ok(Shown::All);
        }
        let index = |name: &str| {
            let found = names.iter().position(|column| *column == name);
            found.ok_or_else(|| UnknownColumn {
                unknown: name.to_owned(),
                names: names.iter().map(|&name| name.to_owned()).collect(),
            })
        };
        Ok(Shown::These(text.split(',').map(str::trim).map(index).collect::<Result<_, _>>()?))
    }

    /// The indices of the columns that are shown of a result table with these rows, and how many more have a cell with a text. A column that is
    /// `apart` stands outside of the table and is not counted.
    pub(super) fn columns(&self, rows: &[&[String]], apart: Option<usize>) -> (Vec<usize>, usize) {
        let is_filled = |column: &usize| Some(*column) != apart && rows.iter().any(|row| !row[*column].is_empty());
        let filled: Vec<usize> = (0..COLUMNS.len()).filter(is_filled).collect();
        let mut chosen = match self {
            Shown::All => return (filled, 0),
            Shown::These(columns) => {
                let n_more = filled.iter().filter(|column| !columns.contains(column)).count();
                return (columns.iter().copied().filter(|column| Some(*column) != apart).collect(), n_more);
            }
            Shown::Usual => filled.clone(),
        };
        let is_faultless = |column: &usize| {
            FAULTS.contains(&COLUMNS[*column].name) && rows.iter().all(|row| ["", "0"].contains(&row[*column].as_str()))
        };
        chosen.retain(|column| !is_faultless(column));
        let rank = |column: &usize| FIRST.iter().position(|name| *name == COLUMNS[*column].name);
        // Columns that are not in the list come last, from left to right.
        chosen.sort_by_key(|column| rank(column).unwrap_or(FIRST.len()));
        chosen.truncate(MOST_COLUMNS);
        chosen.sort_unstable();
        let n_more = filled.len() - chosen.len();
        (chosen, n_more)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn index(name: &str) -> usize {
        COLUMNS.iter().position(|column| column.name == name).unwrap()
    }

    /// A row with a 1 in all columns but those named, which are empty.
    fn row(empty: &[&str]) -> Vec<String> {
        COLUMNS.iter().map(|column| if empty.contains(&column.name) { "" } else { "1" }.to_owned()).collect()
    }

    fn usual(row: Vec<String>, apart: Option<usize>) -> Vec<&'static str> {
        let (columns, _) = Shown::Usual.columns(&[&row], apart);
        columns.into_iter().map(|column| COLUMNS[column].name).collect()
    }

    #[test]
    fn no_two_columns_have_one_name_and_the_first_ones_exist() {
        let mut names: Vec<&str> = COLUMNS.iter().map(|column| column.name).collect();
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
        assert!(FIRST.iter().chain(&FAULTS).all(|name| names.contains(name)));
    }

    #[test]
    fn the_usual_columns_are_eight_and_faults_come_before_figures() {
        let of_boxes = ["localizer", "in_3_sigma", "nees", "width_3_sigma", "width_3_sigma_heading"];
        let mut clean = row(&[&of_boxes[..], &["searched"]].concat());
        FAULTS.iter().for_each(|name| clean[index(name)] = "0".to_owned());
        let expected = ["run", "contained", "unsound", "rmse", "width", "width_heading", "goals", "verdict"];
        assert_eq!(usual(clean.clone(), Some(index("scene"))), expected);
        // Where the robot had to find its place, the table says how long that took.
        let mut searching = clean.clone();
        searching[index("searched")] = "1".to_owned();
        assert!(usual(searching, Some(index("scene"))).contains(&"searched"));
        clean[index("perception")] = "3".to_owned();
        let expected = ["run", "contained", "perception", "unsound", "rmse", "width", "width_heading", "verdict"];
        assert_eq!(usual(clean, Some(index("scene"))), expected);
    }

    #[test]
    fn what_is_not_shown_is_counted() {
        let row = row(&["checks"]);
        let rows = [row.as_slice()];
        let n_filled = COLUMNS.len() - 1;
        assert_eq!(Shown::Usual.columns(&rows, None).1, n_filled - MOST_COLUMNS);
        assert_eq!(
            Shown::All.columns(&rows, None),
            ((0..COLUMNS.len()).filter(|at| *at != index("checks")).collect(), 0)
        );
        let named = Shown::of_result_table("speed, run").unwrap();
        assert_eq!(named.columns(&rows, None), (vec![index("speed"), index("run")], n_filled - 2));
    }

    #[test]
    fn the_name_of_no_column_is_refused_with_those_that_there_are() {
        let refusal = Shown::of_result_table("run,widht").unwrap_err().to_string();
        assert!(refusal.contains("`widht`") && refusal.contains("width_heading, at_fix"), "{refusal}");
    }
}
