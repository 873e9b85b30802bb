//! Spectra of lamps: the number of photons in the visible and in the infrared band that come with a lumen of light.

use std::sync::OnceLock;

use crate::scene::Spectrum;

/// Photons per lumen of a light in the visible and the infrared band, in units of the photons of a lumen at 555 nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photons {
    /// Photons of the visible band, 400 to 700 nm, per lumen.
    pub visible: f64,
    /// Photons of the infrared band, 800 to 900 nm, per lumen.
    pub infrared: f64,
}

/// Equivalent lumens per watt of a diode of 850 nm. A photon's energy is h·c/λ and a watt at 555 nm has 683 lm, which gives 683·850/555.
pub const EQUIVALENT_LUMENS_PER_WATT_850_NM: f64 = 683.0 * 850.0 / 555.0;

const FIRST_NM: f64 = 380.0;
const STEP_NM: f64 = 10.0;

/// The CIE's luminous efficiency of photopic vision (1924), from 380 nm to 780 nm in steps of 10 nm.
const LUMINOUS_EFFICIENCY: [f64; 41] = [
    0.000039, 0.00012, 0.000396, 0.00121, 0.004, 0.0116, 0.023, 0.038, 0.06, 0.09098, 0.13902, 0.20802, 0.323, 0.503,
    0.71, 0.862, 0.954, 0.99495, 0.995, 0.952, 0.87, 0.757, 0.631, 0.503, 0.381, 0.265, 0.175, 0.107, 0.061, 0.032,
    0.017, 0.00821, 0.004102, 0.002091, 0.001047, 0.00052, 0.000249, 0.00012, 0.00006, 0.00003, 0.000015,
];

/// Relative spectral power of the CIE's standard illuminant D65, from 380 nm to 830 nm in steps of 10 nm.
const D65: [f64; 46] = [
    49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.87, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80, 104.79,
    107.69, 104.41, 104.05, 100.0, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28,
    69.72, 71.61, 74.35, 61.60, 69.89, 75.09, 63.59, 46.42, 66.81, 63.38, 64.30, 59.45, 51.96, 57.44, 60.31,
];

impl Photons {
    /// Photons per lumen of a lamp's spectrum.
    pub fn of(spectrum: Spectrum) -> Photons {
        static TABLE: OnceLock<[Photons; 5]> = OnceLock::new();
        let all = || {
            [Spectrum::Monochrome, Spectrum::Daylight, Spectrum::Led, Spectrum::Tube, Spectrum::Incandescent]
                .map(integrated)
        };
        TABLE.get_or_init(all)[spectrum as usize]
    }
}

/// For a spectrum S of power over wavelength: its relative photons Σ S·λ per lumen Σ S·V, where V is the eye's luminous efficiency. The unit is that
/// ratio for light at 555 nm, for which both sums have a single wavelength and V = 1.
fn integrated(spectrum: Spectrum) -> Photons {
    if spectrum == Spectrum::Monochrome {
        return Photons { visible: 1.0, infrared: 0.0 };
    }
    // The sums take steps of 1 nm, as the lines of a fluorescent tube are narrow.
    let wavelengths_nm = || (380..=900).map(f64::from);
    let luminous: f64 = wavelengths_nm().map(|nm| power(spectrum, nm) * between(&LUMINOUS_EFFICIENCY, nm, 0.0)).sum();
    let photons = |low_nm: f64, high_nm: f64| {
        let within = wavelengths_nm().filter(|nm| (low_nm..high_nm).contains(nm));
        within.map(|nm| power(spectrum, nm) * nm / 555.0).sum::<f64>() / luminous
    };
    Photons { visible: photons(400.0, 700.0), infrared: photons(800.0, 900.0) }
}

/// Relative spectral power of a lamp at a wavelength.
fn power(spectrum: Spectrum, nm: f64) -> f64 {
    let bell = |middle_nm: f64, deviation_nm: f64| (-0.5 * ((nm - middle_nm) / deviation_nm).powi(2)).exp();
    match spectrum {
        Spectrum::Monochrome => 0.0,
        // The CIE's table ends at 830 nm; beyond, its last value is used.
        Spectrum::Daylight => between(&D65, nm, D65[D65.len() - 1]),
        // Spectrum of a neutral white light-emitting diode of 4000 K: a blue die of 450 nm, and a phosphor with a full width of 130 nm at half its
        // maximum.
        Spectrum::Led => 0.75 * bell(450.0, 9.0) + bell(580.0, 55.0),
        // Spectrum of a fluorescent tube: the lines of europium and terbium in a lamp of three bands and 4000 K, with mercury's blue line and a weak
        // continuum, chosen so that a lux has as many photons as Thimijan and Heins (HortScience 18, 1983) measured: 74 lx per µmol/(m²·s).
        Spectrum::Tube => {
            0.45 * bell(436.0, 4.0)
                + 0.35 * bell(488.0, 6.0)
                + bell(544.0, 5.0)
                + 0.35 * bell(585.0, 6.0)
                + bell(611.0, 5.0)
                + 0.12 * bell(600.0, 90.0)
        }
        // Spectrum of an incandescent lamp: Planck's law at 2800 K, with c₂ = 1.4388e-2 m·K.
        Spectrum::Incandescent => 1e14 / nm.powi(5) / ((1.4388e7 / (nm * 2800.0)).exp() - 1.0),
    }
}

/// Linear interpolation in a table whose first entry is for 380 nm; past the table's end `beyond` is returned.
fn between(table: &[f64], nm: f64, beyond: f64) -> f64 {
    let place = (nm - FIRST_NM) / STEP_NM;
    let index = place.floor() as usize;
    match (table.get(index), table.get(index + 1)) {
        (Some(low), Some(high)) => low + (high - low) * place.fract(),
        (Some(last), None) if place.fract() == 0.0 => *last,
        _ => beyond,
    }
}
