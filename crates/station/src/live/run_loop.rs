//! The loop: takes the next event, steps the pilot, and hands the outcome to whoever wants it.
//!
//! It decides nothing about the camera: that is the pilot's. It ends when the video has ended, when the operator
//! or the system asks for it, or when a part of the program has failed; each of these is first put to the pilot
//! as a stop, so that the last thing that leaves is a rest.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use barrelman_pilot::{Input, Notice, Outcome, Pilot};
use barrelman_trial::records::{RecordedInput, RecordedOutcome};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{OperatorRequest, StopCause, Timestamp, VehicleProfile, VehicleRates, VideoFrame};

use super::event::Event;
use super::recorder::RecorderInput;
use super::status::{self, Status};
use super::threads::FaultInjector;
use crate::link::{Link, LinkReport};
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_video::VideoState;

/// Longest wait without an event: bounds how late the status line is.
const MAX_WAIT: Duration = Duration::from_millis(200);

/// What watches the outcome of every frame, with the frame.
pub trait FrameObserver {
    /// A frame was put into the pilot.
    fn watch(&mut self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates);
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunEnd {
    /// The video came to its end.
    VideoEnded,
    /// It was asked for.
    Asked(String),
    /// Something failed.
    Failed(String),
}

/// The loop with all that it hands outcomes to.
pub struct RunLoop<'a> {
    /// The pilot.
    pub pilot: Pilot,
    /// The vehicle, for its door.
    pub profile: VehicleProfile,
    /// The clock.
    pub clock: Clock,
    /// Where frames come from.
    pub latest: Arc<Latest<VideoFrame>>,
    /// The link; `None`: a dry run.
    pub link: Option<&'a Link>,
    /// The recording, if there is one.
    pub recorder: Option<RecorderInput>,
    /// The status line.
    pub status: Status,
    /// Whether a selection can only be made at the start: one that is refused then ends the run.
    pub selects_once: bool,
    /// The annotated video, if there is one.
    pub observer: Option<Box<dyn FrameObserver + 'a>>,
    /// Faults on purpose.
    pub fault_injector: FaultInjector,
}

impl RunLoop<'_> {
    /// Runs until something ends it. `requests` are put to the pilot first.
    pub fn run(mut self, events: &Receiver<Event>, requests: &[OperatorRequest]) -> RunEnd {
        let mut state = Stepping::default();
        for request in requests {
            self.step_with(&mut state, Input::Request(*request), None);
        }
        loop {
            let now = self.clock.now();
            self.fault_injector.apply_faults("pilot", now);
            self.status.show(state.outcome.as_ref(), state.rates, now);
            let wake_at = state.outcome.as_ref().and_then(|outcome| outcome.wake_at);
            let wait = wake_at.map_or(MAX_WAIT, |at| at.since(now).min(MAX_WAIT));
            let event = match events.recv_timeout(wait) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => {
                    if wake_at.is_some_and(|at| at <= self.clock.now()) {
                        self.step_with(&mut state, Input::Tick, None);
                    }
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return self.end(
                        &mut state,
                        StopCause::Fault,
                        RunEnd::Failed("every source has gone".to_owned()),
                    );
                }
            };
            if let Some((cause, end)) = self.take(&mut state, event) {
                return self.end(&mut state, cause, end);
            }
        }
    }

    /// Takes an event; what comes back ends the run.
    fn take(&mut self, state: &mut Stepping, event: Event) -> Option<(StopCause, RunEnd)> {
        match event {
            Event::Frame => {
                if let Some(frame) = self.latest.take() {
                    let dropped = self.latest.replaced();
                    self.step_with(state, Input::Frame(&frame), Some(&frame));
                    let age = state.outcome.as_ref().and_then(|outcome| outcome.age);
                    self.status.frame(self.clock.now(), age, dropped);
                    if let Some(why) = state.refused.take().filter(|_| self.selects_once) {
                        return Some((StopCause::Fault, RunEnd::Failed(why)));
                    }
                }
            }
            Event::Request(request) => self.step_with(state, Input::Request(request), None),
            Event::Link(LinkReport::Telemetry(telemetry)) => {
                if let Report::Link(link) = telemetry.report {
                    tracing::info!("{}", status::in_words(link));
                    self.status.link(link);
                }
                self.step_with(state, Input::Telemetry(telemetry), None);
            }
            Event::Link(LinkReport::Lost(reason)) => {
                tracing::warn!("the link was lost ({reason}): it is being opened anew");
            }
            Event::Link(LinkReport::Panicked) => {
                return Some((StopCause::Fault, RunEnd::Failed("the link thread panicked".to_owned())));
            }
            Event::Video(VideoState::Connecting) => {}
            Event::Video(VideoState::Up) => {
                match std::mem::take(&mut state.video_losses) {
                    0 | 1 => tracing::info!("video: up"),
                    tries => tracing::info!("video: up, after {tries} tries"),
                }
                state.was_up = true;
            }
            Event::Video(VideoState::Lost { reason }) => {
                // Said once; the tries that follow are counted.
                state.video_losses += 1;
                match (state.video_losses, state.was_up) {
                    (1, true) => tracing::warn!("the video was lost ({reason}): it is being connected again"),
                    (1, false) => tracing::warn!("no video yet ({reason}): it is tried until it answers"),
                    _ => {}
                }
            }
            Event::Video(VideoState::Ended) => return Some((StopCause::VideoEnded, RunEnd::VideoEnded)),
            Event::Video(VideoState::Failed(error)) => {
                let reason = format!("{:#}", anyhow::Error::from(error));
                return Some((StopCause::Fault, RunEnd::Failed(reason)));
            }
            Event::Quit(cause) => return Some((StopCause::Ending, RunEnd::Asked(cause.to_string()))),
            Event::ThreadPanicked { thread } => {
                let reason = format!("the {thread} thread panicked");
                return Some((StopCause::Fault, RunEnd::Failed(reason)));
            }
            Event::RecordingFailed { reason } => {
                tracing::error!("the recording has stopped: {reason}; the camera is moved on without one");
                self.status.alarm(format!("recording stopped: {reason}"));
                self.recorder = None;
            }
        }
        None
    }

    fn end(&mut self, state: &mut Stepping, cause: StopCause, end: RunEnd) -> RunEnd {
        self.step_with(state, Input::Request(OperatorRequest::Stop(cause)), None);
        end
    }

    fn step_with(&mut self, state: &mut Stepping, input: Input<'_>, frame: Option<&VideoFrame>) {
        let now = self.clock.now();
        let outcome = self.pilot.step(input, now);
        // The door: the only place of a live run where the vehicle's own signs are applied.
        let rates = self.profile.to_vehicle(outcome.command);
        if let Some(link) = self.link {
            link.send(rates, outcome.wake_at);
        }
        self.record(state.step, now, input, &outcome, rates);
        if let Some(notice) = &outcome.notice {
            match notice {
                Notice::Selected(_) => tracing::info!("{notice}"),
                Notice::SelectionRefused(_) if self.selects_once => {}
                Notice::SelectionRefused(_) | Notice::VideoClockWentBack => tracing::warn!("{notice}"),
            }
        }
        if let (Some(observer), Some(frame)) = (&mut self.observer, frame) {
            observer.watch(frame, &outcome, rates);
        }
        state.refused = match &outcome.notice {
            Some(notice @ Notice::SelectionRefused(_)) => Some(notice.to_string()),
            _ => None,
        };
        state.step += 1;
        state.rates = rates;
        state.outcome = Some(outcome);
    }

    fn record(&self, step: u64, now: Timestamp, input: Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        let Some(recorder) = &self.recorder else { return };
        match RecordedInput::from_frameless(&input) {
            Ok(recorded) => recorder.input(step, now, recorded),
            Err(frame) => recorder.frame(step, now, frame),
        }
        recorder.outcome(RecordedOutcome::new(step, outcome, rates));
    }
}

/// What the loop remembers from one event to the next.
#[derive(Default)]
struct Stepping {
    step: u64,
    outcome: Option<Outcome>,
    rates: VehicleRates,
    /// Why the selection of the last step was refused.
    refused: Option<String>,
    was_up: bool,
    /// Attempts at the video that failed since it was last up.
    video_losses: u64,
}
