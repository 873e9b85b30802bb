//! `wherein check`: what is to be said of a scene before it is run.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::{
    campaign::check::{self, CameraCheck, SceneCheck, Stretch, significant},
    loading::{SceneFile, SceneTemplate, Setting},
    render::Renderer,
};

use super::{CommandError, print, reading::while_reading, scenes_and_seeds::one_seed};

/// Arguments of `wherein check`.
#[derive(Debug, Args)]
#[command(after_help = CHECK_AFTER_HELP)]
pub(super) struct CheckArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Seed of everything that is drawn at random.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = one_seed)]
    seed: u64,
    /// Set a key of the scene, such as light.illuminance_at_floor_lux=10; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
    /// Print a JSON object instead of a text.
    #[arg(long)]
    json: bool,
}

const CHECK_AFTER_HELP: &str = "\
The robot is put to up to 24 places of its way and stands still there, people stand where they set out. Each camera takes a picture, and
the scene's methods look at it. Motion blur and slip are not in it: a scene without a doubt can still fail when it is run.
Exit code: 0 nothing is doubtful, 1 something is, 2 the scene is not valid or pictures cannot be drawn.";

/// Checks a scene and prints what was found.
pub(super) fn check_scene(arguments: &CheckArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    let file: SceneFile = while_reading(|| SceneTemplate::load(&arguments.scene)?.with(&arguments.set))?;
    let scene = &file.scene;
    let found = if scene.has_camera() {
        let mut renderer = Renderer::on_adapter(adapter)?;
        let bar = ProgressBar::no_length().with_style(
            ProgressStyle::with_template("{bar:30} place {pos} of {len}")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let found = check::check(scene, arguments.seed, &mut renderer, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        })?;
        bar.finish_and_clear();
        Some(found)
    } else {
        None
    };
    let doubts = found.as_ref().map_or_else(|| scene.remarks(), |found| found.doubts.clone());
    let unlooked = check::without_camera(scene);
    print(&if arguments.json {
        let path = arguments.scene.display().to_string();
        format!(
            "{:#}\n",
            json!({ "scene": path, "pictures": found, "methods_without_camera": unlooked, "doubts": doubts })
        )
    } else {
        text(&arguments.scene.display().to_string(), found.as_ref(), &unlooked, &doubts)
    })?;
    Ok(ExitCode::from(u8::from(!doubts.is_empty())))
}

fn text(scene: &str, found: Option<&SceneCheck>, unlooked: &[&str], doubts: &[String]) -> String {
    let mut text = format!("{scene} is a valid scene.\n");
    match found {
        Some(found) => text += &pictures(found),
        None => text += "Its robot has no camera, so that there are no pictures to look at.\n",
    }
    if !unlooked.is_empty() {
        text += &format!("Not looked at, as they read no camera: {}.\n", unlooked.join(", "));
    }
    text += "\n";
    if doubts.is_empty() {
        return text + "Nothing is doubtful.\n";
    }
    doubts.iter().fold(text + "Doubtful:\n", |text, doubt| text + "- " + doubt + "\n")
}

fn pictures(found: &SceneCheck) -> String {
    let [least, greatest] = found.floor_lux.map(significant);
    let places = if found.n_places == 1 { "place" } else { "places" };
    let whereabouts = found.way_m.map_or("stations".to_owned(), |way_m| format!("{places} along {way_m:.1} m of way"));
    let mut text = format!(
        "Pictures at {} {whereabouts}, seed {}; {least} to {greatest} lx at the floor.\n\
         At {} of these places some method learns something about the pose from a picture.\n\n",
        found.n_places, found.seed, found.places_with_constraint
    );
    for camera in &found.cameras {
        text += &camera_lines(camera);
    }
    text.extend(found.without_position.iter().map(stretch_line));
    text
}

fn stretch_line(stretch: &Stretch) -> String {
    let Stretch { along_way_m: [from_m, to_m], ends_m: [begin, end], n_places, n_with_heading } = stretch;
    format!(
        "No picture bounds the position from {from_m:.1} to {to_m:.1} m of the way, from ({:.1}, {:.1}) to ({:.1}, {:.1}) m; \
         the heading is seen at {n_with_heading} of these {n_places} places.\n",
        begin[0], begin[1], end[0], end[1]
    )
}

fn camera_lines(camera: &CameraCheck) -> String {
    let [shortest, longest] = camera.exposure_s.map(|exposure_s| significant(1e3 * exposure_s));
    let [darkest, brightest] = camera.mean_grey;
    let mut text = format!(
        "{:<8} exposure {shortest} to {longest} ms, mean grey {darkest:.0} to {brightest:.0}, at most {:.2} % white\n",
        camera.camera,
        100.0 * camera.white_share_max
    );
    if let (Some(in_view), Some(read)) = (camera.markers_in_view, camera.markers_read) {
        text += &format!("         {read} of {in_view} markers in view are read\n");
    }
    for method in &camera.methods {
        text += &format!(
            "         {}: {} of {} pictures tell something about the pose; {} claims, {} of them false\n",
            method.method, method.constraints, method.pictures, method.claims, method.false_claims
        );
    }
    if camera.methods.is_empty() {
        text += "         no method reads it\n";
    }
    text
}
