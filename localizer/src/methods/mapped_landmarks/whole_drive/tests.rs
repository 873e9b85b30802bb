//! Landmarks whose true places are known, seen from a way by a camera that is projected with rotation matrices of `nalgebra`.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::*;
use crate::{
    graph::{
        Variable, bounds_over,
        trial::{Draw, rounds},
    },
    methods::mapped_landmarks::{
        album::tests::any_look,
        trial::{True, boxed, homogeneous},
    },
};

/// Number of landmarks that are seen from the whole way.
const N_LANDMARKS: u32 = 17;
/// One more landmark, which is seen from the first two places alone.
const RARE: LandmarkId = LandmarkId(N_LANDMARKS);
/// The landmark of which the picture at the stamp 3 shows something else.
const WRONG: LandmarkId = LandmarkId(4);

/// What a drive of ten places at the stamps 0 to 9 shows.
struct Shown {
    drive: WholeDrive,
    album: Album,
    optics: Arc<Optics>,
    poses: Vec<(f64, PoseBox)>,
    landmarks: Vec<Vector3<f64>>,
}

fn shown(draw: &mut Draw) -> Shown {
    let truth = True::new(draw, 0.1);
    let optics = Arc::new(Optics::new(truth.camera, truth.body));
    let landmarks: Vec<Vector3<f64>> = (0..=N_LANDMARKS)
        .map(|_| Vector3::new(draw.between(3.0, 5.0), draw.between(0.5, 2.5), draw.between(0.3, 1.4)))
        .collect();
    let (mut drive, mut album, mut poses) = (WholeDrive::default(), Album::default(), Vec::new());
    for step in 0..10 {
        let stamp_s = f64::from(step);
        let at = truth.turned(draw, [0.12 * stamp_s, 0.0], 0.0);
        let pose = boxed(draw, at.pose, [0.004, 0.004, 0.003]);
        for (number, landmark) in (0..).map(LandmarkId).zip(&landmarks) {
            let (exact_px, _) = truth.project(&at, *landmark);
            if step == 0 {
                album.add(any_look(), optics.first_seen(&pose, exact_px, [0.0; 2]).unwrap(), stamp_s).unwrap();
            }
            let mut at_px = truth.with_error(draw, exact_px);
            if number == WRONG && step == 3 {
                at_px[1] += 80.0;
            }
            if number != RARE || step < 2 {
                let point = album.point(number).unwrap();
                drive.note(
                    stamp_s,
                    &[Sight {
                        landmark: number,
                        point,
                        at_px,
                        error_px: [truth.camera.error_px; 2],
                        view: None,
                        thing: None,
                    }],
                );
            }
        }
        poses.push((stamp_s, pose));
    }
    Shown { drive, album, optics, poses, landmarks }
}

/// The landmarks that some relations name.
fn named(relations: &dyn Relations, pose: &PoseBox) -> BTreeSet<LandmarkId> {
    let of_point = |(variable, _)| if let Variable::Point(landmark, _) = variable { Some(landmark) } else { None };
    relations.quantities(0, pose).into_iter().filter_map(of_point).collect()
}

#[test]
fn parts_share_no_landmark_and_leave_out_rare_ones_and_sightings_of_something_else() {
    let Shown { drive, album, optics, poses, .. } = shown(&mut Draw::new(20_261_128));
    let parts = drive.parts(&poses, &album, &optics);
    assert_eq!(parts.len(), 2);
    let mut all = BTreeSet::new();
    for part in &parts {
        let of_part: BTreeSet<LandmarkId> =
            part.iter().flat_map(|(stamp_s, one)| named(&**one, &poses[*stamp_s as usize].1)).collect();
        assert!(of_part.len() <= MOST_OF_PART && all.is_disjoint(&of_part));
        all.extend(of_part);
    }
    assert_eq!(all, (0..N_LANDMARKS).map(LandmarkId).collect());
    let stamps_of = |landmark: LandmarkId| -> Vec<f64> {
        let shows = |(stamp_s, one): &&(f64, Arc<dyn Relations>)| {
            named(&**one, &poses[*stamp_s as usize].1).contains(&landmark)
        };
        parts.iter().flatten().filter(shows).map(|(stamp_s, _)| *stamp_s).collect()
    };
    assert_eq!(stamps_of(WRONG), [0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    assert_eq!(stamps_of(LandmarkId(5)).len(), 10);
    // Pictures that are not among those asked for say nothing, nor do forgotten ones.
    let parts = drive.parts(&poses[..5], &album, &optics);
    assert!(parts.iter().flatten().all(|(stamp_s, _)| *stamp_s < 5.0));
    let mut earlier = drive;
    earlier.truncate(2);
    assert!(earlier.parts(&poses, &album, &optics).is_empty());
}

#[test]
fn parts_bound_landmarks_by_all_pictures_and_hold_them() {
    let mut draw = Draw::new(20_261_129);
    for round in 0..rounds(4) {
        let Shown { drive, mut album, optics, poses, landmarks } = shown(&mut draw);
        for part in drive.parts(&poses, &album, &optics) {
            let readings: Vec<(PoseBox, &dyn Relations)> =
                part.iter().map(|(stamp_s, one)| (poses[*stamp_s as usize].1, &**one)).collect();
            let of_part: BTreeSet<LandmarkId> =
                readings.iter().flat_map(|(pose, relations)| named(*relations, pose)).collect();
            let wanted: Vec<Variable> =
                of_part.iter().flat_map(|landmark| (0..3).map(|k| Variable::Point(*landmark, k))).collect();
            let bounds = bounds_over(&readings, &wanted).unwrap();
            album.narrow(&wanted.into_iter().zip(bounds).collect::<Vec<_>>());
        }
        for (number, landmark) in (0..N_LANDMARKS).zip(&landmarks) {
            let point = album.point(LandmarkId(number)).unwrap();
            let expected = homogeneous(&point.anchor, *landmark);
            let holds = (0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k]));
            assert!(holds, "round {round}, {number}: {expected:?} {:?}", point.value);
            // A landmark begins with every depth from 0.4 m on: an inverse depth of 0 to 2.5 per metre.
            assert!(point.value[2].width() < 0.6, "round {round}, {number}: {}", point.value[2]);
        }
    }
}
