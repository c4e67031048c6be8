//! The requests of the program to the link thread: the newest rates, and the request to close.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::dead_mans_switch::RequestedRates;
use crate::waker::Waker;

/// The mailbox of the link thread. New rates replace those that the thread has not read yet.
#[derive(Debug)]
pub struct Mailbox {
    contents: Mutex<Contents>,
    waker: Waker,
}

#[derive(Debug, Default)]
struct Contents {
    requested: RequestedRates,
    is_closing: bool,
    takes_control: bool,
    is_stop_sent: bool,
}

/// What the program requests of the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requested {
    /// The rates.
    pub rates: RequestedRates,
    /// Whether the link is to end.
    pub is_closing: bool,
}

impl Mailbox {
    /// An empty mailbox: rest.
    ///
    /// # Errors
    /// If the system has no more file descriptors.
    pub fn new() -> io::Result<Self> {
        Ok(Self { contents: Mutex::default(), waker: Waker::new()? })
    }

    /// Requests rates, and wakes the thread if they have changed.
    pub fn request(&self, requested: RequestedRates) {
        let previous = std::mem::replace(&mut self.contents().requested, requested);
        if previous.rates != requested.rates {
            self.waker.wake();
        }
    }

    /// Requests rest and the end of the link.
    pub fn close(&self) {
        {
            let mut contents = self.contents();
            contents.requested = RequestedRates::REST;
            contents.is_closing = true;
        }
        self.waker.wake();
    }

    /// Requests that the session takes the control of the vehicle back.
    pub fn take_control(&self) {
        self.contents().takes_control = true;
        self.waker.wake();
    }

    /// What is requested.
    pub fn requested(&self) -> Requested {
        let contents = self.contents();
        Requested { rates: contents.requested, is_closing: contents.is_closing }
    }

    /// Whether the control is to be taken back: once for each request.
    pub fn takes_control(&self) -> bool {
        std::mem::take(&mut self.contents().takes_control)
    }

    /// Stores, at the end of the thread, whether it has sent zeros and stop.
    pub fn set_stop_sent(&self, is_stop_sent: bool) {
        self.contents().is_stop_sent = is_stop_sent;
    }

    /// Whether the thread has ended and sent zeros and stop.
    pub fn is_stop_sent(&self) -> bool {
        self.contents().is_stop_sent
    }

    /// Readable once the mailbox has changed.
    pub const fn waker(&self) -> &Waker {
        &self.waker
    }

    fn contents(&self) -> MutexGuard<'_, Contents> {
        // Plain data, whole at any time: a panic elsewhere must not silence the link.
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
