//! The chart of a film: how wide what the localizer states is and how far its middle is from the truth, over the time of the run.

use localizer::Pose;

use crate::run::RunRecord;

use super::super::{
    canvas::{Canvas, Panel},
    palette,
};

/// Number of times, equally spaced over the run, at which the chart has a value.
const MOST_VALUES: usize = 400;
const TEXT_PX: f32 = 13.0;
/// Space for the labels at the left.
const LABELS_PX: f64 = 54.0;
/// Widths beyond these are not told apart: a tenth of a millimetre and ten metres.
const DECADES: [f64; 2] = [-4.0, 1.0];

/// Length at the upper edge of a chart without any.
const LONGEST_M: f64 = 0.1;

/// Widths and errors of a run, each at its time.
pub(super) struct Widths {
    values: Vec<Value>,
    lasts_s: f64,
    /// Powers of ten, in metres, between which all widths lie.
    decades: [f64; 2],
}

struct Value {
    time_s: f64,
    /// Full width along x or y, whichever is greater; `None` where nothing with a width is stated.
    width_m: Option<f64>,
    /// Distance of the middle from the true position; `None` where no pose is left.
    error_m: Option<f64>,
}

/// One of the lengths of a value.
type Length = fn(&Value) -> Option<f64>;

/// Full widths in x, y and heading of what the localizer states at a step: of the box around its boxes, or of the intervals that hold 95 % of its
/// distribution; `None` for a point, or where no pose is left.
pub(super) fn widths_at(record: &RunRecord, step: usize) -> Option<[f64; 3]> {
    if let Some(stated) = record.stated.get(step)? {
        return stated.spread.as_ref().map(|spread| spread.width_95);
    }
    let hull = record.estimates.get(step).filter(|_| record.has_boxes)?.pose.hull();
    (!hull.is_empty()).then(|| [0, 1, 2].map(|axis| hull.width(axis)))
}

/// Middle of what the localizer states at a step; `None` where no pose is left.
pub(super) fn middle_at(record: &RunRecord, step: usize) -> Option<Pose> {
    let hull = record.estimates.get(step)?.pose.hull();
    let [x_m, y_m, heading_rad] = hull.midpoint();
    let middle = Pose { x_m, y_m, heading_rad };
    (!hull.is_empty() && middle.to_array().iter().all(|value| value.is_finite())).then_some(middle)
}

/// Distance between the positions of two poses.
pub(super) fn distance_m(one: Pose, other: Pose) -> f64 {
    (one.x_m - other.x_m).hypot(one.y_m - other.y_m)
}

impl Widths {
    /// The widths and errors of a run.
    pub(super) fn of(record: &RunRecord) -> Widths {
        let every = record.truths.len().div_ceil(MOST_VALUES).max(1);
        let of_step = |step: usize| Value {
            time_s: record.truths[step].time_s,
            width_m: widths_at(record, step).map(|[x_m, y_m, _]| x_m.max(y_m)),
            error_m: middle_at(record, step).map(|middle| distance_m(middle, record.truths[step].pose)),
        };
        let values: Vec<Value> = (0..record.truths.len()).step_by(every).map(of_step).collect();
        let lengths = values.iter().flat_map(|value| [value.width_m, value.error_m]).flatten();
        let mut shown: Vec<f64> = lengths.filter(|length_m| *length_m > 0.0 && length_m.is_finite()).collect();
        shown.sort_by(f64::total_cmp);
        // One length in fifty is at the lower edge, such as the errors about a zero crossing, which would make the others a line at the top.
        let low = shown.get(shown.len() / 50).copied().unwrap_or(LONGEST_M).log10().floor();
        let high = shown.last().copied().unwrap_or(LONGEST_M).log10().ceil();
        let low = low.clamp(DECADES[0], DECADES[1] - 1.0);
        let decades = [low, high.clamp(low + 1.0, DECADES[1])];
        Widths { lasts_s: record.truths.last().map_or(0.0, |truth| truth.time_s), values, decades }
    }

    /// Draws the chart up to a time of the run.
    pub(super) fn draw(&self, canvas: &mut Canvas, panel: Panel, until_s: f64) {
        let plot = Panel { left_px: panel.left_px + LABELS_PX, width_px: panel.width_px - LABELS_PX, ..panel };
        let [low, high] = self.decades;
        let height_at = |length_m: f64| {
            let share = (length_m.max(1e-9).log10() - low) / (high - low);
            plot.top_px + plot.height_px * (1.0 - share.clamp(0.0, 1.0))
        };
        let across = |time_s: f64| plot.left_px + plot.width_px * (time_s / self.lasts_s.max(1e-9)).min(1.0);
        let right_px = plot.left_px + plot.width_px;
        for decade in (low as i32)..=(high as i32) {
            let at_px = height_at(10_f64.powi(decade)).round();
            canvas.line([plot.left_px, at_px], [right_px, at_px], 1.0, palette::JOINT);
            let label = of_decade(decade);
            let label_px = plot.left_px - 6.0 - Canvas::text_width_px(TEXT_PX, label);
            canvas.text([label_px, at_px - 8.0], TEXT_PX, palette::FAINT_INK, label);
        }
        let told: Vec<&Value> = self.values.iter().filter(|value| value.time_s <= until_s).collect();
        let curves: [(Length, _); 2] = [(|value| value.error_m, palette::TRUTH), (|value| value.width_m, palette::BOX)];
        for (of, colour) in curves {
            for pair in told.windows(2) {
                if let (Some(from_m), Some(to_m)) = (of(pair[0]), of(pair[1])) {
                    let ends = [(pair[0], from_m), (pair[1], to_m)].map(|(at, m)| [across(at.time_s), height_at(m)]);
                    canvas.line(ends[0], ends[1], 1.6, colour);
                }
            }
        }
        let now_px = across(until_s.min(self.lasts_s)).round();
        canvas.line([now_px, plot.top_px], [now_px, plot.top_px + plot.height_px], 1.0, palette::FAINT_INK);
    }
}

/// A power of ten of a metre in the unit in which it is said.
fn of_decade(decade: i32) -> &'static str {
    match decade {
        ..=-4 => "0.1 mm",
        -3 => "1 mm",
        -2 => "1 cm",
        -1 => "10 cm",
        0 => "1 m",
        1.. => "10 m",
    }
}
