//! Photographs an evenly lit tile and the dark at 50 exposures, for `scripts/photon_transfer`, which analyses the images with an external package.
//!
//! Writes 16-bit PNG files, the descriptor file that the package `emva1288` reads, and `expected.txt` with the values that the scene sets.
#![allow(clippy::unwrap_used)]

use std::{env, fmt::Write as _, fs, path::Path};

use localizer::{Pose, reading::Camera};
use sim::{
    render::{NoiseKey, RenderedWorld, Renderer, View},
    run::sensors::still::views_at,
    scene::Scene,
    world::Drawn,
};

const LUX: f64 = 40.0;
const ALBEDO: f64 = 0.5;
const F_NUMBER: f64 = 2.0;
const PITCH_M: f64 = 4.8e-6;
const QUANTUM_EFFICIENCY: f64 = 0.6;
const FULL_WELL_ELECTRONS: f64 = 9_000.0;
const READ_NOISE_ELECTRONS: f64 = 8.0;
const DARK_CURRENT_ELECTRONS_PER_S: f64 = 300.0;
const DSNU_ELECTRONS: f64 = 4.0;
const PRNU: f64 = 0.01;
const GAIN_LEVELS_PER_ELECTRON: f64 = 0.4;
const N_EXPOSURES: u32 = 50;
const LONGEST_EXPOSURE_S: f64 = 0.14;
/// Number of images from which fixed differences between pixels are measured.
const N_SPATIAL: u32 = 16;

fn main() {
    let folder = env::args().nth(1).unwrap();
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).unwrap();
    let scene = Scene::parse(&scene_text(), "photon_transfer.toml").unwrap();
    let drawn = Drawn::draw(&scene, 0);
    let mut renderer = Renderer::new().unwrap();
    let world = renderer.upload(&scene, &drawn).unwrap();
    let pose = Pose { x_m: 2.5, y_m: 2.5, heading_rad: 0.0 };
    let view = views_at(&scene, &drawn, pose, LUX, &[Camera::Floor], 0).remove(0);
    let mut series = Series { renderer, world, view, folder, descriptor: "v 3.0\nn 12 320 240\n".to_owned(), n: 0 };
    for step in 1..=N_EXPOSURES {
        series.point(LONGEST_EXPOSURE_S * f64::from(step) / f64::from(N_EXPOSURES), 2);
    }
    series.point(LONGEST_EXPOSURE_S / 2.0, N_SPATIAL);
    fs::write(folder.join("descriptor.txt"), &series.descriptor).unwrap();
    let expected = format!(
        "gain {GAIN_LEVELS_PER_ELECTRON}\nquantum_efficiency {QUANTUM_EFFICIENCY}\nread_noise {READ_NOISE_ELECTRONS}\n\
         dark_current {DARK_CURRENT_ELECTRONS_PER_S}\ndsnu {DSNU_ELECTRONS}\nprnu {PRNU}\n"
    );
    fs::write(folder.join("expected.txt"), expected).unwrap();
}

/// The images taken so far with the photon-transfer set-up, the folder that they go to, and the renderer and view with which more images are taken.
struct Series<'a> {
    renderer: Renderer,
    world: RenderedWorld,
    view: View,
    folder: &'a Path,
    descriptor: String,
    n: u32,
}

impl Series<'_> {
    /// Takes bright and dark images at one exposure.
    fn point(&mut self, exposure_s: f64, count: u32) {
        for lux in [LUX, 0.0] {
            let nanoseconds = exposure_s * 1e9;
            if lux > 0.0 {
                let photons = photons_per_pixel(lux, exposure_s);
                writeln!(self.descriptor, "b {nanoseconds:.1} {photons:.3}").unwrap();
            } else {
                writeln!(self.descriptor, "d {nanoseconds:.1}").unwrap();
            }
            for _ in 0..count {
                let view = View {
                    exposure_s,
                    gain_levels_per_electron: GAIN_LEVELS_PER_ELECTRON,
                    illuminance_at_floor_lux: lux,
                    noise: NoiseKey { seed: 1, image: self.n },
                    ..self.view.clone()
                };
                let image = self.renderer.draw_deep(&self.world, &[view]).unwrap().remove(0);
                let name = format!("{:04}.png", self.n);
                image.save(self.folder.join(&name)).unwrap();
                writeln!(self.descriptor, "i {name}").unwrap();
                self.n += 1;
            }
        }
    }
}

/// Photons per pixel, computed by hand and not by the simulator's code: the illuminance on the sensor is E = (π/4)·(albedo·lux/π)/N², by photons
/// of 555 nm at 683 lm/W.
fn photons_per_pixel(lux: f64, exposure_s: f64) -> f64 {
    let on_sensor_lux = ALBEDO * lux / (4.0 * F_NUMBER * F_NUMBER);
    let photon_j = 6.626_070_15e-34 * 2.997_924_58e8 / 555e-9;
    on_sensor_lux / 683.0 / photon_j * PITCH_M * PITCH_M * exposure_s
}

/// A scene in which one evenly lit tile fills the view.
fn scene_text() -> String {
    format!(
        "duration_s = 1.0
        [room]\nwidth_m = 5.0\ndepth_m = 5.0
        [light]\nunevenness_ratio = 1.0
        [floor.tiles]\nedge_x_m = 5.0\nedge_y_m = 5.0\nphase_x_m = 0.0\npattern = \"plain\"
        tile_albedo = {ALBEDO}\ntile_albedo_spread = 0.0
        [start]\nx_m = 2.5\ny_m = 2.5
        [[route.waypoint]]\nx_m = 2.6\ny_m = 2.5
        [robot.floor_camera]\nwidth_px = 320\nheight_px = 240
        [robot.floor_camera.sensor]\nbits = 12\nblack_level = 100\npixel_pitch_m = {PITCH_M}\nf_number = {F_NUMBER:?}
        quantum_efficiency = {QUANTUM_EFFICIENCY}\nfull_well_electrons = {FULL_WELL_ELECTRONS:?}
        read_noise_electrons = {READ_NOISE_ELECTRONS:?}
        dark_current_electrons_per_s = {DARK_CURRENT_ELECTRONS_PER_S:?}
        dsnu_electrons = {DSNU_ELECTRONS:?}\nprnu = {PRNU}"
    )
}
