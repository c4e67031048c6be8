//! What was sent to a page that the page has not handled yet, by the page's own counts.
//!
//! The buffers between the program and a page (of both systems, of the network, of the browser) hold many
//! seconds of video. A page that is slower than what is sent would show an ever older past. A page therefore
//! says how many messages it has handled, and gets no more ahead than it handles in [`WINDOW`].

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;

/// What is under way to a page is at most what it has handled within this time: by about so much is it late.
const WINDOW: Duration = Duration::from_millis(750);
/// Messages that are sent to a page that has handled none lately.
const START: usize = 2;

/// The snapshots and video messages under way to one page.
#[derive(Debug, Default)]
pub(super) struct InFlight {
    /// Of each message that is not handled, oldest first: whether it is video.
    unhandled: VecDeque<bool>,
    /// When messages were handled within the window, and how many.
    handled: VecDeque<(Instant, usize)>,
    /// Messages that were sent on this connection.
    sent: u64,
    /// Whether the page says what it has handled. Nothing is counted for a client that never does.
    is_told: bool,
}

impl InFlight {
    /// A snapshot or a video message was sent.
    pub(super) fn add(&mut self, is_video: bool) {
        self.sent += 1;
        if self.is_told {
            self.unhandled.push_back(is_video);
        }
    }

    /// The page has handled so many snapshots and video messages since it connected. A number of messages
    /// that were not sent counts as all.
    pub(super) fn on_handled(&mut self, count: u64, now: Instant) {
        self.is_told = true;
        let left = usize::try_from(self.sent.saturating_sub(count)).unwrap_or(usize::MAX);
        let handled = self.unhandled.len().saturating_sub(left);
        self.unhandled.drain(..handled);
        while self.handled.front().is_some_and(|(at, _)| now.duration_since(*at) > WINDOW) {
            self.handled.pop_front();
        }
        if handled > 0 {
            self.handled.push_back((now, handled));
        }
    }

    /// Whether the page gets neither snapshots nor video until it has handled more.
    pub(super) fn is_full(&self, now: Instant) -> bool {
        let lately = self.handled.iter().filter(|(at, _)| now.duration_since(*at) <= WINDOW);
        self.unhandled.len() >= START + lately.map(|(_, count)| count).sum::<usize>()
    }

    /// Snapshots and video messages that were sent on this connection.
    pub(super) const fn sent(&self) -> u64 {
        self.sent
    }

    /// Video messages that the page has not handled.
    pub(super) fn videos(&self) -> usize {
        self.unhandled.iter().filter(|is_video| **is_video).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_gets_no_more_ahead_than_it_has_handled_lately() {
        let (mut in_flight, start) = (InFlight::default(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        in_flight.on_handled(0, at(0));
        in_flight.add(true);
        assert!(!in_flight.is_full(at(0)));
        in_flight.add(false);
        assert!(in_flight.is_full(at(0)));
        in_flight.on_handled(2, at(100));
        for _ in 0..3 {
            in_flight.add(true);
        }
        assert_eq!((in_flight.is_full(at(100)), in_flight.videos()), (false, 3));
        in_flight.add(true);
        assert!(in_flight.is_full(at(100)), "two to start with, and two that were handled");
        in_flight.on_handled(5, at(200));
        assert_eq!((in_flight.is_full(at(200)), in_flight.is_full(at(1000))), (false, false));
        in_flight.add(false);
        assert!(in_flight.is_full(at(1000)), "what was handled long ago does not count");
        in_flight.on_handled(99, at(1000));
        assert_eq!(in_flight.videos(), 0, "more than was sent counts as all");
    }

    #[test]
    fn a_client_that_does_not_say_what_it_handled_gets_everything() {
        let (mut in_flight, start) = (InFlight::default(), Instant::now());
        for _ in 0..100 {
            in_flight.add(true);
        }
        assert!(!in_flight.is_full(start));
        in_flight.on_handled(1, start);
        assert_eq!(in_flight.videos(), 0, "what was sent before is not counted");
    }
}
