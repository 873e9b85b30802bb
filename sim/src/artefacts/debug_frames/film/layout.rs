//! Where everything stands in a frame of a film.

use localizer::reading::Camera;

use super::super::canvas::Panel;

/// Width of a film.
const WIDTH_PX: f64 = 960.0;
/// Distance between panels and from the edge of the film.
pub(super) const MARGIN_PX: f64 = 12.0;
/// Height of the title above all panels.
const HEADER_PX: f64 = 42.0;
/// Height of the line above each of the panels at the left.
pub(super) const CAPTION_PX: f64 = 20.0;
/// Least height of all panels together.
const BODY_PX: f64 = 440.0;
/// Least height of the panel with figures.
const STATUS_PX: f64 = 190.0;
/// Height of a map beyond the rooms themselves: the scale bar and the margins.
const MAP_MARGIN_PX: f64 = 62.0;

/// What one of the panels at the left shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum View {
    /// What a camera sees.
    Camera(Camera),
    /// What the range camera sees.
    Range,
    /// The map close to the robot.
    CloseUp,
}

/// The panels of a film: what is seen at the left, the map of all rooms at the right and figures below it.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Width and height of the film.
    pub(super) size_px: [u32; 2],
    /// The panels at the left, each below its caption.
    pub(super) views: Vec<(View, Panel)>,
    /// The map of all rooms.
    pub(super) rooms: Panel,
    /// Figures: whether the truth is inside, how wide the boxes are, and the outcome.
    pub(super) status: Panel,
}

impl Layout {
    /// The panels for these cameras in rooms of this depth over their width. The close map is the last of the panels at the left, and fills what the
    /// others leave of their grid, so that no place is blank.
    pub(super) fn new(cameras: &[Camera], has_range: bool, depth_over_width: f64) -> Layout {
        let mut shown: Vec<View> = cameras.iter().copied().map(View::Camera).collect();
        shown.extend(has_range.then_some(View::Range));
        shown.push(View::CloseUp);
        let columns = if shown.len() <= 2 { 1 } else { 2 };
        let rows = shown.len().div_ceil(columns);
        let width_px: f64 = match (columns, rows) {
            (1, _) => 300.0,
            (_, 2) => 288.0,
            _ => 232.0,
        };
        let height_px = (0.75 * width_px).round();
        let left_px = columns as f64 * (width_px + MARGIN_PX);
        let natural_px = rows as f64 * (CAPTION_PX + height_px + MARGIN_PX) - MARGIN_PX;
        let is_full = shown.len() == columns * rows;
        // Only a close map that has a row to itself may be stretched.
        let body_px = if is_full && columns > 1 { natural_px } else { natural_px.max(BODY_PX) };
        let last = shown.len() - 1;
        let views = shown.iter().enumerate().map(|(index, view)| {
            let (column, row) = (index % columns, index / columns);
            let top_px = HEADER_PX + CAPTION_PX + row as f64 * (height_px + CAPTION_PX + MARGIN_PX);
            let spans = index == last && !is_full;
            let panel = Panel {
                left_px: MARGIN_PX + column as f64 * (width_px + MARGIN_PX),
                top_px,
                width_px: if spans { left_px - MARGIN_PX } else { width_px },
                height_px: if index == last { HEADER_PX + body_px - top_px } else { height_px },
            };
            (*view, panel)
        });
        let right_px = MARGIN_PX + left_px;
        let right_width_px = WIDTH_PX - MARGIN_PX - right_px;
        let rooms_px = (right_width_px * depth_over_width + MAP_MARGIN_PX).min(body_px - STATUS_PX - MARGIN_PX).round();
        let rooms = Panel { left_px: right_px, top_px: HEADER_PX, width_px: right_width_px, height_px: rooms_px };
        let status_top_px = HEADER_PX + rooms_px + MARGIN_PX;
        let status = Panel { top_px: status_top_px, height_px: HEADER_PX + body_px - status_top_px, ..rooms };
        let height_px = HEADER_PX + body_px + MARGIN_PX;
        Layout { size_px: [WIDTH_PX as u32, height_px as u32], views: views.collect(), rooms, status }
    }

    /// The part of a panel that an image of this shape fills without being distorted.
    pub(super) fn fitted(panel: Panel, width_over_height: f64) -> Panel {
        let width_px = panel.width_px.min(panel.height_px * width_over_height).round();
        let height_px = panel.height_px.min(panel.width_px / width_over_height).round();
        Panel {
            left_px: panel.left_px + (0.5 * (panel.width_px - width_px)).round(),
            top_px: panel.top_px + (0.5 * (panel.height_px - height_px)).round(),
            width_px,
            height_px,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The edges of a panel with its caption, if it has one: left, top, right, bottom.
    fn edges(panel: &Panel, caption_px: f64) -> [f64; 4] {
        let Panel { left_px, top_px, width_px, height_px } = *panel;
        [left_px, top_px - caption_px, left_px + width_px, top_px + height_px]
    }

    #[test]
    fn no_panel_covers_another_and_all_end_at_the_same_edges() {
        for n_cameras in 0..=3 {
            for (has_range, depth_over_width) in [(false, 0.05), (false, 0.7), (true, 0.7), (true, 8.0)] {
                let layout = Layout::new(&Camera::ALL[..n_cameras], has_range, depth_over_width);
                let mut all: Vec<[f64; 4]> = layout.views.iter().map(|(_, panel)| edges(panel, CAPTION_PX)).collect();
                all.extend([edges(&layout.rooms, 0.0), edges(&layout.status, 0.0)]);
                for (index, one) in all.iter().enumerate() {
                    for other in &all[index + 1..] {
                        let apart = (0..2).any(|axis| one[axis + 2] < other[axis] || other[axis + 2] < one[axis]);
                        assert!(apart, "{n_cameras} {has_range}: {one:?} covers {other:?}");
                    }
                }
                let farthest = |axis: usize| all.iter().map(|edges| edges[axis]).fold(0.0, f64::max);
                let [width_px, height_px] = layout.size_px.map(f64::from);
                assert_eq!([farthest(2), farthest(3)], [width_px - MARGIN_PX, height_px - MARGIN_PX]);
                // The close map and the figures both end at the lower edge.
                let bottoms =
                    [&layout.views[layout.views.len() - 1].1, &layout.status].map(|panel| edges(panel, 0.0)[3]);
                assert_eq!(bottoms, [height_px - MARGIN_PX; 2]);
                assert!(all.iter().all(|[left, top, right, bottom]| right - left > 100.0 && bottom - top > 60.0));
            }
        }
    }

    #[test]
    fn a_wide_image_is_put_into_the_middle_of_its_panel() {
        let panel = Panel { left_px: 10.0, top_px: 20.0, width_px: 300.0, height_px: 200.0 };
        let fitted = Layout::fitted(panel, 3.0);
        assert_eq!([fitted.left_px, fitted.top_px, fitted.width_px, fitted.height_px], [10.0, 70.0, 300.0, 100.0]);
    }
}
