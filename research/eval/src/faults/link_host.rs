//! The simulated owner of the link: a guard, with the gate and the link of the real one, or a thread of the
//! program, where the vehicle's commands expire by themselves.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use barrelman_link::guard::Gate;
use barrelman_link::guard::gate::GuardedCommand;
use barrelman_link::guard::message::ToGuard;
use barrelman_link::guard::watch::BEAT;
use barrelman_link::{LinkAction, LinkCore, LinkReport, RequestedCommand};
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::{ByteSession, LinkHistory};

use super::fault::FaultKind;
use super::line::Line;
use super::link_plan::LinkPlan;
use super::mutant::Mutant;

/// Of the real guard. A thread of the program gives up at once.
const PERSISTENCE: Duration = Duration::from_secs(60);

/// The owner of the link.
pub(super) struct LinkHost<C: GuardedCommand = VehicleRates> {
    core: LinkCore<ByteSession<C>>,
    /// Of a guard.
    gate: Option<Gate<C>>,
    /// Whether a line that is cut is an error of the port. Requests over a network get no answer instead.
    sees_cuts: bool,
    mutant: Mutant,
    is_port_open: bool,
    is_connected: bool,
    /// Whether zeros and stop were sent, of a link that has ended.
    ended: Option<bool>,
    poll_at: Timestamp,
    beat_at: Timestamp,
    /// Whether the program was told that the guard runs, and has not read it yet.
    pub(super) has_beaten: bool,
    /// Messages on their way to the link.
    pub(super) inbox: VecDeque<ToGuard<C>>,
    /// Reports on their way to the program.
    pub(super) reports: VecDeque<LinkReport>,
    /// What was sent in the newest millisecond.
    pub(super) sent: Vec<Vec<u8>>,
}

impl<C: GuardedCommand> LinkHost<C> {
    /// Starts a link. `history`: what a link before it has left.
    pub(super) fn start(plan: &LinkPlan<C>, history: LinkHistory, now: Timestamp) -> Self {
        let open_session = Arc::clone(&plan.open_session);
        let has_guard = plan.guard_limits.is_some();
        let persistence = if has_guard { PERSISTENCE } else { Duration::ZERO };
        let open = Box::new(move |now| open_session(now));
        let mut core = LinkCore::new(open, persistence);
        core.resume(history);
        Self {
            core,
            gate: plan.guard_limits.map(|limits| Gate::new(limits, now)),
            sees_cuts: has_guard,
            mutant: plan.mutant,
            is_port_open: false,
            is_connected: true,
            ended: None,
            poll_at: Timestamp::ZERO,
            beat_at: now,
            has_beaten: true,
            inbox: VecDeque::new(),
            reports: VecDeque::new(),
            sent: Vec::new(),
        }
    }

    /// Whether zeros and stop were sent, of a link that has ended.
    pub(super) const fn ended(&self) -> Option<bool> {
        self.ended
    }

    /// The machine was suspended.
    pub(super) fn on_suspension(&mut self) {
        self.core.request(RequestedCommand::REST);
        self.reports.push_back(LinkReport::Suspended(Duration::from_secs(1)));
        self.poll_at = Timestamp::ZERO;
    }

    /// Runs for a millisecond. `is_program_there`: whether the other end of the pipe is open.
    pub(super) fn advance(&mut self, line: &mut Line, is_program_there: bool, now: Timestamp, at_ms: u64) {
        self.sent.clear();
        if self.ended.is_some() {
            return;
        }
        self.serve_pipe(is_program_there, now);
        if self.beat_at <= now {
            self.beat_at = now.plus(BEAT);
            self.has_beaten = true;
        }
        let mut received = Vec::new();
        if self.is_port_open {
            if self.sees_cuts && line.is_active(FaultKind::LineCut, at_ms) {
                self.lose_port(now);
            }
            while let Some(bytes) = line.arrived_down(at_ms) {
                received.extend(bytes);
            }
        }
        let reports = &mut self.reports;
        if self.is_port_open && !received.is_empty() {
            self.poll_at = Timestamp::ZERO;
            self.core.received(&received, now, &mut |report| {
                reports.push_back(report);
                true
            });
        }
        while self.poll_at <= now && self.ended.is_none() {
            self.poll(line, now, at_ms);
        }
    }

    fn serve_pipe(&mut self, is_program_there: bool, now: Timestamp) {
        while let Some(message) = self.inbox.pop_front() {
            self.poll_at = Timestamp::ZERO;
            if let Some(gate) = &mut self.gate {
                gate.heard(now);
            }
            match message {
                ToGuard::Request(requested) if self.is_connected => {
                    let passed = match self.mutant {
                        Mutant::NoTimeToLive => {
                            let for_ever = now.plus(Duration::from_secs(3_600));
                            RequestedCommand { renew_by: Some(for_ever), ..requested }
                        }
                        _ => self.gate.as_mut().map_or(requested, |gate| gate.pass(requested, now)),
                    };
                    self.core.request(passed);
                }
                ToGuard::TakeControl => self.core.take_control(now),
                ToGuard::Close => self.disconnect(now),
                ToGuard::Request(_) | ToGuard::Settings(_) => {}
            }
        }
        let is_silent = self.gate.as_ref().is_some_and(|gate| gate.is_silent(now));
        if self.is_connected && (!is_program_there || is_silent) {
            self.disconnect(now);
        }
    }

    fn disconnect(&mut self, now: Timestamp) {
        self.is_connected = false;
        self.poll_at = Timestamp::ZERO;
        self.core.close(now);
    }

    fn lose_port(&mut self, now: Timestamp) {
        self.is_port_open = false;
        self.poll_at = Timestamp::ZERO;
        let reports = &mut self.reports;
        self.core.port_lost("unplugged".to_owned(), now, &mut |report| {
            reports.push_back(report);
            true
        });
    }

    fn poll(&mut self, line: &mut Line, now: Timestamp, at_ms: u64) {
        let mut out = Vec::new();
        let reports = &mut self.reports;
        let action = self.core.poll(now, &mut out, &mut |report| {
            reports.push_back(report);
            true
        });
        for packet in out {
            self.sent.push(packet.clone());
            line.send_up(packet, at_ms);
        }
        match action {
            LinkAction::Wait { until } => self.poll_at = until.max(now.plus(Duration::from_millis(1))),
            LinkAction::Open if line.is_active(FaultKind::LineCut, at_ms) => self.core.open_failed(now),
            LinkAction::Open => {
                self.is_port_open = true;
                self.core.opened(now);
            }
            LinkAction::ClosePort => self.is_port_open = false,
            LinkAction::Ended { is_stop_sent, evidence } => {
                self.reports.extend(evidence.map(LinkReport::Stopped));
                self.ended = Some(is_stop_sent);
            }
        }
    }
}
