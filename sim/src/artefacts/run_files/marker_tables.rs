//! The file `marker_tables.md`: Tables 1 to 3 in the form in which Zhou et al. 2016 (paper 5) print them, for that paper's own pipeline, with this
//! localizer's boxes beside it.

use std::fmt::Write;

use crate::{
    devices::camera::world_from_camera,
    judge::{confidence_correlations, marker_counts, midpoint},
    run::{ImageRecord, PaperAnswer, RunRecord},
    scene::Scene,
};

const CENTIMETRES: f64 = 100.0;
const MILLIMETRES: f64 = 1000.0;

/// The tables of a run in which the robot is put at stations under ceiling markers; `None` for any other run.
///
/// Positions are the camera's, in world coordinates, and deviations are real minus output, as in Zhou et al. 2016 (paper 5). The cells of a picture
/// without a marker stay empty. The elapsed time in the paper's Table 1 differs from run to run and stands in `timing.json`.
pub(super) fn marker_tables(scene: &Scene, record: &RunRecord) -> Option<String> {
    let answers = &record.marker_baselines.answers;
    if scene.stations.is_empty() || answers.is_empty() {
        return None;
    }
    let images = record.images.iter().filter(|image| image.method == "ceiling_markers");
    let rows: Vec<(&ImageRecord, &PaperAnswer)> = images.zip(answers).collect();
    Some([identification(scene, record, &rows), angles(&rows), positions(record, &rows)].join("\n"))
}

/// Table 1 of Zhou et al. 2016 (identification of markers), for the paper's pipeline and for this localizer.
fn identification(scene: &Scene, record: &RunRecord, rows: &[(&ImageRecord, &PaperAnswer)]) -> String {
    let counts = marker_counts(scene, record);
    let mut text = "**Identification** (Table 1): pictures with a whole marker in view\n\n\
                    | pipeline | pictures | correct | accuracy (%) | misread |\n|---|---:|---:|---:|---:|\n"
        .to_owned();
    for (name, correct, misread) in
        [("paper", counts.paper_read, counts.paper_misread), ("ours", counts.images_read, counts.misread)]
    {
        let with_marker = counts.images_with_marker;
        let accuracy = 100.0 * correct as f64 / with_marker.max(1) as f64;
        // Writing to a `String` cannot fail.
        let _ = writeln!(text, "| {name} | {with_marker} | {correct} | {accuracy:.2} | {misread} |");
    }
    let [position, heading] = confidence_correlations(rows.iter().map(|(_, answer)| *answer));
    let shown = |value: Option<f64>| value.map_or("undefined".to_owned(), |value| format!("{value:+.3}"));
    let _ = writeln!(
        text,
        "\nCorrelation of P(S) with the size of the paper's error: position {}, heading {}.",
        shown(position),
        shown(heading)
    );
    text
}

/// Table 2 (angles).
fn angles(rows: &[(&ImageRecord, &PaperAnswer)]) -> String {
    let mut text = "**Angle** (Table 2), degrees\n\n\
                    | number | real | output | deviation | P(S) | our deviation | our width |\n\
                    |---:|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    for (index, (image, answer)) in rows.iter().enumerate() {
        let real_rad = answer.truth.heading_rad;
        let paper = answer.fix.map_or("| | ".to_owned(), |fix| {
            let [output, deviation] = [fix.pose.heading_rad, real_rad - fix.pose.heading_rad].map(f64::to_degrees);
            format!("{output:.2} | {deviation:.2} | {:.2}", fix.confidence)
        });
        let ours = box_of(image).map_or("| ".to_owned(), |(middle, width)| {
            let deviation = (image.truth.pose.heading_rad - middle[2]).to_degrees();
            format!("{deviation:.3} | {:.3}", width[2].to_degrees())
        });
        let _ = writeln!(text, "| {} | {:.2} | {paper} | {ours} |", index + 1, real_rad.to_degrees());
    }
    text
}

/// Table 3 of Zhou et al. 2016 (positions). The columns named "our" are the deviations and the full widths of this localizer's box for the robot.
fn positions(record: &RunRecord, rows: &[(&ImageRecord, &PaperAnswer)]) -> String {
    let mut text = "**Position** (Table 3), of the camera, in centimetres; our deviations and widths in millimetres\n\n\
                    | number | X | Y | Z | output X | Y | Z | deviation X | Y | Z | P(S) | our deviation X | Y | our width X | Y |\n\
                    |---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    let Some(mount) = &record.drawn.devices.ceiling_camera else { return text };
    for (index, (image, answer)) in rows.iter().enumerate() {
        let real_m: [f64; 3] = world_from_camera(&image.truth, mount).translation.vector.into();
        let paper = answer.fix.map_or("| ".repeat(6), |fix| {
            let deviation: Vec<f64> = real_m.iter().zip(fix.camera_m).map(|(real, output)| real - output).collect();
            let cells = |values: &[f64]| in_cells(values, CENTIMETRES, 2);
            format!("{} | {} | {:.2}", cells(&fix.camera_m), cells(&deviation), fix.confidence)
        });
        let ours = box_of(image).map_or("| ".repeat(3), |(middle, width)| {
            let truth = image.truth.pose;
            let deviation = [truth.x_m - middle[0], truth.y_m - middle[1]];
            format!("{} | {}", in_cells(&deviation, MILLIMETRES, 2), in_cells(&width[..2], MILLIMETRES, 2))
        });
        let _ = writeln!(text, "| {} | {} | {paper} | {ours} |", index + 1, in_cells(&real_m, CENTIMETRES, 2));
    }
    text
}

/// Middle and full width (m, m, rad) of the localizer's box just after a picture; `None` when the picture gave no fix.
fn box_of(image: &ImageRecord) -> Option<([f64; 3], [f64; 3])> {
    let hull = image.posterior.hull();
    let middle = midpoint(&hull);
    let is_fix = image.constrained && !hull.is_empty();
    is_fix.then(|| ([middle.x_m, middle.y_m, middle.heading_rad], [0, 1, 2].map(|axis| hull[axis].width())))
}

fn in_cells(values: &[f64], scale: f64, digits: usize) -> String {
    values.iter().map(|value| format!("{:.digits$}", value * scale)).collect::<Vec<_>>().join(" | ")
}
