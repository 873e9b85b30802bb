//! Remarks on a valid scene that is perhaps not what its author meant.

use localizer::methods::ceiling_markers::{CeilingMarkers, LEAST_RADIUS_PX};

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
        let unread = methods.contains(&MethodName::CeilingMarkers).then(|| self.dots_too_small()).flatten();
        methods
            .iter()
            .filter_map(|method| {
                let missing = self.robot.lacks(*method).or_else(|| self.unseen(*method))?;
                let name = serde_json::to_value(method).unwrap_or_default();
                let name = name.as_str().unwrap_or_default();
                Some(format!("`localizer.methods`: `{name}` has nothing to read, expected `{missing}`"))
            })
            .chain(unread)
            .chain(self.confuses_nothing())
            .collect()
    }

    /// Says that landmarks of a map are to be confused and that there is no map, if so.
    fn confuses_nothing(&self) -> Option<String> {
        let setup = self.localizer.mapped_landmarks.as_ref().filter(|setup| setup.confuses() && setup.map.is_none())?;
        Some(format!(
            "`localizer.mapped_landmarks.confused_share = {}`: there is no map whose landmarks could be confused, expected \
             `localizer.mapped_landmarks.map`, which `wherein repeat` sets",
            setup.confused_share.unwrap_or_default()
        ))
    }

    /// Says that the ceiling camera sees the dots of all markers too small to read them, if so.
    fn dots_too_small(&self) -> Option<String> {
        let markers = CeilingMarkers::new(&self.map(), &self.robot_model())?;
        (!markers.resolves_dots()).then(|| {
            format!(
                "`robot.ceiling_camera.focal_px`: the dots of the markers have a radius of less than {LEAST_RADIUS_PX} px in the image, so that no \
                 marker is read; expected a greater focal length or a lower ceiling"
            )
        })
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
