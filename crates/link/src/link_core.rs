//! What a link does, without clock, port and thread: one session after the other, the dead-man's switch,
//! reopening, closing.
//!
//! ```text
//!              opened()                    port_lost(), a failed session
//!   without port -----> session ----------------------------------> without port (reopened at once, then every 0.1 s)
//!        |                 |
//!        |  close(): try   |  close(): zeros, stop
//!        v                 v
//!      Ended             Ended
//! ```
//!
//! The worker acts as [`LinkCore::poll`] says, and reports what became of it. The session is that of any
//! vehicle.

use std::time::Duration;

use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{LinkCommand, Telemetry, Timestamp};
use barrelman_wire::{LinkHistory, NextAction, RestEvidence, Session, WillStep};

use crate::dead_mans_switch::{DeadMansSwitch, RequestedCommand};
use crate::report::LinkReport;

/// Interval between attempts to reopen a lost port.
pub const REOPEN_INTERVAL: Duration = Duration::from_millis(100);
/// A session that ended earlier than this is no reason to reopen the port at once.
const SHORT_SESSION: Duration = Duration::from_secs(1);
/// Longest wait: a report that found no room is made again, and a deliberate fault begins, at most this late.
const MAX_WAIT: Duration = Duration::from_millis(100);
/// Longest time from the request to close to `stop`. The link then ends without `stop`.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(5);

/// Opens a session on a newly opened port.
pub type SessionOpener<S> = Box<dyn Fn(Timestamp) -> Box<S> + Send>;

/// Takes a report of the link. Returns whether there was room for the report. Must not block.
pub type ReportSink<'a> = &'a mut dyn FnMut(LinkReport) -> bool;

/// What the worker does after it has sent the packets of [`LinkCore::poll`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LinkAction {
    /// Poll again at this time, or earlier after received packets or another request.
    Wait {
        /// The time.
        until: Timestamp,
    },
    /// Open the port, and say what came of it: [`LinkCore::opened`], [`LinkCore::open_failed`].
    Open,
    /// Close the port, and poll again.
    ClosePort,
    /// The link has ended.
    Ended {
        /// Whether zeros and stop were sent, or nothing ever was that they would end.
        is_stop_sent: bool,
        /// What telemetry shows of the vehicle, to be reported once the last packets were sent; `None`: nothing
        /// was sent.
        evidence: Option<RestEvidence>,
    },
}

/// A link's state.
pub struct LinkCore<S: Session + ?Sized> {
    open_session: SessionOpener<S>,
    /// How long a link that is closing goes on trying to reach its vehicle.
    persistence: Duration,
    requested: RequestedCommand<S::Command>,
    switch: DeadMansSwitch,
    session: Option<OpenSession<S>>,
    /// Whether the port was ever open.
    was_opened: bool,
    reopen_at: Timestamp,
    closing: Option<Closing>,
    reported_state: Option<LinkState>,
    reported_anothers: Option<bool>,
    has_fallen_silent: bool,
    /// What the lost sessions have left. The camera may be turning until a session is up, and the control is
    /// another client's until the operator takes it back.
    history: LinkHistory,
}

struct OpenSession<S: ?Sized> {
    session: Box<S>,
    since: Timestamp,
    is_closing: bool,
}

#[derive(Debug, Clone, Copy)]
struct Closing {
    since: Timestamp,
    /// Whether the port was tried since, where it was not open.
    has_tried: bool,
}

impl<S: Session + ?Sized> LinkCore<S> {
    /// A link without an open port. A link that is closed after its port was lost tries once more to reach
    /// its vehicle, and goes on trying for `persistence`.
    pub fn new(open_session: SessionOpener<S>, persistence: Duration) -> Self {
        Self {
            open_session,
            persistence,
            requested: RequestedCommand::default(),
            switch: DeadMansSwitch::default(),
            session: None,
            was_opened: false,
            reopen_at: Timestamp::ZERO,
            closing: None,
            reported_state: None,
            reported_anothers: None,
            has_fallen_silent: false,
            history: LinkHistory::default(),
        }
    }

    /// Takes over from a link before this one.
    pub const fn resume(&mut self, history: LinkHistory) {
        self.history = history;
    }

    /// Sets the command that is requested from now on.
    pub fn request(&mut self, requested: RequestedCommand<S::Command>) {
        self.requested = requested;
    }

    /// The operator takes the control of the vehicle back.
    pub fn take_control(&mut self, now: Timestamp) {
        self.history.is_anothers = false;
        if let Some(open) = &mut self.session {
            open.session.take_control(now);
        }
    }

    /// Begins the end of the link: rest, zeros, stop.
    pub fn close(&mut self, now: Timestamp) {
        self.requested = RequestedCommand::REST;
        if self.closing.is_some() {
            return;
        }
        self.closing = Some(Closing { since: now, has_tried: false });
        if self.session.is_none() {
            self.reopen_at = now;
        }
    }

    /// The port was opened.
    pub fn opened(&mut self, now: Timestamp) {
        self.was_opened = true;
        self.session = Some(OpenSession { session: self.new_session(now), since: now, is_closing: false });
    }

    fn new_session(&self, now: Timestamp) -> Box<S> {
        let mut session = (self.open_session)(now);
        session.resume(self.history);
        session
    }

    /// The port could not be opened.
    pub fn open_failed(&mut self, now: Timestamp) {
        self.reopen_at = now.plus(REOPEN_INTERVAL);
    }

    /// The port failed for this reason.
    pub fn port_lost(&mut self, reason: String, now: Timestamp, report: ReportSink<'_>) {
        if let Some(open) = self.session.take() {
            let may_be_turning = open.session.may_be_turning();
            let is_short = now.since(open.since) < SHORT_SESSION;
            self.reopen_at = if is_short { now.plus(REOPEN_INTERVAL) } else { now };
            self.history = LinkHistory {
                may_be_turning: self.history.may_be_turning || may_be_turning,
                is_anothers: open.session.is_anothers(),
                vehicle: open.session.vehicle(),
            };
            report(LinkReport::Lost { reason, may_be_turning });
        }
    }

    /// The packets that stop the vehicle from any state, with what the session knows of the vehicle, or,
    /// where there is none, what the sessions before have left.
    pub fn last_will(&self, now: Timestamp) -> Vec<WillStep<S::Sent>> {
        match &self.session {
            Some(open) => open.session.last_will(now),
            None => self.new_session(now).last_will(now),
        }
    }

    /// Whether the vehicle may be turning the camera, or moving the boat, if nothing reaches it from now on.
    pub fn may_be_turning(&self) -> bool {
        self.history.may_be_turning || self.session.as_ref().is_some_and(|open| open.session.may_be_turning())
    }

    /// Passes a received packet to the session.
    pub fn received(&mut self, packet: &S::Received, now: Timestamp, report: ReportSink<'_>) {
        if let Some(open) = &mut self.session {
            open.session.received(packet, now, &mut |telemetry| {
                report(LinkReport::Telemetry(telemetry));
            });
        }
    }

    /// Appends the packets that are due now to `out`, and returns what to do after they were sent.
    pub fn poll(&mut self, now: Timestamp, out: &mut Vec<S::Sent>, report: ReportSink<'_>) -> LinkAction {
        let command = self.switch.command_in_force(&self.requested, now, || {
            report(LinkReport::HeldUp);
        });
        let Some(open) = &mut self.session else {
            return self.poll_without_port(now, report);
        };
        open.session.request(command, self.requested.renew_by.filter(|_| !command.is_rest()));
        if let Some(closing) = self.closing {
            if !open.is_closing {
                open.is_closing = true;
                open.session.close(now);
            }
            if now.since(closing.since) > CLOSING_TIMEOUT + self.persistence {
                self.port_lost("zeros and stop could not be sent".to_owned(), now, report);
                return LinkAction::ClosePort;
            }
        }
        let next = open.session.poll(now, out);
        let (state, evidence) = (open.session.link_state(), open.session.rest_evidence(now));
        let is_anothers = open.session.is_anothers();
        self.history.may_be_turning &= state != LinkState::Up;
        // A silence after this one is another, and may find the camera turning.
        self.has_fallen_silent &= state != LinkState::Up;
        self.report_state(state, now, report);
        self.report_control(is_anothers, report);
        match next {
            NextAction::Closed => LinkAction::Ended { is_stop_sent: true, evidence: Some(evidence) },
            NextAction::Reopen { reason } => {
                let failure = self.session.as_ref().and_then(|open| open.session.failure());
                self.session_failed(failure.unwrap_or_else(|| reason.to_owned()), now, report);
                LinkAction::ClosePort
            }
            NextAction::WaitUntil(at) => {
                let until = if command.is_rest() { at } else { at.min(self.requested.expires_at()) };
                LinkAction::Wait { until: until.min(now.plus(MAX_WAIT)) }
            }
        }
    }

    fn poll_without_port(&mut self, now: Timestamp, report: ReportSink<'_>) -> LinkAction {
        self.report_state(LinkState::Opening, now, report);
        if self.closing.is_some() && !self.was_opened && !self.history.may_be_turning {
            return LinkAction::Ended { is_stop_sent: true, evidence: None };
        }
        if let Some(closing) = self.closing
            && closing.has_tried
            && now.since(closing.since) >= self.persistence
        {
            return LinkAction::Ended { is_stop_sent: false, evidence: None };
        }
        if now < self.reopen_at {
            return LinkAction::Wait { until: self.reopen_at.min(now.plus(MAX_WAIT)) };
        }
        if let Some(closing) = &mut self.closing {
            closing.has_tried = true;
        }
        LinkAction::Open
    }

    /// The conversation has failed. A vehicle that does not answer is reported once.
    fn session_failed(&mut self, reason: String, now: Timestamp, report: ReportSink<'_>) {
        let is_told = std::mem::replace(&mut self.has_fallen_silent, true);
        let mut ignore = |_| true;
        self.port_lost(reason, now, if is_told { &mut ignore } else { report });
    }

    /// Reports the state of the link if it has changed. A report without room is made again later.
    fn report_state(&mut self, state: LinkState, now: Timestamp, report: ReportSink<'_>) {
        let telemetry = Telemetry { at: now, report: Report::Link(state) };
        if self.reported_state != Some(state) && report(LinkReport::Telemetry(telemetry)) {
            self.reported_state = Some(state);
        }
    }

    /// Reports whether another client has the control, if that has changed. A report without room is made
    /// again later.
    fn report_control(&mut self, is_anothers: bool, report: ReportSink<'_>) {
        if self.reported_anothers != Some(is_anothers) && report(LinkReport::Control { is_anothers }) {
            self.reported_anothers = Some(is_anothers);
        }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::VehicleRates;
    use barrelman_vocab::mavlink::SystemId;

    use super::*;

    /// A session that is over at once, and can stop the vehicle only after it was heard. Another client has
    /// the control, if it was heard.
    #[derive(Default)]
    struct NoSession {
        is_heard: bool,
        history: LinkHistory,
    }

    impl Session for NoSession {
        type Sent = ();
        type Received = [u8];
        type Command = VehicleRates;

        fn poll(&mut self, _: Timestamp, _: &mut Vec<()>) -> NextAction {
            NextAction::Closed
        }
        fn received(&mut self, _: &[u8], _: Timestamp, _: &mut dyn FnMut(Telemetry)) {
            self.is_heard = true;
        }
        fn request(&mut self, _: VehicleRates, _: Option<Timestamp>) {}
        fn close(&mut self, _: Timestamp) {}
        fn link_state(&self) -> LinkState {
            LinkState::Closed
        }
        fn may_be_turning(&self) -> bool {
            false
        }
        fn resume(&mut self, history: LinkHistory) {
            self.history = history;
        }
        fn vehicle(&self) -> Option<SystemId> {
            self.history.vehicle.or(self.is_heard.then_some(SystemId(7)))
        }
        fn is_anothers(&self) -> bool {
            self.is_heard || self.history.is_anothers
        }
        fn last_will(&self, _: Timestamp) -> Vec<WillStep<()>> {
            vec![WillStep { packet: (), pause: Duration::ZERO }; usize::from(self.is_heard)]
        }
    }

    fn core_without_port() -> LinkCore<NoSession> {
        LinkCore::new(Box::new(|_| Box::new(NoSession::default())), Duration::ZERO)
    }

    #[test]
    fn the_last_will_is_that_of_the_session_that_is_open() {
        let now = Timestamp::from_secs_f64(1.0);
        let mut core = core_without_port();
        core.opened(now);
        core.received(&[1], now, &mut |_| true);
        assert_eq!(core.last_will(now).len(), 1);
        core.port_lost("unplugged".to_owned(), now, &mut |_| true);
        assert!(core.last_will(now).is_empty(), "a new session knows nothing");
    }

    #[test]
    fn sessions_wait_for_the_operator_from_the_loss_of_the_control_on() {
        let now = Timestamp::from_secs_f64(1.0);
        let mut core = core_without_port();
        let opened_after_a_loss = |core: &mut LinkCore<NoSession>| {
            core.port_lost("unplugged".to_owned(), now, &mut |_| true);
            core.opened(now);
            core.session.as_ref().map(|open| open.session.history.is_anothers)
        };
        core.opened(now);
        assert_eq!(opened_after_a_loss(&mut core), Some(false));
        core.received(&[1], now, &mut |_| true);
        assert_eq!(opened_after_a_loss(&mut core), Some(true));
        assert_eq!(opened_after_a_loss(&mut core), Some(true), "nothing was heard in between");
        core.port_lost("unplugged".to_owned(), now, &mut |_| true);
        core.take_control(now);
        core.opened(now);
        assert_eq!(core.session.as_ref().map(|open| open.session.history.is_anothers), Some(false));
    }

    #[test]
    fn whether_another_client_has_the_control_is_reported_at_each_change() {
        let now = Timestamp::from_secs_f64(1.0);
        let mut core = core_without_port();
        let mut out = Vec::new();
        let mut poll = |core: &mut LinkCore<NoSession>, has_room: bool| {
            let mut told = Vec::new();
            core.poll(now, &mut out, &mut |report| {
                if let LinkReport::Control { is_anothers } = report {
                    told.push(is_anothers);
                }
                has_room
            });
            told
        };
        core.opened(now);
        assert_eq!(poll(&mut core, true), [false]);
        assert_eq!(poll(&mut core, true), [false; 0]);
        core.received(&[1], now, &mut |_| true);
        assert_eq!(poll(&mut core, false), [true], "there is no room for it");
        assert_eq!(poll(&mut core, true), [true]);
        assert_eq!(poll(&mut core, true), [false; 0]);
    }

    #[test]
    fn sessions_speak_to_the_vehicle_that_was_found_first() {
        let now = Timestamp::from_secs_f64(1.0);
        let mut core = core_without_port();
        core.opened(now);
        core.received(&[1], now, &mut |_| true);
        for _ in 0..2 {
            core.port_lost("unplugged".to_owned(), now, &mut |_| true);
            core.opened(now);
            let found = core.session.as_ref().and_then(|open| open.session.history.vehicle);
            assert_eq!(found, Some(SystemId(7)));
        }
    }

    #[test]
    fn a_link_that_reached_nobody_has_nothing_to_stop() {
        let now = Timestamp::from_secs_f64(5.0);
        let mut core = LinkCore::new(Box::new(|_| Box::new(NoSession::default())), Duration::from_secs(10));
        let poll = |core: &mut LinkCore<NoSession>| core.poll(now, &mut Vec::new(), &mut |_| true);
        assert_eq!(poll(&mut core), LinkAction::Open);
        core.open_failed(now);
        core.close(now);
        assert_eq!(poll(&mut core), LinkAction::Ended { is_stop_sent: true, evidence: None });
    }

    #[test]
    fn a_link_that_closes_without_a_port_waits_between_its_attempts() {
        let persistence = Duration::from_secs(10);
        let mut core = LinkCore::new(Box::new(|_| Box::new(NoSession::default())), persistence);
        core.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
        let (mut now, mut attempts) = (Timestamp::from_secs_f64(5.0), 0);
        loop {
            // The worker says so each time.
            core.close(now);
            match core.poll(now, &mut Vec::new(), &mut |_| true) {
                LinkAction::Open => {
                    attempts += 1;
                    assert!(attempts <= 101, "one attempt every 0.1 s");
                    core.open_failed(now);
                }
                LinkAction::Wait { until } => {
                    assert!(until > now);
                    now = until;
                }
                LinkAction::Ended { is_stop_sent, .. } => {
                    assert!(!is_stop_sent);
                    break;
                }
                LinkAction::ClosePort => unreachable!("there is no port"),
            }
        }
        assert!(attempts >= 99, "{attempts}");
        assert!(now.since(Timestamp::from_secs_f64(5.0)) >= persistence);
    }
}
