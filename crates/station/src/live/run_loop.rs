//! The run loop: receives the next event, steps the pilot, and distributes the outcome.
//!
//! The loop makes no decision about the camera; the pilot does. A run ends when the video ends, when the
//! operator or the system requests it, or when a part of the program fails. In each case the pilot first
//! receives a stop, so that rest is the last command sent.
//!
//! Everything around the loop is a trait: the events with their time ([`EventSource`]), the link
//! ([`VehicleLink`]), the observers of steps ([`LiveStepObserver`]), and the status output
//! ([`StatusOutput`]). Requests come through the
//! [`Gateway`]: before each event the loop takes a pressed stop, then the requests that wait, in their order.

use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_console_server::PictureSlot;
use barrelman_console_server::operator::{Answers, Gateway};
use barrelman_console_server::snapshot::{Alarm, Publisher, RecordingState};
use barrelman_pilot::{Input, Notice, Outcome, Pilot, VesselMode};
use barrelman_vocab::{
    Angle, Named as _, Note, OperatorRequest, PictureSize, StopCause, Timestamp, VehicleProfile,
    VehicleRates, VesselOrder, VideoNumber, Videos,
};

use super::connections::Connections;
use super::event::{Event, EventSource};
use super::status_line::{StatusLine, StatusOutput};
use super::tracked_video::{LatestFrame, TrackedVideo};
use crate::config::lens::misfit;
use crate::link::VehicleLink;
use crate::link::vessel_link::VesselLink;
use crate::simulated_source::WorldSwitch;

mod link_reports;
mod requests;

/// The alarms that are also logged: a run without a page must tell them, too.
const UNASKED: [Alarm; 2] = [Alarm::CameraTurns, Alarm::BoatMoves];
/// Longest wait for an event: bounds the delay of the status line.
const MAX_WAIT: Duration = Duration::from_millis(200);

/// One step of the pilot in a live run. The time of the step is `outcome.at`.
#[derive(Debug, Clone, Copy)]
pub struct LiveStep<'a> {
    /// Number of the step, from 0.
    pub index: u64,
    /// The video that a frame belongs to.
    pub video: VideoNumber,
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

    /// Somebody marked the moment. Must not block.
    fn on_note(&mut self, _at: Timestamp, _note: &Note) {}
}

/// Passes the frames of the tracked video on to the pages.
impl LiveStepObserver for Videos<Arc<PictureSlot>> {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        if let (Input::Frame(frame), Some(pictures)) = (step.input, self.get(step.video)) {
            pictures.put(frame, step.outcome, step.rates);
        }
    }
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
    /// Where requests come from.
    pub gateway: Arc<Gateway>,
    /// Where the state after each step goes.
    pub publisher: Publisher,
    /// The slot of the newest frame of the tracked video.
    pub latest: Arc<LatestFrame>,
    /// Which video is the tracked one.
    pub tracked: TrackedVideo,
    /// Horizontal field of view of the second video, where it has one of its own.
    pub second_field_of_view: Option<Angle>,
    /// The link; `None`: a dry run.
    pub link: Option<&'a dyn VehicleLink>,
    /// The link to the boat; `None`: no boat is commanded.
    pub boat: Option<&'a dyn VesselLink>,
    /// What begins another simulated world; `None`: the world is not simulated.
    pub worlds: Option<WorldSwitch>,
    /// The recording, if there is one.
    pub recorder: Option<Box<dyn LiveStepObserver + 'a>>,
    /// The status line.
    pub status: StatusLine,
    /// Where the status line is shown.
    pub status_output: Box<dyn StatusOutput + 'a>,
    /// Whether a refused selection ends the run: where a selection can be made at the start only.
    pub ends_on_refused_selection: bool,
    /// Further observers: the annotated video, the pictures of the console.
    pub observers: Vec<Box<dyn LiveStepObserver + 'a>>,
}

/// The state of the loop between events.
#[derive(Default)]
pub(super) struct LoopState {
    /// The pilot's deadline.
    wake_at: Option<Timestamp>,
    /// Whether the operator knows that the link to the boat is lost.
    is_vessel_loss_told: bool,
    /// The mode of the boat after the last step.
    vessel_mode: Option<VesselMode>,
    /// Why the selection of the last step was refused.
    refusal: Option<String>,
    answers: Answers,
    pub(super) connections: Videos<Connections>,
    /// Size of the newest picture.
    picture: Option<PictureSize>,
}

/// An end of the run, with the cause for the pilot's stop.
pub(super) type Ending = (StopCause, RunEnd);

pub(super) fn failed(reason: impl Into<String>) -> Ending {
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

    /// Takes what the operator requested; then waits for the next event or the pilot's deadline, whichever is
    /// first, and handles it.
    fn wait_and_handle(&mut self, state: &mut LoopState) -> Option<Ending> {
        let now = self.events.now();
        if let Some(gap) = self.events.suspension() {
            self.on_suspension(state, gap);
        }
        self.take_requests(state);
        if let Some(line) = self.status.next_line(self.publisher.newest(), now) {
            self.status_output.show(line);
        }
        let wait = state.wake_at.map_or(MAX_WAIT, |at| at.since(now).min(MAX_WAIT));
        match self.events.next_event(wait) {
            Ok(event) => {
                // A stop that was pressed during the wait comes before the event.
                self.take_stop(state);
                if let Some(gap) = self.events.suspension() {
                    self.on_suspension(state, gap);
                }
                self.handle(state, event)
            }
            Err(RecvTimeoutError::Timeout) => {
                let now = self.events.now();
                if state.wake_at.is_some_and(|at| at <= now) {
                    self.step(state, Input::Tick);
                } else {
                    self.publisher.on_idle_turn(now);
                }
                None
            }
            Err(RecvTimeoutError::Disconnected) => Some(failed("every source has gone")),
        }
    }

    /// Takes a pressed stop. The requests that were made before it are superseded. A stop that would change
    /// nothing is acknowledged without a step, and so without a record: anyone who may only watch could fill
    /// the disk with stops.
    fn take_stop(&mut self, state: &mut LoopState) {
        let Some(press) = self.gateway.stop_latch().pending() else { return };
        self.gateway.refuse_waiting();
        self.publisher.set_stops_taken(press);
        if self.pilot.is_at_rest_by_stop() {
            self.publisher.on_idle_turn(self.events.now());
        } else {
            self.step(state, Input::Request(OperatorRequest::Stop(StopCause::Operator)));
        }
        self.gateway.stop_latch().acknowledge(press);
    }

    /// Handles an event. Returns the end of the run if the event ends it.
    fn handle(&mut self, state: &mut LoopState, event: Event) -> Option<Ending> {
        match event {
            Event::Frame => return self.on_frame(state),
            // The requests are taken before the next event.
            Event::Operator => {}
            Event::Link(report) => return self.on_link_report(state, report),
            Event::Vessel(report) => return self.on_vessel_report(state, report),
            Event::Detections(detections) => {
                self.step(state, Input::Detections(&detections));
            }
            Event::Video(number, video) => return self.on_video_state(state, number, video),
            Event::VideoTiming(number, timing) => {
                self.publisher.set_video_timing(number, timing, self.events.now());
            }
            Event::Quit(cause) => return Some((StopCause::Ending, RunEnd::Requested(cause.to_string()))),
            Event::ThreadPanicked { thread } => return Some(failed(format!("the {thread} thread panicked"))),
            Event::RecordingFailed { reason } => {
                tracing::error!(
                    "{}: {reason}; the run goes on without a recording",
                    Alarm::RecordingFailed.text()
                );
                self.publisher.set_recording(RecordingState::Failed(reason), self.events.now());
                self.recorder = None;
            }
        }
        None
    }

    fn on_frame(&mut self, state: &mut LoopState) -> Option<Ending> {
        let (number, frame) = self.latest.take()?;
        if number != self.tracked.number() {
            return None;
        }
        self.publisher.set_dropped(self.latest.replaced());
        if let Some(ending) = self.check_lens(state, frame.picture.size()) {
            return Some(ending);
        }
        self.step(state, Input::Frame(&frame));
        state.refusal.take().filter(|_| self.ends_on_refused_selection).map(failed)
    }

    /// The lens does not fit pictures of another aspect ratio: that ends the run at the first picture, and is
    /// told at a later one.
    fn check_lens(&self, state: &mut LoopState, picture: PictureSize) -> Option<Ending> {
        let before = state.picture.replace(picture);
        if before == Some(picture) {
            return None;
        }
        let misfit = misfit(self.profile.camera.lens.as_ref()?, picture)?;
        if before.is_none() {
            return Some(failed(misfit));
        }
        tracing::error!("{misfit}; until then, points on the water are computed without the lens");
        None
    }

    /// The machine was suspended, or the loop was away: what arrived before says nothing about now, although
    /// its age seems small.
    fn on_suspension(&mut self, state: &mut LoopState, gap: Duration) {
        tracing::error!(
            "the program did not run for {:.1} s (it was stopped or held up, or the machine was suspended): camera and boat \
             are stopped until the operator engages",
            gap.as_secs_f64()
        );
        drop(self.latest.take());
        self.step(state, Input::Request(OperatorRequest::Stop(StopCause::Suspended)));
    }

    /// Steps the pilot, sends the rates, and informs the observers, in this order.
    pub(super) fn step(&mut self, state: &mut LoopState, input: Input<'_>) -> Outcome {
        let begun = self.events.now();
        let outcome = self.pilot.step(input, begun);
        // The vehicle boundary: the only place of a live run that applies the vehicle's own signs.
        let rates = self.profile.to_vehicle(outcome.command);
        if let Some(link) = self.link {
            link.send(rates, outcome.wake_at);
        }
        if let Some(boat) = self.boat {
            let order = match outcome.vessel.is_commanded() {
                true => VesselOrder::Commanded(outcome.vessel.command),
                false => VesselOrder::Released,
            };
            boat.send(order, outcome.vessel.renew_by);
        }
        if matches!(input, Input::Frame(_)) {
            self.publisher.add_step_time(self.events.now().since(begun));
        }
        let step = LiveStep {
            index: self.publisher.newest().steps,
            video: self.tracked.number(),
            input,
            outcome: &outcome,
            rates,
        };
        if let Some(recorder) = &mut self.recorder {
            recorder.on_step(&step);
        }
        if let Some(notice) = &outcome.notice {
            self.log(notice);
        }
        for observer in &mut self.observers {
            observer.on_step(&step);
        }
        if !matches!(input, Input::Request(_)) {
            state.answers.on_step(&outcome);
        }
        state.refusal = match &outcome.notice {
            Some(notice @ Notice::SelectionRefused(_)) => Some(notice.to_string()),
            _ => None,
        };
        state.wake_at = outcome.next_step_at();
        state.vessel_mode = Some(outcome.vessel.mode);
        let raised = |publisher: &Publisher| UNASKED.map(|alarm| publisher.newest().alarms.contains(&alarm));
        let before = raised(&self.publisher);
        self.publisher.on_step(&input, &outcome, rates, self.pilot.law_id());
        for ((alarm, was), is) in UNASKED.iter().zip(before).zip(raised(&self.publisher)) {
            if is && !was {
                tracing::error!("{}", alarm.text());
            }
        }
        outcome
    }

    fn log(&self, notice: &Notice) {
        match notice {
            // Reported as the end of the run.
            Notice::SelectionRefused(_) if self.ends_on_refused_selection => {}
            Notice::SelectionRefused(_)
            | Notice::SelectionUnconfirmed(_)
            | Notice::RequestRefused(_)
            | Notice::VideoClockWentBack => tracing::warn!("{notice}"),
            _ => tracing::info!("{notice}"),
        }
    }
}
