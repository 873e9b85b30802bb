//! What was known at earlier times of the drive, for the localizer to go back to when an assumption may have been false since.
//!
//! Methods learn landmarks and directions, and heading fixes tell the gyroscope's errors. If an assumption has failed, what was learnt since may be false.
//! How long ago it failed is not known, so that what was known at several earlier times is kept: every second of the latest ones, and fewer the longer ago
//! they are. Nobody else keeps what is to be taken back.

use crate::{Localizer, Method, method::Knowledge};

use super::heading_fixes::{HeadingFixes, KnownFixes};

/// Least time between two times at which what was known is kept.
const APART_S: f64 = 1.0;
/// Greatest distance in time between those that are kept, as a share of the age of the later one: a doubt reaches back by twice as much as the one before,
/// and then by up to this share more.
const SPREAD: f64 = 0.5;

/// What was known at earlier times, the earliest first.
#[derive(Default)]
pub(super) struct EarlierKnowledge {
    kept: Vec<Known>,
}

/// What was known at one time.
struct Known {
    at_s: f64,
    /// What each method knew; `None` for a method that learns nothing.
    methods: Vec<Option<Knowledge>>,
    fixes: Option<KnownFixes>,
}

impl EarlierKnowledge {
    /// Whether enough time has passed since what was known was last kept.
    fn is_due(&self, now_s: f64) -> bool {
        self.kept.last().is_none_or(|latest| now_s >= latest.at_s + APART_S)
    }

    fn keep(&mut self, at_s: f64, methods: &[Box<dyn Method>], fixes: Option<&HeadingFixes>) {
        let memories = methods.iter().map(|method| method.memory());
        self.kept.push(Known {
            at_s,
            methods: memories.map(|memory| memory.and_then(|memory| memory.knowledge())).collect(),
            fixes: fixes.map(HeadingFixes::known),
        });
        self.thin_out(at_s);
    }

    /// Drops what lies between neighbours that are near each other for their age. What was known at first stays.
    fn thin_out(&mut self, now_s: f64) {
        let mut at = 1;
        while at + 1 < self.kept.len() {
            let gap_s = self.kept[at + 1].at_s - self.kept[at - 1].at_s;
            if gap_s <= SPREAD * (now_s - self.kept[at + 1].at_s) {
                self.kept.remove(at);
            } else {
                at += 1;
            }
        }
    }

    /// Drops what was known of headings and of the gyroscope's errors at all times: it was false.
    pub(super) fn forget_fixes(&mut self) {
        self.kept.iter_mut().for_each(|known| known.fixes = None);
    }

    /// What was known at the latest time that is not after the given one, or at the earliest of all; what was known later is dropped.
    fn since(&mut self, since_s: f64) -> Option<&Known> {
        let n_before = self.kept.partition_point(|known| known.at_s <= since_s);
        self.kept.truncate(n_before.max(1));
        self.kept.last()
    }
}

impl Localizer {
    /// Keeps what is known now when that is due, unless an assumption is doubted.
    pub(super) fn keep_knowledge(&mut self) {
        if !self.is_doubted() && self.earlier.is_due(self.now_s) {
            self.earlier.keep(self.now_s, &self.methods, self.fixes.as_ref());
        }
    }

    /// Drops all that was known at earlier times: what is known now can be taken back no more.
    pub(super) fn begin_knowledge(&mut self) {
        self.earlier = EarlierKnowledge::default();
        self.keep_knowledge();
    }

    /// Goes back to what was known at a time not after the given one.
    pub(super) fn go_back(&mut self, since_s: f64) {
        let Some(known) = self.earlier.since(since_s) else { return };
        match (&mut self.fixes, &known.fixes) {
            (Some(fixes), Some(known)) => fixes.go_back(known),
            (Some(fixes), None) => fixes.forget(),
            _ => {}
        }
        for (method, known) in self.methods.iter_mut().zip(&known.methods) {
            if let (Some(memory), Some(known)) = (method.memory_mut(), known) {
                memory.go_back(known);
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::{Interval, contractor::Outcome};

    use super::*;
    use crate::{
        Map, PoseBox, RobotModel,
        graph::trial::{gyro, robot},
    };

    fn kept_s(earlier: &EarlierKnowledge) -> Vec<f64> {
        earlier.kept.iter().map(|known| known.at_s).collect()
    }

    #[test]
    fn whatever_the_depth_something_was_kept_not_much_longer_ago() {
        let mut earlier = EarlierKnowledge::default();
        for second in 0..1000 {
            let now_s = f64::from(second);
            if earlier.is_due(now_s) {
                earlier.keep(now_s, &[], None);
            }
            for depth_s in [1.0, 3.0, 6.0, 12.0, 24.0, 48.0, 96.0, 192.0] {
                let wanted_s = now_s - depth_s;
                let found_s = kept_s(&earlier).into_iter().rev().find(|at_s| *at_s <= wanted_s);
                // By hand: two neighbours are at most a second apart, or half of the later one's age.
                let least_s = wanted_s - (0.5 * depth_s).max(1.0);
                assert!(wanted_s < 0.0 || found_s.is_some_and(|found_s| found_s >= least_s), "{now_s} {depth_s}");
            }
        }
        assert!(kept_s(&earlier).len() <= 30 && kept_s(&earlier)[0] == 0.0, "{:?}", kept_s(&earlier));
        assert!(!earlier.is_due(999.5) && earlier.is_due(1000.0));
    }

    #[test]
    fn what_was_known_later_is_dropped_and_what_was_known_at_first_stays() {
        let mut earlier = EarlierKnowledge::default();
        (0..5).for_each(|second| earlier.keep(f64::from(second), &[], None));
        assert_eq!(earlier.since(3.5).map(|known| known.at_s), Some(3.0));
        assert_eq!(kept_s(&earlier), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(earlier.since(-10.0).map(|known| known.at_s), Some(0.0));
    }

    #[test]
    fn the_gyroscopes_errors_go_back_with_all_else_and_not_to_what_was_found_false() {
        let robot = RobotModel { gyro: Some(gyro(true)), ..robot() };
        let map = Map::of_room([Interval::new(-5.0, 5.0); 2]);
        let mut localizer =
            Localizer::new(map, robot, Vec::new(), PoseBox::from([Interval::ZERO; 3])).learning_gyro(None);
        let bias = |localizer: &Localizer| localizer.fixes.as_ref().unwrap().bias_over(1.0, localizer.now_s);
        // The robot stands, and its heading is known better after each ten seconds.
        let mut known = vec![bias(&localizer)];
        for step in 1..=3000_u32 {
            localizer.fixes.as_mut().unwrap().read(0.01 * f64::from(step), 0.0);
            if step.is_multiple_of(1000) {
                localizer.now_s = 0.01 * f64::from(step);
                let heading = Interval::centred(0.0, 0.001);
                assert_eq!(localizer.fixes.as_mut().unwrap().learn(localizer.now_s, heading), Outcome::Feasible);
                known.push(bias(&localizer));
                localizer.keep_knowledge();
            }
        }
        assert!(known.windows(2).all(|pair| pair[1].width() < pair[0].width()), "{known:?}");
        localizer.go_back(20.0);
        assert_eq!(bias(&localizer), known[2]);
        localizer.earlier.forget_fixes();
        localizer.go_back(10.0);
        assert_eq!(bias(&localizer), known[0]);
    }
}
