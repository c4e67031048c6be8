//! The simulated owner of the link: a guard, with the gate and the link of the real one, or a thread of the program, where the
//! vehicle's commands expire by themselves.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::Result;
use barrelman_host::fault::FaultPlan;
use barrelman_link::guard::Gate;
use barrelman_link::guard::message::ToGuard;
use barrelman_link::{LinkAction, LinkCore, LinkReport, RequestedRates};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};
use barrelman_wire::{ByteSession, NextAction, RestEvidence, Session, WillStep};

use super::fault::FaultKind;
use super::line::Line;
use super::mutant::Mutant;
use crate::vehicle::Vehicle;

/// Of the real guard. A thread of the program gives up at once.
const PERSISTENCE: Duration = Duration::from_secs(60);

/// The owner of the link.
pub(super) struct LinkHost {
    core: LinkCore<ByteSession>,
    /// Of a guard.
    gate: Option<Gate>,
    /// Whether a line that is cut is an error of the port. Requests over a network get no answer instead.
    sees_cuts: bool,
    mutant: Mutant,
    is_port_open: bool,
    is_connected: bool,
    /// Whether zeros and stop were sent, of a link that has ended.
    ended: Option<bool>,
    poll_at: Timestamp,
    /// Messages on their way to the link.
    pub(super) inbox: VecDeque<ToGuard>,
    /// Reports on their way to the program.
    pub(super) reports: VecDeque<LinkReport>,
}

impl LinkHost {
    /// Starts a link. `may_be_turning`: a link before it may have left the camera turning.
    pub(super) fn start(
        vehicle: Vehicle,
        mutant: Mutant,
        may_be_turning: bool,
        now: Timestamp,
    ) -> Result<Self> {
        let limits = vehicle.profile().protocol.rate_limits();
        let open_session = vehicle.session_opener()?;
        let open = move |now| -> Box<ByteSession> {
            let session = open_session(now);
            match mutant {
                Mutant::NoZerosFirst => Box::new(WithoutFirstZeros { vehicle, session, has_begun: false }),
                _ => session,
            }
        };
        let has_guard = vehicle.has_guard();
        let persistence = if has_guard { PERSISTENCE } else { Duration::ZERO };
        let mut core = LinkCore::new(Box::new(open), FaultPlan::default(), persistence);
        if may_be_turning {
            core.expect_motion();
        }
        Ok(Self {
            core,
            gate: has_guard.then(|| Gate::new(VehicleRates { yaw: limits.pan, pitch: limits.tilt }, now)),
            sees_cuts: has_guard,
            mutant,
            is_port_open: false,
            is_connected: true,
            ended: None,
            poll_at: Timestamp::ZERO,
            inbox: VecDeque::new(),
            reports: VecDeque::new(),
        })
    }

    /// Whether zeros and stop were sent, of a link that has ended.
    pub(super) const fn ended(&self) -> Option<bool> {
        self.ended
    }

    /// The machine was suspended.
    pub(super) fn on_suspension(&mut self) {
        self.core.request(RequestedRates::REST);
        self.reports.push_back(LinkReport::Suspended(Duration::from_secs(1)));
        self.poll_at = Timestamp::ZERO;
    }

    /// Runs for a millisecond. `is_program_there`: whether the other end of the pipe is open.
    pub(super) fn advance(&mut self, line: &mut Line, is_program_there: bool, now: Timestamp, at_ms: u64) {
        if self.ended.is_some() {
            return;
        }
        self.serve_pipe(is_program_there, now);
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
                            RequestedRates { renew_by: Some(for_ever), ..requested }
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
            LinkAction::Ended { is_stop_sent } => self.ended = Some(is_stop_sent),
        }
    }
}

/// The mutant of a session that does not begin with zeros.
struct WithoutFirstZeros {
    vehicle: Vehicle,
    session: Box<ByteSession>,
    has_begun: bool,
}

impl Session for WithoutFirstZeros {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let mut packets = Vec::new();
        let next = self.session.poll(now, &mut packets);
        if self.vehicle == Vehicle::MavlinkGimbal {
            out.append(&mut packets);
            return next;
        }
        for packet in packets {
            let stop = packet.windows(4).position(|window| window == b"stop");
            if !self.has_begun {
                let Some(stop) = stop else { continue };
                self.has_begun = true;
                out.push([b"\r", &packet[stop..]].concat());
            } else {
                out.push(packet);
            }
        }
        next
    }

    fn received(&mut self, bytes: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        self.session.received(bytes, now, report);
    }

    fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.session.request(rates, renew_by);
    }

    fn close(&mut self, now: Timestamp) {
        self.session.close(now);
    }

    fn link_state(&self) -> LinkState {
        self.session.link_state()
    }

    /// A MAVLink gimbal gets zeros first where a session before may have left it turning.
    fn must_be_answered(&mut self) {
        if self.vehicle != Vehicle::MavlinkGimbal {
            self.session.must_be_answered();
        }
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        self.session.rest_evidence(now)
    }

    fn may_be_turning(&self) -> bool {
        self.session.may_be_turning()
    }

    fn last_will(&self) -> Vec<WillStep<Vec<u8>>> {
        self.session.last_will()
    }
}
