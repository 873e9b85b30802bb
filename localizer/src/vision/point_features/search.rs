//! The search for a landmark in an image: candidates by their descriptors, then the alignment of the patch.

use interval::Interval;

/// Where a landmark is searched in an image, and how it may appear there. The truth must be in all of these: what lies outside is not looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Corners of a convex region of the image, in order around it, each `[u, v]`.
    pub corners_px: Vec<[f64; 2]>,
    /// Size in this image as a multiple of that in the landmark's own: the inverse ratio of the distances, times [`Landmark::enlargement`] where this
    /// camera has another focal length.
    ///
    /// [`Landmark::enlargement`]: super::Landmark::enlargement
    pub scale: Interval,
    /// Turn of this image against the landmark's own, positive from u towards v.
    pub turn_rad: Interval,
}

impl Search {
    /// A search in a box `[u, v]` of pixels.
    pub fn in_box(position_px: [Interval; 2], scale: Interval, turn_rad: Interval) -> Search {
        let [u, v] = position_px;
        let corners_px = if u.is_empty() || v.is_empty() {
            Vec::new()
        } else {
            vec![[u.lo(), v.lo()], [u.hi(), v.lo()], [u.hi(), v.hi()], [u.lo(), v.hi()]]
        };
        Search { corners_px, scale, turn_rad }
    }
}

/// The region of a search, prepared for many questions.
pub(super) struct Region<'a> {
    corners_px: &'a [[f64; 2]],
    /// Least and greatest coordinates `[u, v]`.
    pub(super) hull_px: [[f64; 2]; 2],
    /// 1 if the corners go around from u towards v, −1 if they go the other way.
    sense: f64,
}

impl Region<'_> {
    /// The region of a search; `None` if it has no corners or an infinite one.
    pub(super) fn of(search: &Search) -> Option<Region<'_>> {
        let corners_px = &search.corners_px;
        let parts = |axis: usize| corners_px.iter().map(move |corner| corner[axis]);
        let low = [0, 1].map(|axis| parts(axis).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|axis| parts(axis).fold(f64::NEG_INFINITY, f64::max));
        let is_finite = low.iter().chain(&high).all(|at| at.is_finite());
        let mut region = Region { corners_px, hull_px: [low, high], sense: 1.0 };
        let area = region.edges().map(|[a, b]| cross(a, b)).sum::<f64>();
        region.sense = if area < 0.0 { -1.0 } else { 1.0 };
        (is_finite && !corners_px.is_empty()).then_some(region)
    }

    fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let next = self.corners_px.iter().cycle().skip(1);
        self.corners_px.iter().zip(next).map(|(a, b)| [*a, *b])
    }

    /// Whether a box around a point, with these half widths, may have a point in common with the region. Near a corner of the region it may say so
    /// of a box that has none.
    pub(super) fn may_meet(&self, at_px: [f64; 2], half_px: [f64; 2]) -> bool {
        let [low, high] = self.hull_px;
        let is_near = |axis: usize| (low[axis] - half_px[axis]..=high[axis] + half_px[axis]).contains(&at_px[axis]);
        let is_beyond = |[a, b]: [[f64; 2]; 2]| {
            let along = [b[0] - a[0], b[1] - a[1]];
            let off = self.sense * cross(along, [at_px[0] - a[0], at_px[1] - a[1]]);
            off < -(along[1].abs() * half_px[0] + along[0].abs() * half_px[1])
        };
        is_near(0) && is_near(1) && !self.edges().any(is_beyond)
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// A landmark that was found in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Claimed position `[u, v]` of the image of the landmark's surface point.
    pub position_px: [f64; 2],
    /// Claimed greatest error of the position, along u and along v: see [`claim`](super::claim).
    pub half_width_px: [f64; 2],
    /// Zero-mean normalised cross-correlation of the image and the fitted patch, 0 to 1.
    pub zncc: f64,
    /// Change of the position in this image per pixel of the landmark's own, row-major: how the surroundings of the landmark are turned, enlarged and
    /// sheared.
    pub image_from_patch: [[f64; 2]; 2],
}

/// Why a landmark was not found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// No keypoint in the region has a descriptor like the landmark's.
    NothingAlike,
    /// Where a descriptor is alike, the patch could not be aligned: it did not settle, or left the region or the image.
    NotAligned,
    /// The aligned patch does not look like the image.
    Unlike {
        /// Zero-mean normalised cross-correlation of the image and the fitted patch.
        zncc: f64,
    },
    /// The position is known too vaguely.
    Vague {
        /// The greater half width, in pixels.
        half_width_px: f64,
    },
    /// Two places in the region look like the landmark.
    Ambiguous {
        /// Both positions, the better one first.
        positions_px: [[f64; 2]; 2],
    },
}
