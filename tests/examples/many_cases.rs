//! Makes up the rows of many cases from those of a real sweep, in Parquet tables as the parts of a sweep leave them, to measure reports on them.
//!
//! `many_cases RESULTS.csv DIR CASES PER_PART` writes `DIR/part-<number>/results.parquet` and prints as JSON what a report on the rows has to show.
//! Every number of a pattern's row is multiplied by the same log-normal factor for its case, and every thousandth case, on average, is said to
//! have missed an expectation. Equal arguments give equal tables.

use std::{env, error::Error, fs, path::Path};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim::campaign::cases::{Cell, Table, read_pieces, to_parquet};

/// Values of the two keys that vary: 50 levels of light and 20 frictions, so that 10⁶ cases are 1000 combinations with 1000 seeds each.
const N_LUX: usize = 50;
const N_FRICTIONS: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [pattern, out, n_cases, per_part] = arguments.as_slice() else {
        return Err("expected RESULTS.csv DIR CASES PER_PART".into());
    };
    let (n_cases, per_part): (usize, usize) = (n_cases.parse()?, per_part.parse()?);
    let mut patterns: Option<Table> = None;
    read_pieces(Path::new(pattern), &|_| true, &mut |piece| patterns = Some(piece.clone()))?;
    let mut patterns = patterns.ok_or("no rows in the pattern")?;
    let after_scene = 2;
    for key in ["set.floor.friction", "set.light.illuminance_at_floor_lux"] {
        patterns.columns.insert(after_scene, key.to_owned());
        patterns.rows.iter_mut().for_each(|row| row.insert(after_scene, Cell::Empty));
    }
    let column = |name: &str| patterns.columns.iter().position(|column| column == name).ok_or(format!("no `{name}`"));
    let columns = Columns {
        case: column("case")?,
        lux: column("set.light.illuminance_at_floor_lux")?,
        friction: column("set.floor.friction")?,
        seed: column("seed")?,
        passed: column("passed")?,
        missed: column("missed_expectations")?,
        widths: [column("width.x_m.mean")?, column("width.y_m.mean")?],
    };
    let (mut n_missed, mut widths_mm) = (0, Vec::with_capacity(n_cases));
    for part in 0..n_cases.div_ceil(per_part) {
        let indices = part * per_part..n_cases.min((part + 1) * per_part);
        let rows = indices.map(|index| {
            let row = columns.made_up(index, &patterns);
            n_missed += usize::from(row[columns.passed] == Cell::Truth(false));
            let width = |column: usize| if let Cell::Number(width_m) = row[column] { 1e3 * width_m } else { f64::NAN };
            widths_mm.push(width(columns.widths[0]).max(width(columns.widths[1])));
            row
        });
        let table = Table { rows: rows.collect(), columns: patterns.columns.clone() };
        let folder = Path::new(out).join(format!("part-{part:05}"));
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("results.parquet"), to_parquet(&table)?)?;
    }
    widths_mm.sort_by(f64::total_cmp);
    let quantile = |share: f64| widths_mm[(share * (widths_mm.len() - 1) as f64).floor() as usize];
    let quantiles = [0.0, 0.01, 0.05, 0.5, 0.95, 0.99, 1.0].map(quantile);
    let told = serde_json::json!({ "columns": patterns.columns.len(), "missed": n_missed, "width_mm": quantiles });
    println!("{told}");
    Ok(())
}

/// Where a row has what is made up anew for each case.
struct Columns {
    case: usize,
    lux: usize,
    friction: usize,
    seed: usize,
    passed: usize,
    missed: usize,
    widths: [usize; 2],
}

impl Columns {
    /// The row of the case with this index.
    fn made_up(&self, index: usize, patterns: &Table) -> Vec<Cell> {
        let mut random = ChaCha8Rng::seed_from_u64(index as u64);
        let mut row = patterns.rows[random.random_range(0..patterns.rows.len())].clone();
        // The sum of twelve uniform numbers is nearly Gaussian, with a standard deviation of one.
        let gaussian = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let combination = index % (N_LUX * N_FRICTIONS);
        for (cell, name) in row.iter_mut().zip(&patterns.columns) {
            let is_kept = name.starts_with("containment.") || name.starts_with("set.");
            if let (Cell::Number(number), false) = (&*cell, is_kept) {
                // Figures of one row are different functions of the case, so that no column is a multiple of another.
                *cell = Cell::Number(number * (0.3 * gaussian).exp() * random.random_range(0.95..1.05));
            }
        }
        row[self.case] = Cell::Text(format!("{index:020x}"));
        row[self.lux] = Cell::Number(10_f64.powf((combination % N_LUX) as f64 / 12.0 - 1.0));
        row[self.friction] = Cell::Number(0.04 * (1 + combination / N_LUX) as f64);
        row[self.seed] = Cell::Whole((index / (N_LUX * N_FRICTIONS)) as u64);
        let has_missed = random.random_range(0..1000) == 0;
        row[self.passed] = Cell::Truth(!has_missed);
        row[self.missed] = if has_missed { Cell::Text("made up".to_owned()) } else { Cell::Empty };
        row
    }
}
