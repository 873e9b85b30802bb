//! Worker threads that run the cases of a sweep and share one graphics adapter.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

use crate::{campaign::judged_run::run_judged, render::Renderer, run::RunOptions, subject::SubjectChoice};

use super::{Case, Store, SweepError};

/// The cases that a sweep has to run, with the renderer, the number of threads and the folder that the runs use.
pub struct Work<'a> {
    /// Cases that are to run.
    pub cases: &'a [&'a Case],
    /// The localizer that the runs test.
    pub subject: &'a SubjectChoice,
    /// Number of worker threads.
    pub jobs: usize,
    /// What each run keeps and computes in addition to the results.
    pub options: RunOptions,
    /// Renderer on the graphics adapter; none when the scene has no camera.
    pub renderer: Option<Renderer>,
    /// Folder into which results are written.
    pub store: &'a Store,
    /// Set from outside to end the sweep before its time. Runs in progress then are not recorded, and end early if the localizer heeds it too
    /// ([`SubjectChoice::until`]).
    pub stop: &'a AtomicBool,
}

/// Outcome of one case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finished {
    /// The case ran and met the scene's expectations.
    Passed,
    /// The case ran and missed some expectation of the scene.
    Missed,
    /// The case could not run.
    Failed,
}

/// Runs all cases and records each as soon as it is done. `finished` is called with the outcome of each case.
///
/// A run that panics is recorded as failed, and the other cases go on. An error of the graphics device or of the file system ends the
/// sweep; cases recorded before stay recorded.
pub fn run_cases(work: Work<'_>, finished: &mut dyn FnMut(Finished)) -> Result<(), SweepError> {
    let Work { cases, subject, jobs, options, renderer, store, stop } = work;
    let renderers = renderers(renderer, jobs.clamp(1, cases.len().max(1)))?;
    let (next, has_erred) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let mut first_error = None;
    let running = Running { subject, options, store, stop };
    thread::scope(|scope| {
        for mut renderer in renderers {
            let (sender, next, has_erred, running) = (sender.clone(), &next, &has_erred, &running);
            scope.spawn(move || {
                while !has_erred.load(Ordering::Relaxed) && !stop.load(Ordering::Relaxed) {
                    let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    let outcome = run_case(case, running, &mut renderer);
                    if outcome.is_err() {
                        has_erred.store(true, Ordering::Relaxed);
                    }
                    // Sending a case's outcome to the main thread cannot fail, as its receiver lives until every worker thread has ended.
                    let _ = sender.send(outcome);
                }
            });
        }
        drop(sender);
        for outcome in receiver {
            match outcome {
                Ok(how) => how.into_iter().for_each(&mut *finished),
                Err(error) => first_error = first_error.take().or(Some(error)),
            }
        }
    });
    first_error.map_or(Ok(()), Err)
}

/// Creates one renderer for each worker thread; fewer renderers, and so fewer workers, where the graphics driver does not allow several threads.
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

/// What all cases have in common.
struct Running<'a> {
    subject: &'a SubjectChoice,
    options: RunOptions,
    store: &'a Store,
    stop: &'a AtomicBool,
}

/// Runs a case and records it; `None` where the sweep was ended from outside, so that nothing is recorded.
fn run_case(
    case: &Case,
    running: &Running<'_>,
    renderer: &mut Option<Renderer>,
) -> Result<Option<Finished>, SweepError> {
    let Running { subject: choice, options, store, stop } = *running;
    let frames = options.keep_images;
    let scene = &case.file.scene;
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        let used = renderer.as_mut().filter(|_| scene.has_camera());
        Ok::<_, SweepError>(run_judged(scene, case.planned.seed, choice, &options, used, &mut (), &mut |_| {})?)
    }));
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    match attempt {
        Ok(outcome) => {
            let (record, verdict) = outcome?;
            store.write(case, frames, &record, &verdict)?;
            Ok(Some(if verdict.verdict.passed { Finished::Passed } else { Finished::Missed }))
        }
        Err(panic) => {
            // A renderer that was in use during a panic may be in an inconsistent state, so that a new one replaces it where the driver allows.
            if let Some(used) = renderer.take() {
                *renderer = Some(match used.sibling()? {
                    Some(fresh) => fresh,
                    None => used,
                });
            }
            store.write_failure(case, frames, &format!("the run panicked: {}", message(&panic)))?;
            Ok(Some(Finished::Failed))
        }
    }
}

fn message(panic: &Box<dyn Any + Send>) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "for an unknown reason".to_owned())
}
