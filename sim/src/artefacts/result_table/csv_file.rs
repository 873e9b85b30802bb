//! The result table as a CSV file with all columns, for programs and for readers who miss a column in a table for people.

use csv::{Reader, StringRecord, Writer};

use super::{
    Kind, Line,
    columns::{COLUMNS, SCENE},
};

/// Writes the lines as CSV: a column `line` that says what each line is about, and all columns of the result table by the names that `--columns` takes.
/// Lines of `before`, the contents of such a file, stay where they are of scenes that `lines` has nothing of; they are dropped where that file has
/// other columns.
pub fn as_csv(lines: &[Line], before: &str) -> csv::Result<Vec<u8>> {
    let head: StringRecord = ["line"].into_iter().chain(COLUMNS.iter().map(|column| column.name)).collect();
    let mut records = kept(lines, before, &head)?;
    records.extend(lines.iter().map(|line| {
        let cells = COLUMNS.iter().map(|column| (column.cell)(line));
        [kind(line.kind).to_owned()].into_iter().chain(cells).collect::<StringRecord>()
    }));
    // Lines of one scene keep their order.
    records.sort_by(|one, other| one[1 + SCENE].cmp(&other[1 + SCENE]));
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record(&head)?;
    records.iter().try_for_each(|record| writer.write_record(record))?;
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// The records of an earlier file that are of other scenes.
fn kept(lines: &[Line], before: &str, head: &StringRecord) -> csv::Result<Vec<StringRecord>> {
    let mut reader = Reader::from_reader(before.as_bytes());
    if reader.headers()? != head {
        return Ok(Vec::new());
    }
    let records = reader.into_records().collect::<csv::Result<Vec<_>>>()?;
    let is_of_another = |record: &StringRecord| lines.iter().all(|line| line.scene != record[1 + SCENE]);
    Ok(records.into_iter().filter(is_of_another).collect())
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Runs => "runs",
        Kind::Method => "method",
        Kind::Baseline => "baseline",
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::judge::figures::Figures;

    use super::*;

    fn line(scene: &str, run: &str) -> Line {
        Line {
            scene: scene.to_owned(),
            subject: String::new(),
            kind: Kind::Runs,
            run: run.to_owned(),
            verdict: "1/2 passed".to_owned(),
            figures: Figures::from([("width.x_m.mean".to_owned(), 0.01), ("width.y_m.mean".to_owned(), 0.02)]),
        }
    }

    /// Scene and run of each record, and how wide its boxes are.
    fn told(csv: &[u8]) -> Vec<[String; 3]> {
        let mut reader = Reader::from_reader(csv);
        let head = reader.headers().unwrap().clone();
        let of =
            |record: &StringRecord, name: &str| record[head.iter().position(|one| one == name).unwrap()].to_owned();
        let records = reader.records().map(|record| record.unwrap());
        records.map(|record| ["scene", "run", "width"].map(|name| of(&record, name))).collect()
    }

    #[test]
    fn scenes_that_ran_are_replaced_and_the_others_stay() {
        let before = as_csv(&[line("b", "old"), line("c", "kept")], "").unwrap();
        let after =
            as_csv(&[line("b", "one"), line("b", "another"), line("a", "new")], str::from_utf8(&before).unwrap());
        let expected = [["a", "new"], ["b", "one"], ["b", "another"], ["c", "kept"]];
        assert_eq!(told(&after.unwrap()), expected.map(|[scene, run]| [scene, run, "20.0"].map(str::to_owned)));
        assert_eq!(told(&as_csv(&[line("a", "new")], "line,scene\nruns,c\n").unwrap()).len(), 1);
    }
}
