//! The places of the quantities in the filter's state, and what is known of each at the start.

use localizer::{PoseBox, RobotModel};
use nalgebra::{DMatrix, DVector};

use crate::{
    scene::FilterNoise,
    subject::cues::{Cues, FloorPlan, Mounted, SIGMAS_OF_BOUND},
};

/// Places of the quantities in the state; `None` for those of devices that the robot does not have.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Bias of the gyroscope in rad/s, and the share by which its scale is off.
    pub(crate) gyro: Option<[usize; 2]>,
    /// Shares by which the flow sensor's counts per metre are off for good and on the present surface, and the angle by which it is turned.
    pub(crate) flow: Option<[usize; 3]>,
    /// Shares by which the radii of the left and the right wheel and the track are off.
    pub(crate) wheels: [usize; 3],
    /// Shares of their way by which the left and the right wheel slip at present, and share of the robot's way by which it slips to its left.
    pub(crate) slip: [usize; 3],
    /// The quantities that change as the robot goes, each with its standard deviation.
    pub(crate) changing: Vec<(usize, f64)>,
    /// Errors of the mounts that last: forward, left, turn.
    mounts: [Option<usize>; Mounted::ALL.len()],
    /// Share by which all distances of the range camera are too long.
    pub(crate) range_scale: Option<usize>,
    /// Shift along x and y, and turn, of all walls against the map.
    pub(crate) floor_plan: Option<usize>,
    /// Pose at the beginning of the present window of motion, where several sensors measure the motion.
    pub(crate) past: Option<usize>,
    /// Standard deviations at the start of all quantities, those of the pose left 0.
    sigma: Vec<f64>,
    /// Means at the start of all quantities, those of the pose left 0.
    mean: Vec<f64>,
}

/// Place of x, y and heading in the state.
pub(crate) const POSE: usize = 0;

/// Least standard deviation of a coordinate of the start pose. A start that is stated exactly would make the covariance singular.
const LEAST_SIGMA: f64 = 1e-5;

impl Layout {
    pub(crate) fn new(robot: &RobotModel, cues: &Cues, tuning: &FilterNoise) -> Layout {
        let (mut sigma, mut mean) = (vec![0.0; 3], vec![0.0; 3]);
        let mut add = |quantities: &[(f64, f64)]| {
            let at = sigma.len();
            for (middle, bound) in quantities {
                mean.push(*middle);
                sigma.push(SIGMAS_OF_BOUND * bound);
            }
            at
        };
        let gyro = robot.gyro.map(|gyro| {
            let (bias, scale) = (gyro.bias_rad_per_s, gyro.scale);
            let share = 0.5 * scale.width() / scale.mid();
            let at = add(&[(bias.mid(), tuning.motion * 0.5 * bias.width()), (0.0, tuning.motion * share)]);
            [at, at + 1]
        });
        let flow = robot.flow.map(|flow| {
            let per_count = flow.metres_per_count;
            let calibration = 0.5 * per_count.width() / per_count.mid();
            let yaw_rad = 0.5 * flow.yaw_rad.width();
            let at = add(&[calibration, flow.scale_change, yaw_rad].map(|bound| (0.0, tuning.motion * bound)));
            [at, at + 1, at + 2]
        });
        let wheels = &robot.wheels;
        let share = |of: interval::Interval| (0.0, tuning.motion * 0.5 * of.width() / of.mid());
        let at = add(&[share(wheels.radius_m[0]), share(wheels.radius_m[1]), share(wheels.track_m)]);
        let wheels_at = [at, at + 1, at + 2];
        let ratios = [wheels.slip_ratio, wheels.slip_ratio, wheels.side_slip_ratio];
        let at = add(&ratios.map(|ratio| (0.0, tuning.motion * ratio)));
        let slip = [at, at + 1, at + 2];
        let mounts = Mounted::ALL.map(|mounted| {
            let mount = cues.mount(mounted)?;
            Some(add(&mount.sigma.map(|sigma| (0.0, sigma / SIGMAS_OF_BOUND))))
        });
        let range_scale = cues.range_scale_sigma().map(|sigma| add(&[(0.0, sigma / SIGMAS_OF_BOUND)]));
        let floor_plan = cues
            .floor_plan()
            .map(FloorPlan::sigma)
            .map(|sigma| add(&sigma.map(|sigma| (0.0, sigma / SIGMAS_OF_BOUND))));
        let past = (gyro.is_some() || flow.is_some()).then(|| add(&[(0.0, 0.0); 3]));
        let changing =
            flow.iter().map(|[_, change, _]| *change).chain(slip).map(|place| (place, sigma[place])).collect();
        Layout { gyro, flow, wheels: wheels_at, slip, changing, mounts, range_scale, floor_plan, past, sigma, mean }
    }

    /// Place of the mount's errors of a device.
    pub(crate) fn mount(&self, mounted: Mounted) -> Option<usize> {
        let index = Mounted::ALL.iter().position(|one| *one == mounted)?;
        self.mounts[index]
    }

    /// Mean and covariance at the start of a drive somewhere in a box, whose half widths are bounds.
    pub(crate) fn start(&self, start: &PoseBox) -> (DVector<f64>, DMatrix<f64>) {
        let (mut mean, mut sigma) = (self.mean.clone(), self.sigma.clone());
        for axis in 0..3 {
            mean[axis] = start[axis].mid();
            sigma[axis] = (SIGMAS_OF_BOUND * 0.5 * start[axis].width()).max(LEAST_SIGMA);
        }
        let variances = DVector::from_iterator(sigma.len(), sigma.iter().map(|sigma| sigma * sigma));
        (DVector::from_vec(mean), DMatrix::from_diagonal(&variances))
    }
}
