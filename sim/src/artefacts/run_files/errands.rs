//! The file `errands.csv`, which says what became of each errand of a run.

use std::fmt::Write;

use crate::{driver::ErrandLog, judge::true_distance_m, run::RunRecord};

/// One line for each errand; the field of an event that did not happen is empty.
pub(super) fn errands_csv(record: &RunRecord, log: &ErrandLog) -> String {
    let mut text = "errand,name,goal_x_m,goal_y_m,tolerance_m,outcome,began_s,ended_s,true_distance_m,\
                    estimated_distance_m,box_reach_m,plans,detours,waited_s\n"
        .to_owned();
    let shown = |value: Option<f64>| value.map(|value| format!("{value:.6}")).unwrap_or_default();
    for (index, errand) in log.errands.iter().enumerate() {
        let quoted = errand.name.replace('"', "\"\"");
        // Writing to a `String` cannot fail.
        let _ = writeln!(
            text,
            "{index},\"{quoted}\",{},{},{},{},{},{},{},{},{},{},{},{:.2}",
            errand.goal_m[0],
            errand.goal_m[1],
            errand.tolerance_m,
            errand.outcome.name(),
            shown(errand.began_s),
            shown(errand.ended_s),
            shown(true_distance_m(record, errand)),
            shown(errand.estimated_distance_m),
            shown(errand.box_reach_m),
            errand.plans,
            errand.detours,
            errand.waited_s,
        );
    }
    text
}
