//! One drive, paced by the clock: inputs of the page and the terminal, ticks when they are due, and the status for the
//! page.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use anyhow::Result;
use barrelman_experiments::drive::motor_schema_shadow::MotorSchemaShadow;
use barrelman_experiments::drive::{Drive, DriveInput, DriveSetup, DriveWriter};
use barrelman_host::clock::Clock;
use barrelman_pilot::Mode;
use barrelman_vocab::{OperatorRequest, Timestamp, Track, VehicleRates};

use super::observers::DriveObservers;
use super::pacing::Pacing;
use super::page::{DriveStatus, PageState};
use super::page_helm::PageHelm;
use crate::live::event::{Event, QuitCause};

/// Interval at which inputs are read while the drive is paused.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Ticks from one status of the page to the next.
const STATUS_TICKS: u64 = 4;

/// How a drive ended.
#[derive(Debug)]
pub enum DriveEnd {
    /// The operator or a signal ended it.
    Quit(QuitCause),
    /// The duration of the session is over.
    TimeIsUp,
    /// The scenario is over.
    Over,
    /// A thread failed.
    Failed(String),
}

/// A drive that is paced by the clock.
pub(super) struct LiveDrive<'a> {
    pub(super) drive: Drive<'a>,
    pub(super) observers: DriveObservers<'a>,
    /// The file that the inputs are stored in, if there is one.
    pub(super) store: Option<DriveWriter>,
    pub(super) page: &'a PageState,
    pub(super) setup: &'a DriveSetup,
    pub(super) clock: Clock,
    pub(super) helm: PageHelm,
    pub(super) is_paused: bool,
}

impl LiveDrive<'_> {
    /// Runs the drive until it ends, or until `until`.
    ///
    /// # Errors
    /// If an input cannot be stored.
    pub(super) fn run(
        &mut self,
        events: &Receiver<Event>,
        inputs: &Receiver<DriveInput>,
        until: Option<Timestamp>,
    ) -> Result<DriveEnd> {
        self.apply(DriveInput::Engage)?;
        let mut pacing = Pacing::new(0, self.clock.now());
        loop {
            let (tick, now) = (self.drive.world().tick(), self.clock.now());
            if until.is_some_and(|until| until <= now) {
                return Ok(DriveEnd::TimeIsUp);
            }
            if self.drive.is_over() {
                return Ok(DriveEnd::Over);
            }
            let due = if self.is_paused { now.plus(POLL_INTERVAL) } else { pacing.due(tick, now) };
            match events.recv_timeout(due.since(now)) {
                Ok(event) => {
                    if let Some(end) = self.on_event(event)? {
                        return Ok(end);
                    }
                    continue;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Ok(DriveEnd::Failed("all threads have ended".to_owned()));
                }
            }
            let was_paused = self.is_paused;
            for input in inputs.try_iter() {
                self.on_page_input(input)?;
            }
            if let Some(neutral) = self.helm.expire(self.clock.now()) {
                self.apply(neutral)?;
            }
            if self.is_paused {
                self.publish_status(pacing.pace(), false);
                continue;
            }
            if was_paused {
                pacing.resume(tick, self.clock.now());
            }
            self.drive.tick(&mut self.observers);
            if tick.is_multiple_of(STATUS_TICKS) {
                self.publish_status(pacing.pace(), false);
            }
        }
    }

    /// Handles an event of the program's threads. Returns how the drive ends, if the event ends it.
    fn on_event(&mut self, event: Event) -> Result<Option<DriveEnd>> {
        match event {
            Event::Quit(cause) => return Ok(Some(DriveEnd::Quit(cause))),
            Event::ThreadPanicked { thread } => {
                return Ok(Some(DriveEnd::Failed(format!("the {thread} thread panicked"))));
            }
            Event::Request(OperatorRequest::Engage) => self.apply(DriveInput::Engage)?,
            Event::Request(OperatorRequest::Stop(_) | OperatorRequest::Disengage) => {
                self.apply(DriveInput::Stop)?;
            }
            Event::Request(OperatorRequest::Select(_))
            | Event::Frame
            | Event::Video(_)
            | Event::Link(_)
            | Event::RecordingFailed { .. } => {}
        }
        Ok(None)
    }

    /// Handles an input of the page. A helm that is already in force is only renewed, not stored again.
    fn on_page_input(&mut self, input: DriveInput) -> Result<()> {
        match input {
            DriveInput::Helm { .. } => {
                if !self.helm.set(input, self.clock.now()) {
                    return Ok(());
                }
            }
            DriveInput::Helmsman => self.helm.release(),
            DriveInput::Pause => self.is_paused = true,
            DriveInput::Resume => self.is_paused = false,
            DriveInput::Engage | DriveInput::Stop => {}
        }
        self.apply(input)
    }

    /// Applies an input before the next tick, and stores it.
    fn apply(&mut self, input: DriveInput) -> Result<()> {
        if let Some(store) = &mut self.store {
            store.add(self.drive.world().tick(), input)?;
        }
        self.drive.put(input, &mut self.observers);
        Ok(())
    }

    fn publish_status(&self, pace: f64, over: bool) {
        self.page.set_status(&self.status(pace, over));
    }

    fn status(&self, pace: f64, over: bool) -> DriveStatus {
        let world = self.drive.world();
        let (outcome, rates) = match &self.observers.newest {
            Some((outcome, rates)) => (Some(outcome), *rates),
            None => (None, VehicleRates::REST),
        };
        let track = outcome.map_or(Track::Unseeded, |outcome| outcome.track);
        let (track, confidence) = match track {
            Track::Unseeded => ("unseeded", None),
            Track::Tracking(seen) => ("tracking", Some(seen.confidence)),
            Track::Coasting(seen) => ("coasting", Some(seen.confidence)),
            Track::Lost { confidence, .. } => ("lost", Some(confidence)),
        };
        let helm = self.drive.helm();
        let command = outcome.map(|outcome| outcome.command).unwrap_or_default();
        DriveStatus {
            scenario: self.setup.url.scenario.clone(),
            seed: self.setup.url.seed,
            tick: world.tick(),
            time_s: world.now().as_secs_f64(),
            paused: self.is_paused,
            pace,
            law: self.setup.law.word(),
            mode: outcome.map_or_else(String::new, |outcome| outcome.mode.to_string()),
            engaged: outcome.is_some_and(|outcome| matches!(outcome.mode, Mode::Servoing | Mode::Holding(_))),
            track,
            confidence,
            p: outcome.and_then(|outcome| outcome.percept).map(|percept| percept.p),
            schema_p: self.observers.shadow.as_ref().and_then(MotorSchemaShadow::p),
            pan: command.pan.radians_per_second(),
            tilt: command.tilt.radians_per_second(),
            yaw_rate: rates.yaw.radians_per_second(),
            pitch_rate: rates.pitch.radians_per_second(),
            achieved: world.camera_rates(),
            speed_m_per_s: world.target_speed_m_per_s(),
            helm: match helm {
                _ if !world.can_be_steered() => "nobody",
                Some(_) => "page",
                None => "helmsman",
            },
            thrust: helm.map_or(0.0, |helm| helm.throttle),
            rudder: helm.map_or(0.0, |helm| helm.rudder),
            in_picture: self.observers.is_in_picture,
            over,
        }
    }

    /// Publishes the last status and completes the recording and the stored drive.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(super) fn finish(self, over: bool) -> Result<()> {
        self.publish_status(1.0, over);
        let (tick, hash) = (self.drive.world().tick(), self.observers.hash.hex());
        if let Some(recorder) = self.observers.recorder {
            recorder.finish()?;
        }
        self.store.map_or(Ok(()), |store| store.end(tick, hash))
    }
}
