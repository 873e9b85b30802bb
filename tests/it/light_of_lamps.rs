use std::f64::consts::PI;

use nalgebra::{Point3, Vector3, vector};
use sim::{
    optics::Photons,
    place::{
        building::{Building, Material, Part, UprightBody, UprightBox},
        drawn::DrawnPlace,
        light::{LightMap, Lighting, Shape, Source, bake, nodes_with_people, polygon_irradiance},
    },
    scene::{Scene, Spectrum},
};

/// Scene with a room of 4 m by 3 m whose walls and ceiling are black, so that there is only direct light.
pub(crate) fn black_room(more: &str) -> Scene {
    let text = format!(
        "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.0\nceiling_albedo = 0.0\n\
         skirting_albedo = 0.0\n[start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n{more}"
    );
    Scene::parse(&text, "room.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

/// Illuminance of the floor at a point, in lux. The lamps of these tests emit light of 555 nm, for which the stored value needs no conversion.
fn at_floor(map: &LightMap, building: &Building, x_m: f64, y_m: f64) -> f64 {
    let floor = building.panels.iter().position(|panel| panel.part == Part::Floor).unwrap();
    map.at(floor, x_m / 4.0, y_m / 3.0, 0)
}

pub(crate) fn baked(scene: &Scene, boxes: &[UprightBox]) -> (Building, Lighting, LightMap) {
    let building = Building::furnished(scene, &DrawnPlace::draw(scene, 0), boxes.to_vec());
    let (lighting, map) = bake(scene, &building);
    (building, lighting, map)
}

pub(crate) fn close(value: f64, expected: f64, share: f64) {
    assert!((value / expected - 1.0).abs() < share, "{value}, expected {expected}");
}

const BULB: &str =
    "[[lamp]]\nkind = \"point\"\nx_m = 1.0\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n";

#[test]
fn a_bulb_follows_the_inverse_square_and_the_cosine() {
    let (building, _, map) = baked(&black_room(BULB), &[]);
    // A bulb of 1256.637 lm in all directions has 100 cd; straight below it, at a distance of 2 m, the floor has 100/4 lx.
    close(at_floor(&map, &building, 1.0, 1.5), 25.0, 0.01);
    // Expected illuminance at 2 m aside from the floor point below the bulb, which hangs 2 m high: d² = 8, cos = 2/√8.
    close(at_floor(&map, &building, 3.0, 1.5), 100.0 / 8.0 * (2.0 / 8_f64.sqrt()), 0.01);
    // Expected illuminance at 2.9 m along x and 1.4 m along y from the floor point below the bulb, which hangs 2 m high: d² = 4 + 8.41 + 1.96.
    close(at_floor(&map, &building, 3.9, 2.9), 100.0 * 2.0 / 14.37_f64.powf(1.5), 0.01);
}

#[test]
fn a_panel_gives_what_the_closed_form_of_a_rectangle_says() {
    let panel = "[[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 1.5\nheight_m = 1.5\nsize_m = [1.2, 0.6]\n\
                 lumens = 3000\nspectrum = \"monochrome\"\n";
    let (building, _, map) = baked(&black_room(panel), &[]);
    let luminance = 3000.0 / (PI * 1.2 * 0.6);
    // Illuminance below a corner of a parallel rectangle a × b at height h: E = L/2·(a/√(a² + h²)·atan(b/√(a² + h²)) + b/√(b² +
    // h²)·atan(a/√(b² + h²))).
    let corner = |a: f64, b: f64, h: f64| {
        let (along, across) = (a.hypot(h), b.hypot(h));
        0.5 * luminance * (a / along * (b / along).atan() + b / across * (a / across).atan())
    };
    close(at_floor(&map, &building, 2.0, 1.5), 4.0 * corner(0.6, 0.3, 1.5), 0.01);
    close(at_floor(&map, &building, 2.6, 1.8), corner(1.2, 0.6, 1.5), 0.01);
    // The point is 1 m beyond the panel's end on its axis: twice the light of the long rectangle less that of the short one.
    let beyond = 2.0 * (corner(2.2, 0.3, 1.5) - corner(1.0, 0.3, 1.5));
    close(at_floor(&map, &building, 3.6, 1.5), beyond, 0.01);
}

#[test]
fn an_upright_surface_sees_only_what_is_before_it() {
    // Expected irradiance of an upright surface by a rectangle overhead, half of which is behind the surface: E = L/2·(atan(b/h) − h/√(a² +
    // h²)·atan(b/√(a² + h²))) for each corner rectangle, a deep and b wide, in front of the surface and h above the point.
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| vector![x, y, 1.5]);
    let (a, b, h) = (1.0_f64, 1.0_f64, 1.5_f64);
    let one = 0.5 * ((b / h).atan() - h / a.hypot(h) * (b / a.hypot(h)).atan());
    close(polygon_irradiance(&corners, Vector3::x()), 2.0 * one, 1e-9);
    close(polygon_irradiance(&corners, -Vector3::y()), 2.0 * one, 1e-9);
    assert_eq!(polygon_irradiance(&corners, -Vector3::z()), 0.0);
}

#[test]
fn a_large_rectangle_close_by_gives_pi_times_its_luminance() {
    let corners = [[-1e4, -1e4], [1e4, -1e4], [1e4, 1e4], [-1e4, 1e4]].map(|[x, y]| vector![x, y, 1.0]);
    close(polygon_irradiance(&corners, Vector3::z()), PI, 1e-6);
}

#[test]
fn a_lamp_given_in_lux_gives_them_at_the_floor_below() {
    let tube = "[[lamp]]\nkind = \"tube\"\nx_m = 2.0\ny_m = 1.0\nheading_deg = 90\nilluminance_at_floor_lux = 120\n\
                spectrum = \"monochrome\"\n";
    let (building, lighting, map) = baked(&black_room(tube), &[]);
    close(at_floor(&map, &building, 2.0, 1.0) * lighting.dimming, 120.0, 0.01);
    let window = "[[lamp]]\nkind = \"window\"\nx_m = 2.0\ny_m = 0.0\nheading_deg = 90\n\
                  illuminance_at_floor_lux = 200\nspectrum = \"monochrome\"\n";
    let (building, lighting, map) = baked(&black_room(window), &[]);
    // The illuminance is taken 1 m in front of the wall with the window.
    close(at_floor(&map, &building, 2.0, 1.004) * lighting.dimming, 200.0, 0.01);
}

#[test]
fn lamps_without_output_give_what_the_light_states() {
    let lamps = "[light]\nilluminance_at_floor_lux = 40\n[[lamp]]\nkind = \"panel\"\nx_m = 1.0\ny_m = 1.0\n\
                 spectrum = \"monochrome\"\n";
    let (_, lighting, map) = baked(&black_room(lamps), &[]);
    close(map.mean_at_floor.lux * lighting.dimming, 40.0, 1e-9);
}

#[test]
fn illuminance_at_the_camera_is_that_on_an_upright_plane_at_its_lens() {
    // Expected illuminance on an upright plane at the lens, facing ahead: the bulb is 1.12 m ahead of the robot's start, less 0.12 m for the lens,
    // and 2 m − 0.25 m above the lens: E = I·cos θ/d².
    let scene = black_room(&format!(
        "{}[light]\nilluminance_at_camera_lux = 0.1\n[robot.forward_camera]\n[floor.tiles]\n\
         tile_albedo = 0.0\njoint_albedo = 0.0\n",
        BULB.replace("x_m = 1.0", "x_m = 3.12")
    ));
    let (_, lighting, _) = baked(&scene, &[]);
    let candela = 100.0 * lighting.dimming;
    let square: f64 = 1.0 + 1.75 * 1.75;
    close(candela / square * (1.0 / square.sqrt()), 0.1, 0.01);
}

#[test]
fn shadow_edges_are_where_similar_triangles_put_them() {
    // The bulb is at x = 1 and 2 m up, and a board 1 m up reaches from x = 1.5 to 1.9: its shadow reaches from x = 2.0 to 2.8.
    let board = UprightBox {
        middle_m: [1.7, 1.5],
        heading_rad: 0.0,
        size_m: [0.4, 1.0],
        between_m: [0.999, 1.0],
        material: Material::matt(0.5),
    };
    let (building, _, map) = baked(&black_room(BULB), &[board]);
    let (open, _, lit_map) = baked(&black_room(BULB), &[]);
    let share = |x: f64| at_floor(&map, &building, x, 1.5) / at_floor(&lit_map, &open, x, 1.5);
    assert!(share(1.85) > 0.99 && share(2.4) < 0.01 && share(2.95) > 0.99);
    let crossing = |from: f64, to: f64| {
        let place = |index: i32| from + (to - from) * f64::from(index) / 2000.0;
        place((0..2000).find(|index| (share(place(*index)) - 0.5).signum() != (share(from) - 0.5).signum()).unwrap())
    };
    // The light map stores the floor's illuminance at nodes some centimetres apart; a shadow's edge must be found more precisely than that.
    for (edge, expected) in [(crossing(1.85, 2.4), 2.0), (crossing(2.4, 2.95), 2.8)] {
        assert!((edge - expected).abs() < 0.01, "{edge}, expected {expected}");
    }
}

#[test]
fn the_shadow_of_furniture_by_a_bulb_is_little_less_sharp_than_the_bulb_makes_it() {
    // A bulb of 10 cm hangs at x = 1 and 2.1 m up, and a seat 0.4 m up begins at x = 1.5. From the points of the bulb's disc that are farthest aside,
    // at x = 1.048 and 0.952 and 2.114 m and 2.086 m up, rays past the seat's edge meet the floor at x = 1.6055 and 1.6300, from its middle at 1.6176.
    let seat = UprightBox {
        middle_m: [1.7, 1.5],
        heading_rad: 0.0,
        size_m: [0.4, 1.0],
        between_m: [0.399, 0.4],
        material: Material::matt(0.5),
    };
    let bulb = BULB.replace("height_m = 2.0", "height_m = 2.1");
    let (building, _, map) = baked(&black_room(&bulb), &[seat]);
    let (open, _, lit_map) = baked(&black_room(&bulb), &[]);
    let share = |x: f64| at_floor(&map, &building, x, 1.5) / at_floor(&lit_map, &open, x, 1.5);
    let falls_below = |least: f64| {
        let place = |index: i32| 1.5 + 0.2 * f64::from(index) / 2000.0;
        place((0..2000).find(|index| share(place(*index)) < least).unwrap())
    };
    assert!((falls_below(0.5) - 1.6176).abs() < 0.004, "{}", falls_below(0.5));
    // Of a disc's light, 10 % to 90 % is open over 0.687 of its diameter, here over 17 mm. With nodes 5 cm apart it would be over 65 mm.
    let width_m = falls_below(0.1) - falls_below(0.9);
    assert!((0.016..0.035).contains(&width_m), "{width_m}");
}

#[test]
fn the_shadow_of_a_person_ends_where_rays_past_head_and_shoulders_meet_the_floor() {
    let (building, lighting, map) = baked(&black_room(BULB), &[]);
    // The bulb is 2 m up at x = 1. The ray over a head 1 m up at x = 1.6 meets the floor at x = 1 + 0.6·2/(2 − 1) = 2.2.
    let person = UprightBody {
        middle_m: [1.6, 1.5],
        heading_rad: 0.0,
        height_m: 1.0,
        radius_m: 0.2,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    let nodes = nodes_with_people(&lighting, &map, &building.panels, &[person]);
    let shaded = LightMap { nodes, ..map.clone() };
    let share = |x: f64, y: f64| at_floor(&shaded, &building, x, y) / at_floor(&map, &building, x, y);
    assert!(share(1.95, 1.5) < 0.06, "in the shadow {}", share(1.95, 1.5));
    // Points beyond the lamp's foot and beyond the shadow's end are lit; both are far from the person's feet.
    assert!(share(0.3, 1.5) > 0.99 && share(3.2, 1.5) > 0.99);
    let crossing = |at: &dyn Fn(f64) -> [f64; 2]| {
        let half = |step: &i32| share(at(f64::from(*step) / 1000.0)[0], at(f64::from(*step) / 1000.0)[1]) > 0.5;
        f64::from((0..1000).find(half).unwrap()) / 1000.0
    };
    // The light map stores the floor's illuminance at nodes 0.05 m apart; the edge of a person's shadow is right to within half of that.
    let end = 2.0 + crossing(&|share| [2.0 + share, 1.5]);
    assert!((end - 2.2).abs() < 0.025, "the head's shadow ends at {end}");
    // The person's shadow is as wide as that of a body that reaches 0.15 m to either side of its axis: at x = 2, the ray from the bulb that passes
    // 0.15 m beside the axis is y = 0.25/√(1 − 0.25²) aside.
    let side = crossing(&|share| [2.0, 1.5 + share]);
    assert!((side - 0.2582).abs() < 0.025, "the shoulder's shadow ends {side} aside");
}

#[test]
fn the_point_straight_below_a_lamp_is_shaded_only_by_who_stands_there() {
    // The bulb hangs 2 m up at (1, 1.5), where the floor's light map has a node.
    let (building, lighting, map) = baked(&black_room(BULB), &[]);
    let share = |x: f64, y: f64| {
        let (middle_m, velocity_m_per_s) = ([x, y], [0.0; 2]);
        let person =
            UprightBody { middle_m, heading_rad: 0.0, height_m: 1.7, radius_m: 0.2, stride: 0.0, velocity_m_per_s };
        let nodes = nodes_with_people(&lighting, &map, &building.panels, &[person]);
        at_floor(&LightMap { nodes, ..map.clone() }, &building, 1.0, 1.5) / at_floor(&map, &building, 1.0, 1.5)
    };
    for (x, y) in [(3.5, 0.4), (3.5, 2.6), (2.9, 1.5), (0.3, 2.8)] {
        assert!(share(x, y) > 0.99, "a person at ({x}, {y}) leaves {}", share(x, y));
    }
    assert!(share(1.0, 1.5) < 0.1, "who stands there leaves {}", share(1.0, 1.5));
}

#[test]
fn half_a_panel_behind_a_board_gives_half_its_light_below_the_edge() {
    // A long board hangs under one half of the lamp, a panel, and the point whose illuminance is tested is straight below the board's edge.
    let panel = Source {
        shape: Shape::Rectangle {
            centre: Point3::new(0.0, 0.0, 2.0),
            half_u: vector![0.3, 0.0, 0.0],
            half_v: vector![0.0, -0.3, 0.0],
        },
        lumens: 1000.0,
        photons: Photons { visible: 1.0, infrared: 0.0 },
    };
    let scene = black_room("");
    let board = UprightBox {
        middle_m: [-5.0, 0.0],
        heading_rad: 0.0,
        size_m: [10.0, 20.0],
        between_m: [1.0, 1.001],
        material: Material::matt(0.5),
    };
    let building = Building::furnished(&scene, &DrawnPlace::draw(&scene, 0), vec![board]);
    let mut lighting = Lighting::direct(&scene, &building);
    lighting.sources = vec![panel];
    let shadowed = lighting.direct_at(Point3::origin(), Vector3::z(), 8).lux;
    let open = lighting.sources[0].illuminance(Point3::origin(), Vector3::z());
    close(shadowed, 0.5 * open, 0.01);
}

#[test]
fn photons_of_a_lux_are_those_of_published_conversions() {
    // One lux of light of 555 nm is 4.091e15 photons per second and square metre, that is 6.793e-3 µmol.
    let micromoles = |spectrum: Spectrum| Photons::of(spectrum).visible * 4.0908e15 / 6.02214e17;
    // Thimijan and Heins (HortScience 18, 1983) give, in lux per µmol/(m²·s): 54 for sunlight, 74 for cool white tubes, 50 for incandescent
    // lamps.
    close(micromoles(Spectrum::Daylight), 1.0 / 54.0, 0.05);
    close(micromoles(Spectrum::Tube), 1.0 / 74.0, 0.08);
    close(micromoles(Spectrum::Incandescent), 1.0 / 50.0, 0.05);
    // White light-emitting diodes give a number of photons per lux between those of tubes and sunlight, and hardly any light in the infrared.
    let led = Photons::of(Spectrum::Led);
    assert!((1.0 / 80.0..1.0 / 55.0).contains(&micromoles(Spectrum::Led)) && led.infrared < 0.01);
    assert!(Photons::of(Spectrum::Incandescent).infrared > 1.0);
}
