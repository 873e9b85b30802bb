//! A key by which a scene tells the localizer a bound.

use localizer::bounds::Assumption;

/// One key of the scene that states a bound.
pub struct ToldKey<'a> {
    /// Bounds that it states, by their names in `relies_on`.
    pub(crate) bounds: &'static [Assumption],
    /// Its value, in the key's own unit.
    pub(crate) value: &'a mut f64,
    /// How much of the key's unit is one unit of the true value that is held against the bound.
    pub(crate) per_true: f64,
    pub(crate) widens: Widens,
}

/// What a true value beyond the bound makes of the key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Widens {
    /// The key becomes the true value.
    To,
    /// What is missing is added: the bound is a sum, or one over every window.
    By,
    /// Another key of the same bound does it.
    Not,
}

impl<'a> ToldKey<'a> {
    /// A key that is the bound, in the unit of the true value.
    pub(crate) fn is(bounds: &'static [Assumption], value: &'a mut f64) -> Self {
        ToldKey { bounds, value, per_true: 1.0, widens: Widens::To }
    }

    /// A key in degrees of a bound in radians.
    pub(crate) fn is_in_deg(bounds: &'static [Assumption], value: &'a mut f64) -> Self {
        ToldKey { bounds, value, per_true: f64::to_degrees(1.0), widens: Widens::To }
    }

    /// A key that is a share of a nominal value, of a bound in the unit of that value.
    pub(crate) fn is_share_of(bounds: &'static [Assumption], value: &'a mut f64, nominal: f64) -> Self {
        ToldKey { bounds, value, per_true: 1.0 / nominal, widens: Widens::To }
    }

    /// A key that is one part of a bound, in the unit of the true value.
    pub(crate) fn is_part(bounds: &'static [Assumption], value: &'a mut f64, widens: Widens) -> Self {
        ToldKey { bounds, value, per_true: 1.0, widens }
    }
}
