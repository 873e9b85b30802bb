//! Factors on the standard deviations of the built-in filters.

use std::{fmt, str::FromStr};

use crate::scene::{FACTORS, FilterNoise};

/// Factors on a filter's standard deviations that the option `--subject` states, as in `ekf,motion=2,cues=0.5`. For one that it does not state, that
/// of the scene holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tuning {
    /// Factor for all errors of the motion sensors: their noise, their slip, and the errors of their constants.
    pub motion: Option<f64>,
    /// Factor for the noise of all other measurements; the errors of mounts, scales and floor plan, which last, are not multiplied.
    pub cues: Option<f64>,
}

impl Tuning {
    /// The factors that hold with a scene's own.
    pub(crate) fn over(self, of_scene: FilterNoise) -> FilterNoise {
        FilterNoise { motion: self.motion.unwrap_or(of_scene.motion), cues: self.cues.unwrap_or(of_scene.cues) }
    }
}

impl fmt::Display for Tuning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, factor) in [("motion", self.motion), ("cues", self.cues)] {
            if let Some(factor) = factor {
                write!(f, ",{name}={factor}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Tuning {
    type Err = String;

    /// Reads factors that are separated by commas, each at most once. Errors for anything else, with what was expected.
    fn from_str(text: &str) -> Result<Tuning, String> {
        let mut tuning = Tuning::default();
        for part in text.split(',') {
            let (name, factor) = part.split_once('=').unwrap_or((part, ""));
            let factor = factor.parse().ok().filter(|factor: &f64| (FACTORS[0]..=FACTORS[1]).contains(factor));
            let place = match name {
                "motion" => &mut tuning.motion,
                "cues" => &mut tuning.cues,
                _ => return Err(unexpected(part)),
            };
            if place.is_some() {
                return Err(format!("`{name}` is stated twice, expected it once"));
            }
            *place = Some(factor.ok_or_else(|| unexpected(part))?);
        }
        Ok(tuning)
    }
}

fn unexpected(part: &str) -> String {
    let [least, greatest] = FACTORS;
    format!("`{part}`: expected motion=FACTOR or cues=FACTOR, with a number from {least} to {greatest}")
}
