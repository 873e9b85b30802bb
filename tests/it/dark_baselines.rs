//! Tests of the point methods of paper 2 (wheels, gyroscope, flow sensor and headings from walls in the dark), and of the point methods that a
//! careful engineer would use with the same sensors, on cases worked out by hand.

use interval::Interval;
use localizer::{
    Pose,
    baselines::{
        CorrectedReckoning, DeadReckoning, DirectionDatabase, GyroAtRest, SlipDecision, Way,
        pose_graph::{Step, Weights, optimised},
    },
    robot::{FlowModel, GyroModel, WheelModel},
};

/// A gyroscope with 100 Hz, a bias of at most 0.01 rad/s, and noise of at most 0.01 rad/s.
fn gyro() -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.0, 0.01),
        scale: Interval::point(1.0),
        noise_rad_per_s: 0.01,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: f64::INFINITY,
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.01,
    }
}

/// Wheels with a tick per millimetre: 1000 ticks in a turn of one metre.
fn wheels() -> WheelModel {
    let radius_m = Interval::point(1.0 / std::f64::consts::TAU);
    WheelModel {
        radius_m: [radius_m; 2],
        track_m: Interval::point(0.3),
        ticks_per_turn: 1000.0,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 0.2,
    }
}

/// A flow sensor 0.1 m ahead of the axle, aligned with the robot, with a count per tenth of a millimetre.
fn flow() -> FlowModel {
    FlowModel {
        position_m: [Interval::point(0.1), Interval::ZERO],
        metres_per_count: Interval::point(1e-4),
        scale_change: 0.0,
        yaw_rad: Interval::ZERO,
        quantisation_counts: 1.0,
        back_and_forth_m: 0.0,
        period_s: 0.01,
    }
}

#[test]
fn the_bias_is_the_mean_rate_at_rest_without_its_begin_and_end() {
    let mut at_rest = GyroAtRest::new(gyro());
    let stands = |at_rest: &mut GyroAtRest, n: usize| {
        (0..n).for_each(|step| at_rest.rate(if step % 2 == 0 { 0.003 } else { 0.005 }));
        at_rest.bias_rad_per_s()
    };
    // After 0.38 s at rest no gyroscope bias is known yet: the first 0.3 s of standing do not count, and the latest 0.1 s of rates are held back.
    assert_eq!(stands(&mut at_rest, 38), 0.0);
    // Whenever the encoders count a tick, the robot is not at rest, and the time of waiting before the gyroscope's rates are used begins anew.
    at_rest.moved();
    assert_eq!(stands(&mut at_rest, 38), 0.0);
    // The bias is the mean of about 60 rates that alternate between 0.003 and 0.005 rad/s. At most one of them is left without a partner of the other
    // value, so that the mean is close to 0.004 rad/s.
    let bias_rad_per_s = stands(&mut at_rest, 62);
    assert!((bias_rad_per_s - 0.004).abs() < 0.001 / 50.0, "{bias_rad_per_s}");
    // The robot begins to turn before its encoders count: the gyroscope's rates of that time are among those held back, and are dropped.
    (0..9).for_each(|_| at_rest.rate(0.015));
    at_rest.moved();
    let after_rad_per_s = at_rest.bias_rad_per_s();
    assert!((after_rad_per_s - 0.004).abs() < 0.001 / 50.0, "{after_rad_per_s}");
    // The robot is turned by hand with its wheels at rest, faster than the gyroscope's bias and noise together explain.
    (0..500).for_each(|_| at_rest.rate(0.3));
    assert_eq!(at_rest.bias_rad_per_s(), after_rad_per_s);
}

#[test]
fn dead_reckoning_takes_off_the_bias_that_it_found_at_rest() {
    let driven = |mut reckoning: DeadReckoning| {
        for step in 0..2000 {
            reckoning.turn(0.01);
            // The robot rests for 10 s, then drives straight ahead at 0.1 m/s for 10 s.
            let ticks = i64::from((step - 999).max(0));
            reckoning.roll([ticks, ticks]);
        }
        reckoning.pose()
    };
    let nominal = driven(DeadReckoning::new(Pose::default(), wheels(), gyro(), Way::Wheels));
    let corrected = driven(DeadReckoning::new(Pose::default(), wheels(), gyro(), Way::Wheels).with_gyro_at_rest());
    // By hand: without correction the heading drifts for 20 s at 0.01 rad/s, the gyroscope's bias, apart from the turn before the first encoder
    // reading.
    assert!((nominal.heading_rad - 0.2).abs() < 2e-4, "{nominal:?}");
    // With the bias measured at rest, the heading drifts only for 0.4 s, until the first rate enters the mean of the bias, and not after that.
    assert!(corrected.heading_rad > 0.0035 && corrected.heading_rad < 0.0045, "{corrected:?}");
    assert!(
        (corrected.x_m - 1.0).abs() < 1e-4 && (corrected.y_m - corrected.heading_rad).abs() < 1e-5,
        "{corrected:?}"
    );
}

#[test]
fn the_way_by_flow_alone_leaves_out_the_arm_and_slip_and_has_the_wheels_where_it_is_blind() {
    let mut reckoning = DeadReckoning::new(Pose::default(), wheels(), gyro(), Way::Flow(flow()));
    reckoning.flow([0, 0], 0);
    reckoning.roll([0, 0]);
    // The robot turns on the spot by 0.5 rad, so that the sensor moves 0.1 m · 0.5 to the left.
    (0..50).for_each(|_| reckoning.turn(1.0));
    reckoning.flow([0, 500], 0);
    reckoning.roll([-75, 75]);
    let turned = reckoning.pose();
    assert!(turned.x_m.abs() < 1e-12 && turned.y_m.abs() < 1e-12 && (turned.heading_rad - 0.5).abs() < 1e-12);
    // The wheels roll 0.2 m while the robot moves 0.1 m over the floor, which is what the flow sensor counts. The flow sensor is blind in the next
    // period, in which the wheels roll 0.05 m and the sensor counts nothing.
    reckoning.flow([1000, 500], 0);
    reckoning.roll([125, 275]);
    let blind_m = |reckoning: &DeadReckoning| reckoning.pose().x_m.hypot(reckoning.pose().y_m);
    assert!((blind_m(&reckoning) - 0.1).abs() < 1e-12, "{:?}", reckoning.pose());
    // Half of these 0.05 m is read from the wheels before the flow sensor has reported that it is blind. The pose must not advance until that report,
    // and then by all that the wheels rolled since the sensor's last good reading.
    reckoning.roll([150, 300]);
    assert!((blind_m(&reckoning) - 0.1).abs() < 1e-12);
    reckoning.flow([1000, 500], 1);
    reckoning.roll([175, 325]);
    assert!((blind_m(&reckoning) - 0.15).abs() < 1e-12, "{:?}", reckoning.pose());
}

#[test]
fn encoders_count_without_slip_and_the_flow_sensor_by_its_weight_with_it() {
    let decision = SlipDecision { level_m: 0.001, flow_weight: 0.75 };
    assert_eq!(decision.travel_m(0.010, [0.0095, 0.0005]), [0.010, 0.0]);
    let [forward, left] = decision.travel_m(0.010, [0.002, 0.004]);
    // Expected travel in metres with a flow weight of 0.75: 0.010 − 0.75·0.008 forward, and 0.75·0.004 left.
    assert!((forward - 0.004).abs() < 1e-12 && (left - 0.003).abs() < 1e-12);
    // A push to the side that the flow sensor sees is counted as travel, although the wheels do not turn.
    assert!(decision.travel_m(0.0, [0.0, 0.002])[1] > 0.0);
}

#[test]
fn a_remembered_direction_corrects_later_headings_and_keeps_the_first_ones_error() {
    let mut database = DirectionDatabase::default();
    // The true direction of the wall is 0.65 rad. When the wall is first seen the reckoned heading is 0.02 rad too great, and so the wall's direction
    // is stored 0.02 rad too great.
    assert_eq!(database.correct(0.65 - 0.30, 0.32), None);
    let corrected = database.correct(0.65 - 1.00, 1.10).unwrap();
    assert!((corrected - 1.02).abs() < 1e-12, "{corrected}");
    // The robot has turned by about a quarter turn more. Directions count modulo a quarter turn, so that the same wall is recognised although the
    // robot now faces across it.
    assert!(database.correct(0.65 - 2.60 + std::f64::consts::FRAC_PI_2, 2.62).is_some());
}

#[test]
fn headings_seen_bend_a_chain_of_odometry_that_turns_too_far() {
    // In ten steps of 0.1 m straight along y the gyroscope reads a turn of 0.02 rad each; the camera reads none, and has a far greater weight.
    let first = Pose { x_m: 0.0, y_m: 0.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    let step = Step { travel_m: [0.1, 0.0], turn_rad: 0.02, heading_rad: Some(first.heading_rad) };
    let believed = Weights { travel_m: 0.001, turn_rad: 0.1, heading_rad: 1e-5 };
    let last = optimised(first, &[step; 10], &believed)[9];
    assert!(last.x_m.abs() < 1e-5 && (last.y_m - 1.0).abs() < 1e-6, "{last:?}");
    // The heading seen by the camera is given a whole turn too great, which must be removed. With equal weights of gyroscope and camera, a turn of
    // 0.02 rad that only the gyroscope reads ends half way, at 0.01 rad.
    let equal = Weights { travel_m: 0.001, turn_rad: 0.01, heading_rad: 0.01 };
    let seen = Some(first.heading_rad + std::f64::consts::TAU);
    let one = optimised(first, &[Step { heading_rad: seen, ..step }], &equal)[0];
    assert!((one.heading_rad - first.heading_rad - 0.01).abs() < 1e-9, "{one:?}");
    // Without headings from the camera the result is odometry alone.
    let circle = optimised(first, &[Step { heading_rad: None, ..step }; 10], &believed)[9];
    assert!((circle.heading_rad - first.heading_rad - 0.2).abs() < 1e-12);
}

#[test]
fn a_whole_chain_of_points_follows_headings_that_are_seen_late() {
    // The robot moves one metre along x in ten seconds, and its gyroscope drifts to the left by 0.02 rad/s. Each second a wall along x is seen in
    // an image that arrives a tenth of a second late. The wall's direction remembered from the first image contains the drift until then.
    let mut chain = CorrectedReckoning::new(Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 });
    let mut reckoned = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    for step in 1..=1000 {
        let time_s = f64::from(step) * 0.01;
        reckoned.heading_rad = 0.02 * time_s;
        reckoned.x_m += 0.001 * reckoned.heading_rad.cos();
        reckoned.y_m += 0.001 * reckoned.heading_rad.sin();
        chain.reckon(time_s, reckoned);
        if step % 100 == 10 {
            chain.see(time_s - 0.1, 0.0);
        }
    }
    let pose = chain.pose();
    // Dead reckoning ends at 0.2 rad and 0.1 m to the left. The database stores the wall's direction as the mean of the directions seen so far, so
    // that each image adds a share of the drift (1/2, 1/3, …): the corrected heading drifts too, but less than half as fast.
    assert!((reckoned.heading_rad - 0.2).abs() < 1e-9 && reckoned.y_m > 0.09, "{reckoned:?}");
    assert!(pose.heading_rad > 0.0 && pose.heading_rad < 0.1, "{pose:?}");
    assert!(pose.y_m > 0.0 && pose.y_m < 0.05 && (pose.x_m - 1.0).abs() < 0.01, "{pose:?}");
}
