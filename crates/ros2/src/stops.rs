//! Stops: sent at once, and repeated until the console confirms them.
//!
//! Each press has a number. The socket sends a press once, as its line delivers in order; requests on lines
//! of their own repeat the newest press. An accepted stop confirms its press and all before.

use std::time::Duration;

use barrelman_vocab::{OperatorRequest, StopCause};
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until, timeout};

use crate::console::api::AnswerKind;
use crate::console::line::Line;
use crate::console::request::post;

/// Between repetitions.
const REPEAT: Duration = Duration::from_millis(100);
/// A repetition is given up after this time, and the next one begins.
const GIVE_UP: Duration = Duration::from_secs(1);

/// The presses so far, and those that are confirmed.
#[derive(Debug)]
pub struct Stops {
    pressed: watch::Sender<u64>,
    confirmed: watch::Sender<u64>,
}

impl Default for Stops {
    fn default() -> Self {
        Self { pressed: watch::Sender::new(0), confirmed: watch::Sender::new(0) }
    }
}

impl Stops {
    /// A stop was called. Returns the number of the press, from 1.
    pub fn press(&self) -> u64 {
        let mut number = 0;
        self.pressed.send_modify(|pressed| {
            *pressed += 1;
            number = *pressed;
        });
        number
    }

    /// The number of the newest press, whenever it changes.
    pub fn presses(&self) -> watch::Receiver<u64> {
        self.pressed.subscribe()
    }

    /// The console has accepted a stop that was sent for this press.
    pub fn confirm(&self, number: u64) {
        let number = number.min(*self.pressed.borrow());
        self.confirmed.send_if_modified(|confirmed| {
            let is_newer = number > *confirmed;
            *confirmed = number.max(*confirmed);
            is_newer
        });
    }

    /// Whether a press is not confirmed.
    pub fn is_pending(&self) -> bool {
        *self.pressed.borrow() > *self.confirmed.borrow()
    }

    /// Waits until a press is confirmed.
    pub async fn confirmed(&self, number: u64) {
        // The sender lives as long as `self`.
        let _ = self.confirmed.subscribe().wait_for(|confirmed| *confirmed >= number).await;
    }

    /// Waits until there is a press after this one.
    pub async fn pressed_after(&self, number: u64) {
        let _ = self.pressed.subscribe().wait_for(|pressed| *pressed > number).await;
    }

    fn newest(&self) -> u64 {
        *self.pressed.borrow()
    }
}

/// Repeats what is not confirmed, for ever.
pub async fn repeat(line: &Line, stops: &Stops) {
    let stop = OperatorRequest::Stop(StopCause::Operator).into();
    loop {
        if !stops.is_pending() {
            stops.pressed_after(stops.newest()).await;
        }
        let (number, began) = (stops.newest(), Instant::now());
        tokio::select! {
            answer = timeout(GIVE_UP, post(line, &stop)) => {
                // What failed is repeated; whoever called the stop hears of it in time.
                if let Ok(Ok(answer)) = answer && answer.answer == AnswerKind::Accepted {
                    stops.confirm(number);
                }
            }
            () = stops.confirmed(number) => {}
        }
        tokio::select! {
            () = sleep_until(began + REPEAT) => {}
            () = stops.pressed_after(number) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;

    use super::*;

    #[test]
    fn a_press_is_confirmed_by_a_stop_that_was_sent_for_it_or_for_a_later_one() {
        let stops = Stops::default();
        assert!(!stops.is_pending());
        let (first, second) = (stops.press(), stops.press());
        stops.confirm(first);
        assert!(stops.is_pending(), "a stop that was sent before the second press says nothing of it");
        assert_eq!(stops.confirmed(first).now_or_never(), Some(()));
        assert_eq!(stops.confirmed(second).now_or_never(), None);
        stops.confirm(second);
        stops.confirm(first);
        assert!(!stops.is_pending());
        assert_eq!(stops.pressed_after(second).now_or_never(), None);
        stops.press();
        assert!(stops.is_pending() && stops.pressed_after(second).now_or_never().is_some());
    }

    #[test]
    fn an_answer_to_a_press_that_was_never_made_confirms_nothing_to_come() {
        let stops = Stops::default();
        stops.press();
        stops.confirm(9);
        assert!(!stops.is_pending());
        stops.press();
        assert!(stops.is_pending());
    }
}
