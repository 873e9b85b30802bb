//! The account of a log's topics: how many messages each has, when, and which were dropped for what reason.

use std::collections::BTreeMap;

use super::topics::Role;

/// Number of usual periods without a message from which on a gap is named, where that is longer than the declared one: one or two lost messages in a
/// row are common.
const PERIODS_OF_A_GAP: f64 = 3.5;

/// What became of the messages of a topic.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Topic {
    pub(super) kind: String,
    /// What the topic is read as; `None` where nothing reads it.
    pub(super) role: Option<Role>,
    pub(super) n_messages: usize,
    /// Usual delay from stamp to time of logging.
    pub(super) delay_ns: Option<i64>,
    /// A step of the stamps' clock against the times of logging, if there was one.
    pub(super) clock_step: Option<ClockStep>,
    /// Number of messages that were logged after one with a later stamp. They are put into order.
    pub(super) n_out_of_order: usize,
    /// Stamps of the first and the last message that is used.
    pub(super) span_ns: Option<[i64; 2]>,
    /// Usual time between two stamps.
    pub(super) period_s: Option<f64>,
    /// Spans without a message that are longer than the declared gap.
    pub(super) gaps_ns: Vec<[i64; 2]>,
    pub(super) account: Account,
}

/// A lasting change of the difference between stamps and times of logging.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ClockStep {
    /// Time of logging of the first message after the step.
    pub(super) logged_ns: i64,
    /// By how much the clock of the stamps was set forward there; `None` where it stops there or goes on at another rate.
    pub(super) by_s: Option<f64>,
}

/// The dropped messages of a topic, by the reason.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Account {
    pub(super) dropped: BTreeMap<&'static str, Dropped>,
}

/// Messages that were dropped for the same reason.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dropped {
    pub(super) count: usize,
    /// Times of logging of the first and the last of these messages.
    pub(super) logged_ns: [i64; 2],
    /// What was found in the first of these messages.
    pub(super) first: String,
}

impl Account {
    /// Notes a dropped message.
    pub(super) fn drop_one(&mut self, reason: &'static str, logged_ns: i64, first: String) {
        let dropped = self.dropped.entry(reason).or_insert(Dropped { count: 0, logged_ns: [logged_ns; 2], first });
        dropped.count += 1;
        dropped.logged_ns[1] = logged_ns;
    }

    /// Number of all dropped messages.
    pub(super) fn n_dropped(&self) -> usize {
        self.dropped.values().map(|dropped| dropped.count).sum()
    }
}

impl Topic {
    /// Notes span, period and gaps of stamps in their order.
    pub(super) fn note_times(&mut self, stamps_ns: &[i64], longest_gap_s: f64) {
        self.span_ns = stamps_ns.first().zip(stamps_ns.last()).map(|(first, last)| [*first, *last]);
        let mut periods_ns: Vec<i64> = stamps_ns.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
        periods_ns.sort_unstable();
        self.period_s = periods_ns.get(periods_ns.len() / 2).map(|period_ns| *period_ns as f64 * 1e-9);
        // Slow topics, such as images or satellite positions, may have a usual period that is longer than the declared gap.
        let longest_s = longest_gap_s.max(PERIODS_OF_A_GAP * self.period_s.unwrap_or(0.0));
        let is_gap = |pair: &&[i64]| pair[1].saturating_sub(pair[0]) as f64 * 1e-9 > longest_s;
        self.gaps_ns = stamps_ns.windows(2).filter(is_gap).map(|pair| [pair[0], pair[1]]).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_named_by_the_stamps_beside_it() {
        let mut topic = Topic::default();
        topic.note_times(&[0, 100_000_000, 200_000_000, 900_000_000], 0.5);
        assert_eq!((topic.period_s, topic.gaps_ns), (Some(0.1), vec![[200_000_000, 900_000_000]]));
        assert_eq!(topic.span_ns, Some([0, 900_000_000]));
    }

    #[test]
    fn messages_that_are_dropped_for_one_reason_are_counted_together() {
        let mut account = Account::default();
        account.drop_one("a", 3, "x".to_owned());
        account.drop_one("a", 5, "y".to_owned());
        account.drop_one("b", 4, String::new());
        assert_eq!(account.dropped["a"], Dropped { count: 2, logged_ns: [3, 5], first: "x".to_owned() });
        assert_eq!(account.n_dropped(), 3);
    }
}
