//! The requests of the program to the link thread: the newest rates, and the request to close.

use std::io;
use std::os::fd::{AsFd as _, BorrowedFd, OwnedFd};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rustix::event::EventfdFlags;

use super::dead_mans_switch::RequestedRates;

/// The mailbox of the link thread. New rates replace those that the thread has not read yet.
#[derive(Debug)]
pub(super) struct Mailbox {
    contents: Mutex<Contents>,
    waker: OwnedFd,
}

#[derive(Debug, Default)]
struct Contents {
    requested: RequestedRates,
    is_closing: bool,
    is_stop_sent: bool,
}

impl Mailbox {
    /// An empty mailbox: rest.
    ///
    /// # Errors
    /// If the system has no more file descriptors.
    pub(super) fn new() -> io::Result<Self> {
        let waker = rustix::event::eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self { contents: Mutex::default(), waker })
    }

    /// Requests rates, and wakes the thread if they have changed.
    pub(super) fn request(&self, requested: RequestedRates) {
        let previous = std::mem::replace(&mut self.contents().requested, requested);
        if previous.rates != requested.rates {
            self.wake();
        }
    }

    /// Requests rest and the end of the link.
    pub(super) fn close(&self) {
        {
            let mut contents = self.contents();
            contents.requested.rates = RequestedRates::REST.rates;
            contents.is_closing = true;
        }
        self.wake();
    }

    /// The requested rates, and whether the link must be closed.
    pub(super) fn requested(&self) -> (RequestedRates, bool) {
        let contents = self.contents();
        (contents.requested, contents.is_closing)
    }

    /// Stores, at the end of the thread, whether it has sent zeros and stop.
    pub(super) fn set_stop_sent(&self, is_stop_sent: bool) {
        self.contents().is_stop_sent = is_stop_sent;
    }

    /// Whether the thread has ended and sent zeros and stop.
    pub(super) fn is_stop_sent(&self) -> bool {
        self.contents().is_stop_sent
    }

    /// Readable after a wake-up, until [`Self::clear_wake_ups`].
    pub(super) fn waker(&self) -> BorrowedFd<'_> {
        self.waker.as_fd()
    }

    /// Forgets the wake-ups so far.
    pub(super) fn clear_wake_ups(&self) {
        let mut count = [0; 8];
        let _ = rustix::io::read(&self.waker, &mut count);
    }

    fn wake(&self) {
        // A full counter already wakes the thread.
        let _ = rustix::io::write(&self.waker, &1_u64.to_ne_bytes());
    }

    fn contents(&self) -> MutexGuard<'_, Contents> {
        // Plain data, whole at any time: a panic elsewhere must not silence the link.
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
