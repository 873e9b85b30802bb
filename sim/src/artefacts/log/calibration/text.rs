//! What the terminal shows of a calibration.

use std::fmt::Write;

use localizer::calibration::TOLERATED_DEVIATIONS;

use super::DriveCalibration;

/// Number of spans that are listed one by one.
const MOST_LISTED: usize = 8;

impl DriveCalibration {
    /// What the terminal shows.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if !self.constants.is_empty() {
            let _ =
                writeln!(text, "{:<28} {:>5} {:>12} {:>12} {:>12}", "constant", "unit", "declared", "found", "± 3 σ");
        }
        for one in &self.constants {
            let within = TOLERATED_DEVIATIONS * one.deviation;
            let _ = writeln!(
                text,
                "{:<28} {:>5} {:>12.6} {:>12.6} {:>12.6}",
                one.name, one.unit, one.declared, one.value, within
            );
        }
        for one in &self.unknown {
            let _ = writeln!(text, "unknown: {one}");
        }
        if !self.set_aside.is_empty() {
            let n_aside = self.set_aside.len();
            let _ = writeln!(
                text,
                "\n{n_aside} spans fit no constants and are set aside; bounds do not cover what acted there:"
            );
        }
        for one in self.set_aside.iter().take(MOST_LISTED) {
            let ([from_s, to_s], unit) = (one.span_s, if one.what == "gyroscope" { "rad" } else { "m" });
            let _ = writeln!(text, "  {}, {from_s:.3} s to {to_s:.3} s: off by {:.4} {unit}", one.what, one.off);
        }
        if self.set_aside.len() > MOST_LISTED {
            let _ = writeln!(text, "  and {} more, which --json lists", self.set_aside.len() - MOST_LISTED);
        }
        if !self.bounds.is_empty() {
            let _ =
                writeln!(text, "\n{:<34} {:>12} {:>16} {:>12}", "bound", "declared", "least it keeps", "to declare");
        }
        for one in &self.bounds {
            let least = one.least.map_or("no value".to_owned(), |least| format!("{least:.6}"));
            let _ = writeln!(text, "{:<34} {:>12.6} {:>16} {:>12.6}", one.key, one.declared, least, one.value);
        }
        text
    }
}
