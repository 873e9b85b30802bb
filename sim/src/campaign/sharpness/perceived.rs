//! The scene's quotas of false claims about images. A history in which more claims are false breaks what is declared.

use interval::Interval;

use crate::{judge, run::RunRecord, scene::Scene};

use super::{
    history::History,
    kind::{Broken, Declared, Kind, Linearised},
};

/// What is broken when more claims are false in truth than the scene's quotas allow. A witness has the same false claims.
pub(super) const QUOTAS: &str = "quotas of false claims";

/// Whether the claims about all images of cameras that have arrived by an instant are within the quotas in truth.
pub(super) struct Perceived {
    /// Stamp of the first image at which they are not.
    pub(super) exceeded_s: Option<f64>,
}

impl Perceived {
    pub(super) fn of(scene: &Scene, record: &RunRecord, time_s: f64) -> Perceived {
        let misperceived = judge::misperceived(record, &judge::false_claims(scene, record));
        let mut exceeding =
            record.images.iter().zip(misperceived).filter(|(image, is_misperceived)| {
                *is_misperceived && image.camera.is_some() && image.arrived_s <= time_s
            });
        Perceived { exceeded_s: exceeding.next().map(|(image, _)| image.measured_s) }
    }
}

impl Kind for Perceived {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        Vec::new()
    }

    fn check(&self, _history: &History, _slack: f64) -> Result<(), Broken> {
        self.exceeded_s.map_or(Ok(()), |time_s| {
            Err(Broken { bound: QUOTAS, time_s, value: Interval::ONE, allowed: Interval::ZERO })
        })
    }

    fn add_rows(&self, _near: &mut Linearised<'_>) {}
}
