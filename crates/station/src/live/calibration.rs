//! The calibration of a live run: asks the pilot for the test motions once video and link are there, records
//! what they do to the picture, and ends the run.

use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use barrelman_console_server::operator::Gateway;
use barrelman_experiments::calibration::CalibrationRecorder;
use barrelman_pilot::{Input, Mode, Notice};
use barrelman_vocab::{CameraRequest, OperatorRequest, TestMotions, Timestamp};

use super::event::{Event, QuitCause};
use super::run_loop::{LiveStep, LiveStepObserver};

/// The pilot is asked again after this time while it refuses: the link may still be opening.
const ASK_INTERVAL: Duration = Duration::from_secs(1);
/// The run ends without test motions after this time.
const GIVES_UP_AFTER: Duration = Duration::from_secs(20);

/// What the run records, shared with its caller.
#[derive(Clone)]
pub struct LiveCalibration {
    state: Arc<Mutex<State>>,
}

struct State {
    motions: TestMotions,
    recorder: CalibrationRecorder,
    first_frame_at: Option<Timestamp>,
    asked_at: Option<Timestamp>,
    has_begun: bool,
    has_ended: bool,
    is_complete: bool,
}

impl LiveCalibration {
    /// A calibration by these motions of a camera of this focal length, as a share of the picture's width.
    pub fn new(motions: TestMotions, focal_share: f64) -> Self {
        let state = State {
            motions,
            recorder: CalibrationRecorder::new(focal_share),
            first_frame_at: None,
            asked_at: None,
            has_begun: false,
            has_ended: false,
            is_complete: false,
        };
        Self { state: Arc::new(Mutex::new(state)) }
    }

    /// Whether all test motions were made.
    pub fn is_complete(&self) -> bool {
        self.state().is_complete
    }

    /// What was recorded.
    pub fn with_recorder<T>(&self, read: impl FnOnce(&CalibrationRecorder) -> T) -> T {
        read(&self.state().recorder)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Plain data, whole at any time.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The observer of the run's steps.
    pub(super) fn observer(&self, gateway: Arc<Gateway>, events: SyncSender<Event>) -> impl LiveStepObserver {
        CalibrationObserver { calibration: self.clone(), gateway, events }
    }
}

struct CalibrationObserver {
    calibration: LiveCalibration,
    gateway: Arc<Gateway>,
    events: SyncSender<Event>,
}

impl LiveStepObserver for CalibrationObserver {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        let mut state = self.calibration.state();
        let (now, is_calibrating) = (step.outcome.at, step.outcome.mode == Mode::Calibrating);
        if let Input::Frame(frame) = step.input {
            state.first_frame_at.get_or_insert(now);
            if state.has_begun {
                state.recorder.on_frame(frame);
            }
        }
        if let Input::Telemetry(telemetry) = &step.input {
            state.recorder.on_telemetry(telemetry);
        }
        state.recorder.on_command(step.outcome.command, now);
        state.has_begun |= is_calibrating;
        let first = state.first_frame_at;
        let waits_too_long =
            !state.has_begun && first.is_some_and(|first| now.since(first) >= GIVES_UP_AFTER);
        if !state.has_ended && ((state.has_begun && !is_calibrating) || waits_too_long) {
            state.has_ended = true;
            // The notice comes once, and the end is reported until there is room.
            state.is_complete |= step.outcome.notice == Some(Notice::TestMotionsMade);
            // A full queue means that the run ends for another reason, or asks again at the next step.
            state.has_ended = self.events.try_send(Event::Quit(QuitCause::CalibrationEnded)).is_ok();
        } else if !state.has_begun && first.is_some() {
            let is_due = state.asked_at.is_none_or(|asked| now.since(asked) >= ASK_INTERVAL);
            if is_due {
                state.asked_at = Some(now);
                let request = CameraRequest::Calibrate { motions: state.motions };
                self.gateway.submit_logged(OperatorRequest::Camera(request));
            }
        }
    }
}
