//! Landmarks: surface points that can be found again by how their surroundings look.

use super::{
    descriptor::{BITS, Descriptor},
    patch::Patch,
    search::{Refusal, Sighting},
};

/// Length of a landmark as bytes: three numbers, two descriptors, and the grey levels of the patch.
const N_BYTES: usize = 3 * 8 + 2 * (BITS / 8) + Patch::N_LEVELS;
/// Length of a focal length, which follows where it is known.
const N_BYTES_FOCAL: usize = 8;

/// A surface point that an image showed, with all that is needed to find it in other images.
///
/// The point is *defined* as the one that the image showed at [`position_px`](Self::position_px()): this position has no error of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    pub(super) position_px: [f64; 2],
    /// Focal length, in pixels, of the camera that took the image; `None` in maps of a time at which it was not kept.
    pub(super) focal_px: Option<f64>,
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

    /// Focal length, in pixels, of the camera that took the image that the landmark was created from, if it is known.
    pub fn focal_px(&self) -> Option<f64> {
        self.focal_px
    }

    /// Size at which a camera with another focal length, in pixels, shows the landmark from the same place, as a multiple of that in its own image. A
    /// landmark of an unknown camera is taken to be of one like this.
    pub fn enlargement(&self, focal_px: f64) -> f64 {
        self.focal_px.map_or(1.0, |own_px| focal_px / own_px)
    }

    /// The landmark as bytes for a file: position and direction, both descriptors, the grey levels of the patch, and the focal length if it is known.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = [self.position_px[0], self.position_px[1], self.direction_rad].map(f64::to_le_bytes);
        let mut bytes = numbers.concat();
        for descriptor in [&self.upright, &self.turned] {
            descriptor.words().iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        }
        bytes.extend(self.patch.levels());
        bytes.extend(self.focal_px.iter().flat_map(|focal_px| focal_px.to_le_bytes()));
        bytes
    }

    /// The landmark that bytes encode; `None` where they are of another length, or their numbers are not finite or the focal length not positive.
    pub fn from_bytes(bytes: &[u8]) -> Option<Landmark> {
        let (bytes, focal) = bytes.split_at_checked(N_BYTES)?;
        let focal_px = match <[u8; N_BYTES_FOCAL]>::try_from(focal) {
            Ok(focal) => Some(f64::from_le_bytes(focal)),
            Err(_) if focal.is_empty() => None,
            Err(_) => return None,
        };
        let word = |index: usize| bytes[8 * index..][..8].try_into().map(u64::from_le_bytes).unwrap_or_default();
        let [u, v, direction_rad] = [0, 1, 2].map(|index| f64::from_bits(word(index)));
        let descriptor = |first: usize| Descriptor::of_words(std::array::from_fn(|index| word(first + index)));
        let (upright, turned) = (descriptor(3), descriptor(3 + BITS / 64));
        let patch = Patch::of_levels(&bytes[N_BYTES - Patch::N_LEVELS..]);
        let is_finite = [u, v, direction_rad].iter().all(|number| number.abs() < 1e6);
        let is_focal = focal_px.is_none_or(|focal_px| (1.0..1e6).contains(&focal_px));
        (is_finite && is_focal).then_some(Landmark {
            position_px: [u, v],
            focal_px,
            upright,
            direction_rad,
            turned,
            patch,
        })
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
