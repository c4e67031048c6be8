//! What the service manager (systemd) hears of a run: that the run is ready, that its loop makes turns, that
//! it ends.
//!
//! The service manager starts a program again whose loop makes no turns. So the loop itself gives each sign
//! of life, by asking for its next event. The thread that passes the signs on gives none of its own: a
//! service manager that takes nothing holds up that thread, and not the loop.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use barrelman_host::threads;
use barrelman_vocab::Timestamp;
use sd_notify::NotifyState;

use super::event::{Event, EventSource, report_panics};

/// The variable by which a service manager says where it listens (`sd_notify(3)`).
pub(super) const SOCKET: &str = "NOTIFY_SOCKET";
/// Signs of life in the time after which the service manager takes the program for hanging.
const SIGNS_IN_TIMEOUT: u32 = 4;
/// Signs that may wait. One that finds no room is dropped.
const MAX_WAITING: usize = 4;

/// Whether a service manager started this process and listens.
pub fn is_a_service() -> bool {
    std::env::var_os(SOCKET).is_some()
}

/// A sign for the service manager.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    /// The run has begun.
    Ready,
    /// The loop makes turns.
    Alive,
    /// The run ends.
    Ending,
}

impl Sign {
    const fn state(self) -> NotifyState<'static> {
        match self {
            Self::Ready => NotifyState::Ready,
            Self::Alive => NotifyState::Watchdog,
            Self::Ending => NotifyState::Stopping,
        }
    }
}

/// The service manager of this process.
#[derive(Debug)]
pub(super) struct ServiceManager {
    signs: SyncSender<Sign>,
    /// How often it wants a sign of life; `None`: never.
    interval: Option<Duration>,
}

impl ServiceManager {
    /// The service manager, if one started this process and listens.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub(super) fn of_this_process(events: SyncSender<Event>) -> std::io::Result<Option<Self>> {
        if !is_a_service() {
            return Ok(None);
        }
        let interval = sd_notify::watchdog_enabled().map(|timeout| timeout / SIGNS_IN_TIMEOUT);
        let (signs, waiting) = sync_channel(MAX_WAITING);
        // Not joined: it may be held up, and ends with the program.
        drop(threads::spawn("supervision", report_panics(events), move || pass_on(&waiting))?);
        Ok(Some(Self { signs, interval }))
    }

    /// The events of the run loop, whose every turn is a sign of life.
    pub(super) fn events<'a>(&'a self, events: Box<dyn EventSource + 'a>) -> Box<dyn EventSource + 'a> {
        Box::new(Supervised { inner: events, manager: self, next_sign_at: None, is_ready: false })
    }

    /// The run ends: from here on, no sign of life is expected.
    pub(super) fn say_ending(&self) {
        self.say(Sign::Ending);
    }

    fn say(&self, sign: Sign) {
        let _ = self.signs.try_send(sign);
    }
}

fn pass_on(signs: &Receiver<Sign>) {
    let mut is_failing = false;
    for sign in signs {
        let told = sd_notify::notify(&[sign.state()]);
        // Said once: the service manager ends a program that it does not hear.
        if let (Err(error), false) = (&told, is_failing) {
            tracing::error!("the service manager cannot be told that the program is {sign:?}: {error}");
        }
        is_failing = told.is_err();
    }
}

/// The events of the run loop, with the signs.
struct Supervised<'a> {
    inner: Box<dyn EventSource + 'a>,
    manager: &'a ServiceManager,
    next_sign_at: Option<Timestamp>,
    is_ready: bool,
}

impl EventSource for Supervised<'_> {
    fn now(&self) -> Timestamp {
        self.inner.now()
    }

    fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError> {
        if !std::mem::replace(&mut self.is_ready, true) {
            self.manager.say(Sign::Ready);
        }
        if let Some(interval) = self.manager.interval {
            let now = self.inner.now();
            if self.next_sign_at.is_none_or(|at| at <= now) {
                self.manager.say(Sign::Alive);
                self.next_sign_at = Some(now.plus(interval));
            }
        }
        self.inner.next_event(wait)
    }

    fn suspension(&mut self) -> Option<Duration> {
        self.inner.suspension()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Events without end, none of which arrives: each wait takes its time.
    struct Quiet(Timestamp);

    impl EventSource for Quiet {
        fn now(&self) -> Timestamp {
            self.0
        }

        fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError> {
            self.0 = self.0.plus(wait);
            Err(RecvTimeoutError::Timeout)
        }
    }

    /// The signs of a loop that makes as many turns of 0.2 s, and then hangs.
    fn signs_of(turns: usize, interval: Option<Duration>) -> Vec<Sign> {
        let (signs, said) = sync_channel(100);
        let manager = ServiceManager { signs, interval };
        let mut events = manager.events(Box::new(Quiet(Timestamp::ZERO)));
        for _ in 0..turns {
            assert_eq!(events.next_event(Duration::from_millis(200)).err(), Some(RecvTimeoutError::Timeout));
        }
        drop(events);
        manager.say_ending();
        drop(manager);
        said.iter().collect()
    }

    #[test]
    fn only_turns_of_the_loop_are_signs_of_life() {
        use Sign::{Alive, Ending, Ready};
        let second = Some(Duration::from_secs(1));
        assert_eq!(signs_of(0, second), [Ending]);
        assert_eq!(signs_of(1, second), [Ready, Alive, Ending]);
        // Turns at 0, 0.2, 0.4, 0.6, 0.8 and 1 s.
        assert_eq!(signs_of(6, second), [Ready, Alive, Alive, Ending]);
        assert_eq!(signs_of(16, second), [Ready, Alive, Alive, Alive, Alive, Ending]);
        assert_eq!(signs_of(16, None), [Ready, Ending]);
    }

    #[test]
    fn a_service_manager_that_takes_nothing_delays_nobody() {
        let (signs, waiting) = sync_channel(1);
        let manager = ServiceManager { signs, interval: None };
        for _ in 0..10 {
            manager.say(Sign::Alive);
        }
        assert_eq!(waiting.try_iter().count(), 1);
    }
}
