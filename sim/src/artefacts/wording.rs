//! Quantities in words, each with its unit, as reports show them.

use localizer::bounds;

/// A value with four significant digits.
pub(crate) fn significant(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse::<f64>().unwrap_or(value);
    rounded.to_string()
}

/// A value of the quantity that a declared bound limits, with the bound's unit, or a thousandth of it where the value is small; shares and counts
/// have none.
pub(crate) fn of_bound(bound: &str, value: f64) -> String {
    let unit = bounds::ALL.iter().find(|one| one.name == bound).map_or("1", |one| one.unit);
    match unit {
        "1" => significant(value),
        "m" if value.abs() < 0.1 => format!("{} mm", significant(1e3 * value)),
        "rad" if value.abs() < 0.1 => format!("{} mrad", significant(1e3 * value)),
        _ => format!("{} {unit}", significant(value)),
    }
}

/// How far the truth is outside of the boxes, along the axis that a verdict names.
pub(crate) fn outside_by(axis: &str, margin: f64) -> String {
    match axis {
        "x_m" => format!("x by {:.3} mm", 1e3 * margin),
        "y_m" => format!("y by {:.3} mm", 1e3 * margin),
        "heading_rad" => format!("heading by {:.4}°", margin.to_degrees()),
        other => other.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_their_units() {
        assert_eq!(of_bound(bounds::WHEELS_SLIP, 0.1 + 0.2), "0.3 m");
        assert_eq!(of_bound(bounds::WHEELS_SLIP, 0.000_276_24), "0.2762 mm");
        assert_eq!(of_bound(bounds::BODY_TILT, 0.002_26), "2.26 mrad");
        assert_eq!(of_bound(bounds::RANGE_LANDMARKS_Q_ITEMS, 2.0), "2");
        assert_eq!(outside_by("x_m", 0.012_345_6), "x by 12.346 mm");
        assert_eq!(outside_by("heading_rad", std::f64::consts::PI / 180.0), "heading by 1.0000°");
        assert_eq!(outside_by("between branches", 0.0), "between branches");
    }
}
