//! What a scene asks of each of its runs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Limits on the figures of `summary.json`, by the same names: `unsound = 0`, `error.x_m.rmse_worst_third_max = 0.001`,
/// `availability_min = 0.99`. A name that ends in `_max` or `_min` limits the figure of the name before it; any other
/// name asks for the exact value. The counts of `containment` need no prefix.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Expect {
    /// Nested tables as the file gives them.
    pub limits: BTreeMap<String, Value>,
}
