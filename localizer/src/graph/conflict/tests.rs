//! Tests of the search for names: what it names, and what it leaves out.

use std::collections::BTreeMap;

use super::*;
use crate::graph::{Constant, Domain, Row, Variable, related::Origin, trial::Draw};

/// A program over the x of three poses, each between −10 and 10 m, and the track, which is 1 ± 0.001 m.
fn related(rows: Vec<Row>) -> Related {
    let mut domain = Domain::default();
    (0..3).for_each(|frame| domain.put(Variable::Pose(frame, 0), Interval::new(-10.0, 10.0)));
    domain.put(Variable::Constant(Constant::Track), Interval::centred(1.0, 0.001));
    let rows =
        rows.into_iter().enumerate().map(|(at, row)| (row, Origin::over([at as f64, at as f64 + 1.0]))).collect();
    Related::new(domain, rows, BTreeMap::new()).unwrap()
}

/// A row that the x of pose 0, with so many times the deviation of the track, is within half of the middle, with the parts given.
fn row(tracks: f64, middle: f64, half: f64, device: &'static str, parts: &[(Assumption, f64)]) -> Row {
    let terms = vec![(Variable::Pose(0, 0), 1.0), (Variable::Constant(Constant::Track), tracks)];
    let row = Row { terms, sides: Interval::centred(middle, half), parts: Vec::new(), devices: Vec::new() };
    row.with_parts(1.0, parts).by_device(device)
}

fn found(related: Related) -> Option<Conflict> {
    let mut search = ConflictSearch::new(related);
    let mut n_calls = 0;
    while !search.advance() {
        n_calls += 1;
        assert!(n_calls < 5000);
    }
    search.found().cloned()
}

#[test]
fn only_what_is_needed_for_the_contradiction_is_named() {
    // By the wheels x is 1 ± 0.1, by the flow sensor 2 ± 0.1: 0.8 apart. Neither the track, of which a hundredfold bound moves the row by 0.1, nor
    // the gyroscope, which says nothing else, can resolve that.
    let rows = vec![
        row(1.0, 1.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]),
        row(0.0, 2.0, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]),
        row(0.0, 1.5, 5.0, "gyro", &[(bounds::GYRO_NOISE, 5.0)]),
    ];
    let found = found(related(rows)).unwrap();
    assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::FLOW_SCALE]);
    assert_eq!(found.factor, Some(100.0));
    let wheels = Readings { device: "wheels", span_s: [0.0, 1.0] };
    assert_eq!(found.readings, [Readings { device: "flow", span_s: [1.0, 2.0] }, wheels]);
}

#[test]
fn at_most_three_bounds_are_named_with_the_greatest_factor_that_allows_it() {
    // Two rows, each with two parts of 0.1, that are 0.12 apart. Made wider threefold, each part alone resolves that; twofold, it takes two of
    // them, so that the first one stays wide and the three others are named.
    let parts = |a, b| [(a, 0.1), (b, 0.1)];
    let rows = vec![
        row(0.0, 0.0, 0.2, "wheels", &parts(bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP)),
        row(0.0, 0.52, 0.2, "flow", &parts(bounds::FLOW_SCALE, bounds::FLOW_POSITION)),
    ];
    let found = found(related(rows)).unwrap();
    assert_eq!(found.factor, Some(2.0));
    assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, bounds::FLOW_SCALE]);
}

#[test]
fn what_was_known_before_is_named_only_where_the_contradiction_needs_it() {
    // The box of pose 0 is by nothing in the program: x is within 10 m. By the wheels it is 1012 ± 0.1: a box a hundred times as wide, or slip a
    // hundred times as great, resolves that if it is slip of 11 m. By the flow sensor it is 1012 ± 0.1, too, so that only the box is left.
    let wheels = || row(0.0, 900.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]);
    let by_one = found(related(vec![wheels()])).unwrap();
    assert!(by_one.is_earlier && by_one.bounds.is_empty() && by_one.factor == Some(100.0), "{by_one:?}");
    // Of two rows that contradict each other by themselves the box says nothing.
    let other = row(0.0, 5.0, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]);
    let nearer = row(0.0, 3.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]);
    let by_two = found(related(vec![nearer, other])).unwrap();
    assert!(!by_two.is_earlier && by_two.bounds == [bounds::WHEELS_SLIP, bounds::FLOW_SCALE], "{by_two:?}");
}

#[test]
fn what_displaces_a_reading_is_named_by_the_bounds_that_make_it() {
    // A reading shows a pose that is displaced by up to 0.02 m by the body's tilt: x is 1.06 ± 0.001 less the displacement. By the wheels it is
    // 1 ± 0.01. A displacement of 0.049 m, made by 2.5 times the tilt, resolves that, and so does five times the slip.
    let (x, shift) = (Variable::Pose(0, 0), Variable::Shift(0, 0));
    let mut domain = Domain::default();
    domain.put(x, Interval::new(-10.0, 10.0));
    domain.put(shift, Interval::centred(0.0, 0.02));
    let shown = |middle: f64, half: f64, terms: &[(Variable, f64)]| Row {
        terms: terms.to_vec(),
        sides: Interval::centred(middle, half),
        parts: Vec::new(),
        devices: Vec::new(),
    };
    let reading = shown(1.06, 0.001, &[(x, 1.0), (shift, 1.0)]).with_part(bounds::RANGE_CAMERA_COLUMNS, 0.001);
    let way = shown(1.0, 0.01, &[(x, 1.0)]).with_part(bounds::WHEELS_SLIP, 0.01);
    let rows = vec![(reading, Origin::over([1.0; 2])), (way, Origin::over([0.0, 1.0]))];
    let mut related = Related::new(domain, rows, BTreeMap::new()).unwrap();
    related.made_by.insert(shift, vec![(Suspect::Bound(bounds::BODY_TILT), 0.02)]);
    let found = found(related).unwrap();
    assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::BODY_TILT, bounds::RANGE_CAMERA_COLUMNS]);
}

#[test]
fn a_row_that_says_nothing_without_a_bound_names_it() {
    // x is 5 ± 0.01 if the code of the one reading is right, and 1 ± 0.01 by the wheels.
    let rows = [
        (row(0.0, 5.0, 0.01, "range_camera", &[(bounds::RANGE_CAMERA_COLUMNS, 0.01)]), true),
        (row(0.0, 1.0, 0.01, "wheels", &[(bounds::WHEELS_SLIP, 0.01)]), false),
    ];
    let rows = rows.map(|(row, has_code)| {
        let void_without = has_code.then_some(bounds::RANGE_LANDMARKS_Q_ITEMS);
        (row, Origin { void_without, ..Origin::over([1.0; 2]) })
    });
    let mut domain = Domain::default();
    domain.put(Variable::Pose(0, 0), Interval::new(-10.0, 10.0));
    domain.put(Variable::Constant(Constant::Track), Interval::centred(1.0, 0.001));
    let found = found(Related::new(domain, rows.to_vec(), BTreeMap::new()).unwrap()).unwrap();
    assert_eq!(found.bounds, [bounds::RANGE_LANDMARKS_Q_ITEMS]);
    assert_eq!((found.factor, found.is_earlier), (Some(100.0), false));
}

#[test]
fn rows_that_agree_name_nothing() {
    let rows = vec![
        row(0.0, 1.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]),
        row(0.0, 1.1, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]),
    ];
    assert_eq!(found(related(rows)), None);
}

#[test]
fn the_broken_bound_is_named_unless_it_is_exceeded_by_more_than_the_factor() {
    let mut draw = Draw::new(20_261_124);
    let names = [
        bounds::WHEELS_SLIP,
        bounds::WHEELS_SIDE_SLIP,
        bounds::FLOW_SCALE,
        bounds::GYRO_NOISE,
        bounds::FLOW_POSITION,
        bounds::BODY_TILT,
    ];
    let (mut n_found, mut n_proven) = (0, 0);
    for round in 0..400 {
        let broken = names[round % names.len()];
        let exceeded = draw.size(1.1, 60.0);
        let truth = [0; 3].map(|_| draw.between(-1.0, 1.0));
        // Each row is a sum of two poses with errors of two bounds, one of which is exceeded in one sense or the other.
        let rows = (0..12).map(|at| {
            let terms: Vec<(Variable, f64)> =
                (0..2).map(|term| (Variable::Pose((at + term) % 3, 0), draw.between(-2.0, 2.0))).collect();
            let parts = [names[at % 6], names[(at + 1 + at / 6) % 6]].map(|name| (name, draw.size(1e-3, 0.1)));
            let value: f64 = (0..2).map(|term| terms[term].1 * truth[(at + term) % 3]).sum();
            let error: f64 = parts
                .iter()
                .map(|&(name, half)| {
                    let most = if name == broken { half * exceeded } else { half };
                    draw.within(Interval::centred(0.0, most))
                })
                .sum();
            let half: f64 = parts.iter().map(|part| part.1).sum();
            let row = Row {
                terms,
                sides: Interval::centred(value + error, half * (1.0 + 1e-9)),
                parts: Vec::new(),
                devices: Vec::new(),
            };
            row.with_parts(1.0, &parts).by_device("wheels")
        });
        let Some(conflict) = found(related(rows.collect())) else { continue };
        n_found += 1;
        n_proven += usize::from(conflict.factor.is_some());
        assert!((1..=3).contains(&conflict.bounds.len()), "round {round}: {conflict:?}");
        let is_named = conflict.bounds.contains(&broken);
        assert!(
            is_named || conflict.factor.is_none_or(|factor| exceeded > factor),
            "round {round}: {broken} by {exceeded}, {conflict:?}"
        );
    }
    assert!(n_found > 150 && n_proven * 20 > n_found * 19, "{n_proven} of {n_found}");
}
