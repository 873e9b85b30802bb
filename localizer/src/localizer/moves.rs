//! How the robot moved between two stamps, and which declared bounds that stands on.

use crate::{
    RobotModel, bounds,
    bounds::Assumption,
    motion::{Motion, WheelHistory},
};

use super::{REMEMBER_S, slip::CertifiedSlip};

/// The bounds that a prediction by wheels stands on.
pub(super) const WHEELS: [Assumption; 6] = [
    bounds::WHEELS_RADIUS,
    bounds::WHEELS_TRACK,
    bounds::WHEELS_SLIP,
    bounds::WHEELS_SIDE_SLIP,
    bounds::REACH_ACCELERATION,
    bounds::ROOM_WALLS,
];
/// The bounds that a prediction by reach stands on.
pub(super) const REACH: [Assumption; 3] = [bounds::REACH_SPEED, bounds::REACH_TURN_RATE, bounds::ROOM_WALLS];
/// What a gyroscope adds to both.
const GYRO: [Assumption; 4] = [bounds::GYRO_BIAS, bounds::GYRO_SCALE, bounds::GYRO_NOISE, bounds::GYRO_ANGLE];
/// What a flow sensor adds to the wheels.
const FLOW: [Assumption; 7] = [
    bounds::FLOW_POSITION,
    bounds::FLOW_YAW,
    bounds::FLOW_CALIBRATION,
    bounds::FLOW_SCALE,
    bounds::FLOW_BACK_AND_FORTH,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

/// How long motion is remembered: as far back as stamps may lie from now, or as slots may lie apart, which are opened anew after two slip
/// windows, with as much for readings that come late.
pub(super) fn memory_s(robot: &RobotModel) -> f64 {
    let apart_s = 2.0 * robot.wheels.slip_window_s;
    if apart_s < REMEMBER_S { REMEMBER_S } else { apart_s + REMEMBER_S }
}

/// The memory of what moves this robot.
pub(super) fn motion_history(robot: &RobotModel) -> WheelHistory {
    let wheels = WheelHistory::new(memory_s(robot));
    let wheels = match robot.gyro {
        Some(model) => wheels.with_gyro(model),
        None => wheels,
    };
    match robot.flow {
        Some(model) => wheels.with_flow(model),
        None => wheels,
    }
}

/// Motion between two stamps of the memory, by reach alone while the wheels are doubted.
pub(super) fn motion_between(
    wheels: &WheelHistory,
    robot: &RobotModel,
    slip: &CertifiedSlip,
    doubted: bool,
    [from_s, to_s]: [f64; 2],
) -> Option<Motion> {
    if doubted {
        return Some(wheels.reach_motion(from_s, to_s, &robot.reach));
    }
    let rolled = wheels.motion(from_s, to_s, &robot.wheels, &robot.reach);
    let flow = wheels.flow_motion(from_s, to_s, &robot.wheels, &robot.reach);
    slip.motion([from_s, to_s], rolled, flow, wheels, robot)
}

/// The bounds that a prediction without doubt stands on.
pub(super) fn assumptions(robot: &RobotModel) -> Vec<Assumption> {
    let mut names = WHEELS.to_vec();
    if robot.gyro.is_some() {
        names.extend(GYRO);
    }
    if robot.flow.is_some() && robot.gyro.is_some() {
        names.extend(FLOW);
    }
    names
}
