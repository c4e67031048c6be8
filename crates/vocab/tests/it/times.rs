//! Timestamps: saturating arithmetic and conversions.

use core::time::Duration;

use barrelman_vocab::Timestamp;

const END: Timestamp = Timestamp::from_nanos(u64::MAX);

#[test]
fn time_saturates_at_both_ends() {
    let second = Duration::from_secs(1);
    assert_eq!(Timestamp::ZERO.minus(second), Timestamp::ZERO);
    assert_eq!(Timestamp::from_nanos(5).minus(Duration::from_nanos(6)), Timestamp::ZERO);
    assert_eq!(END.plus(second), END);
    assert_eq!(Timestamp::from_nanos(1).plus(Duration::MAX), END);
    assert_eq!(END.minus(Duration::MAX), Timestamp::ZERO);
}

#[test]
fn what_is_not_after_a_moment_is_no_time_since_it() {
    let (early, late) = (Timestamp::from_nanos(3), Timestamp::from_nanos(10));
    assert_eq!(late.since(early), Duration::from_nanos(7));
    assert_eq!(early.since(late), Duration::ZERO);
    assert_eq!(early.since(early), Duration::ZERO);
    assert_eq!(END.since(Timestamp::ZERO), Duration::from_nanos(u64::MAX));
}

#[test]
fn seconds_become_nanoseconds() {
    let check = |seconds: f64, nanos: u64| {
        assert_eq!(Timestamp::from_secs_f64(seconds), Timestamp::from_nanos(nanos), "{seconds} s");
    };
    check(0.0, 0);
    check(1.5, 1_500_000_000);
    check(-1.0, 0);
    check(f64::NAN, 0);
    check(f64::NEG_INFINITY, 0);
    check(f64::INFINITY, u64::MAX);
    check(1e300, u64::MAX);
}

#[test]
fn plus_and_minus_undo_each_other() {
    let moment = Timestamp::from_nanos(1_000);
    let span = Duration::from_nanos(250);
    assert_eq!(moment.plus(span).minus(span), moment);
    assert_eq!(moment.plus(span).since(moment), span);
}
