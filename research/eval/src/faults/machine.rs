//! The machine that the program runs on, as far as faults of processes, of the clock and of the line go: the
//! guard's life and death, the program's, suspensions, and the line with its faults.

use barrelman_host::absence::TurnWatch;
use barrelman_link::LinkReport;
use barrelman_link::guard::gate::GuardedCommand;
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::LinkHistory;

use barrelman_link::guard::watch::{GuardWatch, HUNG_WHILE_REOPENING, LOOK_INTERVAL};

use super::fault::{self, Fault, FaultKind};
use super::line::Line;
use super::link_end::LinkEnd;
use super::link_host::LinkHost;
use super::link_plan::LinkPlan;
use super::mutant::Mutant;

/// From the death of a guard to the start of the next, ms.
const GUARD_STARTS_MS: u64 = 40;
/// A program that is gone within this time of its guard's death cannot replace it, ms: both are killed
/// together.
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

/// A pilot that made no turn for this time waits for the operator, ms.
const AWAY_MS: u128 = 1_000;

/// What a turn of the pilot's loop finds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Whether the loop was away for a second or more, judged apart from the program.
    pub(super) was_away: bool,
    /// Whether the program notices it.
    pub(super) is_noticed: bool,
}

/// The machine.
pub(super) struct Machine<C: GuardedCommand = VehicleRates> {
    plan: LinkPlan<C>,
    pub(super) faults: Vec<Fault>,
    pub(super) line: Line,
    link: Option<LinkHost<C>>,
    watch: GuardWatch,
    turns: TurnWatch,
    turned_at: Timestamp,
    /// Until when the guard that is there hangs, ms.
    hangs_until_ms: Option<u64>,
    replaces_hung_guard: bool,
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
    pub(super) fn start(plan: LinkPlan<C>, faults: Vec<Fault>, rng: SplitMix64) -> Self {
        Self {
            line: Line::new(&faults, rng),
            link: Some(LinkHost::start(&plan, LinkHistory::default(), Timestamp::ZERO)),
            plan,
            faults,
            watch: GuardWatch::start(HUNG_WHILE_REOPENING, Timestamp::ZERO),
            turns: TurnWatch::start(Timestamp::ZERO),
            turned_at: Timestamp::ZERO,
            hangs_until_ms: None,
            replaces_hung_guard: false,
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

    /// Whether the guard that is missing now hung, and was killed for that.
    pub(super) const fn replaces_hung_guard(&self) -> bool {
        self.replaces_hung_guard
    }

    /// Whether a guard carries out what the program asks for: it is there, and does not hang.
    pub(super) const fn has_live_guard(&self) -> bool {
        self.link.is_some() && self.hangs_until_ms.is_none()
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

    /// Whether the link is a thread of the program, without a guard.
    fn is_thread(&self) -> bool {
        self.plan.guard_limits.is_none() || self.plan.mutant == Mutant::NoGuard
    }

    /// Lets the link run. Returns whether the guard was killed by a fault, or begins to hang.
    pub(super) fn advance_link(&mut self, end: &mut LinkEnd<C>, moment: Moment) -> bool {
        let Moment { now, at_ms, .. } = moment;
        let is_killed = self.begins(FaultKind::GuardKilled, at_ms) && self.lose_guard(at_ms);
        let hang = self.faults.iter().find(|fault| fault.begins(FaultKind::GuardHangs, at_ms));
        let hangs_until_ms =
            hang.map(|fault| fault.until_ms).filter(|_| self.has_link() && !self.is_thread());
        self.hangs_until_ms = self.hangs_until_ms.max(hangs_until_ms).filter(|until_ms| at_ms < *until_ms);
        let is_struck = is_killed || hangs_until_ms.is_some();
        let is_there = self.program_gone_at_ms.is_none();
        if self.hangs_until_ms.is_some() || (self.is_thread() && !self.is_program_running(at_ms)) {
            return is_struck;
        }
        let Some(link) = &mut self.link else { return is_struck };
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
        is_struck
    }

    /// The guard is no more. Returns whether there was one.
    fn lose_guard(&mut self, at_ms: u64) -> bool {
        if self.link.take().is_none() {
            return false;
        }
        self.hangs_until_ms = None;
        self.replaces_hung_guard = false;
        self.guard_died_at_ms = Some(at_ms);
        self.is_stop_sent = false;
        if self.is_program_running(at_ms) {
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
        true
    }

    /// The program kills a guard that hangs.
    fn watch_guard(&mut self, at_ms: u64, now: Timestamp) {
        let Some(link) = &mut self.link else { return };
        if std::mem::take(&mut link.has_beaten) {
            self.watch.heard();
        }
        let looks = at_ms.is_multiple_of(LOOK_INTERVAL.as_millis() as u64);
        if looks && self.watch.hangs(now) && !self.is_thread() && self.plan.mutant != Mutant::NoGuardWatch {
            self.replaces_hung_guard = self.lose_guard(at_ms);
        }
    }

    /// The pilot's loop makes a turn.
    pub(super) fn turn(&mut self, moment: Moment) -> Turn {
        let turned_at = std::mem::replace(&mut self.turned_at, moment.now);
        let away = self.turns.turn(moment.now);
        Turn {
            was_away: moment.now.since(turned_at).as_millis() >= AWAY_MS,
            is_noticed: away.is_some() && self.plan.mutant != Mutant::NoAbsenceWatch,
        }
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
            // A guard that hangs is replaced by a program that runs.
            self.is_excluded |= is_helpless || self.hangs_until_ms.is_some();
            return false;
        }
        if self.guard_starts_at_ms.is_some_and(|starts| starts <= at_ms) {
            self.guard_starts_at_ms = None;
            let history = LinkHistory::after(self.is_stop_sent, end.is_anothers, None);
            self.link = Some(LinkHost::start(&self.plan, history, now));
            self.watch = GuardWatch::start(HUNG_WHILE_REOPENING, now);
            end.reports.push_back(LinkReport::GuardLost("it was killed".to_owned()));
        } else if self.link.is_none() && self.guard_starts_at_ms.is_none() {
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
        self.watch_guard(at_ms, now);
        if let Some(link) = &mut self.link {
            end.reports.extend(link.reports.drain(..));
        }
        end.beat(now);
        !self.is_active(FaultKind::PilotHangs, at_ms)
    }
}
