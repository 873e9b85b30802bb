//! The answers that a process under test writes, one line of JSON each.

use serde::Deserialize;

use crate::subject::{Answer, ForeignAnswer, newest_stamp};

/// Greatest difference between the time that an answer names and the time for which it was asked: far less than the millisecond by which times of the
/// simulation differ, and more than any printing of decimals loses.
const SAME_S: f64 = 1e-6;
/// Number of characters of a line that a message about it shows.
const SHOWN: usize = 80;

/// One line of a process, with one of the four kinds of answers.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    time_s: f64,
    newest_s: Option<f64>,
    mean: Option<[f64; 3]>,
    covariance: Option<[[f64; 3]; 3]>,
    samples: Option<Vec<[f64; 4]>>,
    boxes: Option<Vec<[[f64; 2]; 3]>>,
    status: Option<BoxStatus>,
    relies_on: Option<Vec<String>>,
    pose: Option<[f64; 3]>,
}

/// Whether an answer in boxes relies on its declared assumptions alone.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BoxStatus {
    Sound,
    Recovering,
}

/// Reads the answer for `time_s` from a line, and the stamp of the newest reading in it, if it is told. The error says what is wrong with the line and
/// what was expected.
pub(super) fn read(line: &[u8], time_s: f64) -> Result<(Answer, Option<f64>), String> {
    let line: Line = serde_json::from_slice(line).map_err(|error| refusal(line, &error))?;
    if (line.time_s - time_s).abs() > SAME_S {
        let when = if line.time_s > time_s { "the future" } else { "the past" };
        return Err(format!("it answered for {when}: `time_s` is {}, expected {time_s} as asked", line.time_s));
    }
    let newest_s = newest_stamp(line.newest_s, time_s).map_err(|reason| format!("it answered with {reason}"))?;
    let answer = match line {
        Line { mean: Some(mean), covariance: Some(covariance), samples: None, boxes: None, pose: None, .. } => {
            ForeignAnswer::Gaussian { mean, covariance }
        }
        Line { samples: Some(samples), mean: None, covariance: None, boxes: None, pose: None, .. } => {
            ForeignAnswer::Samples(samples)
        }
        Line {
            boxes: Some(boxes), status, relies_on, mean: None, covariance: None, samples: None, pose: None, ..
        } => {
            let is_recovering = matches!(status, Some(BoxStatus::Recovering));
            ForeignAnswer::Boxes { boxes, is_recovering, relies_on }
        }
        Line { pose: Some(pose), mean: None, covariance: None, samples: None, boxes: None, .. } => {
            ForeignAnswer::Point(pose)
        }
        _ => {
            return Err(
                "it wrote an answer of no kind or of two, expected `time_s` and one of `mean` with `covariance`, \
                        `samples`, `boxes`, `pose`"
                    .to_owned(),
            );
        }
    };
    let answer = answer.checked(time_s).map_err(|reason| format!("it answered with {reason}"))?;
    Ok((answer, newest_s))
}

/// What is wrong with a line that does not have the form of an answer.
fn refusal(line: &[u8], error: &serde_json::Error) -> String {
    let text = String::from_utf8_lossy(line);
    let visible = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    let mut shown: String = text.trim_end().chars().take(SHOWN).map(visible).collect();
    if text.trim_end().chars().count() > SHOWN {
        shown += "…";
    }
    // JSON has none of these, but some programs write them.
    let mut words = text.split(|c: char| !c.is_alphanumeric());
    if words.any(|word| ["NaN", "nan", "Infinity", "inf"].contains(&word)) {
        return format!("it answered with a number that is not finite, expected finite numbers: `{shown}`");
    }
    format!("it wrote `{shown}`, expected an answer in JSON: {error}")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::TAU;

    use localizer::{Pose, Status, bounds};

    use super::*;
    use crate::subject::{GaussianPose, WeightedPose, foreign_answer::turned_to};

    fn pose([x_m, y_m, heading_rad]: [f64; 3]) -> Pose {
        Pose { x_m, y_m, heading_rad }
    }

    fn answer(rest: &str) -> Result<Answer, String> {
        read(format!("{{\"time_s\": 1.25, {rest}}}\n").as_bytes(), 1.25).map(|(answer, _)| answer)
    }

    /// The message about an answer that has to be refused.
    fn refused(rest: &str) -> String {
        answer(rest).unwrap_err()
    }

    #[test]
    fn each_kind_of_answer_is_read_as_it_is_written() {
        let gaussian = answer("\"mean\": [1, 2, 3], \"covariance\": [[4, 0, 1], [0, 5, 0], [1, 0, 6]]").unwrap();
        let covariance = [[4.0, 0.0, 1.0], [0.0, 5.0, 0.0], [1.0, 0.0, 6.0]];
        assert_eq!(gaussian, Answer::Gaussian(GaussianPose { mean: pose([1.0, 2.0, 3.0]), covariance }));
        let samples = answer("\"samples\": [[1, 2, 3, 0.5], [4, 5, 6, 0]]").unwrap();
        let sample = |at, weight| WeightedPose { pose: pose(at), weight };
        let expected = vec![sample([1.0, 2.0, 3.0], 0.5), sample([4.0, 5.0, 6.0], 0.0)];
        assert_eq!(samples, Answer::Samples(expected));
        assert_eq!(answer("\"pose\": [1, 2, 3]").unwrap(), Answer::Point(pose([1.0, 2.0, 3.0])));
        let boxes = answer(
            "\"boxes\": [[[1, 2], [3, 4], [5, 6]], [[7, 7], [8, 9], [0, 1]]], \"status\": \"recovering\", \
             \"relies_on\": [\"wheels.slip\"]",
        );
        let Answer::Boxes(estimate) = boxes.unwrap() else { unreachable!() };
        assert_eq!((estimate.time_s, estimate.status), (1.25, Status::Recovering));
        assert_eq!(estimate.relies_on, [bounds::WHEELS_SLIP]);
        assert_eq!(estimate.pose.branches.len(), 2);
        assert!(estimate.pose.contains(pose([1.5, 3.5, 5.5])) && estimate.pose.contains(pose([7.0, 8.5, 0.5])));
        assert!(!estimate.pose.contains(pose([5.0, 5.0, 3.0])));
    }

    #[test]
    fn an_answer_may_tell_its_newest_reading() {
        let newest_s = |rest: &str| read(format!("{{\"time_s\": 1.25, \"pose\": [1, 2, 3]{rest}}}").as_bytes(), 1.25);
        assert_eq!(newest_s(", \"newest_s\": 1.2").unwrap().1, Some(1.2));
        assert_eq!(newest_s("").unwrap().1, None);
        // A stamp in milliseconds is none in seconds.
        let refused = newest_s(", \"newest_s\": 1200.0").unwrap_err();
        assert!(refused.contains("the newest_s 1200, expected the stamp of a reading in seconds"), "{refused}");
    }

    #[test]
    fn headings_are_taken_at_the_turn_nearest_to_the_answer_before() {
        // From 3.1 rad on, the robot turns a little to the left, and its process wraps the heading to just above −π.
        let headings = |rest: &str| {
            let Answer::Boxes(estimate) = turned_to(answer(rest).unwrap(), 3.1) else { unreachable!() };
            estimate.pose.branches.iter().map(|branch| branch[2].mid()).collect::<Vec<_>>()
        };
        let found = headings("\"boxes\": [[[0, 0], [0, 0], [-3.2, -3.0]], [[0, 0], [0, 0], [3.0, 3.4]]]");
        assert!((found[0] - (TAU - 3.1)).abs() < 1e-12 && (found[1] - 3.2).abs() < 1e-12, "{found:?}");
        let point = turned_to(Answer::Point(pose([1.0, 2.0, 3.0 - 2.0 * TAU])), 3.1);
        let Answer::Point(point) = point else { unreachable!() };
        assert!((point.heading_rad - 3.0).abs() < 1e-12 && point.x_m == 1.0);
    }

    #[test]
    fn boxes_without_names_rely_on_every_bound() {
        let Answer::Boxes(estimate) = answer("\"boxes\": [[[1, 2], [3, 4], [5, 6]]]").unwrap() else { unreachable!() };
        assert_eq!((estimate.status, estimate.relies_on.len()), (Status::Sound, bounds::ALL.len()));
    }

    #[test]
    fn a_line_that_is_no_answer_is_refused_by_what_is_wrong() {
        for (rest, said) in [
            ("\"mean\": [1, 2, 3]", "no kind"),
            ("\"pose\": [1, 2, 3], \"samples\": [[1, 2, 3, 1]]", "of two"),
            ("\"pose\": [1, 2]", "invalid length 2"),
            ("\"pose\": [1, 2, NaN]", "not finite"),
            ("\"pose\": [1, 2, null]", "invalid type: null"),
            ("\"poses\": [1, 2, 3]", "unknown field `poses`"),
            ("\"samples\": []", "no `samples`"),
            ("\"samples\": [[1, 2, 3, 0]]", "add up to 0"),
            ("\"samples\": [[1, 2, 3, -1]]", "weight -1"),
            ("\"boxes\": []", "at least one"),
            ("\"boxes\": [[[2, 1], [3, 4], [5, 6]]]", "[2, 1]"),
            ("\"boxes\": [[[1, 2], [3, 4], [5, 6]]], \"relies_on\": [\"luck\"]", "`luck`"),
        ] {
            assert!(refused(rest).contains(said), "{rest}: {}", refused(rest));
        }
        assert!(read(b"info: nanny", 0.0).unwrap_err().contains("`info: nanny`, expected an answer"));
        assert!(read(b"\xff\x07\n", 0.0).unwrap_err().contains("\\u{7}"));
        let long = read(&[b'x'; 5000], 0.0).unwrap_err();
        assert!(long.len() < 200 && long.contains('…'), "{long}");
    }

    #[test]
    fn a_matrix_that_is_no_covariance_is_refused() {
        // [[1, 2], [2, 1]] has the eigenvalues 3 and −1.
        let negative = "[[1, 2, 0], [2, 1, 0], [0, 0, 1]]";
        assert!(refused(&format!("\"mean\": [0, 0, 0], \"covariance\": {negative}")).contains("-1e0"));
        let lopsided = "[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]";
        assert!(refused(&format!("\"mean\": [0, 0, 0], \"covariance\": {lopsided}")).contains("not symmetric"));
        // A covariance may be singular, as where a filter is told its start exactly, and the rounding of f32 leaves it a little below.
        for sound in ["[[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "[[1, 1.0000001, 0], [1.0000001, 1, 0], [0, 0, 1]]"] {
            assert!(answer(&format!("\"mean\": [0, 0, 0], \"covariance\": {sound}")).is_ok(), "{sound}");
        }
    }

    #[test]
    fn the_time_that_an_answer_names_is_the_one_that_was_asked() {
        let at = |time: &str| read(format!("{{\"time_s\": {time}, \"pose\": [0, 0, 0]}}").as_bytes(), 1.25);
        assert!(at("1.25").is_ok() && at("1.2500000001").is_ok());
        assert!(at("1.26").unwrap_err().contains("the future: `time_s` is 1.26, expected 1.25"));
        assert!(at("1.24").unwrap_err().contains("the past"));
    }
}
