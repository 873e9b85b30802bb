//! The figures of a run: every number of a summary under its dotted name. Expectations limit them, and result tables show them.

use std::collections::BTreeMap;

use serde_json::Value;

/// Figures by dotted name, such as `error.x_m.rmse`.
pub type Figures = BTreeMap<String, f64>;

/// All figures of `summary`, and those derived from them: `containment.contained_share`; a `rmse_worst_third` for each `rmse_by_third`; and
/// `violations`, the number of violations.
pub fn figures(summary: &Value) -> Figures {
    let mut figures = Figures::new();
    flatten(summary, String::new(), &mut figures);
    if let (Some(contained), Some(checks)) = (figures.get("containment.contained"), figures.get("containment.checks")) {
        // A run in which no step was checked has shown nothing, so that its share is 0.
        let share = if *checks > 0.0 { contained / checks } else { 0.0 };
        figures.insert("containment.contained_share".to_owned(), share);
    }
    figures
}

fn flatten(value: &Value, name: String, figures: &mut Figures) {
    match value {
        Value::Object(entries) => {
            for (key, entry) in entries {
                flatten(entry, if name.is_empty() { key.clone() } else { format!("{name}.{key}") }, figures);
            }
        }
        Value::Array(items) => list(items, name, figures),
        Value::Number(number) => {
            figures.insert(name, number.as_f64().unwrap_or(f64::NAN));
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

fn list(items: &[Value], name: String, figures: &mut Figures) {
    if name == "violations" {
        figures.insert(name, items.len() as f64);
        return;
    }
    for (index, item) in items.iter().enumerate() {
        flatten(item, format!("{name}.{}", index + 1), figures);
    }
    if let Some(stem) = name.strip_suffix("_by_third") {
        let thirds = items.iter().map(|item| item.as_f64().unwrap_or(f64::NAN));
        // `f64::max` would ignore a NaN, but a third of the run without a figure must not pass as a good one: there is no worst third then.
        let worst = thirds.fold(f64::NEG_INFINITY, |worst, third| if third <= worst { worst } else { third });
        if !worst.is_nan() {
            figures.insert(format!("{stem}_worst_third"), worst);
        }
    }
}
