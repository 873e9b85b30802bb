//! What a scene asks of each of its runs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Limits on the figures of `summary.json`, by the same names: `unsound = 0`, `error.x_m.rmse_max = 0.0015`,
/// `availability_min = 0.99`. A name that ends in `_max` or `_min` limits the figure of the name before it; any other
/// name asks for the exact value.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Expect {
    /// Nested tables as the file gives them.
    pub limits: BTreeMap<String, serde_json::Value>,
}
