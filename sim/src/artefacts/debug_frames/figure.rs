//! The debug figure of one image: at the left what was seen, at the right where that puts the robot, and a description in words above and below.

use image::{Rgb, RgbImage};
use localizer::PoseBox;

use crate::{
    loading::SceneFile,
    run::{ImageRecord, RunRecord},
    scene::{Event, Scene},
};

use super::{
    Seen, camera_view,
    canvas::{Canvas, Panel},
    legend::{Entry, draw_legend},
    map_view::{MapView, learnt_by},
    palette, range_view,
    tones::Tones,
};

const MARGIN_PX: f64 = 20.0;
const HEADER_PX: f64 = 84.0;
const FOOTER_PX: f64 = 70.0;
const IMAGE_HEIGHT_PX: f64 = 720.0;
const MAPS_WIDTH_PX: f64 = 560.0;
/// Length of the wedges of headings on both maps.
const WEDGE_PX: f64 = 90.0;
const TITLE_PX: f32 = 24.0;
const TEXT_PX: f32 = 18.0;

/// Draws the figure of one image.
pub(super) fn draw(file: &SceneFile, record: &RunRecord, image: &ImageRecord, seen: &Seen) -> RgbImage {
    let aspect = match seen {
        Seen::Image { pixels, .. } => f64::from(pixels.width()) / f64::from(pixels.height().max(1)),
        Seen::Codes { .. } => 4.0 / 3.0,
    };
    let view = Panel {
        left_px: MARGIN_PX,
        top_px: HEADER_PX,
        width_px: (IMAGE_HEIGHT_PX * aspect).round(),
        height_px: IMAGE_HEIGHT_PX,
    };
    let maps_left_px = view.left_px + view.width_px + MARGIN_PX;
    let map_height_px = ((IMAGE_HEIGHT_PX - MARGIN_PX) / 2.0).round();
    let map = |top_px: f64| Panel { left_px: maps_left_px, top_px, width_px: MAPS_WIDTH_PX, height_px: map_height_px };
    let (room, near) = (map(HEADER_PX), map(HEADER_PX + map_height_px + MARGIN_PX));
    let width_px = maps_left_px + MAPS_WIDTH_PX + MARGIN_PX;
    let height_px = HEADER_PX + IMAGE_HEIGHT_PX + FOOTER_PX;
    let mut canvas = Canvas::new(width_px as u32, height_px as u32, palette::PAPER);

    header(&mut canvas, file, record, image, seen);
    match seen {
        Seen::Image { pixels, .. } => camera_view::draw(&mut canvas, view, &file.scene, record, image, pixels),
        Seen::Codes { camera } => range_view::draw(&mut canvas, view, &file.scene, camera, record, image),
    }
    let close_up = MapView::close_up(near, image.truth.pose, shown_m(image));
    maps(&mut canvas, &MapView::rooms(room, &file.scene), &close_up, &file.scene, record, image);
    for panel in [view, room, near] {
        frame(&mut canvas, panel);
    }
    legend(&mut canvas, height_px - FOOTER_PX + 13.0, &file.scene, image);
    canvas.image
}

/// Half the side of the close map view: twice the reach of the estimate's nearest box, which then extends over half of the view. A view smaller than
/// a centimetre or larger than a metre would show nothing of use.
fn shown_m(image: &ImageRecord) -> f64 {
    let truth_m = [image.truth.pose.x_m, image.truth.pose.y_m];
    let reach_m = |branch: &PoseBox| {
        let sides = branch.components();
        let reach = |axis: usize| (sides[axis].hi() - truth_m[axis]).max(truth_m[axis] - sides[axis].lo());
        reach(0).max(reach(1))
    };
    (2.0 * image.posterior.branches.iter().map(reach_m).fold(f64::INFINITY, f64::min)).clamp(0.01, 1.0)
}

fn maps(canvas: &mut Canvas, room: &MapView, near: &MapView, scene: &Scene, record: &RunRecord, image: &ImageRecord) {
    let truth = image.truth.pose;
    for view in [room, near] {
        view.draw_floor(canvas, scene, record.drawn.place.tiles.as_ref());
        view.draw_things(canvas, scene);
        view.draw_grid(canvas, scene);
        view.draw_errands(canvas, record, image.truth.time_s);
        view.draw_markers(canvas, scene, Some(&record.drawn.place.markers));
        view.draw_landmarks(canvas, scene, learnt_by(record, image.measured_s));
        view.draw_trail(canvas, record, image.truth.time_s);
    }
    room.draw_robot(canvas, scene, truth);
    room.draw_boxes(canvas, &image.posterior, truth, WEDGE_PX);
    room.draw_truth(canvas, truth, 46.0);
    near.draw_boxes(canvas, &image.posterior, truth, WEDGE_PX);
    near.draw_truth(canvas, truth, 110.0);
    room.draw_scale(canvas);
    near.draw_scale(canvas);
}

fn header(canvas: &mut Canvas, file: &SceneFile, record: &RunRecord, image: &ImageRecord, seen: &Seen) {
    let (kind, circumstances) = match seen {
        Seen::Image { pixels, exposure_s } => {
            let tones = Tones::of(pixels.as_raw().iter().map(|level| u16::from(*level)));
            let light = format!(
                "{}, exposed {} ms, grey {} to {} shown black to white",
                light_in_words(&file.scene, image.measured_s),
                milliseconds(*exposure_s),
                tones.black,
                tones.white,
            );
            ("image", light)
        }
        Seen::Codes { .. } => {
            let known = format!("{} landmarks known, boxes as the range camera measured them", image.landmarks.len());
            ("reading", known)
        }
    };
    let title = format!("{}   seed {}   {kind} {}   {:.2} s", file.name, record.seed, image.number, image.measured_s);
    canvas.text([MARGIN_PX, 12.0], TITLE_PX, palette::INK, &title);
    canvas.text([MARGIN_PX, 48.0], TEXT_PX, palette::FAINT_INK, &circumstances);
    let (outcome, colour) = outcome(image);
    let right_px = f64::from(canvas.image.width()) - MARGIN_PX;
    let left_of = |size: f32, text: &str| right_px - Canvas::text_width_px(size, text);
    canvas.text([left_of(TITLE_PX, &outcome), 12.0], TITLE_PX, colour, &outcome);
    let widths = widths(image);
    canvas.text([left_of(TEXT_PX, &widths), 48.0], TEXT_PX, palette::FAINT_INK, &widths);
}

/// An exposure time in milliseconds: of daylight, which is exposed for some hundredths, with three decimals.
fn milliseconds(exposure_s: f64) -> String {
    let exposure_ms = exposure_s * 1e3;
    if exposure_ms < 1.0 { format!("{exposure_ms:.3}") } else { format!("{exposure_ms:.1}") }
}

/// Says in words whether the localizer's union of boxes, just after it used the image, holds the robot's true pose, and in which colour to write it.
fn outcome(image: &ImageRecord) -> (String, Rgb<u8>) {
    let made = match (image.constrained, image.emptied) {
        (_, true) => "contradiction, ",
        (false, false) => "no cue, ",
        (true, false) => "",
    };
    if image.posterior.contains(image.truth.pose) {
        (format!("{made}truth inside"), palette::TRUTH)
    } else {
        (format!("{made}TRUTH OUTSIDE"), palette::MISS)
    }
}

fn widths(image: &ImageRecord) -> String {
    let hull = image.posterior.hull();
    if hull.is_empty() {
        return "no pose left".to_owned();
    }
    let branches = image.posterior.branches.len();
    let plural = if branches == 1 { "" } else { "es" };
    format!(
        "{branches} branch{plural}, {:.1} mm × {:.1} mm × {:.2}° wide",
        hull.width(0) * 1e3,
        hull.width(1) * 1e3,
        hull.width(2).to_degrees(),
    )
}

/// Light in words: the mean illuminance with all lamps on and where it is measured, and which lamps are switched.
fn light_in_words(scene: &Scene, time_s: f64) -> String {
    let as_stated = if scene.outdoors.is_some() { "sun and sky" } else { "lamps as stated" };
    let all_on = illuminance_lux(scene, time_s).map_or(as_stated.to_owned(), |(lux, place)| {
        let with = if scene.switched_lamps().is_empty() { "" } else { " with all lamps on" };
        format!("{lux} lx at the {place}{with}")
    });
    [all_on].into_iter().chain(switched_lamps(scene, time_s)).collect::<Vec<_>>().join(", ")
}

/// What the events switched until a given time and did not switch on again: the names of lamps with the light that they give, in words.
pub(super) fn switched_lamps(scene: &Scene, time_s: f64) -> Vec<String> {
    let in_words = |name: &str| {
        let share_at = |event: &Event| match event {
            Event::Lamp { at_s, lamp, share } if lamp == name && *at_s <= time_s => Some((*at_s, *share)),
            _ => None,
        };
        let latest = scene.events.iter().filter_map(share_at).max_by(|one, other| one.0.total_cmp(&other.0))?.1;
        match latest {
            1.0 => None,
            0.0 => Some(format!("{name} off")),
            share => Some(format!("{name} at {:.0} %", 100.0 * share)),
        }
    };
    scene.switched_lamps().into_iter().filter_map(in_words).collect()
}

/// Mean illuminance at the floor at a given time, after the light events until then; or at the camera, where the scene states that instead. With the
/// place at which it is measured; `None` as long as it follows from the outputs that all lamps state, or from
/// sun and sky.
pub(super) fn illuminance_lux(scene: &Scene, time_s: f64) -> Option<(f64, &'static str)> {
    let switched = scene.events.iter().filter_map(|event| match event {
        Event::Light { at_s, illuminance_at_floor_lux } if *at_s <= time_s => Some((*at_s, *illuminance_at_floor_lux)),
        _ => None,
    });
    let latest = switched.max_by(|one, other| one.0.total_cmp(&other.0));
    match (latest, scene.light.illuminance_at_camera_lux) {
        (Some((_, lux)), _) => Some((lux, "floor")),
        (None, Some(lux)) => Some((lux, "camera")),
        (None, None) if scene.lamps_state_outputs() || scene.outdoors.is_some() => None,
        (None, None) => Some((scene.light.illuminance_at_floor_lux, "floor")),
    }
}

/// Draws the frame of a panel.
pub(super) fn frame(canvas: &mut Canvas, panel: Panel) {
    let (right_px, bottom_px) = (panel.left_px + panel.width_px, panel.top_px + panel.height_px);
    let corners =
        [[panel.left_px, panel.top_px], [right_px, panel.top_px], [right_px, bottom_px], [panel.left_px, bottom_px]];
    canvas.outline(&corners, 1.0, palette::JOINT);
}

fn legend(canvas: &mut Canvas, top_px: f64, scene: &Scene, image: &ImageRecord) {
    let n_claims = image.claims.len();
    let things = [
        (!scene.furniture.is_empty(), palette::FURNITURE, "furniture"),
        (!scene.people.is_empty(), palette::PEOPLE, "ways that people walk"),
        (scene.markers.is_some(), palette::MARKER, "ceiling markers"),
        (!scene.landmarks.is_empty(), palette::TRUTH, "landmarks (dots)"),
    ];
    let entries = [
        (palette::SEEN, format!("claimed ({n_claims})")),
        (palette::FALSE, "claimed, but false".to_owned()),
        (palette::REJECTED, format!("rejected ({})", image.rejected_px.len())),
        (palette::BOX, "boxes with wedge of headings".to_owned()),
        (palette::MISS, "boxes without the truth".to_owned()),
        (palette::TRUTH, "true pose".to_owned()),
        (palette::TRAIL, "way come".to_owned()),
        (palette::ROUTE, "route".to_owned()),
    ];
    let shown = things.into_iter().filter(|(is_there, ..)| *is_there);
    let all = entries.into_iter().chain(shown.map(|(_, colour, text)| (colour, text.to_owned())));
    let width_px = f64::from(canvas.image.width()) - 2.0 * MARGIN_PX;
    let panel = Panel { left_px: MARGIN_PX, top_px, width_px, height_px: FOOTER_PX };
    draw_legend(canvas, panel, TEXT_PX, &all.map(|(colour, text)| Entry { colour, text }).collect::<Vec<_>>());
}
