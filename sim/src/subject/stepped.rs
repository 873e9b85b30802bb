//! A subject whose answers are given from another thread, step by step: the closed loop turned inside out, for a loop outside of this program that
//! asks for one step after the other.

use std::{
    cell::{Cell, OnceCell, RefCell},
    sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    time::Duration,
};

use localizer::{Pose, PoseBox, Reading};

use super::{Answer, Failure, GivenReading, Subject, foreign_answer::turned_to, process::device};

/// One question of a run: where is the robot at this time?
#[derive(Clone, Debug)]
pub struct Step {
    /// Time for which to answer, since the start of the present drive.
    pub time_s: f64,
    /// Box of poses in which a drive starts, if one starts with this step.
    pub start: Option<PoseBox>,
    /// Readings that have arrived since the question before, in the order of their arrival.
    pub readings: Vec<Reading>,
}

/// The side of the run: a subject that hands on its readings with every question, and waits for the answer.
pub struct Stepped {
    name: String,
    asks: SyncSender<Step>,
    answers: Receiver<Answered>,
    next: RefCell<Next>,
    /// Number of readings given, and the newest of them.
    given: (usize, Option<GivenReading>),
    failure: OnceCell<Failure>,
    /// Stamp of the newest reading that the latest answer takes into account, if the loop tells it.
    newest_s: Cell<Option<f64>>,
}

/// An answer, and the stamp of the newest reading that it takes into account, if the loop tells it.
type Answered = (Answer, Option<f64>);

/// What the next question will hold, and the answer to the one before.
struct Next {
    start: Option<PoseBox>,
    readings: Vec<Reading>,
    /// The latest answer with its time, unless a reading has come since.
    latest: Option<(f64, Answer)>,
    /// Heading near which the next answer's headings are taken: that of the answer before, or the middle of the start box.
    heading_rad: f64,
}

/// The side of the loop: takes one step after the other and answers each.
pub struct Steps {
    asked: Receiver<Step>,
    answers: SyncSender<Answered>,
}

/// Makes the two sides of a subject that is asked in one thread and answered in another; `name` is what results call it.
pub fn stepped(name: String) -> (Stepped, Steps) {
    let (asks, asked) = sync_channel(1);
    let (answers, answered) = sync_channel(1);
    let next = Next { start: None, readings: Vec::new(), latest: None, heading_rad: 0.0 };
    let (next, given, failure) = (RefCell::new(next), (0, None), OnceCell::new());
    let newest_s = Cell::new(None);
    (Stepped { name, asks, answers: answered, next, given, failure, newest_s }, Steps { asked, answers })
}

impl Steps {
    /// Waits for the next step; `None` where the run has ended. The error says that `limit` has passed first.
    pub fn next_within(&self, limit: Duration) -> Result<Option<Step>, RecvTimeoutError> {
        match self.asked.recv_timeout(limit) {
            Ok(step) => Ok(Some(step)),
            Err(RecvTimeoutError::Disconnected) => Ok(None),
            Err(timeout) => Err(timeout),
        }
    }

    /// Answers the latest step; each step has exactly one answer. `newest_s` is the stamp of the newest reading that the answer takes into account, if
    /// the loop tells it. An answer after the end of the run is dropped.
    pub fn answer(&self, answer: Answer, newest_s: Option<f64>) {
        let _ = self.answers.send((answer, newest_s));
    }
}

impl Subject for Stepped {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_elsewhere(&self) -> bool {
        true
    }

    fn start(&mut self, start: &PoseBox) {
        *self.next.get_mut() =
            Next { start: Some(*start), readings: Vec::new(), latest: None, heading_rad: start[2].mid() };
    }

    fn observe(&mut self, reading: &Reading) {
        let (number, measured_s, arrived_s) = (self.given.0 + 1, reading.measured_s(), reading.arrived_s());
        let device = device(reading).to_owned();
        self.given = (number, Some(GivenReading { number, device, measured_s, arrived_s }));
        let next = self.next.get_mut();
        next.readings.push(reading.clone());
        next.latest = None;
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        let mut next = self.next.borrow_mut();
        if let Some((at_s, answer)) = &next.latest
            && *at_s == time_s
        {
            return answer.clone();
        }
        let step = Step { time_s, start: next.start.take(), readings: std::mem::take(&mut next.readings) };
        let answer = self.asks.send(step).ok().and_then(|()| self.answers.recv().ok());
        let Some((answer, newest_s)) = answer else {
            let reason = "the loop that answers was left".to_owned();
            self.failure.get_or_init(|| Failure { time_s, reading: self.given.1.clone(), reason });
            return Answer::Point(Pose::default());
        };
        self.newest_s.set(newest_s);
        let answer = turned_to(answer, next.heading_rad);
        let middle_rad = answer.clone().into_estimate(time_s).pose.hull()[2].mid();
        if middle_rad.is_finite() {
            next.heading_rad = middle_rad;
        }
        next.latest = Some((time_s, answer.clone()));
        answer
    }

    fn knows_until_s(&self) -> Option<f64> {
        self.newest_s.get()
    }

    fn failure(&self) -> Option<&Failure> {
        self.failure.get()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::{f64::consts::TAU, thread};

    use interval::Interval;

    use super::*;

    const SOON: Duration = Duration::from_secs(30);

    fn wheels(time_s: f64) -> Reading {
        Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [1, 2] }
    }

    fn point(heading_rad: f64) -> Answer {
        Answer::Point(Pose { x_m: 1.0, y_m: 2.0, heading_rad })
    }

    #[test]
    fn each_question_has_the_readings_since_the_one_before_and_is_asked_once() {
        let (mut subject, steps) = stepped("loop".to_owned());
        let answering = thread::spawn(move || {
            let mut seen = Vec::new();
            while let Ok(Some(step)) = steps.next_within(SOON) {
                seen.push((step.time_s, step.start.is_some(), step.readings.len()));
                // Every step but the first tells what it knows.
                steps.answer(point(0.5 + TAU), (step.time_s > 0.01).then_some(step.time_s - 0.004));
            }
            seen
        });
        subject.start(&PoseBox::from([0.0, 0.0, 0.4].map(Interval::point)));
        subject.observe(&wheels(0.0));
        subject.observe(&wheels(0.005));
        // The heading is taken at the turn of the start box, and the driver's and the recorder's question for one time are one.
        let first = subject.estimate_at(0.01);
        let Answer::Point(pose) = &first else { unreachable!() };
        assert!((pose.heading_rad - 0.5).abs() < 1e-12);
        assert_eq!(subject.estimate_at(0.01), first);
        subject.observe(&wheels(0.01));
        subject.estimate_at(0.01);
        assert_eq!(subject.knows_until_s(), None);
        subject.estimate_at(0.02);
        assert_eq!(subject.knows_until_s(), Some(0.016));
        assert!(subject.failure().is_none());
        drop(subject);
        assert_eq!(answering.join().unwrap(), [(0.01, true, 2), (0.01, false, 1), (0.02, false, 0)]);
    }

    #[test]
    fn a_loop_that_is_left_is_a_failure_with_the_newest_reading() {
        let (mut subject, steps) = stepped("loop".to_owned());
        subject.observe(&wheels(0.25));
        drop(steps);
        subject.estimate_at(0.26);
        let failure = subject.failure().unwrap();
        assert_eq!((failure.time_s, failure.reading.as_ref().unwrap().number), (0.26, 1));
        assert!(failure.reason.contains("left"));
    }
}
