//! The few numerical results, such as mean width and error, that a report shows for every combination of settings.

use crate::judge::figures::Figures;

/// A numerical result as a report shows it, with a name, a unit and an explanation for people.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Name of the shown result on the command line.
    pub key: &'static str,
    /// Name of the shown result in tables.
    pub name: &'static str,
    /// Unit of the shown result.
    pub unit: &'static str,
    /// One sentence that explains the shown result.
    pub meaning: &'static str,
    /// Function that computes the shown result, in its unit, from the recorded results of one run or pooled results of several.
    pub value: fn(&Figures) -> Option<f64>,
    /// Number of digits of the shown result behind the decimal point.
    pub digits: usize,
}

/// All results that a report shows: the share of steps with the truth in the box, widths of the boxes, errors of their midpoints, availability, the
/// ratio of error to half width, normalised error and calibration of distributions, and goals reached on errands.
pub const MEASURES: [Measure; 13] = [
    Measure {
        key: "contained",
        name: "contained",
        unit: "%",
        meaning: "share of steps of 10 ms with the truth in the box",
        value: |figures| scaled(figures, "containment.contained_share", 1e2),
        digits: 2,
    },
    Measure {
        key: "width",
        name: "width",
        unit: "mm",
        meaning: "mean full width of the box, the wider of x and y",
        value: |figures| {
            let along = |axis: &str| scaled(figures, &format!("width.{axis}.mean"), 1e3);
            Some(along("x_m")?.max(along("y_m")?))
        },
        digits: 1,
    },
    Measure {
        key: "error",
        name: "error",
        unit: "mm",
        meaning: "mean distance from the midpoint of the box to the truth",
        value: |figures| scaled(figures, "error.position_m.mean", 1e3),
        digits: 2,
    },
    Measure {
        key: "available",
        name: "available",
        unit: "%",
        meaning: "share of steps that are sound, hold the truth and are narrower than the scene declares",
        value: |figures| scaled(figures, "availability", 1e2),
        digits: 2,
    },
    Measure {
        key: "power_x",
        name: "x error / half",
        unit: "max after 5 s",
        meaning: "greatest error along x over half the width after 5 s: at 0.5 boxes half as wide had held the truth",
        value: |figures| scaled(figures, "power.after_5_s.x_m.max", 1.0),
        digits: 2,
    },
    Measure {
        key: "power_x_often",
        name: "x error / half",
        unit: "99.9 % after 5 s",
        meaning: "what one step in a thousand exceeds of the error along x over half the width after 5 s, in the run where that is greatest",
        value: |figures| scaled(figures, "power.after_5_s.x_m.p999", 1.0),
        digits: 2,
    },
    Measure {
        key: "power_y",
        name: "y error / half",
        unit: "max after 5 s",
        meaning: "greatest error along y over half the width after 5 s: at 0.5 boxes half as wide had held the truth",
        value: |figures| scaled(figures, "power.after_5_s.y_m.max", 1.0),
        digits: 2,
    },
    Measure {
        key: "power_y_often",
        name: "y error / half",
        unit: "99.9 % after 5 s",
        meaning: "what one step in a thousand exceeds of the error along y over half the width after 5 s, in the run where that is greatest",
        value: |figures| scaled(figures, "power.after_5_s.y_m.p999", 1.0),
        digits: 2,
    },
    Measure {
        key: "power_heading",
        name: "heading error / half",
        unit: "max after 5 s",
        meaning: "greatest error along heading over half the width after 5 s: at 0.5 boxes half as wide had held the truth",
        value: |figures| scaled(figures, "power.after_5_s.heading_rad.max", 1.0),
        digits: 2,
    },
    Measure {
        key: "power_heading_often",
        name: "heading error / half",
        unit: "99.9 % after 5 s",
        meaning: "what one step in a thousand exceeds of the error along heading over half the width after 5 s, in the run where that is greatest",
        value: |figures| scaled(figures, "power.after_5_s.heading_rad.p999", 1.0),
        digits: 2,
    },
    Measure {
        key: "nees",
        name: "NEES",
        unit: "mean",
        meaning: "mean normalised error squared of the stated distribution: 3 is right, more is overconfident",
        value: |figures| scaled(figures, "distribution.nees.mean", 1.0),
        digits: 1,
    },
    Measure {
        key: "in_3_sigma",
        name: "in 3σ",
        unit: "%",
        meaning: "share of steps with the truth within three stated standard deviations along x, y and heading",
        value: |figures| scaled(figures, "distribution.within_3_sigma_share", 1e2),
        digits: 2,
    },
    Measure {
        key: "goals",
        name: "goals",
        unit: "%",
        meaning: "share of the errands' goals that were reached",
        value: |figures| {
            let errands = figures.get("metrics.errands").filter(|errands| **errands > 0.0)?;
            Some(scaled(figures, "metrics.goals_reached", 1e2)? / errands)
        },
        digits: 1,
    },
];

impl Measure {
    /// Whether the result says how much of the boxes the errors use, which few readers need first.
    pub(super) fn is_detail(&self) -> bool {
        self.name.ends_with("/ half")
    }

    /// Name and unit of the shown result, as the heading of a column.
    pub(super) fn heading(&self) -> String {
        format!("{}, {}", self.name, self.unit)
    }

    /// Formats a value of the shown result. A share is shown as 100 % only when it is complete.
    pub fn show(&self, value: Option<f64>) -> String {
        let Some(value) = value else { return String::new() };
        let digits = self.digits;
        match self.unit {
            "%" if value >= 100.0 => "100".to_owned(),
            "%" => {
                let text = format!("{value:.digits$}");
                if text.starts_with("100") { "99.99".to_owned() } else { text }
            }
            _ => format!("{value:.digits$}"),
        }
    }

    /// Formats the shown result that follows from the recorded results `figures`.
    pub fn of(&self, figures: &Figures) -> String {
        self.show((self.value)(figures))
    }
}

fn scaled(figures: &Figures, name: &str, scale: f64) -> Option<f64> {
    Some(figures.get(name)? * scale)
}
