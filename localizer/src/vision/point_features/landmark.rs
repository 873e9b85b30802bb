//! Landmarks: surface points that can be found again by how their surroundings look.

use super::{descriptor::Descriptor, patch::Patch, search::Refusal, search::Sighting};

/// A surface point that an image showed, with all that is needed to find it in other images.
///
/// The point is *defined* as the one that the image showed at [`position_px`](Self::position_px()): this position has no error of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    pub(super) position_px: [f64; 2],
    /// Descriptor along the image's own axes.
    pub(super) upright: Descriptor,
    /// Direction to the centroid of the surroundings, and the descriptor along it.
    pub(super) direction_rad: f64,
    pub(super) turned: Descriptor,
    pub(super) patch: Patch,
}

impl Landmark {
    /// Position `[u, v]` in the image that the landmark was created from, in pixels.
    pub fn position_px(&self) -> [f64; 2] {
        self.position_px
    }

    /// Position of the landmark relative to the patch's middle pixel.
    pub(super) fn offset_px(&self) -> [f64; 2] {
        self.position_px.map(|at| at - at.round())
    }
}

/// How reliably a landmark has been found so far (the failure counter and the score of paper 4, section 2.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Number of searches that found the landmark.
    pub n_found: usize,
    /// Number of searches since it was last found.
    pub n_failures: usize,
    /// Zero-mean normalised cross-correlation when it was last found; 0 if it never was.
    pub zncc: f64,
}

/// Failures in a row after which a landmark is retired: at 30 images a second, a person who passes takes less than this.
const MOST_FAILURES: usize = 30;

impl Record {
    /// Notes the result of a search in an image that should show the landmark.
    pub fn note(&mut self, result: &Result<Sighting, Refusal>) {
        match result {
            Ok(sighting) => *self = Record { n_found: self.n_found + 1, n_failures: 0, zncc: sighting.zncc },
            // Where something else looks alike, the landmark may well be in view.
            Err(Refusal::Ambiguous { .. }) => {}
            Err(_) => self.n_failures += 1,
        }
    }

    /// Whether the landmark should no longer be searched.
    pub fn is_retired(&self) -> bool {
        self.n_failures >= MOST_FAILURES
    }
}
