//! Tests of intervals as text: a printed interval reads back as the same one, and an interval that is read contains the written numbers.

use interval::{Interval, IntervalBox};
use proptest::prelude::*;

/// Generator of random bounds of an interval: any double but NaN by its bits, or a number of ordinary size, whole or not.
fn bound() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), -100.0..100.0f64, (-1000..1000i32).prop_map(f64::from)]
        .prop_filter("a bound is not NaN", |bound| !bound.is_nan())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn printed_intervals_read_back(a in bound(), b in bound(), n_decimals in 0..9usize) {
        let interval = Interval::new(a.min(b), a.max(b));
        prop_assert_eq!(interval.to_string().parse::<Interval>().unwrap(), interval);
        let json = serde_json::to_string(&IntervalBox::new([interval, Interval::EMPTY])).unwrap();
        let read: IntervalBox<2> = serde_json::from_str(&json).unwrap();
        prop_assert_eq!(read[0], interval);
        prop_assert!(read[1].is_empty());
        if !interval.is_empty() {
            let rounded: Interval = format!("{interval:.n_decimals$}").parse().unwrap();
            prop_assert!(interval.is_subset_of(rounded), "{rounded} does not contain {interval}");
            prop_assert!(!(a.abs() < 1e6 && b.abs() < 1e6) || rounded.width() < interval.width() + 4.1 * 0.1f64.powi(n_decimals as i32));
        }
    }
}

#[test]
fn a_tenth_is_between_two_doubles() {
    // The double nearest to 0.1 is above one tenth, so that the interval read from text must reach below it.
    let tenth: Interval = "[0.1]".parse().unwrap();
    assert_eq!((tenth.lo(), tenth.hi()), (0.1f64.next_down(), 0.1));
    let third: Interval = "[1/3, 2/3]".parse().unwrap();
    assert!(third.lo() < 1.0 / 3.0 && third.hi() > 2.0 / 3.0);
}

#[test]
fn text_that_is_no_interval_is_refused() {
    for text in
        ["", "1, 2", "[1, 2", "[2, 1]", "[one]", "[1, 2, 3]", "[nan]", "[inf, inf]", "[0x]", "[1e]", "[--1]", "[1/0]"]
    {
        assert!(text.parse::<Interval>().is_err(), "{text:?} was read as {:?}", text.parse::<Interval>());
    }
    assert!(serde_json::from_str::<IntervalBox<2>>("[\"[0, 1]\"]").is_err());
}
