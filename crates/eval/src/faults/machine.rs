//! The machine that the program runs on, as far as faults of processes, of the clock and of the line go: the guard's life and
//! death, the program's, suspensions, and the line with its faults.

use barrelman_link::LinkReport;
use barrelman_link::guard::gate::GuardedCommand;
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::LinkHistory;

use super::fault::{self, Fault, FaultKind};
use super::line::Line;
use super::link_end::LinkEnd;
use super::link_host::LinkHost;
use super::link_plan::LinkPlan;
use super::mutant::Mutant;
use crate::rng::Rng;

/// From the death of a guard to the start of the next, ms.
const GUARD_STARTS_MS: u64 = 40;
/// A program that is gone within this time of its guard's death cannot replace it, ms: both are killed together.
const TOGETHER_MS: u64 = 400;

/// A millisecond in which the machine runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    /// By the monotonic clock.
    pub(super) now: Timestamp,
    /// Of the world.
    pub(super) at_ms: u64,
    /// Whether the machine was suspended until now.
    pub(super) was_suspended: bool,
}

/// The machine.
pub(super) struct Machine<C: GuardedCommand = VehicleRates> {
    plan: LinkPlan<C>,
    pub(super) faults: Vec<Fault>,
    pub(super) line: Line,
    link: Option<LinkHost<C>>,
    guard_starts_at_ms: Option<u64>,
    /// Whether the guard before has sent zeros and stop.
    is_stop_sent: bool,
    /// Whether a guard that took the program for gone has ended.
    has_guard_ended: bool,
    guard_died_at_ms: Option<u64>,
    program_gone_at_ms: Option<u64>,
    /// Whether the program ends in order.
    pub(super) is_closing: bool,
    is_suspended: bool,
    suspended_ms: u64,
    is_excluded: bool,
}

impl<C: GuardedCommand> Machine<C> {
    /// A machine whose program and link have just started.
    pub(super) fn start(plan: LinkPlan<C>, faults: Vec<Fault>, rng: Rng) -> Self {
        Self {
            line: Line::new(&faults, rng),
            link: Some(LinkHost::start(&plan, LinkHistory::default(), Timestamp::ZERO)),
            plan,
            faults,
            guard_starts_at_ms: None,
            is_stop_sent: false,
            has_guard_ended: false,
            guard_died_at_ms: None,
            program_gone_at_ms: None,
            is_closing: false,
            is_suspended: false,
            suspended_ms: 0,
            is_excluded: false,
        }
    }

    pub(super) fn is_active(&self, kind: FaultKind, at_ms: u64) -> bool {
        fault::active(&self.faults, kind, at_ms).is_some()
    }

    pub(super) fn begins(&self, kind: FaultKind, at_ms: u64) -> bool {
        self.faults.iter().any(|fault| fault.begins(kind, at_ms))
    }

    /// Whether the machine is suspended.
    pub(super) const fn is_suspended(&self) -> bool {
        self.is_suspended
    }

    /// Whether guard and program were gone together, for which there is no help.
    pub(super) const fn is_excluded(&self) -> bool {
        self.is_excluded
    }

    /// Whether there is a guard, or the thread that has the link.
    pub(super) const fn has_link(&self) -> bool {
        self.link.is_some()
    }

    /// The monotonic clock, which stands still while the machine is suspended.
    pub(super) const fn now(&self, at_ms: u64) -> Timestamp {
        Timestamp::from_nanos((at_ms - self.suspended_ms) * 1_000_000)
    }

    /// What the link sent in the newest millisecond.
    pub(super) fn sent(&self) -> &[Vec<u8>] {
        self.link.as_ref().map_or(&[], |link| &link.sent)
    }

    /// Lets a millisecond begin. `None`: the machine is suspended.
    pub(super) fn begin(&mut self, at_ms: u64) -> Option<Moment> {
        if let Some(link) = &mut self.link {
            link.sent.clear();
        }
        let is_suspended = self.is_active(FaultKind::Suspension, at_ms);
        let was_suspended = std::mem::replace(&mut self.is_suspended, is_suspended);
        if is_suspended {
            self.suspended_ms += 1;
            return None;
        }
        if was_suspended && let Some(link) = &mut self.link {
            link.on_suspension();
        }
        Some(Moment { now: self.now(at_ms), at_ms, was_suspended })
    }

    fn is_program_running(&self, at_ms: u64) -> bool {
        self.program_gone_at_ms.is_none() && !self.is_active(FaultKind::ProgramStopped, at_ms)
    }

    /// Whether program or guard have ended in a run in which commands get lost.
    pub(super) fn has_ended_deaf(&self, at_ms: u64) -> bool {
        let has_ended = self.is_closing || self.program_gone_at_ms.is_some() || self.has_guard_ended;
        let was_deaf = |fault: &Fault| fault.kind == FaultKind::CommandsLost && fault.from_ms <= at_ms;
        has_ended && self.faults.iter().any(was_deaf)
    }

    /// Whether program and pilot run now, and do not end.
    pub(super) fn runs(&self, at_ms: u64) -> bool {
        self.is_program_running(at_ms)
            && !self.is_suspended
            && !self.is_closing
            && !self.is_active(FaultKind::PilotHangs, at_ms)
    }

    /// Lets the link run. Returns whether the guard was killed.
    pub(super) fn advance_link(&mut self, end: &mut LinkEnd<C>, moment: Moment) -> bool {
        let Moment { now, at_ms, .. } = moment;
        let is_killed = self.begins(FaultKind::GuardKilled, at_ms) && self.link.take().is_some();
        if is_killed {
            self.guard_died_at_ms = Some(at_ms);
            self.is_stop_sent = false;
            if self.is_program_running(at_ms) {
                self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
            }
        }
        let is_there = self.program_gone_at_ms.is_none();
        let is_thread = self.plan.guard_limits.is_none() || self.plan.mutant == Mutant::NoGuard;
        if is_thread && !self.is_program_running(at_ms) {
            return is_killed;
        }
        let Some(link) = &mut self.link else { return is_killed };
        if is_there {
            link.inbox.extend(end.outbox.drain(..));
        }
        link.advance(&mut self.line, is_there, now, at_ms);
        if let Some(is_stop_sent) = link.ended()
            && !self.is_closing
            && is_there
        {
            (self.is_stop_sent, self.has_guard_ended) = (is_stop_sent, true);
            // A guard that took the program for gone has ended; the program starts another.
            self.link = None;
            end.reports.push_back(LinkReport::GuardLost("it has ended".to_owned()));
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
        is_killed
    }

    /// Lets the program look after its link. Returns whether the program runs.
    pub(super) fn advance_program(&mut self, end: &mut LinkEnd<C>, moment: Moment) -> bool {
        let Moment { now, at_ms, .. } = moment;
        if self.begins(FaultKind::ProgramKilled, at_ms) {
            self.program_gone_at_ms.get_or_insert(at_ms);
        }
        if !self.is_program_running(at_ms) {
            let is_helpless = self.link.is_none()
                && self
                    .guard_died_at_ms
                    .is_some_and(|died| self.program_gone_at_ms.is_none_or(|gone| gone < died + TOGETHER_MS));
            self.is_excluded |= is_helpless;
            return false;
        }
        if self.guard_starts_at_ms.is_some_and(|starts| starts <= at_ms) {
            self.guard_starts_at_ms = None;
            let history = LinkHistory::after(self.is_stop_sent, end.is_anothers, None);
            self.link = Some(LinkHost::start(&self.plan, history, now));
            end.reports.push_back(LinkReport::GuardLost("it was killed".to_owned()));
        } else if self.link.is_none() && self.guard_starts_at_ms.is_none() {
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
        if let Some(link) = &mut self.link {
            end.reports.extend(link.reports.drain(..));
        }
        end.beat(now);
        !self.is_active(FaultKind::PilotHangs, at_ms)
    }
}
