//! What a live run does with the output of the video thread: frames to the loop, units to the recording and the console.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use barrelman_console_server::VideoRelay;
use barrelman_console_server::operator::Gateway;
use barrelman_host::latest::Latest;
use barrelman_video::sender_clock::VideoTiming;
use barrelman_video::{DecodeError, VideoSink, VideoState};
use barrelman_vocab::{CameraRequest, EncodedUnit, OperatorRequest, PixelBox, VideoFrame};

use super::event::Event;
use super::recorder::RecorderInput;

/// Receives the output of the video thread.
pub(super) struct LiveVideoSink {
    pub(super) latest: Arc<Latest<VideoFrame>>,
    pub(super) recorder: Option<RecorderInput>,
    /// The video for the console's pages.
    pub(super) relay: Option<Arc<VideoRelay>>,
    pub(super) events: SyncSender<Event>,
    pub(super) gateway: Arc<Gateway>,
    /// Whether to select the target that a simulated world reports.
    pub(super) selects_target: bool,
    pub(super) damaged_units: u64,
}

impl VideoSink for LiveVideoSink {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        if let Some(recorder) = &self.recorder {
            recorder.unit(unit);
        }
        if let Some(relay) = &self.relay {
            relay.add(unit);
        }
    }

    fn on_frame(&mut self, frame: VideoFrame) {
        if self.latest.put(frame) {
            let _ = self.events.send(Event::Frame);
        }
    }

    fn on_target(&mut self, target: PixelBox) {
        if self.selects_target {
            tracing::info!("no --select: the simulated world says where the boat is, {target}");
            self.gateway.submit_logged(OperatorRequest::Camera(CameraRequest::SelectNext(target)));
        }
    }

    fn on_state(&mut self, state: VideoState) {
        let _ = self.events.send(Event::Video(state));
    }

    fn on_timing(&mut self, timing: VideoTiming) {
        let _ = self.events.send(Event::VideoTiming(timing));
    }

    fn on_damage(&mut self, error: &DecodeError) {
        self.damaged_units += 1;
        if self.damaged_units == 1 {
            tracing::warn!("damaged video: {error}; further damage is counted");
        }
    }
}

impl Drop for LiveVideoSink {
    fn drop(&mut self) {
        if self.damaged_units > 1 {
            tracing::warn!("{} damaged pictures in all", self.damaged_units);
        }
        // The video thread owns the sink: a drop during unwinding means that this thread panicked.
        if std::thread::panicking() {
            let _ = self.events.send(Event::ThreadPanicked { thread: "video".to_owned() });
        }
    }
}
