//! The search for failing scenes: cases in the order of their numbers, several at a time, each recorded in the journal when it is done.

use std::{
    collections::BTreeSet,
    ops::Range,
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    thread,
    time::Instant,
};

use toml::Table;

use super::{
    FalsifyError, Profile,
    child::{Ending, Run},
    drawn,
    finding::Finding,
    journal::{Done, Journal},
    probe::Outcome,
    shrink::shrink,
    wish::{Hit, Wish},
};

/// Parameters of a search for failing scenes.
#[derive(Clone, Debug)]
pub struct Search {
    /// Seed of all scenes of the search.
    pub seed: u64,
    /// Range of the case numbers.
    pub cases: Range<u64>,
    /// Kinds of scenes that are drawn.
    pub profile: Profile,
    /// Number of runs at the same time.
    pub jobs: usize,
    /// Time after which no more cases begin and failing scenes are not reduced any further.
    pub deadline: Option<Instant>,
    /// Kinds of failure that are searched for: scenes that show one are reduced to small ones and written to files.
    pub wishes: Vec<Wish>,
    /// Greatest number of smaller scenes that are tried in order to reduce a failing scene.
    pub tries: usize,
    /// Interval, in cases, at which a case runs twice so that the results of both runs can be compared byte by byte; 0 for never.
    pub twice_every: u64,
    /// Folder for the journal and the failing scenes.
    pub out: PathBuf,
    /// Graphics adapter to render with.
    pub adapter: Option<String>,
}

/// A message about the progress of a search.
#[derive(Clone, Debug)]
pub enum Progress {
    /// Number of cases that are done already, as the journal of an earlier process shows.
    Resumed(usize),
    /// A case is done.
    Done(Done),
}

/// Greatest number of scenes that are drawn for one case, in case that each is refused. A random scene should be valid more often than not, and one
/// in six such that witnesses of it can be checked, so that this number of refusals in a row has a probability of at most 10⁻¹².
const ATTEMPTS: u64 = 160;

/// Greatest number of smaller scenes that are tried when the failure is a run that does not end: each smaller scene that does not end either takes
/// all the time that a run is allowed.
const HANG_TRIES: usize = 60;

/// Runs every case that is not done yet, and returns all cases that are done, in the order of their numbers. `progress` is called for each case as
/// soon as it is done.
pub fn search(search: &Search, progress: &mut dyn FnMut(Progress)) -> Result<Vec<Done>, FalsifyError> {
    let (journal, earlier) =
        Journal::open(&search.out, search.seed, search.profile, search.seeks_witnesses(), search.adapter.as_deref())?;
    let mut done: Vec<Done> = earlier.into_values().filter(|case| search.cases.contains(&case.case)).collect();
    progress(Progress::Resumed(done.len()));
    let known: BTreeSet<u64> = done.iter().map(|case| case.case).collect();
    // The case numbers stay an iterator and never become a list: a search that is limited by time only has billions of them.
    let todo = Mutex::new(search.cases.clone().filter(|number| !known.contains(number)));
    let (stop, journal) = (AtomicBool::new(false), Mutex::new(journal));
    let (sender, receiver) = mpsc::channel();
    let mut first_error = None;
    thread::scope(|scope| {
        for _ in 0..search.jobs.max(1) {
            let (sender, stop, journal, todo) = (sender.clone(), &stop, &journal, &todo);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !search.is_over() {
                    let Some(number) = todo.lock().unwrap_or_else(PoisonError::into_inner).next() else { break };
                    let outcome = search.case(number).and_then(|case| {
                        journal.lock().unwrap_or_else(PoisonError::into_inner).add(&case)?;
                        Ok(case)
                    });
                    if outcome.is_err() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    // Sending a case's result to the main thread cannot fail, as its receiver lives until every worker thread has ended.
                    let _ = sender.send(outcome);
                }
            });
        }
        drop(sender);
        for outcome in receiver {
            match outcome {
                Ok(case) => {
                    progress(Progress::Done(case.clone()));
                    done.push(case);
                }
                Err(error) => first_error = first_error.take().or(Some(error)),
            }
        }
    });
    done.sort_by_key(|case| case.case);
    first_error.map_or(Ok(done), Err)
}

/// Results of one scene's run.
struct Seen {
    outcome: Option<Outcome>,
    hits: Vec<Hit>,
}

impl Search {
    fn seeks_witnesses(&self) -> bool {
        self.wishes.contains(&Wish::WitnessOutside)
    }

    fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Runs one case: draws scenes until one is valid, runs it, and reduces the scene to a small one if it shows a failure.
    fn case(&self, number: u64) -> Result<Done, FalsifyError> {
        let mut refused = Vec::new();
        for attempt in 0..ATTEMPTS {
            let (scene, run_seed) = drawn(self.seed, self.profile, number, attempt);
            match self.seen(number, &scene, run_seed, self.runs_twice(number))? {
                Err(reason) => refused.push(reason),
                Ok(seen) => return self.done(number, run_seed, scene, seen, refused),
            }
        }
        let reason = refused.pop().unwrap_or_default();
        Err(FalsifyError::AllRefused { case: number, attempts: ATTEMPTS, reason })
    }

    fn runs_twice(&self, number: u64) -> bool {
        self.twice_every > 0 && number.is_multiple_of(self.twice_every)
    }

    fn done(
        &self,
        case: u64,
        run_seed: u64,
        scene: Table,
        seen: Seen,
        refused: Vec<String>,
    ) -> Result<Done, FalsifyError> {
        let gravest =
            seen.hits.iter().filter(|hit| self.wishes.contains(&hit.wish)).min_by_key(|hit| hit.wish).cloned();
        let found = gravest.map(|hit| self.found(case, run_seed, scene, hit)).transpose()?;
        let outcome = seen.outcome;
        Ok(Done {
            case,
            run_seed,
            refused,
            steps: outcome.as_ref().map_or(0, |outcome| outcome.steps),
            simulated_s: outcome.as_ref().map_or(0.0, |outcome| outcome.simulated_s),
            has_cameras: outcome.as_ref().is_some_and(|outcome| outcome.has_cameras),
            witnesses: outcome.as_ref().map(|outcome| outcome.witnesses.clone()),
            broken: outcome.map(|outcome| outcome.broken).unwrap_or_default(),
            hits: seen.hits,
            found,
        })
    }

    /// Reduces a scene that shows a failure to a small one and writes it to a file.
    fn found(&self, case: u64, run_seed: u64, scene: Table, hit: Hit) -> Result<PathBuf, FalsifyError> {
        let mut error = None;
        let mut last = hit.clone();
        let tries = if hit.wish == Wish::Hang { self.tries.min(HANG_TRIES) } else { self.tries };
        let small = shrink(scene, hit.at_s, tries, &mut |smaller| {
            if error.is_some() || self.is_over() {
                return false;
            }
            let seen = match self.seen(case, smaller, run_seed, hit.wish == Wish::DigestDiffers) {
                Ok(seen) => seen,
                Err(failed) => {
                    error = Some(failed);
                    return false;
                }
            };
            let again = seen.ok().and_then(|seen| seen.hits.into_iter().find(|other| is_same(&hit, other)));
            let is_again = again.is_some();
            last = again.unwrap_or_else(|| last.clone());
            is_again
        });
        if let Some(error) = error {
            return Err(error);
        }
        let finding = Finding { seed: self.seed, case, run_seed, hit: &last, scene: &small };
        Ok(finding.write(&self.out)?)
    }

    /// Runs a scene in a process of its own. The inner result is an error when the scene was refused, and names the first invalid key.
    fn seen(&self, case: u64, scene: &Table, seed: u64, is_twice: bool) -> Result<Result<Seen, String>, FalsifyError> {
        let text = scene.to_string();
        let run = |driver_threads| {
            let (adapter, seeks_witnesses) = (self.adapter.as_deref(), self.seeks_witnesses());
            let run = Run { text: &text, seed, adapter, driver_threads, seeks_witnesses };
            run.run().map_err(|source| FalsifyError::Process { case, source })
        };
        let outcome = match run(None)? {
            Ending::Refused(reason) => return Ok(Err(reason)),
            Ending::CouldNotRun(reason) => return Err(FalsifyError::CouldNotRun { case, reason }),
            Ending::Ran(outcome) => outcome,
            ended => return Ok(Ok(Seen { outcome: None, hits: ended_early(&ended).into_iter().collect() })),
        };
        let mut hits = outcome.hits.clone();
        if is_twice {
            // The second run has a single thread in a software driver: the number of its threads must not change a byte.
            match run(Some(1))? {
                Ending::Ran(second) if second.digest == outcome.digest => {}
                Ending::CouldNotRun(reason) => return Err(FalsifyError::CouldNotRun { case, reason }),
                other => hits.push(differs(&outcome, &other)),
            }
        }
        Ok(Ok(Seen { outcome: Some(outcome), hits }))
    }
}

/// Returns the failure of a process that crashed before its run was complete, or that took too long.
fn ended_early(ending: &Ending) -> Option<Hit> {
    match ending {
        Ending::Crashed { at_s, place, said } => {
            // The line with `panicked at` has the place of the panic, and the line after it the message.
            let message = said.lines().skip_while(|line| !line.contains("panicked at")).nth(1).unwrap_or(place);
            let seen = format!("{place}: {message}, after {at_s:.1} s");
            Some(Hit { wish: Wish::Crash, at_s: *at_s, signature: place.clone(), seen })
        }
        Ending::Hung { at_s, took_s } => {
            let seen = format!("ended at {at_s:.1} s of simulated time, after {took_s:.0} s of processor time");
            Some(Hit { wish: Wish::Hang, at_s: *at_s, signature: "hang".to_owned(), seen })
        }
        _ => None,
    }
}

fn differs(first: &Outcome, second: &Ending) -> Hit {
    let names = ["truth", "readings", "estimates"];
    let seen = match second {
        Ending::Ran(second) => {
            let pairs = first.digest.split(' ').zip(second.digest.split(' ')).zip(names);
            let differing: Vec<&str> = pairs.filter(|((one, other), _)| one != other).map(|(_, name)| name).collect();
            format!("the second run has other {}", differing.join(", "))
        }
        other => format!("the second run did not end as the first: {other:?}"),
    };
    Hit { wish: Wish::DigestDiffers, at_s: 0.0, signature: seen.clone(), seen }
}

/// Whether the failures of a scene and of a smaller version of it are the same: of the same kind, and for crashes also at the same place in the
/// source.
fn is_same(one: &Hit, other: &Hit) -> bool {
    one.wish == other.wish && (one.wish != Wish::Crash || one.signature == other.signature)
}
