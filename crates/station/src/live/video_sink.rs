//! What a live run does with the output of a video thread: the tracked video's frames go to the loop, units
//! to the recording and the console.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use barrelman_console_server::VideoOutlet;
use barrelman_console_server::operator::Gateway;
use barrelman_video::sender_clock::VideoTiming;
use barrelman_video::{DecodeError, VideoSink, VideoState};
use barrelman_vocab::{CameraRequest, EncodedUnit, OperatorRequest, PixelBox, VideoFrame, VideoNumber};

use super::event::Event;
use super::recorder::RecorderInput;
use super::tracked_video::{LatestFrame, TrackedVideo};

/// Where the output of the videos goes.
#[derive(Clone)]
pub(super) struct VideoReceivers {
    pub(super) tracked: TrackedVideo,
    pub(super) latest: Arc<LatestFrame>,
    pub(super) recorder: Option<RecorderInput>,
    pub(super) events: SyncSender<Event>,
    pub(super) gateway: Arc<Gateway>,
    /// Whether to select the target that a simulated world reports.
    pub(super) selects_target: bool,
}

/// Receives the output of one video thread.
pub(super) struct LiveVideoSink {
    number: VideoNumber,
    receivers: VideoReceivers,
    /// For the console's pages.
    outlet: Option<VideoOutlet>,
    damaged_units: u64,
}

impl LiveVideoSink {
    pub(super) const fn new(
        number: VideoNumber,
        receivers: VideoReceivers,
        outlet: Option<VideoOutlet>,
    ) -> Self {
        Self { number, receivers, outlet, damaged_units: 0 }
    }

    /// Names the video where that is not the first.
    const fn prefix(&self) -> &'static str {
        match self.number {
            VideoNumber::First => "",
            VideoNumber::Second => "video 2: ",
        }
    }

    fn send(&self, event: Event) {
        // Without a loop, the run has ended.
        let _ = self.receivers.events.send(event);
    }
}

impl VideoSink for LiveVideoSink {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        if let Some(recorder) = &self.receivers.recorder {
            recorder.unit(self.number, unit);
        }
        if let Some(outlet) = &self.outlet {
            outlet.relay.add(unit);
        }
    }

    fn on_frame(&mut self, frame: VideoFrame) {
        if self.receivers.tracked.number() != self.number {
            if let Some(outlet) = &self.outlet {
                outlet.pictures.show(&frame);
            }
        } else if self.receivers.latest.put((self.number, frame)) {
            self.send(Event::Frame);
        }
    }

    fn on_target(&mut self, target: PixelBox) {
        if self.receivers.selects_target {
            tracing::info!("no --select: the simulated world says where the boat is, {target}");
            let request = OperatorRequest::Camera(CameraRequest::SelectNext(target));
            self.receivers.gateway.submit_logged(request);
        }
    }

    fn on_state(&mut self, state: VideoState) {
        self.send(Event::Video(self.number, state));
    }

    fn on_timing(&mut self, timing: VideoTiming) {
        self.send(Event::VideoTiming(self.number, timing));
    }

    fn on_damage(&mut self, error: &DecodeError) {
        self.damaged_units += 1;
        if self.damaged_units == 1 {
            tracing::warn!("{}damaged video: {error}; further damage is counted", self.prefix());
        }
    }
}

impl Drop for LiveVideoSink {
    fn drop(&mut self) {
        if self.damaged_units > 1 {
            tracing::warn!("{}{} damaged pictures in all", self.prefix(), self.damaged_units);
        }
        // The video thread owns the sink: a drop during unwinding means that this thread panicked.
        if std::thread::panicking() {
            self.send(Event::ThreadPanicked { thread: "video".to_owned() });
        }
    }
}
