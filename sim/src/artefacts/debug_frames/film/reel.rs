//! What is kept during a run so that its film can be drawn at the end: small pictures of the cameras, at equal steps of time.

use std::sync::Arc;

use image::GrayImage;
use localizer::{Estimate, Pose, Reading, localizer::Account, reading::Camera};

use crate::{devices::Observation, run::Witness, truth::Truth};

use super::super::camera_view;

/// How long a frame is shown, in hundredths of a second: 8 frames a second.
pub(super) const FRAME_HUNDREDTHS: u16 = 12;
/// Number of steps of 10 ms from one frame to the next in a film that is as fast as the run was.
const REAL_TIME_STEPS: usize = FRAME_HUNDREDTHS as usize;
/// Greatest number of frames before the outcome: a film of 20 s. When a run lasts longer, every other frame is dropped and the film made twice as
/// fast, so that it lasts 10 s to 20 s and needs the same memory however long the run is.
const MOST_FRAMES: usize = 166;
/// Width in which pictures are kept; the greatest in which a film shows one.
const KEPT_WIDTH_PX: u32 = 300;

/// Follows a run and keeps what its film shows of the cameras; the rest is in the record of the run.
#[derive(Clone, Debug, Default)]
pub struct Reel {
    /// Latest image of each camera, in the order of [`Camera::ALL`].
    latest: [Option<Exposed>; 3],
    samples: Vec<Sample>,
    /// How often the number of frames has been halved.
    halvings: u32,
    n_steps: usize,
    offset_s: f64,
}

/// What the cameras had given by a step of the run.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Index of the step in the record of the run.
    pub(super) step: usize,
    /// Latest picture of each camera, in the order of [`Camera::ALL`].
    pub(super) pictures: Pictures,
}

/// The latest picture of each camera, in the order of [`Camera::ALL`]; `None` for a camera that has given none.
pub(super) type Pictures = [Option<Arc<Picture>>; 3];

/// One image as a film shows it.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    /// The image, tone-mapped and made small.
    pub(super) shown: GrayImage,
    /// Width of the image itself.
    pub(super) width_px: u32,
    /// Stamp of the image, counted from the start of the run.
    pub(super) measured_s: f64,
    /// Exposure time of the image.
    pub(super) exposure_s: f64,
}

/// An image as a camera gave it, and the picture made of it once a sample needs one.
#[derive(Clone, Debug)]
struct Exposed {
    image: Arc<GrayImage>,
    measured_s: f64,
    exposure_s: f64,
    picture: Option<Arc<Picture>>,
}

impl Reel {
    /// The samples for the frames before the outcome.
    pub(super) fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// What the cameras gave last.
    pub(super) fn last_pictures(&self) -> Pictures {
        self.latest.clone().map(|latest| latest.map(|mut exposed| exposed.picture()))
    }

    /// How many times as fast as the run the film is.
    pub(super) fn speed(&self) -> usize {
        1 << self.halvings
    }

    /// Keeps a sample if a frame is due at this step. The first is due one interval after the start, when the cameras have given their first images.
    fn sample(&mut self, step: usize) {
        if step == 0 || !step.is_multiple_of(REAL_TIME_STEPS * self.speed()) {
            return;
        }
        if self.samples.len() == MOST_FRAMES {
            self.halvings += 1;
            let stride = REAL_TIME_STEPS * self.speed();
            self.samples.retain(|sample| sample.step.is_multiple_of(stride));
            return self.sample(step);
        }
        let pictures = self.latest.each_mut().map(|latest| latest.as_mut().map(Exposed::picture));
        self.samples.push(Sample { step, pictures });
    }
}

impl Exposed {
    fn picture(&mut self) -> Arc<Picture> {
        let made = || {
            let (width_px, height_px) = self.image.dimensions();
            let kept_height_px = (KEPT_WIDTH_PX * height_px).div_ceil(width_px.max(1)).max(1);
            Arc::new(Picture {
                shown: camera_view::shown(&self.image, KEPT_WIDTH_PX, kept_height_px),
                width_px,
                measured_s: self.measured_s,
                exposure_s: self.exposure_s,
            })
        };
        self.picture.get_or_insert_with(made).clone()
    }
}

impl Witness for Reel {
    fn start(&mut self, offset_s: f64, _station: Option<usize>) {
        self.offset_s = offset_s;
    }

    fn sense(&mut self, observation: &Observation) {
        let Reading::Camera { measured_s, camera, exposure_s, image, .. } = &observation.reading else { return };
        let Some(index) = Camera::ALL.iter().position(|name| name == camera) else { return };
        let (image, measured_s) = (Arc::clone(image), measured_s + self.offset_s);
        self.latest[index] = Some(Exposed { image, measured_s, exposure_s: *exposure_s, picture: None });
    }

    fn account(&mut self, _reading: &Reading, _accounts: &[Account]) {}

    fn step(&mut self, _truth: &Truth, _estimate: &Estimate, _odometry: Pose) {
        self.sample(self.n_steps);
        self.n_steps += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps at which a reel keeps samples of a run of so many steps, and the speed of the film.
    fn kept(n_steps: usize) -> (Vec<usize>, usize) {
        let mut reel = Reel::default();
        (0..n_steps).for_each(|step| reel.sample(step));
        (reel.samples.iter().map(|sample| sample.step).collect(), reel.speed())
    }

    #[test]
    fn however_long_a_run_is_its_film_lasts_10_to_20_seconds_and_has_equal_steps() {
        assert_eq!(kept(26), (vec![12, 24], 1));
        for n_steps in [1_000, 2_000, 9_959, 24_000, 360_000] {
            let (steps, speed) = kept(n_steps);
            let lasts_s = steps.len() as f64 * 0.12;
            assert!((9.9..=20.0).contains(&lasts_s), "{n_steps} steps: {lasts_s} s");
            let interval = 12 * speed;
            let expected: Vec<usize> = (1..).map(|index| index * interval).take_while(|step| *step < n_steps).collect();
            assert_eq!(steps, expected, "{n_steps} steps at {speed} times the speed");
        }
    }
}
