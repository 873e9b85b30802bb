use localizer::baselines::SOLVERS;
use sim::{
    judge::{Verdict, judge, metric_names},
    render::Renderer,
    run::{BASELINES, RunRecord, run_otherwise},
    scene::Scene,
    subject::{IntervalLocalizer, SubjectOf},
};

/// Verdict of the judge on a run of the interval localizer. The run is simulated again where the judge has to find out whose fault a
/// failure is.
pub(crate) fn verdict_of(scene: &Scene, record: &RunRecord) -> Verdict {
    verdict_of_subject(scene, record, &IntervalLocalizer::boxed)
}

/// Verdict of the judge on a run of another subject, which may be any localizer under test.
pub(crate) fn verdict_of_subject(scene: &Scene, record: &RunRecord, subject_of: &SubjectOf<'_>) -> Verdict {
    let mut renderer = None;
    let verdict = judge(scene, record, &mut |asked| {
        if scene.has_camera() && renderer.is_none() {
            renderer = Some(Renderer::new()?);
        }
        run_otherwise(scene, record, asked, subject_of, renderer.as_mut(), &mut |_| {})
    });
    let verdict = verdict.unwrap();
    // Every metric that a run measures must be in the list of metrics that a scene may state expectations of.
    let unknown: Vec<&String> =
        verdict.metrics.keys().filter(|name| !metric_names().any(|known| known == *name)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    // So must every method to compare with be in the list of their names.
    let is_known = |name: &str| BASELINES.contains(&name) || SOLVERS.iter().any(|(solver, _)| *solver == name);
    let unknown: Vec<&String> = verdict.baselines.keys().filter(|name| !is_known(name)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    verdict
}
