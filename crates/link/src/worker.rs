//! The link's worker: drives a [`LinkCore`] on one port, by the clock. The worker decides nothing.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::fault::FaultPlan;
use barrelman_wire::{LinkHistory, Session, WillStep};

use crate::faulty_io::FaultyIo;
use crate::link_core::{LinkAction, LinkCore, SessionOpener};
use crate::mailbox::Mailbox;
use crate::port_io::PortIo;
use crate::report::LinkReport;

#[cfg(test)]
mod arrival_tests;
#[cfg(test)]
mod request_tests;
#[cfg(test)]
mod tests;

/// Pause before a report is offered again that must not be lost.
const REPORT_PAUSE: Duration = Duration::from_millis(20);
/// How often it is offered, at most: for ten seconds. The program may be gone.
const REPORT_ATTEMPTS: u32 = 500;

/// Longest wait for the other end to take what was sent last.
const ARRIVAL_TIME: Duration = Duration::from_millis(500);

/// The work of a link's thread, or of the guard.
pub struct Worker<S: Session + ?Sized, I, R> {
    /// How long a link that is closing goes on trying to reach its vehicle.
    pub persistence: Duration,
    /// The program's requests.
    pub mailbox: Arc<Mailbox<S::Command>>,
    /// The time, the port, and waiting.
    pub io: I,
    /// What a link before this one has left.
    pub history: LinkHistory,
    /// Opens a session with the vehicle.
    pub open_session: Arc<dyn Fn(barrelman_vocab::Timestamp) -> Box<S> + Send + Sync>,
    /// Takes the reports of the thread. Returns whether there was room for the report. Must not block.
    pub report: R,
}

impl<S, I, R> Worker<S, I, R>
where
    S: Session + ?Sized + 'static,
    I: PortIo<Sent = S::Sent, Received = S::Received>,
    R: Fn(LinkReport) -> bool,
{
    /// Serves the port, which has these deliberate faults, until the link is closed. A panic sends the
    /// emergency stop.
    pub fn run(self, port: Option<I::Port>, faults: FaultPlan) {
        if faults.is_empty() {
            return self.serve_guarded(port);
        }
        let Self { persistence, mailbox, io, history, open_session, report } = self;
        let io = FaultyIo::new(io, faults);
        Worker { persistence, mailbox, io, history, open_session, report }.serve_guarded(port);
    }

    fn serve_guarded(self, mut port: Option<I::Port>) {
        let open_session = Arc::clone(&self.open_session);
        let opener: SessionOpener<S> = Box::new(move |now| open_session(now));
        // Port and core are outside of the code that may panic: the emergency stop needs them.
        let mut core = LinkCore::new(opener, self.persistence);
        let served = catch_unwind(AssertUnwindSafe(|| self.serve(&mut core, &mut port)));
        let is_stop_sent = served.unwrap_or_else(|_| {
            let is_sent = port.as_mut().is_some_and(|port| self.stop_after_panic(&core, port));
            self.report_panic();
            is_sent
        });
        self.mailbox.set_stop_sent(is_stop_sent);
    }

    /// Reports the panic, which ends the run. A loop that has no room for the report either makes some, or
    /// closes the link: the thread does not wait for a loop that waits for the thread, nor for a program that
    /// is gone.
    fn report_panic(&self) {
        for _ in 0..REPORT_ATTEMPTS {
            if (self.report)(LinkReport::Panicked) || self.mailbox.requested().is_closing {
                return;
            }
            self.io.sleep(REPORT_PAUSE);
        }
    }

    /// Serves the port until the link is closed. Returns whether zeros and stop were sent.
    fn serve(&self, core: &mut LinkCore<S>, port: &mut Option<I::Port>) -> bool {
        core.resume(self.history);
        if port.is_some() {
            core.opened(self.io.now());
        }
        let mut report = |report| (self.report)(report);
        let mut out = Vec::new();
        loop {
            let now = self.io.now();
            let requested = self.mailbox.requested();
            core.request(requested.command);
            if requested.is_closing {
                core.close(now);
            }
            if self.mailbox.takes_control() {
                core.take_control(now);
            }
            let action = core.poll(now, &mut out, &mut report);
            let sent = match port {
                Some(port) => out.iter().try_for_each(|packet| self.io.send(port, packet)),
                None => Ok(()),
            };
            out.clear();
            if let Err(error) = sent {
                *port = None;
                core.port_lost(error.to_string(), self.io.now(), &mut report);
                continue;
            }
            match action {
                LinkAction::Ended { is_stop_sent, evidence } => {
                    if let (Some(port), Some(evidence)) = (port, evidence) {
                        report(LinkReport::Stopped(evidence));
                        self.let_arrive(port);
                    }
                    return is_stop_sent;
                }
                LinkAction::ClosePort => *port = None,
                LinkAction::Open => match self.io.open() {
                    Ok(opened) => {
                        *port = Some(opened);
                        core.opened(self.io.now());
                    }
                    Err(_) => core.open_failed(self.io.now()),
                },
                LinkAction::Wait { until } => {
                    let wait = until.since(self.io.now());
                    let is_readable = self.io.wait(port.as_ref(), wait);
                    let Some(open) = port.as_mut().filter(|_| is_readable) else { continue };
                    let now = self.io.now();
                    let received =
                        self.io.receive(open, &mut |packet| core.received(packet, now, &mut report));
                    if let Err(error) = received {
                        *port = None;
                        core.port_lost(error.to_string(), now, &mut report);
                    }
                }
            }
        }
    }

    /// Stops the vehicle by the last will of its session; by a new session's, if this one's panics, too.
    /// Returns whether the vehicle was told to stop, or needs no stop.
    fn stop_after_panic(&self, core: &LinkCore<S>, port: &mut I::Port) -> bool {
        let now = self.io.now();
        let own = catch_unwind(AssertUnwindSafe(|| (core.last_will(now), core.may_be_turning())));
        let (will, may_be_turning) = own.unwrap_or_else(|_| ((self.open_session)(now).last_will(now), true));
        let is_stopped = !will.is_empty() || !may_be_turning;
        let is_sent = self.send_all(port, will).is_ok();
        self.let_arrive(port);
        is_sent && is_stopped
    }

    /// Lets what was sent arrive before the port is closed: a connection that is closed with packets unread
    /// discards what is still on its way.
    fn let_arrive(&self, port: &mut I::Port) {
        if !self.io.end_sending(port) {
            return;
        }
        let until = self.io.now().plus(ARRIVAL_TIME);
        loop {
            let left = until.since(self.io.now());
            if left.is_zero() || self.io.wait(Some(port), left) && self.io.receive(port, &mut |_| {}).is_err()
            {
                return;
            }
        }
    }

    fn send_all(&self, port: &mut I::Port, will: Vec<WillStep<S::Sent>>) -> io::Result<()> {
        for WillStep { packet, pause } in will {
            self.io.send(port, &packet)?;
            self.io.sleep(pause);
        }
        Ok(())
    }
}
