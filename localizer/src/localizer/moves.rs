//! The robot's motion between two stamps, and the declared bounds that it relies on.

use crate::{
    RobotModel, bounds,
    bounds::Assumption,
    graph::Stray,
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
/// Declared bounds that a prediction of the motion by the wheels relies on in addition if there is a steering encoder.
const STEERING: [Assumption; 5] = [
    bounds::WHEELS_WHEELBASE,
    bounds::WHEELS_STEERING_SLIP,
    bounds::WHEELS_STEERING_RATE,
    bounds::STEERING_ENCODER_ZERO,
    bounds::STEERING_ENCODER_SCALE,
];
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

/// Longest time after which a pose is stored anew although its encoders are coarse. It stays well below the age up to which readings are accepted, so
/// that the pose at a late reading's stamp is predicted by the wheel readings that are remembered.
const COARSE_APART_S: f64 = 2.0;
/// Share of the encoders' quantisation that the constant part of slip makes up for before a pose is stored anew. With a quarter, only encoders coarser
/// than those of usual robots, which have hundreds of ticks a turn, make poses lie farther apart than two slip windows.
const SLIP_PER_TICK: f64 = 0.25;

/// Time after the latest stored pose after which a pose is stored anew: two slip windows, so that the constant part of slip is counted afresh. Each
/// time, however, the quantisation of the encoders counts once more. Where that is coarse, the time is longer.
pub(super) fn apart_s(robot: &RobotModel) -> f64 {
    let wheels = &robot.wheels;
    let tick_m = wheels.metres_per_tick(0).hi().max(wheels.metres_per_tick(1).hi());
    let slip_m_per_s = wheels.slip_floor_m / wheels.slip_window_s;
    (2.0 * wheels.slip_window_s).max((SLIP_PER_TICK * tick_m / slip_m_per_s).min(COARSE_APART_S))
}

/// Time for which readings of motion are remembered: the greatest age of a stamp that is accepted. If stored poses may lie farther apart than that, it
/// is their distance in time plus that age, for readings that come late.
pub(super) fn memory_s(robot: &RobotModel) -> f64 {
    let apart_s = apart_s(robot);
    if apart_s < REMEMBER_S { REMEMBER_S } else { apart_s + REMEMBER_S }
}

/// An empty history of wheel, gyroscope, flow and steering readings for this robot's sensors.
pub(super) fn motion_history(robot: &RobotModel) -> WheelHistory {
    let wheels = WheelHistory::new(memory_s(robot));
    let wheels = match robot.gyro {
        Some(model) => wheels.with_gyro(model),
        None => wheels,
    };
    let wheels = match robot.flow {
        Some(model) => wheels.with_flow(model),
        None => wheels,
    };
    match robot.steering {
        Some(model) => wheels.with_steering(model),
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

/// How far the robot can have gone within the error of a stamp: by its limits of motion, by the gyroscope, and by the wheels where they are believed,
/// which is since the latest doubt ended.
pub(super) fn stray_about(
    wheels: &WheelHistory,
    robot: &RobotModel,
    slip: &CertifiedSlip,
    doubt_ended_s: f64,
    [stamp_s, error_s]: [f64; 2],
) -> Stray {
    let (model, reach) = (&robot.wheels, &robot.reach);
    let mut stray = Stray::by_reach(error_s, reach);
    if let Some(turn_rad) = wheels.greatest_turn_about(stamp_s, error_s, model, reach) {
        stray.radians = stray.radians.min(turn_rad);
    }
    let is_believed = |span_s: [f64; 2]| span_s[0] >= doubt_ended_s && !slip.covers(span_s);
    if let Some(travel_m) = wheels.greatest_travel_about(stamp_s, error_s, model, reach, &is_believed) {
        stray.metres = stray.metres.min(travel_m);
    }
    stray
}

/// Declared bounds that a prediction of the motion relies on while nothing is doubted.
pub(super) fn assumptions(robot: &RobotModel) -> Vec<Assumption> {
    let mut names = WHEELS.to_vec();
    if let Some(gyro) = robot.gyro {
        names.extend(GYRO);
        if gyro.drifts_from_way_to_way() {
            names.push(bounds::GYRO_WANDER);
        }
    } else {
        names.push(bounds::REACH_TURN_RATE);
    }
    if robot.flow.is_some() && robot.gyro.is_some() {
        names.extend(FLOW);
    }
    if robot.steering.is_some() {
        names.extend(STEERING);
    }
    names
}
