use std::f64::consts::PI;

use interval::Interval;

use super::*;
use crate::{
    graph::trial::{Draw, rounds},
    map::{Anchor, SpacePoint},
    methods::mapped_landmarks::trial::{True, around, boxed, homogeneous, is_within, look, walls},
};

/// Sights of a robot in a room, with boxes of their landmarks that hold them, and a box of its pose; of the sights, `n_wrong` show something
/// else.
pub(in super::super) fn trial(draw: &mut Draw, n_wrong: usize) -> (Arc<Optics>, Vec<Sight>, PoseBox, [f64; 3]) {
    let truth = True::new(draw, 0.2);
    let landmarks = walls(draw, 120);
    let turn_rad = draw.between(-3.0, 3.0);
    let at = truth.turned(draw, [0.5, -0.3], turn_rad);
    let mut sights: Vec<Sight> = look(&truth, draw, &at, &landmarks)
        .into_iter()
        .map(|seen| {
            let landmark = landmarks[seen.landmark.0 as usize];
            let axis = if landmark.x.abs() > landmark.y.abs() { 0 } else { 1 };
            let anchor = Anchor { from_m: [0.1, 0.2, 0.4], axis, is_positive: landmark[axis] > 0.0 };
            let value = homogeneous(&anchor, landmark).map(|one| around(draw, one, 0.002));
            let error_px = [truth.camera.error_px; 2];
            Sight {
                landmark: seen.landmark,
                point: SpacePoint { anchor, value },
                at_px: seen.at_px,
                error_px,
                view: None,
                thing: None,
            }
        })
        .collect();
    sights.truncate(24);
    for sight in sights.iter_mut().take(n_wrong) {
        sight.at_px = sight.at_px.map(|at| at + draw.between(-40.0, 40.0));
    }
    let pose = boxed(draw, at.pose, [0.1, 0.1, 0.05]);
    (Arc::new(Optics::new(truth.camera, truth.body)), sights, pose, at.pose)
}

#[test]
fn wrong_sightings_within_the_quota_leave_the_truth_in_the_box() {
    let mut draw = Draw::new(20_261_201);
    let mut narrower = 0;
    let n_rounds = rounds(30);
    for round in 0..n_rounds {
        let n_wrong = round % 4;
        let (optics, sights, pose, truth) = trial(&mut draw, n_wrong);
        assert!(sights.len() > 12, "{}", sights.len());
        let mut left = pose;
        FewWrong::new(&optics, Stray::default(), &sights, n_wrong).contract(&mut left);
        assert!(is_within(truth, &left), "round {round}: {truth:?} {left:?}");
        narrower += usize::from((0..3).all(|axis| left.width(axis) < 0.5 * pose.width(axis)));
    }
    assert!(3 * narrower >= 2 * n_rounds, "{narrower}");
}

/// Sights that are on three things by their columns, of which one has moved: all of its landmarks are seen elsewhere in the picture.
pub(in super::super) fn with_moved_thing(sights: &mut [Sight], moved: u32, by_px: [f64; 2]) {
    let mut order: Vec<usize> = (0..sights.len()).collect();
    order.sort_by(|&a, &b| sights[a].at_px[0].total_cmp(&sights[b].at_px[0]));
    for (rank, &at) in order.iter().enumerate() {
        let thing = (3 * rank / order.len()) as u32;
        sights[at].thing = Some(thing);
        if thing == moved {
            (0..2).for_each(|axis| sights[at].at_px[axis] += by_px[axis]);
        }
    }
}

#[test]
fn a_thing_that_has_moved_leaves_the_truth_in_the_box_and_is_named() {
    let mut draw = Draw::new(20_261_207);
    let (mut n_lost, mut n_named, mut n_narrower) = (0, 0, 0);
    let n_rounds = rounds(20);
    for round in 0..n_rounds {
        let (optics, mut sights, pose, truth) = trial(&mut draw, 0);
        let moved = (round % 3) as u32;
        with_moved_thing(&mut sights, moved, [15.0, 9.0]);
        let with = |things| FewWrong::new(&optics, Stray::default(), &sights, MostWrong { items: 0, things });
        let mut left = pose;
        with(1).contract(&mut left);
        assert!(is_within(truth, &left), "round {round}: {truth:?} {left:?}");
        n_narrower += usize::from((0..3).all(|axis| left.width(axis) < 0.7 * pose.width(axis)));
        let mut without = pose;
        with(0).contract(&mut without);
        n_lost += usize::from(!is_within(truth, &without));
        // It is named from the truth alone, whether it was declared to be possible or not, and nothing else is.
        let known = PoseBox::from([0, 1, 2].map(|axis| Interval::centred(truth[axis], 0.02)));
        for things in [0, 1] {
            let named = with(things).contradicting(&known);
            assert!(named.is_empty() || named == [moved], "round {round}: {named:?}, not {moved}");
            n_named += usize::from(!named.is_empty());
        }
    }
    assert_eq!(n_lost, n_rounds);
    assert!(4 * n_named >= 3 * 2 * n_rounds && 2 * n_narrower >= n_rounds, "{n_named} {n_narrower}");
}

#[test]
fn of_two_things_that_contradict_each_other_neither_is_named() {
    let mut draw = Draw::new(20_261_209);
    let mut n_contradictory = 0;
    for round in 0..6 {
        let (optics, mut sights, pose, _) = trial(&mut draw, 0);
        // What is seen beside its place as by a heading that is another by 0.1 rad; the box has room for that.
        with_moved_thing(&mut sights, 2, [42.0, 0.0]);
        sights.retain(|sight| sight.thing != Some(1));
        let pose = PoseBox::from([0, 1, 2].map(|axis| pose[axis].inflate([0.2, 0.2, 0.15][axis])));
        let with = |things| FewWrong::new(&optics, Stray::default(), &sights, MostWrong { items: 0, things });
        n_contradictory += usize::from(with(0).contract(&mut pose.clone()) != Outcome::Feasible);
        // Each by itself is possible from somewhere in a wide box.
        assert_eq!(with(1).contradicting(&pose), [], "round {round}");
    }
    assert!(n_contradictory >= 3, "{n_contradictory}");
}

#[test]
fn a_picture_of_one_thing_says_nothing_where_that_may_have_moved() {
    let mut draw = Draw::new(20_261_208);
    let (optics, mut sights, pose, _) = trial(&mut draw, 0);
    sights.iter_mut().for_each(|sight| sight.thing = Some(4));
    let one = FewWrong::new(&optics, Stray::default(), &sights, MostWrong { items: 0, things: 1 });
    assert!(!one.says_something() && !one.tells_anywhere());
    let mut left = pose;
    assert_eq!(one.contract(&mut left), Outcome::Feasible);
    assert_eq!(left, pose);
    assert!(one.contradicting(&pose).is_empty());
    // What is on no thing is not left out, and neither is more than one thing.
    sights.iter_mut().skip(3).for_each(|sight| sight.thing = None);
    assert_eq!(n_without(sights.iter(), 1), sights.len() - 3);
    sights.iter_mut().skip(8).for_each(|sight| sight.thing = Some(9));
    assert_eq!([0, 1, 2, 3].map(|n| n_without(sights.iter(), n)), [sights.len(), 8, 5, 5]);
}

#[test]
fn a_picture_tells_where_in_a_hall_and_facing_where_it_was_taken() {
    let mut draw = Draw::new(20_261_206);
    let hall = PoseBox::from([Interval::new(-5.0, 5.0), Interval::new(-5.0, 5.0), Interval::new(-PI, PI)]);
    for round in 0..4_u32 {
        let n_wrong = (round % 2) as usize;
        let (optics, sights, _, truth) = trial(&mut draw, n_wrong);
        let sights = FewWrong::new(&optics, Stray::default(), &sights, n_wrong);
        let found = sights.branches(&hall);
        assert!(found.iter().any(|one| is_within(truth, one)), "round {round}: {truth:?} {found:?}");
        let area_m2: f64 = found.iter().map(|one| one.width(0) * one.width(1)).sum();
        assert!(found.len() <= 3 && area_m2 < 0.5, "round {round}: {found:?}");
        // A part of the hall without the truth is excluded, where no other place looks the same.
        let beyond = PoseBox::from([hall[0], hall[1], Interval::centred(truth[2] + PI, 1.5)]);
        assert!(FewWrong::new(&optics, Stray::default(), &[], 0).branches(&beyond) == [beyond]);
        assert!(sights.anywhere(&beyond).is_empty(), "round {round}");
        // Where one of three things has moved, the truth is found if that may be, and is excluded if not.
        let (optics, mut sights, _, truth) = trial(&mut draw, 0);
        with_moved_thing(&mut sights, round % 3, [60.0, 40.0]);
        let with = |things| FewWrong::new(&optics, Stray::default(), &sights, MostWrong { items: 0, things });
        let [one, none] = [1, 0].map(|things| with(things).branches(&hall).iter().any(|found| is_within(truth, found)));
        assert!(one && !none, "round {round}: {one} {none}");
    }
}

#[test]
fn hardly_more_sightings_than_may_be_wrong_say_nothing() {
    let mut draw = Draw::new(20_261_202);
    let (optics, sights, pose, _) = trial(&mut draw, 0);
    let few = FewWrong::new(&optics, Stray::default(), &sights[..3], 2);
    assert!(!few.says_something());
    let mut left = pose;
    assert_eq!(few.contract(&mut left), Outcome::Feasible);
    assert_eq!(left, pose);
    assert!(FewWrong::new(&optics, Stray::default(), &sights, 2).says_something());
}
