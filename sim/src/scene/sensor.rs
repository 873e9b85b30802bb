//! Image sensors, which turn light into grey levels behind a lens: presets, and the keys that a scene states otherwise.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An image sensor by the linear model of EMVA 1288, with its aperture and exposure control. Keys that are not stated have the preset's values.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Named camera whose values apply where no other key states one. Unless stated, `global_shutter` for the floor camera, `robot_vacuum` for the
    /// forward camera and `infrared` for the ceiling camera.
    pub preset: Option<SensorPreset>,
    /// Distance between the centres of neighbouring pixels.
    #[schemars(range(min = 0.5e-6, max = 50e-6))]
    pub pixel_pitch_m: Option<f64>,
    /// F-number of the lens: focal length over aperture.
    #[schemars(range(min = 0.7, max = 32.0))]
    pub f_number: Option<f64>,
    /// Longest exposure of an image. Auto-exposure takes a shorter one where the image would saturate.
    #[schemars(range(min = 0.00001, max = 1.0))]
    pub longest_exposure_s: Option<f64>,
    /// Fixed exposure of all images, at the least gain, in place of auto-exposure.
    #[schemars(range(min = 0.00001, max = 1.0))]
    pub exposure_s: Option<f64>,
    /// Electrons per photon at 555 nm, or for an infrared camera at 850 nm.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub quantum_efficiency: Option<f64>,
    /// Number of electrons at which a pixel saturates.
    #[schemars(range(min = 100.0, max = 1000000.0))]
    pub full_well_electrons: Option<f64>,
    /// Standard deviation of a pixel's read noise.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub read_noise_electrons: Option<f64>,
    /// Mean dark current of a pixel. The dark current has shot noise of its own.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub dark_current_electrons_per_s: Option<f64>,
    /// Dark signal non-uniformity: standard deviation of the pixels' offsets, which are the same in every image.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub dsnu_electrons: Option<f64>,
    /// Photo response non-uniformity: standard deviation of the pixels' sensitivities as a share. The sensitivities are the same in every image.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub prnu: Option<f64>,
    /// Number of bits of a grey level. The localizer gets the eight most significant ones.
    pub bits: Option<BitDepth>,
    /// Grey level of a pixel without any electrons, at the sensor's own bit depth.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub black_level: Option<f64>,
    /// Greatest gain of auto-exposure, in grey levels of the sensor's own bit depth per electron.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub max_gain_levels_per_electron: Option<f64>,
    /// Share of the pixels that auto-exposure lets turn white, such as those of lamps and windows in view, for the sake of all other pixels. Unless
    /// stated 0.005, which keeps nearly all pixels within the range, and 0.0001 for the preset `infrared`, so that even small dots do not turn white.
    #[schemars(range(min = 0.0, max = 0.4))]
    pub highlight_share: Option<f64>,
}

/// Named cameras whose values a sensor can start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SensorPreset {
    /// A camera without noise but that of photons and reading: 4.8 µm pixels, f/2, up to 10 ms, 8 bits.
    GlobalShutter,
    /// A good machine-vision camera: 4.8 µm pixels, f/2, up to 10 ms, 12 bits, 2.5 electrons of read noise.
    MachineVision,
    /// The cheap camera of a robot vacuum: 3 µm pixels, f/2, up to 33 ms, 8 bits.
    RobotVacuum,
    /// A camera for the dark: 6 µm pixels, f/1.4, up to 100 ms, 10 bits, 1.5 electrons of read noise.
    LowLight,
    /// A small camera behind an 850 nm filter, like paper 5's: 3 µm pixels, f/2, up to 20 ms, 8 bits.
    Infrared,
}

/// Number of bits of a grey level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schemars(with = "u8", extend("enum" = [8, 10, 12]))]
pub enum BitDepth {
    /// 256 levels.
    Eight,
    /// 1024 levels.
    Ten,
    /// 4096 levels.
    Twelve,
}

/// All properties of an image sensor, with the values of its preset filled in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Side of a square pixel.
    pub pixel_pitch_m: f64,
    /// F-number of the lens: focal length over aperture.
    pub f_number: f64,
    /// Longest exposure of an image.
    pub longest_exposure_s: f64,
    /// Whether every image has the longest exposure and the least gain, without auto-exposure.
    pub is_fixed: bool,
    /// Electrons per photon.
    pub quantum_efficiency: f64,
    /// Number of electrons at which a pixel saturates.
    pub full_well_electrons: f64,
    /// Standard deviation of a pixel's read noise.
    pub read_noise_electrons: f64,
    /// Mean dark current of a pixel.
    pub dark_current_electrons_per_s: f64,
    /// Standard deviation of the pixels' offsets, which are the same in every image.
    pub dsnu_electrons: f64,
    /// Standard deviation of the pixels' sensitivities, as a share.
    pub prnu: f64,
    /// Number of bits of a grey level.
    pub bits: BitDepth,
    /// Grey level of a pixel without any electrons.
    pub black_level: f64,
    /// Greatest gain of auto-exposure.
    pub max_gain_levels_per_electron: f64,
    /// Share of the pixels that auto-exposure lets turn white.
    pub highlight_share: f64,
}

impl Sensor {
    /// Model of the sensor: the stated keys, and for all others the values of the stated preset, or of `otherwise` if no preset is stated.
    pub fn model(&self, otherwise: SensorPreset) -> SensorModel {
        let preset = self.preset.unwrap_or(otherwise).model();
        SensorModel {
            pixel_pitch_m: self.pixel_pitch_m.unwrap_or(preset.pixel_pitch_m),
            f_number: self.f_number.unwrap_or(preset.f_number),
            longest_exposure_s: self.exposure_s.or(self.longest_exposure_s).unwrap_or(preset.longest_exposure_s),
            is_fixed: self.exposure_s.is_some(),
            quantum_efficiency: self.quantum_efficiency.unwrap_or(preset.quantum_efficiency),
            full_well_electrons: self.full_well_electrons.unwrap_or(preset.full_well_electrons),
            read_noise_electrons: self.read_noise_electrons.unwrap_or(preset.read_noise_electrons),
            dark_current_electrons_per_s: self
                .dark_current_electrons_per_s
                .unwrap_or(preset.dark_current_electrons_per_s),
            dsnu_electrons: self.dsnu_electrons.unwrap_or(preset.dsnu_electrons),
            prnu: self.prnu.unwrap_or(preset.prnu),
            bits: self.bits.unwrap_or(preset.bits),
            black_level: self.black_level.unwrap_or(preset.black_level),
            max_gain_levels_per_electron: self
                .max_gain_levels_per_electron
                .unwrap_or(preset.max_gain_levels_per_electron),
            highlight_share: self.highlight_share.unwrap_or(preset.highlight_share),
        }
    }
}

impl SensorPreset {
    /// Model of the sensor that the preset names.
    pub fn model(self) -> SensorModel {
        let global_shutter = SensorModel {
            pixel_pitch_m: 4.8e-6,
            f_number: 2.0,
            longest_exposure_s: 0.01,
            is_fixed: false,
            quantum_efficiency: 0.55,
            full_well_electrons: 10_000.0,
            read_noise_electrons: 6.0,
            dark_current_electrons_per_s: 0.0,
            dsnu_electrons: 0.0,
            prnu: 0.0,
            bits: BitDepth::Eight,
            black_level: 0.0,
            max_gain_levels_per_electron: 4.0,
            highlight_share: 0.005,
        };
        match self {
            SensorPreset::GlobalShutter => global_shutter,
            SensorPreset::MachineVision => SensorModel {
                quantum_efficiency: 0.62,
                read_noise_electrons: 2.5,
                dark_current_electrons_per_s: 3.0,
                dsnu_electrons: 0.8,
                prnu: 0.005,
                bits: BitDepth::Twelve,
                black_level: 64.0,
                max_gain_levels_per_electron: 40.0,
                ..global_shutter
            },
            SensorPreset::RobotVacuum => SensorModel {
                pixel_pitch_m: 3e-6,
                longest_exposure_s: 0.033,
                full_well_electrons: 6000.0,
                read_noise_electrons: 3.0,
                dark_current_electrons_per_s: 10.0,
                dsnu_electrons: 1.5,
                prnu: 0.01,
                black_level: 16.0,
                ..global_shutter
            },
            SensorPreset::LowLight => SensorModel {
                pixel_pitch_m: 6e-6,
                f_number: 1.4,
                longest_exposure_s: 0.1,
                read_noise_electrons: 1.5,
                dark_current_electrons_per_s: 4.0,
                dsnu_electrons: 0.7,
                prnu: 0.006,
                full_well_electrons: 15_000.0,
                bits: BitDepth::Ten,
                black_level: 32.0,
                max_gain_levels_per_electron: 16.0,
                ..global_shutter
            },
            SensorPreset::Infrared => SensorModel {
                pixel_pitch_m: 3e-6,
                longest_exposure_s: 0.02,
                quantum_efficiency: 0.3,
                full_well_electrons: 6000.0,
                read_noise_electrons: 3.0,
                dark_current_electrons_per_s: 10.0,
                dsnu_electrons: 1.5,
                prnu: 0.01,
                black_level: 16.0,
                // The retro-reflective dots of a marker, the brightest that it is to measure, are about a thousandth of an image. Were as many
                // pixels let turn white as of other cameras, all dots would: of the markers of `docs/src/ci.md` 64 % were read, and now all.
                highlight_share: 0.0001,
                ..global_shutter
            },
        }
    }
}

impl BitDepth {
    /// Number of bits of a grey level, as an integer.
    pub fn bits(self) -> u32 {
        match self {
            BitDepth::Eight => 8,
            BitDepth::Ten => 10,
            BitDepth::Twelve => 12,
        }
    }

    /// The brightest grey level at this bit depth.
    pub fn greatest_level(self) -> u32 {
        (1 << self.bits()) - 1
    }

    /// The eight most significant bits of a grey level.
    pub fn most_significant(self, level: u16) -> u8 {
        (level >> (self.bits() - 8)) as u8
    }

    /// Number of grey levels at this bit depth that fall into one level of eight bits.
    pub fn levels_per_byte_level(self) -> f64 {
        f64::from(1 << (self.bits() - 8))
    }
}

impl TryFrom<u8> for BitDepth {
    type Error = &'static str;

    fn try_from(bits: u8) -> Result<Self, Self::Error> {
        match bits {
            8 => Ok(BitDepth::Eight),
            10 => Ok(BitDepth::Ten),
            12 => Ok(BitDepth::Twelve),
            _ => Err("expected 8, 10 or 12"),
        }
    }
}

impl From<BitDepth> for u8 {
    fn from(depth: BitDepth) -> u8 {
        depth.bits() as u8
    }
}
