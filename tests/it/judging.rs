use sim::{
    judge::{METRICS, Verdict, judge},
    render::Renderer,
    run::{RunRecord, run_otherwise},
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
    let unknown: Vec<&String> = verdict.metrics.keys().filter(|name| !METRICS.contains(&name.as_str())).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    verdict
}
