//! What an answer changes in a session, and what it reports.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Telemetry, Timestamp, ZoomAbility};

use super::{OnvifSession, RETRY, State};
use crate::http::motion::Speeds as _;
use crate::onvif::answers::{Status, StatusBody};
use crate::onvif::ask::Ask;
use crate::onvif::joining_error::JoiningError;
use crate::onvif::refusal::Refusal;
use crate::onvif::{soap, watch};
use crate::session::RestEvidence;

type ReportSink<'a> = &'a mut dyn FnMut(Telemetry);

impl OnvifSession {
    /// An answer, or `None` where there was none.
    pub(super) fn on_answer(
        &mut self,
        id: u64,
        answer: Option<(u16, &[u8])>,
        now: Timestamp,
        report: ReportSink<'_>,
    ) {
        let Some(call) = self.lanes.take(id) else { return };
        if !matches!(self.state, State::Joining | State::Up | State::Closing { .. }) {
            return;
        }
        match call.ask {
            Ask::Status { .. } => self.on_status(answer, now, report),
            Ask::Move { velocity, .. } => {
                if !velocity.is_rest() {
                    self.motion.on_turn_answer(answer.is_some(), now);
                }
                self.on_command("ContinuousMove", answer, now);
            }
            Ask::Stop { .. } => self.on_command("Stop", answer, now),
            Ask::DateAndTime
            | Ask::Services
            | Ask::Capabilities
            | Ask::Profiles(_)
            | Ask::MoveOptions { .. }
            | Ask::StreamUri { .. } => self.on_joining(answer, now, report),
        }
    }

    fn on_joining(&mut self, answer: Option<(u16, &[u8])>, now: Timestamp, report: ReportSink<'_>) {
        // A question without an answer is asked again, until the camera counts as silent.
        let Some((status, body)) = answer.filter(|_| self.state == State::Joining) else { return };
        match self.joining.on_answer(status, body, now) {
            Err(error) => self.fail(error, now),
            Ok(()) => {
                if let Some(time) = self.joining.time() {
                    self.caller.set_time(time);
                }
                if let Some(joined) = self.joining.joined() {
                    let zoom = ZoomAbility::told(joined.full.zoom.is_some());
                    let used = joined.equipment().map(Report::Equipment);
                    for content in used.into_iter().chain([Report::Zoom(zoom)]) {
                        report(Telemetry { at: now, report: content });
                    }
                    // What turns the camera is not known.
                    self.motion.stop(now);
                    self.state = State::Up;
                }
            }
        }
    }

    /// The camera cannot be used for a while, and a link that is closing has no more to do. A motion ends by
    /// itself.
    fn fail(&mut self, error: JoiningError, now: Timestamp) {
        self.motion.yield_control();
        self.failure = Some(error);
        self.state = match self.state {
            State::Closing { .. } => State::Closed,
            _ => State::Refused { until: now.plus(RETRY) },
        };
    }

    fn on_command(&mut self, question: &'static str, answer: Option<(u16, &[u8])>, now: Timestamp) {
        let Some((status, body)) = answer else { return self.commands.on_no_answer(now) };
        self.commands.on_answer();
        match Refusal::of(status, body) {
            // The next conversation finds what the camera has now.
            Some(refusal) if refusal.said == Acceptance::LoginRefused || refusal.lacks_profile => {
                self.fail(JoiningError::Refused { question, refusal }, now);
            }
            // A camera that knows no Stop is stopped by the other kind of zero.
            Some(refusal) if question == "Stop" && refusal.is_unknown => {}
            Some(refusal) => self.commands.refuse(refusal.said, now),
            None => {}
        }
    }

    fn on_status(&mut self, answer: Option<(u16, &[u8])>, now: Timestamp, report: ReportSink<'_>) {
        let Some((status, body)) = answer else { return };
        let refusal = Refusal::of(status, body);
        if let Some(refusal) = refusal.clone().filter(|refusal| refusal.lacks_profile) {
            return self.fail(JoiningError::Refused { question: "GetStatus", refusal }, now);
        }
        let told = refusal.map_or_else(|| soap::read::<StatusBody>(body), |_| None);
        self.schedule.on_answer(told.is_none());
        if let Some(told) = told {
            self.on_motion(&told.answer.status, now);
            for content in watch::reports(&told.answer.status).into_iter().flatten() {
                report(Telemetry { at: now, report: content });
            }
        }
    }

    /// A camera that still turns after the zeros of this program's last motion gets more of them. One that
    /// another client turns is left alone.
    fn on_motion(&mut self, status: &Status, now: Timestamp) {
        self.watch.on_status(status, now);
        match self.watch.since(Timestamp::ZERO, now) {
            RestEvidence::AtRest => self.has_rested |= !self.motion.is_turning(),
            RestEvidence::Moving { .. } => self.motion.on_unexpected_motion(!self.has_rested, now),
            RestEvidence::NoTelemetry => {}
        }
    }

    /// Reports what the camera says to commands.
    pub(super) fn report_acceptance(&mut self, now: Timestamp, report: ReportSink<'_>) {
        if matches!(self.state, State::Closing { .. } | State::Closed) {
            return;
        }
        if let Some(said) = self.acceptance(now) {
            self.commands.report(said, now, report);
        }
    }
}
