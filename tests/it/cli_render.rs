use std::fs;

use crate::command::{blind_scene, folder, outcome, wherein};

#[test]
fn one_picture_and_its_tone_mapped_twin_per_camera() {
    let folder = folder("render_one");
    let keys = "[robot.forward_camera]\nwidth_px = 96\nheight_px = 64\n[robot.ceiling_camera]\nwidth_px = 80\n\
                height_px = 64\nprincipal_point_px = [39.5, 31.5]\nfocal_px = [60.0, 60.0]\n";
    fs::write(folder.join("room.toml"), blind_scene(1.0, keys)).unwrap();
    let (code, printed, error) =
        outcome(&mut wherein(&folder, &["render", "room.toml", "--at", "1.2,1,-30", "--lux", "80", "--out", "out"]));
    assert_eq!(code, 0, "{error}");
    for (camera, size) in [("forward", (96, 64)), ("ceiling", (80, 64))] {
        for name in [format!("{camera}.png"), format!("{camera}_tone_mapped.png")] {
            assert!(printed.contains(&name), "{printed}");
            assert_eq!(image::image_dimensions(folder.join("out/room").join(name)).unwrap(), size);
        }
    }
    assert!(!folder.join("out/room/floor.png").exists(), "the robot has no floor camera");
}

#[test]
fn a_room_gives_the_same_bytes_in_any_process_on_any_number_of_threads() {
    let folder = folder("render_threads");
    let keys = "[[furniture]]\nname = \"box\"\nx_m = 1.0\ny_m = 1.7\nsize_m = [0.4, 0.3]\nheight_m = 0.6\n\
                [[person]]\nwaypoints_m = [[1.4, 1.6], [1.8, 1.0]]\n\
                [[building.dot]]\nx_m = 0.9\ny_m = 0.9\n[robot.forward_camera]\nwidth_px = 320\nheight_px = 240\n\
                lens.distortion = [-0.1, 0.02, 0.0, 0.0, 0.0]\nlens.defocus_px = 1.5\nsensor.bits = 10\n[robot.ceiling_camera]\n";
    fs::write(folder.join("room.toml"), blind_scene(1.0, keys)).unwrap();
    let pictures = |threads: &str, out: &str| {
        let mut command = wherein(&folder, &["render", "room.toml", "--lux", "5", "--seed", "3", "--out", out]);
        let (code, _, error) = outcome(command.env("LP_NUM_THREADS", threads));
        assert_eq!(code, 0, "{error}");
        ["forward.png", "ceiling.png"].map(|name| fs::read(folder.join(out).join("room").join(name)).unwrap())
    };
    let first = pictures("1", "one");
    for threads in ["1", "2", "4"] {
        assert!(pictures(threads, &format!("again_{threads}")) == first, "{threads} threads");
    }
}

#[test]
fn an_adapter_is_chosen_by_flag() {
    let folder = folder("render_adapter");
    fs::write(folder.join("room.toml"), blind_scene(1.0, "[robot.forward_camera]\n")).unwrap();
    let (code, _, error) = outcome(&mut wherein(&folder, &["render", "room.toml", "--adapter", "of no maker"]));
    assert_eq!(code, 2);
    assert!(error.contains("\"of no maker\" (--adapter or WHEREIN_ADAPTER)") && error.contains("found: "), "{error}");
    // The graphics adapter named by the command-line flag `--adapter` takes precedence over the one named by the environment variable
    // `WHEREIN_ADAPTER`.
    let (code, found, _) = outcome(&mut wherein(&folder, &["adapter"]));
    assert_eq!(code, 0);
    let name = found.split(' ').next().unwrap();
    let mut command = wherein(&folder, &["--adapter", name, "adapter"]);
    let (code, again, error) = outcome(command.env("WHEREIN_ADAPTER", "of no maker"));
    assert_eq!((code, again), (0, found.clone()), "{error}");
}

#[test]
fn a_contact_sheet_is_one_picture() {
    let folder = folder("render_sheet");
    let keys = "[robot.forward_camera]\nwidth_px = 96\nheight_px = 64\n";
    fs::write(folder.join("room.toml"), blind_scene(1.0, keys)).unwrap();
    let (code, printed, error) =
        outcome(&mut wherein(&folder, &["render", "room.toml", "--contact-sheet", "lux=1,100", "--out", "out"]));
    assert_eq!(code, 0, "{error}");
    assert_eq!(printed.trim(), "out/room/contact_sheet.png");
    let (width, height) = image::image_dimensions(folder.join("out/room/contact_sheet.png")).unwrap();
    assert!(width > 800 && height > 250, "{width} × {height}");
}

#[test]
fn twelve_bits_are_written_as_they_are() {
    let folder = folder("render_deep");
    let keys = "[robot.forward_camera]\nwidth_px = 96\nheight_px = 64\nsensor.preset = \"machine_vision\"\n";
    fs::write(folder.join("room.toml"), blind_scene(1.0, keys)).unwrap();
    let (code, _, error) = outcome(&mut wherein(&folder, &["render", "room.toml", "--out", "out"]));
    assert_eq!(code, 0, "{error}");
    let image::DynamicImage::ImageLuma16(levels) = image::open(folder.join("out/room/forward.png")).unwrap() else {
        panic!("not of 16 bits");
    };
    let greatest = levels.as_raw().iter().max().copied().unwrap();
    assert!((1024..4096).contains(&greatest), "{greatest}");
    assert!(levels.as_raw().iter().any(|level| level % 16 != 0));
}

#[test]
fn what_cannot_be_rendered_is_refused_with_its_reason() {
    let folder = folder("render_refused");
    fs::write(folder.join("blind.toml"), blind_scene(1.0, "")).unwrap();
    fs::write(folder.join("seeing.toml"), blind_scene(1.0, "[robot.forward_camera]\n")).unwrap();
    let furnished =
        "[robot.forward_camera]\n[[furniture]]\nname = \"box\"\nx_m = 1.5\ny_m = 1.6\nsize_m = [0.4, 0.4]\n";
    fs::write(folder.join("furnished.toml"), blind_scene(1.0, furnished)).unwrap();
    let cases: [(&[&str], &str); 12] = [
        (&["render", "blind.toml"], "its robot has no camera"),
        (&["render", "seeing.toml", "--camera", "ceiling"], "its robot has no ceiling camera"),
        (&["render", "seeing.toml", "--camera", "side"], "expected one of floor, forward, ceiling"),
        (&["render", "seeing.toml", "--at", "1,1"], "such as 1.5,2,90"),
        (&["render", "seeing.toml", "--at", "1,1,inf"], "such as 1.5,2,90"),
        (
            &["render", "seeing.toml", "--at", "9,1,0"],
            "failed to render seeing.toml --at 9,1: outside the room, expected x from 0.25 to 2.75 and y from 0.25 to 1.75",
        ),
        // Two poses that must be refused: at one the robot's origin is in a wall, at the other only the edge of the robot's body.
        (&["render", "seeing.toml", "--at", "1,2,90"], "outside the room"),
        (&["render", "seeing.toml", "--at", "1,0.1,90"], "as the robot's body reaches 0.25 m about its origin"),
        (
            &["render", "furnished.toml", "--at", "1.6,1.5,0"],
            "failed to render furnished.toml --at 1.6,1.5: in or by furniture[0] (box), expected 0.25 m of distance",
        ),
        (&["render", "furnished.toml", "--at", "1.5,1.2,0"], "in or by furniture[0] (box)"),
        (&["render", "seeing.toml", "--lux", "-1"], "from 0 to 100000 lx"),
        (&["render", "seeing.toml", "--contact-sheet", "0.1,1"], "such as lux=0.1,1,10,100,1000"),
    ];
    for (arguments, reason) in cases {
        let (code, _, error) = outcome(&mut wherein(&folder, arguments));
        assert_eq!(code, 2, "{arguments:?}");
        assert!(error.contains(reason), "{arguments:?}: {error}");
    }
}
