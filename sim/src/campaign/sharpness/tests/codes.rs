//! Sightings whose codes are wrong: as many and as far apart as declared, and none beyond.

use std::path::Path;

use interval::Interval;
use localizer::{bounds, bounds::Assumption, reading::Reading};

use super::super::{
    ReadingLog,
    history::History,
    kind::Kind,
    range::Range,
    readings::Readings,
    search::{TRUTH_SLACK, check, search},
};
use super::drive::Drive;
use crate::{
    run::{RunOptions, RunRecord, run_witnessed},
    scene::{Distribution, Scene},
    subject::IntervalLocalizer,
};

/// Looks of a drive at landmarks 7 and 9, with at most one wrong code in a look and two right ones between two wrong ones of a landmark.
fn range(drive: &Drive) -> Range {
    let mut range = drive.range();
    (range.model.q_items, range.model.wrong_spacing) = (1, 2);
    range
}

/// Puts a sighting 5 px off to the side.
fn spoil(range: &mut Range, look: usize, sighting: usize) {
    range.looks[look].sightings[sighting].left_px += 5.0;
    range.looks[look].sightings[sighting].right_px += 5.0;
}

fn broken(drive: &Drive, range: &Range) -> Option<Assumption> {
    range.check(&drive.history, 0.0).err().map(|broken| broken.bound)
}

#[test]
fn one_more_wrong_code_than_declared_is_refused_and_so_is_one_too_near_another() {
    let drive = Drive::on_circle(&[30, 50, 70, 90]);
    let mut wrong = range(&drive);
    spoil(&mut wrong, 0, 0);
    assert_eq!(broken(&drive, &wrong), None);
    // The other landmark's code in the same look, and in the next.
    let mut two = range(&drive);
    (0..2).for_each(|sighting| spoil(&mut two, 0, sighting));
    assert_eq!(broken(&drive, &two), Some(bounds::RANGE_LANDMARKS_Q_ITEMS));
    spoil(&mut wrong, 1, 1);
    assert_eq!(broken(&drive, &wrong), None);
    // The same code again after two right uses of it, and after one.
    spoil(&mut wrong, 3, 0);
    assert_eq!(broken(&drive, &wrong), None);
    let mut near = range(&drive);
    [0, 2].into_iter().for_each(|look| spoil(&mut near, look, 0));
    assert_eq!(broken(&drive, &near), Some(bounds::RANGE_LANDMARKS_WRONG_SPACING));
    // Where no code may be wrong, it is the columns that are.
    near.model.q_items = 0;
    assert_eq!(broken(&drive, &near), Some(bounds::RANGE_CAMERA_COLUMNS));
}

/// A run of the scene with wrong codes.
struct Run {
    scene: Scene,
    record: RunRecord,
    log: ReadingLog,
}

impl Run {
    fn of(errors: Distribution) -> Run {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/papers/rigid_transform_wrong_matches.toml");
        let mut scene = Scene::load(Path::new(path)).unwrap();
        scene.duration_s = 4.0;
        scene.robot.errors = errors;
        let mut log = ReadingLog::default();
        let mut subject = IntervalLocalizer::of(&scene);
        let options = RunOptions::default();
        let record = run_witnessed(&scene, 3, &mut subject, None, &options, &mut log, &mut |_| {}).unwrap();
        Run { scene, record, log }
    }

    fn last(&self) -> (History, Vec<Box<dyn Kind>>) {
        let readings = Readings::of(&self.scene, &self.record, &self.log);
        readings.until(self.record.truths.last().unwrap().time_s).unwrap()
    }

    fn spanned(&self) -> [Interval; 3] {
        let (truth, kinds) = self.last();
        search(&truth, &kinds, [0.1, 0.1, 0.1]).unwrap().spanned
    }
}

#[test]
fn the_truth_of_a_run_with_wrong_codes_is_accepted() {
    for errors in [Distribution::Corner, Distribution::Uniform] {
        let run = Run::of(errors);
        let codes = run.log.observations.iter().flat_map(|observation| &observation.codes);
        assert!(codes.filter(|(_, is_own)| !is_own).count() > 2);
        let (truth, kinds) = run.last();
        assert_eq!(check(&truth, &kinds, TRUTH_SLACK), Ok(()));
    }
}

/// A witness may have other codes wrong than the truth has, so that it ends farther out than witnesses which have the same.
#[test]
fn freely_chosen_wrong_codes_lead_farther_and_not_out_of_the_box() {
    let mut run = Run::of(Distribution::Uniform);
    let hull = run.record.estimates.last().unwrap().pose.hull();
    let free = run.spanned();
    assert!((0..3).all(|axis| free[axis].is_subset_of(hull[axis])), "{free:?} in {hull:?}");
    // Without the sightings that truly have wrong codes, and with all others right.
    for observation in &mut run.log.observations {
        let mut codes = observation.codes.iter();
        if let Reading::Range { sightings, .. } = &mut observation.reading {
            sightings.retain(|_| codes.next().is_some_and(|(_, is_own)| *is_own));
        }
    }
    run.scene.robot.range_camera.as_mut().unwrap().q_items = 0;
    let kept = run.spanned();
    // In heading other wrong codes win most; the wheels know the way in x and y nearly as well as the sightings.
    for (axis, gain) in [1.03, 1.0, 1.1].into_iter().enumerate() {
        assert!(kept[axis].width() > 0.0 && free[axis].width() > gain * kept[axis].width(), "{free:?}, {kept:?}");
    }
}
