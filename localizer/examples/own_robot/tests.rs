//! The example's log against the truth behind it, which was made with it: a drive in which the odometry counts 1.5 % too much on the left and 1 % too
//! little on the right, and ranges have errors of up to 5 cm.
#![allow(clippy::unwrap_used)]

use localizer::{Pose, Status, localizer::Dropped};

use super::*;

const LOG: &str = include_str!("log.csv");
const TRUTH: &str = include_str!("truth.csv");

/// The estimate after each line of a log that is odometry, with the true pose then.
fn estimates(localizer: &mut Localizer, is_used: impl Fn(&Reading) -> bool) -> Vec<(localizer::Estimate, Pose)> {
    let mut truths = TRUTH.lines().map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        Pose { x_m: numbers[1], y_m: numbers[2], heading_rad: numbers[3] }
    });
    let mut found = Vec::new();
    for reading in LOG.lines().map(|line| reading(line).unwrap()) {
        if is_used(&reading) {
            assert_eq!(localizer.observe(&reading).dropped, None, "{reading:?}");
        }
        if matches!(reading, Reading::Wheels { .. }) {
            found.push((localizer.estimate(), truths.next().unwrap()));
        }
    }
    found
}

#[test]
fn every_box_holds_the_truth_and_ranges_make_it_narrow() {
    let both = estimates(&mut own_robot(), |_| true);
    let rolled = estimates(&mut own_robot(), |reading| matches!(reading, Reading::Wheels { .. }));
    assert!(both.len() == 201 && rolled.len() == 201);
    for (estimate, truth) in both.iter().chain(&rolled) {
        assert!(estimate.pose.contains(*truth) && estimate.status == Status::Sound, "{estimate:?} without {truth:?}");
    }
    let width_m = |found: &[(localizer::Estimate, Pose)]| found.last().unwrap().0.pose.hull().width(0);
    assert!(width_m(&both) < 0.5 && width_m(&rolled) > 1.0, "{} m, {} m", width_m(&both), width_m(&rolled));
    assert!(both.last().unwrap().0.relies_on.contains(&"beacon.range"));
}

#[test]
fn a_range_that_is_false_is_noticed_and_one_of_another_device_is_dropped() {
    let mut localizer = own_robot();
    estimates(&mut localizer, |_| true);
    let beacon = |device: &str, range_m| Reading::Other {
        measured_s: 20.0,
        arrived_s: 20.0,
        device: device.to_owned(),
        numbers: vec![0.0, 0.0, range_m],
    };
    assert_eq!(localizer.observe(&beacon("lamp", 1.0)).dropped, Some(Dropped::UnknownDevice));
    assert_eq!(localizer.estimate().status, Status::Sound);
    // The robot is some 5 m away from the beacon at the origin.
    let observed = localizer.observe(&beacon("beacon", 1.0));
    assert!(observed.accounts[0].emptied && localizer.estimate().status == Status::Recovering);
}
