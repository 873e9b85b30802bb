//! Localizers whose stored poses lie farther apart in time than a reading's stamp may be old (3 s): the pose at a reading's stamp is predicted
//! from the last stored pose before it, however old that one is.

use interval::Interval;
use localizer::{
    Constraint, Localizer, Map, Method, PoseBox, PoseUnion, Reading, RobotModel, Status,
    localizer::Dropped,
    method::Context,
    reading::{LandmarkId, Sighting},
};

use crate::range_landmarks_setup::{robot, says};

/// A stand-in for a localization method: it claims that x is 0 to within a centimetre, at every reading.
struct AtZero;

impl Method for AtZero {
    fn name(&self) -> &'static str {
        "at_zero"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        Some(says(self.name(), reading, 0, Interval::centred(0.0, 0.01)))
    }
}

/// Localizer of a robot that rests in the origin and counts slip over windows of this length.
fn resting(slip_window_s: f64) -> Localizer {
    let mut robot: RobotModel = robot(0, 1);
    robot.wheels.slip_window_s = slip_window_s;
    let start = PoseBox::from([Interval::centred(0.0, 0.05); 3]);
    Localizer::new(room(), robot, vec![Box::new(AtZero)], start)
}

fn room() -> Map {
    Map {
        room_m: [Interval::new(-3.0, 4.0), Interval::new(-3.0, 3.0)],
        tiles: None,
        markers: None,
        wall_directions_rad: Vec::new(),
        walls: None,
    }
}

/// Gives the localizer readings of wheels at rest, every 10 ms of a time interval.
fn rest(localizer: &mut Localizer, [from_s, to_s]: [f64; 2]) {
    for step in (from_s * 100.0).round() as i32..=(to_s * 100.0).round() as i32 {
        let time_s = f64::from(step) * 0.01;
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
    }
}

/// Gives the localizer a range reading with this stamp, and asserts that the truth stays inside the box and that no assumption is doubted;
/// returns the pose at the stamp.
fn look(localizer: &mut Localizer, measured_s: f64, arrived_s: f64) -> PoseUnion {
    let observed = localizer.observe(&Reading::Range { measured_s, arrived_s, sightings: Vec::new() });
    let [account] = observed.accounts.as_slice() else { panic!("the reading at {measured_s} s: {observed:?}") };
    assert!(!account.emptied && account.posterior.hull().contains(&[0.0; 3]), "{:?}", account.posterior);
    assert!(account.posterior.hull()[0].is_subset_of(Interval::centred(0.0, 0.01)));
    let estimate = localizer.estimate();
    assert!(estimate.status == Status::Sound && estimate.pose.hull().contains(&[0.0; 3]), "{estimate:?}");
    account.posterior.clone()
}

#[test]
fn a_reading_long_after_the_last_slot_is_told_from_it_by_the_wheels() {
    let mut localizer = resting(5.0);
    for [from_s, to_s] in [[0.0, 8.0], [8.01, 12.0], [12.01, 21.9]] {
        rest(&mut localizer, [from_s, to_s]);
        let posterior = look(&mut localizer, to_s - 0.05, to_s);
        // The pose may have moved by the slip that is declared for a robot at rest over two windows (the time for which slip is bounded), but by far
        // less than the robot could have driven since the last stored pose.
        assert!(posterior.hull()[1].width() < 1.0 && posterior.hull()[2].width() < 1.0, "{posterior:?}");
    }
}

#[test]
fn a_reading_that_the_next_slot_overtakes_is_told_from_the_slot_before() {
    let mut localizer = resting(5.0);
    // The localizer stores a pose anew after two slip windows, here at 10 s: after the reading's stamp, but before the reading arrives.
    rest(&mut localizer, [0.0, 10.1]);
    look(&mut localizer, 9.95, 10.1);
}

#[test]
fn a_reading_after_wheels_that_were_silent_for_longer_than_they_are_remembered_is_told_by_reach() {
    let mut localizer = resting(0.2);
    rest(&mut localizer, [0.0, 1.0]);
    rest(&mut localizer, [8.0, 8.0]);
    look(&mut localizer, 7.9, 8.0);
}

#[test]
fn a_reading_older_than_stamps_are_remembered_is_refused_however_old_the_last_slot_is() {
    let mut localizer = resting(5.0);
    rest(&mut localizer, [0.0, 8.0]);
    let late = Reading::Range { measured_s: 4.9, arrived_s: 8.0, sightings: Vec::new() };
    let observed = localizer.observe(&late);
    let Some(Dropped::TooOld { age_s, .. }) = observed.dropped else { panic!("{observed:?}") };
    assert!((age_s - 3.1).abs() < 1e-9 && observed.accounts.is_empty(), "{age_s}");
}

#[test]
fn a_reading_that_cannot_be_used_is_answered_by_the_reason() {
    let dropped = |localizer: &mut Localizer, reading: Reading| localizer.observe(&reading).dropped;
    let range = |measured_s, arrived_s| Reading::Range { measured_s, arrived_s, sightings: Vec::new() };
    let mut localizer = resting(5.0);
    assert_eq!(dropped(&mut localizer, range(0.0, 0.0)), Some(Dropped::NoMotion));
    rest(&mut localizer, [0.0, 1.0]);
    assert_eq!(dropped(&mut localizer, range(0.5, 1.0)), None);
    assert_eq!(dropped(&mut localizer, range(-0.5, 1.0)), Some(Dropped::BeforeStart));
    let wheels = |measured_s| Reading::Wheels { measured_s, arrived_s: 1.0, ticks: [0; 2] };
    assert_eq!(dropped(&mut localizer, wheels(1.0)), Some(Dropped::Overtaken));
    assert_eq!(dropped(&mut localizer, wheels(1.01)), None);
    // The robot has neither a gyroscope nor a flow sensor, and no method reads a beacon.
    let gyro = Reading::Gyro { measured_s: 1.0, arrived_s: 1.0, rate_rad_per_s: 0.0 };
    let flow = Reading::Flow { measured_s: 1.0, arrived_s: 1.0, counts: [0; 2], blind_periods: 0 };
    let beacon = Reading::Other { measured_s: 1.0, arrived_s: 1.0, device: "beacon".to_owned(), numbers: Vec::new() };
    for unknown in [gyro, flow, beacon] {
        assert_eq!(dropped(&mut localizer, unknown), Some(Dropped::UnknownDevice));
    }
    let rate = Reading::Gyro { measured_s: 1.0, arrived_s: 1.0, rate_rad_per_s: f64::NAN };
    let sighting = Sighting { landmark: LandmarkId(1), left_px: f64::INFINITY, right_px: 1.0 };
    let seen = Reading::Range { measured_s: 1.0, arrived_s: 1.0, sightings: vec![sighting] };
    for not_finite in [rate, seen, range(f64::NAN, 1.0), wheels(f64::INFINITY), range(0.5, f64::NAN)] {
        assert_eq!(dropped(&mut localizer, not_finite), Some(Dropped::NotFinite));
    }
    for travel_m in [[f64::NAN, 0.3], [0.3, f64::NEG_INFINITY], [1e10, 0.0]] {
        assert!(Reading::odometry(1.0, 1.0, travel_m).is_none(), "{travel_m:?}");
    }
    assert!(Reading::odometry(1.0, 1.0, [0.3, -1e9]).is_some());
}

#[test]
fn readings_every_four_seconds_are_used_whatever_the_slip_window() {
    for slip_window_s in [0.2, 3.0, 5.0] {
        let mut localizer = resting(slip_window_s);
        for number in 0..8 {
            let from_s = 4.0 * f64::from(number);
            rest(&mut localizer, [if number == 0 { 0.0 } else { from_s + 0.01 }, from_s + 4.0]);
            look(&mut localizer, from_s + 3.95, from_s + 4.0);
        }
    }
}

#[test]
fn encoder_readings_lost_at_the_start_cost_reach_only_until_the_first_that_comes() {
    let mut localizer = resting(0.2);
    let lost_s = 0.3;
    rest(&mut localizer, [lost_s, lost_s + 0.1]);
    // The robot may have gone 0.7 m/s · 0.3 s along and across its heading before the first reading. Both its start and its first heading are known to
    // 0.05. From then on the wheels say that it rests, to within their slip.
    let most_m = 2.0 * (0.05 + 0.7 * lost_s * 1.05) + 0.01;
    let estimate = localizer.estimate();
    assert!(estimate.pose.hull()[0].width() < most_m, "{estimate:?}");
    assert!(estimate.relies_on.contains(&"reach.speed"), "{:?}", estimate.relies_on);
    for gone_m in [-0.25, 0.0, 0.25] {
        assert!(estimate.pose.hull().contains(&[gone_m, -gone_m, 0.0]), "{estimate:?}");
    }
    // A reading that was taken before the first of the wheels does not bring the lost time back.
    let observed = localizer.observe(&Reading::Range { measured_s: 0.2, arrived_s: 0.4, sightings: Vec::new() });
    assert_eq!(observed.dropped, None);
    rest(&mut localizer, [0.41, 0.6]);
    let estimate = localizer.estimate();
    // From that reading on, which tells x to 0.01 m, 0.1 s are lost. The heading is then known to 0.05 + 1.6 · 0.2 = 0.37, whose sine is 0.36.
    assert!(estimate.pose.hull()[0].width() < 2.0 * (0.01 + 0.7 * 0.1 * 1.36) + 0.02, "{estimate:?}");
}

#[test]
fn a_robot_that_may_be_anywhere_still_has_turned_as_often_as_was_last_known() {
    let headings_rad = [0.0, 20.0, -31.0];
    for heading_rad in headings_rad {
        // The localizer is told that the robot starts inside a wall, so that no pose is possible from the first step on, and any pose must then be
        // assumed to be possible.
        let start = PoseBox::from([Interval::point(9.0), Interval::ZERO, Interval::centred(heading_rad, 0.05)]);
        let mut localizer = Localizer::new(room(), robot(0, 1), Vec::new(), start);
        rest(&mut localizer, [0.0, 1.0]);
        let estimate = localizer.estimate();
        assert_eq!(estimate.status, Status::Recovering);
        for aside_rad in [-3.1, 0.0, 3.1] {
            let pose = localizer::Pose { x_m: 0.0, y_m: 0.0, heading_rad: heading_rad + aside_rad };
            assert!(estimate.pose.contains(pose), "{heading_rad} {aside_rad}: {:?}", estimate.pose);
        }
    }
}

#[test]
fn a_robot_that_may_be_anywhere_after_wheels_were_silent_has_turned_as_far_as_it_can() {
    let start = PoseBox::from([Interval::point(9.0), Interval::ZERO, Interval::ZERO]);
    let robot = robot(0, 1);
    let turned_rad = 8.0 * robot.reach.turn_rate_rad_per_s;
    assert!(turned_rad > 2.0 * std::f64::consts::PI);
    let mut localizer = Localizer::new(room(), robot, Vec::new(), start);
    rest(&mut localizer, [8.0, 8.0]);
    for heading_rad in [-turned_rad, 0.0, turned_rad] {
        let pose = localizer::Pose { x_m: 0.0, y_m: 0.0, heading_rad };
        assert!(localizer.estimate().pose.contains(pose), "{heading_rad}: {:?}", localizer.estimate().pose);
    }
}
