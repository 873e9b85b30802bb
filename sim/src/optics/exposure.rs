//! Exposure time and gain of a camera: the conversion of luminance to electrons, and automatic exposure.

use std::f64::consts::PI;

use image::GrayImage;

use crate::scene::SensorModel;

/// Photons at 555 nm per second, square metre and lux.
///
/// 1 lx = 1 lm/m² = (1/683) W/m² at 555 nm (the definition of the candela), and a photon carries
/// h·c/λ = 6.62607e-34 · 2.99792e8 / 555e-9 = 3.5792e-19 J.
const PHOTONS_PER_LUX_SECOND_M2: f64 = 1.0 / 683.0 / (6.626_070_15e-34 * 299_792_458.0 / 555e-9);

impl SensorModel {
    /// Electrons that an exposure collects in a pixel, per cd/m² of luminance of the surface seen.
    ///
    /// The illuminance on the sensor is E = (π/4)·L/N² (thin lens, far object, no vignetting), and electrons = E · pitch² · t · QE · photons per lux
    /// second and square metre.
    pub fn electrons_per_luminance(&self, exposure_s: f64) -> f64 {
        PI / 4.0 / self.f_number.powi(2)
            * self.pixel_pitch_m.powi(2)
            * exposure_s
            * self.quantum_efficiency
            * PHOTONS_PER_LUX_SECOND_M2
    }
}

/// Exposure time and gain of one image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Length of the exposure.
    pub exposure_s: f64,
    /// Gain in grey levels, at the sensor's own bit depth, per electron.
    pub gain_levels_per_electron: f64,
}

/// Automatic exposure: each image is exposed by what was measured in the image before it, so that a switched lamp spoils one or two images. If the
/// sensor's exposure is fixed, all images are exposed alike.
#[derive(Clone, Debug)]
pub struct AutoExposure {
    max_exposure_s: f64,
    /// Least and greatest gain, in levels of eight bits per electron.
    gain_range: [f64; 2],
    /// Exposure time of the next image, and its gain in levels of eight bits per electron.
    next: Exposure,
    /// Black level of the sensor, in levels of eight bits.
    black_level: f64,
    levels_per_byte_level: f64,
    is_fixed: bool,
    /// Greatest share of an image's pixels that automatic exposure lets be brighter than [`HIGHLIGHT_LEVEL`].
    highlight_share: f64,
}

/// Mean grey level that automatic exposure aims at. It is below the middle of the range, as camera makers choose it, to leave room for highlights.
const TARGET_MEAN_LEVEL: f64 = 110.0;
/// Grey level that only a given share of the pixels, the highlights, may exceed. It lies below white, so that noise does not saturate the pixels just
/// below it.
const HIGHLIGHT_LEVEL: f64 = 215.0;
/// Factor by which exposure is reduced after an image that is white all over, as such an image shows only that it got too much light. With this
/// factor, two images suffice to find the right exposure after any switch of lamps that changes the light by up to 40 times.
const STRONGEST_STEP_DOWN: f64 = 20.0;
/// Greatest factor by which exposure is raised at once, as a dark image is mostly noise.
const STRONGEST_STEP_UP: f64 = 32.0;
/// Shortest exposure that the simulated global-shutter sensors can take.
const SHORTEST_EXPOSURE_S: f64 = 1e-5;
/// Illuminance for which the first image is exposed: office light, on a floor of albedo 0.5.
const FIRST_ILLUMINANCE_LUX: f64 = 300.0;
const FIRST_ALBEDO: f64 = 0.5;

impl AutoExposure {
    /// Automatic exposure in its state before the first image, which is exposed for a floor in office light unless the exposure is fixed.
    pub fn new(sensor: &SensorModel) -> AutoExposure {
        let levels_per_byte_level = sensor.bits.levels_per_byte_level();
        let black_level = sensor.black_level / levels_per_byte_level;
        let max_gain = sensor.max_gain_levels_per_electron / levels_per_byte_level;
        // With less gain than this, the upper grey levels would not be used: at this gain a pixel whose well is full of electrons has the last level.
        let min_gain = (255.0 - black_level) / sensor.full_well_electrons;
        let gain_range = [min_gain.min(max_gain), max_gain];
        let luminance = FIRST_ALBEDO * FIRST_ILLUMINANCE_LUX / PI;
        let electrons_per_s = luminance * sensor.electrons_per_luminance(1.0);
        let mut control = AutoExposure {
            max_exposure_s: sensor.longest_exposure_s,
            gain_range,
            next: Exposure { exposure_s: sensor.longest_exposure_s, gain_levels_per_electron: gain_range[0] },
            black_level,
            levels_per_byte_level,
            is_fixed: sensor.is_fixed,
            highlight_share: sensor.highlight_share,
        };
        if !control.is_fixed {
            control.aim_at(TARGET_MEAN_LEVEL / electrons_per_s);
        }
        control
    }

    /// Exposure of the next image.
    pub fn exposure(&self) -> Exposure {
        let gain_levels_per_electron = self.next.gain_levels_per_electron * self.levels_per_byte_level;
        Exposure { gain_levels_per_electron, ..self.next }
    }

    /// Exposure of the next image if its exposure time may not be longer than `longest_s`. A higher gain makes up for the missing light, up to the
    /// sensor's greatest gain.
    pub fn exposure_within(&self, longest_s: f64) -> Exposure {
        let wanted = self.exposure();
        if wanted.exposure_s <= longest_s {
            return wanted;
        }
        let product = self.next.exposure_s * self.next.gain_levels_per_electron;
        let gain = (product / longest_s).min(self.gain_range[1]);
        Exposure { exposure_s: longest_s, gain_levels_per_electron: gain * self.levels_per_byte_level }
    }

    /// Greatest gain that any image can have, in grey levels of the sensor's own bit depth per electron.
    pub fn greatest_gain_levels_per_electron(&self) -> f64 {
        self.gain_range[usize::from(!self.is_fixed)] * self.levels_per_byte_level
    }

    /// Measures the brightness of an image that was exposed as [`AutoExposure::exposure`] says, in order to set the next exposure. `image` holds the
    /// eight most significant bits.
    pub fn meter(&mut self, image: &GrayImage) {
        self.meter_exposed(image, self.exposure());
    }

    /// Measures the brightness of an image whose exposure time and gain were `exposed`, in order to set the next exposure. `image` holds the eight
    /// most significant bits.
    pub fn meter_exposed(&mut self, image: &GrayImage, exposed: Exposure) {
        if self.is_fixed {
            return;
        }
        let pixels = image.as_raw();
        let mut histogram = [0_usize; 256];
        for &level in pixels {
            histogram[usize::from(level)] += 1;
        }
        let sum: usize = histogram.iter().enumerate().map(|(level, count)| level * count).sum();
        let mean = sum as f64 / pixels.len().max(1) as f64 - self.black_level;
        let brightest = level_exceeded_by(&histogram, self.highlight_share * pixels.len() as f64);
        let highlight = brightest - self.black_level;
        let white = histogram[255] as f64 / pixels.len().max(1) as f64;
        let change = if white > 0.5 {
            1.0 / STRONGEST_STEP_DOWN
        } else if brightest >= 255.0 {
            // The image is clipped, so that the light is more than its mean grey level shows. The exposure is therefore reduced to 0.6 of what the
            // mean demands.
            (TARGET_MEAN_LEVEL / mean.max(0.1)).min(1.0) * 0.6
        } else {
            (TARGET_MEAN_LEVEL / mean.max(0.1)).min(HIGHLIGHT_LEVEL / highlight.max(0.1))
        };
        let product = exposed.exposure_s * exposed.gain_levels_per_electron / self.levels_per_byte_level;
        self.aim_at(product * change.clamp(1.0 / STRONGEST_STEP_DOWN, STRONGEST_STEP_UP));
    }

    /// Splits a wanted product of exposure time and gain: the exposure time is the longest allowed one, and is shortened only when the gain is at its
    /// least.
    fn aim_at(&mut self, product: f64) {
        let [min_gain, max_gain] = self.gain_range;
        let gain = (product / self.max_exposure_s).clamp(min_gain, max_gain);
        let exposure_s = (product / gain).min(self.max_exposure_s).max(SHORTEST_EXPOSURE_S);
        self.next = Exposure { exposure_s: exposure_s.min(self.max_exposure_s), gain_levels_per_electron: gain };
    }
}

/// Lowest grey level of a histogram that at most `count` pixels exceed.
fn level_exceeded_by(histogram: &[usize; 256], count: f64) -> f64 {
    let mut above = 0;
    for level in (0..256_usize).rev() {
        above += histogram[level];
        if above as f64 > count {
            return level as f64;
        }
    }
    0.0
}
