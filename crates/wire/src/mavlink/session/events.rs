//! What received messages change in a session.

use barrelman_vocab::telemetry::{Quaternion, Report};
use barrelman_vocab::{Telemetry, Timestamp};

use super::{GimbalSession, HAS_ZEROS_AFTER, MAX_CANDIDATES, RELEASES, State, searching};
use crate::closing_zeros::ZEROS_AT_REST;
use crate::mavlink::gimbal_reader::{Claim, Holder, Received};
use crate::session::{RestEvidence, Session as _};

impl GimbalSession {
    pub(super) fn on_received(
        &mut self,
        received: Received,
        now: Timestamp,
        report: &mut dyn FnMut(Telemetry),
    ) {
        match received {
            Received::Heartbeat(from, is_ground_station) => {
                let is_new = !is_ground_station && !self.candidates.contains(&from);
                if is_new && self.candidates.len() < MAX_CANDIDATES {
                    self.candidates.push(from);
                }
            }
            Received::Gimbal(gimbal) => {
                self.gimbal = Some(gimbal);
                self.on_heard(now);
            }
            Received::Device(_) => {
                self.described_at.get_or_insert(now);
            }
            Received::Autopilot(kinds) => {
                for (subscription, _) in
                    self.autopilot.iter_mut().zip(kinds).filter(|(_, is_heard)| *is_heard)
                {
                    subscription.on_heard(now);
                }
            }
            Received::Information(_) => {
                self.has_information = true;
                self.on_heard(now);
            }
            Received::Holder(holder) => {
                self.last_status = Some(now);
                self.holder = Some(holder);
                self.on_holder(holder);
            }
            Received::ClaimAnswered(claim) => self.on_claim_answered(claim, now),
            Received::Attitude(attitude) => self.on_attitude(attitude, now),
            Received::Restarted => self.on_restarted(now),
            Received::ZoomAnswered => self.zooming.on_answer(now),
            Received::FieldOfView(angle) => {
                self.zooming.on_field_of_view(now);
                report(Telemetry { at: now, report: Report::FieldOfView(angle) });
            }
            Received::Camera(information) => {
                let system = self.target().manager.system;
                self.zooming.on_information(information, system, now);
            }
            Received::Stream(_) => {}
            Received::Other => self.on_heard(now),
            Received::Report(content) => report(Telemetry { at: now, report: content }),
        }
    }

    /// The gimbal manager was heard. A vehicle that was silent during the shut-down may have received none of
    /// its zeros.
    fn on_heard(&mut self, now: Timestamp) {
        if let State::Closing { since, zeros_sent, next_at } = &mut self.state
            && self.last_heard.is_none_or(|heard| heard < *since)
            && *zeros_sent > ZEROS_AT_REST
        {
            (*zeros_sent, *next_at) = (0, now);
        }
        let has_zeros = |moved_at: &Timestamp| now.since(*moved_at) >= HAS_ZEROS_AFTER;
        self.moved_at = self.moved_at.filter(|moved_at| !has_zeros(moved_at));
        self.last_heard = Some(now);
    }

    fn on_attitude(&mut self, attitude: Quaternion, now: Timestamp) {
        self.last_attitude = Some(now);
        self.attitude.on_attitude(attitude, now);
        let evidence = self.evidence_since(Timestamp::ZERO, now);
        self.is_seen_turning = matches!(evidence, RestEvidence::Moving { .. });
    }

    fn on_holder(&mut self, holder: Holder) {
        match (self.state, holder) {
            (State::Asking { .. } | State::Up | State::Yielded, Holder::Other(_))
            | (State::Claiming { is_by_operator: false, .. }, Holder::Other(_)) => self.yield_control(),
            // Without a commander, no other program stops a gimbal that turns.
            (State::Up, Holder::Nobody) => {
                let may_be_turning = self.pacing.may_be_turning();
                self.yield_control();
                self.owes_zeros = may_be_turning;
            }
            // Another commander has taken the control in the last moment: the gimbal is its own.
            (State::Closing { .. } | State::Releasing { .. }, Holder::Other(_)) => self.state = State::Closed,
            // The rates before are unknown.
            (State::Asking { .. } | State::Claiming { .. } | State::Yielded, Holder::Us) => self.begin_up(),
            _ => {}
        }
    }

    fn on_claim_answered(&mut self, claim: Claim, now: Timestamp) {
        match (&mut self.state, claim) {
            (State::Claiming { accepted_at, .. }, Claim::Accepted) => {
                accepted_at.get_or_insert(now);
            }
            (State::Claiming { .. }, Claim::Refused) => self.yield_control(),
            (State::Releasing { sent, next_at }, _) => (*sent, *next_at) = (RELEASES, now),
            _ => {}
        }
    }

    fn on_restarted(&mut self, now: Timestamp) {
        if matches!(self.state, State::Closing { .. } | State::Releasing { .. } | State::Closed) {
            return;
        }
        self.is_operator_asked |= self.state == State::Yielded;
        // A vehicle that obeys everybody has gone on with the rates that were sent until its restart was
        // known.
        self.needs_answer |= self.may_be_turning();
        (self.zeros_at, self.left_zeros_sent) = (now, 0);
        (self.gimbal, self.has_information, self.holder) = (None, false, None);
        self.described_at = None;
        self.state = searching(now);
    }
}
