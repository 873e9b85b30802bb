//! False claims by their names: what was claimed to be seen, where in the picture, and how far off that is by the simulator's own camera.

use localizer::Claim;

use crate::{
    run::{ImageRecord, RunRecord},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use super::{
    claims::is_true,
    space_points,
    verdict::{NamedClaim, NamedClaims},
};

/// Greatest number of false claims of a reading that are named.
const MOST_NAMED: usize = 3;

impl NamedClaims {
    /// The false claims of a reading of a run.
    pub(super) fn of(scene: &Scene, record: &RunRecord, image: &ImageRecord) -> NamedClaims {
        let is_false = |claim: &&Claim| !is_true(claim, scene, &record.drawn, &image.truth);
        let all = image.claims.iter().filter(is_false);
        let named = all.map(|claim| NamedClaim::of(claim, scene, &record.drawn, &image.truth)).collect();
        let (method, number, measured_s) = (image.method, image.number, image.measured_s);
        NamedClaims { method, image: number, measured_s, worst: named, more: 0 }.sorted()
    }

    /// The claims with the worst first, as many as are named.
    fn sorted(mut self) -> NamedClaims {
        // What the camera does not show at all is farther off than anything else.
        let off_px = |one: &NamedClaim| one.off_px.unwrap_or(f64::INFINITY);
        self.worst.sort_by(|a, b| off_px(b).total_cmp(&off_px(a)));
        self.more += self.worst.len().saturating_sub(MOST_NAMED);
        self.worst.truncate(MOST_NAMED);
        self
    }

    /// The reading and the claims in words.
    pub(super) fn in_words(&self) -> String {
        let mut told: Vec<String> = self.worst.iter().map(NamedClaim::in_words).collect();
        told.extend((self.more > 0).then(|| format!("{} more", self.more)));
        format!("in image {} at {:.2} s: {}", self.image, self.measured_s, told.join("; "))
    }
}

impl NamedClaim {
    fn of(claim: &Claim, scene: &Scene, drawn: &Drawn, truth: &Truth) -> NamedClaim {
        let in_picture = |what: &str, places: &[[f64; 2]]| {
            let middle = [0, 1].map(|axis| places.iter().map(|at| at[axis]).sum::<f64>() / places.len().max(1) as f64);
            NamedClaim { what: what.to_owned(), at_px: Some(middle), off_px: None }
        };
        match claim {
            Claim::FloorJoint { points_px, .. } => {
                in_picture("floor joint", &points_px.iter().map(|[u, v, _]| [*u, *v]).collect::<Vec<_>>())
            }
            Claim::WallLine { ends_px, .. } => in_picture("level edge", ends_px),
            Claim::UprightLine { ends_px, .. } => in_picture("upright edge", ends_px),
            Claim::WallUpright { lines, .. } => in_picture(
                "upright edge of a wall",
                &lines.iter().flat_map(|(ends_px, _)| *ends_px).collect::<Vec<_>>(),
            ),
            Claim::Marker { marker, dots_px } => {
                let places: Vec<[f64; 2]> = dots_px.iter().map(|(_, [u, v, _])| [*u, *v]).collect();
                in_picture(&format!("marker {}", marker.0), &places)
            }
            Claim::SpacePoint { landmark, point, at_px, view, .. } => NamedClaim {
                off_px: space_points::off_px(point, view.as_ref(), *at_px, scene, drawn, truth),
                ..in_picture(&format!("landmark {}", landmark.0), &[*at_px])
            },
            Claim::Landmark { landmark, .. } => {
                NamedClaim { what: format!("landmark {}", landmark.0), at_px: None, off_px: None }
            }
            Claim::WallPoint { bearing_rad, distance_m, .. } => NamedClaim {
                what: format!("wall {distance_m:.3} m away at a bearing of {:.1}°", bearing_rad.to_degrees()),
                at_px: None,
                off_px: None,
            },
        }
    }

    fn in_words(&self) -> String {
        let at = self.at_px.map(|[u, v]| format!(" at ({u:.1}, {v:.1}) px"));
        let off = self.off_px.map(|off_px| format!(", {off_px:.1} px off"));
        [Some(self.what.clone()), at, off].into_iter().flatten().collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::Interval;
    use localizer::{
        Estimate, Pose, PoseBox, PoseUnion, Status,
        map::{Anchor, SpacePoint},
        quota::Quota,
        reading::{Camera, LandmarkId},
    };

    use super::*;
    use crate::judge::{Judgement, judge, space_points::tests::scene};

    fn landmark(number: u32, off_px: Option<f64>) -> NamedClaim {
        NamedClaim { what: format!("landmark {number}"), at_px: Some([312.44, 187.0]), off_px }
    }

    #[test]
    fn of_false_claims_the_three_worst_are_named_and_the_others_counted() {
        let named = |worst: &[NamedClaim], more| NamedClaims {
            method: "mapped_landmarks",
            image: 12,
            measured_s: 2.456,
            worst: worst.to_vec(),
            more,
        };
        let all = [landmark(1, Some(4.0)), landmark(2, Some(23.04)), landmark(3, None), landmark(4, Some(9.0))];
        let worst = [2, 1, 3].map(|at| all[at].clone());
        assert_eq!(named(&all, 0).sorted(), named(&worst, 1));
        assert_eq!(
            named(&worst, 1).in_words(),
            "in image 12 at 2.46 s: landmark 3 at (312.4, 187.0) px; landmark 2 at (312.4, 187.0) px, 23.0 px \
             off; landmark 4 at (312.4, 187.0) px, 9.0 px off; 1 more"
        );
        assert_eq!(
            named(&all[..1], 0).in_words(),
            "in image 12 at 2.46 s: landmark 1 at (312.4, 187.0) px, 4.0 px off"
        );
    }

    /// A claim of a landmark 2 m ahead of the origin at the camera's height, by so many pixels to the right of where it is.
    fn claim(number: u32, off_px: f64) -> Claim {
        let anchor = Anchor { from_m: [0.0, 0.0, 0.3], axis: 0, is_positive: true };
        let value = [0.0, 0.0, 0.5].map(|at| Interval::centred(at, 1e-9));
        let (landmark, point) = (LandmarkId(number), SpacePoint { anchor, value });
        Claim::SpacePoint {
            landmark,
            point,
            at_px: [319.5 + off_px, 239.5],
            half_width_px: [0.5; 2],
            view: None,
            thing: None,
        }
    }

    /// A run of one second at rest, with a picture every tenth of a second that has two claims, and boxes that hold the truth until 0.5 s.
    fn lost(scene: &Scene, false_at: &[usize]) -> RunRecord {
        let mut record = RunRecord::new(1, None, Drawn::draw(scene, 1));
        for step in 0..=100 {
            let truth = Truth { time_s: 0.01 * f64::from(step), ..Truth::default() };
            let middle_m = if step < 50 { 0.0 } else { 0.05 };
            let pose = PoseBox::from([middle_m, 0.0, 0.0].map(|at| Interval::centred(at, 0.01)));
            let pose = PoseUnion::single(pose);
            record.truths.push(truth);
            record.odometry.push(Pose::default());
            record.estimates.push(Estimate {
                time_s: truth.time_s,
                pose: pose.clone(),
                status: Status::Sound,
                relies_on: Vec::new(),
                contradicting: None,
            });
            if step % 10 == 0 {
                let number = step as usize / 10;
                let wrong_px = if false_at.contains(&number) { 20.0 + number as f64 } else { 0.0 };
                record.images.push(ImageRecord {
                    number,
                    measured_s: truth.time_s,
                    arrived_s: truth.time_s + 0.06,
                    truth,
                    camera: Some(Camera::Forward),
                    method: "mapped_landmarks",
                    claims: vec![claim(7, 0.0), claim(204, wrong_px)],
                    quota: Quota::of_each(0),
                    alone: None,
                    is_held: false,
                    rejected_px: Vec::new(),
                    constrained: true,
                    emptied: false,
                    prior: pose.hull(),
                    posterior: pose,
                    landmarks: Vec::new(),
                    codes: Vec::new(),
                    reading: None,
                });
            }
        }
        record
    }

    #[test]
    fn a_verdict_names_the_false_matches_of_the_last_picture_before_the_truth_is_lost() {
        let scene = scene();
        // The picture at 0.5 s arrives when the truth is lost already, and that at 0.9 s long after.
        let record = lost(&scene, &[1, 4, 5, 9]);
        let verdict = judge(&scene, &record, &mut |_| {
            let mut again = lost(&scene, &[]);
            let held = again.estimates[0].clone();
            again.estimates.fill(held);
            Ok(again)
        });
        let first = verdict.unwrap().containment.unwrap().first_failure.unwrap();
        assert_eq!(first.outcome, Judgement::Perception, "{first:?}");
        let told = "in image 4 at 0.40 s: landmark 204 at (343.5, 239.5) px, 24.0 px off";
        assert_eq!(first.blame, format!("mapped_landmarks: false claims {told}"));
        assert!(first.because.contains(&format!("first in image 1 at 0.10 s, last {told}; without")), "{first:?}");
        let named = first.false_claims.unwrap();
        assert_eq!((named.image, named.worst.len(), named.more), (4, 1, 0));
    }
}
