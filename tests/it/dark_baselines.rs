//! Paper 2's point methods on cases worked out by hand.

use localizer::{
    Pose,
    baselines::{
        CorrectedReckoning, DirectionDatabase, SlipDecision,
        pose_graph::{Step, Weights, optimised},
    },
};

#[test]
fn encoders_count_without_slip_and_the_flow_sensor_by_its_weight_with_it() {
    let decision = SlipDecision { level_m: 0.001, flow_weight: 0.75 };
    assert_eq!(decision.travel_m(0.010, [0.0095, 0.0005]), [0.010, 0.0]);
    let [forward, left] = decision.travel_m(0.010, [0.002, 0.004]);
    // 0.010 − 0.75·0.008, and 0.75·0.004.
    assert!((forward - 0.004).abs() < 1e-12 && (left - 0.003).abs() < 1e-12);
    // A push sideways, without a turn of the wheels.
    assert!(decision.travel_m(0.0, [0.0, 0.002])[1] > 0.0);
}

#[test]
fn a_remembered_direction_corrects_later_headings_and_keeps_the_first_ones_error() {
    let mut database = DirectionDatabase::default();
    // The wall runs at 0.65 rad; the first heading is 0.02 rad too great, and so is the direction remembered.
    assert_eq!(database.correct(0.65 - 0.30, 0.32), None);
    let corrected = database.correct(0.65 - 1.00, 1.10).unwrap();
    assert!((corrected - 1.02).abs() < 1e-12, "{corrected}");
    // A quarter turn on, the same wall is seen across.
    assert!(database.correct(0.65 - 2.60 + std::f64::consts::FRAC_PI_2, 2.62).is_some());
}

#[test]
fn headings_seen_bend_a_chain_of_odometry_that_turns_too_far() {
    // Ten steps of 0.1 m straight on along y; the gyroscope says 0.02 rad of turn in each, the camera says none, and is believed.
    let first = Pose { x_m: 0.0, y_m: 0.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    let step = Step { travel_m: [0.1, 0.0], turn_rad: 0.02, heading_rad: Some(first.heading_rad) };
    let believed = Weights { travel_m: 0.001, turn_rad: 0.1, heading_rad: 1e-5 };
    let last = optimised(first, &[step; 10], &believed)[9];
    assert!(last.x_m.abs() < 1e-5 && (last.y_m - 1.0).abs() < 1e-6, "{last:?}");
    // Equally believed, one step of 0.02 rad ends half way, with the wrap of a full turn taken out.
    let equal = Weights { travel_m: 0.001, turn_rad: 0.01, heading_rad: 0.01 };
    let seen = Some(first.heading_rad + std::f64::consts::TAU);
    let one = optimised(first, &[Step { heading_rad: seen, ..step }], &equal)[0];
    assert!((one.heading_rad - first.heading_rad - 0.01).abs() < 1e-9, "{one:?}");
    // Without headings, odometry alone.
    let circle = optimised(first, &[Step { heading_rad: None, ..step }; 10], &believed)[9];
    assert!((circle.heading_rad - first.heading_rad - 0.2).abs() < 1e-12);
}

#[test]
fn a_whole_chain_of_points_follows_headings_that_are_seen_late() {
    // A metre in ten seconds along x, by a gyroscope that drifts to the left by 0.02 rad/s; each second a wall along x is seen from a picture that
    // comes a tenth of a second late. What the first picture remembers of the wall is what had drifted by then.
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
    // Dead reckoning ends at 0.2 rad and 0.1 m to the left. The database's mean takes over a share of the drift at each picture (1/2, 1/3, …), so
    // that its error grows too, but less than half as fast.
    assert!((reckoned.heading_rad - 0.2).abs() < 1e-9 && reckoned.y_m > 0.09, "{reckoned:?}");
    assert!(pose.heading_rad > 0.0 && pose.heading_rad < 0.1, "{pose:?}");
    assert!(pose.y_m > 0.0 && pose.y_m < 0.05 && (pose.x_m - 1.0).abs() < 0.01, "{pose:?}");
}
