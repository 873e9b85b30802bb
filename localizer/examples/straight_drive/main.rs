//! Paper 4's numerical experiment: a vehicle drives straight ahead and maps five landmarks of unknown depth. On the same data: the paper's methods on
//! boxes, relations kept by linear rows, and the exact hull from inside.
//!
//! usage: straight_drive FOLDER
//! Writes `results.csv` into the folder, one row for each drive and method; `scripts/straight_drive` makes the book's table and figure of it.

mod boxes;
mod drive;
mod related;
mod rows;
mod witness;
#[cfg(test)]
mod trial;

use std::{env, error::Error, fmt::Write, fs, path::Path, time::Instant};

use interval::Interval;

use boxes::{contract_locally, contract_window};
use drive::{Drive, LANDMARKS_M, N_CONVERGING, Settings};
use related::relate;
use witness::hull_from_inside;

/// Seeds of the drives: none of those by which the settings were chosen.
const N_SEEDS: u64 = 20;
/// Windows of the figure, in steps; the last is the whole drive.
const WINDOWS: [usize; 10] = [1, 2, 3, 5, 10, 15, 20, 30, 40, 60];
/// The window of the paper's post-localization, which the table has beside the paper's 10.
const LONG_WINDOW: usize = 50;

/// Boxes of the converging landmarks' places.
type Places = [[Interval; 3]; N_CONVERGING];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args().nth(1).ok_or("name the folder for the results")?;
    fs::create_dir_all(&folder)?;
    let mut table = String::from("case,seed,method,window,x_m,y_m,z_m,volume_m3,ms_per_step,contained\n");
    for seed in 0..N_SEEDS {
        measure(&mut table, ("as chosen", &Settings::OURS), seed, &WINDOWS)?;
        for (name, settings) in variations() {
            measure(&mut table, (name, &settings), seed, &[])?;
        }
    }
    fs::write(Path::new(&folder).join("results.csv"), table)?;
    Ok(())
}

/// Other settings, to see on what the result depends: odometry from perfect to bad, and shorter drives.
fn variations() -> [(&'static str, Settings); 6] {
    let ours = Settings::OURS;
    [
        ("odometer 0.05 %", Settings { distance_error: 0.0005, ..ours }),
        ("odometer 1 %", Settings { distance_error: 0.01, ..ours }),
        ("odometer 5 %", Settings { distance_error: 0.05, ..ours }),
        ("gyroscope 0.003°/s", Settings { turn_error_rad: 1e-5, ..ours }),
        ("gyroscope 0.1°/s", Settings { turn_error_rad: 3.5e-4, ..ours }),
        ("20 steps", Settings { n_steps: 20, ..ours }),
    ]
}

/// Runs all methods on a drive and adds a row for each.
fn measure(
    table: &mut String,
    (case, settings): (&str, &Settings),
    seed: u64,
    windows: &[usize],
) -> Result<(), Box<dyn Error>> {
    let drive = Drive::new(settings, seed);
    let mut add = |method: &str, window: usize, places_m: &Places, began: Instant| {
        let [x_m, y_m, z_m] = mean_widths_m(places_m);
        let ms = 1e3 * began.elapsed().as_secs_f64() / settings.n_steps as f64;
        let contained = holds_truth(places_m);
        let volume_m3 = mean_volume_m3(places_m);
        writeln!(table, "{case},{seed},{method},{window},{x_m},{y_m},{z_m},{volume_m3},{ms},{contained}")
    };
    let began = Instant::now();
    let local = contract_locally(&drive)?;
    add("LIC", 0, &local.places_m(), began)?;
    let mut windows: Vec<usize> = windows.iter().copied().chain([10, LONG_WINDOW]).collect();
    windows.sort_unstable();
    windows.dedup();
    for window in windows {
        let began = Instant::now();
        add("DIGO", window, &contract_window(&drive, window)?.places_m(), began)?;
    }
    let began = Instant::now();
    let related = relate(&drive)?;
    add("relations", settings.n_steps, &related.places_m, began)?;
    let began = Instant::now();
    add("inside", settings.n_steps, &hull_from_inside(&drive, &related.boxes)?, began)?;
    Ok(())
}

/// Mean widths of the boxes in x, y and z: the paper's MDW.
fn mean_widths_m(places_m: &Places) -> [f64; 3] {
    [0, 1, 2].map(|axis| places_m.iter().map(|place| place[axis].width()).sum::<f64>() / N_CONVERGING as f64)
}

/// Mean volume of the boxes: the paper's MPV, equation (32).
fn mean_volume_m3(places_m: &Places) -> f64 {
    places_m.iter().map(|place| place.iter().map(|side| side.width()).product::<f64>()).sum::<f64>()
        / N_CONVERGING as f64
}

/// Whether every box holds the true place of its landmark.
fn holds_truth(places_m: &Places) -> bool {
    let pairs = places_m.iter().zip(LANDMARKS_M);
    pairs.into_iter().all(|(place, truth)| place.iter().zip(truth).all(|(side, truth)| side.contains(truth)))
}
