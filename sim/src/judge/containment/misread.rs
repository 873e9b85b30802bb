//! Readings with more false claims than the scene declares, and which of those claims are named where they are to blame.

use localizer::reading::Camera;

use crate::{
    judge::NamedClaims,
    run::{ImageRecord, RunRecord},
    scene::Scene,
};

/// A reading that has more wrong claims than the scene declares for its method, alone or with the readings counted together with it.
pub(super) struct Misread {
    method: &'static str,
    pub(super) camera: Option<Camera>,
    pub(super) measured_s: f64,
    pub(super) arrived_s: f64,
    number: usize,
}

impl Misread {
    /// What is to blame, where this was the first such reading, and `named` are the false claims of the last one before the loss, if known.
    pub(super) fn as_blame(&self, named: Option<&NamedClaims>) -> String {
        let claims = named.map_or_else(|| format!("in image {}", self.number), NamedClaims::in_words);
        format!("{}: false claims {claims}", named.map_or(self.method, |named| named.method))
    }

    /// Why that is to blame.
    pub(super) fn because(&self, named: Option<&NamedClaims>) -> String {
        let Misread { method, number, measured_s, .. } = self;
        let first = || format!("first in image {number} at {measured_s:.2} s");
        let claims = match named {
            Some(named) if named.image == *number => named.in_words(),
            Some(named) => format!("{}, last {}", first(), named.in_words()),
            None => first(),
        };
        format!("{method} claimed more falsely than declared, {claims}; without such images")
    }
}

/// The readings of a run that have more false claims than declared.
pub(super) fn misread(record: &RunRecord, misperceived: &[bool]) -> Vec<Misread> {
    let of = |image: &ImageRecord| Misread {
        method: image.method,
        camera: image.camera,
        measured_s: image.measured_s,
        arrived_s: image.arrived_s,
        number: image.number,
    };
    images(record, misperceived).map(of).collect()
}

/// By name, the false claims of the last reading with too many of them that arrived before the truth was outside, or of the first one that arrived
/// while it was. `None` where no reading of the run had too many by then.
pub(super) fn named(
    scene: &Scene,
    record: &RunRecord,
    misperceived: &[bool],
    [begin_s, end_s]: [f64; 2],
) -> Option<NamedClaims> {
    let before = images(record, misperceived).filter(|image| image.arrived_s <= begin_s).last();
    let image = before.or_else(|| images(record, misperceived).find(|image| image.arrived_s <= end_s))?;
    Some(NamedClaims::of(scene, record, image))
}

fn images<'a>(record: &'a RunRecord, misperceived: &'a [bool]) -> impl Iterator<Item = &'a ImageRecord> {
    let wrong = record.images.iter().zip(misperceived).filter(|(_, is_misread)| **is_misread);
    wrong.map(|(image, _)| image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::NamedClaim;

    #[test]
    fn the_claims_of_the_last_reading_before_the_loss_are_named_beside_the_first_one() {
        let first = Misread { method: "mapped_landmarks", camera: None, measured_s: 0.6, arrived_s: 0.66, number: 3 };
        let claim = NamedClaim { what: "landmark 20".to_owned(), at_px: Some([100.0, 50.25]), off_px: Some(12.0) };
        let named = |image, measured_s| NamedClaims {
            method: "mapped_landmarks",
            image,
            measured_s,
            worst: vec![claim.clone()],
            more: 0,
        };
        let told = "landmark 20 at (100.0, 50.2) px, 12.0 px off";
        assert_eq!(
            first.as_blame(Some(&named(12, 2.4))),
            format!("mapped_landmarks: false claims in image 12 at 2.40 s: {told}")
        );
        assert_eq!(
            first.because(Some(&named(12, 2.4))),
            format!(
                "mapped_landmarks claimed more falsely than declared, first in image 3 at 0.60 s, last in image 12 at 2.40 s: {told}; without \
                 such images"
            )
        );
        let alone = format!(
            "mapped_landmarks claimed more falsely than declared, in image 3 at 0.60 s: {told}; without such images"
        );
        assert_eq!(first.because(Some(&named(3, 0.6))), alone);
        assert_eq!(first.as_blame(None), "mapped_landmarks: false claims in image 3");
    }
}
