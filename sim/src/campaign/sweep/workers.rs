//! Cases run by several threads that share one graphics adapter.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

use crate::{
    judge::judge,
    render::Renderer,
    run::{FramesPolicy, RunOptions, run, run_otherwise},
    subject::IntervalLocalizer,
};

use super::{Case, Store, SweepError};

/// What there is to run, and with what.
pub struct Work<'a> {
    /// The cases.
    pub cases: &'a [&'a Case],
    /// Threads.
    pub jobs: usize,
    /// Images of which debug frames stay.
    pub frames: FramesPolicy,
    /// The device; none when the scene has no camera.
    pub renderer: Option<Renderer>,
    /// Where results go.
    pub store: &'a Store,
}

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finished {
    /// The scene's expectations were met.
    Passed,
    /// Some were not.
    Missed,
    /// It could not run.
    Failed,
}

/// Runs all cases and records each as soon as it is done; `finished` is told of each.
///
/// A run that panics is recorded as failed and the others go on. An error of the device or of the file system ends the
/// sweep; what is recorded by then stays.
pub fn run_cases(work: Work<'_>, finished: &mut dyn FnMut(Finished)) -> Result<(), SweepError> {
    let Work { cases, jobs, frames, renderer, store } = work;
    let renderers = renderers(renderer, jobs.clamp(1, cases.len().max(1)))?;
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let mut first_error = None;
    thread::scope(|scope| {
        for mut renderer in renderers {
            let (sender, next, stop) = (sender.clone(), &next, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    let outcome = run_case(case, frames, &mut renderer, store);
                    if outcome.is_err() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    // The receiver lives until every worker has ended.
                    let _ = sender.send(outcome);
                }
            });
        }
        drop(sender);
        for outcome in receiver {
            match outcome {
                Ok(how) => finished(how),
                Err(error) => first_error = first_error.take().or(Some(error)),
            }
        }
    });
    first_error.map_or(Ok(()), Err)
}

/// One renderer a worker; fewer workers where the driver does not allow several threads.
fn renderers(first: Option<Renderer>, jobs: usize) -> Result<Vec<Option<Renderer>>, SweepError> {
    let Some(first) = first else { return Ok((0..jobs).map(|_| None).collect()) };
    let mut all = Vec::new();
    while all.len() + 1 < jobs
        && let Some(another) = first.sibling()?
    {
        all.push(Some(another));
    }
    all.push(Some(first));
    Ok(all)
}

fn run_case(
    case: &Case,
    frames: FramesPolicy,
    renderer: &mut Option<Renderer>,
    store: &Store,
) -> Result<Finished, SweepError> {
    let scene = &case.file.scene;
    let options = RunOptions { keep_images: frames };
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        let used = renderer.as_mut().filter(|_| scene.has_camera());
        let record = run(scene, case.planned.seed, &mut IntervalLocalizer::of(scene), used, &options, &mut |_| {})?;
        let verdict = judge(scene, &record, &mut |asked| {
            let used = renderer.as_mut().filter(|_| scene.has_camera());
            run_otherwise(scene, &record, asked, &IntervalLocalizer::boxed, used, &mut |_| {})
        })?;
        Ok::<_, SweepError>((record, verdict))
    }));
    match attempt {
        Ok(outcome) => {
            let (record, verdict) = outcome?;
            store.write(case, frames, &record, &verdict)?;
            Ok(if verdict.verdict.passed { Finished::Passed } else { Finished::Missed })
        }
        Err(panic) => {
            // What the panic left of the renderer is not to be relied on.
            if let Some(used) = renderer.take() {
                *renderer = Some(match used.sibling()? {
                    Some(fresh) => fresh,
                    None => used,
                });
            }
            store.write_failure(case, frames, &format!("the run panicked: {}", message(&panic)))?;
            Ok(Finished::Failed)
        }
    }
}

fn message(panic: &Box<dyn Any + Send>) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "for an unknown reason".to_owned())
}
