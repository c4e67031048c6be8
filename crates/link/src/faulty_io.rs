//! Deliberate faults of a port: a wrapper of any [`PortIo`], which the link cannot tell from a port that
//! fails.
//!
//! | kind | effect |
//! |---|---|
//! | stall | nothing passes in either direction, and no error |
//! | drop | nothing is sent, and no error |
//! | disconnect | the port is lost, and cannot be opened |
//! | panic | the next call panics, once; after it nothing fails on purpose: the emergency stop is what is tested |
//!
//! Other kinds have no effect on a port.

use std::cell::Cell;
use std::io;
use std::time::Duration;

use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_vocab::Timestamp;

use crate::port::PortError;
use crate::port_io::PortIo;

/// Why a disconnected port fails.
const DISCONNECTED: &str = "disconnected on purpose";

/// A port with planned faults. The times of the plan count from the program's start.
#[derive(Debug)]
pub(crate) struct FaultyIo<I> {
    io: I,
    plan: FaultPlan,
    has_panicked: Cell<bool>,
}

impl<I: PortIo> FaultyIo<I> {
    /// Wraps a port.
    pub(crate) const fn new(io: I, plan: FaultPlan) -> Self {
        Self { io, plan, has_panicked: Cell::new(false) }
    }

    fn is_active(&self, kinds: &[FaultKind]) -> bool {
        let now = self.io.now();
        !self.has_panicked.get() && kinds.iter().any(|kind| self.plan.is_active(*kind, now))
    }

    fn is_disconnected(&self) -> bool {
        self.is_active(&[FaultKind::Disconnect])
    }

    /// Panics if the plan says so.
    fn panic_if_planned(&self) {
        if self.is_active(&[FaultKind::Panic]) {
            self.has_panicked.set(true);
            #[allow(clippy::panic, reason = "requested on the command line, to test the emergency stop")]
            {
                panic!("the link thread panics on purpose");
            }
        }
    }

    /// Panics or fails if the plan says so.
    fn fail_if_planned(&self) -> io::Result<()> {
        self.panic_if_planned();
        if self.is_disconnected() { Err(io::Error::other(DISCONNECTED)) } else { Ok(()) }
    }
}

impl<I: PortIo> PortIo for FaultyIo<I> {
    type Port = I::Port;
    type Sent = I::Sent;
    type Received = I::Received;

    fn now(&self) -> Timestamp {
        self.io.now()
    }

    fn open(&self) -> Result<I::Port, PortError> {
        self.fail_if_planned().map_err(|error| PortError::NotUsable {
            address: "the port".to_owned(),
            reason: error.to_string(),
        })?;
        self.io.open()
    }

    fn send(&self, port: &mut I::Port, packet: &I::Sent) -> io::Result<()> {
        self.fail_if_planned()?;
        if self.is_active(&[FaultKind::Drop, FaultKind::Stall]) {
            return Ok(());
        }
        self.io.send(port, packet)
    }

    fn receive(&self, port: &mut I::Port, each: &mut dyn FnMut(&I::Received)) -> io::Result<()> {
        self.fail_if_planned()?;
        if self.is_active(&[FaultKind::Stall]) {
            return self.io.receive(port, &mut |_| {});
        }
        self.io.receive(port, each)
    }

    /// A disconnected port is readable: reading it fails.
    fn wait(&self, port: Option<&I::Port>, wait: Duration) -> bool {
        self.panic_if_planned();
        let wait = if port.is_some() && self.is_disconnected() { Duration::ZERO } else { wait };
        self.io.wait(port, wait) || (port.is_some() && self.is_disconnected())
    }

    fn sleep(&self, pause: Duration) {
        self.io.sleep(pause);
    }

    fn end_sending(&self, port: &mut I::Port) -> bool {
        self.io.end_sending(port)
    }
}
