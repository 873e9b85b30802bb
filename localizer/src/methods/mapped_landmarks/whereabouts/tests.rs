//! Lines of sight that were worked out by hand, and which landmarks are searched when.

use super::*;
use crate::methods::mapped_landmarks::finding::tests::{Eye, Taken};

/// A line of sight from an eye towards a place, known to 0.02 m and 0.01 rad.
fn bearing(eye_m: [f64; 3], to_m: [f64; 3]) -> Bearing {
    let (eye_m, to_m) = (Vector3::from(eye_m), Vector3::from(to_m));
    Bearing { eye_m, direction: (to_m - eye_m).normalize(), off_m: 0.02, off_per_m: 0.01 }
}

/// Whereabouts of landmarks of the map that have been found elsewhere: their places on the map and their lines of sight.
fn whereabouts(all: &[([f64; 3], Vec<Bearing>)]) -> Whereabouts {
    let taken = Taken::by_first_camera();
    let missing = all.iter().zip(taken.points.iter().zip(&taken.looks)).map(
        |((at_m, bearings), ((landmark, point), (_, look)))| {
            let (look, point, at_m) = (Arc::new(look.clone()), *point, Vector3::from(*at_m));
            (*landmark, Missing { look, point, at_m, bearings: bearings.clone(), searched_in: 0, n_first: 0 })
        },
    );
    Whereabouts { missing: missing.collect(), n_pictures: 0 }
}

/// Eyes along x, 0.4 m apart and 0.3 m high.
fn eyes() -> impl Iterator<Item = [f64; 3]> {
    (0..6).map(|step| [0.4 * f64::from(step), 0.0, 0.3])
}

/// Lines of sight from some eyes towards one place, and from the following ones each towards a place of its own.
fn seen(n_right: usize, n_wrong: usize, place_m: [f64; 3]) -> Vec<Bearing> {
    let right = eyes().take(n_right).map(|eye_m| bearing(eye_m, place_m));
    let wrong = eyes().skip(n_right).take(n_wrong).zip([-1.0, 1.3, -1.7]);
    right.chain(wrong.map(|(eye_m, up_m)| bearing(eye_m, [place_m[0], place_m[1], place_m[2] + up_m]))).collect()
}

#[test]
fn lines_of_sight_that_meet_in_one_place_tell_that_place() {
    let place_m = [1.0, 3.0, 1.2];
    let (met_m, n) = met(&seen(4, 1, place_m)).unwrap();
    assert_eq!(n, 4);
    assert!((met_m - Vector3::from(place_m)).norm() < 1e-9, "{met_m}");
    // Nearly parallel ones tell no place, and what is behind the eye is not seen.
    assert!(met(&[bearing([0.0, 0.0, 0.3], place_m), bearing([0.2, 0.0, 0.3], place_m)]).is_none());
    let away = |eye_m: [f64; 3]| Bearing { direction: -bearing(eye_m, place_m).direction, ..bearing(eye_m, place_m) };
    assert_eq!(met(&eyes().map(away).collect::<Vec<_>>()).map_or(0, |(_, n)| n), 0);
    // From 3 m away a line that is known to 0.02 m and 0.01 rad may pass by 0.05 m.
    let beside = |off_m: f64| bearing([1.0, 0.0, 1.2], [1.0 + off_m, 3.0, 1.2]).agrees(&Vector3::from(place_m));
    assert!(beside(0.049) && !beside(0.052));
}

#[test]
fn the_bounds_of_a_pose_tell_by_how_much_its_lines_of_sight_may_pass() {
    // The wall is 3 m away. A camera that looks along x sees what is 100 px to the left of its middle and 75 px above at a metre to the left and 0.75 m up.
    let eye = Eye { place_m: [0.0, 0.2, 0.3], heading_rad: 0.0, focal_px: 300.0, ..Eye::default() };
    let taken = Taken::by_first_camera();
    let sight = Sight {
        landmark: LandmarkId(0),
        point: taken.points[0].1,
        at_px: [59.5, 44.5],
        error_px: [0.3, 0.6],
        view: None,
        thing: None,
    };
    let pose =
        PoseBox::from([Interval::centred(0.0, 0.03), Interval::centred(0.2, 0.04), Interval::centred(0.0, 0.02)]);
    let one = Bearing::of(&sight, &pose, &eye.finder().optics);
    assert!(one.agrees(&Vector3::new(3.0, 1.2, 1.05)), "{one:?}");
    assert!((one.off_m - 0.025).abs() < 1e-12 && (one.off_per_m - (0.01 + 0.6 / 300.0)).abs() < 1e-12, "{one:?}");
    // Turned to the left by a quarter, it sees along y what it saw along x.
    let turned = PoseBox::from([pose[0], pose[1], Interval::point(std::f64::consts::FRAC_PI_2)]);
    let direction = Bearing::of(&sight, &turned, &eye.finder().optics).direction;
    assert!((direction - Vector3::new(-1.0, 3.0, 0.75).normalize()).norm() < 1e-9, "{direction}");
}

#[test]
fn a_landmark_has_moved_if_nearly_all_its_sightings_agree_and_a_neighbour_moved_with_it() {
    let moved = |all: &[([f64; 3], Vec<Bearing>)]| -> Vec<u32> {
        whereabouts(all).moved().keys().map(|landmark| landmark.0).collect()
    };
    let (at_m, now_m) = ([0.5, 3.0, 1.2], [1.5, 3.0, 1.2]);
    let neighbour = ([0.8, 3.0, 1.2], seen(4, 0, [1.8, 3.0, 1.2]));
    assert_eq!(moved(&[(at_m, seen(4, 0, now_m)), neighbour.clone()]), [0, 1]);
    // Four of five agree, which is enough, and four of six are too few; so are two of two.
    assert_eq!(moved(&[(at_m, seen(4, 1, now_m)), neighbour.clone()]), [0, 1]);
    assert!(moved(&[(at_m, seen(4, 2, now_m)), neighbour.clone()]).is_empty());
    assert!(moved(&[(at_m, seen(2, 0, now_m)), neighbour.clone()]).is_empty());
    // Alone, beside the same corner once more, or with a neighbour that is somewhere else: what looks alike may be seen.
    assert!(moved(&[(at_m, seen(4, 0, now_m))]).is_empty());
    assert!(moved(&[(at_m, seen(4, 0, now_m)), ([0.55, 3.0, 1.2], seen(4, 0, [1.55, 3.0, 1.2]))]).is_empty());
    assert!(moved(&[(at_m, seen(4, 0, now_m)), (neighbour.0, seen(4, 0, [1.8, 2.2, 1.2]))]).is_empty());
    assert!(moved(&[(at_m, seen(4, 0, now_m)), ([1.4, 3.0, 1.2], seen(4, 0, [2.4, 3.0, 1.2]))]).is_empty());
    // Both a decimetre beside their places: these are wrong boxes.
    assert!(moved(&[(at_m, seen(4, 0, [0.6, 3.0, 1.2])), (neighbour.0, seen(4, 0, [0.9, 3.0, 1.2]))]).is_empty());
    // Turned by a quarter and moved, as on another wall.
    assert_eq!(moved(&[(at_m, seen(4, 0, [2.2, 2.6, 1.2])), (neighbour.0, seen(4, 0, [2.2, 2.3, 1.2]))]), [0, 1]);
    let places = whereabouts(&[(at_m, seen(4, 1, now_m)), neighbour]).moved();
    let (place_m, n) = places[&LandmarkId(0)];
    assert!(n == 4 && (Vector3::from(place_m) - Vector3::from(now_m)).norm() < 1e-6, "{place_m:?}");
}

#[test]
fn landmarks_that_are_not_found_are_searched_by_turns() {
    let all: Vec<_> = (0..14).map(|at| ([f64::from(at), 3.0, 1.2], Vec::new())).collect();
    let mut whereabouts = whereabouts(&all);
    let pose = |x_m: f64| PoseBox::from([x_m, 0.0, 0.0].map(Interval::point));
    // Landmark 3 was found half as often as not, 4 not often absent yet, and 5 was never expected.
    let seen = |landmark: LandmarkId| {
        let (n_found, n_absent) = [(4, 8), (0, 3)].get(landmark.0.wrapping_sub(3) as usize).copied().unwrap_or((1, 5));
        let counts = SeenAgain { n_found, n_absent, ..SeenAgain::of(landmark) };
        (landmark.0 != 5).then_some(counts)
    };
    let next = |whereabouts: &mut Whereabouts, x_m: f64| -> (Vec<u32>, Vec<f64>) {
        whereabouts.wanted(&pose(x_m), seen).iter().map(|one| (one.landmark.0, one.size)).unzip()
    };
    let (numbers, sizes) = next(&mut whereabouts, 0.0);
    assert_eq!(numbers, [0, 1, 2, 6, 7, 8, 9, 10, 11, 12]);
    let (numbers, other_sizes) = next(&mut whereabouts, 0.0);
    assert_eq!(numbers, [13, 0, 1, 2, 6, 7, 8, 9, 10, 11]);
    assert!(sizes.iter().all(|size| *size != other_sizes[0]) && sizes[0] == sizes[9], "{sizes:?} {other_sizes:?}");
    // One that was found is searched again from another place, until it was found from twelve.
    for step in 0..12 {
        let x_m = 0.2 * f64::from(step);
        whereabouts.missing.get_mut(&LandmarkId(13)).unwrap().bearings.push(bearing([x_m, 0.0, 0.3], [2.0, 3.0, 1.0]));
        assert!((0..3).all(|_| !next(&mut whereabouts, x_m + 0.09).0.contains(&13)), "{step}");
        let is_searched = (0..3).any(|_| next(&mut whereabouts, x_m + 0.11).0.contains(&13));
        assert_eq!(is_searched, step < 11, "{step}");
    }
}

#[test]
fn sightings_of_a_landmark_are_kept_from_different_places_and_not_too_many() {
    let mut whereabouts = whereabouts(&[([0.5, 3.0, 1.2], Vec::new())]);
    let optics = Eye { place_m: [0.0, 0.0, 0.3], focal_px: 300.0, ..Eye::default() }.finder().optics;
    let point = whereabouts.missing[&LandmarkId(0)].point;
    let sight =
        Sight { landmark: LandmarkId(0), point, at_px: [59.5, 44.5], error_px: [0.3; 2], view: None, thing: None };
    let n_kept = |whereabouts: &mut Whereabouts, x_m: f64| {
        whereabouts.keep(&[&sight], &PoseBox::from([x_m, 0.0, 0.0].map(Interval::point)), &optics);
        whereabouts.missing[&LandmarkId(0)].bearings.len()
    };
    assert_eq!([0.0, 0.06, 0.11, 0.17, 0.22].map(|x_m| n_kept(&mut whereabouts, x_m)), [1, 1, 2, 2, 3]);
    assert_eq!((1..20).map(|step| n_kept(&mut whereabouts, f64::from(step))).max(), Some(12));
}

#[test]
fn a_landmark_is_searched_first_once_a_neighbour_was_found_elsewhere() {
    // The last two are half a metre apart, all others a metre.
    let place_m = |at: u8| [f64::from(at) - if at == 13 { 0.5 } else { 0.0 }, 3.0, 1.2];
    let mut whereabouts = whereabouts(&(0..14).map(|at| (place_m(at), Vec::new())).collect::<Vec<_>>());
    let optics = Eye { place_m: [0.0, 0.0, 0.3], focal_px: 300.0, ..Eye::default() }.finder().optics;
    let point = whereabouts.missing[&LandmarkId(13)].point;
    let sight =
        Sight { landmark: LandmarkId(13), point, at_px: [59.5, 44.5], error_px: [0.3; 2], view: None, thing: None };
    let pose = PoseBox::from([Interval::ZERO; 3]);
    whereabouts.keep(&[&sight], &pose, &optics);
    let seen = |landmark| Some(SeenAgain { n_absent: 4, ..SeenAgain::of(landmark) });
    // Landmark 13 itself is not searched from the same place again. Of the others, 12 is searched at each size, and then by turns.
    let firsts: Vec<u32> = (0..6).map(|_| whereabouts.wanted(&pose, seen)[0].landmark.0).collect();
    assert_eq!(firsts[..4], [12; 4]);
    assert!(firsts[4..].iter().all(|landmark| *landmark != 12), "{firsts:?}");
}
