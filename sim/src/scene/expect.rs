//! Limits that a scene sets on the results of each of its runs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Limits on the figures of `summary.json`, under the same names: `unsound = 0`, `error.x_m.rmse_worst_third_max = 0.001`, `availability_min = 0.99`.
/// A name that ends in `_max` or `_min` limits the figure whose name comes before that ending; any other name demands the exact value. The counts
/// under `containment` need no prefix.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Expect {
    /// Limits by name, in nested tables as the scene's file gives them.
    pub limits: BTreeMap<String, Value>,
}
