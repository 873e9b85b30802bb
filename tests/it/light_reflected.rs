//! Light that surfaces reflect onto each other, compared with closed forms, with sums over single reflections, and with a path tracer.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3, vector};
use sim::{
    place::{
        building::{Building, Material, Part, UprightBox},
        light::{LightMap, Lighting},
    },
    scene::Scene,
};

use crate::light_of_lamps::{baked, close};

#[test]
fn light_bounces_as_in_an_integrating_sphere() {
    // In a cube whose six faces have the same albedo ρ, with direct light E on the floor alone, the mean exitance is ρ·(E/6)/(1 − ρ),
    // whatever the view factors are.
    let text = "[room]\nwidth_m = 2.6\ndepth_m = 2.6\n[building]\nwall_albedo = 0.4\nceiling_albedo = 0.4\n\
                skirting_height_m = 0.0\n[start]\nx_m = 1.3\ny_m = 1.3\n[[route.waypoint]]\nx_m = 1.3\ny_m = 1.3\n\
                [light]\nilluminance_at_floor_lux = 100\n";
    let (building, _, map) = baked(&Scene::parse(text, "cube.toml").unwrap(), &[]);
    // Mean of direct and bounced illuminance over all surfaces of one kind in the room. Times the albedo it is their mean exitance (light given off
    // per area).
    let mean = |part: Part| {
        let panels = || building.panels.iter().enumerate().filter(|(_, panel)| panel.part == part);
        let sum: f64 = panels()
            .map(|(index, _)| {
                let places = (0..400).map(|k| (f64::from(k % 20) / 20.0 + 0.025, f64::from(k / 20) / 20.0 + 0.025));
                places.map(|(s, t)| map.at(index, s, t, 0)).sum::<f64>() / 400.0
            })
            .sum();
        sum / panels().count() as f64
    };
    let mean_illuminance = (mean(Part::Floor) + 4.0 * mean(Part::Wall) + mean(Part::Ceiling)) / 6.0;
    // In a closed room all light of the lamp is absorbed in the end. The lamp gives 1000 lm before dimming, and every face absorbs the share 1 − ρ of
    // the light that arrives.
    let area_m2 = 6.0 * 2.6 * 2.6;
    close(mean_illuminance, 1000.0 / (area_m2 * (1.0 - 0.4)), 0.02);
}

#[test]
fn light_that_bounces_goes_through_open_doors_and_none_is_lost() {
    // Two rooms of 3 m by 3 m, with the lamp in the first one. The surfaces of a room are its floor, walls and ceiling; the frames of the doors are
    // left out.
    let rooms = |hole: &str| {
        let text = format!(
            "[room]\nwidth_m = 3.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.7\nceiling_albedo = 0.8\n\
             skirting_height_m = 0.0\n[start]\nx_m = 1.3\ny_m = 1.3\n[[route.waypoint]]\nx_m = 1.3\ny_m = 1.3\n\
             [[lamp]]\nkind = \"panel\"\nx_m = 1.5\ny_m = 1.5\nlumens = 1000\nspectrum = \"monochrome\"\n\
             [[building.room]]\nx_m = 3.0\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 3.0\n{hole}"
        );
        baked(&Scene::parse(&text, "two.toml").unwrap_or_else(|error| panic!("failed to {error}")), &[])
    };
    // Light flux in lumens that all surfaces of one room absorb: what falls on them, times the share that they do not reflect.
    let taken_lm = |(building, _, map): &(Building, Lighting, LightMap), room: usize| -> f64 {
        let panels = building.panels.iter().enumerate();
        let of_room = panels.filter(|(_, panel)| panel.room == room && panel.part != Part::Thing);
        of_room
            .map(|(index, panel)| {
                let places = (0..400).map(|k| (f64::from(k % 20) / 20.0 + 0.025, f64::from(k / 20) / 20.0 + 0.025));
                let mean = places.map(|(s, t)| map.at(index, s, t, 0)).sum::<f64>() / 400.0;
                mean * panel.area_m2() * (1.0 - panel.material.albedo[0])
            })
            .sum()
    };
    let shut = rooms("");
    assert_eq!(taken_lm(&shut, 1), 0.0);
    close(taken_lm(&shut, 0), 1000.0, 0.02);
    let open = rooms("[[building.door]]\nfrom_m = [3.0, 0.5]\nto_m = [3.0, 2.0]\nheight_m = 2.0\nopen = true\n");
    let (first_lm, second_lm) = (taken_lm(&open, 0), taken_lm(&open, 1));
    close(first_lm + second_lm, 1000.0, 0.02);
    // The second room, which has no lamp, gets the share of the light bounced in the first room that meets the open doorway, and the light that the
    // lamp shines through it onto the floor.
    assert!((100.0..300.0).contains(&second_lm), "{first_lm} and {second_lm} lm");
}

/// Number of the panel on which a point lies, towards whose visible side it lies, and the point's shares of the panel's sides.
fn panel_at(building: &Building, at: Point3<f64>, normal: Vector3<f64>) -> (usize, [f64; 2]) {
    let faces = building.panels.iter().enumerate().filter(|(_, panel)| panel.normal().dot(&normal) > 0.999);
    let found = faces.filter_map(|(index, panel)| {
        let distance = panel.seen_along(at + normal * 0.02, -normal * 0.04)?;
        let from_corner = at - panel.corner;
        let shares = [panel.along, panel.up].map(|side| from_corner.dot(&side) / side.norm_squared());
        Some((distance, (index, shares)))
    });
    found.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, found)| found).unwrap()
}

/// Reflected illuminance at a point of a face, in lux, of lamps of 555 nm.
fn reflected((building, lighting, map): &(Building, Lighting, LightMap), at: Point3<f64>, normal: Vector3<f64>) -> f64 {
    let (panel, [s, t]) = panel_at(building, at, normal);
    map.at(panel, s, t, 0) - lighting.direct_at(at, normal, 12).lux / lighting.dimming
}

/// Illuminance at a point by light that one reflection from the floors brings there: the sum over small squares of the floors, of the light that
/// lamps give there, if nothing stands in between.
fn by_floors((building, lighting, _): &(Building, Lighting, LightMap), at: Point3<f64>, normal: Vector3<f64>) -> f64 {
    const SIDE_M: f64 = 0.05;
    let floors = building.panels.iter().filter(|panel| panel.normal().z > 0.999 && panel.corner.z.abs() < 0.01);
    let from = |panel: &sim::place::building::Panel| -> f64 {
        let count = panel.size_m().map(|side_m| (side_m / SIDE_M).ceil() as usize);
        let share = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
        let cells = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| (i, j)));
        cells
            .map(|(i, j)| {
                let place = panel.place(share(i, count[0]), share(j, count[1])) + Vector3::z() * 0.002;
                let way = place - at;
                let cosines = normal.dot(&way).max(0.0) * (-way.z).max(0.0) / way.norm_squared();
                if cosines == 0.0
                    || lighting.occluders.contain(place)
                    || lighting.occluders.block(at + normal * 0.002, place)
                {
                    return 0.0;
                }
                let lux = lighting.direct_at(place, Vector3::z(), 4).lux / lighting.dimming;
                let cell_m2 = panel.area_m2() / (count[0] * count[1]) as f64;
                panel.material.albedo[0] * lux * cosines * cell_m2 / (PI * way.norm_squared())
            })
            .sum()
    };
    floors.map(from).sum()
}

/// Rooms in which only the floors reflect light, so that all reflected light has been reflected once: they face nothing that reflects.
fn with_black_walls(more: &str) -> Scene {
    let text = format!(
        "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.0\nceiling_albedo = 0.0\n\
         skirting_albedo = 0.0\n\
         [floor]\ncovering = \"screed\"\n[start]\nx_m = 0.5\ny_m = 0.5\n[[route.waypoint]]\nx_m = 0.6\ny_m = 0.5\n\
         [[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 1.5\nlumens = 3000\nspectrum = \"monochrome\"\n{more}"
    );
    Scene::parse(&text, "black.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

#[test]
fn light_through_a_hole_counts_once() {
    let scene = with_black_walls(
        "[[building.room]]\nx_m = 4.1\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 3.0\n\
         [[building.door]]\nfrom_m = [4.0, 1.0]\nto_m = [4.0, 2.0]\nopen = true\n",
    );
    let rooms = baked(&scene, &[]);
    // In the dark room: its far wall, beside the door's height and above it, a wall beside, and the ceiling; in the lit one a wall.
    for (at, normal) in [
        ([7.1, 1.5, 1.0], -Vector3::x()),
        ([7.1, 1.2, 1.8], -Vector3::x()),
        ([6.0, 3.0, 1.2], -Vector3::y()),
        ([5.6, 1.5, 2.5], -Vector3::z()),
        ([1.0, 3.0, 1.2], -Vector3::y()),
    ] {
        let at = Point3::from(at);
        close(reflected(&rooms, at, normal), by_floors(&rooms, at, normal), 0.06);
    }
}

#[test]
fn furniture_hides_light_and_its_faces_get_what_they_see() {
    // A black cupboard in the middle, with the lamp on its one side.
    let cupboard = UprightBox {
        middle_m: [2.6, 1.5],
        heading_rad: 0.3,
        size_m: [0.4, 1.2],
        between_m: [0.0, 1.6],
        material: Material::matt(0.0),
    };
    let room = baked(&with_black_walls(""), &[cupboard]);
    let ahead = vector![0.3_f64.cos(), 0.3_f64.sin(), 0.0];
    let face = |side: f64, height_m: f64| (Point3::new(2.6, 1.5, height_m) + ahead * (0.2 * side), ahead * side);
    // Where the floor before a face lies in half shadow, which a reflector has as one mean, the face is off by a tenth.
    for ((at, normal), tolerance) in
        [(face(1.0, 0.8), 0.15), (face(1.0, 1.4), 0.15), (face(-1.0, 0.8), 0.04), (face(-1.0, 0.3), 0.04)]
    {
        close(reflected(&room, at, normal), by_floors(&room, at, normal), tolerance);
    }
    // The face away from the lamp sees a floor in shadow.
    let [lit, unlit] = [face(-1.0, 0.3), face(1.0, 0.3)].map(|(at, normal)| reflected(&room, at, normal));
    assert!(unlit < 0.6 * lit, "{unlit} and {lit} lx");
    // On the wall behind the cupboard.
    close(
        reflected(&room, Point3::new(4.0, 1.7, 0.9), -Vector3::x()),
        by_floors(&room, Point3::new(4.0, 1.7, 0.9), -Vector3::x()),
        0.06,
    );
}

#[test]
fn light_that_bounces_is_the_same_in_a_room_made_of_two() {
    // A room of 7.5 m by 4 m, and the same room made of two, with the lamp in the first part.
    let room = |width_m: f64, more: &str| {
        let text = format!(
            "[room]\nwidth_m = {width_m:?}\ndepth_m = 4.0\n[building]\nskirting_height_m = 0.0\n\
             [start]\nx_m = 1.3\ny_m = 1.3\n[[route.waypoint]]\nx_m = 1.3\ny_m = 1.3\n\
             [[lamp]]\nkind = \"panel\"\nx_m = 1.5\ny_m = 2.0\nlumens = 3000\nspectrum = \"monochrome\"\n{more}"
        );
        baked(&Scene::parse(&text, "seam.toml").unwrap_or_else(|error| panic!("failed to {error}")), &[])
    };
    let joined = room(
        4.0,
        "[[building.room]]\nx_m = 4.0\ny_m = 0.0\nwidth_m = 3.5\ndepth_m = 4.0\n\
         [[building.door]]\nfrom_m = [4.0, 0.0]\nto_m = [4.0, 4.0]\nheight_m = 2.5\nopen = true\n",
    );
    let whole = room(7.5, "");
    for (x_m, is_floor) in [1.5, 3.0, 3.98, 4.02, 5.0, 6.5].into_iter().flat_map(|x_m| [(x_m, true), (x_m, false)]) {
        let (at, normal) = if is_floor {
            (Point3::new(x_m, 2.0, 0.0), Vector3::z())
        } else {
            (Point3::new(x_m, 0.0, 1.2), Vector3::y())
        };
        close(reflected(&joined, at, normal), reflected(&whole, at, normal), 0.03);
        // People, lamps and dots are lit by a coarser model.
        let of_lattice = |rooms: &(Building, Lighting, LightMap)| {
            let at = at + normal * 0.01;
            rooms.1.at(at, normal, rooms.0.room_at(at), 8).lux - rooms.1.direct_at(at, normal, 8).lux
        };
        close(of_lattice(&joined) / joined.1.dimming, reflected(&joined, at, normal), 0.1);
    }
}
