//! The places of the quantities in the filter's state, and what is known of each at the start.

use localizer::{PoseBox, RobotModel};
use nalgebra::{DMatrix, DVector};

use crate::subject::cues::{Cues, Mounted, SIGMAS_OF_BOUND};

/// Places of the quantities in the state; `None` for those of devices that the robot does not have.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Bias of the gyroscope in rad/s, and the share by which its scale is off.
    pub(crate) gyro: Option<[usize; 2]>,
    /// Share by which the flow sensor's counts per metre are off, and the angle by which it is turned.
    pub(crate) flow: Option<[usize; 2]>,
    /// Shares by which the radii of the left and the right wheel and the track are off.
    pub(crate) wheels: [usize; 3],
    /// Errors of the mounts that last: forward, left, turn.
    mounts: [Option<usize>; Mounted::ALL.len()],
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
    pub(crate) fn new(robot: &RobotModel, cues: &Cues) -> Layout {
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
            let at = add(&[(bias.mid(), 0.5 * bias.width()), (0.0, 0.5 * scale.width() / scale.mid())]);
            [at, at + 1]
        });
        let flow = robot.flow.map(|flow| {
            let per_count = flow.metres_per_count;
            let at = add(&[(0.0, 0.5 * per_count.width() / per_count.mid()), (0.0, 0.5 * flow.yaw_rad.width())]);
            [at, at + 1]
        });
        let wheels = &robot.wheels;
        let share = |of: interval::Interval| (0.0, 0.5 * of.width() / of.mid());
        let at = add(&[share(wheels.radius_m[0]), share(wheels.radius_m[1]), share(wheels.track_m)]);
        let mounts = Mounted::ALL.map(|mounted| {
            let mount = cues.mount(mounted)?;
            Some(add(&mount.sigma.map(|sigma| (0.0, sigma / SIGMAS_OF_BOUND))))
        });
        let past = (gyro.is_some() || flow.is_some()).then(|| add(&[(0.0, 0.0); 3]));
        Layout { gyro, flow, wheels: [at, at + 1, at + 2], mounts, past, sigma, mean }
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
