//! How grey levels are shown: one mapping for tone-mapped pictures, contact sheets and figures.

use image::{GrayImage, Luma};

use crate::render::DeepImage;

/// Share of the pixels that are shown as black.
const BLACK_SHARE: f64 = 0.005;
/// Share of the pixels below the knee; lamps and dots are among the rest.
const KNEE_SHARE: f64 = 0.95;
/// Where in the range of greys the knee is shown; what is brighter shares the rest, so that dots stand out from a bright ceiling.
const KNEE_SHOWN: f64 = 0.85;
/// A knee nearer to black than this would make noise of one level as bright as a picture.
const KNEE_LEVELS: f64 = 16.0;
/// Where the median should be shown.
const MEDIAN_SHOWN: f64 = 0.38;
/// Exponents beyond these leave a picture flat or black. A screen's own gamma is between them.
const EXPONENTS: [f64; 2] = [0.25, 0.8];

/// Grey levels that are shown as black, as light and as white, and the curve between the first two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tones {
    /// Shown as black, with what is darker.
    pub(super) black: u16,
    /// Shown as white: the brightest there is.
    pub(super) white: u16,
    knee: f64,
    knee_shown: f64,
    exponent: f64,
}

impl Tones {
    /// Of a picture's levels: the curve brings the median to a middle grey, which makes an image of 3 lx as legible as one of 300, with
    /// a lamp in it or without; above the knee a straight shoulder keeps apart what is bright.
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
        // Where nothing is brighter than the knee, white is left for the knee itself.
        let knee_shown = if knee < f64::from(white) { KNEE_SHOWN } else { 1.0 };
        let median = f64::from(quantile(0.5) - black) / (knee - f64::from(black));
        // A median at black stays there: a dark ceiling is dark.
        let exponent = if median > 0.0 { (MEDIAN_SHOWN / knee_shown).ln() / median.ln() } else { 1.0 };
        // At the knee itself, of logarithm 0, the median is shown as bright however it is bent.
        let exponent = if exponent < 0.0 { EXPONENTS[1] } else { exponent.clamp(EXPONENTS[0], EXPONENTS[1]) };
        Tones { black, white, knee, knee_shown, exponent }
    }

    /// From 0 for black to 1 for white.
    pub(super) fn share(&self, level: u16) -> f64 {
        let (level, black) = (f64::from(level), f64::from(self.black));
        if level <= self.knee {
            return self.knee_shown * ((level - black).max(0.0) / (self.knee - black)).powf(self.exponent);
        }
        // Only where there are levels above the knee.
        self.knee_shown + (1.0 - self.knee_shown) * (level - self.knee) / (f64::from(self.white) - self.knee)
    }
}

/// A picture as a screen shows it, from all bits that the sensor gave.
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

    /// Of a picture of so many pixels of each level.
    fn tones(counts: &[(u16, usize)]) -> Tones {
        Tones::of(counts.iter().flat_map(|(level, count)| std::iter::repeat_n(*level, *count)))
    }

    /// What is shown of each of its levels.
    fn shown(counts: &[(u16, usize)]) -> Vec<f64> {
        let mapping = tones(counts);
        counts.iter().map(|(level, _)| (255.0 * mapping.share(*level)).round()).collect()
    }

    /// So many pixels, of levels about a middle as noise spreads them.
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
        // On a ceiling that fills the picture there is more room below it.
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
        // Sixteen levels that share their eight most significant bits.
        let counts: Vec<(u16, usize)> = (2048..2064).map(|level| (level, 100)).collect();
        let shown = shown(&counts);
        assert!(shown.windows(2).all(|pair| pair[1] - pair[0] >= 4.0), "{shown:?}");
    }

    #[test]
    fn noise_of_a_dark_picture_spreads_over_the_greys() {
        // As a tenth of a lux gives them, a few at level 0, and one lamp.
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
