//! The plan of a sweep: it lists every case by name before the first case runs.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{
    artefacts::run_files::{program_digest, scene_digest},
    loading::{SceneFile, SceneTemplate, Setting},
    subject::SubjectChoice,
};

use super::{Sweep, SweepError, Variable};

/// Greatest number of cases of a sweep. A plan holds the names of all cases, so that they have to fit in memory.
const MOST_CASES: u128 = 1_000_000;

/// Contents of `sweep.json`, which are equal for all parts of one sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the sweep's scene.
    pub scene: String,
    /// Path of the scene's file, as the user gave it.
    pub path: PathBuf,
    /// Digest of the scene as its file states it, without the values that vary.
    pub scene_digest: String,
    /// Name of the localizer that the sweep tests; left out where it is the one that is tested without asking.
    #[serde(default = "usual_subject", skip_serializing_if = "is_usual")]
    pub subject: String,
    /// Whether the methods to compare with (baselines) are run on each run's readings, too.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub baselines: bool,
    /// Scene keys that vary, with their values; the key that changes slowest from case to case comes first.
    pub vary: Vec<Variable>,
    /// First seed of the sweep, and the seed after the last one.
    pub seeds: [u64; 2],
    /// Version of the program `wherein`.
    pub version: String,
    /// Digest of the program's file; none when the operating system does not give access to it.
    pub program: Option<String>,
    /// Graphics adapter of the sweep; none when the scene has no camera.
    pub adapter: Option<String>,
    /// Names of all cases, ordered by the combinations of `vary` and, within each combination, by the seeds.
    pub cases: Vec<String>,
}

/// One case of a sweep as the plan describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedCase {
    /// Index of the case in the plan, from 0.
    pub index: usize,
    /// Name of the case.
    pub id: String,
    /// Keys that are set in the scene for this case.
    pub settings: Vec<Setting>,
    /// Seed of the case.
    pub seed: u64,
}

/// A case of a sweep, with the scene that it runs.
#[derive(Clone, Debug)]
pub struct Case {
    /// The case as the plan describes it.
    pub planned: PlannedCase,
    /// The scene with the settings of the case.
    pub file: Arc<SceneFile>,
}

impl Sweep {
    /// Returns one scene for every combination of the values of the keys that vary; each of these scenes is checked for validity.
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
    /// Creates the plan and the cases of a sweep, given the `variations` of its scene.
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
            subject: sweep.subject.to_string(),
            baselines: sweep.baselines,
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

    /// Returns all cases in the order of the plan.
    pub fn planned(&self) -> impl Iterator<Item = PlannedCase> {
        let seeds = self.seeds[0]..self.seeds[1];
        let cases = combinations(&self.vary)
            .into_iter()
            .flat_map(move |settings| seeds.clone().map(move |seed| (settings.clone(), seed)));
        cases.zip(&self.cases).enumerate().map(|(index, ((settings, seed), id))| PlannedCase {
            index,
            id: id.clone(),
            settings,
            seed,
        })
    }

    /// Returns the name of a case: a digest of everything that determines the bytes of its results.
    fn id(&self, scene_digest: &str, settings: &[Setting], seed: u64) -> String {
        let mut hasher = Sha256::new();
        // The localizer that is tested without asking adds nothing to the text.
        let subject = if is_usual(&self.subject) { "" } else { &self.subject };
        // Each part of the hashed text ends with a zero byte, which no part contains, so that different parts cannot give the same sequence of bytes.
        for part in [
            scene_digest,
            &listed(settings),
            &seed.to_string(),
            &self.version,
            self.program.as_deref().unwrap_or_default(),
            self.adapter.as_deref().unwrap_or_default(),
            subject,
            if self.baselines { "baselines" } else { "" },
        ] {
            hasher.update(part.as_bytes());
            hasher.update([0]);
        }
        // The name has 80 bits: the probability that two among a million cases have the same name is 4·10⁻¹³.
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

/// Returns every combination of the values of the keys that vary, with the last key changing fastest.
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

/// Name of the localizer that is tested without asking.
fn usual_subject() -> String {
    SubjectChoice::default().to_string()
}

fn is_usual(subject: &str) -> bool {
    subject == usual_subject()
}

/// Lists settings as `key=value key=value`, or a phrase that stands for the scene without settings.
fn listed(settings: &[Setting]) -> String {
    let listed: Vec<String> = settings.iter().map(Setting::to_string).collect();
    if listed.is_empty() { "the scene as it is".to_owned() } else { listed.join(" ") }
}
