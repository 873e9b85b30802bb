//! Tests of the gyroscope's bias, which the localizer learns between fixes of the heading and unlearns when an assumption is doubted.

#![allow(clippy::unwrap_used)]

use interval::{
    Interval,
    contractor::{Contractor, Outcome},
};

use crate::{
    Constraint, Localizer, Map, Method, PoseBox, Reading, RobotModel,
    method::Context,
    robot::{BodyModel, GyroModel, Reach, WheelModel},
};

const BIAS_RAD_PER_S: f64 = 0.0042;
const FIX_RAD: f64 = 0.002;
const NOISE_RAD_PER_S: f64 = 0.0005;

/// Test method that bounds the heading at each range reading: near 0 at first, and near 0.3 rad from `wrong_from_s` on.
struct Compass {
    wrong_from_s: f64,
    /// Whether the interval of the heading is ten times as wide, except at the readings within one second of every five.
    mostly_wide: bool,
}

impl Method for Compass {
    fn name(&self) -> &'static str {
        "compass"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let says_rad = if reading.measured_s() < self.wrong_from_s { 0.0 } else { 0.3 };
        let is_wide = self.mostly_wide && reading.measured_s().ceil() % 5.0 != 3.0;
        let radius_rad = if is_wide { 10.0 * FIX_RAD } else { FIX_RAD };
        let heading = Heading(Interval::centred(says_rad, radius_rad));
        Some(Constraint::new(self.name(), reading.measured_s(), heading))
    }
}

/// Contractor that keeps the heading in an interval.
struct Heading(Interval);

impl Contractor<3> for Heading {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        domain[2] = domain[2].intersect(self.0);
        if domain.is_empty() { Outcome::Empty("elsewhere") } else { Outcome::Feasible }
    }
}

/// A stand-in for a method that bounds the heading: it is never wrong, and gives equally narrow headings at every reading.
const RIGHT: Compass = Compass { wrong_from_s: f64::INFINITY, mostly_wide: false };

/// Intervals of the gyroscope's bias after each second, for a robot that stands still. It gets a heading fix every second, at a stamp at
/// which no period of the gyroscope ends.
fn biases(lasts_s: f64, wrong_from_s: f64, wander_rad_per_s2: Option<f64>) -> Vec<Interval> {
    biases_by(Compass { wrong_from_s, mostly_wide: false }, lasts_s, wander_rad_per_s2)
}

fn biases_by(compass: Compass, lasts_s: f64, wander_rad_per_s2: Option<f64>) -> Vec<Interval> {
    let mut known = Vec::new();
    drive(
        wander_rad_per_s2.map(|wander| (wander, None)),
        compass,
        lasts_s,
        |_| 0,
        |second, localizer| {
            let measured_s = second - 0.0043;
            localizer.observe(&Reading::Range { measured_s, arrived_s: second, sightings: Vec::new() });
            known.push(known_bias(localizer));
        },
    );
    known
}

/// The gyroscope's bias as the localizer knows it at present: the declared one unless it learns it.
fn known_bias(localizer: &Localizer) -> Interval {
    let declared = localizer.robot.gyro.unwrap().bias_rad_per_s;
    localizer.fixes.as_ref().map_or(declared, |fixes| fixes.bias_over(0.0, localizer.now_s))
}

/// Feeds a localizer with the gyroscope readings and encoder counts of a robot that does not turn; `look` is called each second.
fn drive(
    learns: Option<(f64, Option<f64>)>,
    compass: Compass,
    lasts_s: f64,
    ticks: impl Fn(f64) -> i64,
    mut look: impl FnMut(f64, &mut Localizer),
) {
    let gyro = GyroModel {
        bias_rad_per_s: Interval::centred(0.0, 0.01),
        scale: Interval::centred(1.0, 0.002),
        noise_rad_per_s: NOISE_RAD_PER_S,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: learns.map_or(0.0, |(wander_rad_per_s2, _)| wander_rad_per_s2),
        period_s: 0.01,
    };
    // The declared slip of the wheels is so great that only heading fixes, and not the wheels, say how far the robot turned.
    let wheels = WheelModel {
        radius_m: [Interval::centred(0.0975, 0.0002); 2],
        track_m: Interval::centred(0.33, 0.001),
        ticks_per_turn: 19_150.0,
        slip_ratio: 0.005,
        slip_floor_m: 0.01,
        side_slip_ratio: 0.003,
        side_slip_floor_m: 0.00005,
        slip_window_s: 0.2,
    };
    let robot = RobotModel {
        wheels,
        reach: Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 },
        body: BodyModel { tilt_rad: 0.004, heave_m: 0.0, clearance_m: 0.0 },
        floor_camera: None,
        ceiling_camera: None,
        forward_camera: None,
        gyro: Some(gyro),
        flow: None,
        range_camera: None,
        steering: None,
    };
    let room = Interval::new(-5.0, 5.0);
    let map = Map { room_m: [room, room], tiles: None, markers: None, wall_directions_rad: Vec::new(), walls: None };
    let start = PoseBox::from([Interval::ZERO, Interval::ZERO, Interval::centred(0.0, FIX_RAD)]);
    let mut localizer = Localizer::new(map, robot, vec![Box::new(compass)], start);
    if let Some((_, rest_turn_rad)) = learns {
        localizer = localizer.learning_gyro(rest_turn_rad);
    }
    for step in 1..=(lasts_s * 100.0) as usize {
        let time_s = step as f64 * 0.01;
        let noise = if step % 3 == 0 { NOISE_RAD_PER_S } else { -0.9 * NOISE_RAD_PER_S };
        let rate_rad_per_s = BIAS_RAD_PER_S + noise;
        localizer.observe(&Reading::Gyro { measured_s: time_s, arrived_s: time_s, rate_rad_per_s });
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [ticks(time_s); 2] });
        if step % 100 == 0 {
            look(time_s, &mut localizer);
        }
    }
}

#[test]
fn fixes_of_the_heading_narrow_the_bias_to_noise_and_width_over_time() {
    let known = biases(20.0, f64::INFINITY, Some(0.0));
    assert!(known.iter().all(|bias| bias.contains(BIAS_RAD_PER_S)), "{known:?}");
    // 19 s pass from the first heading fix to the last one. The expected half-width of the gyroscope's bias is the bound on its noise plus half of a
    // fix's width at either end over that time, plus a little for incomplete periods of the gyroscope.
    let expected = 2.0 * (NOISE_RAD_PER_S + 2.0 * FIX_RAD / 19.0);
    let width = known[19].width();
    assert!(width <= 1.05 * expected && width > 0.5 * expected, "{width} rad/s wide, expected {expected}");
    assert_eq!(biases(3.0, f64::INFINITY, None)[2], Interval::centred(0.0, 0.01));
    // If the gyroscope's bias may wander, its interval must be wider by as much as the bias may have wandered since the heading fixes.
    let wandering = biases(20.0, f64::INFINITY, Some(1e-4));
    assert!(wandering.iter().all(|bias| bias.contains(BIAS_RAD_PER_S)) && wandering[19].width() > 1.3 * width);
}

#[test]
fn the_narrowest_heading_of_each_while_is_kept() {
    let known = biases_by(Compass { mostly_wide: true, ..RIGHT }, 23.5, Some(0.0));
    assert!(known.iter().all(|bias| bias.contains(BIAS_RAD_PER_S)), "{known:?}");
    // Narrow heading fixes come within one second of every five. The bias must be learnt from the turn between the narrow fix at 3 s, or the start,
    // and the narrow fix at 23 s.
    let expected = 2.0 * (NOISE_RAD_PER_S + 2.0 * FIX_RAD / 20.0);
    let width = known[22].width();
    assert!(width <= 1.1 * expected && width > 0.5 * expected, "{width} rad/s wide, expected {expected}");
}

#[test]
fn a_doubt_takes_back_what_the_last_seconds_taught_of_the_bias() {
    let known = biases(20.0, 19.5, Some(0.0));
    // At 20 s a wrong heading makes the localizer doubt, which takes back what was learnt about the gyroscope's bias in the last 3 s.
    assert!(known[19].width() > known[18].width(), "{known:?}");
    assert!(known[19].width() <= known[15].width() + 1e-12, "{known:?}");
    assert!(known.iter().all(|bias| bias.contains(BIAS_RAD_PER_S)), "{known:?}");
}

#[test]
fn encoders_at_rest_narrow_the_bias_to_noise_and_the_turn_they_may_hide() {
    let rest_turn_rad = 0.002;
    let known = |ticks: &dyn Fn(f64) -> i64, rest_turn_rad: Option<f64>| {
        let mut known = Vec::new();
        drive(Some((0.0, rest_turn_rad)), RIGHT, 11.0, ticks, |_, localizer| {
            known.push(known_bias(localizer));
        });
        known
    };
    let at_rest = known(&|_| 0, Some(rest_turn_rad));
    assert!(at_rest.iter().all(|bias| bias.contains(BIAS_RAD_PER_S)), "{at_rest:?}");
    // By hand: half of the bias's width is the bound on the gyroscope's noise, plus the turn that encoders at rest may hide (as declared) over the
    // elapsed time, counted from 0.5 s after the first encoder reading.
    let expected = 2.0 * (NOISE_RAD_PER_S + rest_turn_rad / 9.5);
    let width = at_rest[10].width();
    assert!(width <= 1.1 * expected && width > 0.8 * expected, "{width} rad/s wide, expected {expected}");
    // Nothing about the bias is learnt at rest unless a turn that encoders at rest may hide is declared, and nothing is learnt while the wheels turn.
    for as_declared in [known(&|_| 0, None), known(&|time_s| (time_s * 20.0) as i64, Some(rest_turn_rad))] {
        assert!((as_declared[10].width() - 0.02).abs() < 1e-9, "{as_declared:?}");
    }
}

#[test]
fn a_heading_fixed_once_is_carried_on_without_a_toll_at_every_slot() {
    let width = |learns: Option<(f64, Option<f64>)>| {
        let mut width = 0.0;
        drive(
            learns,
            RIGHT,
            20.0,
            |_| 0,
            |_, localizer| {
                let heading = localizer.estimate().pose.hull()[2];
                assert!(heading.contains(0.0), "{heading:?}");
                width = heading.width();
            },
        );
        width
    };
    // By hand, the heading's width after 20 s: 0.004 rad at the start, then 20 s of the gyroscope's bias and noise, 0.0105 rad/s to either side, over
    // a scale of 0.998.
    let carried = width(Some((0.0, None)));
    let expected = 2.0 * FIX_RAD + 20.0 * 2.0 * (0.01 + NOISE_RAD_PER_S) / 0.998;
    assert!(carried < 1.02 * expected && carried > 0.9 * expected, "{carried}, expected {expected}");
    assert!(width(None) >= carried - 1e-9);
}

#[test]
fn a_bias_that_wanders_is_known_the_less_the_longer_nothing_fixes_the_heading() {
    let mut widths = Vec::new();
    let last_fix_s = 10.0;
    drive(
        Some((1e-3, None)),
        RIGHT,
        20.0,
        |_| 0,
        |second, localizer| {
            if second <= last_fix_s {
                let measured_s = second - 0.0043;
                localizer.observe(&Reading::Range { measured_s, arrived_s: second, sightings: Vec::new() });
            }
            widths.push(localizer.estimate().pose.hull()[2].width());
        },
    );
    // By hand: after the last heading fix, each second adds the gyroscope's bias and noise to the heading's width, and the bias may be 0.001 rad/s
    // farther off than in the second before.
    let grown = |second: usize| widths[second] - widths[second - 1];
    assert!(grown(14) > grown(12) + 0.001, "{} and {}", grown(12), grown(14));
}
