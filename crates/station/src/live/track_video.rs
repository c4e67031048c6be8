//! The change from one video to the other, at rest.
//!
//! A change is made of a request and a report, so that a replay of the recording makes it, too.

use barrelman_console_server::operator::Answer;
use barrelman_console_server::snapshot::VideoSourceState;
use barrelman_pilot::{Input, Mode};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{CameraRequest, Telemetry, VideoNumber, VideoRequest};

use super::run_loop::{LoopState, RunLoop};

impl RunLoop<'_> {
    /// The answer to a request about the videos.
    pub(super) fn video_answer(&mut self, state: &mut LoopState, request: VideoRequest) -> Answer {
        let VideoRequest::TrackVideo { video } = request;
        match self.track_video(state, video) {
            Ok(()) => Answer::ACCEPTED,
            Err(reason) => Answer::Refused(reason),
        }
    }

    fn track_video(&mut self, state: &mut LoopState, wanted: VideoNumber) -> Result<(), String> {
        let newest = self.publisher.newest();
        let Some(other) = &newest.other_video else {
            return Err("there is one video: give --video a second time at the start of the run".to_owned());
        };
        if wanted == self.tracked.number() {
            return Ok(());
        }
        match newest.outcome.as_ref().map(|outcome| outcome.mode) {
            None | Some(Mode::Idle | Mode::Stopped(_)) => {}
            Some(Mode::Servoing | Mode::Holding(_)) => {
                return Err("the camera is engaged: disengage, then change the video".to_owned());
            }
            Some(Mode::Nudging | Mode::Searching | Mode::Calibrating) => {
                return Err("the camera turns: stop it, then change the video".to_owned());
            }
        }
        if other.state != VideoSourceState::Up {
            return Err(format!("video {} has no picture", wanted.count()));
        }
        self.step(state, Input::Request(CameraRequest::Deselect.into()));
        // A second video without a field of view of its own is of the same camera.
        let field_of_view = match wanted {
            VideoNumber::First => None,
            VideoNumber::Second => self.second_field_of_view,
        };
        let report = Report::OtherVideo(field_of_view);
        self.step(state, Input::Telemetry(Telemetry { at: self.events.now(), report }));
        self.tracked.choose(wanted);
        drop(self.latest.take());
        self.publisher.track_video(wanted, self.events.now());
        tracing::info!("the boat is looked for in video {} from now on", wanted.count());
        Ok(())
    }
}
