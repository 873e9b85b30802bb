//! Drawings of the union of boxes for viewers: a flat cuboid for each box, and lines for its least and greatest heading.

use localizer::{Estimate, Pose, PoseBox, Status};

use super::{
    cdr::Message,
    messages::{WORLD, planar_pose},
};

/// Thickness of the cuboids that show boxes, which lie on the floor.
const HEIGHT_M: f64 = 0.01;
/// Length of the lines that show headings.
const HEADING_LINE_M: f64 = 0.3;
/// Width of the lines that show headings.
const HEADING_LINE_WIDTH_M: f64 = 0.004;
const ORIGIN: Pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };

/// A `foxglove_msgs/SceneUpdate` with one entity, which replaces the entity of the message before.
pub(super) fn scene_update(time_s: f64, estimate: &Estimate) -> Vec<u8> {
    let boxes = &estimate.pose.branches;
    let colour = colour(estimate).map(f64::from);
    let mut message = Message::new()
        .length(0)
        .length(1)
        .time(time_s)
        .text(WORLD)
        .text("boxes")
        .time(0.0)
        .bool(false)
        .length(0)
        .length(0)
        .length(boxes.len());
    for pose in boxes {
        message = message
            .with(|message| planar_pose(message, centre(pose), HEIGHT_M / 2.0))
            .f64s(&size_m(pose))
            .f64s(&colour);
    }
    // The scene update continues with empty lists of spheres and cylinders and with one list of lines.
    message = message.length(0).length(0).length(1).u8(2).with(|message| planar_pose(message, ORIGIN, 0.0));
    message = message.f64s(&[HEADING_LINE_WIDTH_M]).bool(false).with(|message| heading_lines(message, boxes));
    // The lines have one solid colour, without colours or indices of single points; the lists of triangles, texts and models are empty.
    message.f64s(&colour).length(0).length(0).length(0).length(0).length(0).finish()
}

/// A `visualization_msgs/MarkerArray` that deletes all earlier markers and draws the boxes anew.
pub(super) fn marker_array(time_s: f64, estimate: &Estimate) -> Vec<u8> {
    const CUBE: i32 = 1;
    const LINE_LIST: i32 = 5;
    const ADD: i32 = 0;
    const DELETE_ALL: i32 = 3;
    let boxes = &estimate.pose.branches;
    let colour = colour(estimate);
    let marker = |message: Message, id: usize, kind: [i32; 2], pose: Pose, size_m: [f64; 3], line_boxes: &[PoseBox]| {
        let [kind, action] = kind;
        let message = message.header(time_s, WORLD).text("boxes").i32(id as i32).i32(kind).i32(action);
        let message = message.with(|message| planar_pose(message, pose, 0.0)).f64s(&size_m);
        let message = colour.iter().fold(message, |message, &share| message.f32(share));
        let message = message.time(0.0).bool(false).with(|message| heading_lines(message, line_boxes));
        // The marker has no colours of single points, no texture, no text and no mesh.
        let message = message.length(0).text("").header(0.0, "").text("").bytes(&[]).length(0);
        message.text("").text("").text("").bytes(&[]).bool(false)
    };
    let mut message = Message::new().length(boxes.len() + 2);
    message = marker(message, 0, [CUBE, DELETE_ALL], ORIGIN, [0.0; 3], &[]);
    message = marker(message, 0, [LINE_LIST, ADD], ORIGIN, [HEADING_LINE_WIDTH_M, 0.0, 0.0], boxes);
    for (index, pose) in boxes.iter().enumerate() {
        message = marker(message, index + 1, [CUBE, ADD], centre(pose), size_m(pose), &[]);
    }
    message.finish()
}

/// A `geometry_msgs/Point[]` with two points for each line. From the middle of each pose box one line of fixed length points in the
/// direction of the box's least heading, and one in that of its greatest.
fn heading_lines(message: Message, boxes: &[PoseBox]) -> Message {
    boxes.iter().fold(message.length(4 * boxes.len()), |message, pose| {
        let [x_m, y_m, _] = pose.midpoint();
        [pose[2].lo(), pose[2].hi()].into_iter().fold(message, |message, heading_rad| {
            let (sin, cos) = heading_rad.sin_cos();
            message.f64s(&[x_m, y_m, HEIGHT_M]).f64s(&[
                x_m + HEADING_LINE_M * cos,
                y_m + HEADING_LINE_M * sin,
                HEIGHT_M,
            ])
        })
    })
}

/// Pose of the cuboid that shows a box: the middle of the box in the plane with heading 0, since the cuboid is not rotated.
fn centre(pose: &PoseBox) -> Pose {
    let [x_m, y_m, _] = pose.midpoint();
    Pose { x_m, y_m, heading_rad: 0.0 }
}

fn size_m(pose: &PoseBox) -> [f64; 3] {
    [pose[0].width(), pose[1].width(), HEIGHT_M]
}

/// Colour of the drawn boxes as red, green, blue and opacity: blue while the status is `Sound`, orange while it is `Recovering`.
fn colour(estimate: &Estimate) -> [f32; 4] {
    match estimate.status {
        Status::Sound => [0.12, 0.47, 0.71, 0.5],
        Status::Recovering => [1.0, 0.5, 0.05, 0.5],
    }
}
