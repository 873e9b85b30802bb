//! Merges the parts of a sweep that several machines ran.

use std::path::{Path, PathBuf};

use super::{
    Plan, Store, SweepError,
    store::{Recorded, read_case, read_plan},
};

/// Copies every recorded case of `folders`, which must hold parts of one sweep, into `store`, and returns the plan of the sweep.
///
/// A case that failed in one part and ran in another counts as run. Cases that no folder holds stay missing.
pub fn merge(folders: &[PathBuf], store: &Store) -> Result<Plan, SweepError> {
    let mut whole: Option<(PathBuf, Plan)> = None;
    for folder in folders {
        let plan = read_plan(folder)?.ok_or_else(|| SweepError::NoSweep { folder: folder.clone() })?;
        match &whole {
            None => whole = Some((folder.clone(), plan)),
            Some((first, agreed)) => expect_same("merge", (first, agreed), (folder, &plan))?,
        }
    }
    let Some((_, plan)) = whole else {
        return Err(SweepError::NoSweep { folder: store.folder().to_owned() });
    };
    store.write_plan(&plan)?;
    for id in &plan.cases {
        adopt(id, folders, store)?;
    }
    Ok(plan)
}

/// Copies a case from the first folder in which it ran, or else from one in which it failed.
fn adopt(id: &str, folders: &[PathBuf], store: &Store) -> Result<(), SweepError> {
    let ran = |folder: &Path| matches!(read_case(folder, id), Recorded::Done { .. });
    let (first, last): (Vec<&PathBuf>, Vec<&PathBuf>) = folders.iter().partition(|folder| ran(folder));
    for folder in first.into_iter().chain(last) {
        if store.adopt(id, folder)? {
            break;
        }
    }
    Ok(())
}

/// Refuses to join two folders, each with its plan, if they hold parts of different sweeps.
pub fn expect_same(join: &'static str, one: (&Path, &Plan), other: (&Path, &Plan)) -> Result<(), SweepError> {
    let ((one, plan), (other, other_plan)) = (one, other);
    difference(plan, other_plan).map_or(Ok(()), |what| {
        Err(SweepError::DifferentSweeps { join, one: one.to_owned(), other: other.to_owned(), what })
    })
}

/// Describes what differs between two plans; none when they are equal.
fn difference(one: &Plan, other: &Plan) -> Option<String> {
    let differ = |name: &str, one: String, other: String| (one != other).then(|| format!("{name}: {one} and {other}"));
    let keys = |plan: &Plan| {
        let each: Vec<String> =
            plan.vary.iter().map(|variable| format!("{} = {}", variable.key, variable.shown_values())).collect();
        if each.is_empty() { "nothing".to_owned() } else { each.join("; ") }
    };
    let seeds = |plan: &Plan| format!("{}..{}", plan.seeds[0], plan.seeds[1]);
    let optional = |text: &Option<String>| text.clone().unwrap_or_else(|| "none".to_owned());
    differ("scene", one.scene.clone(), other.scene.clone())
        .or_else(|| differ("what the scene states", one.scene_digest.clone(), other.scene_digest.clone()))
        .or_else(|| differ("what varies", keys(one), keys(other)))
        .or_else(|| differ("localizer", one.subject.clone(), other.subject.clone()))
        .or_else(|| differ("baselines", one.baselines.to_string(), other.baselines.to_string()))
        .or_else(|| differ("seeds", seeds(one), seeds(other)))
        .or_else(|| differ("version", one.version.clone(), other.version.clone()))
        .or_else(|| differ("program", optional(&one.program), optional(&other.program)))
        .or_else(|| differ("adapter", optional(&one.adapter), optional(&other.adapter)))
        .or_else(|| (one.cases != other.cases).then(|| "cases".to_owned()))
}
