//! Trials of the front end on synthetic images: what it claims is compared with the truth.

use interval::Interval;

use super::synthetic::{Eye, Texture};
use super::{Frame, ImageBounds, Landmark, Refusal, Search};
use crate::vision::synthetic::Random;

/// Number of pairs of images of a trial; the environment variable `WHEREIN_FEATURE_PAIRS` sets another number for a long trial.
pub(super) fn pairs(usual: usize) -> usize {
    std::env::var("WHEREIN_FEATURE_PAIRS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Random seed of a trial: `usual`, unless the environment variable `WHEREIN_FEATURE_SEED` sets another.
pub(super) fn seed(usual: u64) -> u64 {
    std::env::var("WHEREIN_FEATURE_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Sightings that are farther than this from the truth show something else.
const WRONG_PX: f64 = 3.0;

/// Results of searching landmarks in a number of images.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    pub(super) created: usize,
    /// Number of landmarks whose patch is wholly in the second image.
    pub(super) in_view: usize,
    pub(super) found: usize,
    /// Number of sightings that show something else, and of those that show the landmark but outside of the claim.
    pub(super) wrong: usize,
    pub(super) false_claims: usize,
    /// Greatest error of a right sighting in units of its claim, along either axis.
    pub(super) worst: f64,
    pub(super) squares: f64,
    pub(super) half_widths_px: Vec<f64>,
    /// Number of searches refused for each reason: nothing alike, not aligned, unlike, vague, ambiguous.
    pub(super) refused: [usize; 5],
}

/// How a landmark is searched: half of the side of the region, and the share by which the scale and the angle by which the turn may differ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) half_px: f64,
    pub(super) scale_share: f64,
    pub(super) turn_rad: f64,
}

impl Tally {
    pub(super) fn found_share(&self) -> f64 {
        self.found as f64 / self.in_view.max(1) as f64
    }

    pub(super) fn median_half_width_px(&self) -> f64 {
        let mut widths = self.half_widths_px.clone();
        widths.sort_by(f64::total_cmp);
        widths.get(widths.len() / 2).copied().unwrap_or(f64::NAN)
    }

    pub(super) fn print(&self, name: &str) {
        println!(
            "{name:18} created {:6}  found {:6}/{:6} ({:4.1} %)  wrong {}  false {}  \
             worst {:.2}  rms {:.4} px  half {:.3} px  refused {:?}",
            self.created,
            self.found,
            self.in_view,
            100.0 * self.found_share(),
            self.wrong,
            self.false_claims,
            self.worst,
            (self.squares / (2.0 * (self.found - self.wrong).max(1) as f64)).sqrt(),
            self.median_half_width_px(),
            self.refused,
        );
    }

    pub(super) fn merge(&mut self, other: &Tally) {
        self.created += other.created;
        self.in_view += other.in_view;
        self.found += other.found;
        self.wrong += other.wrong;
        self.false_claims += other.false_claims;
        self.worst = self.worst.max(other.worst);
        self.squares += other.squares;
        self.half_widths_px.extend_from_slice(&other.half_widths_px);
        (0..5).for_each(|why| self.refused[why] += other.refused[why]);
    }

    /// Takes both images, creates landmarks in the first, searches them in the second, and compares what is claimed with the truth.
    pub(super) fn add(&mut self, texture: Texture, eyes: [&Eye; 2], prior: Prior, random: &mut Random) {
        let pictures = eyes.map(|eye| eye.picture(texture, random));
        let bounds = declared(eyes);
        let landmarks = Frame::new(&pictures[0], &bounds).landmarks(60);
        let mut frame = Frame::new(&pictures[1], &bounds);
        self.created += landmarks.len();
        for landmark in &landmarks {
            let truth_px = eyes[1].project(eyes[0].on_plane(landmark.position_px()));
            let (scale, turn_rad) = seen_as(eyes, landmark);
            let margin_px = 15.0 * scale.max(1.0) + 3.0;
            let is_inside = |axis: usize| {
                truth_px[axis] > margin_px && truth_px[axis] < eyes[1].size_px[axis] as f64 - 1.0 - margin_px
            };
            if !is_inside(0) || !is_inside(1) {
                continue;
            }
            self.in_view += 1;
            let around =
                |mid: f64, half: f64, random: &mut Random| Interval::centred(mid + random.between(-half, half), half);
            let region = truth_px.map(|at| around(at, prior.half_px, random));
            let scales = around(scale.ln(), prior.scale_share, random).exp();
            let turns = around(turn_rad, prior.turn_rad, random);
            match frame.find(landmark, &Search::in_box(region, scales, turns)) {
                Ok(sighting) => {
                    self.found += 1;
                    let errors = [0, 1].map(|axis| sighting.position_px[axis] - truth_px[axis]);
                    if errors[0].hypot(errors[1]) > WRONG_PX * scale.max(1.0) {
                        self.wrong += 1;
                        continue;
                    }
                    let shares = [0, 1].map(|axis| errors[axis].abs() / sighting.half_width_px[axis]);
                    let worst = shares[0].max(shares[1]);
                    self.worst = self.worst.max(worst);
                    self.false_claims += usize::from(worst > 1.0);
                    self.squares += errors[0].powi(2) + errors[1].powi(2);
                    self.half_widths_px.push(sighting.half_width_px[0].max(sighting.half_width_px[1]));
                }
                Err(why) => {
                    let idx = match why {
                        Refusal::NothingAlike => 0,
                        Refusal::NotAligned => 1,
                        Refusal::Unlike { .. } => 2,
                        Refusal::Vague { .. } => 3,
                        Refusal::Ambiguous { .. } => 4,
                    };
                    self.refused[idx] += 1;
                }
            }
        }
    }
}

/// Numbers of landmarks of one texture that are found in an image of another one, which shows none of them: in a region of 20 × 20 px, and anywhere
/// in the image at any turn; and the number of those searched.
pub(super) fn found_elsewhere(textures: [Texture; 2], eye: &Eye, random: &mut Random) -> [usize; 3] {
    let pictures = textures.map(|texture| eye.picture(texture, random));
    let bounds = declared([eye; 2]);
    let landmarks = Frame::new(&pictures[0], &bounds).landmarks(60);
    let mut frame = Frame::new(&pictures[1], &bounds);
    let region = eye.size_px.map(|size| Interval::new(0.0, size as f64));
    let anywhere = Search::in_box(region, Interval::new(0.7, 1.4), Interval::new(-3.2, 3.2));
    let mut found = [0, 0];
    for landmark in &landmarks {
        let region = landmark.position_px().map(|at| Interval::centred(at, 10.0));
        let near = Search::in_box(region, Interval::new(0.9, 1.1), Interval::new(-0.1, 0.1));
        found[0] += usize::from(frame.find(landmark, &near).is_ok());
        found[1] += usize::from(frame.find(landmark, &anywhere).is_ok());
    }
    [found[0], found[1], landmarks.len()]
}

/// Bounds that both cameras keep.
fn declared(eyes: [&Eye; 2]) -> ImageBounds {
    let most = |of: fn(&Eye) -> f64| of(eyes[0]).max(of(eyes[1]));
    // The line of sight to the image's corner is slanted against the optical axis too.
    let corner = eyes[1].size_px.map(|size| 0.5 * size as f64 / eyes[1].focal_px);
    ImageBounds {
        focal_px: eyes[0].focal_px,
        slant: (most(|eye| eye.slant_rad) + corner[0].hypot(corner[1]).atan()).min(1.2).tan(),
        dark_noise_grey: most(|eye| eye.dark_noise_grey),
        electrons_per_grey: -most(|eye| -eye.electrons_per_grey),
    }
}

/// True scale of a landmark in the second image against the first, and its turn, from how small steps of the first image map to the second.
fn seen_as(eyes: [&Eye; 2], landmark: &Landmark) -> (f64, f64) {
    let [u, v] = landmark.position_px();
    let map = |at_px: [f64; 2]| eyes[1].project(eyes[0].on_plane(at_px));
    let step = |du: f64, dv: f64| {
        let ends = [map([u + du, v + dv]), map([u - du, v - dv])];
        [0, 1].map(|axis| (ends[0][axis] - ends[1][axis]) / 2.0)
    };
    let (along_u, along_v) = (step(1.0, 0.0), step(0.0, 1.0));
    let scale = (along_u[0] * along_v[1] - along_u[1] * along_v[0]).sqrt();
    // The nearest rotation of a map with columns a and b turns by atan2(a_v − b_u, a_u + b_v).
    (scale, (along_u[1] - along_v[0]).atan2(along_u[0] + along_v[1]))
}
