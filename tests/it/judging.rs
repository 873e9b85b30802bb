use sim::{
    judge::METRICS,
    judge::{Verdict, judge},
    render::Renderer,
    run::{RunRecord, run_otherwise},
    scene::Scene,
    subject::{IntervalLocalizer, SubjectOf},
};

/// What the check says of a run, simulated again where it has to know whose fault a failure is.
pub(crate) fn verdict_of(scene: &Scene, record: &RunRecord) -> Verdict {
    verdict_of_subject(scene, record, &IntervalLocalizer::boxed)
}

/// The same of a run by another subject.
pub(crate) fn verdict_of_subject(scene: &Scene, record: &RunRecord, subject_of: &SubjectOf<'_>) -> Verdict {
    let mut renderer = None;
    let verdict = judge(scene, record, &mut |asked| {
        if scene.has_camera() && renderer.is_none() {
            renderer = Some(Renderer::new()?);
        }
        run_otherwise(scene, record, asked, subject_of, renderer.as_mut(), &mut |_| {})
    });
    let verdict = verdict.unwrap();
    // What a run measures can be expected of it.
    let unknown: Vec<&String> = verdict.metrics.keys().filter(|name| !METRICS.contains(&name.as_str())).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    verdict
}
