//! Readings that arrive after the next key frame has been made.

use interval::Interval;

use crate::PoseBox;

use super::{
    super::link::{Link, Read},
    FrameReading, KeyFrame, KeyFrames, Ways, places,
};

/// A place between two key frames.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Index of the key frame after the gap.
    at: usize,
    /// Stamps of the key frames before and after it.
    pub span_s: [f64; 2],
    /// Headings at the key frame before it.
    pub heading: Interval,
}

impl KeyFrames {
    /// The gap between two key frames into which a late reading with the given stamp fits: at least `apart_s` from any other reading of its source, and
    /// before the latest key frame.
    pub fn gap_for(&self, stamp_s: f64, source: &str, apart_s: f64) -> Option<Gap> {
        let at = self.frames.iter().position(|frame| frame.stamp_s > stamp_s).filter(|&at| at > 0)?;
        let is_near = |frame: &KeyFrame| frame.has(source) && (frame.stamp_s - stamp_s).abs() < apart_s;
        let [before, after] = [&self.frames[at - 1], &self.frames[at]];
        let is_free = !self.frames.iter().any(is_near) && before.stamp_s < stamp_s && after.link.is_some();
        is_free.then_some(Gap { at, span_s: [before.stamp_s, after.stamp_s], heading: before.pose[2] })
    }

    /// Adds a key frame for a late reading between two others, with the ways to it and on from it. Returns whether it was added: the ways have to
    /// tell the motion as fully as the way between the two others did.
    pub fn insert(
        &mut self,
        gap: &Gap,
        stamp_s: f64,
        pose: PoseBox,
        reading: FrameReading,
        [first, second]: [Ways; 2],
    ) -> bool {
        let [before, after] = [&self.frames[gap.at - 1], &self.frames[gap.at]];
        let [to, on] = [places(&first.1), places(&second.1)];
        let had = after.link.as_ref().map(Link::tells);
        let tells = |(way, flow): &Ways| [flow.is_some(), way.is_some()];
        let keeps_places = to.is_none_or(|[first, _]| before.place.is_none_or(|place| place == first))
            && on.map(|[_, last]| last) == after.place;
        if !keeps_places || had.is_none_or(|had| [&first, &second].iter().any(|ways| had != tells(ways))) {
            return false;
        }
        let number = self.new_number();
        let scale_change = self.flow_scale_change;
        let known_s = |ways: &Ways| self.known_s().filter(|_| ways.1.is_some());
        let [way_known_s, next_known_s] = [known_s(&first), known_s(&second)];
        let link =
            |(way, flow): Ways, shares_error: bool| Some(Link::Read(Read { way, flow, shares_error, scale_change }));
        if let (Some([first, _]), None) = (to, self.frames[gap.at - 1].place) {
            self.frames[gap.at - 1].place = Some(first);
        }
        let shares_error = to.zip(on).is_some_and(|([_, last], [first, _])| last == first);
        self.frames[gap.at].link = link(second, shares_error);
        self.frames[gap.at].way_known_s = next_known_s;
        let place = to.map(|[_, last]| last);
        let readings = vec![FrameReading { number, ..reading }];
        let link = link(first, to.is_some());
        let frame = KeyFrame::new(number, stamp_s, pose, readings);
        let frame = KeyFrame { link, is_linked: true, way_known_s, place, ..frame };
        self.frames.insert(gap.at, frame);
        if self.is_too_many() {
            self.drop_one();
        }
        true
    }
}
