//! Tests of upright edges of walls as bearings: drives whose pictures show ends of walls keep the truth, and the judge knows which edges are true.

use localizer::{Claim, bounds};
use serde_json::{Value, json};
use sim::{
    judge::{Verdict, is_true, watched},
    render::Renderer,
    run::{RunOptions, RunRecord, run},
    scene::{Distribution, Scene},
    subject::IntervalLocalizer,
    world::Drawn,
};

use crate::{judging::verdict_of, world_setup::scene};

/// A room of 7 m by 4 m with a passage between two partitions and a free wall behind it, in which a robot with gyroscope and forward camera drives.
fn passage(changes: &[(&str, Value)]) -> Scene {
    let wall = |name: &str, [x_m, y_m]: [f64; 2], size_m: [f64; 2]| {
        let mut piece =
            json!({ "name": name, "x_m": x_m, "y_m": y_m, "size_m": size_m, "height_m": 2.5, "wall": true });
        piece["albedo"] = json!(0.4);
        piece
    };
    let quotas = json!({ "wrong_share": 0.1, "wrong_sightings": 1 });
    let mut keys = json!({
        "duration_s": 6.0,
        "bounds_from": "laboratory",
        "room": { "width_m": 7.0, "depth_m": 4.0 },
        "building": { "ceiling_height_m": 2.5 },
        "floor": { "friction": 0.8 },
        "light": { "illuminance_at_floor_lux": 200.0 },
        "start": { "x_m": 0.8, "y_m": 1.9, "heading_deg": 0.0, "tolerance_m": 0.08, "tolerance_deg": 2.0 },
        "robot": {
            "floor_camera": false,
            "gyro": true,
            "forward_camera": { "period_s": 0.2, "sensor": { "preset": "machine_vision" } },
        },
        "furniture": [
            wall("partition, south", [3.2, 0.7], [0.1, 1.4]),
            wall("partition, north", [3.2, 3.4], [0.1, 1.2]),
            wall("free wall", [5.0, 2.3], [0.1, 0.7]),
            { "name": "table", "x_m": 2.2, "y_m": 3.3, "size_m": [0.5, 0.5], "rotation_deg": 30.0 },
        ],
        "localizer": { "methods": ["wall_bearings"], "wall_bearings": quotas, "declared_width_m": 0.2 },
        "route": { "waypoint": [{ "x_m": 1.6, "y_m": 2.3 }, { "x_m": 2.3, "y_m": 1.8 }] },
    });
    for (path, value) in changes {
        *keys.pointer_mut(path).unwrap_or_else(|| panic!("{path}")) = value.clone();
    }
    scene(keys)
}

fn judged(scene: &Scene, seed: u64, renderer: &mut Renderer) -> (RunRecord, Verdict) {
    let mut localizer = IntervalLocalizer::of(scene);
    let record = run(scene, seed, &mut localizer, Some(renderer), &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}

#[test]
fn drives_by_ends_of_walls_keep_the_truth_and_narrow_the_box() {
    let mut renderer = Renderer::new().unwrap();
    for errors in [Distribution::Uniform, Distribution::Corner] {
        let mut scene = passage(&[]);
        scene.robot.errors = errors;
        let (record, verdict) = judged(&scene, 1, &mut renderer);
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!(containment.contained, containment.checks, "{errors:?}: {verdict:?}");
        assert!(verdict.violations.is_empty(), "{errors:?}: {:?}", verdict.violations);
        assert!(watched(&scene, &record).contains(bounds::WALLS_PLACEMENT));
        // Where all sightings may be false, they say nothing.
        scene.localizer.wall_bearings.as_mut().unwrap().wrong_share = 1.0;
        let (without, _) = judged(&scene, 1, &mut renderer);
        let [with, without] = [&record, &without].map(|record| record.estimates.last().unwrap().pose.hull());
        let share = |axis: usize| with.width(axis) / without.width(axis);
        // The walls are ahead along x, so that they tell the place along y and the heading first. How far depends on the errors drawn.
        let most = if errors == Distribution::Uniform { 0.8 } else { 0.99 };
        assert!(share(1) < most && share(2) < most, "{errors:?}: {with:?} of {without:?}");
    }
}

#[test]
fn edges_of_walls_are_claimed_and_the_judge_knows_which_are_true() {
    let mut renderer = Renderer::new().unwrap();
    let scene = passage(&[]);
    let (record, _) = judged(&scene, 2, &mut renderer);
    let drawn = Drawn::draw(&scene, 2);
    let shifted = |claim: &Claim, by_px: f64, by_m: f64| {
        let Claim::WallUpright { lines, posts_m } = claim else { panic!("{claim:?}") };
        let moved = |[u, v]: [f64; 2]| [u + by_px, v];
        let lines = lines.iter().map(|(ends_px, bound_px)| (ends_px.map(moved), *bound_px)).collect();
        Claim::WallUpright { lines, posts_m: posts_m.iter().map(|[x, y]| [*x, y + by_m]).collect() }
    };
    let share = |by_px: f64, by_m: f64| {
        let claims = record.images.iter().flat_map(|image| image.claims.iter().map(move |claim| (image, claim)));
        let judged: Vec<bool> =
            claims.map(|(image, claim)| is_true(&shifted(claim, by_px, by_m), &scene, &drawn, &image.truth)).collect();
        assert!(judged.len() > 20, "{}", judged.len());
        judged.iter().filter(|is_true| **is_true).count() as f64 / judged.len() as f64
    };
    // What is claimed is mostly true where it stands, and false 6 px or 10 cm beside.
    assert!(share(0.0, 0.0) > 0.85, "{}", share(0.0, 0.0));
    assert!(share(6.0, 0.0) < 0.1 && share(0.0, 0.1) < 0.1, "{} {}", share(6.0, 0.0), share(0.0, 0.1));
}
