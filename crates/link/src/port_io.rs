//! What the link thread uses of the machine: the time, its port, and waiting.

use std::io;
use std::os::fd::AsFd;
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_vocab::{LinkCommand, Timestamp};
use rustix::event::{PollFd, PollFlags, poll};

use crate::mailbox::Mailbox;
use crate::port::{Port, PortError};
use crate::url::Endpoint;

/// The time, a port, and waiting.
pub trait PortIo {
    /// An open port.
    type Port;
    /// A packet that the port sends.
    type Sent;
    /// A packet that the port receives.
    type Received: ?Sized;

    /// The time now.
    fn now(&self) -> Timestamp;

    /// Opens the port.
    ///
    /// # Errors
    /// [`PortError`] names the port and the remedy.
    fn open(&self) -> Result<Self::Port, PortError>;

    /// Sends a packet, or fails within a bounded time.
    ///
    /// # Errors
    /// If the port is lost.
    fn send(&self, port: &mut Self::Port, packet: &Self::Sent) -> io::Result<()>;

    /// Passes what has arrived to `each`. Does not block.
    ///
    /// # Errors
    /// If the port is lost.
    fn receive(&self, port: &mut Self::Port, each: &mut dyn FnMut(&Self::Received)) -> io::Result<()>;

    /// Waits until something arrives at `port` or the mailbox is changed, at most for `wait`. Returns whether
    /// the port is readable.
    fn wait(&self, port: Option<&Self::Port>, wait: Duration) -> bool;

    /// Waits for the whole of `pause`.
    fn sleep(&self, pause: Duration);

    /// Tells the other end that nothing more is sent. Returns whether the port is a connection, which has the
    /// packets that were sent in its keeping until the other end has taken them.
    fn end_sending(&self, _port: &mut Self::Port) -> bool {
        false
    }
}

/// Largest part of a stream that is read at once, and largest datagram, bytes.
const MAX_READ_BYTES: usize = 2048;

/// The program's clock and a port that carries bytes.
#[derive(Debug)]
pub(crate) struct MachineIo<C> {
    pub(crate) endpoint: Endpoint,
    pub(crate) clock: Clock,
    pub(crate) mailbox: Arc<Mailbox<C>>,
}

impl<C: LinkCommand> PortIo for MachineIo<C> {
    type Port = Port;
    type Sent = Vec<u8>;
    type Received = [u8];

    fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn open(&self) -> Result<Port, PortError> {
        Port::open(&self.endpoint)
    }

    fn send(&self, port: &mut Port, packet: &Vec<u8>) -> io::Result<()> {
        port.write_all(packet)
    }

    fn receive(&self, port: &mut Port, each: &mut dyn FnMut(&[u8])) -> io::Result<()> {
        let mut buffer = [0; MAX_READ_BYTES];
        let read = port.read(&mut buffer)?;
        each(&buffer[..read]);
        Ok(())
    }

    fn wait(&self, port: Option<&Port>, wait: Duration) -> bool {
        wait_for_port(&self.mailbox, port, wait)
    }

    fn sleep(&self, pause: Duration) {
        std::thread::sleep(pause);
    }

    fn end_sending(&self, port: &mut Port) -> bool {
        port.end_sending()
    }
}

/// Waits until something arrives at `port` or the mailbox is changed, at most for `wait`. Returns whether the
/// port is readable.
pub fn wait_for_port<C: LinkCommand>(mailbox: &Mailbox<C>, port: Option<&impl AsFd>, wait: Duration) -> bool {
    let waker = PollFd::new(mailbox.waker(), PollFlags::IN);
    let is_readable = match port {
        Some(port) => {
            let mut fds = [waker, PollFd::new(port, PollFlags::IN)];
            poll_for(&mut fds, wait);
            !fds[1].revents().is_empty()
        }
        None => {
            poll_for(&mut [waker], wait);
            false
        }
    };
    mailbox.waker().clear();
    is_readable
}

/// Waits until one of the descriptors is ready, at most for `wait`, which is at most an hour.
pub fn poll_for(fds: &mut [PollFd<'_>], wait: Duration) {
    // Waits are at most a second long: the conversion succeeds.
    let timeout = rustix::event::Timespec::try_from(wait).ok();
    // An interrupted wait is a short wait.
    let _ = poll(fds, timeout.as_ref());
}
