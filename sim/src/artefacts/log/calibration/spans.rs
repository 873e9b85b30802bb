//! The rows that a log gives for the constants of wheels, gyroscope and antenna: what was read in each span of the drive, and the true motion in it.

use std::f64::consts::TAU;

use localizer::{Reading, calibration::constants::Span, methods::gnss_positions::Position};

use super::super::{open_log::OpenLog, truth::TruePath};

/// Rows for the radii of both wheels and half the track, in metres: φ_L·r_L + θ·b/2 = d and φ_R·r_R − θ·b/2 = d for the wheels' angles φ, the robot's
/// way d and its turn θ. A third row says that the robot does not move aside, whatever the constants: it tells a span in which the robot was pushed.
pub(super) fn of_wheels(log: &OpenLog<'_>, truth: &TruePath, span_s: f64) -> Vec<Span<3>> {
    let per_tick_rad = TAU / f64::from(log.told.robot.encoders.ticks_per_turn);
    let angles: Vec<(f64, [f64; 2])> = log
        .motion
        .readings
        .iter()
        .filter_map(|reading| match reading {
            Reading::Wheels { measured_s, ticks, .. } => {
                Some((*measured_s, ticks.map(|count| count as f64 * per_tick_rad)))
            }
            _ => None,
        })
        .collect();
    let mut spans = Vec::new();
    for [from, to] in apart(&angles, |(at_s, _)| *at_s, span_s) {
        let [(from_s, begins), (to_s, ends)] = [angles[from], angles[to]];
        let is_doubted = log.motion.excesses.iter().any(|one| one.span_s[0] < to_s && from_s < one.span_s[1]);
        let Some([way_m, aside_m, turn_rad]) = truth.travelled(from_s, to_s).filter(|_| !is_doubted) else { continue };
        let [left_rad, right_rad] = [ends[0] - begins[0], ends[1] - begins[1]];
        let rows = vec![([left_rad, 0.0, turn_rad], way_m), ([0.0, right_rad, -turn_rad], way_m), ([0.0; 3], aside_m)];
        spans.push(Span { span_s: [from_s, to_s], rows });
    }
    spans
}

/// Rows for the gyroscope's scale and bias, in radians: θ·scale + T·bias = Σ rate·period over a span of the length T with the true turn θ.
pub(super) fn of_gyro(log: &OpenLog<'_>, truth: &TruePath, period_s: f64, span_s: f64) -> Vec<Span<2>> {
    let rates: Vec<(f64, f64)> = log
        .motion
        .readings
        .iter()
        .filter_map(|reading| match reading {
            Reading::Gyro { measured_s, rate_rad_per_s, .. } => Some((*measured_s, *rate_rad_per_s)),
            _ => None,
        })
        .collect();
    let mut spans = Vec::new();
    for [from, to] in apart(&rates, |(at_s, _)| *at_s, span_s) {
        let (from_s, to_s) = (rates[from].0, rates[to].0);
        // Where readings are missing, their sum is not the angle.
        let is_whole = ((to_s - from_s) / period_s - (to - from) as f64).abs() < 0.5;
        let Some([_, _, turn_rad]) = truth.travelled(from_s, to_s).filter(|_| is_whole) else { continue };
        let read_rad: f64 = rates[from + 1..=to].iter().map(|(_, rate)| rate * period_s).sum();
        spans.push(Span { span_s: [from_s, to_s], rows: vec![([turn_rad, to_s - from_s], read_rad)] });
    }
    spans
}

/// Rows for the antenna's place forward and to the left, in metres: R(θ)·place = position read − true position. Only positions of the quality `fixed`
/// are used.
pub(super) fn of_antenna(log: &OpenLog<'_>, truth: &TruePath) -> Vec<Span<2>> {
    let position = |reading: &Reading| {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let (told, pose) = (Position::of(numbers).filter(|told| told.is_fixed)?, truth.at(*measured_s)?);
        let (sin, cos) = pose.heading_rad.sin_cos();
        let rows = vec![([cos, -sin], told.at_m[0] - pose.x_m), ([sin, cos], told.at_m[1] - pose.y_m)];
        Some(Span { span_s: [*measured_s; 2], rows })
    };
    log.positions.iter().filter_map(position).collect()
}

/// First and last place of spans that follow each other, each at least `span_s` long.
fn apart<T>(values: &[T], at_s: impl Fn(&T) -> f64, span_s: f64) -> Vec<[usize; 2]> {
    let (mut spans, mut from) = (Vec::new(), 0);
    for to in 0..values.len() {
        if at_s(&values[to]) - at_s(&values[from]) >= span_s - 1e-9 {
            spans.push([from, to]);
            from = to;
        }
    }
    spans
}
