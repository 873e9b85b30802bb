//! One key frame: a stamp of the drive at which the pose is bounded, with its readings and the way to it.

use std::sync::Arc;

use interval::Interval;

use crate::{PoseBox, reading::Shown};

use super::super::{BoxLabel, Relations, Stray, link::Link};

/// One stamp of the drive at which the pose is bounded.
#[derive(Clone)]
pub(super) struct KeyFrame {
    pub(super) number: usize,
    pub(super) stamp_s: f64,
    /// Box of the pose: as it was known when the key frame was made, narrowed since by bounds of the linear program.
    pub(super) pose: PoseBox,
    /// What the box was before it was narrowed, each with the time at which the bounds that narrowed it were known.
    pub(super) wider: Vec<(f64, PoseBox)>,
    /// The reading that makes the pose's box, if it is of one.
    pub(super) label: Option<BoxLabel>,
    /// The way from the key frame before; `None` for the first one, and where no reading of the motion is to be believed.
    pub(super) link: Option<Link>,
    /// The readings at this stamp that relate something, at most one of each source.
    pub(super) readings: Vec<FrameReading>,
    /// Whether the way to it has been asked for.
    pub(super) is_linked: bool,
    /// Time by which all was known that the way to it follows from, if it was made with boxes that poses had then: by counts of the flow sensor from a
    /// heading, and where two ways were joined.
    pub(super) way_known_s: Option<f64>,
    /// The greatest error of the flow sensor's place by its counts, and the stamps of the readings that the counts are of.
    pub(super) place: Option<(f64, [f64; 2])>,
}

/// A reading at the stamp of a key frame.
#[derive(Clone)]
pub struct FrameReading {
    /// What it is a reading of, such as the name of the method that read it: of each source a key frame has one reading at most.
    pub source: &'static str,
    /// What the reading relates.
    pub relations: Arc<dyn Relations>,
    /// What the reading showed, of which its relations can be made anew.
    pub shown: Option<Shown>,
    /// How far the robot can have gone between the reading's stamp and its true instant.
    pub(super) stray: Stray,
    /// Number by which the reading's own quantities are told apart from those of all other readings. The first reading of a key frame has the key
    /// frame's number.
    pub(super) number: usize,
}

impl FrameReading {
    /// A reading of a source, for a key frame.
    pub fn new(source: &'static str, relations: Arc<dyn Relations>, stray: Stray) -> FrameReading {
        FrameReading { source, relations, shown: None, stray, number: 0 }
    }

    /// The same reading, with what it showed.
    pub fn showing(self, shown: Option<Shown>) -> FrameReading {
        FrameReading { shown, ..self }
    }

    /// How far the pose that the reading shows may be from the pose at its stamp.
    pub(super) fn displaced(&self) -> Stray {
        Stray { metres: self.relations.shift_m(&self.stray), ..self.stray }
    }
}

impl KeyFrame {
    /// A key frame whose way from the key frame before is not known yet. `pose` encloses the pose at its stamp.
    pub(super) fn new(number: usize, stamp_s: f64, pose: PoseBox, readings: Vec<FrameReading>) -> KeyFrame {
        KeyFrame {
            number,
            stamp_s,
            pose,
            wider: Vec::new(),
            label: None,
            link: None,
            readings,
            is_linked: false,
            way_known_s: None,
            place: None,
        }
    }

    /// Narrows the pose along an axis by a bound that follows from what was known at `known_s`.
    pub(super) fn narrow(&mut self, axis: usize, bound: Interval, known_s: f64) {
        if self.wider.last().is_none_or(|(narrowed_s, _)| *narrowed_s != known_s) {
            self.wider.push((known_s, self.pose));
        }
        self.pose[axis] = self.pose[axis].intersect(bound);
    }

    /// Takes back what followed from what was known after a stamp: of the pose, and the way to it.
    pub(super) fn take_back_since(&mut self, since_s: f64) {
        if self.way_known_s.take_if(|known_s| *known_s > since_s).is_some() {
            self.link = None;
        }
        let n_before = self.wider.partition_point(|(narrowed_s, _)| *narrowed_s <= since_s);
        if let Some((_, pose)) = self.wider.drain(n_before..).next() {
            self.pose = pose;
        }
    }

    /// Whether a reading relates more than the map.
    pub(super) fn relates_more_than_the_map(&self) -> bool {
        !self.readings.iter().all(|one| one.relations.is_of_the_map())
    }

    /// How much the key frame counts among those that are kept.
    pub(super) fn counts(&self) -> usize {
        if self.relates_more_than_the_map() { 2 } else { 1 }
    }

    /// Whether the key frame has a reading of a source.
    pub(super) fn has(&self, source: &str) -> bool {
        self.readings.iter().any(|one| one.source == source)
    }
}
