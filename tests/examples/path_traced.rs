//! Light in five scenes as this project computes it, for `scripts/path_traced`, which compares it with a path tracer.
//!
//! Writes a file in JSON for each scene: the flat faces of the building with their albedos, the lamps, and pictures of radiance in cd/m²: at each
//! pixel the illuminance of the light map times the albedo of the face that is seen there, over π. Frames of doors and bars of windows, which cast no
//! shadows here, are left out.
#![allow(clippy::unwrap_used)]

use std::{env, f64::consts::PI, fs, path::Path};

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use sim::{
    place::{
        building::Building,
        drawn::DrawnPlace,
        light::{LightMap, Lighting, Shape, bake},
    },
    scene::Scene,
};

const SIZE_PX: [usize; 2] = [160, 120];
const FOCAL_PX: f64 = 80.0;
/// Rays along each side of a pixel.
const RAYS: usize = 3;

const LAMP: &str = "[[lamp]]\nkind = \"panel\"\nlumens = 3000\nspectrum = \"monochrome\"\n";

/// A scene to compare: its name, its keys, and for each picture the place of the eye and the place that it looks at.
type Case = (&'static str, String, Vec<[[f64; 3]; 2]>);

fn cases() -> Vec<Case> {
    let room = |width_m: f64, depth_m: f64, more: &str| {
        format!(
            "[room]\nwidth_m = {width_m:?}\ndepth_m = {depth_m:?}\n[building]\nwall_albedo = 0.7\n\
             ceiling_albedo = 0.8\nskirting_albedo = 0.7\n[floor]\ncovering = \"screed\"\n[start]\nx_m = 0.5\ny_m = 0.5\n\
             [[route.waypoint]]\nx_m = 0.6\ny_m = 0.5\n{more}"
        )
    };
    let lamp = |x_m: f64, y_m: f64| format!("{LAMP}x_m = {x_m:?}\ny_m = {y_m:?}\n");
    let furniture = "[[furniture]]\nname = \"cupboard\"\nx_m = 3.2\ny_m = 2.6\nsize_m = [1.0, 0.5]\nheight_m = 1.8\n\
                     albedo = 0.5\n\
                     [[furniture]]\nname = \"table\"\nx_m = 1.2\ny_m = 1.9\nsize_m = [0.8, 1.2]\nheight_m = 0.7\n\
                     rotation_deg = 20\nalbedo = 0.4\n";
    let second = "[[building.room]]\nx_m = 4.1\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 3.0\n\
                  [[building.door]]\nfrom_m = [4.0, 1.0]\nto_m = [4.0, 2.0]\nopen = true\n";
    let corners = vec![[[0.3, 0.3, 1.2], [4.0, 2.6, 0.9]], [[3.7, 2.0, 1.6], [0.0, 0.8, 0.6]]];
    let both = vec![[[0.3, 0.4, 1.2], [4.0, 1.7, 1.0]], [[6.8, 2.7, 1.3], [4.1, 1.0, 0.9]]];
    vec![
        ("one_room", room(4.0, 3.0, &lamp(1.5, 1.2)), corners.clone()),
        ("furnished", room(4.0, 3.0, &format!("{}{furniture}", lamp(1.9, 1.2))), corners.clone()),
        ("two_lamps", room(4.0, 3.0, &format!("{}{}{furniture}", lamp(1.0, 1.0), lamp(3.0, 1.5))), corners),
        ("lamp_before_door", room(4.0, 3.0, &format!("{}{second}", lamp(2.0, 1.5))), both.clone()),
        ("lamp_behind_door", room(4.0, 3.0, &format!("{}{second}", lamp(5.6, 1.5))), both),
        (
            "hall",
            room(12.0, 3.0, &lamp(1.5, 1.5)),
            vec![[[0.3, 0.3, 1.4], [12.0, 2.0, 1.0]], [[8.0, 1.5, 1.4], [12.0, 1.6, 1.2]]],
        ),
    ]
}

fn main() {
    let folder = env::args().nth(1).unwrap();
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).unwrap();
    for (name, text, views) in cases() {
        let scene = Scene::parse(&text, name).unwrap_or_else(|error| panic!("failed to {error}"));
        let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
        let (lighting, map) = bake(&scene, &building);
        let panels: Vec<Value> = building.panels[..building.n_large_panels]
            .iter()
            .map(|panel| {
                let sides = [panel.corner.coords, panel.along, panel.up].map(|side| [side.x, side.y, side.z]);
                json!({ "corner": sides[0], "along": sides[1], "up": sides[2], "albedo": panel.material.albedo[0] })
            })
            .collect();
        let pictures: Vec<Value> = views.iter().map(|view| picture(&building, &lighting, &map, *view)).collect();
        let scene = json!({ "panels": panels, "lamps": lamps(&lighting), "pictures": pictures });
        fs::write(folder.join(format!("{name}.json")), scene.to_string()).unwrap();
    }
}

fn lamps(lighting: &Lighting) -> Vec<Value> {
    let rectangle = |shape: Shape| match shape {
        Shape::Rectangle { centre, half_u, half_v } => {
            let [centre, half_u, half_v] = [centre.coords, half_u, half_v].map(|side| [side.x, side.y, side.z]);
            Some(json!({ "centre": centre, "half_u": half_u, "half_v": half_v }))
        }
        Shape::Point { .. } => None,
    };
    let with_light = |(mut lamp, luminance): (Value, f64)| {
        lamp["luminance"] = json!(luminance);
        lamp
    };
    lighting
        .sources
        .iter()
        .filter_map(|source| Some((rectangle(source.shape)?, source.luminance())))
        .map(with_light)
        .collect()
}

/// Mean radiance in each pixel, and the face that its middle shows; radiance below 0 and no face where a ray meets a lamp or nothing.
fn picture(building: &Building, lighting: &Lighting, map: &LightMap, [eye, to]: [[f64; 3]; 2]) -> Value {
    let (eye_at, target) = (Point3::from(eye), Point3::from(to));
    let ahead = (target - eye_at).normalize();
    let right = ahead.cross(&Vector3::z()).normalize();
    let down = ahead.cross(&right);
    let seen = |u: f64, v: f64| {
        let ray = ahead * FOCAL_PX + right * (u - SIZE_PX[0] as f64 / 2.0) + down * (v - SIZE_PX[1] as f64 / 2.0);
        let faces = building.panels[..building.n_large_panels]
            .iter()
            .enumerate()
            .filter_map(|(index, panel)| Some((index, panel.seen_along(eye_at, ray)?)));
        let (index, distance) = faces.min_by(|one, other| one.1.total_cmp(&other.1))?;
        let is_lamp = lighting.sources.iter().any(|source| {
            let Shape::Rectangle { centre, half_u, half_v } = source.shape else { return false };
            let normal = half_u.cross(&half_v);
            let hit = eye_at + ray * (normal.dot(&(centre - eye_at)) / normal.dot(&ray)) - centre;
            [half_u, half_v].iter().all(|side| hit.dot(side).abs() <= side.norm_squared())
        });
        let panel = &building.panels[index];
        let at = eye_at + ray * distance - panel.corner;
        let [s, t] = [panel.along, panel.up].map(|side| at.dot(&side) / side.norm_squared());
        (!is_lamp).then(|| (index, panel.material.albedo[0] * map.at(index, s, t, 0) / PI))
    };
    let (mut radiance, mut faces) = (Vec::new(), Vec::new());
    for (row, column) in (0..SIZE_PX[1]).flat_map(|row| (0..SIZE_PX[0]).map(move |column| (row, column))) {
        let within = |index: usize| (index as f64 + 0.5) / RAYS as f64;
        let rays =
            (0..RAYS * RAYS).map(|index| (column as f64 + within(index % RAYS), row as f64 + within(index / RAYS)));
        let sum: Option<f64> = rays.map(|(u, v)| seen(u, v).map(|(_, radiance)| radiance)).sum();
        radiance.push(sum.map_or(-1.0, |sum| sum / (RAYS * RAYS) as f64));
        faces.push(seen(column as f64 + 0.5, row as f64 + 0.5).map_or(-1, |(index, _)| index as i64));
    }
    json!({ "eye": eye, "to": to, "size_px": SIZE_PX, "focal_px": FOCAL_PX, "radiance": radiance, "faces": faces })
}
