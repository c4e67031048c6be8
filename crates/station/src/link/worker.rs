//! The link thread: one session after the other, on one port. The session is that of any vehicle; the worker passes
//! packets, times and requests, and decides nothing.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::fault::FaultKind;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp};
use barrelman_wire::{NextAction, Session, WillStep};

use super::dead_mans_switch::DeadMansSwitch;
use super::mailbox::Mailbox;
use super::port::PortError;
use super::port_io::PortIo;
use super::report::LinkReport;
use super::url::LinkUrl;

#[cfg(test)]
mod request_tests;
#[cfg(test)]
mod tests;

/// Interval between attempts to reopen a lost port.
const REOPEN_INTERVAL: Duration = Duration::from_millis(250);
/// Longest wait of a session: a deliberate fault begins at most this late.
const MAX_WAIT: Duration = Duration::from_millis(100);
/// Longest time from the request to close to `stop`. The program then ends without `stop`.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(3);
/// Pause before a report is offered again that must not be lost.
const REPORT_PAUSE: Duration = Duration::from_millis(20);

/// The work of the link thread.
pub(super) struct Worker<S: ?Sized, I, R> {
    pub(super) url: LinkUrl,
    pub(super) mailbox: Arc<Mailbox>,
    pub(super) io: I,
    /// Opens a session with the vehicle.
    pub(super) open_session: SessionOpener<S>,
    /// Takes the reports of the thread. Returns whether there was room for the report. Must not block.
    pub(super) report: R,
}

/// Opens a session on a newly opened port.
pub(super) type SessionOpener<S> = Box<dyn Fn(Timestamp) -> Box<S> + Send>;

/// How a session ended without an error.
enum SessionEnd {
    /// Zeros and stop were sent.
    Closed,
    /// The conversation has failed, for this reason.
    Failed(&'static str),
}

impl<S, I, R> Worker<S, I, R>
where
    S: Session + ?Sized,
    I: PortIo<Sent = S::Sent, Received = S::Received>,
    R: Fn(LinkReport) -> bool,
{
    /// Serves the port until the link is closed. A panic sends the emergency stop.
    pub(super) fn run(self, port: I::Port) {
        // The port is outside of the code that may panic: the emergency stop needs it.
        let mut port = Some(port);
        let served = catch_unwind(AssertUnwindSafe(|| self.serve(&mut port)));
        let is_stop_sent = served.unwrap_or_else(|_| {
            let is_sent = port.as_mut().is_some_and(|port| self.send_last_will(port).is_ok());
            self.report_panic();
            is_sent
        });
        self.mailbox.set_stop_sent(is_stop_sent);
    }

    /// Reports the panic, which ends the run. A loop that has no room for the report either makes some, or closes the
    /// link: the thread does not wait for a loop that waits for the thread.
    fn report_panic(&self) {
        while !(self.report)(LinkReport::Panicked) {
            let (_, is_closing) = self.mailbox.requested();
            if is_closing {
                return;
            }
            self.io.sleep(REPORT_PAUSE);
        }
    }

    /// Serves the port until the link is closed. Returns whether zeros and stop were sent.
    fn serve(&self, port: &mut Option<I::Port>) -> bool {
        let mut reported_state = None;
        let mut is_first_silence = true;
        loop {
            let Some(open) = port else {
                self.report_state(LinkState::Opening, &mut reported_state);
                let (_, is_closing) = self.mailbox.requested();
                if is_closing {
                    // The vehicle keeps its last rate, so the link tries once more to reach the vehicle.
                    return self.reopen().is_ok_and(|mut port| self.send_last_will(&mut port).is_ok());
                }
                match self.reopen() {
                    Ok(reopened) => *port = Some(reopened),
                    Err(_) => drop(self.io.wait(None, REOPEN_INTERVAL)),
                }
                continue;
            };
            match self.serve_session(open, &mut reported_state) {
                Ok(SessionEnd::Closed) => return true,
                Ok(SessionEnd::Failed(reason)) => {
                    if std::mem::take(&mut is_first_silence) {
                        (self.report)(LinkReport::Lost(reason.to_owned()));
                    }
                }
                Err(error) => drop((self.report)(LinkReport::Lost(error.to_string()))),
            }
            *port = None;
        }
    }

    fn reopen(&self) -> Result<I::Port, PortError> {
        if self.url.faults.is_active(FaultKind::Disconnect, self.io.now()) {
            let source = io::Error::new(io::ErrorKind::NotConnected, "disconnected on purpose");
            return Err(PortError::Unreachable { address: self.url.to_string(), source });
        }
        self.io.open()
    }

    /// Serves one session to its end.
    fn serve_session(
        &self,
        port: &mut I::Port,
        reported_state: &mut Option<LinkState>,
    ) -> io::Result<SessionEnd> {
        let mut session = (self.open_session)(self.io.now());
        let mut switch = DeadMansSwitch::default();
        let mut out = Vec::new();
        let mut closing_since: Option<Timestamp> = None;
        loop {
            let now = self.io.now();
            self.apply_faults(now)?;
            let (requested, is_closing) = self.mailbox.requested();
            let rates = switch.rates_in_force(&requested, now);
            session.request(rates, requested.renew_by.filter(|_| !rates.is_rest()));
            if is_closing && closing_since.is_none() {
                closing_since = Some(now);
                session.close(now);
            }
            if closing_since.is_some_and(|since| now.since(since) > CLOSING_TIMEOUT) {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "zeros and stop could not be sent"));
            }
            let next = session.poll(now, &mut out);
            for packet in out.drain(..) {
                if !self.is_cut(&[FaultKind::Drop, FaultKind::Stall], now) {
                    self.io.send(port, &packet)?;
                }
            }
            self.report_state(session.link_state(), reported_state);
            let wake_at = match next {
                NextAction::Closed => return Ok(SessionEnd::Closed),
                NextAction::Reopen { reason } => return Ok(SessionEnd::Failed(reason)),
                NextAction::WaitUntil(wake_at) if rates.is_rest() => wake_at,
                NextAction::WaitUntil(wake_at) => wake_at.min(requested.expires_at()),
            };
            let wait = wake_at.since(self.io.now()).min(MAX_WAIT);
            if self.io.wait(Some(port), wait) {
                let now = self.io.now();
                self.io.receive(port, &mut |packet| {
                    if !self.is_cut(&[FaultKind::Stall], now) {
                        session.received(packet, now, &mut |telemetry| {
                            (self.report)(LinkReport::Telemetry(telemetry));
                        });
                    }
                })?;
            }
        }
    }

    /// Whether one of these faults keeps packets from passing.
    fn is_cut(&self, kinds: &[FaultKind], now: Timestamp) -> bool {
        kinds.iter().any(|kind| self.url.faults.is_active(*kind, now))
    }

    fn apply_faults(&self, now: Timestamp) -> io::Result<()> {
        let faults = &self.url.faults;
        #[allow(clippy::panic, reason = "requested on the command line, to test the emergency stop")]
        if faults.is_active(FaultKind::Panic, now) {
            panic!("the link thread panics on purpose");
        }
        if faults.is_active(FaultKind::Disconnect, now) {
            return Err(io::Error::new(io::ErrorKind::NotConnected, "disconnected on purpose"));
        }
        Ok(())
    }

    /// Reports the state of the link if it has changed. A report without room is made again later.
    fn report_state(&self, state: LinkState, reported_state: &mut Option<LinkState>) {
        let telemetry = Telemetry { at: self.io.now(), report: Report::Link(state) };
        if *reported_state != Some(state) && (self.report)(LinkReport::Telemetry(telemetry)) {
            *reported_state = Some(state);
        }
    }

    /// Stops the vehicle without a session.
    fn send_last_will(&self, port: &mut I::Port) -> io::Result<()> {
        for WillStep { packet, pause } in (self.open_session)(self.io.now()).last_will() {
            self.io.send(port, &packet)?;
            self.io.sleep(pause);
        }
        Ok(())
    }
}
