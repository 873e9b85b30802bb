//! Where a camera's picture shows what a pinhole camera would show elsewhere, with the declared bounds of its lens.

use interval::Interval;

use crate::{
    robot::ForwardCameraModel,
    vision::distortion::{bend_over, unbent},
};

/// Tangent of the greatest angle from the optical axis, along u and along v, for which the lens model is used.
const WIDEST: f64 = 1.5;
/// Least depth, as a share of the length of a ray, of a point before the camera.
const LEAST_DEPTH: f64 = 0.1;

/// Lens of a camera: raw pixels are c + f·D(x) + e, where a pinhole camera shows c + f·x, D is the lens distortion, and e what the lens model misses.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureLens {
    focal_px: Interval,
    centre_px: [Interval; 2],
    distortion: [f64; 5],
    distortion_px: f64,
}

impl PictureLens {
    pub(super) fn new(camera: &ForwardCameraModel) -> PictureLens {
        PictureLens {
            focal_px: camera.focal_px,
            centre_px: camera.principal_point_px,
            distortion: camera.distortion,
            distortion_px: camera.distortion_px,
        }
    }

    /// Where a pinhole camera shows what the picture shows at a place with an error along u and along v, and the error there. `None` where the lens
    /// is about to fold.
    pub(super) fn straightened(&self, at_px: [f64; 2], error_px: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        let seen_px = [0, 1].map(|axis| Interval::centred(at_px[axis], error_px[axis]).inflate(self.distortion_px));
        let seen = [0, 1].map(|axis| (seen_px[axis] - self.centre_px[axis]) / self.focal_px);
        let bent = bend_over(self.distortion, unbent(self.distortion, seen)?.at);
        let straight = [0, 1].map(|axis| seen_px[axis] - self.focal_px * bent[axis]);
        Some((straight.map(Interval::mid), straight.map(Interval::radius)))
    }

    /// Part of the picture that shows what is in the directions `[right, down, ahead]`; `None` where it may be beside the camera or behind it.
    pub(super) fn shown(&self, [right, down, ahead]: [Interval; 3]) -> Option<[Interval; 2]> {
        if ahead.lo() <= LEAST_DEPTH * right.magnitude().max(down.magnitude()).max(ahead.hi()) {
            return None;
        }
        let at = [right / ahead, down / ahead];
        if at.iter().any(|part| part.magnitude() > WIDEST) {
            return None;
        }
        let bent = bend_over(self.distortion, at);
        let raw =
            |axis: usize| (self.centre_px[axis] + self.focal_px * (at[axis] + bent[axis])).inflate(self.distortion_px);
        Some([raw(0), raw(1)])
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{graph::trial::Draw, vision::distortion::bend};

    #[test]
    fn a_bent_image_point_is_straightened_to_where_a_pinhole_shows_it() {
        let mut draw = Draw::new(20_261_205);
        let distortion = [-0.12, 0.02, 0.0005, -0.0003, 0.0];
        let lens = PictureLens {
            focal_px: Interval::centred(417.0, 0.4),
            centre_px: [319.5, 239.5].map(|at| Interval::centred(at, 0.3)),
            distortion,
            distortion_px: 0.1,
        };
        for _ in 0..500 {
            let (focal_px, centre_px) = (draw.within(lens.focal_px), lens.centre_px.map(|at| draw.within(at)));
            let at = [draw.between(-0.7, 0.7), draw.between(-0.5, 0.5)];
            let bent = bend(distortion, at);
            let off = [0, 1].map(|_| draw.within(Interval::centred(0.0, 0.1)));
            let raw_px = [0, 1].map(|k| centre_px[k] + focal_px * (at[k] + bent[k]) + off[k]);
            let told_px = raw_px.map(|at| at + draw.within(Interval::centred(0.0, 0.2)));
            let (straight_px, error_px) = lens.straightened(told_px, [0.2; 2]).unwrap();
            for k in 0..2 {
                let pinhole_px = centre_px[k] + focal_px * at[k];
                assert!((straight_px[k] - pinhole_px).abs() <= error_px[k] + 1e-9, "{straight_px:?} {error_px:?}");
                assert!(error_px[k] < 0.6, "{error_px:?}");
            }
            let shown = lens.shown([at[0], at[1], 1.0].map(|one| Interval::point(3.0 * one))).unwrap();
            assert!((0..2).all(|k| shown[k].inflate(1e-9).contains(raw_px[k])), "{shown:?} {raw_px:?}");
        }
        let beside = [Interval::point(2.0), Interval::ZERO, Interval::ONE];
        assert!(lens.shown(beside).is_none());
        assert!(lens.shown([Interval::ZERO, Interval::ZERO, Interval::new(-0.1, 1.0)]).is_none());
    }
}
