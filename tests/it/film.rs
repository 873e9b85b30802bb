use std::{fs, io::Cursor, path::Path};

use image::{AnimationDecoder, Frame, codecs::png::PngDecoder};

use crate::command::{blind_scene, folder, outcome, root, wherein};

/// The colours of boxes that hold the truth, of those that do not, and of the true pose.
const BOX: [u8; 3] = [0, 114, 178];
const MISS: [u8; 3] = [213, 60, 0];
const TRUTH: [u8; 3] = [0, 128, 92];

/// The frames of an animated PNG, each as a whole picture, as another program's decoder shows them.
fn frames(path: &Path) -> Vec<Frame> {
    let decoder = PngDecoder::new(Cursor::new(fs::read(path).unwrap())).unwrap();
    decoder.apng().unwrap().into_frames().collect_frames().unwrap()
}

/// How long a frame is shown.
fn shown_s(frame: &Frame) -> f64 {
    let (milliseconds, per) = frame.delay().numer_denom_ms();
    f64::from(milliseconds) / f64::from(per) / 1e3
}

/// Number of pixels of exactly this colour.
fn count(frame: &Frame, colour: [u8; 3]) -> usize {
    frame.buffer().pixels().filter(|pixel| pixel.0[..3] == colour).count()
}

#[test]
fn a_film_is_left_beside_the_other_files_and_changes_none_of_them() {
    let folder = folder("film");
    fs::write(folder.join("scene.toml"), blind_scene(3.0, "[expect]\nunsound = 0\n")).unwrap();
    for (out, film) in [("without", None), ("with", Some("--film")), ("again", Some("--film"))] {
        let arguments: Vec<&str> =
            ["run", "scene.toml", "--seeds", "0..2", "--out", out].into_iter().chain(film).collect();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &arguments));
        assert_eq!(code, 0, "{stderr}");
    }
    let read = |out: &str, seed: u64, file: &str| fs::read(folder.join(format!("{out}/scene/{seed}/{file}"))).unwrap();
    for seed in 0..2 {
        for file in ["summary.json", "boxes.csv", "steps.csv", "truth.tum", "estimate.tum"] {
            assert_eq!(read("with", seed, file), read("without", seed, file), "{file}");
        }
        assert_eq!(read("with", seed, "film.png"), read("again", seed, "film.png"), "equal runs, other bytes");
    }
    assert_ne!(read("with", 0, "film.png"), read("with", 1, "film.png"), "one film for two seeds");
    assert!(!folder.join("without/scene/0/film.png").exists());

    // 3 s are 25 times 0.12 s; the outcome comes after them.
    let frames = frames(&folder.join("with/scene/0/film.png"));
    let shown: Vec<f64> = frames.iter().map(shown_s).collect();
    assert_eq!(shown, [vec![0.12; 25], vec![2.0]].concat());
    let [first, .., last] = &frames[..] else { panic!("too few frames") };
    assert!(count(first, BOX) > 50 && count(first, TRUTH) > 50, "boxes and the true pose are drawn");
    // At the end the word "passed" stands in the colour of the truth, and a chart over the whole run.
    assert!(count(last, BOX) > 2 * count(first, BOX), "the chart has not grown");
    assert_eq!(count(last, MISS), 0);
}

#[test]
fn a_film_shows_distributions_and_a_run_that_failed_at_once() {
    let folder = folder("film_of_others");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    for (subject, code) in [("ekf", 0), ("particles", 0), ("exit 3", 1)] {
        let out = subject.split(' ').next().unwrap();
        let run = ["run", "scene.toml", "--film", "--subject", subject, "--out", out];
        let (ended, _, stderr) = outcome(&mut wherein(&folder, &run));
        assert_eq!(ended, code, "{stderr}");
        let frames = frames(&folder.join(out).join("scene/0/film.png"));
        let last = &frames[frames.len() - 1];
        match code {
            0 => assert!(frames.len() == 9 && count(last, BOX) + count(last, MISS) > 50, "{subject}"),
            // Of a run without a step there is the outcome alone.
            _ => assert!(frames.len() == 1 && count(last, MISS) > 50, "{subject}"),
        }
        assert_eq!(shown_s(last), 2.0);
    }
}

#[test]
fn resume_runs_again_what_has_no_film_yet() {
    let folder = folder("film_resumed");
    fs::write(folder.join("scene.toml"), blind_scene(0.5, "")).unwrap();
    let film = folder.join("renders/scene/0/film.png");
    let run = |more: &[&str]| {
        let arguments = [&["run", "scene.toml", "--resume"], more].concat();
        assert_eq!(outcome(&mut wherein(&folder, &arguments)).0, 0);
    };
    run(&[]);
    assert!(!film.exists());
    run(&["--film"]);
    let made = fs::metadata(&film).unwrap().modified().unwrap();
    run(&["--film"]);
    assert_eq!(fs::metadata(&film).unwrap().modified().unwrap(), made, "the film was made twice");
}

#[test]
fn a_sweep_and_a_replay_refuse_a_film() {
    let folder = folder("film_refused");
    fs::write(folder.join("scene.toml"), blind_scene(0.5, "")).unwrap();
    for command in ["sweep", "replay"] {
        let (code, _, stderr) = outcome(&mut wherein(&folder, &[command, "scene.toml", "--film"]));
        assert!(code == 2 && stderr.contains("'--film'"), "{command}: {stderr}");
    }
}

#[test]
fn the_film_of_the_gallery_has_at_most_3_mb_and_shows_the_whole_drive() {
    let path = root().join("docs/src/gallery/home_film.png");
    let length = fs::metadata(&path).unwrap().len();
    assert!(length <= 3_000_000, "{length} bytes");
    let frames = frames(&path);
    let lasts_s: f64 = frames.iter().map(shown_s).sum();
    assert!((10.0..=22.0).contains(&lasts_s), "{lasts_s} s");
    // Each camera's panel differs from one frame to the next: the robot drives, and the pictures are noisy.
    for (name, left, top) in [("floor", 12, 62), ("forward", 256, 62), ("ceiling", 12, 268)] {
        let panel = |frame: &Frame| image::imageops::crop_imm(frame.buffer(), left, top, 232, 174).to_image();
        let middle = frames.len() / 2;
        assert_ne!(panel(&frames[middle]), panel(&frames[middle + 1]), "{name} camera");
    }
    assert_eq!(count(&frames[frames.len() - 1], MISS), 0, "the run has failed");
}
