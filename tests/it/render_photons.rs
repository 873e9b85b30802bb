//! Grey levels and their noise in rendered pictures, compared with photon counts by hand; and the same bytes for the same noise key.

use sim::{
    optics::AutoExposure,
    render::{FloorLight, NoiseKey},
    scene::{CameraKeys, Light, Room},
};

use crate::render_studio::{Studio, exposed, renderer, standing};

/// A floor on which one tile fills the view: tiles of 5 m with albedo 0.5, seen from the middle of one.
const ONE_TILE: &str = "[floor.tiles]\nedge_x_m = 5.0\nedge_y_m = 5.0\nphase_x_m = 0.0\npattern = \"plain\"\n\
                        tile_albedo = 0.5\ntile_albedo_spread = 0.0\n";

fn one_tile() -> Studio {
    Studio::new(5.0, ONE_TILE)
}

fn moments(levels: &[u8]) -> (f64, f64) {
    let mean = levels.iter().map(|&level| f64::from(level)).sum::<f64>() / levels.len() as f64;
    let variance = levels.iter().map(|&level| (f64::from(level) - mean).powi(2)).sum::<f64>() / levels.len() as f64;
    (mean, variance)
}

#[test]
fn grey_level_follows_from_lux_albedo_aperture_and_exposure() {
    let studio = one_tile();
    let mut view = studio.view(&[standing(2.5, 2.5, 0.3)], 0);
    view.illuminance_at_floor_lux = 200.0;
    view.gain_levels_per_electron = 0.03;
    let image = studio.draw(view);
    // By hand, the expected grey level of a tile with albedo 0.5 in 200 lx: luminance L = 0.5·200/π; on the sensor (π/4)·L/2² = 6.25 lx. One lux of
    // 555 nm is 4.09e15 photons/(s·m²): 6.25 · 4.09e15 · (4.8 µm)² · 10 ms · 0.55 = 3239 electrons, times 0.03 = 97.2 levels.
    let (mean, _) = moments(image.as_raw());
    assert!((mean / 97.2 - 1.0).abs() < 0.02, "{mean}");
}

#[test]
fn noise_has_the_variance_of_photons_and_reading() {
    let studio = one_tile();
    let mut view = studio.view(&[standing(2.5, 2.5, 0.0)], 0);
    // The tile gives 16.2 electrons per lux: 30 lx are 486 electrons. At a gain of 0.25 levels per electron these are 121.5 levels.
    view.illuminance_at_floor_lux = 30.0;
    view.gain_levels_per_electron = 0.25;
    let (mean, variance) = moments(studio.draw(view).as_raw());
    // Expected variance of the grey levels: shot noise gain·mean, read noise (6·0.25)², and rounding 1/12.
    let expected = 0.25 * mean + 2.25 + 1.0 / 12.0;
    assert!((variance / expected - 1.0).abs() < 0.02, "{variance}, expected {expected}");
}

#[test]
fn few_electrons_are_counted_as_poisson_has_it() {
    let studio = one_tile();
    for mean_electrons in [0.8, 5.0, 25.0] {
        let mut view = studio.view(&[standing(2.5, 2.5, 0.0)], 0);
        view.sensor.read_noise_electrons = 0.0;
        view.illuminance_at_floor_lux = 300.0;
        view.exposure_s = 0.01 * mean_electrons / (16.196 * 300.0);
        // At this gain each electron is one grey level, and the 255 levels hold all counts that occur.
        view.gain_levels_per_electron = 1.0;
        let image = studio.draw(view);
        let n_pixels = image.as_raw().len() as f64;
        let (mean, variance) = moments(image.as_raw());
        assert!((mean / mean_electrons - 1.0).abs() < 0.01, "{mean}, expected {mean_electrons}");
        assert!((variance / mean - 1.0).abs() < 0.015, "variance {variance}, mean {mean}");
        let mut probability = (-mean).exp();
        for count in 0..12_u8 {
            let share = image.as_raw().iter().filter(|&&level| level == count).count() as f64 / n_pixels;
            // Over 307 200 pixels, the share of pixels with a given count scatters by 0.0009 at most (one standard deviation).
            assert!((share - probability).abs() < 0.004, "{count} electrons: {share}, Poisson {probability}");
            probability *= mean / f64::from(count + 1);
        }
    }
}

#[test]
fn noise_is_the_same_for_the_same_key_and_independent_for_another() {
    let studio = one_tile();
    let truth = standing(2.5, 2.5, 0.0);
    let draw = |seed: u64, image: u32| {
        let mut view = studio.view(&[truth], 0);
        view.noise = NoiseKey { seed, image };
        studio.draw(view).into_raw()
    };
    let first = draw(5, 0);
    assert_eq!(first, draw(5, 0));
    let (mean, variance) = moments(&first);
    for other in [draw(5, 1), draw(6, 0), draw(5 + (1 << 32), 0)] {
        let products = first.iter().zip(&other).map(|(&a, &b)| (f64::from(a) - mean) * (f64::from(b) - mean));
        let correlation = products.sum::<f64>() / first.len() as f64 / variance;
        // The correlation between two images with independent noise, of 307 200 pixels each, scatters by 0.0018 (one standard deviation).
        assert!(correlation.abs() < 0.009, "{correlation}");
    }
}

#[test]
fn views_of_several_worlds_in_one_submit_are_those_of_each_alone() {
    let dark = Studio::new(3.0, "[floor.tiles]\nedge_x_m = 0.2\ntile_albedo = 0.3\n");
    let (bright, places) = (one_tile(), [standing(1.5, 1.5, 0.4), standing(2.5, 2.5, 0.0)]);
    let views = [dark.view(&[places[0]], 1), bright.view(&[places[1]], 2), dark.view(&[places[1]], 3)];
    let alone = [dark.draw(views[0].clone()), bright.draw(views[1].clone()), dark.draw(views[2].clone())];
    let mut renderer = renderer();
    let worlds = [&dark, &bright].map(|studio| renderer.upload(&studio.scene, &studio.drawn).unwrap());
    let together = [(&worlds[0], &views[0]), (&worlds[1], &views[1]), (&worlds[0], &views[2])];
    assert!(renderer.draw_together(&together).unwrap() == alone);
    assert!(alone[0] != alone[1] && alone[0] != alone[2]);
}

#[test]
fn a_switched_lamp_spoils_two_images_at_most() {
    let studio = Studio::new(3.0, "[floor.tiles]\n");
    let camera = studio.scene.robot.floor_camera.clone().unwrap();
    let mut control = AutoExposure::new(&camera.sensor_model());
    let mut number = 0;
    for (lux, levels) in [(300.0, 110.0), (1000.0, 110.0), (3.0, 110.0), (100.0, 110.0), (10.0, 110.0)] {
        let mut means = Vec::new();
        for _ in 0..4 {
            let exposure = control.exposure();
            assert!(exposure.exposure_s <= camera.sensor_model().longest_exposure_s);
            let mut view = exposed(studio.view(&[standing(1.5, 1.5, 0.2)], number), exposure);
            view.illuminance_at_floor_lux = lux;
            let image = studio.draw(view);
            control.meter(&image);
            means.push(moments(image.as_raw()).0);
            number += 1;
        }
        assert!(means[2..].iter().all(|mean| (mean / levels - 1.0).abs() < 0.15), "{lux} lx: {means:?}");
    }
}

#[test]
fn uneven_light_keeps_its_mean_and_its_ratio() {
    let room = Room { width_m: 3.6, depth_m: 2.4 };
    let light = Light { unevenness_ratio: 20.0, unevenness_direction_deg: 140.0, ..Light::default() };
    let field = FloorLight::new(&light, &room);
    let (mut sum, mut least, mut greatest) = (0.0, f64::INFINITY, 0.0_f64);
    let n = 400;
    for i in 0..=n {
        for j in 0..=n {
            let share = |k: i32| f64::from(k) / f64::from(n);
            let factor = field.factor_at([room.width_m * share(i), room.depth_m * share(j)].into());
            // The mean of the light over the room is computed by the trapezoidal rule: values at the room's borders count half.
            let weight = |k: i32| if k == 0 || k == n { 0.5 } else { 1.0 };
            sum += factor * weight(i) * weight(j);
            least = least.min(factor);
            greatest = greatest.max(factor);
        }
    }
    assert!((sum / f64::from(n * n) - 1.0).abs() < 1e-4);
    assert!((greatest / least - 20.0).abs() < 1e-9);
}
