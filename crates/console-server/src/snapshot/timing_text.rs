//! What the times of the pictures tell, in words.

use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::Timestamp;
use jiff::Zoned;

/// The state of the times in words; `None`: the pictures are in time. `wall_now`: the time of day at `now`.
pub(super) fn timing_text(timing: VideoTiming, now: Timestamp, wall_now: &Zoned) -> Option<String> {
    match timing {
        VideoTiming::InTime => None,
        VideoTiming::Late { by, since } => {
            let ago = now.since(since);
            let since = wall_now.checked_sub(ago).unwrap_or_else(|_| wall_now.clone());
            Some(format!(
                "video {:.1} s late since {}; reconnect",
                by.as_secs_f64(),
                since.strftime("%H:%M:%S")
            ))
        }
        VideoTiming::ClockWrong(fault) => {
            Some(format!("the camera's clock is wrong: times of arrival are used ({fault})"))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use barrelman_video::sender_clock::ClockFault;

    use super::*;

    fn check(timing: VideoTiming, expected: Option<&str>) {
        let wall_now: Zoned = "2026-11-28T14:03:30+00:00[UTC]".parse().unwrap();
        let text = timing_text(timing, Timestamp::from_nanos(60_000_000_000), &wall_now);
        assert_eq!(text.as_deref(), expected);
    }

    #[test]
    fn a_delay_is_told_with_its_beginning_by_the_time_of_day() {
        let since = Timestamp::from_nanos(50_000_000_000);
        let late = VideoTiming::Late { by: Duration::from_millis(2960), since };
        check(late, Some("video 3.0 s late since 14:03:20; reconnect"));
        check(VideoTiming::InTime, None);
    }

    #[test]
    fn a_wrong_clock_is_told_with_what_is_wrong() {
        let wrong = VideoTiming::ClockWrong(ClockFault::Rate(0.75));
        let expected =
            "the camera's clock is wrong: times of arrival are used (it runs at 75 % of true time)";
        check(wrong, Some(expected));
    }
}
