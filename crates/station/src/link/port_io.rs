//! What the link thread uses of the machine: the time, its port, and waiting.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_vocab::Timestamp;
use rustix::event::{PollFd, PollFlags, poll};

use super::mailbox::Mailbox;
use super::port::{Port, PortError};
use super::url::Endpoint;

/// The time, a port, and waiting.
pub(super) trait PortIo {
    /// An open port.
    type Port;

    /// The time now.
    fn now(&self) -> Timestamp;

    /// Opens the port.
    fn open(&self) -> Result<Self::Port, PortError>;

    /// Writes all bytes, or fails within a bounded time.
    fn write_all(&self, port: &mut Self::Port, bytes: &[u8]) -> io::Result<()>;

    /// Reads the bytes that have arrived. Does not block.
    fn read(&self, port: &mut Self::Port, buffer: &mut [u8]) -> io::Result<usize>;

    /// Waits until bytes arrive at `port` or the mailbox is changed, at most for `wait`. Returns whether the port is
    /// readable.
    fn wait(&self, port: Option<&Self::Port>, wait: Duration) -> bool;

    /// Waits for the whole of `pause`.
    fn sleep(&self, pause: Duration);
}

/// The program's clock and a real port.
#[derive(Debug)]
pub(super) struct MachineIo {
    pub(super) endpoint: Endpoint,
    pub(super) clock: Clock,
    pub(super) mailbox: Arc<Mailbox>,
}

impl PortIo for MachineIo {
    type Port = Port;

    fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn open(&self) -> Result<Port, PortError> {
        Port::open(&self.endpoint)
    }

    fn write_all(&self, port: &mut Port, bytes: &[u8]) -> io::Result<()> {
        port.write_all(bytes)
    }

    fn read(&self, port: &mut Port, buffer: &mut [u8]) -> io::Result<usize> {
        port.read(buffer)
    }

    fn wait(&self, port: Option<&Port>, wait: Duration) -> bool {
        let waker = self.mailbox.waker();
        let waker = PollFd::from_borrowed_fd(waker, PollFlags::IN);
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
        self.mailbox.clear_wake_ups();
        is_readable
    }

    fn sleep(&self, pause: Duration) {
        std::thread::sleep(pause);
    }
}

fn poll_for(fds: &mut [PollFd<'_>], wait: Duration) {
    // Waits are at most a second long: the conversion succeeds.
    let timeout = rustix::event::Timespec::try_from(wait).ok();
    // An interrupted wait is a short wait.
    let _ = poll(fds, timeout.as_ref());
}
