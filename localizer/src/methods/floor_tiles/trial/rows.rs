//! Tests with a rolling shutter: tile joints as it shows them from a robot that moves as fast as its declared limits allow.

use super::{
    BARREL, Eye, HEIGHT_M, MIDDLE_PX, ROW_TIME_S, SCALE, TILT_RAD, contracted, method, moved, random_pose, robot,
};
use interval::Interval;

use crate::{
    PoseBox, PoseUnion,
    methods::floor_tiles::Chain,
    vision::{FloorLine, FloorLines, synthetic::Random},
};

/// Drive at constant speed while an image is exposed, with a tilt of the body that is reversed between the upper and lower half of the
/// picture.
struct Drive {
    pose: [f64; 3],
    /// Speeds of the robot forward, left and turning.
    speed: [f64; 3],
    tilt: [f64; 2],
}

impl Drive {
    fn at_reach(random: &mut Random) -> Self {
        let (pose, _) = random_pose(random);
        let (course, lean) = (random.between(-3.2, 3.2), random.between(-3.2, 3.2));
        let turning = if random.chance(0.5) { 1.6 } else { -1.6 };
        Drive {
            pose,
            speed: [0.7 * course.cos(), 0.7 * course.sin(), turning],
            tilt: [TILT_RAD * lean.cos(), TILT_RAD * lean.sin()],
        }
    }

    /// Place in the raw image at which a point of the floor is seen by an image row at the row's own time; `None` if it is outside the
    /// picture.
    fn raw_px(&self, eye: &Eye, place_m: [f64; 2], row_time_s: f64) -> Option<[f64; 2]> {
        let mut raw_px = MIDDLE_PX;
        for _ in 0..20 {
            let time_s = (raw_px[1] - MIDDLE_PX[1]) * row_time_s;
            let [x_m, y_m, heading_rad] = moved(self.pose, self.speed, time_s);
            let (sin, cos) = heading_rad.sin_cos();
            let (dx_m, dy_m) = (place_m[0] - x_m, place_m[1] - y_m);
            let side = if time_s > 0.0 && row_time_s > 0.0 { 1.0 } else { -1.0 };
            let tilt = nalgebra::Rotation3::new(nalgebra::Vector3::new(self.tilt[0], self.tilt[1], 0.0) * side);
            let in_body = tilt * nalgebra::Vector3::new(cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m, 0.0);
            let (ahead, aside, down) = (in_body.x - eye.mount_m[0], in_body.y - eye.mount_m[1], HEIGHT_M - in_body.z);
            let (sin, cos) = eye.yaw_rad.sin_cos();
            let (ahead, aside) = (cos * ahead + sin * aside, cos * aside - sin * ahead);
            let [x, y] = [-aside / down, -ahead / down];
            if x.hypot(y) > 1.8 {
                return None;
            }
            let bent = eye.bent(x, y);
            raw_px = [0, 1].map(|axis| eye.focal_px * bent[axis] + MIDDLE_PX[axis]);
        }
        (0..2).all(|axis| (raw_px[axis] - MIDDLE_PX[axis]).abs() <= MIDDLE_PX[axis]).then_some(raw_px)
    }

    /// Joints in view, straightened by a lens model without any error; each point has a random error within its bound.
    fn lines(&self, eye: &Eye, row_time_s: f64, random: &mut Random) -> FloorLines {
        let model = Eye { focal_px: SCALE * HEIGHT_M, ..*eye };
        let mut lines = Vec::new();
        for axis in 0..2 {
            let nearest = (self.pose[axis] / 0.30).round();
            for number in -3..=3 {
                let across_m = 0.30 * (nearest + f64::from(number));
                let place_m = |step: i32| {
                    let along_m = self.pose[1 - axis] + 0.008 * f64::from(step);
                    if axis == 0 { [across_m, along_m] } else { [along_m, across_m] }
                };
                let seen = (-80..=80).filter_map(|step| self.raw_px(eye, place_m(step), row_time_s));
                let straight = seen.map(|raw_px| {
                    let ray = model.ray(raw_px);
                    [0, 1].map(|axis| model.focal_px * ray[axis] + MIDDLE_PX[axis] + random.between(-0.2, 0.2))
                });
                let points_px: Vec<[f64; 3]> = straight
                    .filter(|at| (0..2).all(|axis| (at[axis] - MIDDLE_PX[axis]).abs() <= MIDDLE_PX[axis]))
                    .map(|[u, v]| [u, v, 0.3])
                    .collect();
                if points_px.len() >= 12 {
                    lines.push(FloorLine { points_px, share_wrong: 0.0, family: axis as u8 });
                }
            }
        }
        FloorLines { lines, rejected_px: Vec::new() }
    }
}

/// Results of drives at the greatest speeds: the number of drives that gave a constraint, the number of those whose box misses the true
/// pose at the stamp, and the mean widths of the boxes.
fn rolling(lens: [f64; 5], row_time_s: f64, known_row_time_s: f64) -> (usize, usize, [f64; 3]) {
    let (eye, method) = (Eye::with(lens), method(&robot(lens, 0.0, known_row_time_s), Chain::Direct));
    let (mut random, mut found, mut missed, mut widths) = (Random::new(7), 0, 0, [0.0; 3]);
    for _ in 0..400 {
        let drive = Drive::at_reach(&mut random);
        let lines = drive.lines(&eye, row_time_s, &mut random);
        let prior = PoseBox::from(drive.pose.map(|at| Interval::centred(at, 0.02)));
        let Some(constraint) = method.constraint(0.0, lines, &PoseUnion::single(prior)) else { continue };
        let pose_box = contracted(&constraint, prior);
        (found, missed) = (found + 1, missed + usize::from(!pose_box.contains(&drive.pose)));
        widths = [0, 1, 2].map(|axis| widths[axis] + pose_box[axis].width());
    }
    let widths = widths.map(|width| 1e3 * width / f64::from(found.max(1) as u32));
    println!(
        "rows {row_time_s}, known {known_row_time_s}: found {found}, missed {missed}, widths {widths:.2?} mm and mrad"
    );
    (found, missed, widths)
}

#[test]
fn rows_taken_one_after_the_other_keep_the_pose_at_the_stamp_in_the_box() {
    for lens in [[0.0; 5], BARREL] {
        let (found, missed, _) = rolling(lens, ROW_TIME_S, ROW_TIME_S);
        assert!(found > 350 && missed == 0, "{missed} of {found} missed");
        let (_, missed, _) = rolling(lens, ROW_TIME_S, 0.0);
        assert!(missed > 100, "a shutter that the model does not know is missed only {missed} times");
        let (found, missed, _) = rolling(lens, 0.0, 0.0);
        assert!(found > 350 && missed == 0, "{missed} of {found} missed");
    }
}
