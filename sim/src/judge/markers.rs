//! Ceiling markers: where the true camera would show them, and which of them were read.

use std::collections::BTreeMap;

use localizer::{
    Claim, Pose,
    markers::{GridPlace, MarkerId, dot_in_marker_m},
    reading::Camera,
};
use nalgebra::Point3;

use crate::{
    devices::camera::{DrawnCamera, world_from_camera},
    optics::Lens,
    place::{
        drawn::{DrawnMarker, markers::DOT_RADIUS_M},
        sight::Obstacles,
    },
    run::{ImageRecord, MarkerBaselines, PaperAnswer, RunRecord},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use super::statistics::correlation;

/// A claimed dot: its place in the marker's grid, and its pixel coordinates u and v with their bound.
type SeenDot = (GridPlace, [f64; 3]);

/// Greatest distance, along u or v, at which a claimed dot is taken for a marker's dot. In any picture in which dots can be told apart they
/// are more than twice as far apart.
const SAME_DOT_PX: f64 = 4.0;

/// The ceiling camera with its true mount and lens, and the true state at the stamp of an image.
pub(super) struct Sight {
    lens: Lens,
    mount: DrawnCamera,
    truth: Truth,
    camera_from_world: nalgebra::Isometry3<f64>,
}

/// Number of times that the row in which a point is seen is worked out from the time at which it is exposed: the picture moves by much less than a
/// row from one row to the next.
const ROUNDS: usize = 5;

impl Sight {
    /// The true ceiling camera; `None` when the robot has none.
    pub(super) fn new(scene: &Scene, drawn: &Drawn, truth: &Truth) -> Option<Sight> {
        let (camera, mount) = (scene.robot.ceiling_camera.as_ref()?, drawn.devices.ceiling_camera.as_ref()?);
        let camera_from_world = world_from_camera(truth, mount).inverse();
        Some(Sight { lens: Lens::of(camera, mount), mount: *mount, truth: *truth, camera_from_world })
    }

    /// Pixel at which a point in the world is seen when its row is exposed; `None` for a point behind the camera.
    fn pixel(&self, in_world: &Point3<f64>) -> Option<[f64; 2]> {
        let seen_from = |camera_from_world: &nalgebra::Isometry3<f64>| {
            let at = camera_from_world * in_world;
            (at.z > 0.0).then(|| self.lens.pixel([at.x / at.z, at.y / at.z]))
        };
        let mut at = seen_from(&self.camera_from_world)?;
        if self.lens.row_time_s > 0.0 {
            for _ in 0..ROUNDS {
                let truth = self.truth.moved_on(self.lens.after_stamp_s(at[1]));
                at = seen_from(&world_from_camera(&truth, &self.mount).inverse())?;
            }
        }
        Some(at)
    }

    /// Whether all dots belong to the marker: each lies within `within_px` of the true dot, along u and along v, where `within_px` is
    /// computed from the dot's bound.
    fn agrees(&self, marker: &DrawnMarker, dots_px: &[SeenDot], within_px: impl Fn(f64) -> f64) -> bool {
        dots_px.iter().all(|(place, [u, v, bound_px])| {
            let dot = marker.dots.iter().find(|dot| dot.place == *place);
            let true_px = dot.and_then(|dot| self.pixel(&dot.centre_in_world));
            let within_px = within_px(*bound_px);
            true_px.is_some_and(|[true_u, true_v]| (true_u - u).abs() <= within_px && (true_v - v).abs() <= within_px)
        })
    }

    /// Whether the centre of at least one dot of the marker is in the picture.
    fn shows_some(&self, marker: &DrawnMarker) -> bool {
        let is_within = |[u, v]: [f64; 2]| {
            u >= 0.0 && v >= 0.0 && u < f64::from(self.lens.size_px[0]) && v < f64::from(self.lens.size_px[1])
        };
        marker.dots.iter().any(|dot| self.pixel(&dot.centre_in_world).is_some_and(is_within))
    }

    /// Markers of the map that are wholly in the picture and not hidden by furniture.
    fn wholly_shown(&self, scene: &Scene, drawn: &Drawn, obstacles: &Obstacles) -> Vec<MarkerId> {
        on_map(scene, drawn).filter(|marker| self.shows(marker, obstacles)).map(|marker| marker.id).collect()
    }

    /// Whether the marker's whole grid, empty places included, is in the picture, with a margin of the dots' radius and three pixels for
    /// soft edges, and no furniture hides it. People may stand in front of it.
    fn shows(&self, marker: &DrawnMarker, obstacles: &Obstacles) -> bool {
        let (sin, cos) = marker.rotation_rad.sin_cos();
        let [x_m, y_m] = marker.centre_m;
        let in_world = |[along_m, across_m]: [f64; 2]| {
            Point3::new(x_m + cos * along_m - sin * across_m, y_m + sin * along_m + cos * across_m, marker.height_m)
        };
        let eye = Point3::from(self.camera_from_world.inverse().translation.vector);
        [[0, 0], [3, 0], [0, 3], [3, 3]].into_iter().map(dot_in_marker_m).all(|corner_m| {
            let corner = in_world(corner_m);
            // The corner of the marker's grid, moved outwards by the radius of a dot.
            let rim = in_world(corner_m.map(|at_m| at_m + DOT_RADIUS_M.copysign(at_m)));
            let depth_m = (self.camera_from_world * corner).z;
            let margin_px = self.lens.focal_px[0].max(self.lens.focal_px[1]) * DOT_RADIUS_M / depth_m.max(0.01) + 3.0;
            let is_within = |at_px: [f64; 2]| {
                (0..2).all(|axis| {
                    let last_px = f64::from(self.lens.size_px[axis]) - 1.0;
                    (margin_px..=last_px - margin_px).contains(&at_px[axis])
                })
            };
            self.pixel(&corner).is_some_and(is_within) && obstacles.leave_free(eye, rim, &[])
        })
    }
}

/// Markers of the map that the true ceiling camera shows wholly, and not hidden by furniture, at a true state of the robot; none without such a camera.
pub(crate) fn wholly_in_view(scene: &Scene, drawn: &Drawn, truth: &Truth, obstacles: &Obstacles) -> Vec<MarkerId> {
    Sight::new(scene, drawn, truth).map_or_else(Vec::new, |sight| sight.wholly_shown(scene, drawn, obstacles))
}

/// Whether a marker of the map with this identity truly has each of the claimed dots within its bound of the claimed pixel.
pub(super) fn is_marker(id: MarkerId, dots_px: &[SeenDot], scene: &Scene, drawn: &Drawn, truth: &Truth) -> bool {
    let Some(sight) = Sight::new(scene, drawn, truth) else { return false };
    on_map(scene, drawn).any(|marker| marker.id == id && sight.agrees(marker, dots_px, |bound_px| bound_px))
}

/// Figures of how many markers were wholly in view, how many were read, and how many were misread; empty without markers.
///
/// `markers_misread` counts claims whose identity no marker at that place has. A claim with the right identity and with a dot outside its
/// bound is false, but not misread.
pub(super) fn metrics(scene: &Scene, record: &RunRecord) -> BTreeMap<String, f64> {
    if record.drawn.place.markers.is_empty() {
        return BTreeMap::new();
    }
    let counts = marker_counts(scene, record);
    let share = |part: usize, whole: usize| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    let [read_share, misread, by_position, by_heading] = MarkerBaselines::FIGURES;
    let mut metrics = BTreeMap::from([
        ("marker_images".to_owned(), counts.images as f64),
        ("marker_images_read_share".to_owned(), share(counts.images_read, counts.images_with_marker)),
        ("markers_in_view".to_owned(), counts.in_view as f64),
        ("markers_read_share".to_owned(), share(counts.read, counts.in_view)),
        ("markers_misread".to_owned(), counts.misread as f64),
    ]);
    if record.marker_baselines.answers.is_empty() {
        return metrics;
    }
    metrics.extend([
        (read_share.to_owned(), share(counts.paper_read, counts.images_with_marker)),
        (misread.to_owned(), counts.paper_misread as f64),
    ]);
    let correlations = confidence_correlations(&record.marker_baselines.answers);
    for (name, correlation) in [by_position, by_heading].into_iter().zip(correlations) {
        metrics.extend(correlation.map(|value| (name.to_owned(), value)));
    }
    metrics
}

/// Correlation of the confidence P(S), which the pipeline of Zhou et al. 2016 (paper 5) gives with each pose, with the pose's distance error, and
/// with the magnitude of its heading error; the paper's own tables give −0.976 and −0.995. `None` where one of the two quantities does not vary.
pub fn confidence_correlations<'a>(answers: impl IntoIterator<Item = &'a PaperAnswer>) -> [Option<f64>; 2] {
    let fixes: Vec<_> = answers.into_iter().filter_map(|answer| Some((answer.fix?, answer.truth))).collect();
    let pairs = |error: fn(Pose, Pose) -> f64| -> Vec<[f64; 2]> {
        fixes.iter().map(|(fix, truth)| [fix.confidence, error(fix.pose, *truth)]).collect()
    };
    let distance_m = |fix: Pose, truth: Pose| (fix.x_m - truth.x_m).hypot(fix.y_m - truth.y_m);
    let turn_rad = |fix: Pose, truth: Pose| (fix.heading_rad - truth.heading_rad).abs();
    [correlation(&pairs(distance_m)), correlation(&pairs(turn_rad))]
}

/// Counts of markers over a run's pictures of the ceiling.
pub fn marker_counts(scene: &Scene, record: &RunRecord) -> MarkerCounts {
    let (mut counts, obstacles) = (MarkerCounts::default(), Obstacles::new(&scene.as_built(&record.drawn.place)));
    let images = record.images.iter().filter(|image| image.camera == Some(Camera::Ceiling));
    // Where it was asked, the pipeline of Zhou et al. 2016 gave one answer for each picture, in the order of the pictures.
    let answers = record.marker_baselines.answers.iter().map(Some).chain(std::iter::repeat(None));
    for (image, paper) in images.zip(answers) {
        if let Some(sight) = Sight::new(scene, &record.drawn, &image.truth) {
            counts.add(scene, record, (image, paper), &sight, &obstacles);
        }
    }
    counts
}

/// Counts of markers that were in view and of markers that were read, over a run's pictures of the ceiling.
#[derive(Clone, Copy, Debug, Default)]
pub struct MarkerCounts {
    /// Number of pictures of the ceiling.
    pub images: usize,
    /// Number of pictures with at least one whole marker of the map in view.
    pub images_with_marker: usize,
    /// Number of pictures in which at least one of the whole markers in view was read.
    pub images_read: usize,
    /// Number of whole markers of the map in view, summed over all pictures.
    pub in_view: usize,
    /// Number of whole markers in view that were read.
    pub read: usize,
    /// Number of claims with an identity that no marker at that place has.
    pub misread: usize,
    /// Number of pictures with a whole marker in view from which the pipeline of Zhou et al. 2016 read a marker that is in view.
    pub paper_read: usize,
    /// Number of pictures from which the pipeline of Zhou et al. 2016 read a marker that is not in view.
    pub paper_misread: usize,
}

impl MarkerCounts {
    fn add(
        &mut self,
        scene: &Scene,
        record: &RunRecord,
        (image, paper): (&ImageRecord, Option<&PaperAnswer>),
        sight: &Sight,
        obstacles: &Obstacles,
    ) {
        let claimed: Vec<MarkerId> = claims(image).map(|(id, _)| id).collect();
        let shown = sight.wholly_shown(scene, &record.drawn, obstacles);
        let read = shown.iter().filter(|id| claimed.contains(id)).count();
        self.images += 1;
        self.images_with_marker += usize::from(!shown.is_empty());
        self.images_read += usize::from(read > 0);
        self.in_view += shown.len();
        self.read += read;
        let is_there = |(id, dots_px): &(MarkerId, &[SeenDot])| {
            let is_it = |marker: &DrawnMarker| marker.id == *id && sight.agrees(marker, dots_px, |_| SAME_DOT_PX);
            record.drawn.place.markers.iter().any(is_it)
        };
        self.misread += claims(image).filter(|claim| !is_there(claim)).count();
        // The pipeline of Zhou et al. 2016 names one marker, which may be one that is partly out of view.
        let nearby =
            |id: MarkerId| on_map(scene, &record.drawn).any(|marker| marker.id == id && sight.shows_some(marker));
        if let Some(fix) = paper.and_then(|answer| answer.fix) {
            self.paper_misread += usize::from(!nearby(fix.marker));
            self.paper_read += usize::from(nearby(fix.marker) && !shown.is_empty());
        }
    }
}

fn claims(image: &ImageRecord) -> impl Iterator<Item = (MarkerId, &[SeenDot])> {
    image.claims.iter().filter_map(|claim| match claim {
        Claim::Marker { marker, dots_px } => Some((*marker, dots_px.as_slice())),
        Claim::FloorJoint { .. }
        | Claim::WallLine { .. }
        | Claim::UprightLine { .. }
        | Claim::WallUpright { .. }
        | Claim::SpacePoint { .. }
        | Claim::Landmark { .. }
        | Claim::WallPoint { .. } => None,
    })
}

/// Markers on the ceiling that are also on the localizer's map.
fn on_map<'a>(scene: &'a Scene, drawn: &'a Drawn) -> impl Iterator<Item = &'a DrawnMarker> {
    let known = |marker: &&DrawnMarker| {
        scene.markers.as_ref().and_then(|markers| markers.all().get(marker.index)).is_some_and(|marker| marker.on_map)
    };
    drawn.place.markers.iter().filter(known)
}
