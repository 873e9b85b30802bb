//! A sweep that has begun: its plan is written, and its cases are told apart into those that are recorded and those that are to run.

use std::path::{Path, PathBuf};

use crate::{loading::SceneTemplate, render::Renderer, run::FramesPolicy};

use super::{Case, Plan, Shard, Store, Sweep, SweepError};

/// A sweep whose plan is written into its folder.
pub struct Begun {
    /// Folder of the sweep.
    pub out: PathBuf,
    /// The plan of the sweep.
    pub plan: Plan,
    /// Every case of the sweep.
    pub cases: Vec<Case>,
    /// The results in the sweep's folder.
    pub store: Store,
    /// Renderer on the graphics adapter; none when the scene has no camera.
    pub renderer: Option<Renderer>,
    /// Whether a recorded case can be told from a case of another build or of another version of the localizer under test.
    is_known: bool,
}

impl Begun {
    /// Opens the folder of a sweep, by default `sweeps/<scene>`, opens the graphics adapter if a camera needs it, and writes the plan.
    pub fn of(sweep: &Sweep, out: Option<&Path>, adapter: Option<&str>) -> Result<Begun, SweepError> {
        let template = SceneTemplate::load(&sweep.scene)?;
        let variations = sweep.variations(&template)?;
        let has_camera = variations.iter().any(|file| file.scene.has_camera());
        let renderer = if has_camera { Some(Renderer::on_adapter(adapter)?) } else { None };
        let (plan, cases) = Plan::new(sweep, &template, variations, renderer.as_ref().map(Renderer::adapter));
        let out = out.map_or_else(|| Path::new("sweeps").join(&plan.scene), Path::to_owned);
        let store = Store::open(&out)?;
        store.write_plan(&plan)?;
        // Without a digest of the program, a case that this build recorded cannot be told from a case of another build, so that every case runs again.
        let is_known = plan.program.is_some() && !sweep.subject.may_have_changed();
        Ok(Begun { out, plan, cases, store, renderer, is_known })
    }

    /// The cases of a shard that are to run, and the number of cases that the shard has.
    pub fn todo(&self, shard: Shard, frames: FramesPolicy) -> (Vec<&Case>, usize) {
        let meant: Vec<&Case> = self.cases.iter().filter(|case| shard.holds(case.planned.index)).collect();
        let is_recorded = |case: &Case| self.is_known && self.store.has(&case.planned, frames);
        let n_meant = meant.len();
        (meant.into_iter().filter(|case| !is_recorded(case)).collect(), n_meant)
    }
}
