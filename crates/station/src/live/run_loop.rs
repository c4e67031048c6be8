//! The run loop: receives the next event, steps the pilot, and distributes the outcome.
//!
//! The loop makes no decision about the camera; the pilot does. A run ends when the video ends, when the operator or
//! the system requests it, or when a part of the program fails. In each case the pilot first receives a stop, so that
//! rest is the last command sent.
//!
//! Everything around the loop is a trait: the events with their time ([`EventSource`]), the link ([`VehicleLink`]), the
//! observers of steps ([`LiveStepObserver`]), and the status output ([`StatusOutput`]).

use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_host::latest::Latest;
use barrelman_pilot::{Input, Notice, Outcome, Pilot};
use barrelman_video::VideoState;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{OperatorRequest, StopCause, Telemetry, VehicleProfile, VehicleRates, VideoFrame};

use super::event::{Event, EventSource};
use super::status_line::{StatusLine, StatusOutput, link_state_text};
use super::threads::FaultInjector;
use crate::link::{LinkReport, VehicleLink};

/// Longest wait for an event: bounds the delay of the status line.
const MAX_WAIT: Duration = Duration::from_millis(200);

/// One step of the pilot in a live run. The time of the step is `outcome.at`.
#[derive(Debug, Clone, Copy)]
pub struct LiveStep<'a> {
    /// Number of the step, from 0.
    pub index: u64,
    /// The input.
    pub input: Input<'a>,
    /// The outcome.
    pub outcome: &'a Outcome,
    /// The rates sent to the link, in the vehicle's own signs.
    pub rates: VehicleRates,
}

/// Reads each step and changes nothing: the recording, the annotated video.
pub trait LiveStepObserver {
    /// The pilot made a step. Must not block.
    fn on_step(&mut self, step: &LiveStep<'_>);
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunEnd {
    /// The video ended.
    VideoEnded,
    /// The operator or the system requested the end, for this reason.
    Requested(String),
    /// A part of the program failed.
    Failed(String),
}

/// The loop with everything that it connects.
pub struct RunLoop<'a> {
    /// The pilot.
    pub pilot: Pilot,
    /// The vehicle profile, for the vehicle boundary.
    pub profile: VehicleProfile,
    /// The events and the time.
    pub events: &'a mut dyn EventSource,
    /// The slot of the newest video frame.
    pub latest: Arc<Latest<VideoFrame>>,
    /// The link; `None`: a dry run.
    pub link: Option<&'a dyn VehicleLink>,
    /// The recording, if there is one.
    pub recorder: Option<Box<dyn LiveStepObserver + 'a>>,
    /// The status line.
    pub status: StatusLine,
    /// Where the status line is shown.
    pub status_output: Box<dyn StatusOutput + 'a>,
    /// Whether a refused selection ends the run: where a selection can be made at the start only.
    pub ends_on_refused_selection: bool,
    /// The annotated video, if there is one.
    pub overlay: Option<Box<dyn LiveStepObserver + 'a>>,
    /// Deliberate faults.
    pub fault_injector: FaultInjector,
}

/// The state of the loop between events.
#[derive(Default)]
struct LoopState {
    steps: u64,
    outcome: Option<Outcome>,
    rates: VehicleRates,
    /// Why the selection of the last step was refused.
    refusal: Option<String>,
    has_video_been_up: bool,
    /// Failed attempts to connect to the video since it was last up.
    failed_connections: u64,
}

/// An end of the run, with the cause for the pilot's stop.
type Ending = (StopCause, RunEnd);

fn failed(reason: impl Into<String>) -> Ending {
    (StopCause::Fault, RunEnd::Failed(reason.into()))
}

impl RunLoop<'_> {
    /// Runs until an event ends the run. The pilot receives `requests` first.
    pub fn run(mut self, requests: &[OperatorRequest]) -> RunEnd {
        let mut state = LoopState::default();
        for request in requests {
            self.step(&mut state, Input::Request(*request));
        }
        let (cause, end) = loop {
            if let Some(ending) = self.wait_and_handle(&mut state) {
                break ending;
            }
        };
        self.step(&mut state, Input::Request(OperatorRequest::Stop(cause)));
        end
    }

    /// Waits for the next event or the pilot's deadline, whichever is first, and handles it.
    fn wait_and_handle(&mut self, state: &mut LoopState) -> Option<Ending> {
        let now = self.events.now();
        self.fault_injector.apply_faults("pilot", now);
        if let Some(line) = self.status.next_line(state.outcome.as_ref(), state.rates, now) {
            self.status_output.show(line);
        }
        let wake_at = state.outcome.as_ref().and_then(|outcome| outcome.wake_at);
        let wait = wake_at.map_or(MAX_WAIT, |at| at.since(now).min(MAX_WAIT));
        match self.events.next_event(wait) {
            Ok(event) => self.handle(state, event),
            Err(RecvTimeoutError::Timeout) => {
                if wake_at.is_some_and(|at| at <= self.events.now()) {
                    self.step(state, Input::Tick);
                }
                None
            }
            Err(RecvTimeoutError::Disconnected) => Some(failed("every source has gone")),
        }
    }

    /// Handles an event. Returns the end of the run if the event ends it.
    fn handle(&mut self, state: &mut LoopState, event: Event) -> Option<Ending> {
        match event {
            Event::Frame => return self.on_frame(state),
            Event::Request(request) => self.step(state, Input::Request(request)),
            Event::Link(report) => return self.on_link_report(state, report),
            Event::Video(video) => return on_video_state(state, video),
            Event::Quit(cause) => return Some((StopCause::Ending, RunEnd::Requested(cause.to_string()))),
            Event::ThreadPanicked { thread } => return Some(failed(format!("the {thread} thread panicked"))),
            Event::RecordingFailed { reason } => {
                tracing::error!("the recording has stopped: {reason}; the run goes on without a recording");
                self.status.alarm(format!("recording stopped: {reason}"));
                self.recorder = None;
            }
        }
        None
    }

    fn on_frame(&mut self, state: &mut LoopState) -> Option<Ending> {
        let frame = self.latest.take()?;
        let dropped = self.latest.replaced();
        self.step(state, Input::Frame(&frame));
        let age = state.outcome.as_ref().and_then(|outcome| outcome.age);
        self.status.frame(self.events.now(), age, dropped);
        state.refusal.take().filter(|_| self.ends_on_refused_selection).map(failed)
    }

    fn on_link_report(&mut self, state: &mut LoopState, report: LinkReport) -> Option<Ending> {
        match report {
            LinkReport::Telemetry(telemetry) => self.on_telemetry(state, telemetry),
            LinkReport::Lost(reason) => tracing::warn!("the link was lost ({reason}); reopening it"),
            LinkReport::Panicked => return Some(failed("the link thread panicked")),
        }
        None
    }

    fn on_telemetry(&mut self, state: &mut LoopState, telemetry: Telemetry) {
        if let Report::Link(link) = telemetry.report {
            tracing::info!("{}", link_state_text(link));
            self.status.link(link);
        }
        self.step(state, Input::Telemetry(telemetry));
    }

    /// Steps the pilot, sends the rates, and informs the observers, in this order.
    fn step(&mut self, state: &mut LoopState, input: Input<'_>) {
        let outcome = self.pilot.step(input, self.events.now());
        // The vehicle boundary: the only place of a live run that applies the vehicle's own signs.
        let rates = self.profile.to_vehicle(outcome.command);
        if let Some(link) = self.link {
            link.send(rates, outcome.wake_at);
        }
        let step = LiveStep { index: state.steps, input, outcome: &outcome, rates };
        if let Some(recorder) = &mut self.recorder {
            recorder.on_step(&step);
        }
        if let Some(notice) = &outcome.notice {
            self.log(notice);
        }
        if let Some(overlay) = &mut self.overlay {
            overlay.on_step(&step);
        }
        state.refusal = match &outcome.notice {
            Some(notice @ Notice::SelectionRefused(_)) => Some(notice.to_string()),
            _ => None,
        };
        state.steps += 1;
        state.rates = rates;
        state.outcome = Some(outcome);
    }

    fn log(&self, notice: &Notice) {
        match notice {
            Notice::Selected(_) => tracing::info!("{notice}"),
            // Reported as the end of the run.
            Notice::SelectionRefused(_) if self.ends_on_refused_selection => {}
            Notice::SelectionRefused(_) | Notice::VideoClockWentBack => tracing::warn!("{notice}"),
        }
    }
}

/// Logs a change of the video. The first failed connection is logged; the following ones are counted.
fn on_video_state(state: &mut LoopState, video: VideoState) -> Option<Ending> {
    match video {
        VideoState::Connecting => {}
        VideoState::Up => {
            match std::mem::take(&mut state.failed_connections) {
                0 | 1 => tracing::info!("video: up"),
                attempts => tracing::info!("video: up, after {attempts} attempts"),
            }
            state.has_video_been_up = true;
        }
        VideoState::Lost { reason } => {
            state.failed_connections += 1;
            match (state.failed_connections, state.has_video_been_up) {
                (1, true) => tracing::warn!("the video was lost ({reason}); reconnecting"),
                (1, false) => tracing::warn!("no video yet ({reason}); retrying until the source answers"),
                _ => {}
            }
        }
        VideoState::Ended => return Some((StopCause::VideoEnded, RunEnd::VideoEnded)),
        VideoState::Failed(error) => return Some(failed(format!("{:#}", anyhow::Error::from(error)))),
    }
    None
}
