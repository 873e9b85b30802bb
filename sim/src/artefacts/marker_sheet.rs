//! Ceiling markers to print, one on each A4 page, at true scale.
//!
//! A marker's axes are named by the dots in three of its corners: x points from dot O to dot X, y from dot O to dot Y. A page shows the marker as the
//! camera sees it from below: x points right and y points down. When the page is held overhead, printed side down and with its x arrow along world x,
//! its y axis points along world y; seen from above, through the paper, the turn from x to y is counter-clockwise.

mod pdf;

use crate::{
    place::drawn::markers::{DOT_RADIUS_M, PITCH_M},
    scene::{Marker, Markers, Scene},
};

use pdf::{A4_MM, Page, document};

/// Distance from the middle of a marker to the edge of the square that is cut out of the page.
const HALF_WIDTH_MM: f64 = 80.0;
/// Position of the marker's middle on its page.
const MIDDLE_MM: [f64; 2] = [A4_MM[0] / 2.0, 125.0];
/// Length of the printed ruler, by which the scale of a print is checked.
const RULER_MM: f64 = 50.0;

/// A PDF with one page for each of the scene's markers that are on the localizer's map.
pub fn marker_sheet(scene: &Scene, markers: &Markers) -> Vec<u8> {
    let on_map = markers.all().iter().filter(|marker| marker.on_map);
    document(on_map.map(|marker| page(marker, markers, scene)).collect())
}

fn page(marker: &Marker, markers: &Markers, scene: &Scene) -> Page {
    let mut page = Page::new();
    let [middle_x, middle_y] = MIDDLE_MM;
    let at = |along_m: f64, across_m: f64| [middle_x + 1e3 * along_m, middle_y + 1e3 * across_m];
    for place in (0..4).flat_map(|i| (0..4).map(move |j| [i, j])).filter(|place| marker.is_printed(*place)) {
        // The page shows the marker from below: x to the right, y down.
        let [x_m, y_m] = place.map(|index: u8| (f64::from(index) - 1.5) * PITCH_M);
        page.disc(at(x_m, y_m), 1e3 * DOT_RADIUS_M);
    }
    for (name, place) in [("O", [-0.06, -0.06]), ("X", [0.06, -0.06]), ("Y", [-0.06, 0.06])] {
        let [x, y] = at(place[0], place[1]);
        page.text([x + 11.5, y + 9.0], 3.5, name);
    }
    cutting_marks(&mut page);
    let height_m = markers.height_m(marker, scene);
    let [left, top] = [middle_x - HALF_WIDTH_MM, middle_y - HALF_WIDTH_MM];
    page.text([left, top - 22.0], 8.0, &format!("Marker {}", marker.id));
    page.text(
        [left, top - 14.0],
        4.0,
        &format!(
            "{}    middle at x = {:.3} m, y = {:.3} m, {height_m:.3} m high",
            markers.coding.as_str(),
            marker.x_m,
            marker.y_m
        ),
    );
    // One printed arrow points in the direction from corner dot O to corner dot X, beyond the dots but within the marker's square, and one from O to
    // Y.
    let arrow_y = middle_y - 76.0;
    arrow(&mut page, [middle_x - 30.0, arrow_y], [middle_x + 30.0, arrow_y]);
    page.text([middle_x - 29.0, arrow_y + 4.5], 3.5, &direction(marker));
    let arrow_x = middle_x - 76.0;
    arrow(&mut page, [arrow_x, middle_y - 30.0], [arrow_x, middle_y + 30.0]);
    page.text([arrow_x + 1.5, middle_y + 34.0], 3.5, if marker.rotation_deg == 0.0 { "towards +y" } else { "O to Y" });
    let below = middle_y + HALF_WIDTH_MM;
    ruler(&mut page, [left, below + 18.0]);
    for (line, text) in [
        "Print at 100 % and measure the ruler. Discs are retro-reflective film, 20 mm across, on a matt ground.",
        "Cut at the marks. Glue the back to the ceiling: the printed side faces down, as you see it now.",
        "Turn it until the upper arrow points as it says; seen from above, Y is then to the left of O to X.",
        "A film stuck on with its printed side up is a mirror image, which cannot be read.",
    ]
    .into_iter()
    .enumerate()
    {
        page.text([left, below + 34.0 + 6.0 * line as f64], 3.5, text);
    }
    page
}

fn direction(marker: &Marker) -> String {
    if marker.rotation_deg == 0.0 {
        return "towards +x".to_owned();
    }
    format!("O to X: {} deg from +x towards +y", marker.rotation_deg)
}

fn arrow(page: &mut Page, from: [f64; 2], to: [f64; 2]) {
    const HEAD_MM: f64 = 3.0;
    page.line(from, to);
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]);
    let [dx, dy] = along.map(|side| side / length * HEAD_MM);
    for side in [-0.5, 0.5] {
        page.line(to, [to[0] - dx + side * dy, to[1] - dy - side * dx]);
    }
}

/// Draws two strokes at each corner of the marker's square, outside of it.
fn cutting_marks(page: &mut Page) {
    for (side_x, side_y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let [x, y] = [MIDDLE_MM[0] + side_x * HALF_WIDTH_MM, MIDDLE_MM[1] + side_y * HALF_WIDTH_MM];
        page.line([x + side_x * 1.0, y], [x + side_x * 9.0, y]);
        page.line([x, y + side_y * 1.0], [x, y + side_y * 9.0]);
    }
}

fn ruler(page: &mut Page, [x, y]: [f64; 2]) {
    page.line([x, y], [x + RULER_MM, y]);
    for centimetre in 0..=5 {
        let at = x + 10.0 * f64::from(centimetre);
        page.line([at, y], [at, y - 3.0]);
    }
    page.text([x + RULER_MM + 3.0, y], 3.5, "50 mm");
}
