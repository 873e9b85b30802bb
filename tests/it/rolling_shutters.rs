//! Drives whose camera that looks ahead exposes its rows one after the other.

use sim::{judge::is_true, scene::Scene};

use crate::{command::root, render_studio::judged};

#[test]
fn edges_behind_a_rolling_shutter_are_claimed_where_they_are_at_the_stamp() {
    // 50 µs from row to row, so that an image takes 24 ms. With all rows taken for one instant, half of the upright edges of the first minute were
    // claimed falsely, and so were 6 to 8 % of the level ones; turned at 1 rad/s, the camera moves edges by up to 5 px from where they are at the
    // stamp.
    let mut scene = Scene::load(&root().join("scenes/home_bearings.toml")).unwrap();
    scene.duration_s = 24.0;
    scene.robot.forward_camera.as_mut().unwrap().lens.row_time_s = 5e-5;
    // A drive has some ninety claims of level edges, of which two more or fewer are false by chance, so that drives are counted together.
    let drives = [0, 1, 2].map(|seed| judged(&scene, seed));
    for (_, verdict) in &drives {
        let contained = verdict.containment.as_ref().unwrap();
        assert_eq!(contained.contained, contained.checks);
    }
    for (method, least, most_false) in [("wall_bearings", 30, 0.1), ("wall_directions", 120, 0.06)] {
        let claims = || {
            drives.iter().flat_map(|(record, _)| {
                record.images.iter().filter(|image| image.method == method).flat_map(|image| {
                    image.claims.iter().map(|claim| is_true(claim, &scene, &record.drawn, &image.truth))
                })
            })
        };
        let (n_all, n_false) = (claims().count(), claims().filter(|is_true| !is_true).count());
        println!("{method}: {n_false} of {n_all}");
        assert!(n_all >= least && n_false as f64 <= most_false * n_all as f64, "{method}: {n_false} of {n_all} false");
    }
}
