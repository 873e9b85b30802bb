//! What the image points of one image relate: the pose, the constants of the camera, the lean of the body, and the landmarks.

use std::{cmp::Ordering, sync::Arc};

use interval::Interval;

use crate::{
    PoseBox,
    bounds::{self, Assumption},
    graph::{Disc, Domain, Relations, Row, Stray, Variable},
    map::{SpacePoint, ViewSight},
    reading::LandmarkId,
    robot::cayley_radius,
};

use super::{
    camera::{DEVICE, SeenPoint},
    ray::{HEAVE, N_PARAMETERS, Optics, POINT, Parameters, Picture, TURN, variable},
};

/// A picture of the teaching drive with the place in it of a landmark.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) sight: ViewSight,
    /// Index of the drive's camera, and the box of the pose from which the picture was taken.
    pub(super) camera: usize,
    pub(super) pose: PoseBox,
}

/// Image point of a landmark, with what is known of the landmark.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) landmark: LandmarkId,
    pub(super) point: SpacePoint,
    /// Column and row at which a pinhole camera would see it.
    pub(super) at_px: [f64; 2],
    /// Greatest error of the image point along u and along v.
    pub(super) error_px: [f64; 2],
    /// A picture of the drive that taught the landmark, if that is used.
    pub(super) view: Option<View>,
    /// The thing that the landmark is on, if the map tells.
    pub(super) thing: Option<u32>,
}

impl Sight {
    /// Order in which the landmarks whose direction from the robot is known best come first. The error of a direction is that of the slopes, and what
    /// the inverse depth makes for each metre that the robot is away from the anchor.
    pub(super) fn better_known_first(&self, other: &Sight) -> Ordering {
        let error = |sight: &Sight| sight.point.value.iter().map(|one| one.width()).sum::<f64>();
        error(self).total_cmp(&error(other)).then(self.landmark.cmp(&other.landmark))
    }

    /// The sight of an image point that a point camera has told.
    pub(super) fn told(seen: &SeenPoint, point: SpacePoint, optics: &Optics) -> Sight {
        Sight {
            landmark: seen.landmark,
            point,
            at_px: seen.at_px,
            error_px: [optics.camera.error_px; 2],
            view: None,
            thing: None,
        }
    }
}

/// The places of at most so many of some sightings: those of the landmarks that are known best, no two of them nearer in the picture than a distance.
/// What makes one sighting false, such as a crossing of edges at different depths, makes its neighbours false, too, and they would all count for the
/// number of false ones that is declared.
pub(super) fn best_known_apart(sights: &[Sight], most: usize, least_px: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..sights.len()).collect();
    order.sort_by(|&a, &b| sights[a].better_known_first(&sights[b]));
    let apart_px = |a: usize, b: usize| {
        let [du, dv] = [0, 1].map(|axis| sights[a].at_px[axis] - sights[b].at_px[axis]);
        du.hypot(dv)
    };
    let mut used: Vec<usize> = Vec::new();
    for at in order {
        if used.len() < most && used.iter().all(|&other| apart_px(at, other) >= least_px) {
            used.push(at);
        }
    }
    used
}

/// Image points of landmarks, with what is known of each landmark.
#[derive(Clone)]
pub(super) struct Points {
    pub(super) optics: Arc<Optics>,
    pub(super) seen: Vec<Sight>,
}

impl Points {
    fn rows_of(&self, sight: &Sight, frame: usize, domain: &Domain) -> Vec<Row> {
        let own = (sight.at_px, sight.error_px);
        let mut rows = rows_of(&self.optics, Picture::Own(frame), sight, own, domain);
        if let Some(view) = &sight.view
            && let Some(optics) = self.optics.taught.get(view.camera)
        {
            let picture = Picture::Taught(view.sight.picture, view.camera);
            rows.extend(rows_of(optics, picture, sight, (view.sight.at_px, view.sight.error_px), domain));
        }
        rows
    }
}

/// The rows of a landmark that a picture shows at a place with a greatest error.
fn rows_of(
    optics: &Optics,
    picture: Picture,
    Sight { landmark, point, .. }: &Sight,
    (at_px, error_px): ([f64; 2], [f64; 2]),
    domain: &Domain,
) -> Vec<Row> {
    // What no quantity of the graph stands for keeps its interval.
    let own = optics.parameters(&PoseBox::from([Interval::ZERO; 3]), point.value);
    let named: [Option<Variable>; N_PARAMETERS] = std::array::from_fn(|k| variable(k, picture, *landmark));
    let over_box: Parameters = std::array::from_fn(|k| named[k].map_or(own[k], |one| domain.value(one)));
    if over_box.iter().any(|value| value.is_empty() || !value.is_bounded()) {
        return Vec::new();
    }
    let at_middle: Parameters =
        std::array::from_fn(|k| Interval::point(named[k].map_or(own[k].mid(), |one| domain.reference(one))));
    // From the middle the other parameters are moved first, with the landmark's in the middle, and then the landmark's: the product of both
    // deviations, which is most of what a row loses, counts once in this way, and twice with slopes over the whole box.
    let landmark_at_middle: Parameters =
        std::array::from_fn(|k| if POINT.contains(&k) { at_middle[k] } else { over_box[k] });
    // The landmark's parameters are the first.
    const { assert!(POINT[0] == 0 && POINT[1] == 1 && POINT[2] == 2) };
    let (over_box, depth) = optics.equations::<{ POINT.len() }>(&over_box, &point.anchor, at_px);
    let (others, _) = optics.equations::<N_PARAMETERS>(&landmark_at_middle, &point.anchor, at_px);
    let (at_middle, _) = optics.equations::<0>(&at_middle, &point.anchor, at_px);
    let slope =
        |equation: usize, k: usize| over_box[equation].slopes.get(k).copied().unwrap_or(others[equation].slopes[k]);
    // Rows count in about the image's units of a focal length, so that their coefficients are of the size of those of other rows. The factor is a
    // power of two, by which numbers are multiplied without a rounding error.
    let unit = Interval::point((-optics.camera.focal_px.mid().log2().round()).exp2());
    let row = |k: usize| {
        let error = Interval::centred(0.0, error_px[k]) * depth.value * unit;
        let slopes: Parameters = std::array::from_fn(|parameter| slope(k, parameter) * unit);
        let terms: Vec<(Variable, Interval)> = (0..N_PARAMETERS).filter_map(|k| Some((named[k]?, slopes[k]))).collect();
        let [heave, turn] = [HEAVE, TURN].map(|k| slopes[k] * own[k]);
        // Parameters of which no quantity of the graph stands for, besides those two, and which are known to an interval.
        let unnamed = (0..N_PARAMETERS).filter(|&k| named[k].is_none() && k != HEAVE && k != TURN);
        let rest = unnamed.fold(Interval::ZERO, |sum, k| sum + slopes[k] * (own[k] - Interval::point(own[k].mid())));
        Row::new(domain, &terms, error - at_middle[k].value * unit - heave - turn - rest)
            .with_part(bounds::POINT_CAMERA_POINTS, error.radius())
            .with_part(bounds::BODY_HEAVE, heave.radius())
            .with_part(bounds::BODY_TILT, turn.radius())
            .by_device(DEVICE)
    };
    vec![row(0), row(1)]
}

impl Relations for Points {
    fn quantities(&self, frame: usize, pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let mut quantities = Vec::new();
        let of = |optics: &Optics, picture: Picture, pose: &PoseBox, Sight { landmark, point, .. }: &Sight| {
            let parameters = optics.parameters(pose, point.value).into_iter().enumerate();
            let named = parameters.filter_map(|(k, value)| Some((variable(k, picture, *landmark)?, value)));
            named.filter(|(one, _)| !matches!(one, Variable::Pose(..))).collect::<Vec<_>>()
        };
        for sight in &self.seen {
            quantities.extend(of(&self.optics, Picture::Own(frame), pose, sight));
            if let Some(view) = &sight.view
                && let Some(optics) = self.optics.taught.get(view.camera)
            {
                quantities.extend(of(optics, Picture::Taught(view.sight.picture, view.camera), &view.pose, sight));
            }
        }
        quantities.sort_by_key(|&(variable, _)| variable);
        quantities.dedup_by_key(|&mut (variable, _)| variable);
        quantities
    }

    fn discs(&self, frame: usize) -> Vec<Disc> {
        let body = [0, 1].map(|axis| Variable::BodyTilt(frame, axis));
        let mount = [0, 1].map(|axis| Variable::Constant(crate::graph::Constant::PointTilt(axis)));
        vec![(body, cayley_radius(self.optics.body.tilt_rad)), (mount, cayley_radius(self.optics.camera.tilt_rad))]
    }

    fn stamp_error_s(&self) -> f64 {
        self.optics.camera.stamp_error_s
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::POINT_CAMERA_STAMP
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        [bounds::POINT_CAMERA_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres)).to_vec()
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        self.seen.iter().flat_map(|one| self.rows_of(one, frame, domain)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Anchor;

    #[test]
    fn of_sightings_near_each_other_the_best_known_one_is_taken() {
        let anchor = Anchor { from_m: [0.0; 3], axis: 0, is_positive: true };
        let sights = [(0.0, 0.3), (10.0, 0.1), (19.0, 0.2), (30.0, 0.4)].map(|(u_px, half)| Sight {
            landmark: LandmarkId(u_px as u32),
            point: SpacePoint { anchor, value: [Interval::centred(0.0, half); 3] },
            at_px: [u_px, 5.0],
            error_px: [0.5; 2],
            view: None,
            thing: None,
        });
        // Those at 0 and 19 px are within 14 px of that at 10 px, which is known better.
        assert_eq!(best_known_apart(&sights, 9, 14.0), [1, 3]);
        assert_eq!(best_known_apart(&sights, 9, 9.0), [1, 2, 0, 3]);
        assert_eq!(best_known_apart(&sights, 2, 9.0), [1, 2]);
    }
}
