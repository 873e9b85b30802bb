//! One frame of a film.

use image::{RgbImage, imageops};
use localizer::{Pose, PoseBox, reading::Camera};

use crate::{
    judge::Verdict,
    loading::SceneFile,
    place::building::GroundPlan,
    run::{ImageRecord, RunRecord},
};

use super::{
    super::{
        camera_view,
        canvas::{Canvas, Panel},
        figure::{frame, illuminance_lux, switched_lamps},
        legend::{Entry, draw_legend},
        map_view::{MapView, learnt_by},
        palette, range_view,
    },
    layout::{CAPTION_PX, Layout, MARGIN_PX, View},
    reel::{Picture, Pictures, Reel},
    status,
    widths::{Widths, middle_at},
};

const TITLE_PX: f32 = 21.0;
const TEXT_PX: f32 = 14.0;
/// Width of strokes over a camera's image, over that in a debug figure, whose images are about three times as wide.
const STROKE: f64 = 0.45;
/// Length of the arrows of the true pose on both maps.
const ARROWS_PX: [f64; 2] = [24.0, 56.0];
/// Length of the wedges of headings on both maps: a little more than the arrows.
const WEDGES_PX: [f64; 2] = [34.0, 72.0];
/// Height of the legend below the figures.
const LEGEND_PX: f64 = 40.0;
/// Height of the gaps above and below the chart.
const GAPS_PX: f64 = 26.0;
/// Least height of the chart of widths; with less room there is none.
const CHART_PX: f64 = 40.0;

/// What all frames of a film have in common.
pub(super) struct Drawing<'a> {
    file: &'a SceneFile,
    record: &'a RunRecord,
    verdict: &'a Verdict,
    layout: Layout,
    rooms: MapView,
    /// What is the same in all frames, with the map before anything was driven.
    ground: Canvas,
    widths: Widths,
}

/// What a frame shows: a step of the run, if there was any, and what the cameras had given by then.
pub(super) struct Moment<'a> {
    pub(super) step: Option<usize>,
    pub(super) pictures: &'a Pictures,
    /// Whether the frame shows the outcome of the run.
    pub(super) is_end: bool,
}

impl<'a> Drawing<'a> {
    pub(super) fn new(file: &'a SceneFile, record: &'a RunRecord, verdict: &'a Verdict, reel: &Reel) -> Drawing<'a> {
        let [[x0_m, y0_m], [x1_m, y1_m]] = GroundPlan::of(&file.scene).extents_m();
        let has_range = record.images.iter().any(|image| is_of_range(image, file));
        let layout = Layout::new(&file.scene.robot.cameras(), has_range, (y1_m - y0_m) / (x1_m - x0_m));
        let rooms = MapView::rooms(layout.rooms, &file.scene);
        let mut ground = Canvas::new(layout.size_px[0], layout.size_px[1], palette::PAPER);
        rooms.draw_floor(&mut ground, &file.scene, record.drawn.place.tiles.as_ref());
        rooms.draw_things(&mut ground, &file.scene);
        rooms.draw_markers(&mut ground, &file.scene, Some(&record.drawn.place.markers));
        rooms.draw_scale(&mut ground);
        let speed = match reel.speed() {
            1 => "as fast as the run".to_owned(),
            times => format!("{times} times as fast as the run"),
        };
        let right_px = f64::from(layout.size_px[0]) - MARGIN_PX;
        let speed_px = right_px - Canvas::text_width_px(TEXT_PX, &speed);
        ground.text([speed_px, 16.0], TEXT_PX, palette::FAINT_INK, &speed);
        let title = format!("{}   seed {}   {}", file.name, record.seed, record.subject);
        // Half of the title's line is for the time of the run and the speed of the film.
        let title = status::cut(&title, TITLE_PX, 0.5 * right_px);
        ground.text([MARGIN_PX, 10.0], TITLE_PX, palette::INK, &title);
        Drawing { file, record, verdict, layout, rooms, ground, widths: Widths::of(record) }
    }

    /// Width and height of the film.
    pub(super) fn size_px(&self) -> [u32; 2] {
        self.layout.size_px
    }

    /// Draws a frame.
    pub(super) fn draw(&self, moment: &Moment<'_>) -> RgbImage {
        let mut canvas = self.ground.clone();
        let truth = moment.step.and_then(|step| self.record.truths.get(step)).copied();
        let time_s = truth.map_or(0.0, |truth| truth.time_s);
        let shown = format!("{time_s:.1} s");
        canvas.text([0.62 * f64::from(self.layout.size_px[0]), 10.0], TITLE_PX, palette::INK, &shown);
        for (view, panel) in &self.layout.views {
            let aside = match view {
                View::Camera(camera) => self.camera(&mut canvas, *panel, *camera, moment.pictures),
                View::Range => self.range(&mut canvas, *panel, time_s),
                View::CloseUp => {
                    self.close_up(&mut canvas, *panel, moment.step, time_s);
                    String::new()
                }
            };
            let name = match view {
                View::Camera(camera) => format!("{} camera", camera.as_str()),
                View::Range => "range camera".to_owned(),
                View::CloseUp => "close to the robot".to_owned(),
            };
            let top_px = panel.top_px - CAPTION_PX + 1.0;
            canvas.text([panel.left_px, top_px], TEXT_PX, palette::INK, &name);
            let aside_px = panel.left_px + panel.width_px - Canvas::text_width_px(TEXT_PX, &aside);
            canvas.text([aside_px, top_px], TEXT_PX, palette::FAINT_INK, &aside);
            frame(&mut canvas, *panel);
        }
        let pose = truth.map(|truth| truth.pose);
        self.rooms.draw_landmarks(&mut canvas, &self.file.scene, learnt_by(self.record, time_s));
        self.rooms.draw_errands(&mut canvas, self.record, time_s);
        self.rooms.draw_trail(&mut canvas, self.record, time_s);
        if let (Some(step), Some(pose)) = (moment.step, pose) {
            self.rooms.draw_robot(&mut canvas, &self.file.scene, pose);
            self.answer(&mut canvas, &self.rooms, WEDGES_PX[0], step, pose);
            self.rooms.draw_truth(&mut canvas, pose, ARROWS_PX[0]);
        }
        frame(&mut canvas, self.layout.rooms);
        self.status(&mut canvas, moment, time_s);
        canvas.image
    }

    /// Draws what a camera saw last with what was claimed of it, and returns the light and the exposure in words.
    fn camera(&self, canvas: &mut Canvas, panel: Panel, camera: Camera, pictures: &Pictures) -> String {
        let place = Camera::ALL.iter().position(|name| *name == camera);
        let Some(picture) = place.and_then(|index| pictures[index].as_deref()) else {
            nothing_yet(canvas, panel, "no image yet");
            return String::new();
        };
        let Picture { shown, measured_s, .. } = picture;
        let fitted = Layout::fitted(panel, f64::from(shown.width()) / f64::from(shown.height()));
        let (width_px, height_px) = (fitted.width_px as u32, fitted.height_px as u32);
        camera_view::paint(
            canvas,
            fitted,
            &imageops::resize(shown, width_px, height_px, imageops::FilterType::Triangle),
        );
        let pens = camera_view::Pens { scale: fitted.width_px / f64::from(picture.width_px), stroke: STROKE };
        let of_it = |image: &&ImageRecord| image.camera == Some(camera) && image.measured_s == *measured_s;
        for image in self.record.images.iter().filter(of_it) {
            camera_view::draw_seen(canvas, fitted, &pens, &self.file.scene, self.record, image);
        }
        let lux = illuminance_lux(&self.file.scene, *measured_s).map(|(lux, _)| format!("{lux} lx"));
        let lamps = switched_lamps(&self.file.scene, *measured_s);
        let exposure = format!("{:.1} ms", 1e3 * picture.exposure_s);
        lux.into_iter().chain(lamps).chain([exposure]).collect::<Vec<_>>().join(", ")
    }

    /// Draws what the range camera measured last, and returns in words how many landmarks are known.
    fn range(&self, canvas: &mut Canvas, panel: Panel, time_s: f64) -> String {
        let latest =
            self.record.images.iter().rfind(|image| is_of_range(image, self.file) && image.arrived_s <= time_s);
        let (Some(image), Some(camera)) = (latest, &self.file.scene.robot.range_camera) else {
            nothing_yet(canvas, panel, "no reading yet");
            return String::new();
        };
        canvas.fill(&corners(panel), palette::ROOM, 1.0);
        range_view::draw(canvas, panel, &self.file.scene, camera, self.record, image);
        format!("{} known", learnt_by(self.record, time_s).len())
    }

    /// Draws the map close to the robot.
    fn close_up(&self, canvas: &mut Canvas, panel: Panel, step: Option<usize>, time_s: f64) {
        let Some((step, truth)) = step.and_then(|step| Some((step, self.record.truths.get(step)?.pose))) else {
            nothing_yet(canvas, panel, "no answer");
            return;
        };
        // What is stated fills between a quarter and a half of the view, whose scale changes only now and then.
        let shown_m = 2_f64.powf((2.0 * self.reach_m(step, truth)).log2().ceil()).clamp(1.0 / 64.0, 1.0);
        let view = MapView::close_up(panel, truth, shown_m);
        canvas.fill(&corners(panel), palette::ROOM, 1.0);
        view.draw_floor(canvas, &self.file.scene, self.record.drawn.place.tiles.as_ref());
        view.draw_things(canvas, &self.file.scene);
        view.draw_landmarks(canvas, &self.file.scene, learnt_by(self.record, time_s));
        view.draw_errands(canvas, self.record, time_s);
        view.draw_trail(canvas, self.record, time_s);
        self.answer(canvas, &view, WEDGES_PX[1], step, truth);
        view.draw_truth(canvas, truth, ARROWS_PX[1]);
        view.draw_scale(canvas);
    }

    /// Distance from the truth that what the localizer states reaches along x or y; of several boxes that of the nearest.
    fn reach_m(&self, step: usize, truth: Pose) -> f64 {
        let off_m = |x_m: f64, y_m: f64| (x_m - truth.x_m).abs().max((y_m - truth.y_m).abs());
        let reach_m = if let Some(stated) = self.record.stated.get(step).and_then(Option::as_ref) {
            let ellipse = stated.spread.as_ref().map(|spread| spread.ellipse_95_m()).unwrap_or_default();
            let places = ellipse.iter().chain([&[0.0, 0.0]]);
            places.map(|[x_m, y_m]| off_m(stated.mean.x_m + x_m, stated.mean.y_m + y_m)).fold(0.0, f64::max)
        } else {
            let of_box = |branch: &PoseBox| {
                let [x, y, _] = branch.components();
                off_m(x.lo(), y.lo()).max(off_m(x.hi(), y.hi()))
            };
            let union = self.record.estimates.get(step).map(|estimate| &estimate.pose);
            union.into_iter().flat_map(|union| &union.branches).map(of_box).fold(f64::INFINITY, f64::min)
        };
        // Where no pose is left, the floor around the robot is shown.
        if reach_m.is_finite() { reach_m } else { 0.25 }
    }

    /// Draws what the localizer stated at a step: boxes, the ellipse of a distribution, or a point.
    fn answer(&self, canvas: &mut Canvas, view: &MapView, wedge_px: f64, step: usize, truth: Pose) {
        let colour = match status::holds_truth(self.record, step) {
            Some(false) => palette::MISS,
            _ => palette::BOX,
        };
        match self.record.stated.get(step) {
            Some(Some(stated)) => {
                let ellipse = stated.spread.as_ref().map(|spread| spread.ellipse_95_m()).unwrap_or_default();
                view.draw_region(canvas, stated.mean, &ellipse, colour);
            }
            Some(None) if self.record.has_boxes => {
                let estimate = self.record.estimates.get(step);
                estimate.iter().for_each(|estimate| view.draw_boxes(canvas, &estimate.pose, truth, wedge_px));
            }
            _ => middle_at(self.record, step).iter().for_each(|mean| view.draw_region(canvas, *mean, &[], colour)),
        }
    }

    /// Writes the figures, with the chart and the legend below them.
    fn status(&self, canvas: &mut Canvas, moment: &Moment<'_>, time_s: f64) {
        let panel = self.layout.status;
        let lines = match moment.is_end {
            true => {
                let room_px = panel.height_px - LEGEND_PX - GAPS_PX - CHART_PX;
                status::of_outcome(self.record, self.verdict, [panel.width_px, room_px])
            }
            false => status::of_step(self.record, self.verdict, moment.step),
        };
        let mut top_px = panel.top_px;
        for line in lines {
            canvas.text([panel.left_px, top_px], line.height_px, line.colour, &line.text);
            top_px += line.pitch_px();
        }
        let bottom_px = panel.top_px + panel.height_px;
        let legend = Panel { top_px: bottom_px - LEGEND_PX, height_px: LEGEND_PX, ..panel };
        draw_legend(canvas, legend, TEXT_PX, &self.legend());
        let chart = Panel { top_px: top_px + 12.0, height_px: legend.top_px - top_px - GAPS_PX, ..panel };
        if chart.height_px >= CHART_PX {
            self.widths.draw(canvas, chart, time_s);
        }
    }

    fn legend(&self) -> Vec<Entry> {
        let record = self.record;
        let stated = match (record.stated.iter().any(Option::is_some), record.has_boxes) {
            (true, _) => "95 % region, its width",
            (false, true) => "box, its width",
            (false, false) => "answer",
        };
        let entries = [
            (true, palette::TRUTH, "true pose, error of the middle"),
            (true, palette::BOX, stated),
            (record.images.iter().any(|image| !image.claims.is_empty()), palette::SEEN, "claimed"),
            (self.file.scene.markers.is_some(), palette::MARKER, "marker"),
            (record.errands.is_some(), palette::ROUTE, "planned way"),
            (record.errands.is_none() && self.file.scene.route.is_some(), palette::ROUTE, "route"),
            (true, palette::TRAIL, "driven"),
        ];
        let shown = entries.into_iter().filter(|(is_shown, ..)| *is_shown);
        shown.map(|(_, colour, text)| Entry { colour, text: text.to_owned() }).collect()
    }
}

fn is_of_range(image: &ImageRecord, file: &SceneFile) -> bool {
    image.camera.is_none() && file.scene.robot.range_camera.is_some()
}

/// Fills a panel that has nothing to show.
fn nothing_yet(canvas: &mut Canvas, panel: Panel, text: &str) {
    canvas.fill(&corners(panel), palette::FURNITURE, 1.0);
    let left_px = panel.left_px + 0.5 * (panel.width_px - Canvas::text_width_px(TEXT_PX, text));
    canvas.text([left_px, panel.top_px + 0.5 * panel.height_px - 8.0], TEXT_PX, palette::INK, text);
}

fn corners(panel: Panel) -> [[f64; 2]; 4] {
    let (right_px, bottom_px) = (panel.left_px + panel.width_px, panel.top_px + panel.height_px);
    [[panel.left_px, panel.top_px], [right_px, panel.top_px], [right_px, bottom_px], [panel.left_px, bottom_px]]
}
