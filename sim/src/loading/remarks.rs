//! Remarks on a valid scene that is perhaps not what its author meant.

use crate::scene::{MethodName, Scene};

impl Scene {
    /// What in the scene is allowed but leaves the localizer without anything to see: for each such key a sentence with the key, its value, and what
    /// would be expected.
    pub fn remarks(&self) -> Vec<String> {
        let methods = &self.localizer.methods;
        if methods.is_empty() {
            let text = "`localizer.methods = []`: the estimate follows the motion alone, and its box grows all the time; expected a method, unless that \
                        is meant";
            return vec![text.to_owned()];
        }
        methods
            .iter()
            .filter_map(|method| {
                let missing = self.robot.lacks(*method).or_else(|| self.unseen(*method))?;
                let name = serde_json::to_value(method).unwrap_or_default();
                let name = name.as_str().unwrap_or_default();
                Some(format!("`localizer.methods`: `{name}` has nothing to read, expected `{missing}`"))
            })
            .collect()
    }

    /// Key of the table that states what a method looks at, if the scene has none of it.
    fn unseen(&self, method: MethodName) -> Option<&'static str> {
        match method {
            MethodName::FloorTiles => self.floor.tiles.is_none().then_some("floor.tiles"),
            MethodName::CeilingMarkers => self.markers.is_none().then_some("markers"),
            MethodName::RangeLandmarks => self.landmarks.is_empty().then_some("landmark"),
            _ => None,
        }
    }
}
