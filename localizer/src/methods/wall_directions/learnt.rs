//! Learnt directions of the building: what `wall_directions` learns from images, and takes back.

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseUnion,
    method::{Knowledge, Memory, Shown},
};

use super::{FEWEST_TO_LEARN, Image, NEW_DIRECTION_RAD, WallDirections, headings, held::Certificates};

impl Memory for WallDirections {
    fn learn(&mut self, shown: &Shown, posterior: Option<&PoseUnion>) {
        let Some(heading) = posterior.map(|posterior| posterior.hull()[2]) else { return };
        let strange_rad = shown.downcast_ref::<Image>().map_or(&[][..], |image| &image.strange_rad);
        if !self.learns || strange_rad.len() < FEWEST_TO_LEARN || heading.is_empty() {
            return;
        }
        // A direction α of the building is the heading θ plus the edge's angle φ from robot forward, up to quarter turns. Its interval is as wide as
        // those of heading and edges together, never narrower.
        let quarter = Interval::PI * 0.5;
        let any = Interval::new(-0.1, quarter.hi() + 0.1);
        let turned: Vec<Vec<Interval>> =
            strange_rad.iter().map(|&azimuth| headings::of_line(azimuth * -1.0, &[Interval::ZERO], any)).collect();
        let agreed = headings::agreed(&turned, turned.len() - self.quotas.wrong_of_image(turned.len()));
        let Some(azimuth) = one_direction(&agreed) else { return };
        let direction_rad = azimuth + heading;
        let near = |known: Interval| {
            let quarters = ((known.mid() - direction_rad.mid()) / quarter.mid()).round();
            !(direction_rad + quarter * quarters).inflate(NEW_DIRECTION_RAD).is_disjoint_from(known)
        };
        if direction_rad.width() <= NEW_DIRECTION_RAD && !self.directions_rad.iter().copied().any(near) {
            self.directions_rad.push(direction_rad);
        }
    }

    fn knowledge(&self) -> Option<Knowledge> {
        Some(Arc::new(self.directions_rad.clone()))
    }

    fn go_back(&mut self, known: &Knowledge) {
        if let Some(directions_rad) = known.downcast_ref::<Vec<Interval>>() {
            self.directions_rad.clone_from(directions_rad);
        }
        self.certificates = Certificates::default();
    }

    fn take_contradiction(&mut self) -> bool {
        let are_too_many = self.certificates.are_too_many;
        if are_too_many {
            self.certificates = Certificates::default();
        }
        are_too_many
    }
}

/// The one direction on which all given intervals of directions agree up to quarter turns; `None` where they give several directions and it is not
/// known which is right.
fn one_direction(sets: &[Interval]) -> Option<Interval> {
    let quarter = Interval::PI * 0.5;
    let (&first, others) = sets.split_first()?;
    others.iter().try_fold(first, |direction, &set| {
        let again = set - quarter;
        (!again.is_disjoint_from(first)).then(|| direction.hull(again))
    })
}
