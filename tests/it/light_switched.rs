//! Lamps that are switched one by one: their direct light against the inverse-square law, reflected light against an integrating sphere and against
//! the light of each lamp by itself, and pictures against those of a scene whose lamp gives nothing.

use localizer::Reading;
use sim::{
    optics::Lens,
    place::{
        building::{Building, Part, UprightBody},
        drawn::DrawnPlace,
        light::{LightMap, SwitchableLight, bake},
    },
    render::{Shows, View},
    scene::Scene,
    world::Drawn,
};

use crate::{
    light_of_lamps::{black_room, close},
    render_room::{level, looking_ahead, looking_down, quiet_view},
    render_studio::{judged, renderer},
};

/// A bulb of 100 cd, 2 m above the floor.
fn bulb(name: &str, x_m: f64) -> String {
    format!(
        "[[lamp]]\nkind = \"point\"\nname = \"{name}\"\nx_m = {x_m:?}\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\n\
         spectrum = \"monochrome\"\n"
    )
}

fn switched(lamp: &str, at_s: f64, share: f64) -> String {
    format!("[[event]]\nkind = \"lamp\"\nat_s = {at_s:?}\nlamp = \"{lamp}\"\nshare = {share:?}\n")
}

fn switchable(scene: &Scene) -> (Building, SwitchableLight) {
    let building = Building::new(scene, &DrawnPlace::draw(scene, 0));
    let light = SwitchableLight::new(scene, &building);
    (building, light)
}

#[test]
fn a_bulb_that_is_switched_takes_its_own_light_from_the_floor_and_no_other() {
    let scene = black_room(&[bulb("left", 1.0), bulb("right", 3.0), switched("left", 1.0, 0.0)].concat());
    let (building, light) = switchable(&scene);
    let floor = building.panels.iter().position(|panel| panel.part == Part::Floor).unwrap();
    let below_left_lux = |share: f64| light.under(&[share]).1.at(floor, 0.25, 0.5, 0);
    // The left bulb is 2 m above: 100/4 lx. The right one is 2 m aside, too: d² = 8, cos = 2/√8.
    let (own_lux, other_lux) = (100.0 / 4.0, 100.0 / 8.0 * (2.0 / 8_f64.sqrt()));
    close(below_left_lux(1.0), own_lux + other_lux, 0.01);
    close(below_left_lux(0.5), 0.5 * own_lux + other_lux, 0.01);
    close(below_left_lux(0.0), other_lux, 0.01);
    // The room is symmetric, so that half of the floor's light is that of each bulb.
    close(light.floor_share(&[0.0]), 0.5, 1e-6);
}

#[test]
fn light_of_the_lamps_that_stay_on_bounces_as_in_an_integrating_sphere() {
    // All light of the lamps that are on is absorbed in the end: in a cube whose faces have the albedo ρ, the mean illuminance is Φ/(A·(1 − ρ)).
    let panel = |name: &str, x_m: f64, lumens: f64| {
        format!(
            "[[lamp]]\nkind = \"panel\"\nname = \"{name}\"\nx_m = {x_m:?}\ny_m = 1.3\nlumens = {lumens:?}\n\
             spectrum = \"monochrome\"\n"
        )
    };
    let text = format!(
        "[room]\nwidth_m = 2.6\ndepth_m = 2.6\n[building]\nwall_albedo = 0.4\nceiling_albedo = 0.4\n\
         skirting_height_m = 0.0\n[start]\nx_m = 1.3\ny_m = 1.3\n[[route.waypoint]]\nx_m = 1.3\ny_m = 1.3\n{}{}{}",
        panel("small", 0.7, 400.0),
        panel("large", 1.9, 600.0),
        switched("large", 1.0, 0.25)
    );
    let (building, light) = switchable(&Scene::parse(&text, "cube.toml").unwrap());
    for (share, lumens) in [(1.0, 1000.0), (0.25, 550.0), (0.0, 400.0)] {
        let (_, map) = light.under(&[share]);
        let of_face = |index: usize| {
            let places = (0..400).map(|k| (f64::from(k % 20) / 20.0 + 0.025, f64::from(k / 20) / 20.0 + 0.025));
            places.map(|(s, t)| map.at(index, s, t, 0)).sum::<f64>() / 400.0
        };
        let faces = building.panels.iter().enumerate().filter(|(_, panel)| panel.part != Part::Thing);
        let mean_lux = faces.map(|(index, _)| of_face(index)).sum::<f64>() / 6.0;
        close(mean_lux, lumens / (6.0 * 2.6 * 2.6 * (1.0 - 0.4)), 0.02);
    }
}

/// Two furnished rooms with an open door and three lamps, two of which have names. The lamps whose index is not among `given` give nothing.
fn two_rooms(given: &[usize], events: &str) -> Scene {
    let lamps = [
        "kind = \"panel\"\nname = \"here\"\nx_m = 1.6\ny_m = 1.5\nspectrum = \"tube\"",
        "kind = \"point\"\nname = \"next door\"\nx_m = 5.6\ny_m = 1.5\nheight_m = 1.9\nspectrum = \"incandescent\"",
        "kind = \"window\"\nx_m = 2.0\ny_m = 0.0\nheading_deg = 90",
    ];
    let lumens = |index: usize| if given.contains(&index) { 700 + 400 * index } else { 0 };
    let lamps = lamps.iter().enumerate();
    let lamps: String = lamps.map(|(index, lamp)| format!("[[lamp]]\n{lamp}\nlumens = {}\n", lumens(index))).collect();
    let text = format!(
        "duration_s = 4.0\n[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[[building.room]]\nx_m = 4.1\ny_m = 0.0\n\
         width_m = 3.0\n\
         depth_m = 3.0\n[[building.door]]\nfrom_m = [4.0, 1.0]\nto_m = [4.0, 2.0]\nopen = true\n[[furniture]]\n\
         name = \"table\"\nx_m = 2.6\ny_m = 2.3\nsize_m = [0.8, 0.5]\nheight_m = 0.7\n[start]\nx_m = 0.7\ny_m = 0.8\n\
         [[route.waypoint]]\nx_m = 0.8\ny_m = 0.8\n{lamps}{events}"
    );
    Scene::parse(&text, "rooms.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

#[test]
fn the_light_of_single_lamps_adds_up_to_that_of_all() {
    let events = [switched("next door", 1.0, 0.5), switched("here", 2.0, 0.0)].concat();
    let (building, light) = switchable(&two_rooms(&[0, 1, 2], &events));
    let alone = |given: &[usize]| bake(&two_rooms(given, ""), &building).1;
    let by_itself = [0, 1, 2].map(|lamp| alone(&[lamp]));
    // Shares stand in the order of the events: of the lamp next door, and of that here.
    for (shares, weights) in
        [([1.0, 1.0], [1.0, 1.0, 1.0]), ([0.5, 0.0], [0.0, 0.5, 1.0]), ([0.0, 0.3], [0.3, 0.0, 1.0])]
    {
        let (_, map) = light.under(&shares);
        let greatest = map.nodes.iter().flatten().fold(0.0_f32, |greatest, lux| greatest.max(*lux));
        for (index, node) in map.nodes.iter().enumerate() {
            for (band, found) in node.iter().enumerate() {
                let sum: f64 = (0..3).map(|lamp| weights[lamp] * f64::from(by_itself[lamp].nodes[index][band])).sum();
                assert!((f64::from(*found) - sum).abs() < 1e-4 * f64::from(greatest), "{found} for {sum}");
            }
        }
        let mean = |map: &LightMap| map.mean_at_floor.lux;
        let sum: f64 = (0..3).map(|lamp| weights[lamp] * mean(&by_itself[lamp])).sum();
        close(mean(&map), sum, 1e-4);
    }
    let all = alone(&[0, 1, 2]);
    close(light.under(&[]).1.mean_at_floor.lux, all.mean_at_floor.lux, 1e-4);
}

#[test]
fn pictures_with_a_lamp_off_are_those_of_a_scene_in_which_it_gives_nothing() {
    let person = UprightBody {
        middle_m: [2.6, 1.2],
        heading_rad: 0.4,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    let mut renderer = renderer();
    let mut pictures = |scene: &Scene, states: &[&[f64]]| -> Vec<Vec<image::GrayImage>> {
        let mut world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
        let mut of_state = |shares: &&[f64]| {
            world.switch_lamps(shares);
            world.place_bodies(&[person]);
            let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
            let ahead = quiet_view(Lens::ideal([160, 120], 100.0), vec![looking_ahead()], 1.0);
            let mut down = quiet_view(Lens::ideal([80, 60], 100.0), vec![looking_down(2.2, 1.0, 1.0)], 1.0);
            down.shows = Shows::Floor;
            let views = [ahead, down].map(|view| View { illuminance_at_floor_lux, ..view });
            renderer.draw(&world, &views).unwrap()
        };
        states.iter().map(&mut of_state).collect()
    };
    let events = [switched("here", 1.0, 0.0), switched("next door", 2.0, 0.0)].concat();
    let found = pictures(&two_rooms(&[0, 1, 2], &events), &[&[1.0, 1.0], &[0.0, 1.0], &[1.0, 0.0], &[1.0, 1.0]]);
    assert_eq!(found[0], found[3], "the lamps are on again");
    for (state, given) in [(0, [0, 1, 2].as_slice()), (1, &[1, 2]), (2, &[0, 2])] {
        let expected = pictures(&two_rooms(given, ""), &[&[]]).remove(0);
        for (found, expected) in found[state].iter().zip(&expected) {
            // Sums over groups are rounded in another order than sums over lamps.
            let off = found.pixels().zip(expected.pixels()).filter(|(one, other)| one.0[0].abs_diff(other.0[0]) > 1);
            assert_eq!(off.count(), 0, "state {state}");
            let is_lit = expected.pixels().any(|pixel| pixel.0[0] > 20);
            assert!(is_lit, "state {state}");
        }
    }
    assert!(found[0] != found[1] && found[1] != found[2]);
    assert!(level(&found[1][1], 40, 30) < level(&found[0][1], 40, 30) - 5.0);
}

#[test]
fn images_of_a_run_go_dark_when_the_only_lamp_goes_off() {
    let text = [
        "duration_s = 2.4\n[room]\nwidth_m = 3.0\ndepth_m = 3.0\n[floor.tiles]\n[start]\nx_m = 1.0\n\
         y_m = 1.0\n[[route.waypoint]]\nx_m = 1.5\ny_m = 1.0\n\
         [robot.floor_camera]\n[[lamp]]\nkind = \"panel\"\nname = \"only\"\nx_m = 1.5\ny_m = 1.5\n",
        &switched("only", 0.5, 0.0),
        &switched("only", 1.5, 1.0),
    ]
    .concat();
    // One robot's only camera looks at the floor, another one looks ahead, too.
    for more in ["", "[robot.forward_camera]\n"] {
        let scene =
            Scene::parse(&format!("{text}{more}"), "dark.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        let (record, _) = judged(&scene, 1);
        let mut seen = [0; 2];
        for image in &record.images {
            let Some(Reading::Camera { image, measured_s, .. }) = &image.reading else { panic!() };
            let mean = image.pixels().map(|pixel| f64::from(pixel.0[0])).sum::<f64>()
                / f64::from(image.width() * image.height());
            let is_off = (0.5..1.5).contains(measured_s);
            assert_eq!(mean < 30.0, is_off, "grey {mean} at {measured_s} s");
            seen[usize::from(is_off)] += 1;
        }
        assert!(seen.iter().all(|count| *count >= 3), "{seen:?}");
    }
}
