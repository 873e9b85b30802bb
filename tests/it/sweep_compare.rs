use std::{
    fs,
    path::{Path, PathBuf},
};

use interval::Interval;
use localizer::{PoseUnion, pose::PoseBox};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim::{
    artefacts::run_files,
    campaign::comparison::{Comparison, Demand, Finding, Side, as_text, compare, quantile},
    loading::SceneFile,
    run::{RunOptions, run},
    subject::IntervalLocalizer,
};

use crate::command::{blind_scene, folder, outcome, wherein};
use crate::judging::verdict_of;

/// Results of ten seeds of a drive whose errors are all in a corner of what is declared, with every box `scale` times as wide as the localizer
/// answered: they stand for a localizer with a bound that is too wide or too tight. Returns their folder.
fn planted(folder: &Path, name: &str, scale: f64) -> PathBuf {
    let scene = folder.join("scene.toml");
    let text = blind_scene(0.5, "").replace("[robot]\n", "[robot]\nerrors = \"corner\"\n");
    fs::write(&scene, text).unwrap();
    let file = SceneFile::load(&scene).unwrap();
    let out = folder.join(name);
    for seed in 0..10 {
        let mut run_record =
            run(&file.scene, seed, &mut IntervalLocalizer::of(&file.scene), None, &RunOptions::default(), &mut |_| {})
                .unwrap();
        for estimate in &mut run_record.estimates {
            let hull = estimate.pose.hull();
            let scaled = [0, 1, 2].map(|axis| {
                let (middle, half) = (hull.midpoint()[axis], 0.5 * hull[axis].width());
                Interval::centred(middle, scale * half)
            });
            estimate.pose = PoseUnion::single(PoseBox::from(scaled));
        }
        let verdict = verdict_of(&file.scene, &run_record);
        run_files::write(&out, &file, &run_record, &verdict).unwrap();
    }
    out
}

fn finding(comparison: &Comparison, name: &str) -> Finding {
    comparison.lines.iter().find(|line| line.compared.name == name).unwrap().finding
}

#[test]
fn a_bound_five_percent_too_wide_is_worse_in_width_and_in_nothing_else() {
    let folder = folder("compare_wide");
    let sides = [1.0, 1.05].map(|scale| Side::load(&planted(&folder, &scale.to_string(), scale)).unwrap());
    let comparison = compare(&sides[0], &sides[1], Demand::default());
    assert_eq!((comparison.n_pairs, comparison.n_seeds), (10, 10));
    for line in &comparison.lines {
        let is_width = line.compared.name.starts_with("width");
        let expected = if is_width { Finding::Worse } else { Finding::NotDistinguishable };
        assert_eq!(line.finding, expected, "{}", line.compared.name);
        if is_width {
            let ratio = line.means[1] / line.means[0];
            assert!((ratio - 1.05).abs() < 1e-6, "{ratio}");
        }
    }
    let back = compare(&sides[1], &sides[0], Demand::default());
    assert_eq!(finding(&back, "width in x"), Finding::Better);
    assert!(!back.is_worse() && comparison.is_worse());
}

#[test]
fn a_bound_five_percent_too_tight_is_found_to_lose_the_truth() {
    let folder = folder("compare_tight");
    let (sound, tight) = (planted(&folder, "sound", 1.0), planted(&folder, "tight", 0.95));
    let comparison = compare(&Side::load(&sound).unwrap(), &Side::load(&tight).unwrap(), Demand::default());
    assert_eq!(finding(&comparison, "contained"), Finding::Worse);
    assert_eq!(finding(&comparison, "width in x"), Finding::Better, "it looks better where it must not count");
    // The simulated errors are as great as their bounds allow, so that the robot starts at the edge of its start box: a box that is 5 % too tight
    // loses the true pose with every seed.
    assert_eq!(comparison.lost.len(), 10);
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["compare", "sound", "tight"]));
    assert_eq!(code, 1, "{stdout}");
    assert!(stdout.contains("10 lost containment, which the first side kept:\n  scene seed 0\n"), "{stdout}");
    assert!(stdout.contains("contained, %") && stdout.contains("WORSE"), "{stdout}");
}

#[test]
fn identical_versions_are_not_distinguishable_in_twenty_of_twenty_trials() {
    let folder = folder("compare_same");
    fs::write(folder.join("scene.toml"), blind_scene(0.3, "")).unwrap();
    for trial in 0..20 {
        let seeds = format!("{}..{}", 5 * trial, 5 * trial + 5);
        for out in ["one", "two"] {
            let sweep = ["sweep", "scene.toml", "--vary", "floor.friction=0.5,0.8", "--seeds", &seeds, "--out", out];
            assert_eq!(outcome(&mut wherein(&folder, &sweep)).0, 0);
        }
        let (code, stdout, _) = outcome(&mut wherein(&folder, &["compare", "one/results.csv", "two"]));
        assert_eq!(code, 0, "{stdout}");
        assert_eq!(stdout.matches("not distinguishable").count(), 7, "{stdout}");
        assert!(stdout.contains("10 pairs of 5 seeds"), "{stdout}");
    }
}

/// Results of a sweep with one case for each seed; every figure of a case is 0.5 plus a tenth of a random number from `noise`.
fn noisy(noise: &mut dyn FnMut() -> f64, seeds: u64) -> Side {
    let figures = "containment.contained_share,error.position_m.mean,error.heading_rad.rmse,\
                   width.x_m.mean,width.y_m.mean,width.heading_rad.mean,availability";
    let mut text = format!("scene,seed,status,{figures}\n");
    for seed in 0..seeds {
        let values: Vec<String> = (0..7).map(|_| (0.5 + 0.1 * noise()).to_string()).collect();
        text += &format!("scene,{seed},done,{}\n", values.join(","));
    }
    Side::parse(&text).unwrap()
}

/// Noise with heavier tails than a normal distribution: cubes of uniform random numbers.
fn cubes(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || (2.0 * random.random::<f64>() - 1.0).powi(3)
}

#[test]
fn chance_is_taken_for_a_difference_no_more_often_than_the_confidence_allows() {
    let mut noise = cubes(7);
    let trials = 1000;
    let mut wrong = 0;
    for _ in 0..trials {
        let comparison =
            compare(&noisy(&mut noise, 6), &noisy(&mut noise, 6), Demand { confidence: 0.9, ..Demand::default() });
        let is_told = |finding: Finding| matches!(finding, Finding::Better | Finding::Worse);
        wrong += usize::from(comparison.lines.iter().any(|line| is_told(line.finding)));
    }
    // Both results contain nothing but noise. With a confidence of 90 %, a difference may be reported in at most 100 of the 1000 trials; three
    // standard deviations of chance are 28 more.
    assert!(wrong <= 128, "{wrong} of {trials}");
    assert!(wrong >= 10, "{wrong} of {trials}: intervals so wide say nothing");
}

#[test]
fn settings_that_share_a_seed_are_one_witness() {
    let table = |scale: f64| {
        let mut text = "scene,set.floor.friction,seed,status,width.x_m.mean\n".to_owned();
        for (friction, seed) in [0.1, 0.2, 0.3, 0.4, 0.5].into_iter().flat_map(|one| [(one, 0), (one, 1)]) {
            let width_m = 0.01 * (1.0 + friction) + scale * [0.001, 0.0001][seed];
            text += &format!("scene,{friction},{seed},done,{width_m}\n");
        }
        Side::parse(&text).unwrap()
    };
    let comparison = compare(&table(0.0), &table(1.0), Demand::default());
    assert_eq!((comparison.n_pairs, comparison.n_seeds), (10, 2));
    // There are two differences, 1.0 and 0.1 mm: their mean is 0.55 ± 0.45 · t, and t of one degree of freedom is above 60 here. If all ten cases
    // counted as independent, the finding would have been certain.
    assert_eq!(finding(&comparison, "width in x"), Finding::Inconclusive);
    let half_width_m = 0.5 * (comparison.lines[0].difference[1] - comparison.lines[0].difference[0]);
    // The expected half-width of the interval uses the quantile t(1 − 0.01/2, 1) of a confidence of 99 % shared by one figure and two sides; it
    // is tan(π (1/2 − 0.01/2)), because the t distribution with one degree of freedom is Cauchy's.
    let expected_m = 0.00045 * (std::f64::consts::PI * (0.5 - 0.01 / 2.0)).tan();
    assert!((half_width_m / expected_m - 1.0).abs() < 1e-6, "{half_width_m} {expected_m}");
    assert!((comparison.lines[0].least_seen / expected_m - 1.0).abs() < 1e-6);
}

#[test]
fn twenty_times_the_width_with_two_seeds_is_inconclusive_and_can_be_refused() {
    let folder = folder("compare_few");
    let table = |name: &str, widths_m: &[f64]| {
        let rows = widths_m.iter().enumerate().map(|(seed, width_m)| format!("scene,{seed},done,{width_m}\n"));
        let path = folder.join(name);
        fs::write(&path, format!("scene,seed,status,width.x_m.mean\n{}", rows.collect::<String>())).unwrap();
        path
    };
    let narrow = table("narrow.csv", &[0.025, 0.026]);
    let wide = table("wide.csv", &[0.554, 0.310]);
    let asked = |second: &Path, more: &[&str]| {
        let paths = [narrow.to_str().unwrap(), second.to_str().unwrap()];
        outcome(&mut wherein(&folder, &[&["compare"], &paths[..], more].concat()))
    };
    // Two differences, 0.529 and 0.284 m: their mean is 0.41 ± 0.12 · t, and t of one degree of freedom is above 400.
    let (code, text, _) = asked(&wide, &[]);
    assert!(code == 0 && text.contains("inconclusive") && text.contains("Too few seeds"), "{text}");
    assert_eq!(asked(&wide, &["--fail-if-inconclusive"]).0, 1);
    // The same results beside themselves leave nothing open.
    let (code, text, _) = asked(&narrow, &["--fail-if-inconclusive"]);
    assert!(code == 0 && !text.contains("inconclusive"), "{text}");
}

#[cfg(unix)]
#[test]
fn a_run_to_which_links_lead_in_a_circle_counts_once() {
    let folder = folder("links_in_a_circle");
    let scene = folder.join("scene.toml");
    fs::write(&scene, blind_scene(0.2, "")).unwrap();
    let (code, _, errors) =
        outcome(&mut wherein(&folder, &["run", "scene.toml", "--seeds", "0..2", "--out", "all/runs"]));
    assert_eq!(code, 0, "{errors}");
    std::os::unix::fs::symlink("..", folder.join("all/runs/back")).unwrap();
    std::os::unix::fs::symlink("runs", folder.join("all/again")).unwrap();
    let (_, _, errors) = outcome(&mut wherein(&folder, &["report", "all"]));
    let rows = fs::read_to_string(folder.join("all/results.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 2, "{rows} {errors}");
    let (_, table, _) = outcome(&mut wherein(&folder, &["table", "all", "--columns", "all"]));
    assert!(table.contains("| scene | 2 seeds | 42 |"), "{table}");
}

#[test]
fn quantiles_are_those_of_the_printed_tables() {
    // Values of Student's t from Abramowitz and Stegun, table 26.10.
    let printed = [
        (0.975, 1.0, 12.706),
        (0.995, 1.0, 63.657),
        (0.975, 4.0, 2.776),
        (0.995, 9.0, 3.250),
        (0.95, 30.0, 1.697),
        (0.9995, 120.0, 3.373),
    ];
    for (p, degrees, t) in printed {
        assert!((quantile(p, degrees) - t).abs() < 6e-4, "t({p}, {degrees}) = {}", quantile(p, degrees));
    }
}

#[test]
fn a_case_that_ran_once_and_cannot_any_more_is_worse() {
    let side = |second: &str| {
        Side::parse(&format!("scene,seed,status,availability\nscene,0,done,1\nscene,1,{second},1\n")).unwrap()
    };
    let comparison = compare(&side("done"), &side("failed"), Demand::default());
    assert!(comparison.is_worse());
    assert_eq!(comparison.failed, ["scene seed 1"]);
    assert!(!compare(&side("failed"), &side("done"), Demand::default()).is_worse());
}

#[test]
fn differences_that_do_not_scatter_do_not_tell_what_could_be_seen() {
    let side = |[first, second]: [f64; 2]| {
        let text = format!("scene,seed,status,availability\nscene,0,done,{first:?}\nscene,1,done,{second:?}\n");
        Side::parse(&text).unwrap()
    };
    let told = |other: [f64; 2]| as_text(&compare(&side([0.9, 0.8]), &side(other), Demand::default()));
    assert!(told([0.9, 0.8]).contains("unknown"), "{}", told([0.9, 0.8]));
    assert!(!told([0.9, 0.7]).contains("unknown"), "{}", told([0.9, 0.7]));
}

#[test]
fn results_without_a_common_case_cannot_be_compared() {
    let folder = folder("compare_nothing");
    fs::write(folder.join("scene.toml"), blind_scene(0.3, "")).unwrap();
    for (out, seeds) in [("one", "0..2"), ("two", "2..4")] {
        let sweep = ["sweep", "scene.toml", "--seeds", seeds, "--out", out];
        assert_eq!(outcome(&mut wherein(&folder, &sweep)).0, 0);
    }
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["compare", "one", "two"]));
    assert_eq!(code, 2);
    assert!(stderr.starts_with("wherein: failed to compare one and two: no case ran in both"), "{stderr}");
}

/// Results of a sweep over ten seeds, in which the seeds from `from` on have the figures `changed`, and all others those of a run without failures.
fn table(from: u64, changed: &str) -> Side {
    let mut text = "scene,seed,status,passed,containment.contained_share,containment.unsound,containment.perception,\
                    containment.bound_broken,width.x_m.mean,width.y_m.mean\n"
        .to_owned();
    for seed in 0..10 {
        let same = "true,1,0,0,0,0.01,0.01";
        text += &format!("scene,{seed},done,{}\n", if seed < from { same } else { changed });
    }
    Side::parse(&text).unwrap()
}

#[test]
fn one_case_that_breaks_a_promise_is_worse_whatever_the_means_say() {
    // The results that are compared against have a failure themselves: in their last seed a bound is broken at some steps.
    let first = table(9, "true,0.9,0,0,100,0.01,0.01");
    assert!(!compare(&first, &first, Demand::default()).is_worse());
    let unsound = compare(&first, &table(9, "true,0.9,100,0,0,0.01,0.01"), Demand::default());
    assert!(unsound.is_worse() && unsound.graver == ["scene seed 9"] && unsound.lost.is_empty());
    assert!(compare(&first, &table(9, "true,0.9,0,1,99,0.01,0.01"), Demand::default()).is_worse(), "perception");
    let lost = compare(&first, &table(8, "true,0.9,0,0,100,0.01,0.01"), Demand::default());
    assert_eq!((lost.lost.as_slice(), finding(&lost, "contained")), (&["scene seed 8".to_owned()][..], Finding::Worse));
    let missed = compare(&first, &table(9, "false,0.9,0,0,100,0.01,0.01"), Demand::default());
    assert!(missed.is_worse() && missed.missed == ["scene seed 9"]);
    assert!(
        !compare(&table(9, "false,0.9,0,1,99,0.01,0.01"), &first, Demand::default()).is_worse(),
        "the other way round"
    );
}

#[test]
fn a_box_that_is_wider_in_y_alone_is_worse() {
    let wider = compare(&table(10, ""), &table(0, "true,1,0,0,0,0.01,0.02"), Demand::default());
    assert_eq!(
        (finding(&wider, "width in x"), finding(&wider, "width in y")),
        (Finding::NotDistinguishable, Finding::Worse)
    );
}

#[test]
fn what_is_not_told_any_more_is_not_taken_for_unchanged() {
    let (whole, nan) = (table(10, ""), table(9, "true,1,0,0,0,NaN,0.01"));
    let comparison = compare(&whole, &nan, Demand::default());
    assert!(comparison.is_worse() && comparison.half_known == ["width.x_m.mean"]);
    let mut fewer = table(10, "");
    fewer.cases.pop_last();
    let comparison = compare(&whole, &fewer, Demand::default());
    assert!(comparison.is_worse() && comparison.unpaired[0] == ["scene seed 9"]);
    assert!(!compare(&fewer, &whole, Demand::default()).is_worse());
}
