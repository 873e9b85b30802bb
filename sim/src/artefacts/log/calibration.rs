//! Calibration by a log with true poses: the constants of wheels, gyroscope and antenna, and the least bounds that the whole log keeps.

mod spans;
mod text;

use std::path::Path;

use localizer::{
    bounds::{self, Assumption},
    calibration::{
        TOLERATED_DEVIATIONS,
        constants::{Constants, LEAST_SPANS, Span, Undetermined, constants},
    },
    motion::SlipExcess,
};
use serde_json::{Value, json};

use super::{
    LogError,
    motion::{self, Motion},
    open_log::OpenLog,
    tightness::tightness,
    truth::TruePath,
};
use crate::{
    loading::{SceneTemplate, Setting},
    scene::{LoggedTruth, Scene},
};

/// What spans of the wheels are called.
const WHEELS: &str = "wheels";
/// How a log is used for calibration.
#[derive(Clone, Copy, Debug)]
pub struct Calibrating {
    /// Length of the spans into which the drive is divided. In longer spans the errors of the true poses count less.
    pub span_s: f64,
    /// Factor by which bounds are declared greater than the least that the log keeps, as the next drive may need more.
    pub margin: f64,
}

/// What a drive with known true poses tells about a robot.
#[derive(Clone, Debug)]
pub struct DriveCalibration {
    /// Constants, each with what is to be declared of it.
    pub constants: Vec<FoundConstant>,
    /// Bounds on what no constant explains.
    pub bounds: Vec<FoundBound>,
    /// What could not be found, and why.
    pub unknown: Vec<String>,
    /// Spans that fit no constants: something else acted in them.
    pub set_aside: Vec<SetAside>,
    /// Number of spans of the drive.
    pub n_spans: usize,
}

/// A constant of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundConstant {
    /// What it is, for people.
    pub name: &'static str,
    /// Unit of all values.
    pub unit: &'static str,
    /// The nominal value that the robot's file declares.
    pub declared: f64,
    /// The value that the drive tells.
    pub value: f64,
    /// Its standard deviation, by the jackknife over ten blocks of the drive.
    pub deviation: f64,
    /// Keys of the scene that state it, with their values: the nominal value, if there is a key of it, and the tolerance.
    pub keys: Vec<Setting>,
}

/// A bound, with the least value that the log keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundBound {
    /// Name of the bound.
    pub bound: Assumption,
    /// The key that states it.
    pub key: &'static str,
    /// Value that the robot's file declares.
    pub declared: f64,
    /// Least value that nothing in the log exceeds for certain; `None` where no value is enough, as for a robot that is pushed while its wheels stand.
    pub least: Option<f64>,
    /// Value to be declared: the least one times the margin, or what was declared where the log says nothing against 0.
    pub value: f64,
}

/// A span that was set aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetAside {
    /// What it does not fit.
    pub what: &'static str,
    /// When it begins and ends, in seconds since the log's first reading of the wheels.
    pub span_s: [f64; 2],
    /// By how much it is off, in the unit of `what`: metres, or radians for the gyroscope.
    pub off: f64,
}

/// A bound that the log is compared with, the key that states it, and its value in a scene.
type BoundKey = (Assumption, &'static str, fn(&Scene) -> Option<f64>);

/// The bounds whose least values are found. Those on the robot's reach are not among them: a drive that is slower than the robot can be does not tell
/// them, and the replay of a log says where they are exceeded.
const BOUND_KEYS: [BoundKey; 4] = [
    (bounds::WHEELS_SLIP, "bounds.slip_ratio", |scene| Some(scene.bounds.slip_ratio)),
    (bounds::WHEELS_SIDE_SLIP, "bounds.side_slip_ratio", |scene| Some(scene.bounds.side_slip_ratio)),
    (bounds::GNSS_FIXED, "robot.gnss.fixed_tolerance_m", |scene| Some(scene.robot.gnss.as_ref()?.fixed_tolerance_m)),
    (bounds::GNSS_FLOATING, "robot.gnss.floating_tolerance_m", |scene| {
        Some(scene.robot.gnss.as_ref()?.floating_tolerance_m)
    }),
];

/// Calibrates the robot of the file `robot` by a log of a drive with true poses.
pub fn calibrate_drive(robot: &SceneTemplate, path: &Path, how: &Calibrating) -> Result<DriveCalibration, LogError> {
    let log = OpenLog::read(robot.file(), path)?;
    let unusable = |found: String| LogError::Uncalibrated { log: path.to_owned(), found };
    let (truth, keys) = log.truth.as_ref().zip(log.keys.truth.as_ref()).ok_or_else(|| {
        unusable(
            "`log.truth` is missing, expected where the true poses are: a calibration compares readings with them"
                .to_owned(),
        )
    })?;
    let ends_s = log.motion.readings.last().map_or(0.0, localizer::Reading::measured_s);
    truth.overlaps(ends_s).map_err(unusable)?;
    let mut found = DriveCalibration {
        constants: Vec::new(),
        bounds: Vec::new(),
        unknown: Vec::new(),
        set_aside: Vec::new(),
        n_spans: 0,
    };
    // Each end of a span has the true poses' error along both axes.
    let by_truth_m = 2.0 * std::f64::consts::SQRT_2 * keys.tolerance_m;
    if log.gathered.odometry.is_empty() {
        let spans = spans::of_wheels(&log, truth, how.span_s);
        found.n_spans = spans.len();
        let told =
            found.keep(WHEELS, &spans, by_truth_m, &["radius of the left wheel", "radius of the right wheel", "track"]);
        found.constants.extend(told.iter().flat_map(|fit| wheels(fit, &log.told)));
    } else {
        found.unknown.push("wheels: the log has odometry in place of the wheels' angles".to_owned());
    }
    if let Some(gyro) = &log.told.robot.gyro {
        let spans = spans::of_gyro(&log, truth, gyro.period_s, how.span_s);
        let told = found.keep("gyroscope", &spans, 2.0 * keys.tolerance_deg.to_radians(), &["scale", "bias"]);
        found.constants.extend(told.iter().flat_map(gyroscope));
    }
    if let Some(receiver) = &log.told.robot.gnss {
        let spans = spans::of_antenna(&log, truth);
        let told = found.keep("antenna", &spans, by_truth_m, &["place forward", "place to the left"]);
        found.constants.extend(told.iter().flat_map(|fit| antenna(fit, [receiver.forward_m, receiver.left_m])));
    }
    if found.constants.is_empty() {
        return Err(unusable(found.unknown.join("; ")));
    }
    let calibrated = motion::told(&robot.with(&found.settings())?.scene, log.keys, &log.gathered);
    let aside_s: Vec<[f64; 2]> =
        found.set_aside.iter().filter(|one| one.what == WHEELS).map(|one| one.span_s).collect();
    found.bounds = least_bounds(&calibrated, &log, truth, keys, &aside_s, how.margin);
    Ok(found)
}

impl DriveCalibration {
    /// The constants that fit the spans, after noting which spans were set aside, or what is unknown and why. The true poses' own errors may put a
    /// span off by `by_truth`.
    fn keep<const N: usize>(
        &mut self,
        what: &'static str,
        spans: &[Span<N>],
        by_truth: f64,
        names: &[&str; N],
    ) -> Option<Constants<N>> {
        match constants(spans, by_truth) {
            Ok(fit) => {
                let aside = fit.set_aside.iter();
                self.set_aside.extend(aside.map(|(at, off)| SetAside { what, span_s: spans[*at].span_s, off: *off }));
                Some(fit)
            }
            Err(Undetermined::FewSpans(n_spans)) => {
                self.unknown.push(format!("{what}: {n_spans} spans with true poses, expected at least {LEAST_SPANS}, of a longer drive or by a smaller --span-s"));
                None
            }
            Err(Undetermined::Constant(place)) => {
                let name = names[place];
                self.unknown.push(format!(
                    "{what}: the drive does not tell the {name}, expected one with straight ways and turns"
                ));
                None
            }
        }
    }

    /// All keys of the scene with the values to be declared.
    pub fn settings(&self) -> Vec<Setting> {
        let constants = self.constants.iter().flat_map(|one| one.keys.iter().cloned());
        constants.chain(self.bounds.iter().map(|one| Setting::number(one.key, one.value))).collect()
    }

    /// All that was found, as JSON.
    pub fn to_json(&self) -> Value {
        let constants: Vec<Value> = self
            .constants
            .iter()
            .map(|one| {
                json!({
                    "name": one.name, "unit": one.unit, "declared": one.declared, "value": one.value, "deviation": one.deviation,
                })
            })
            .collect();
        let bounds = self.bounds.iter().map(|one| {
            json!({ "bound": one.bound, "key": one.key, "declared": one.declared, "least": one.least, "value": one.value })
        });
        let set_aside = self.set_aside.iter();
        json!({
            "spans": self.n_spans,
            "constants": constants,
            "bounds": bounds.collect::<Vec<_>>(),
            "unknown": self.unknown,
            "set_aside": set_aside.map(|one| json!({ "what": one.what, "from_s": one.span_s[0], "to_s": one.span_s[1], "off": one.off }))
                .collect::<Vec<_>>(),
            "keys": self.settings().into_iter().map(|one| (one.key, json!(one.value))).collect::<serde_json::Map<_, _>>(),
        })
    }
}

/// Radii and track: one nominal radius stands for both wheels, so that its tolerance covers half of their difference.
fn wheels(fit: &Constants<3>, told: &Scene) -> Vec<FoundConstant> {
    let base = &told.robot.base;
    let [left_m, right_m, half_track_m] = fit.values;
    let (radius_m, track_m) = (0.5 * (left_m + right_m), 2.0 * half_track_m);
    let off_m = 0.5 * (left_m - right_m).abs() + TOLERATED_DEVIATIONS * fit.deviations[0].max(fit.deviations[1]);
    let radius = |name, value, deviation, keys| FoundConstant {
        name,
        unit: "m",
        declared: base.wheel_radius_m,
        value,
        deviation,
        keys,
    };
    let keys = vec![
        Setting::number("robot.base.wheel_radius_m", radius_m),
        Setting::number("robot.base.wheel_radius_tolerance", off_m / radius_m),
    ];
    let deviation = 2.0 * fit.deviations[2];
    vec![
        radius("radius of the left wheel", left_m, fit.deviations[0], keys),
        radius("radius of the right wheel", right_m, fit.deviations[1], Vec::new()),
        FoundConstant {
            name: "track",
            unit: "m",
            declared: base.track_m,
            value: track_m,
            deviation,
            keys: vec![
                Setting::number("robot.base.track_m", track_m),
                Setting::number("robot.base.track_tolerance", TOLERATED_DEVIATIONS * deviation / track_m),
            ],
        },
    ]
}

/// Scale and bias of the gyroscope, whose nominal values are 1 and 0 and have no keys.
fn gyroscope(fit: &Constants<2>) -> Vec<FoundConstant> {
    let [scale, bias_deg_per_s] = [fit.values[0], fit.values[1].to_degrees()];
    let [scale_deviation, bias_deviation] = [fit.deviations[0], fit.deviations[1].to_degrees()];
    let within = |off: f64, deviation: f64| off.abs() + TOLERATED_DEVIATIONS * deviation;
    vec![
        FoundConstant {
            name: "scale of the gyroscope",
            unit: "1",
            declared: 1.0,
            value: scale,
            deviation: scale_deviation,
            keys: vec![Setting::number("robot.gyro.scale_tolerance", within(scale - 1.0, scale_deviation))],
        },
        FoundConstant {
            name: "bias of the gyroscope",
            unit: "°/s",
            declared: 0.0,
            value: bias_deg_per_s,
            deviation: bias_deviation,
            keys: vec![Setting::number("robot.gyro.bias_tolerance_deg_per_s", within(bias_deg_per_s, bias_deviation))],
        },
    ]
}

/// Place of the satellite receiver's antenna on the robot.
fn antenna(fit: &Constants<2>, declared_m: [f64; 2]) -> Vec<FoundConstant> {
    let place = |axis: usize, name, keys| FoundConstant {
        name,
        unit: "m",
        declared: declared_m[axis],
        value: fit.values[axis],
        deviation: fit.deviations[axis],
        keys,
    };
    let within_m = TOLERATED_DEVIATIONS * fit.deviations[0].max(fit.deviations[1]);
    vec![
        place(0, "antenna, forward", vec![Setting::number("robot.gnss.forward_m", fit.values[0])]),
        place(
            1,
            "antenna, to the left",
            vec![
                Setting::number("robot.gnss.left_m", fit.values[1]),
                Setting::number("robot.gnss.position_tolerance_m", within_m),
            ],
        ),
    ]
}

/// The least bounds that the log keeps with the calibrated constants.
///
/// Spans in which the wheels fit no constants, `aside_s`, are left out: a bound that covers a push would cover everything.
fn least_bounds(
    calibrated: &Scene,
    log: &OpenLog<'_>,
    truth: &TruePath,
    keys: &LoggedTruth,
    aside_s: &[[f64; 2]],
    margin: f64,
) -> Vec<FoundBound> {
    let mut motion = Motion::of(&log.gathered, log.zero_ns, calibrated, log.keys);
    motion.excesses.extend(aside_s.iter().map(|span_s| SlipExcess { span_s: *span_s, slip_m: 0.0, side_slip_m: 0.0 }));
    let all = tightness(calibrated, &motion, [&log.positions, &log.scans], truth, keys);
    // Where odometry stands for the wheels, its law states their slip, and the keys of the slip have no effect.
    let has_wheels = log.gathered.odometry.is_empty();
    let told = BOUND_KEYS.iter().filter(|(_, key, _)| has_wheels || !key.starts_with("bounds."));
    let found = told.filter_map(|(bound, key, declared)| {
        let (compared, declared) = (all.iter().find(|one| one.bound == *bound)?, declared(calibrated)?);
        let least = Some(compared.needed).filter(|least| least.is_finite());
        let value = least.filter(|least| *least > 0.0).map_or(declared, |least| margin * least);
        Some(FoundBound { bound, key, declared, least, value })
    });
    found.collect()
}
