//! The robot of one's own as arguments of `Localizer`: checked, and refused with name, value and what was expected.

use ::localizer::robot::{ErrorLaw, GyroModel};
use interval::Interval;
use pyo3::{exceptions::PyValueError, prelude::*, types::PyDict};

use crate::intervals::{Given, PyBox, shown};

/// Keys of a gyroscope that have to be given.
const GYRO_NEEDS: [&str; 4] = ["bias_rad_per_s", "scale", "noise_rad_per_s", "period_s"];
/// Keys of a gyroscope that may be given.
const GYRO_MAY_HAVE: [&str; 3] = ["angle_floor_rad", "angle_rad_per_s", "bias_wander_rad_per_s2"];

/// A box with bounds on every side.
pub(crate) fn within(name: &str, given: &PyBox) -> PyResult<()> {
    match given.0.iter().find(|side| !side.is_bounded()) {
        Some(side) => Err(refused(name, "bounded intervals that hold a number", shown(*side))),
        None => Ok(()),
    }
}

/// The distance between the wheels.
pub(crate) fn track(given: &Given) -> PyResult<Interval> {
    positive("track_m", given.interval()?)
}

/// Least and greatest value of something that is above 0.
fn positive(name: &str, given: Interval) -> PyResult<Interval> {
    if given.is_bounded() && given.lo() > 0.0 {
        Ok(given)
    } else {
        Err(refused(name, "an interval of finite numbers above 0", shown(given)))
    }
}

/// The law of an error of odometry.
pub(crate) fn error_law(name: &str, (floor_m, share, m_per_s): (f64, f64, f64)) -> PyResult<ErrorLaw> {
    let parts = [("metres at any time", floor_m), ("share of the way", share), ("metres per second", m_per_s)];
    for (part, value) in parts {
        at_least_zero(&format!("{name}: {part}"), value)?;
    }
    Ok(ErrorLaw { floor_m, share, m_per_s })
}

/// A limit that no motion exceeds.
pub(crate) fn limit(name: &str, value: f64) -> PyResult<f64> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(refused(name, "a finite number above 0", value)) }
}

/// The model of a gyroscope, from a dict with the keys that every localizer is told of one.
pub(crate) fn gyro_model(given: &Bound<'_, PyDict>) -> PyResult<GyroModel> {
    let all = || GYRO_NEEDS.iter().chain(&GYRO_MAY_HAVE);
    for key in given.keys() {
        let key: String = key.extract()?;
        if !all().any(|known| **known == key) {
            let known = all().copied().collect::<Vec<_>>().join(", ");
            return Err(refused("gyro", &format!("keys of {known}"), format!("`{key}`")));
        }
    }
    let needed = |key: &str| {
        let found = given.get_item(key)?.filter(|value| !value.is_none());
        found.ok_or_else(|| refused("gyro", &format!("the key `{key}`"), given))
    };
    // A key that is None is a bound that is not declared, as in what every localizer is told.
    let optional = |key: &str, undeclared: f64| match given.get_item(key)?.filter(|value| !value.is_none()) {
        Some(value) => at_least_zero(&format!("gyro: {key}"), value.extract()?),
        None => Ok(undeclared),
    };
    let bias_rad_per_s = needed("bias_rad_per_s")?.extract::<Given>()?.interval()?;
    if !bias_rad_per_s.is_bounded() {
        let found = shown(bias_rad_per_s);
        return Err(refused("gyro: bias_rad_per_s", "an interval of finite numbers", found));
    }
    Ok(GyroModel {
        bias_rad_per_s,
        scale: positive("gyro: scale", needed("scale")?.extract::<Given>()?.interval()?)?,
        noise_rad_per_s: at_least_zero("gyro: noise_rad_per_s", needed("noise_rad_per_s")?.extract()?)?,
        period_s: limit("gyro: period_s", needed("period_s")?.extract()?)?,
        angle_floor_rad: optional("angle_floor_rad", f64::INFINITY)?,
        angle_rad_per_s: optional("angle_rad_per_s", 0.0)?,
        bias_wander_rad_per_s2: optional("bias_wander_rad_per_s2", 0.0)?,
    })
}

fn at_least_zero(name: &str, value: f64) -> PyResult<f64> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(refused(name, "a finite number of at least 0", value))
    }
}

fn refused(name: &str, expected: &str, found: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("{name}: expected {expected}, found {found}"))
}
