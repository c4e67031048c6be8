//! The requests of the program to the link thread: the newest command, and the request to close.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use barrelman_vocab::{LinkCommand, VehicleRates};

use crate::dead_mans_switch::RequestedCommand;
use crate::waker::Waker;

/// The mailbox of the link thread. A new command replaces one that the thread has not read yet.
#[derive(Debug)]
pub struct Mailbox<C = VehicleRates> {
    contents: Mutex<Contents<C>>,
    waker: Waker,
}

#[derive(Debug, Default)]
struct Contents<C> {
    requested: RequestedCommand<C>,
    is_closing: bool,
    takes_control: bool,
    is_stop_sent: bool,
}

/// What the program requests of the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requested<C> {
    /// The command.
    pub command: RequestedCommand<C>,
    /// Whether the link is to end.
    pub is_closing: bool,
}

impl<C: LinkCommand> Mailbox<C> {
    /// An empty mailbox: rest, or a vessel that is not commanded.
    ///
    /// # Errors
    /// If the system has no more file descriptors.
    pub fn new() -> io::Result<Self> {
        Ok(Self { contents: Mutex::default(), waker: Waker::new()? })
    }

    /// Requests a command, and wakes the thread if it has changed.
    pub fn request(&self, requested: RequestedCommand<C>) {
        let previous = std::mem::replace(&mut self.contents().requested, requested);
        if previous.command != requested.command {
            self.waker.wake();
        }
    }

    /// Requests rest, unless what is requested moves nothing: a boat that is not commanded is left alone.
    pub fn rest(&self) {
        let is_at_rest = self.contents().requested.command.is_rest();
        if !is_at_rest {
            self.request(RequestedCommand::REST);
        }
    }

    /// Requests rest and the end of the link.
    pub fn close(&self) {
        {
            let mut contents = self.contents();
            contents.requested = RequestedCommand::REST;
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
    pub fn requested(&self) -> Requested<C> {
        let contents = self.contents();
        Requested { command: contents.requested, is_closing: contents.is_closing }
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

    fn contents(&self) -> MutexGuard<'_, Contents<C>> {
        // Plain data, whole at any time: a panic elsewhere must not silence the link.
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{VesselCommand, VesselOrder};

    use super::*;

    #[test]
    fn rest_leaves_a_boat_alone_that_is_not_commanded() {
        let moving = VesselOrder::Commanded(VesselCommand { throttle: 0.5, rudder: 0.0 });
        for (before, after) in
            [(VesselOrder::Released, VesselOrder::Released), (moving, VesselOrder::NEUTRAL)]
        {
            let mailbox = Mailbox::new().unwrap();
            mailbox.request(RequestedCommand { command: before, renew_by: None });
            mailbox.rest();
            assert_eq!(mailbox.requested().command.command, after);
        }
    }
}
