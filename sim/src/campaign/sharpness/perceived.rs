//! The scene's quotas of false claims about images. A history in which more claims are false breaks what is declared.

use interval::Interval;

use crate::{judge, run::RunRecord, scene::Scene};

use super::{
    history::History,
    kind::{Broken, Declared, Kind, Linearised},
};

/// What there are when more claims are false in truth than the scene's quotas allow. A witness has the same false claims.
pub(super) const MISPERCEIVED: &str = "images with more false claims than declared, first";

/// Whether the claims about all images of cameras that have arrived by an instant are within the quotas in truth.
pub(super) struct Perceived {
    /// Stamps of the images at which they are not, in the order of their arrival.
    pub(super) exceeded_s: Vec<f64>,
}

impl Perceived {
    pub(super) fn of(scene: &Scene, record: &RunRecord, time_s: f64) -> Perceived {
        let misperceived = judge::misperceived(record, &judge::false_claims(scene, record));
        let exceeding =
            record.images.iter().zip(misperceived).filter(|(image, is_misperceived)| {
                *is_misperceived && image.camera.is_some() && image.arrived_s <= time_s
            });
        Perceived { exceeded_s: exceeding.map(|(image, _)| image.measured_s).collect() }
    }
}

impl Kind for Perceived {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        Vec::new()
    }

    fn check(&self, _history: &History, _slack: f64) -> Result<(), Broken> {
        self.exceeded_s.first().map_or(Ok(()), |time_s| {
            let value = Interval::point(self.exceeded_s.len() as f64);
            Err(Broken { bound: MISPERCEIVED, time_s: *time_s, value, allowed: Interval::ZERO })
        })
    }

    fn add_rows(&self, _near: &mut Linearised<'_>) {}
}
