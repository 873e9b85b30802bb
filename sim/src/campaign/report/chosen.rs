//! Which figures the tables of a report show, and the table of all combinations.

use crate::artefacts::result_table::{MOST_COLUMNS, Shown, UnknownColumn};

use super::{Group, MEASURES, Measure, Overview};

/// The table that has a line for each combination of scene, localizer and settings.
pub(super) struct Combinations {
    /// Headings of the columns.
    pub(super) headings: Vec<String>,
    /// Number of columns from the left that say which combination a line is about.
    pub(super) n_labels: usize,
    /// One line for each combination, in the order of the sweep.
    pub(super) rows: Vec<Vec<String>>,
    /// Number of figures that a combination has and that are not shown.
    pub(super) n_left_out: usize,
}

/// Greatest number of columns that say which combination a line is about; where there would be more, the keys share one column.
const MOST_LABELS: usize = 4;

/// Reads `all`, or the names of figures of a report with commas between them.
pub fn shown_figures(text: &str) -> Result<Shown, UnknownColumn> {
    Shown::among(text, &MEASURES.map(|measure| measure.key))
}

impl Overview {
    /// The figures that a table of the report shows beside `n_labels` other columns, and how many more there are. Usually these are as many as have
    /// room in [`MOST_COLUMNS`]: first those that every combination has, as a localizer without boxes has no widths, and last how errors compare with
    /// boxes.
    pub(super) fn chosen(&self, n_labels: usize) -> (Vec<&'static Measure>, usize) {
        let all: Vec<&Measure> = self.measures().collect();
        let chosen: Vec<&Measure> = match &self.shown {
            Shown::All => all.clone(),
            Shown::These(these) => these.iter().filter_map(|index| MEASURES.get(*index)).collect(),
            Shown::Usual => {
                let lacks = |measure: &&Measure| {
                    self.groups.iter().filter(|group| (measure.value)(&group.figures).is_none()).count()
                };
                let mut first = all.clone();
                first.sort_by_key(|measure| (measure.is_detail(), lacks(measure)));
                first.truncate(MOST_COLUMNS.saturating_sub(n_labels));
                first
            }
        };
        let n_left_out = all.iter().filter(|one| chosen.iter().all(|other| other.key != one.key)).count();
        (chosen, n_left_out)
    }

    /// Headings of the columns that say which combination a line is about.
    pub(super) fn label_headings(&self) -> Vec<String> {
        let is_one = usize::from(self.has_scenes) + usize::from(self.has_subjects) + self.keys.len() > MOST_LABELS;
        let mut headings = self.labels("scene", "localizer", str::to_owned);
        if let Some(last) = headings.last_mut().filter(|_| is_one) {
            *last = "settings".to_owned();
        }
        headings
    }

    /// What says which combination a line is about, by the values of its keys: scene and localizer where there are several, and the values, in one text
    /// where they would be too many columns.
    pub(super) fn labels(&self, scene: &str, subject: &str, value: impl Fn(&str) -> String) -> Vec<String> {
        let mut labels: Vec<String> = Vec::new();
        labels.extend(self.has_scenes.then(|| scene.to_owned()));
        labels.extend(self.has_subjects.then(|| subject.to_owned()));
        if labels.len() + self.keys.len() <= MOST_LABELS {
            labels.extend(self.keys.iter().map(|key| value(key)));
        } else {
            let leaf = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
            let each = self.keys.iter().map(|key| format!("{}={}", leaf(key), value(key)));
            labels.push(each.collect::<Vec<_>>().join(" "));
        }
        labels
    }

    /// The table of all combinations.
    pub(super) fn combinations(&self) -> Combinations {
        let mut headings = self.label_headings();
        let n_labels = headings.len();
        headings.push("passed".to_owned());
        let (chosen, n_left_out) = self.chosen(headings.len());
        headings.extend(chosen.iter().map(|measure| measure.heading()));
        let row = |group: &Group| {
            let mut cells = self.labels(&group.scene, &group.subject, |key| group.value(key));
            cells.push(format!("{}/{}", group.n_passed, group.n_cases));
            cells.extend(chosen.iter().map(|measure| measure.of(&group.figures)));
            cells
        };
        let rows = self.groups.iter().map(row).collect();
        Combinations { headings, n_labels, rows, n_left_out }
    }
}
