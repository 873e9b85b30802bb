//! A key by which a scene gives the localizer a bound.

use localizer::bounds::Assumption;

/// One key of the scene that states a bound.
pub struct ToldKey<'a> {
    /// Names of the bounds that the key states, as an estimate names them in `relies_on`, its list of the bounds that it depends on.
    pub(crate) bounds: &'static [Assumption],
    /// Value of the key, in the key's own unit.
    pub(crate) value: &'a mut f64,
    /// Factor from the unit of the true value that is compared with the bound to the unit of the scene's key.
    pub(crate) per_true: f64,
    pub(crate) widens: Widens,
}

/// How a key of the scene is changed when the true value exceeds the bound that it states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Widens {
    /// The scene's key is set to the true value.
    To,
    /// The amount by which the true value exceeds the bound is added to the key, as for a bound that is a sum or applies to every time window.
    By,
    /// The scene's key stays as it is, because another key of the same bound is changed.
    Not,
}

impl<'a> ToldKey<'a> {
    /// A key of the scene whose value is the bound itself, in the unit of the true value.
    pub(crate) fn is(bounds: &'static [Assumption], value: &'a mut f64) -> Self {
        ToldKey { bounds, value, per_true: 1.0, widens: Widens::To }
    }

    /// A key of the scene in degrees, for a bound in radians.
    pub(crate) fn is_in_deg(bounds: &'static [Assumption], value: &'a mut f64) -> Self {
        ToldKey { bounds, value, per_true: f64::to_degrees(1.0), widens: Widens::To }
    }

    /// A key of the scene that is a share of a nominal value, for a bound in the unit of that value.
    pub(crate) fn is_share_of(bounds: &'static [Assumption], value: &'a mut f64, nominal: f64) -> Self {
        ToldKey { bounds, value, per_true: 1.0 / nominal, widens: Widens::To }
    }

    /// A key of the scene that is one part of a bound, in the unit of the true value.
    pub(crate) fn is_part(bounds: &'static [Assumption], value: &'a mut f64, widens: Widens) -> Self {
        ToldKey { bounds, value, per_true: 1.0, widens }
    }
}
