//! One run with its verdict: the run itself, and the runs that the judge has simulated again to find what was to blame.

use crate::{
    judge::{Verdict, judge},
    render::{RenderError, Renderer},
    run::{RunOptions, RunRecord, Witness, run_otherwise, run_witnessed},
    scene::Scene,
    subject::{SubjectChoice, subject},
};

/// How far a run and its judgement have got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// The present simulation has reached this simulated time.
    At {
        /// Simulated time since the start of the run.
        simulated_s: f64,
    },
    /// The run is being simulated again under changed conditions, to find the cause of a loss of the truth.
    Again {
        /// Number of this repetition, counted from 1.
        number: usize,
        /// Simulated time that it lasts: up to the last loss that it has to explain.
        lasts_s: f64,
    },
    /// The present simulation has ended.
    Ended {
        /// Simulated time that it lasts when nothing ends it early.
        lasts_s: f64,
    },
}

/// Runs a scene with one seed and one localizer under test, and judges the run. The methods to compare with are run where the options or the scene's
/// expectations ask for them. `witness` is told each event of the run, and `progress` is called now and then.
///
/// Errors when a camera cannot be rendered; a robot without a camera needs no renderer.
pub fn run_judged(
    scene: &Scene,
    seed: u64,
    choice: &SubjectChoice,
    options: &RunOptions,
    mut renderer: Option<&mut Renderer>,
    witness: &mut dyn Witness,
    progress: &mut dyn FnMut(Progress),
) -> Result<(RunRecord, Verdict), RenderError> {
    let told = scene.told(seed);
    let scene = &*told;
    let mut tested = subject(choice, scene);
    let options = RunOptions { baselines: options.baselines || scene.expect.needs_baselines(), ..*options };
    let record = {
        let mut at = |simulated_s| progress(Progress::At { simulated_s });
        run_witnessed(scene, seed, &mut *tested, renderer.as_deref_mut(), &options, witness, &mut at)?
    };
    progress(Progress::Ended { lasts_s: scene.simulated_s() });
    let mut number = 0;
    let verdict = judge(scene, &record, &mut |asked| {
        number += 1;
        let lasts_s = asked.until_s.unwrap_or(scene.simulated_s());
        progress(Progress::Again { number, lasts_s });
        let subject_of = |told: &Scene| subject(choice, told);
        let mut at = |simulated_s| progress(Progress::At { simulated_s });
        let again = run_otherwise(scene, &record, asked, &subject_of, renderer.as_deref_mut(), &mut at);
        progress(Progress::Ended { lasts_s });
        again
    })?;
    Ok((record, verdict))
}
