//! A localization method that is written outside of the localizer's crate, for a device that the localizer has no kind for, in a simulated drive.

use interval::Interval;
use localizer::{Constraint, Localizer, Method, Reading, method::Context, rigid_motion::RigidPlanar};
use sim::{
    judge::Verdict,
    run::{RunOptions, run},
    scene::Scene,
    subject::{IntervalLocalizer, Subject},
};

use crate::{command::blind_scene, judging::verdict_of_subject};

/// Name of the bound that the method relies on, which the project's table of bounds does not have.
const OWN_BOUND: &str = "antenna.position";

/// Takes the numbers of a receiver for the position of its antenna, which is on the robot at the given place.
struct Antenna {
    in_robot_m: [f64; 2],
    /// Greatest error of either coordinate, by the receiver, by the robot's motion within the error of the stamp, and by the robot's lean.
    within_m: f64,
}

impl Method for Antenna {
    fn name(&self) -> &'static str {
        "antenna"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == "gnss")
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let &[x_m, y_m, _] = &numbers[..] else { return None };
        let in_world_m = [x_m, y_m].map(|at_m| Interval::centred(at_m, self.within_m));
        let on_pose = RigidPlanar::new(&[(in_world_m, self.in_robot_m.map(Interval::point))]);
        Some(Constraint { relies_on: vec![OWN_BOUND], ..Constraint::new(self.name(), *measured_s, on_pose) })
    }
}

/// The localizer with these methods in a drive past a receiver with errors of up to a centimetre.
fn driven(methods_of: fn(&Scene) -> Vec<Box<dyn Method>>) -> Verdict {
    let receiver =
        "[robot.gnss]\nforward_m = 0.1\nleft_m = 0.05\nfixed_tolerance_m = 0.01\nfloating_tolerance_m = 0.01\n";
    let scene = Scene::parse(&blind_scene(8.0, receiver), "scene.toml").unwrap_or_else(|error| panic!("{error}"));
    let subject_of = |told: &Scene| {
        let localizer = Localizer::new(told.map(), told.robot_model(), methods_of(told), told.start_box());
        Box::new(IntervalLocalizer::from(localizer)) as Box<dyn Subject>
    };
    let record = run(&scene, 3, &mut *subject_of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let last = record.estimates.last().unwrap();
    assert_eq!(last.relies_on.contains(&OWN_BOUND), !methods_of(&scene).is_empty());
    verdict_of_subject(&scene, &record, &subject_of)
}

#[test]
fn a_method_of_ones_own_for_a_device_of_ones_own_narrows_the_boxes_and_keeps_the_truth() {
    let without = driven(|_| Vec::new());
    let with = driven(|scene| {
        let receiver = scene.robot.gnss.as_ref().unwrap();
        let in_robot_m = [receiver.forward_m, receiver.left_m];
        // The antenna's place on the robot is known to some millimetres; the stamp to some milliseconds, in which the robot drives some more.
        let within_m = receiver.floating_tolerance_m + receiver.position_tolerance_m + 0.02;
        vec![Box::new(Antenna { in_robot_m, within_m })]
    });
    for verdict in [&without, &with] {
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!(containment.contained, containment.checks, "{containment:?}");
    }
    let readings = &with.methods["antenna"];
    assert!(readings.constraints >= 5 && readings.empty == 0, "{readings:?}");
    let mean_m = |verdict: &Verdict| verdict.width.as_ref().unwrap().x_m.mean_by_third[2];
    assert!(mean_m(&with) < 0.8 * mean_m(&without), "{} m, {} m without", mean_m(&with), mean_m(&without));
}
