//! What the guard's worker uses of the machine: the port, and the pipe to the program, in one wait.

use std::cell::{Cell, RefCell};
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::suspend::SuspendWatch;
use barrelman_vocab::Timestamp;
use rustix::event::{PollFd, PollFlags};

use super::gate::{Gate, GuardedCommand};
use super::message::{FromGuard, MessageCommand, ToGuard};
use super::pipe::{Pipe, PipeRead};
use super::watch::BEAT;
use crate::port::{Port, PortError};
use crate::port_io::{MachineIo, PortIo, poll_for};

/// The guard's port, pipe and clock. What comes through the pipe goes to the mailbox, as far as the gate lets
/// it pass.
pub(super) struct PipeIo<C> {
    pub(super) machine: MachineIo<C>,
    pub(super) pipe: Arc<Pipe>,
    pub(super) gate: RefCell<Gate<C>>,
    pub(super) suspend: RefCell<SuspendWatch>,
    /// Readable when the guard was asked to end by a signal.
    pub(super) signalled: OwnedFd,
    pub(super) last_alive: Cell<Timestamp>,
    /// Whether the program can still be heard.
    pub(super) is_connected: Cell<bool>,
}

impl<C: GuardedCommand + MessageCommand> PipeIo<C> {
    /// Takes what the program says. The end of the pipe, silence and what cannot be read close the link.
    fn serve_pipe(&self) {
        if let Some(gap) = self.suspend.borrow_mut().check() {
            self.machine.mailbox.rest();
            self.pipe.send(&FromGuard::Suspended(gap).encode());
        }
        while self.is_connected.get() {
            let now = self.machine.clock.now();
            match self.pipe.read() {
                PipeRead::Nothing => break,
                PipeRead::End => self.disconnect(),
                PipeRead::Message(packet) => {
                    self.gate.borrow_mut().heard(now);
                    match ToGuard::<C>::decode(&packet) {
                        Ok(ToGuard::Request(requested)) => {
                            self.machine.mailbox.request(self.gate.borrow().pass(requested, now));
                        }
                        Ok(ToGuard::TakeControl) => self.machine.mailbox.take_control(),
                        Ok(ToGuard::Close) => self.machine.mailbox.close(),
                        Ok(ToGuard::Settings(_)) | Err(_) => self.disconnect(),
                    }
                }
            }
        }
        let now = self.machine.clock.now();
        if self.is_connected.get() && self.gate.borrow().is_silent(now) {
            self.disconnect();
        }
        self.beat(now);
    }

    /// Says that the guard runs, where that is due.
    fn beat(&self, now: Timestamp) {
        if now.since(self.last_alive.get()) >= BEAT {
            self.beat_now(now);
        }
    }

    fn beat_now(&self, now: Timestamp) {
        self.last_alive.set(now);
        self.pipe.send(&FromGuard::Alive.encode());
    }

    fn disconnect(&self) {
        self.is_connected.set(false);
        self.machine.mailbox.close();
    }
}

impl<C: GuardedCommand + MessageCommand> PortIo for PipeIo<C> {
    type Port = Port;
    type Sent = Vec<u8>;
    type Received = [u8];

    fn now(&self) -> Timestamp {
        self.machine.now()
    }

    fn open(&self) -> Result<Port, PortError> {
        self.pipe.send(&FromGuard::OpensPort.encode());
        let opened = self.machine.open();
        self.beat_now(self.now());
        opened
    }

    fn send(&self, port: &mut Port, packet: &Vec<u8>) -> io::Result<()> {
        let sent = self.machine.send(port, packet);
        // A port that is slow to take its bytes is no guard that hangs.
        self.beat(self.now());
        sent
    }

    fn receive(&self, port: &mut Port, each: &mut dyn FnMut(&[u8])) -> io::Result<()> {
        self.machine.receive(port, &mut |bytes| {
            self.pipe.send(&FromGuard::Received(self.now(), bytes.to_vec()).encode());
            each(bytes);
        })
    }

    fn wait(&self, port: Option<&Port>, wait: Duration) -> bool {
        let wait = wait.min(BEAT.saturating_sub(self.now().since(self.last_alive.get())));
        // A pipe at its end, and a signal, are readable for ever.
        let watched = if self.is_connected.get() { PollFlags::IN } else { PollFlags::empty() };
        let until_signal =
            if self.machine.mailbox.requested().is_closing { PollFlags::empty() } else { PollFlags::IN };
        let pipe = PollFd::new(&*self.pipe, watched);
        let signal = PollFd::new(&self.signalled, until_signal);
        let (is_readable, is_signalled) = match port {
            Some(port) => {
                let mut fds = [signal, PollFd::new(port, PollFlags::IN), pipe];
                poll_for(if self.is_connected.get() { &mut fds } else { &mut fds[..2] }, wait);
                (!fds[1].revents().is_empty(), fds[0].revents().contains(PollFlags::IN))
            }
            None => {
                let mut fds = [signal, pipe];
                poll_for(if self.is_connected.get() { &mut fds } else { &mut fds[..1] }, wait);
                (false, fds[0].revents().contains(PollFlags::IN))
            }
        };
        if is_signalled {
            self.machine.mailbox.close();
        }
        self.serve_pipe();
        is_readable
    }

    fn end_sending(&self, port: &mut Port) -> bool {
        self.machine.end_sending(port)
    }

    fn sleep(&self, pause: Duration) {
        let mut left = pause;
        while !left.is_zero() {
            let slice = left.min(BEAT);
            std::thread::sleep(slice);
            left -= slice;
            self.beat(self.now());
        }
    }
}
