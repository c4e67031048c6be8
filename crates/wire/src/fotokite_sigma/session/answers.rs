//! What an answer changes in a session, and what it reports.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Equipment, EquipmentKind, Telemetry, Timestamp};

use super::{FotokiteSigmaSession, INFO_RETRY, State, TOKEN_RETRY};
use crate::fotokite_sigma::call::{Call, StreamId};
use crate::fotokite_sigma::control::refusal;
use crate::fotokite_sigma::json;
use crate::fotokite_sigma::reports::{TURNS, field_of_view_of, pan_of, tilt_of};
use crate::http::motion::Speeds as _;
use crate::session::RestEvidence;

type ReportSink<'a> = &'a mut dyn FnMut(Telemetry);

fn tell(content: Option<Report>, now: Timestamp, report: ReportSink<'_>) {
    if let Some(content) = content {
        report(Telemetry { at: now, report: content });
    }
}

impl FotokiteSigmaSession {
    /// An answer, or `None` where there was none.
    pub(super) fn on_answer(
        &mut self,
        id: u64,
        answer: Option<(u16, &[u8])>,
        now: Timestamp,
        report: ReportSink<'_>,
    ) {
        let Some(call) = self.lanes.take(id) else { return };
        let status = answer.map(|(status, _)| status);
        if status == Some(401) && self.is_open() {
            self.motion.yield_control();
            self.state = State::Refused { until: now.plus(TOKEN_RETRY) };
            return;
        }
        let body = answer.filter(|(status, _)| (200..300).contains(status)).map(|(_, body)| body);
        match call {
            Call::CameraInfo => self.on_info(status, body, now),
            Call::RequestControl => self.on_control_answer(status, now),
            Call::Turn { speeds, .. } => {
                if !speeds.is_rest() {
                    self.motion.on_turn_answer(status.is_some(), now);
                }
                self.on_command(status, now);
            }
            Call::CameraState => {
                if let Some(state) = body.and_then(json::read) {
                    self.on_camera_state(&state, now, report);
                }
            }
            Call::Subscribe if status == Some(101) => {}
            Call::Subscribe => self.schedule.on_socket_end(now),
            Call::VideoStreams => self.on_video_streams(body, now, report),
            Call::VideoStreamState { .. } => {
                let state: Option<json::VideoStreamState> = body.and_then(json::read);
                if let Some(level) = state.and_then(|state| state.zoom_level) {
                    self.zoom.on_level(level, now);
                }
                tell(state.as_ref().and_then(field_of_view_of), now, report);
            }
            Call::FlightState => {
                if let Some(state) = body.and_then(json::read) {
                    self.flight.on_state(&state);
                    tell(self.flight.report(), now, report);
                }
            }
            Call::SystemState => {
                if let Some(state) = body.and_then(json::read) {
                    self.flight.on_batteries(&state);
                    tell(self.flight.report(), now, report);
                }
            }
            Call::Notifications => {
                if let Some(list) = body.and_then(json::read::<Vec<json::Notification>>) {
                    self.flight.on_notifications(&list);
                    tell(self.flight.report(), now, report);
                }
            }
            Call::Zoom { .. } => self.zoom.on_answer(body.is_some(), now),
            Call::ReleaseControl | Call::ShowStatus { .. } => {}
        }
    }

    fn on_control_answer(&mut self, status: Option<u16>, now: Timestamp) {
        let is_newly_ours = self.control.on_answer(status, now);
        if !self.control.is_ours() {
            self.motion.yield_control();
        } else if is_newly_ours {
            self.motion.stop(now);
        }
        if self.state == State::Joining && self.control.is_known() {
            self.state = State::Up;
        }
    }

    fn on_video_streams(&mut self, body: Option<&[u8]>, now: Timestamp, report: ReportSink<'_>) {
        let streams: Vec<json::VideoStream> = body.and_then(json::read).unwrap_or_default();
        let main = json::main_stream(&streams, self.stream.as_deref());
        self.zoom.set_stream(main);
        self.schedule.set_stream(main.and_then(|stream| StreamId::new(&stream.stream_id)));
        if let Some(main) = main {
            let used = Equipment::new(EquipmentKind::Stream, &main.stream_id);
            tell(Some(Report::Equipment(used)), now, report);
            tell(Some(Report::Zoom(self.zoom.ability())), now, report);
        }
    }

    fn on_info(&mut self, status: Option<u16>, body: Option<&[u8]>, now: Timestamp) {
        self.info_at = now.plus(INFO_RETRY);
        match body.and_then(json::read) {
            Some(info) => {
                self.info = Some(info);
                self.commands.forget_refusal();
                if self.state == State::Looking {
                    self.state = if self.control.is_known() { State::Up } else { State::Joining };
                }
            }
            None => {
                // An answer that cannot be read is a fault of the vehicle's.
                let said = status
                    .map_or(Acceptance::Unanswered, |status| refusal(status).unwrap_or(Acceptance::Fault));
                self.commands.refuse(said, now);
            }
        }
    }

    fn on_command(&mut self, status: Option<u16>, now: Timestamp) {
        let Some(status) = status else { return self.commands.on_no_answer(now) };
        self.commands.on_answer();
        if status == 403 {
            // Another client controls.
            self.control.lose();
            self.motion.yield_control();
            return;
        }
        let Some(said) = refusal(status) else { return };
        if said == Acceptance::Unusable {
            // The limits may have changed with the camera.
            self.info_at = now;
        }
        self.commands.refuse(said, now);
    }

    pub(super) fn on_camera_state(
        &mut self,
        state: &json::CameraState,
        now: Timestamp,
        report: ReportSink<'_>,
    ) {
        self.is_offline = state.online_state.as_deref() == Some("Offline");
        self.camera.on_state(state, now);
        if let RestEvidence::Moving { rate } = self.camera.since(Timestamp::ZERO, now) {
            self.motion.on_unexpected_motion(rate > TURNS, now);
        }
        tell(tilt_of(state), now, report);
        tell(pan_of(state), now, report);
    }

    /// Reports what the vehicle says to commands.
    pub(super) fn report_acceptance(&mut self, now: Timestamp, report: ReportSink<'_>) {
        // Nothing is known before the first answers.
        if matches!(self.state, State::Closing { .. } | State::Closed)
            || (self.is_starting() && !self.is_told())
        {
            return;
        }
        self.commands.report(self.acceptance(now), now, report);
    }
}
