//! The tone curve by which grey levels are shown: the same for tone-mapped pictures, contact sheets and figures.

use image::{GrayImage, Luma};

use crate::render::DeepImage;

/// Share of a picture's pixels that are shown as black.
const BLACK_SHARE: f64 = 0.005;
/// Share of a picture's pixels that are darker than the knee of the tone curve, the grey level at which its slope changes. Lamps and marker dots are
/// among the pixels above the knee.
const KNEE_SHARE: f64 = 0.95;
/// Grey at which the knee of the tone curve is shown, from 0 for black to 1 for white. Brighter levels share the rest of the range, so that
/// marker dots stand out from a bright ceiling.
const KNEE_SHOWN: f64 = 0.85;
/// Least distance in levels of the knee of the tone curve from black. A smaller one would stretch noise of one level to the contrast of a picture.
const KNEE_LEVELS: f64 = 16.0;
/// Grey at which a picture's median should be shown, from 0 for black to 1 for white.
const MEDIAN_SHOWN: f64 = 0.38;
/// Least and greatest exponent of the tone curve. Exponents beyond them leave a picture flat or black; a screen's own gamma lies between them.
const EXPONENTS: [f64; 2] = [0.25, 0.8];

/// A tone curve: the grey levels that are shown as black and as white, the knee, and the curve between black and the knee.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tones {
    /// Level that is shown as black, as are all darker levels.
    pub(super) black: u16,
    /// Level that is shown as white: the brightest level in the picture.
    pub(super) white: u16,
    knee: f64,
    knee_shown: f64,
    exponent: f64,
}

impl Tones {
    /// The tone curve for a picture's grey levels. It brings the median to a middle grey, which makes an image of 3 lx as legible as one of 300, with
    /// or without a lamp in it. Above the curve's knee a straight shoulder keeps bright levels apart.
    pub(super) fn of(levels: impl Iterator<Item = u16>) -> Tones {
        let mut counts = vec![0_usize; 1 << 16];
        levels.for_each(|level| counts[usize::from(level)] += 1);
        let total: usize = counts.iter().sum();
        let quantile = |share: f64| {
            let mut below = 0;
            let found = counts.iter().position(|count| {
                below += count;
                below as f64 > share * total as f64
            });
            found.and_then(|level| u16::try_from(level).ok()).unwrap_or(0)
        };
        let brightest = counts.iter().rposition(|count| *count > 0).and_then(|level| u16::try_from(level).ok());
        let (black, white) = (quantile(BLACK_SHARE), brightest.unwrap_or(0));
        let knee = f64::from(quantile(KNEE_SHARE)).max(f64::from(black) + KNEE_LEVELS);
        // Where no level is brighter than the tone curve's knee, the knee itself is shown as white.
        let knee_shown = if knee < f64::from(white) { KNEE_SHOWN } else { 1.0 };
        let median = f64::from(quantile(0.5) - black) / (knee - f64::from(black));
        // A picture whose median grey level equals the black level stays black there: a dark ceiling is shown dark.
        let exponent = if median > 0.0 { (MEDIAN_SHOWN / knee_shown).ln() / median.ln() } else { 1.0 };
        // A median at the knee of the tone curve has the relative level 1, of logarithm 0, and is shown equally bright with any exponent.
        let exponent = if exponent < 0.0 { EXPONENTS[1] } else { exponent.clamp(EXPONENTS[0], EXPONENTS[1]) };
        Tones { black, white, knee, knee_shown, exponent }
    }

    /// Grey at which a level is shown, from 0 for black to 1 for white.
    pub(super) fn share(&self, level: u16) -> f64 {
        let (level, black) = (f64::from(level), f64::from(self.black));
        if level <= self.knee {
            return self.knee_shown * ((level - black).max(0.0) / (self.knee - black)).powf(self.exponent);
        }
        // Only a level above the tone curve's knee reaches this line. The picture's brightest level, which is shown as white, is then above the knee,
        // too, and the divisor not 0.
        self.knee_shown + (1.0 - self.knee_shown) * (level - self.knee) / (f64::from(self.white) - self.knee)
    }
}

/// The picture as a screen shows it, tone-mapped from all bits that the sensor gave.
pub fn tone_mapped(levels: &DeepImage) -> GrayImage {
    let tones = Tones::of(levels.as_raw().iter().copied());
    GrayImage::from_fn(levels.width(), levels.height(), |u, v| {
        let Luma([level]) = *levels.get_pixel(u, v);
        Luma([(255.0 * tones.share(level)).round() as u8])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tone curve of a picture with the given number of pixels of each level.
    fn tones(counts: &[(u16, usize)]) -> Tones {
        Tones::of(counts.iter().flat_map(|(level, count)| std::iter::repeat_n(*level, *count)))
    }

    /// The greys, 0 to 255, at which each level of a picture is shown.
    fn shown(counts: &[(u16, usize)]) -> Vec<f64> {
        let mapping = tones(counts);
        counts.iter().map(|(level, _)| (255.0 * mapping.share(*level)).round()).collect()
    }

    /// A made-up histogram of `count` pixels whose grey levels are spread by Gaussian noise around the level `middle`.
    fn noise(middle: f64, deviation: f64, count: f64) -> Vec<(u16, usize)> {
        let share = |level: u16| (-0.5 * ((f64::from(level) - middle) / deviation).powi(2)).exp() / deviation / 2.507;
        let levels = 0..(middle + 5.0 * deviation) as u16;
        levels.map(|level| (level, (count * share(level)) as usize)).filter(|(_, count)| *count > 0).collect()
    }

    #[test]
    fn dots_stay_apart_from_a_bright_ceiling() {
        let mut counts = noise(161.0, 5.0, 300_000.0);
        counts.insert(0, (40, 9_000));
        counts.push((255, 300));
        let [ceiling, dots] = [161, 255].map(|level| 255.0 * tones(&counts).share(level));
        assert_eq!(dots, 255.0);
        assert!(dots - ceiling > 30.0, "{ceiling}");
        // A bright ceiling that fills the picture is shown darker, which leaves more contrast between the ceiling and the marker dots.
        let mut counts = noise(161.0, 5.0, 300_000.0);
        counts.push((255, 300));
        let ceiling = 255.0 * tones(&counts).share(161);
        assert!(255.0 - ceiling > 80.0, "{ceiling}");
    }

    #[test]
    fn beside_a_lamp_the_room_stays_legible() {
        for lamp in [3_000, 10_000] {
            let shown = shown(&[(1, 20_000), (2, 30_000), (4, 30_000), (9, 20_000), (255, lamp)]);
            assert!((60.0..=140.0).contains(&shown[2]), "{shown:?}");
            assert!(shown.windows(2).all(|pair| pair[1] - pair[0] > 15.0), "{shown:?}");
            assert_eq!(shown[4], 255.0);
        }
    }

    #[test]
    fn twelve_bits_keep_levels_that_eight_would_not() {
        // Sixteen neighbouring levels of a 12-bit sensor that share their eight most significant bits.
        let counts: Vec<(u16, usize)> = (2048..2064).map(|level| (level, 100)).collect();
        let shown = shown(&counts);
        assert!(shown.windows(2).all(|pair| pair[1] - pair[0] >= 4.0), "{shown:?}");
    }

    #[test]
    fn noise_of_a_dark_picture_spreads_over_the_greys() {
        // The histogram of an image taken at a tenth of a lux: noise with a few pixels at level 0, and one lamp.
        let mut counts = noise(31.0, 16.0, 300_000.0);
        counts.push((255, 10));
        let [dark, middle, light] = [0, 31, 57].map(|level| 255.0 * tones(&counts).share(level));
        assert!(dark == 0.0 && (60.0..=140.0).contains(&middle) && light > 200.0, "{dark} {middle} {light}");
    }

    #[test]
    fn a_dark_ceiling_stays_dark_and_its_dots_shine() {
        let shown = shown(&[(16, 77_000), (17, 22_700), (173, 200), (255, 100)]);
        assert!(shown[0] == 0.0 && shown[1] < 40.0 && shown[2] > 220.0 && shown[3] == 255.0, "{shown:?}");
    }

    #[test]
    fn an_empty_picture_and_one_of_a_single_level_are_shown() {
        assert_eq!(shown(&[]), Vec::<f64>::new());
        assert_eq!(shown(&[(7, 10)]), [0.0]);
        assert_eq!(shown(&[(u16::MAX, 10)]), [0.0]);
        assert_eq!(tone_mapped(&DeepImage::new(0, 0)).dimensions(), (0, 0));
    }
}
