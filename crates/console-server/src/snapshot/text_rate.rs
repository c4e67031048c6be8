//! Which of a vehicle's texts are shown and logged: each one again only after a while, and not too many.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_vocab::Timestamp;

/// The same text is taken again after this time: ArduPilot repeats what fails before arming every 30 s.
pub(super) const SAME_AFTER: Duration = Duration::from_secs(120);
/// At most so many texts are taken within [`SPAN`].
pub(super) const MAX_TEXTS: usize = 10;
/// The time in which texts are counted.
pub(super) const SPAN: Duration = Duration::from_secs(30);
/// Number of texts that are remembered.
const REMEMBERED: usize = 32;

/// The texts of the last time.
#[derive(Debug, Default)]
pub(super) struct TextRate(VecDeque<(Timestamp, String)>);

impl TextRate {
    /// Whether a text is taken.
    pub(super) fn takes(&mut self, text: &str, now: Timestamp) -> bool {
        let is_known = |(at, known): &(Timestamp, String)| known == text && now.since(*at) < SAME_AFTER;
        let recent = self.0.iter().filter(|(at, _)| now.since(*at) < SPAN).count();
        if recent >= MAX_TEXTS || self.0.iter().any(is_known) {
            return false;
        }
        if self.0.len() == REMEMBERED {
            self.0.pop_front();
        }
        self.0.push_back((now, text.to_owned()));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(s: u64) -> Timestamp {
        Timestamp::from_nanos(s * 1_000_000_000)
    }

    #[test]
    fn a_text_that_repeats_is_taken_once_and_a_flood_is_cut() {
        let mut rate = TextRate::default();
        assert!(rate.takes("PreArm: compass", at(0)));
        assert!(!rate.takes("PreArm: compass", at(30)));
        assert!(rate.takes("PreArm: compass", at(121)));
        let taken = (0..100).filter(|number| rate.takes(&format!("text {number}"), at(200))).count();
        assert_eq!(taken, MAX_TEXTS);
        assert!(rate.takes("another", at(231)));
    }
}
