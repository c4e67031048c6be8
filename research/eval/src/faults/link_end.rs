//! The program's end of a link: what it sends to the link, and what the link has reported.

use std::collections::VecDeque;

use barrelman_link::guard::gate::HEARTBEAT;
use barrelman_link::guard::message::ToGuard;
use barrelman_link::{LinkReport, RequestedCommand};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{LinkCommand, Telemetry, Timestamp, VehicleRates};

/// A report of the link that the run loop acts on.
#[derive(Debug)]
pub(super) enum LinkEvent {
    /// What the vehicle or the link says; a guard that is lost is a link that opens again.
    Telemetry(Telemetry),
    /// The machine was suspended.
    Suspended,
}

/// The program's end of a link.
pub(super) struct LinkEnd<C = VehicleRates> {
    requested: RequestedCommand<C>,
    sent_at: Timestamp,
    /// Messages for the link.
    pub(super) outbox: VecDeque<ToGuard<C>>,
    /// Reports that the run loop has not read yet.
    pub(super) reports: VecDeque<LinkReport>,
    /// Whether another commander has the control, as the link said last.
    pub(super) is_anothers: bool,
}

impl<C: LinkCommand> LinkEnd<C> {
    /// An end that asks for `requested` at first.
    pub(super) const fn new(requested: RequestedCommand<C>) -> Self {
        Self {
            requested,
            sent_at: Timestamp::ZERO,
            outbox: VecDeque::new(),
            reports: VecDeque::new(),
            is_anothers: false,
        }
    }

    /// The operator takes the control back.
    pub(super) fn take_control(&mut self) {
        self.is_anothers = false;
        self.outbox.push_back(ToGuard::TakeControl);
    }

    /// The thread of the link: the sign of life.
    pub(super) fn beat(&mut self, now: Timestamp) {
        if now.since(self.sent_at) >= HEARTBEAT {
            self.sent_at = now;
            self.outbox.push_back(ToGuard::Request(self.requested));
        }
    }

    /// The next report that the run loop acts on.
    pub(super) fn next_event(&mut self, now: Timestamp) -> Option<LinkEvent> {
        while let Some(report) = self.reports.pop_front() {
            match report {
                LinkReport::Telemetry(telemetry) => return Some(LinkEvent::Telemetry(telemetry)),
                LinkReport::Suspended(_) => return Some(LinkEvent::Suspended),
                LinkReport::GuardLost(_) => {
                    let report = Report::Link(LinkState::Opening);
                    return Some(LinkEvent::Telemetry(Telemetry { at: now, report }));
                }
                LinkReport::Control { is_anothers } => self.is_anothers = is_anothers,
                LinkReport::NotReached(_)
                | LinkReport::Lost { .. }
                | LinkReport::HeldUp
                | LinkReport::Stopped(_)
                | LinkReport::Panicked => {}
            }
        }
        None
    }

    /// Asks for a command from now on.
    pub(super) fn request(&mut self, requested: RequestedCommand<C>, now: Timestamp) {
        if std::mem::replace(&mut self.requested, requested) != requested {
            self.sent_at = now;
            self.outbox.push_back(ToGuard::Request(requested));
        }
    }
}
