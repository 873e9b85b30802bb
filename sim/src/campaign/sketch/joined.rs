//! Tables of results that are reported on together: each case counts once, as in a merger of the folders with the tables.

use std::{
    collections::{BTreeSet, HashMap},
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use crate::campaign::{
    cases::{Cell, PARTS, table_files},
    sweep::{Plan, SweepError, expect_same, read_plan},
};

use super::{kept::Origin, tally::Columns};

/// What became of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Status {
    /// The case ran.
    Ran,
    /// The case could not run.
    Failed,
    /// The case has not run.
    Missing,
}

/// A file with a table of results.
#[derive(Debug)]
pub(super) struct TableFile {
    pub(super) file: PathBuf,
    pub(super) origin: Origin,
    /// Whether the cases belong to the plan of a sweep, which lies beside the table.
    is_of_plan: bool,
    /// The status of rows that were met when it was not their turn.
    pub(super) postponed: BTreeSet<Status>,
}

/// The cases of several tables, and which of them have been counted.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// The plan that all parts of a sweep agree on, with the folder of the first of them.
    plan: Option<(PathBuf, Plan)>,
    /// Whether each case has been counted: every case of the plan, and those of tables without a plan that were met.
    is_counted: HashMap<Key, bool>,
    /// The case that none of the tables may have, with its table.
    other: Option<(PathBuf, String)>,
}

/// Beginning of the digest of a case's name, or of all of its row if it has no name. Among a million cases two have the same one with a probability
/// of 4·10⁻¹³, and their keys take about 25 MB.
type Key = [u8; 10];

impl Status {
    /// All of them: in which order the rows of tables are counted, so that a case counts as run wherever it ran.
    pub(super) const ALL: [Status; 3] = [Status::Ran, Status::Failed, Status::Missing];

    fn of(text: &str) -> Status {
        match text {
            "failed" => Status::Failed,
            "missing" => Status::Missing,
            _ => Status::Ran,
        }
    }
}

impl Joined {
    /// Finds the tables of files and folders, and the plan of the sweep whose parts they are.
    pub(super) fn of(paths: &[PathBuf]) -> Result<(Joined, Vec<TableFile>), SweepError> {
        let mut joined = Joined::default();
        let mut tables: Vec<TableFile> = Vec::new();
        for path in paths {
            for file in table_files(path)? {
                let folder = folder_of(&file);
                // A plan may have a million cases, so that it is read once for all tables of a folder.
                let (scene_path, is_of_plan) = match tables.last() {
                    Some(last) if last.origin.folder == folder => (last.origin.scene_path.clone(), last.is_of_plan),
                    _ => match joined.agreed(&folder)? {
                        Some(scene_path) => (scene_path, true),
                        None => (PathBuf::new(), false),
                    },
                };
                let origin = Origin { folder, scene_path };
                tables.push(TableFile { file, origin, is_of_plan, postponed: BTreeSet::new() });
            }
        }
        Ok((joined, tables))
    }

    /// Reads the plan in a folder, which has to be that of the folders before, and returns the path of its scene; none where the folder has no plan.
    fn agreed(&mut self, folder: &Path) -> Result<Option<PathBuf>, SweepError> {
        let Some(plan) = read_plan(folder)? else { return Ok(None) };
        let scene_path = plan.path.clone();
        match &self.plan {
            Some((first, agreed)) => expect_same("report on", (first, agreed), (folder, &plan))?,
            None => {
                self.is_counted.extend(plan.cases.iter().map(|id| (key_of_name(id), false)));
                self.plan = Some((folder.to_owned(), plan));
            }
        }
        Ok(Some(scene_path))
    }

    /// Whether a row is to be counted now that it is the turn of cases of the status `now`. Its case is not counted again then.
    pub(super) fn takes(&mut self, table: &mut TableFile, now: Status, columns: &Columns<'_>, row: &[Cell]) -> bool {
        let id = columns.text(row, "case");
        let key = if id.is_empty() { key_of_row(columns, row) } else { key_of_name(id) };
        let known = self.is_counted.get_mut(&key);
        if known.is_none() && table.is_of_plan {
            // The table is older than the plan beside it.
            return false;
        }
        if known.is_none() && self.plan.is_some() && !id.is_empty() {
            self.other.get_or_insert_with(|| (table.file.clone(), id.to_owned()));
            return false;
        }
        let status = Status::of(columns.identity(row).status);
        if status != now {
            table.postponed.insert(status);
            return false;
        }
        match known {
            Some(is_counted) => !std::mem::replace(is_counted, true),
            None => self.is_counted.insert(key, true).is_none(),
        }
    }

    /// Refuses a case that is none of the sweep.
    pub(super) fn expect_no_other(&mut self) -> Result<(), SweepError> {
        match (self.other.take(), &self.plan) {
            (Some((table, case)), Some((folder, _))) => {
                Err(SweepError::OtherCase { table, folder: folder.clone(), case })
            }
            _ => Ok(()),
        }
    }

    /// Returns the plan of the sweep, with the folder of its first part.
    pub(super) fn plan(&self) -> Option<&(PathBuf, Plan)> {
        self.plan.as_ref()
    }

    /// Whether a case of the plan has not been counted.
    pub(super) fn is_missing(&self, id: &str) -> bool {
        self.is_counted.get(&key_of_name(id)) == Some(&false)
    }

    /// Returns the plan of the sweep.
    pub(super) fn into_plan(self) -> Option<Plan> {
        self.plan.map(|(_, plan)| plan)
    }
}

/// The folder in which the cases of a table were run: the file's folder, or the folder above, if that is a sweep's.
fn folder_of(file: &Path) -> PathBuf {
    let mut folder = file.parent().unwrap_or(Path::new("")).to_owned();
    if folder.ends_with(PARTS) {
        folder.pop();
    }
    folder
}

fn key_of_name(id: &str) -> Key {
    shortened(&Sha256::digest(id))
}

/// The key of a run that has no name: another row with the same settings, seed, versions and figures is of the same run.
fn key_of_row(columns: &Columns<'_>, row: &[Cell]) -> Key {
    let mut hasher = Sha256::new();
    for (name, cell) in columns.cells(row) {
        hasher.update(format!("{name} {cell:?}\0"));
    }
    shortened(&hasher.finalize())
}

fn shortened(digest: &[u8]) -> Key {
    let mut key = Key::default();
    key.iter_mut().zip(digest).for_each(|(byte, of_digest)| *byte = *of_digest);
    key
}
