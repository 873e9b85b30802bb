//! What the method by pictures keeps from one reading to the next: what it learns, and what a drive tells of the map.

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseBox, PoseUnion,
    graph::{Relations, Variable},
    map::{SeenAgain, SpacePoint, Views},
    method::{Knowledge, Memory, OnPose, Shown},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{Album, KNOWN_M, KNOWN_RAD, Learning, LookedFor, PicturedLandmarks, Shows, Sight, WholeDrive, view};

impl Memory for PicturedLandmarks {
    /// The constraint of a picture by what is left of its landmarks: some of it may have been unlearnt since.
    fn on_pose_again(&self, shown: &Shown) -> Option<OnPose> {
        let (_, sights, most_wrong) = shown.downcast_ref::<Shows>()?.used.as_ref()?;
        let again = |sight: &Sight| {
            let mut point = self.album.point(sight.landmark)?;
            // What was learnt of the landmark after the picture was not claimed of it.
            (0..3).for_each(|k| point.value[k] = point.value[k].hull(sight.point.value[k]));
            Some(Sight { point, ..*sight })
        };
        let sights: Vec<Sight> = sights.iter().filter_map(again).collect();
        Some(Box::new(self.by_sights(&sights, *most_wrong)))
    }

    fn keeps_drive(&self) -> bool {
        self.learning == Learning::Teaches
    }

    fn learns_of_together(&self, shown: &[(f64, PoseBox)]) -> Vec<Vec<(f64, Arc<dyn Relations>)>> {
        let shown: Vec<(f64, PoseBox)> =
            shown.iter().map(|(stamp_s, pose)| (*stamp_s, self.stray.around(pose))).collect();
        self.drive.parts(&shown, &self.album, &self.finder.optics)
    }

    fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        self.album.narrow(bounds);
    }

    fn views(&self, shown: &[(f64, PoseBox)]) -> Option<Views> {
        let optics = &self.finder.optics;
        let shown: Vec<(f64, PoseBox)> =
            shown.iter().map(|(stamp_s, pose)| (*stamp_s, self.stray.around(pose))).collect();
        let pictures = self.drive.apart(&shown, &self.album, optics);
        let pictures: Vec<(f64, PoseBox, &[Sight])> =
            pictures.iter().map(|(stamp_s, pose, sights)| (*stamp_s, *pose, sights.as_slice())).collect();
        self.keeps_drive().then(|| self.album.views(view::kept(optics), &pictures))
    }

    fn knowledge(&self) -> Option<Knowledge> {
        (self.learning != Learning::Never).then(|| Arc::new((self.album.clone(), self.drive.n_pictures())) as _)
    }

    fn go_back(&mut self, known: &Knowledge) {
        if let Some((album, n_pictures)) = known.downcast_ref::<(Album, usize)>() {
            self.album.clone_from(album);
            self.drive.truncate(*n_pictures);
        }
        self.album.interrupt();
    }

    fn clock_set_back(&mut self) {
        self.album.begin_anew();
        self.drive = WholeDrive::default();
        self.learnt_at = None;
    }

    fn learn(&mut self, shown: &Shown, posterior: Option<&PoseUnion>) {
        let (Some(picture), Some(posterior)) = (shown.downcast_ref::<Shows>(), posterior) else { return };
        // The pose that the picture shows.
        let shown = self.stray.around(&posterior.hull());
        self.count(picture, &shown);
        let Shows { stamp_s, looked_for: Some(LookedFor { sights: found, .. }), new: Some(new), .. } = picture else {
            return;
        };
        let is_known = shown.width(0).max(shown.width(1)) <= KNOWN_M && shown.width(2) <= KNOWN_RAD;
        if shown.is_empty() || !is_known {
            return;
        }
        self.learnt_at = Some([0, 1, 2].map(|axis| shown[axis].mid()));
        // The place at which a landmark was first seen has no error of its own, but the lens model has.
        let mut first = Vec::new();
        for look in new {
            let straight = self.finder.lens.straightened(look.position_px(), [0.0; 2]);
            if let Some((at_px, error_px)) = straight
                && let Some(point) = self.finder.optics.first_seen(&shown, at_px, error_px)
                && let Some(landmark) = self.album.add(look.clone(), point, *stamp_s)
            {
                first.push(Sight { landmark, point, at_px, error_px, view: None, thing: None });
            }
        }
        if self.keeps_drive() {
            self.drive.note(*stamp_s, &first);
        }
        self.album.learn(&shown, [found, &first], &self.finder.optics, self.learning == Learning::Teaches);
    }

    fn space_points(&self) -> Vec<(LandmarkId, SpacePoint)> {
        self.album.kept().map(|(landmark, entry)| (landmark, entry.point)).collect()
    }

    fn seen_again(&self) -> Vec<SeenAgain> {
        self.sought.all(&self.whereabouts.moved())
    }

    fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        self.album.kept().map(|(landmark, entry)| (landmark, (*entry.look).clone())).collect()
    }
}
