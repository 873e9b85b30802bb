//! Files of estimates that any program may write: boxes as `boxes.csv` of a run has them, or poses in the TUM format.

use std::{fs, path::Path};

use interval::Interval;
use localizer::{Estimate, PoseBox, PoseUnion, Status};

use super::{LogError, truth::read_tum};

/// The estimates of a file.
#[derive(Debug)]
pub(super) struct Stated {
    /// Whether the estimates are boxes; else each is a single pose, as a box without width.
    pub(super) has_boxes: bool,
    /// The estimates, in the order of their times.
    pub(super) estimates: Vec<Estimate>,
}

/// Columns of a file of boxes: the ends of each box along world x, world y and heading.
const SIDES: [[&str; 2]; 3] = [["x_min_m", "x_max_m"], ["y_min_m", "y_max_m"], ["heading_min_rad", "heading_max_rad"]];

/// Reads a file of estimates: one with the ending `csv` as boxes, any other as poses in the TUM format.
pub(super) fn read(path: &Path) -> Result<Stated, LogError> {
    let refused = |found: String| LogError::Estimates { path: path.to_owned(), found };
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        let text = fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
        return Ok(Stated { has_boxes: true, estimates: boxes(&text).map_err(refused)? });
    }
    let poses = read_tum(path).map_err(refused)?;
    let point = |time_s: f64, side: [f64; 3]| estimate(time_s, PoseBox::from(side.map(Interval::point)));
    let estimates = poses.iter().map(|one| point(one.stamp_ns as f64 * 1e-9, one.value.to_array())).collect();
    Ok(Stated { has_boxes: false, estimates })
}

fn estimate(time_s: f64, branch: PoseBox) -> Estimate {
    let pose = PoseUnion { branches: vec![branch] };
    Estimate { time_s, pose, status: Status::Sound, relies_on: Vec::new(), contradicting: None }
}

/// The boxes of a table. Lines with the same time are the boxes of one estimate, of which one has to hold the pose.
fn boxes(text: &str) -> Result<Vec<Estimate>, String> {
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let headers = table.headers().map_err(|error| error.to_string())?.clone();
    let column = |name: &str| {
        let place = headers.iter().position(|header| header.trim() == name);
        place.ok_or_else(|| {
            let sides = SIDES.concat().join(", ");
            format!("the column `{name}` is missing, expected the columns time_s, {sides}")
        })
    };
    let time = column("time_s")?;
    let mut sides = [[0; 2]; 3];
    for (axis, names) in SIDES.iter().enumerate() {
        sides[axis] = [column(names[0])?, column(names[1])?];
    }
    let mut estimates: Vec<Estimate> = Vec::new();
    for (index, row) in table.records().enumerate() {
        let row = row.map_err(|error| error.to_string())?;
        let line = row.position().map_or(index + 2, |position| position.line() as usize);
        let number = |place: usize| {
            let text = row.get(place).unwrap_or_default().trim();
            let number = text.parse::<f64>().ok().filter(|number| !number.is_nan());
            number.ok_or_else(|| format!("line {line}: `{}` is {text:?}, expected a number", &headers[place]))
        };
        let time_s = number(time)?;
        if !time_s.is_finite() {
            return Err(format!("line {line}: `time_s` is {time_s}, expected a finite time in seconds"));
        }
        let mut branch = PoseBox::from([Interval::ENTIRE; 3]);
        for (axis, [low, high]) in sides.into_iter().enumerate() {
            let (from, to) = (number(low)?, number(high)?);
            if from > to {
                let (low, high) = (&headers[low], &headers[high]);
                return Err(format!(
                    "line {line}: `{low}` is {from} and `{high}` is {to}, expected the lower end first"
                ));
            }
            branch[axis] = Interval::new(from, to);
        }
        match estimates.last_mut() {
            Some(last) if last.time_s == time_s => last.pose.branches.push(branch),
            Some(last) if last.time_s > time_s => {
                let before_s = last.time_s;
                return Err(format!(
                    "line {line}: `time_s` is {time_s} after {before_s}, expected times that do not decrease"
                ));
            }
            _ => estimates.push(estimate(time_s, branch)),
        }
    }
    if estimates.is_empty() {
        return Err("the file has no box, expected one in each line after the first".to_owned());
    }
    Ok(estimates)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const HEAD: &str = "time_s,x_min_m,x_max_m,y_min_m,y_max_m,heading_min_rad,heading_max_rad\n";

    #[test]
    fn lines_of_one_time_are_the_boxes_of_one_estimate_and_other_columns_are_left_alone() {
        let text = "note,time_s,x_min_m,x_max_m,y_min_m,y_max_m,heading_min_rad,heading_max_rad\n\
                    a,0.1,1,2,3,4,-0.5,0.5\nb,0.1,5,6,7,8,0,inf\nc,0.2,1,1,1,1,1,1\n";
        let read = boxes(text).unwrap();
        assert_eq!(
            read.iter().map(|one| (one.time_s, one.pose.branches.len())).collect::<Vec<_>>(),
            [(0.1, 2), (0.2, 1)]
        );
        assert_eq!(read[0].pose.branches[1][0], Interval::new(5.0, 6.0));
        assert_eq!(read[0].pose.branches[1][2], Interval::new(0.0, f64::INFINITY));
    }

    #[test]
    fn what_is_no_box_is_refused_with_line_column_and_what_was_expected() {
        for (text, told) in [
            ("time_s,x_min_m\n".to_owned(), "`x_max_m` is missing"),
            (HEAD.to_owned(), "no box"),
            (format!("{HEAD}0.1,1,2,3,4,0,here\n"), "line 2: `heading_max_rad` is \"here\", expected a number"),
            (format!("{HEAD}0.1,1,2,3,4,0,nan\n"), "line 2: `heading_max_rad`"),
            (format!("{HEAD}0.1,1,2,4,3,0,1\n"), "`y_min_m` is 4 and `y_max_m` is 3"),
            (format!("{HEAD}0.2,1,2,3,4,0,1\n0.1,1,2,3,4,0,1\n"), "line 3: `time_s` is 0.1 after 0.2"),
            (format!("{HEAD}inf,1,2,3,4,0,1\n"), "expected a finite time"),
            (format!("{HEAD}0.1,1,2\n"), "fields"),
        ] {
            let found = boxes(&text).unwrap_err();
            assert!(found.contains(told), "{found}");
        }
    }
}
