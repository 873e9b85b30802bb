//! The robot's motion between two stamps, and the declared bounds that it relies on.

use crate::{
    RobotModel, bounds,
    bounds::Assumption,
    motion::{Motion, WheelHistory},
};

use super::{REMEMBER_S, slip::CertifiedSlip};

/// Declared bounds that a prediction of the motion by the wheels relies on.
pub(super) const WHEELS: [Assumption; 6] = [
    bounds::WHEELS_RADIUS,
    bounds::WHEELS_TRACK,
    bounds::WHEELS_SLIP,
    bounds::WHEELS_SIDE_SLIP,
    bounds::REACH_ACCELERATION,
    bounds::ROOM_WALLS,
];
/// Declared bounds that a prediction of the motion by the robot's physical limits alone relies on.
pub(super) const REACH: [Assumption; 3] = [bounds::REACH_SPEED, bounds::REACH_TURN_RATE, bounds::ROOM_WALLS];
/// Declared bounds that a prediction of the motion relies on in addition if there is a gyroscope.
const GYRO: [Assumption; 4] = [bounds::GYRO_BIAS, bounds::GYRO_SCALE, bounds::GYRO_NOISE, bounds::GYRO_ANGLE];
/// Declared bounds that a prediction of the motion by the wheels relies on in addition if there is a flow sensor.
const FLOW: [Assumption; 7] = [
    bounds::FLOW_POSITION,
    bounds::FLOW_YAW,
    bounds::FLOW_CALIBRATION,
    bounds::FLOW_SCALE,
    bounds::FLOW_BACK_AND_FORTH,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

/// Time for which readings of motion are remembered: the greatest age of a stamp that is accepted. If stored poses may lie farther apart than that (a
/// new one is stored after two slip windows), it is their distance in time plus that age, for readings that come late.
pub(super) fn memory_s(robot: &RobotModel) -> f64 {
    let apart_s = 2.0 * robot.wheels.slip_window_s;
    if apart_s < REMEMBER_S { REMEMBER_S } else { apart_s + REMEMBER_S }
}

/// An empty history of wheel, gyroscope and flow readings for this robot's sensors.
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

/// The robot's motion between two stamps by the remembered readings; while the wheels are doubted after a contradiction, by the robot's limits of
/// speed and turn rate alone.
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

/// Declared bounds that a prediction of the motion relies on while nothing is doubted.
pub(super) fn assumptions(robot: &RobotModel) -> Vec<Assumption> {
    let mut names = WHEELS.to_vec();
    if let Some(gyro) = robot.gyro {
        names.extend(GYRO);
        if gyro.drifts_from_way_to_way() {
            names.push(bounds::GYRO_WANDER);
        }
    }
    if robot.flow.is_some() && robot.gyro.is_some() {
        names.extend(FLOW);
    }
    names
}
