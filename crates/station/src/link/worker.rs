//! The link thread: one session after the other, on one port.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::fault::FaultKind;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp};
use barrelman_wire::fotokite_pro::session::{NextAction, STOP_DELAY};
use barrelman_wire::fotokite_pro::{Session, SessionSettings};

use super::dead_mans_switch::DeadMansSwitch;
use super::mailbox::Mailbox;
use super::port::PortError;
use super::port_io::PortIo;
use super::report::LinkReport;
use super::url::LinkUrl;

#[cfg(test)]
mod tests;

/// Interval between attempts to reopen a lost port.
const REOPEN_INTERVAL: Duration = Duration::from_millis(250);
/// Longest wait of a session: a deliberate fault begins at most this late.
const MAX_WAIT: Duration = Duration::from_millis(100);
/// Longest time from the request to close to `stop`. The program then ends without `stop`.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(3);
/// Number of zeros in an emergency stop, and the pause after each.
const EMERGENCY_ZEROS: usize = 3;
const EMERGENCY_ZERO_PAUSE: Duration = Duration::from_millis(50);

/// The work of the link thread.
pub(super) struct Worker<I, R> {
    pub(super) url: LinkUrl,
    pub(super) settings: SessionSettings,
    pub(super) mailbox: Arc<Mailbox>,
    pub(super) io: I,
    /// Receives the reports of the thread.
    pub(super) report: R,
}

/// How a session ended without an error.
enum SessionEnd {
    /// Zeros and stop were sent.
    Closed,
    /// The ground station does not answer.
    Unanswered,
}

impl<I: PortIo, R: Fn(LinkReport)> Worker<I, R> {
    /// Serves the port until the link is closed. A panic sends the emergency stop.
    pub(super) fn run(self, port: I::Port) {
        // The port is outside of the code that may panic: the emergency stop needs it.
        let mut port = Some(port);
        let served = catch_unwind(AssertUnwindSafe(|| self.serve(&mut port)));
        let is_stop_sent = served.unwrap_or_else(|_| {
            let is_sent = port.as_mut().is_some_and(|port| self.send_emergency_stop(port).is_ok());
            (self.report)(LinkReport::Panicked);
            is_sent
        });
        self.mailbox.set_stop_sent(is_stop_sent);
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
                    return self.reopen().is_ok_and(|mut port| self.send_emergency_stop(&mut port).is_ok());
                }
                match self.reopen() {
                    Ok(reopened) => *port = Some(reopened),
                    Err(_) => drop(self.io.wait(None, REOPEN_INTERVAL)),
                }
                continue;
            };
            match self.serve_session(open, &mut reported_state) {
                Ok(SessionEnd::Closed) => return true,
                Ok(SessionEnd::Unanswered) => {
                    if std::mem::take(&mut is_first_silence) {
                        (self.report)(LinkReport::Lost("the ground station does not answer".to_owned()));
                    }
                }
                Err(error) => (self.report)(LinkReport::Lost(error.to_string())),
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
        let mut session = Session::open(self.settings, self.io.now());
        let mut switch = DeadMansSwitch::default();
        let mut out = Vec::new();
        let mut buffer = [0; 1024];
        let mut closing_since: Option<Timestamp> = None;
        loop {
            let now = self.io.now();
            self.apply_faults(now)?;
            let (requested, is_closing) = self.mailbox.requested();
            let rates = switch.rates_in_force(&requested, now);
            session.set_rates(rates);
            if is_closing && closing_since.is_none() {
                closing_since = Some(now);
                session.close(now);
            }
            if closing_since.is_some_and(|since| now.since(since) > CLOSING_TIMEOUT) {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "zeros and stop could not be sent"));
            }
            out.clear();
            let next = session.poll(now, &mut out);
            if !out.is_empty() && !self.url.faults.is_active(FaultKind::Drop, now) {
                self.io.write_all(port, &out)?;
            }
            self.report_state(session.link_state(), reported_state);
            let wake_at = match next {
                NextAction::Closed => return Ok(SessionEnd::Closed),
                NextAction::Reopen => return Ok(SessionEnd::Unanswered),
                NextAction::WaitUntil(wake_at) if rates.is_rest() => wake_at,
                NextAction::WaitUntil(wake_at) => wake_at.min(requested.expires_at()),
            };
            let wait = wake_at.since(self.io.now()).min(MAX_WAIT);
            if self.io.wait(Some(port), wait) {
                let read = self.io.read(port, &mut buffer)?;
                session.receive(&buffer[..read], self.io.now(), |telemetry| {
                    (self.report)(LinkReport::Telemetry(telemetry));
                });
            }
        }
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

    /// Reports the state of the link if it has changed.
    fn report_state(&self, state: LinkState, reported_state: &mut Option<LinkState>) {
        if reported_state.replace(state) != Some(state) {
            let telemetry = Telemetry { at: self.io.now(), report: Report::Link(state) };
            (self.report)(LinkReport::Telemetry(telemetry));
        }
    }

    /// Stops the vehicle without a session: zeros, half a second, stop.
    fn send_emergency_stop(&self, port: &mut I::Port) -> io::Result<()> {
        let (zeros, stop) = Session::emergency_stop(self.settings.framing);
        for _ in 0..EMERGENCY_ZEROS {
            self.io.write_all(port, &zeros)?;
            self.io.sleep(EMERGENCY_ZERO_PAUSE);
        }
        self.io.sleep(STOP_DELAY);
        self.io.write_all(port, &stop)
    }
}
