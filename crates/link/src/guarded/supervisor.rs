//! The thread `link` of a guarded link: it serves one guard after the other until the link is closed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp};
use barrelman_wire::{LinkHistory, OpenSession, ReportReader};
use rustix::event::{PollFd, PollFlags};

use super::client::{Client, Commands};
use super::process::{Guard, GuardedLinkSettings};
use crate::guard::gate::HEARTBEAT;
use crate::guard::message::{FromGuard, ToGuard};
use crate::guard::pipe::PipeRead;
use crate::guard::watch::{
    GuardWatch, HUNG_AT_START, HUNG_WHILE_OPENING, HUNG_WHILE_REOPENING, LOOK_INTERVAL,
};
use crate::handle::LinkHandle;
use crate::port_io::poll_for;
use crate::report::LinkReport;

/// Pause before a guard that could not be started is started again.
const RESTART_PAUSE: Duration = Duration::from_millis(500);
/// Longest wait for the end of the guard when the link is closed. The guard itself goes on after that.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(7);

/// Pause before a report is offered again that must not be lost.
const REPORT_PAUSE: Duration = Duration::from_millis(5);

/// What became of the first opening of the port.
pub(super) enum FirstOpening {
    /// The port is open, or its vehicle may come.
    Started,
    /// The port's error, which stays.
    PortRefused(String),
    /// The guard is gone, or hangs.
    GuardFailed(String),
}

/// Why a guard is no longer served.
enum GuardEnd {
    /// It has ended, and zeros and stop were sent, or not.
    Ended { is_stop_sent: bool },
    /// The first guard could not open the port: nothing was sent, and there is nothing to stop.
    NeverOpened,
    /// It is gone, or hung. `was_useful`: it had tried to open its port.
    Gone { reason: String, was_useful: bool },
    /// The link is closing, and the guard takes too long. It goes on by itself.
    TooLong,
}

/// The thread `link` of a guarded link.
pub(super) struct Supervisor<P: OpenSession, R> {
    pub(super) settings: GuardedLinkSettings<P>,
    pub(super) client: Arc<Client<P::Command>>,
    pub(super) report: R,
    pub(super) reader: ReportReader,
    /// What the guard before has left.
    pub(super) history: LinkHistory,
    /// Whether a guard has opened the port: before that, nothing was sent that a guard could leave.
    pub(super) was_opened: bool,
    /// Takes whether the first guard has opened the port.
    pub(super) opened: Option<SyncSender<FirstOpening>>,
}

impl<P: OpenSession, R: Fn(LinkReport) -> bool> Supervisor<P, R>
where
    P::Command: Commands,
{
    /// Serves one guard after the other until the link is closed. Returns whether zeros and stop were sent. A
    /// panic closes the pipe, so that the guard sends them, and is reported.
    pub(super) fn run(mut self, first: Guard) -> bool {
        catch_unwind(AssertUnwindSafe(|| self.serve_guards(first))).unwrap_or_else(|_| {
            self.client.state().pipe = None;
            self.report_until_taken(|| LinkReport::Panicked);
            false
        })
    }

    fn serve_guards(&mut self, first: Guard) -> bool {
        let mut guard = Some(first);
        let mut attempts_to_close = 0;
        let (mut is_loss_told, mut is_useless_told) = (true, false);
        loop {
            let Some(served) = guard.take().or_else(|| Guard::start(&self.settings, self.history).ok())
            else {
                is_loss_told =
                    is_loss_told || self.offer_state(LinkState::Opening, self.settings.clock.now());
                match self.rest_without_guard() {
                    Some(is_stop_sent) => return is_stop_sent,
                    None => continue,
                }
            };
            self.client.state().pipe = Some(Arc::clone(&served.pipe));
            if !std::mem::replace(&mut is_loss_told, true) {
                self.report_state(LinkState::Opening, self.settings.clock.now());
            }
            if self.client.state().is_closing {
                attempts_to_close += 1;
                served.pipe.send(&ToGuard::<P::Command>::Close.encode());
            }
            let end = self.serve(&served);
            let is_stop_sent = matches!(end, GuardEnd::Ended { is_stop_sent: true });
            let is_anothers = self.client.state().is_anothers;
            if self.was_opened {
                self.history = LinkHistory::after(is_stop_sent, is_anothers, self.reader.vehicle());
            }
            self.client.state().pipe = None;
            let is_closing = self.client.state().is_closing;
            let (reason, was_useful) = match end {
                // A first guard that fails before it has opened the port ends the start of the run with its
                // reason.
                GuardEnd::Gone { reason, .. } if self.opened.is_some() => {
                    self.answer_opening(FirstOpening::GuardFailed(reason));
                    served.reap();
                    return false;
                }
                GuardEnd::TooLong => return false,
                GuardEnd::NeverOpened => {
                    served.reap();
                    return false;
                }
                GuardEnd::Ended { is_stop_sent } if is_closing => {
                    served.reap();
                    return is_stop_sent;
                }
                GuardEnd::Ended { .. } => ("it has ended".to_owned(), true),
                GuardEnd::Gone { reason, was_useful } => (reason, was_useful),
            };
            served.reap();
            if was_useful && attempts_to_close > 1 {
                return false;
            }
            // Of guards that come to nothing, the first is told.
            if was_useful || !std::mem::replace(&mut is_useless_told, true) {
                (self.report)(LinkReport::GuardLost(reason));
            }
            is_useless_told &= !was_useful;
            // The next guard does not wait until the loop takes it.
            is_loss_told = self.offer_state(LinkState::Opening, self.settings.clock.now());
            if !was_useful && let Some(is_stop_sent) = self.rest_without_guard() {
                return is_stop_sent;
            }
        }
    }

    /// Does what a guard would have done that cannot be started, or ends before it comes to its port. Returns
    /// whether zeros and stop were sent, if the link is closing.
    fn rest_without_guard(&self) -> Option<bool> {
        let is_stop_sent = self.stop_without_guard();
        if self.client.state().is_closing {
            return Some(is_stop_sent);
        }
        std::thread::sleep(RESTART_PAUSE);
        None
    }

    /// Serves a guard until its end.
    fn serve(&mut self, guard: &Guard) -> GuardEnd {
        let mut watch = GuardWatch::start(HUNG_WHILE_OPENING, self.settings.clock.now());
        let mut last_sent = Instant::now();
        let mut closing_since = None;
        let mut was_useful = false;
        loop {
            poll_for(&mut [PollFd::new(&*guard.pipe, PollFlags::IN)], LOOK_INTERVAL);
            loop {
                match guard.pipe.read() {
                    PipeRead::Nothing => break,
                    PipeRead::End => return gone("it is gone", was_useful),
                    PipeRead::Message(packet) => {
                        watch.heard();
                        let message = FromGuard::decode(&packet);
                        was_useful |= !matches!(message, Ok(FromGuard::OpensPort) | Err(_));
                        match message {
                            Ok(FromGuard::OpensPort) => watch.heard_opening(),
                            Ok(FromGuard::Ended { is_stop_sent }) => return GuardEnd::Ended { is_stop_sent },
                            Ok(FromGuard::NotOpened { may_pass: false, reason }) if self.opened.is_some() => {
                                self.answer_opening(FirstOpening::PortRefused(reason));
                                return GuardEnd::NeverOpened;
                            }
                            Ok(message) => self.on_message(message),
                            Err(_) => return gone("it says what cannot be read", was_useful),
                        }
                    }
                }
            }
            let is_closing = {
                let mut state = self.client.state();
                if !state.is_closing {
                    state.pass_on_control();
                    if last_sent.elapsed() >= HEARTBEAT {
                        last_sent = Instant::now();
                        state.send(&ToGuard::Request(state.requested));
                    }
                }
                state.is_closing
            };
            if is_closing {
                let since = *closing_since.get_or_insert_with(Instant::now);
                if since.elapsed() > CLOSING_TIMEOUT {
                    return GuardEnd::TooLong;
                }
            }
            if self.opened.is_none() {
                watch.set_patience_while_opening(HUNG_WHILE_REOPENING);
            }
            if watch.hangs(self.settings.clock.now()) {
                let silence = format!("it has said nothing for {} s", HUNG_AT_START.as_secs());
                return gone(if watch.is_starting() { &silence } else { "it hangs" }, was_useful);
            }
        }
    }

    fn on_message(&mut self, message: FromGuard) {
        match message {
            FromGuard::Opened => {
                self.was_opened = true;
                self.answer_opening(FirstOpening::Started);
            }
            FromGuard::NotOpened { reason, .. } if self.opened.is_some() => {
                (self.report)(LinkReport::NotReached(reason));
                self.answer_opening(FirstOpening::Started);
            }
            FromGuard::State(state, at) => {
                self.was_opened |= state != LinkState::Opening;
                self.report_state(state, at);
            }
            FromGuard::Received(at, bytes) => {
                let (report, mut not_taken) = (&self.report, Vec::new());
                self.reader.read(&bytes, |content| {
                    let telemetry = Telemetry { at, report: content };
                    // A vehicle repeats all others.
                    let is_told_once = matches!(content, Report::Equipment(_) | Report::Zoom(_));
                    // In their order.
                    let waits = is_told_once && !not_taken.is_empty();
                    if waits || (!report(LinkReport::Telemetry(telemetry)) && is_told_once) {
                        not_taken.push(telemetry);
                    }
                });
                for telemetry in not_taken {
                    self.report_until_taken(|| LinkReport::Telemetry(telemetry));
                }
            }
            FromGuard::Control { is_anothers } => self.client.state().is_anothers = is_anothers,
            FromGuard::Lost { may_be_turning, reason } => {
                (self.report)(LinkReport::Lost { reason, may_be_turning });
            }
            FromGuard::HeldUp => drop((self.report)(LinkReport::HeldUp)),
            FromGuard::Suspended(gap) => drop((self.report)(LinkReport::Suspended(gap))),
            FromGuard::Stopped(evidence) => drop((self.report)(LinkReport::Stopped(evidence))),
            FromGuard::Panicked => self.report_until_taken(|| LinkReport::Panicked),
            // A later guard goes on trying; its state says so.
            FromGuard::NotOpened { .. }
            | FromGuard::Alive
            | FromGuard::OpensPort
            | FromGuard::Ended { .. } => {}
        }
    }

    fn answer_opening(&mut self, answer: FirstOpening) {
        if let Some(opened) = self.opened.take() {
            // Without a receiver, the opening was given up.
            let _ = opened.send(answer);
        }
    }

    fn report_state(&mut self, state: LinkState, at: Timestamp) {
        // The pilot goes by the state.
        if !self.offer_state(state, at) {
            let telemetry = Telemetry { at, report: Report::Link(state) };
            self.report_until_taken(|| LinkReport::Telemetry(telemetry));
        }
    }

    /// Reports a state, if there is room for the report, and returns whether there was.
    fn offer_state(&mut self, state: LinkState, at: Timestamp) -> bool {
        if state == LinkState::Opening {
            // The pilot forgets what a vehicle said on a port before. A reader reports changes only, and has
            // to report it again.
            let mut reader = self.settings.protocol.reports(self.settings.clock.now());
            if let Some(vehicle) = self.reader.vehicle() {
                reader.name(vehicle);
            }
            self.reader = reader;
        }
        (self.report)(LinkReport::Telemetry(Telemetry { at, report: Report::Link(state) }))
    }

    /// Makes a report that must not be lost, unless the link is closing.
    fn report_until_taken(&self, report: impl Fn() -> LinkReport) {
        while !(self.report)(report()) && !self.client.state().is_closing {
            std::thread::sleep(REPORT_PAUSE);
        }
    }

    /// Zeros and stop from this process, once. Returns whether they were sent: without a port there is nothing
    /// to do but to try again.
    fn stop_without_guard(&self) -> bool {
        let LinkHistory { is_anothers, vehicle, .. } = self.history;
        let history = LinkHistory::after(false, is_anothers, vehicle);
        LinkHandle::stop(&self.settings.url, self.settings.protocol, self.settings.clock, history)
            .unwrap_or(false)
    }
}

fn gone(reason: &str, was_useful: bool) -> GuardEnd {
    GuardEnd::Gone { reason: reason.to_owned(), was_useful }
}
