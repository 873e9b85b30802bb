//! A failing scene in a file of its own, for a person to investigate.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::{
    artefacts::run_files::{self, RecordError},
    campaign::{
        cases::{program, quoted},
        sweep::write_whole,
    },
};

use super::wish::{Hit, Wish};

/// A random scene that shows a failure, with a description of the failure and the seeds that repeat it.
#[derive(Clone, Debug)]
pub struct Finding<'a> {
    /// Seed of the search.
    pub seed: u64,
    /// Number of the case in the search.
    pub case: u64,
    /// Seed of the run.
    pub run_seed: u64,
    /// Failure that the scene shows.
    pub hit: &'a Hit,
    /// The scene, shrunk.
    pub scene: &'a Table,
}

impl Finding<'_> {
    /// Returns the path of the file for a failing scene, given the folder of the search.
    pub fn path(&self, out: &Path) -> PathBuf {
        out.join("found").join(format!("{}_{}_{}.toml", self.hit.wish.name(), self.seed, self.case))
    }

    /// Writes the scene, with a description of the failure in comments before it. The scene expects that the failure does not occur, so that a person
    /// who has found the cause can add the file to the project's scenes as it is.
    pub fn write(&self, out: &Path) -> Result<PathBuf, RecordError> {
        let path = self.path(out);
        run_files::prepare_for(&path)?;
        write_whole(&path, self.text(&path).as_bytes())?;
        Ok(path)
    }

    /// Returns the text of the file for a failing scene.
    pub fn text(&self, path: &Path) -> String {
        let Hit { wish, seen, signature, .. } = self.hit;
        let program = program().iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
        let replay = quoted(&path.display().to_string());
        let mut scene = self.scene.clone();
        scene.insert(
            "description".to_owned(),
            Value::String(format!("Found by a random search, case {}: {}", self.case, wish.name())),
        );
        let names: &[&str] = if *wish == Wish::Perception { &["unsound", "perception"] } else { &["unsound"] };
        let expect = names.iter().map(|name| ((*name).to_owned(), Value::Integer(0))).collect();
        scene.insert("expect".to_owned(), Value::Table(expect));
        format!(
            "# {} in case {} of the search of seed {}: {seen}\n# {signature}\n# seeds: {}\n# replay: {program} run {replay} --seed {}\n\n{scene}",
            wish.name().replace('_', " "),
            self.case,
            self.seed,
            self.run_seed,
            self.run_seed,
        )
    }
}
