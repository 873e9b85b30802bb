//! `wherein render`: renders the pictures that the cameras of a standing robot take.

use std::{
    fs,
    path::{Path, PathBuf},
    str::FromStr,
};

use clap::Args;

use localizer::{Pose, reading::Camera};

use super::{CommandError, print, reading::while_reading, scenes_and_seeds::one_seed};
use crate::{
    artefacts::debug_frames::{Column, contact_sheet, tone_mapped},
    loading::SceneFile,
    place::building::{GroundPlan, UprightBody},
    render::Renderer,
    run::sensors::{
        LampStates,
        still::{Still, take},
    },
    scene::BitDepth,
    world::Drawn,
};

/// Arguments of `wherein render`.
#[derive(Debug, Args)]
#[command(after_help = RENDER_AFTER_HELP)]
pub(super) struct RenderArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Pose of the robot: x and y in metres, heading in degrees. By default the scene's start pose.
    #[arg(long, value_name = "X,Y,HEADING", allow_hyphen_values = true)]
    at: Option<At>,
    /// Take a picture with this camera only: floor, forward or ceiling.
    #[arg(long, value_name = "NAME", value_parser = camera_name)]
    camera: Option<Camera>,
    /// Mean illuminance at the floor in lux; all lamps are dimmed alike. By default what the scene states.
    #[arg(long, value_name = "LUX", value_parser = illuminance, allow_hyphen_values = true, conflicts_with = "contact_sheet")]
    lux: Option<f64>,
    /// Draw one sheet with the pictures of all cameras in several lights, such as lux=0.1,1,10,100,1000.
    #[arg(long, value_name = "lux=A,B,…")]
    contact_sheet: Option<Lights>,
    /// Seed of the camera mounts, the floor tiles and the image noise.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = one_seed)]
    seed: u64,
    /// Folder for the results. The pictures are written into a subfolder with the scene's name.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

const RENDER_AFTER_HELP: &str = "\
Writes DIR/<scene>/<camera>.png as the sensor gave it and <camera>_tone_mapped.png as a screen should show it,
or DIR/<scene>/contact_sheet.png. Exposures are those on which automatic exposure settles.";

fn camera_name(text: &str) -> Result<Camera, String> {
    let found = Camera::ALL.into_iter().find(|name| name.as_str() == text);
    found.ok_or_else(|| format!("expected one of {}", Camera::ALL.map(Camera::as_str).join(", ")))
}

/// A place and a heading on the command line: `1.5,2,90` for x = 1.5 m, y = 2 m and 90°.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At {
    x_m: f64,
    y_m: f64,
    heading_deg: f64,
}

/// The illuminances of a contact sheet on the command line, in lux: `lux=0.1,1,10`.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    lux: Vec<f64>,
}

impl FromStr for At {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x_m, y_m, heading_deg]) if [x_m, y_m, heading_deg].iter().all(|number| number.is_finite()) => {
                Ok(At { x_m, y_m, heading_deg })
            }
            _ => Err("expected x, y in metres and a heading in degrees, such as 1.5,2,90".to_owned()),
        }
    }
}

impl FromStr for Lights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lux = text.strip_prefix("lux=").and_then(|list| {
            let numbers: Option<Vec<f64>> = list.split(',').map(|part| illuminance(part).ok()).collect();
            numbers
        });
        lux.map(|lux| Lights { lux }).ok_or_else(|| {
            "expected lux= and illuminances from 0 to 100000 lx, such as lux=0.1,1,10,100,1000".to_owned()
        })
    }
}

/// Parses an illuminance at the floor in lux from the command line.
pub(super) fn illuminance(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|lux| (0.0..=100_000.0).contains(lux))
        .ok_or_else(|| "expected an illuminance at the floor from 0 to 100000 lx".to_owned())
}

/// Renders the pictures that the arguments ask for and prints the names of their files.
pub(super) fn render(arguments: &RenderArguments, adapter: Option<&str>) -> Result<(), CommandError> {
    let mut files = while_reading(|| SceneFile::load_all(std::slice::from_ref(&arguments.scene)))?;
    if files.len() != 1 {
        return Err(CommandError::SeveralScenes { path: arguments.scene.clone(), count: files.len() });
    }
    let file = files.remove(0);
    let cameras = cameras(arguments.camera, &file)?;
    let pose = pose(arguments.at, &file)?;
    let drawn = Drawn::draw(&file.scene, arguments.seed);
    let mut renderer = Renderer::on_adapter(adapter)?;
    let mut world = renderer.upload_room(&file.scene.as_built(&drawn.place), &drawn)?;
    let lamps = LampStates::new(&file.scene, &world).at(0.0).clone();
    world.switch_lamps(&lamps.shares);
    world.place_bodies(&file.scene.people.iter().filter_map(UprightBody::setting_out).collect::<Vec<_>>());
    let folder = arguments.out.join(&file.name);
    fs::create_dir_all(&folder).map_err(|error| CommandError::Unwritable(folder.clone(), error))?;
    let mut take_in = |lux: Option<f64>| -> Result<Column, CommandError> {
        let lux = lux.unwrap_or(lamps.illuminance_at_floor_lux);
        let stills = take(&mut renderer, &world, &file.scene, &drawn, pose, lux, (cameras.as_slice(), arguments.seed))?;
        Ok(Column { illuminance_at_floor_lux: lux, stills })
    };
    if let Some(lights) = &arguments.contact_sheet {
        let columns: Vec<Column> = lights.lux.iter().map(|lux| take_in(Some(*lux))).collect::<Result<_, _>>()?;
        let title = format!(
            "{}   at {:.2} m, {:.2} m, {:.0}°   seed {}",
            file.name,
            pose.x_m,
            pose.y_m,
            pose.heading_rad.to_degrees(),
            arguments.seed
        );
        let sheet = contact_sheet(&title, &columns);
        return save(&folder.join("contact_sheet.png"), |path| sheet.save(path));
    }
    for Still { camera, image, levels, sensor, .. } in take_in(arguments.lux)?.stills {
        let raw = folder.join(format!("{}.png", camera.as_str()));
        match sensor.bits {
            BitDepth::Eight => save(&raw, |path| image.save(path))?,
            BitDepth::Ten | BitDepth::Twelve => save(&raw, |path| levels.save(path))?,
        }
        let toned = tone_mapped(&levels);
        save(&folder.join(format!("{}_tone_mapped.png", camera.as_str())), |path| toned.save(path))?;
    }
    Ok(())
}

fn cameras(wanted: Option<Camera>, file: &SceneFile) -> Result<Vec<Camera>, CommandError> {
    let fitted = file.scene.robot.cameras();
    match wanted {
        None if fitted.is_empty() => Err(CommandError::NoCamera { scene: file.path.clone(), wanted: None }),
        None => Ok(fitted),
        Some(camera) if fitted.contains(&camera) => Ok(vec![camera]),
        Some(camera) => Err(CommandError::NoCamera { scene: file.path.clone(), wanted: Some(camera.as_str()) }),
    }
}

/// Returns the pose that the user states, or else the scene's start pose. A stated pose must leave room for the robot's body, like any
/// other pose in a scene.
fn pose(at: Option<At>, file: &SceneFile) -> Result<Pose, CommandError> {
    let Some(at) = at else { return Ok(file.scene.nominal_start()) };
    let (scene, at_m, reach_m) = (&file.scene, [at.x_m, at.y_m], file.scene.robot.body_radius_m);
    let room_m = [scene.room.width_m, scene.room.depth_m];
    // The limits of the room allow this much more, as floating-point differences such as room width minus robot radius are not always exact.
    const ROUNDING_M: f64 = 1e-9;
    let least_m = reach_m - ROUNDING_M;
    let ground_plan = GroundPlan::of(scene);
    if ground_plan.has_further_rooms() {
        if ground_plan.wall_distance_m(at_m) < least_m {
            return Err(CommandError::ByWall { scene: file.path.clone(), at_m, reach_m });
        }
    } else if (0..2).any(|axis| !(least_m..=room_m[axis] - least_m).contains(&at_m[axis])) {
        return Err(CommandError::OutsideRoom { scene: file.path.clone(), at_m, room_m, reach_m });
    }
    if let Some(index) = scene.furniture.iter().position(|furniture| furniture.distance_m(at_m) < least_m) {
        let piece = scene.furniture[index].told(index);
        return Err(CommandError::InFurniture { scene: file.path.clone(), at_m, piece, reach_m });
    }
    Ok(Pose { x_m: at.x_m, y_m: at.y_m, heading_rad: at.heading_deg.to_radians() })
}

fn save(path: &Path, write: impl FnOnce(&Path) -> image::ImageResult<()>) -> Result<(), CommandError> {
    write(path).map_err(|error| CommandError::Unwritable(path.to_owned(), std::io::Error::other(error)))?;
    print(&format!("{}\n", path.display()))
}
