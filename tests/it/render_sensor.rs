//! The simulated image sensor against EMVA 1288's linear model: means and variances by hand, pattern noise over many images, bit depths, presets.

use image::GrayImage;
use sim::{
    optics::{AutoExposure, Exposure},
    render::{DeepImage, NoiseKey, View},
    scene::{BitDepth, SensorModel, SensorPreset},
};

use crate::render_studio::{Studio, exposed, renderer, standing};

/// A floor on which one tile of albedo 0.5 fills the view.
fn one_tile() -> Studio {
    Studio::new(
        5.0,
        "[floor.tiles]\nedge_x_m = 5.0\nedge_y_m = 5.0\nphase_x_m = 0.0\npattern = \"plain\"\ntile_albedo = 0.5\n\
         tile_albedo_spread = 0.0\n",
    )
}

/// A sensor of 12 bits with one level per electron above a black level of 100, and without any noise but that of photons.
fn counting() -> SensorModel {
    SensorModel {
        read_noise_electrons: 0.0,
        full_well_electrons: 1e6,
        bits: BitDepth::Twelve,
        black_level: 100.0,
        ..SensorPreset::GlobalShutter.model()
    }
}

fn view(studio: &Studio, sensor: SensorModel, lux: f64, image: u32) -> View {
    View {
        sensor,
        illuminance_at_floor_lux: lux,
        gain_levels_per_electron: 1.0,
        noise: NoiseKey { seed: 8, image },
        ..studio.view(&[standing(2.5, 2.5, 0.0)], image)
    }
}

fn draw_deep(studio: &Studio, views: &[View]) -> Vec<DeepImage> {
    let mut renderer = renderer();
    let world = renderer.upload(&studio.scene, &studio.drawn).unwrap();
    renderer.draw_deep(&world, views).unwrap()
}

fn moments(levels: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = levels.clone().count() as f64;
    let mean = levels.clone().sum::<f64>() / n;
    (mean, levels.map(|level| (level - mean).powi(2)).sum::<f64>() / n)
}

fn levels(image: &DeepImage) -> impl Iterator<Item = f64> + Clone + '_ {
    image.as_raw().iter().map(|level| f64::from(*level))
}

fn close(value: f64, expected: f64, share: f64) {
    assert!((value / expected - 1.0).abs() < share, "{value}, expected {expected}");
}

#[test]
fn dark_current_adds_electrons_and_their_shot_noise() {
    let studio = one_tile();
    let sensor = SensorModel { dark_current_electrons_per_s: 500.0, ..counting() };
    let dark = View { exposure_s: 0.2, ..view(&studio, sensor, 0.0, 0) };
    let (mean, variance) = moments(levels(&draw_deep(&studio, &[dark])[0]));
    // Expected: dark current gives 500 · 0.2 = 100 electrons over a black level of 100. The count is Poisson distributed, so that its variance is
    // 100.
    close(mean - 100.0, 100.0, 0.003);
    close(variance, 100.0, 0.02);
}

#[test]
fn pixels_differ_by_offset_and_sensitivity_alike_in_every_image() {
    const N_IMAGES: u32 = 40;
    let studio = one_tile();
    let sensor = SensorModel { dsnu_electrons: 12.0, prnu: 0.03, read_noise_electrons: 5.0, ..counting() };
    // By hand, a tile with albedo 0.5 gives 16.2 electrons per lux in 10 ms, so that 60 lx give 972 electrons.
    let series = |lux: f64| -> Vec<DeepImage> {
        (0..N_IMAGES).map(|image| draw_deep(&studio, &[view(&studio, sensor, lux, image)]).remove(0)).collect()
    };
    let mean_image = |series: &[DeepImage]| -> Vec<f64> {
        let n_pixels = series[0].as_raw().len();
        (0..n_pixels)
            .map(|at| series.iter().map(|image| f64::from(image.as_raw()[at])).sum::<f64>() / f64::from(N_IMAGES))
            .collect()
    };
    let (dark, bright) = (mean_image(&series(0.0)), mean_image(&series(60.0)));
    let (dark_mean, dark_variance) = moments(dark.iter().copied());
    let (bright_mean, bright_variance) = moments(bright.iter().copied());
    let signal = bright_mean - dark_mean;
    close(signal, 972.0, 0.02);
    // A mean of n images still contains 1/n of the temporal noise, which is subtracted from the variance between pixels, as EMVA 1288 does (section
    // 8).
    close((dark_variance - (25.0 + 1.0 / 12.0) / f64::from(N_IMAGES)).sqrt(), 12.0, 0.01);
    let spatial = bright_variance - (signal + 25.0 + 1.0 / 12.0) / f64::from(N_IMAGES);
    close((spatial - 144.0).sqrt() / signal, 0.03, 0.01);
    // The offsets of neighbouring pixels must be independent of each other (no correlation).
    let pairs = dark.windows(2).map(|pair| (pair[0] - dark_mean) * (pair[1] - dark_mean));
    assert!((pairs.sum::<f64>() / dark.len() as f64 / dark_variance).abs() < 0.01);
}

#[test]
fn another_seed_is_another_sensor() {
    let studio = one_tile();
    let sensor = SensorModel { dsnu_electrons: 20.0, ..counting() };
    let dark = |seed: u64, image: u32| {
        let dark = View { noise: NoiseKey { seed, image }, ..view(&studio, sensor, 0.0, image) };
        levels(&draw_deep(&studio, &[dark])[0]).collect::<Vec<f64>>()
    };
    let correlation = |one: &[f64], other: &[f64]| {
        let ((mean_one, one_variance), (mean_other, _)) =
            (moments(one.iter().copied()), moments(other.iter().copied()));
        let products = one.iter().zip(other).map(|(a, b)| (a - mean_one) * (b - mean_other));
        products.sum::<f64>() / one.len() as f64 / one_variance
    };
    assert!(correlation(&dark(1, 0), &dark(1, 1)) > 0.99);
    assert!(correlation(&dark(1, 0), &dark(2, 0)).abs() < 0.01);
}

#[test]
fn a_deep_picture_is_the_same_picture_with_more_bits() {
    let studio = one_tile();
    for (bits, gain) in [(BitDepth::Eight, 0.05), (BitDepth::Ten, 0.2), (BitDepth::Twelve, 0.8)] {
        let sensor = SensorModel { bits, black_level: 0.0, ..counting() };
        let one = View { gain_levels_per_electron: gain, ..view(&studio, sensor, 120.0, 0) };
        let deep = draw_deep(&studio, std::slice::from_ref(&one)).remove(0);
        let shallow: GrayImage = studio.draw(one);
        // By hand, 120 lx give 1944 electrons, at 16.2 electrons per lux.
        close(moments(levels(&deep)).0, 1944.0 * gain, 0.02);
        let shift = bits.bits() - 8;
        assert!(deep.as_raw().iter().zip(shallow.as_raw()).all(|(deep, level)| deep >> shift == u16::from(*level)));
    }
    // In an image with twelve bits the greatest grey level is 4095, even in much brighter light.
    let bright = View { gain_levels_per_electron: 10.0, ..view(&studio, counting(), 300.0, 0) };
    assert!(draw_deep(&studio, &[bright])[0].as_raw().iter().all(|level| *level == 4095));
}

#[test]
fn counts_of_some_dozens_of_photons_are_skewed_as_poisson_s_law_is() {
    const N_IMAGES: u32 = 4;
    let studio = one_tile();
    // A tile of albedo 0.5 gives 16.2 electrons per lux at 10 ms.
    for electrons in [25.0, 36.0, 60.0] {
        let views: Vec<View> = (0..N_IMAGES).map(|image| view(&studio, counting(), electrons / 16.2, image)).collect();
        let images: Vec<DeepImage> =
            views.iter().flat_map(|view| draw_deep(&studio, std::slice::from_ref(view))).collect();
        let counts: Vec<f64> = images.iter().flat_map(levels).collect();
        let (mean, variance) = moments(counts.iter().copied());
        let third = counts.iter().map(|count| (count - mean).powi(3)).sum::<f64>() / counts.len() as f64;
        let skewness = third / variance.powf(1.5);
        // The scatter of a measured skewness is √(6/n): 0.002 for 1.2 million pixels.
        let (expected, deviation) = ((mean - 100.0).sqrt().recip(), (6.0 / counts.len() as f64).sqrt());
        close(mean - 100.0, electrons, 0.02);
        assert!((skewness - expected).abs() < 5.0 * deviation, "{skewness}, expected {expected} within {deviation}");
    }
}

#[test]
fn a_full_well_saturates_below_the_last_level() {
    let studio = one_tile();
    let sensor = SensorModel { full_well_electrons: 2000.0, ..counting() };
    let (mean, variance) = moments(levels(&draw_deep(&studio, &[view(&studio, sensor, 300.0, 0)])[0]));
    assert_eq!((mean, variance), (2100.0, 0.0));
}

#[test]
fn at_a_tenth_of_a_lux_the_vacuums_camera_counts_two_electrons() {
    let studio = one_tile();
    let preset = SensorPreset::RobotVacuum.model();
    assert_eq!((preset.pixel_pitch_m, preset.f_number, preset.longest_exposure_s), (3e-6, 2.0, 0.033));
    let sensor = SensorModel { bits: BitDepth::Twelve, black_level: 200.0, ..preset };
    let dim = View { exposure_s: 0.033, gain_levels_per_electron: 20.0, ..view(&studio, sensor, 0.1, 0) };
    let (mean, variance) = moments(levels(&draw_deep(&studio, &[dim])[0]));
    // Photo-electrons by hand: L = 0.5 · 0.1/π cd/m²; on the sensor (π/4)·L/2² = 0.003125 lx; times 4.0907e15 photons/(lx·s·m²), (3 µm)², 33 ms
    // and 0.55: 2.088 electrons. The dark current adds 10 · 0.033 = 0.33.
    let electrons = (mean - 200.0) / 20.0;
    close(electrons, 2.088 + 0.33, 0.01);
    // The variance in electrons is shot noise 2.418, read noise 3², pixel offsets 1.5² and pixel sensitivities (0.01 · 2.088)²; rounding is a
    // twentieth of an electron.
    close(variance / 400.0, 2.418 + 9.0 + 2.25, 0.02);
}

#[test]
fn auto_exposure_uses_the_range_of_every_sensor_above_its_black_level() {
    let studio = Studio::new(3.0, "[floor.tiles]\n");
    for preset in [
        SensorPreset::GlobalShutter,
        SensorPreset::MachineVision,
        SensorPreset::RobotVacuum,
        SensorPreset::LowLight,
        SensorPreset::Infrared,
    ] {
        let sensor = preset.model();
        let black = sensor.black_level / sensor.bits.levels_per_byte_level();
        let mut control = AutoExposure::new(&sensor);
        let mut mean = 0.0;
        for image in 0..5 {
            let exposure = control.exposure();
            assert!(exposure.exposure_s <= sensor.longest_exposure_s);
            let mut view = exposed(studio.view(&[standing(1.5, 1.5, 0.2)], image), exposure);
            (view.sensor, view.illuminance_at_floor_lux) = (sensor, 40.0);
            let image = studio.draw(view);
            control.meter(&image);
            mean = moments(image.as_raw().iter().map(|level| f64::from(*level))).0;
        }
        close(mean - black, 110.0, 0.15);
    }
}

#[test]
fn lamps_in_view_darken_all_else_only_where_they_may_not_turn_white() {
    // Image for the auto-exposure: three of a hundred pixels show lamps that are a hundred times as bright as all other pixels.
    let settled = |highlight_share: Option<f64>| {
        let sensor =
            SensorModel { highlight_share: highlight_share.unwrap_or(0.005), ..SensorPreset::GlobalShutter.model() };
        let mut control = AutoExposure::new(&sensor);
        let level = |exposure: Exposure, times: f64| {
            (26_000.0 * times * exposure.exposure_s * exposure.gain_levels_per_electron).min(255.0) as u8
        };
        for _ in 0..40 {
            let exposure = control.exposure();
            let image =
                GrayImage::from_fn(100, 100, |u, _| image::Luma([level(exposure, if u < 3 { 100.0 } else { 1.0 })]));
            control.meter(&image);
        }
        f64::from(level(control.exposure(), 1.0))
    };
    // Where the pixels that show lamps may reach level 215 at most, auto-exposure leaves 2.15 levels for all other pixels.
    assert!(settled(None) <= 3.0, "{}", settled(None));
    // Where five of a hundred pixels may turn white, auto-exposure reaches its mean level of 110, with x the level of all pixels but the lamps':
    // 0.03·255 + 0.97·x = 110.
    let expected = (110.0 - 0.03 * 255.0) / 0.97;
    assert!((settled(Some(0.05)) - expected).abs() < 2.0, "{}, expected {expected}", settled(Some(0.05)));
}
