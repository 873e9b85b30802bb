use sim::{
    check::{Verdict, check},
    render::Renderer,
    run::{RunRecord, run_otherwise},
    scene::Scene,
};

/// What the check says of a run, simulated again where it has to know whose fault a failure is.
pub(crate) fn verdict_of(scene: &Scene, record: &RunRecord) -> Verdict {
    let mut renderer = None;
    let verdict = check(scene, record, &mut |asked| {
        if scene.has_camera() && renderer.is_none() {
            renderer = Some(Renderer::new()?);
        }
        run_otherwise(scene, record, asked, renderer.as_mut(), &mut |_| {})
    });
    verdict.unwrap()
}
