//! Every case of a sweep, named before the first one runs.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{
    artefacts::run_files::{program_digest, scene_digest},
    loading::{SceneFile, SceneTemplate, Setting},
};

use super::{Sweep, SweepError, Variable};

/// A plan names its cases one by one, so that they have to fit in memory.
const MOST_CASES: u128 = 1_000_000;

/// What `sweep.json` holds: equal for all parts of one sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// The scene's file, as it was named.
    pub path: PathBuf,
    /// Digest of the scene as its file states it.
    pub scene_digest: String,
    /// Keys that vary, the one that changes slowest first.
    pub vary: Vec<Variable>,
    /// The first seed, and the one after the last.
    pub seeds: [u64; 2],
    /// Version of Wherein.
    pub version: String,
    /// Digest of the program; none when the system does not tell.
    pub program: Option<String>,
    /// Graphics adapter; none when the scene has no camera.
    pub adapter: Option<String>,
    /// Names of all cases: combinations in the order of `vary`, within each the seeds.
    pub cases: Vec<String>,
}

/// One case as its plan tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedCase {
    /// Place in the plan, from 0.
    pub index: usize,
    /// Its name.
    pub id: String,
    /// What is set in the scene.
    pub settings: Vec<Setting>,
    /// Its seed.
    pub seed: u64,
}

/// A case with the scene that it runs.
#[derive(Clone, Debug)]
pub struct Case {
    /// What the plan says of it.
    pub planned: PlannedCase,
    /// The scene with the case's settings.
    pub file: Arc<SceneFile>,
}

impl Sweep {
    /// The scene with every combination of values, each held against the scene's schema.
    pub fn variations(&self, template: &SceneTemplate) -> Result<Vec<SceneFile>, SweepError> {
        check_size(self)?;
        let mut seen: BTreeMap<String, String> = BTreeMap::new();
        let mut variations = Vec::new();
        for settings in combinations(&self.vary) {
            let varied = template.with(&settings)?;
            if let Some(one) = seen.insert(scene_digest(&varied.scene), listed(&settings)) {
                return Err(SweepError::SameCase { one, other: listed(&settings) });
            }
            variations.push(varied);
        }
        Ok(variations)
    }
}

impl Plan {
    /// Plans all cases of the `variations` of a sweep's scene.
    pub fn new(
        sweep: &Sweep,
        template: &SceneTemplate,
        variations: Vec<SceneFile>,
        adapter: Option<String>,
    ) -> (Plan, Vec<Case>) {
        let file = template.file();
        let mut plan = Plan {
            scene: file.name.clone(),
            path: file.path.clone(),
            scene_digest: scene_digest(&file.scene),
            vary: sweep.vary.clone(),
            seeds: [sweep.seeds.start, sweep.seeds.end],
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program: program_digest().map(str::to_owned),
            adapter,
            cases: Vec::new(),
        };
        let mut cases = Vec::new();
        for varied in variations.into_iter().map(Arc::new) {
            let digest = scene_digest(&varied.scene);
            for seed in sweep.seeds.clone() {
                let settings = varied.settings.clone();
                let id = plan.id(&digest, &settings, seed);
                plan.cases.push(id.clone());
                let planned = PlannedCase { index: cases.len(), id, settings, seed };
                cases.push(Case { planned, file: Arc::clone(&varied) });
            }
        }
        (plan, cases)
    }

    /// All cases, in order.
    pub fn planned(&self) -> Vec<PlannedCase> {
        let seeds = self.seeds[0]..self.seeds[1];
        let combinations = combinations(&self.vary);
        let cases = combinations.iter().flat_map(|settings| seeds.clone().map(move |seed| (settings, seed)));
        cases
            .zip(&self.cases)
            .enumerate()
            .map(|(index, ((settings, seed), id))| PlannedCase {
                index,
                id: id.clone(),
                settings: settings.clone(),
                seed,
            })
            .collect()
    }

    /// The name of a case: a digest of all that determines its bytes.
    fn id(&self, scene_digest: &str, settings: &[Setting], seed: u64) -> String {
        let mut hasher = Sha256::new();
        // Each part ends with a byte that none contains.
        for part in [
            scene_digest,
            &listed(settings),
            &seed.to_string(),
            &self.version,
            self.program.as_deref().unwrap_or_default(),
            self.adapter.as_deref().unwrap_or_default(),
        ] {
            hasher.update(part.as_bytes());
            hasher.update([0]);
        }
        // 80 bits: that two among a million cases share a name has a chance of 4·10⁻¹³.
        hasher.finalize().iter().take(10).map(|byte| format!("{byte:02x}")).collect()
    }
}

fn check_size(sweep: &Sweep) -> Result<(), SweepError> {
    for (index, variable) in sweep.vary.iter().enumerate() {
        if sweep.vary[..index].iter().any(|earlier| earlier.key == variable.key) {
            return Err(SweepError::TwiceVaried { key: variable.key.clone() });
        }
    }
    let sizes = sweep.vary.iter().map(|variable| variable.values.len() as u128);
    let seeds = u128::from(sweep.seeds.end.saturating_sub(sweep.seeds.start));
    let cases = sizes.fold(seeds, u128::saturating_mul);
    if cases > MOST_CASES { Err(SweepError::TooManyCases { cases, limit: MOST_CASES }) } else { Ok(()) }
}

/// Every combination of values, the last key changing fastest.
fn combinations(vary: &[Variable]) -> Vec<Vec<Setting>> {
    vary.iter().fold(vec![Vec::new()], |combined, variable| {
        let longer = |settings: &Vec<Setting>| {
            let settings = settings.clone();
            variable.values.iter().map(move |value| {
                let setting = Setting { key: variable.key.clone(), value: value.clone() };
                settings.iter().cloned().chain([setting]).collect()
            })
        };
        combined.iter().flat_map(longer).collect()
    })
}

/// `key=value key=value`, or what there is to say without any.
fn listed(settings: &[Setting]) -> String {
    let listed: Vec<String> = settings.iter().map(Setting::to_string).collect();
    if listed.is_empty() { "the scene as it is".to_owned() } else { listed.join(" ") }
}
