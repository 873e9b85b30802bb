//! Benchmark of speed on the present machine, beside the goals for two cores without a GPU: medians, printed as a table.

#![allow(clippy::unwrap_used)]

use std::{hint::black_box, path::Path, time::Instant};

use interval::{Interval, IntervalBox};
use localizer::{
    Pose, PoseBox, PoseUnion, Reading,
    localizer::Account,
    methods::wall_directions::{Setup, WallDirections},
    reading::Camera,
    vision::forward::{self, Picture, stabilise},
};
use nalgebra::{UnitQuaternion, Vector3};
use sim::{
    place::{building::Building, light::bake},
    render::{Renderer, View},
    run::{
        RunOptions, RunRecord, run,
        sensors::still::{take, views_at},
    },
    scene::Scene,
    subject::{Answer, IntervalLocalizer, Subject},
    world::Drawn,
};

fn main() {
    println!("{:<44} {:>10}   aim", "what", "median");
    // `make bench-render` runs the measurements of rendered views alone.
    if !std::env::args().any(|argument| argument == "views") {
        intervals();
        runs();
        steps();
        forward_frames();
        rolling_frames();
        people_in_a_hall();
        supermarket();
        home();
    }
    light_maps();
    views();
    memory();
}

/// Prints one line of the table: what was measured, its median, and the goal.
fn line(what: &str, median: f64, unit: &str, aim: &str) {
    println!("{what:<44} {median:>10.2} {unit}   {aim}");
}

fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn intervals() {
    const COUNT: usize = 4096;
    let operands: Vec<Interval> =
        (0..COUNT).map(|index| Interval::centred(0.5 + index as f64 / COUNT as f64, 1e-3)).collect();
    // The goals for interval operations are 1.5 times the times measured when the library was designed: 1.3, 2.2, 2.9 and 41 ns.
    line("Interval add", nanoseconds(&operands, |a, b| a + b), "ns", "≤ 2.0");
    line("Interval mul", nanoseconds(&operands, |a, b| a * b), "ns", "≤ 3.3");
    line("Interval div", nanoseconds(&operands, |a, b| a / b), "ns", "≤ 4.4");
    line("Interval sin", nanoseconds(&operands, |a, _| a.sin()), "ns", "≤ 62");
}

/// Median time in nanoseconds of one interval operation; each operation gets two neighbouring intervals of the list `operands`.
fn nanoseconds(operands: &[Interval], operation: impl Fn(Interval, Interval) -> Interval) -> f64 {
    let mut results = vec![Interval::ZERO; operands.len() - 1];
    let mut pass = |_| {
        let began = Instant::now();
        for (result, pair) in results.iter_mut().zip(black_box(operands).windows(2)) {
            *result = operation(pair[0], pair[1]);
        }
        black_box(&results);
        began.elapsed().as_secs_f64() * 1e9 / results.len() as f64
    };
    median((0..101).map(&mut pass).collect())
}

fn runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut seen = Scene::load(&root.join("scenes/papers/floor_vision_odometry.toml")).unwrap();
    seen.duration_s = 20.0;
    let mut blind = seen.clone();
    blind.robot.floor_camera = None;
    let factor = |record: &RunRecord| record.truths.last().unwrap().time_s / record.timing.wall_s;

    let options = RunOptions::default();
    let without: Vec<f64> = (0..5)
        .map(|seed| {
            factor(&run(&blind, seed, &mut IntervalLocalizer::of(&blind), None, &options, &mut |_| {}).unwrap())
        })
        .collect();
    line("simulation without cameras", median(without), "× real time", "≥ 200");

    let mut renderer = Renderer::new().unwrap();
    let records: Vec<RunRecord> = (0..3)
        .map(|seed| {
            run(&seen, seed, &mut IntervalLocalizer::of(&seen), Some(&mut renderer), &options, &mut |_| {}).unwrap()
        })
        .collect();
    line(
        "simulation with the floor camera at 5 Hz",
        median(records.iter().map(factor).collect()),
        "× real time",
        "≥ 8",
    );
    let per_image = |stage: fn(&RunRecord) -> f64| {
        median(records.iter().map(|record| 1e3 * stage(record) / record.images.len() as f64).collect())
    };
    line("floor_tiles, an image of 640 × 480", per_image(|record| record.timing.vision_s), "ms", "≤ 3");
    line("rendering and sensor, an image of 640 × 480", per_image(|record| record.timing.render_s), "ms", "");
}

/// A localizer whose time for each wheel reading is measured, with all other readings but pictures that arrived since the one before.
struct Timed {
    subject: IntervalLocalizer,
    now_s: f64,
    steps_s: Vec<f64>,
    pictures_s: f64,
}

impl Timed {
    fn of(scene: &Scene) -> Self {
        Timed { subject: IntervalLocalizer::of(scene), now_s: 0.0, steps_s: Vec::new(), pictures_s: 0.0 }
    }
}

impl Subject for Timed {
    fn start(&mut self, start: &PoseBox) {
        self.subject.start(start);
    }

    fn observe(&mut self, reading: &Reading) {
        let began = Instant::now();
        self.subject.observe(reading);
        let took_s = began.elapsed().as_secs_f64();
        match reading {
            Reading::Camera { .. } => self.pictures_s += took_s,
            _ => self.now_s += took_s,
        }
        if let Reading::Wheels { .. } = reading {
            self.steps_s.push(std::mem::take(&mut self.now_s));
        }
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        self.subject.estimate_at(time_s)
    }

    fn accounts(&mut self) -> Vec<Account> {
        self.subject.accounts()
    }
}

/// Measures the steps of the localizer, each 10 ms of the drive, on paper 3's loop: with some 50 key frames and 36 landmarks.
fn steps() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scene = Scene::load(&root.join("scenes/papers/rigid_transform_loop.toml")).unwrap();
    let mut timed = Timed::of(&scene);
    run(&scene, 0, &mut timed, None, &RunOptions::default(), &mut |_| {}).unwrap();
    // The second half of the drive, with most key frames.
    let mut steps_s = timed.steps_s.split_off(timed.steps_s.len() / 2);
    let mean_s = steps_s.iter().sum::<f64>() / steps_s.len() as f64;
    steps_s.sort_by(f64::total_cmp);
    line("a step of the localizer in paper 3's loop, mean", 1e3 * mean_s, "ms", "≤ 1");
    line("  the longest of 1000", 1e3 * steps_s[steps_s.len() * 999 / 1000], "ms", "");
    line("  the longest of all", 1e3 * steps_s[steps_s.len() - 1], "ms", "≤ 20");
}

/// Measures the method `floor_tiles` on images whose rows are exposed one after the other while the robot moves: each is straightened anew.
fn rolling_frames() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut renderer = Renderer::new().unwrap();
    for (name, what) in [("rolling_shutter", "a rolling shutter"), ("bent_rolling_lens", "the same behind a bent lens")]
    {
        let mut scene = Scene::load(&root.join(format!("scenes/floor/{name}.toml"))).unwrap();
        scene.duration_s = 10.0;
        let (subject, options) = (&mut IntervalLocalizer::of(&scene), RunOptions::default());
        let record = run(&scene, 0, subject, Some(&mut renderer), &options, &mut |_| {}).unwrap();
        let per_image_ms = 1e3 * record.timing.vision_s / record.images.len() as f64;
        line(&format!("floor_tiles, {what}"), per_image_ms, "ms", "≤ 6");
    }
}

/// Measures a ceiling image of a hall of 30 m by 20 m with 96 lamps, empty and with three people who walk.
fn people_in_a_hall() {
    let hall = "duration_s = 3.0\n[room]\nwidth_m = 30.0\ndepth_m = 20.0\n[robot]\nfloor_camera = false\n[robot.ceiling_camera]\n\
                [localizer]\nmethods = [\"ceiling_markers\"]\n[start]\nx_m = 5.0\ny_m = 5.0\n[[route.waypoint]]\nx_m = 8.0\ny_m = 6.0\n";
    let people: String = [[[10, 10], [12, 11]], [[4, 12], [7, 12]], [[20, 5], [24, 6]]]
        .map(|way| format!("[[person]]\nwaypoints_m = {way:?}\n"))
        .concat();
    let mut renderer = Renderer::new().unwrap();
    for (what, text, aim) in [("empty", hall.to_owned(), ""), ("three people", hall.to_owned() + &people, "≤ 60")] {
        let scene = Scene::parse(&text, "hall.toml").unwrap();
        let (subject, options) = (&mut IntervalLocalizer::of(&scene), RunOptions::default());
        let record = run(&scene, 0, subject, Some(&mut renderer), &options, &mut |_| {}).unwrap();
        // No marker is on this ceiling, so that the record names no image that told something.
        let n_images = scene.duration_s / scene.robot.ceiling_camera.as_ref().unwrap().period_s;
        let per_image_ms = 1e3 * record.timing.render_s / n_images;
        line(&format!("a ceiling image of a hall, {what}"), per_image_ms, "ms", aim);
    }
}

/// Measures a drive through a supermarket among three people, and how long its first picture takes from the scene's file on. The layout of its
/// markers is kept from the first time on.
fn supermarket() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("scenes/rooms/supermarket.toml");
    Scene::load(&file).unwrap();
    let began = Instant::now();
    let mut scene = Scene::load(&file).unwrap();
    let (mut renderer, options) = (Renderer::new().unwrap(), RunOptions::default());
    let mut drive_for = |duration_s: f64| {
        scene.duration_s = duration_s;
        let subject = &mut IntervalLocalizer::of(&scene);
        run(&scene, 0, subject, Some(&mut renderer), &options, &mut |_| {}).unwrap()
    };
    drive_for(0.2);
    line("a supermarket's first pictures", began.elapsed().as_secs_f64(), "s", "≤ 5");
    let driven = drive_for(40.0);
    line(
        "a supermarket with three people",
        driven.truths.last().unwrap().time_s / driven.timing.wall_s,
        "× real time",
        "≥ 1",
    );
}

/// Measures a whole drive through the flat with all its cameras.
fn home() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scene = Scene::load(&root.join("scenes/home.toml")).unwrap();
    let mut timed = Timed::of(&scene);
    let mut renderer = Renderer::new().unwrap();
    let driven = run(&scene, 0, &mut timed, Some(&mut renderer), &RunOptions::default(), &mut |_| {}).unwrap();
    line("the flat, all cameras", driven.truths.last().unwrap().time_s / driven.timing.wall_s, "× real time", "≥ 4.5");
    let n_steps = timed.steps_s.len() as f64;
    line("  a step of the localizer, pictures aside", 1e3 * timed.steps_s.iter().sum::<f64>() / n_steps, "ms", "≤ 0.4");
    line("  pictures, for each step of 10 ms", 1e3 * timed.pictures_s / n_steps, "ms", "");
}

/// Measures each step of the method `wall_directions`, which computes headings from edges in images of the forward camera, on images of a room at 0.1
/// lx, on one core.
fn forward_frames() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scene = Scene::load(&root.join("scenes/papers/dark_carpet.toml")).unwrap();
    let drawn = Drawn::draw(&scene, 0);
    let mut renderer = Renderer::new().unwrap();
    let world = renderer.upload_room(&scene, &drawn).unwrap();
    let lux = world.illuminance_at_floor_lux().unwrap();
    let setup = Setup { solves_lean: true, floor_edges: true, ..Setup::default() };
    let mut steps: [Vec<f64>; 6] = Default::default();
    for index in 0..24 {
        let heading_rad = f64::from(index) * std::f64::consts::TAU / 24.0;
        let pose = Pose { x_m: 2.2, y_m: 1.8, heading_rad };
        let cameras = (&[Camera::Forward][..], 0);
        let stills = take(&mut renderer, &world, &scene, &drawn, pose, lux, cameras).unwrap();
        let picture = Picture::from(&stills[0].image);
        let near = IntervalBox::from([pose.x_m, pose.y_m, heading_rad].map(|at| Interval::centred(at, 0.05)));
        let mut walls = WallDirections::new(&scene.map(), &scene.robot_model(), setup).unwrap();
        let mut began = Instant::now();
        let mut step = |which: usize| {
            steps[which].push(1e3 * began.elapsed().as_secs_f64());
            began = Instant::now();
        };
        let even = black_box(stabilise::stabilised(&picture));
        let binned = even.binned();
        step(0);
        let filtered = black_box(forward::guided(&binned));
        step(1);
        let found = black_box(forward::long_segments(&filtered, &picture));
        step(2);
        let lines = black_box(forward::refitted(&even, &found));
        step(3);
        black_box(walls.constraint(0.0, &lines, &PoseUnion::single(near), &[]));
        step(4);
        black_box(forward::detect(&picture));
        step(5);
    }
    let names = ["noise made even, bins", "rolling guidance", "segments", "refit", "headings and lean"];
    let medians = steps.map(median);
    for (name, milliseconds) in names.iter().zip(medians) {
        line(&format!("wall_directions: {name}"), milliseconds, "ms", "");
    }
    // The whole processing of an image is the detection of edges, which covers the first four steps of the table in one call, and then the fifth
    // step, headings and lean.
    line("wall_directions, an image of 640 × 480", medians[5] + medians[4], "ms", "≤ 30");
}

/// Measures the computation of all light in a building, with which each run with cameras begins, on all cores.
fn light_maps() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let places = [("the flat of home.toml", "scenes/home.toml"), ("a living room", "scenes/rooms/living_room.toml")];
    for (place, path) in places {
        let scene = Scene::load(&root.join(path)).unwrap();
        let building = Building::new(&scene, &Drawn::draw(&scene, 0).place);
        let seconds = |_| {
            let began = Instant::now();
            black_box(bake(&scene, &building));
            began.elapsed().as_secs_f64()
        };
        line(&format!("light maps of {place}"), median((0..5).map(seconds).collect()), "s", "≤ 1");
    }
}

/// Measures the rendering of views of three cameras at once in a room with lamps, shadows and furniture, with the sensor model applied.
fn views() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scene = Scene::load(&root.join("scenes/rooms/living_room.toml")).unwrap();
    let drawn = Drawn::draw(&scene, 0);
    let mut renderer = Renderer::new().unwrap();
    let world = renderer.upload_room(&scene, &drawn).unwrap();
    let pose = Pose { x_m: 0.8, y_m: 0.9, heading_rad: 0.5 };
    let lux = world.illuminance_at_floor_lux().unwrap();
    let still: Vec<View> = views_at(&scene, &drawn, pose, lux, &Camera::ALL, 0);
    // During the exposure each camera turns about its image's u axis so far that points in the image's corners move by 5.9 px. The renderer draws
    // that motion as four sub-frames, which it averages.
    let moved = |view: &View| {
        let (lens, start) = (&view.lens, view.world_from_camera[0]);
        let [x, y] = [0, 1].map(|axis| 0.5 * f64::from(lens.size_px[axis]) / lens.focal_px[axis]);
        let turn_rad = 5.9 / (lens.focal_px[1] * (x * y).hypot(1.0 + y * y));
        let end = start * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), turn_rad);
        View { world_from_camera: vec![start, end], ..view.clone() }
    };
    let moving: Vec<View> = still.iter().map(moved).collect();
    for (what, views, aim) in [
        ("views of 640 × 480, three cameras a tick", &still, "≥ 250"),
        ("the same with four sub-frames", &moving, "≥ 90"),
    ] {
        renderer.draw(&world, views).unwrap();
        let per_s = |_| {
            let began = Instant::now();
            black_box(renderer.draw(&world, views).unwrap());
            views.len() as f64 / began.elapsed().as_secs_f64()
        };
        line(what, median((0..41).map(per_s).collect()), "views/s", aim);
        let mut spent_ms = |_| {
            let began_s = processor_s()?;
            black_box(renderer.draw(&world, views).unwrap());
            Some(1e3 * (processor_s()? - began_s))
        };
        if let Some(spent_ms) = (0..41).map(&mut spent_ms).collect::<Option<Vec<f64>>>() {
            line("  processor time of a tick, all cores", spent_ms.into_iter().fold(f64::MAX, f64::min), "ms", "");
        }
    }
    for (camera, view) in Camera::ALL.iter().zip(&still) {
        let views = std::slice::from_ref(view);
        let milliseconds = |_| {
            let began = Instant::now();
            black_box(renderer.draw(&world, views).unwrap());
            1e3 * began.elapsed().as_secs_f64()
        };
        line(
            &format!("one view of the {} camera", camera.as_str()),
            median((0..41).map(milliseconds).collect()),
            "ms",
            "",
        );
    }
}

/// Measures how much more memory the process holds after 1000 images of moving cameras, with new light each tick, than after 100.
fn memory() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scene = Scene::load(&root.join("scenes/rooms/living_room.toml")).unwrap();
    let drawn = Drawn::draw(&scene, 0);
    let mut renderer = Renderer::new().unwrap();
    let world = renderer.upload_room(&scene, &drawn).unwrap();
    let (mut n_pictures, mut early_mb) = (0, None);
    while n_pictures < 1000 {
        let turned = f64::from(n_pictures) * 0.01;
        let pose = Pose { x_m: 0.8 + 0.1 * turned.sin(), y_m: 0.9, heading_rad: turned };
        let lux = 100.0 * (1.1 + turned.sin());
        let views = views_at(&scene, &drawn, pose, lux, &Camera::ALL, 0);
        black_box(renderer.draw(&world, &views).unwrap());
        n_pictures += views.len() as u32;
        if n_pictures >= 100 && early_mb.is_none() {
            early_mb = resident_mb();
        }
    }
    if let (Some(early_mb), Some(late_mb)) = (early_mb, resident_mb()) {
        line("memory gained from picture 100 to 1000", late_mb - early_mb, "MB", "≤ 5");
    }
}

/// Processor time of all threads since the start, which measures speed even while other processes use the machine; `None` if the system does not
/// report it.
fn processor_s() -> Option<f64> {
    let of_thread = |thread: std::io::Result<std::fs::DirEntry>| {
        let spent = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        spent.split(' ').next()?.parse::<f64>().ok()
    };
    Some(std::fs::read_dir("/proc/self/task").ok()?.filter_map(of_thread).sum::<f64>() * 1e-9)
}

/// Memory that the process holds; `None` if the system does not report it in Linux's format.
fn resident_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?.trim().strip_suffix(" kB")?;
    Some(kilobytes.parse::<f64>().ok()? / 1024.0)
}
