//! One drive, paced by the clock: requests of the console and the terminal, ticks when they are due, and the
//! state for the console.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::SessionTime;
use barrelman_console_server::operator::{Answer, AnswerSlot, Gateway, SessionRequest, Submitted};
use barrelman_console_server::snapshot::DriveState;
use barrelman_experiments::drill::DrillJudge;
use barrelman_experiments::drive::{Drive, DriveSetup, DriveWriter};
use barrelman_experiments::scenario;
use barrelman_host::clock::Clock;
use barrelman_pilot::VesselMode;
use barrelman_vocab::{
    CameraRequest, Note, NoteRequest, OperatorRequest, StopCause, Timestamp, VideoRequest, WorldRequest,
};

use super::drill::Drill;
use super::drive_files::{DriveFiles, OpenFiles};
use super::drive_plan::{DrivePlan, Purpose};
use super::first_selection::FirstSelection;
use super::observers::DriveObservers;
use super::pacing::Pacing;
use crate::live::event::{Event, QuitCause};

/// Interval at which requests are read while the drive is paused.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Ticks from one published state of the world to the next.
const STATE_TICKS: u64 = 4;

/// How a drive ended.
#[derive(Debug)]
pub enum DriveEnd {
    /// The operator or a signal ended it.
    Quit(QuitCause),
    /// The duration of the session is over.
    TimeIsUp,
    /// A thread failed.
    Failed(String),
}

/// What follows a drive.
pub(super) enum Next {
    /// The end of the session.
    End(DriveEnd),
    /// Another drive.
    Drive(Box<NextDrive>),
}

/// A drive that was asked for.
pub(super) struct NextDrive {
    /// Its setup.
    pub(super) setup: DriveSetup,
    /// Who judges it, if it is a drill.
    pub(super) judge: Option<DrillJudge>,
    /// Its files.
    pub(super) files: OpenFiles,
    /// Where the answer goes when it has begun.
    pub(super) answer: AnswerSlot,
}

/// A drive that is paced by the clock.
pub(super) struct LiveDrive<'a> {
    pub(super) drive: Drive<'a>,
    pub(super) observers: DriveObservers<'a>,
    /// The file that the inputs are stored in, if there is one.
    pub(super) store: Option<DriveWriter>,
    pub(super) gateway: &'a Gateway,
    pub(super) setup: &'a DriveSetup,
    /// What the drives of the session have in common.
    pub(super) plan: &'a DrivePlan,
    /// The files of the drives of the session.
    pub(super) files: &'a DriveFiles,
    /// The number of the drive, from 1.
    pub(super) number: u32,
    pub(super) clock: Clock,
    pub(super) time: SessionTime,
    pub(super) is_paused: bool,
    /// Whether the time waits for the first selection.
    pub(super) first_selection: FirstSelection,
    /// The drill, if the drive is one.
    pub(super) drill: Option<Drill>,
    /// Whether the user knows that the world is slower than real time.
    pub(super) is_slow_told: bool,
}

impl LiveDrive<'_> {
    /// Runs the drive until it ends, or until `until`.
    ///
    /// # Errors
    /// If an input cannot be stored.
    pub(super) fn run(&mut self, events: &Receiver<Event>, until: Option<Timestamp>) -> Result<Next> {
        // A new drive is a stop: the operator engages.
        if !self.setup.hands_on && (self.number == 1 || self.drill.is_some()) {
            self.request(CameraRequest::Engage.into())?;
        }
        while let Some(drill) = self.drill.as_mut().filter(|drill| !drill.has_begun()) {
            self.drive.tick(&mut self.observers);
            drill.after_tick(&self.drive, self.setup)?;
        }
        let mut pacing = Pacing::new(self.drive.world().tick(), self.clock.now());
        loop {
            if let Some(next) = self.take_requests()? {
                return Ok(Next::Drive(next));
            }
            let (tick, now) = (self.drive.world().tick(), self.clock.now());
            if until.is_some_and(|until| until <= now) {
                return Ok(Next::End(DriveEnd::TimeIsUp));
            }
            let stands_still = self.stands_still();
            let due = if stands_still { now.plus(POLL_INTERVAL) } else { pacing.due(tick, now) };
            match events.recv_timeout(due.since(now)) {
                Ok(event) => {
                    if let Some(end) = self.on_event(event) {
                        return Ok(Next::End(end));
                    }
                    continue;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    let why = "all threads have ended".to_owned();
                    return Ok(Next::End(DriveEnd::Failed(why)));
                }
            }
            if stands_still {
                self.publish_state(pacing.pace());
                pacing.resume(tick, self.clock.now());
                continue;
            }
            self.drive.tick(&mut self.observers);
            self.first_selection = self.first_selection.after_steps(&mut self.observers.first_selection);
            self.time.set(self.drive.world().now());
            if let Some(drill) = &mut self.drill {
                // Its world stands still at the end: the result is looked at.
                self.is_paused |= drill.after_tick(&self.drive, self.setup)?;
            }
            if tick.is_multiple_of(STATE_TICKS) {
                self.publish_state(pacing.pace());
                if !self.is_slow_told
                    && let Some(message) = pacing.slow_message(self.setup.url.size)
                {
                    self.is_slow_told = true;
                    tracing::warn!("{message}");
                }
            }
        }
    }

    /// Handles an event of the program's threads. Returns how the drive ends, if the event ends it.
    fn on_event(&mut self, event: Event) -> Option<DriveEnd> {
        match event {
            Event::Quit(cause) => return Some(DriveEnd::Quit(cause)),
            Event::ThreadPanicked { thread } => {
                return Some(DriveEnd::Failed(format!("the {thread} thread panicked")));
            }
            // The requests are taken before the next tick.
            Event::Operator
            | Event::Frame
            | Event::Video(..)
            | Event::VideoTiming(..)
            | Event::Detections(_)
            | Event::Link(_)
            | Event::Vessel(_)
            | Event::RecordingFailed { .. } => {}
        }
        None
    }

    /// Takes a pressed stop, and the requests that wait. Returns the drive that follows, if one was asked
    /// for.
    fn take_requests(&mut self) -> Result<Option<Box<NextDrive>>> {
        let (is_lost, now) = (self.gateway.is_console_lost(), self.drive.world().now());
        if let Some(console) = &mut self.observers.console {
            console.publisher.set_console_lost(is_lost, now);
        }
        let mode = self.drive.outcome().map_or(VesselMode::Absent, |outcome| outcome.vessel.mode);
        if let Some(request) = self.gateway.stop_for_left_vessel(mode, self.clock.now()) {
            self.request(request)?;
        }
        loop {
            self.take_stop()?;
            let Some(Submitted { request, answer }) = self.gateway.next_request() else { return Ok(None) };
            match request {
                SessionRequest::World(WorldRequest::NewDrive(wanted)) => {
                    if let Some(next) = self.next(&Purpose::Drive(wanted), answer)? {
                        return Ok(Some(next));
                    }
                }
                SessionRequest::World(WorldRequest::Drill(wanted)) => {
                    if let Some(next) = self.next(&Purpose::Drill(wanted), answer)? {
                        return Ok(Some(next));
                    }
                }
                SessionRequest::Video(VideoRequest::TrackVideo { .. }) => {
                    answer.give(Answer::Refused("a demo has one video".to_owned()));
                }
                SessionRequest::World(request @ (WorldRequest::Pause | WorldRequest::Resume)) => {
                    self.is_paused = request == WorldRequest::Pause;
                    if !self.is_paused {
                        self.first_selection = FirstSelection::Over;
                    }
                    answer.give(Answer::ACCEPTED);
                }
                SessionRequest::Note(NoteRequest::Note(note)) => answer.give(self.note_answer(note)),
                SessionRequest::Pilot(request) => {
                    // A helm that is renewed is stored each time: the pilot makes a step for it.
                    self.request(request)?;
                    if let (Some(console), Some(outcome)) =
                        (&mut self.observers.console, self.drive.outcome())
                    {
                        console.answers.on_request_step(&request, answer, outcome);
                    }
                }
            }
        }
    }

    /// Records a marked moment.
    fn note_answer(&mut self, note: Note) -> Answer {
        let now = self.drive.world().now();
        let Some(recorder) = &mut self.observers.recorder else { return Answer::not_recorded() };
        if let Some(console) = &mut self.observers.console {
            console.publisher.events().add_note(now, &note);
        }
        recorder.add_note(now, note);
        Answer::ACCEPTED
    }

    /// Stops this drive for another one; `None`: the other one is refused, and this one goes on.
    fn next(&mut self, wanted: &Purpose, answer: AnswerSlot) -> Result<Option<Box<NextDrive>>> {
        match self.prepare(wanted) {
            Ok((setup, files)) => {
                self.request(OperatorRequest::Stop(StopCause::Operator))?;
                Ok(Some(Box::new(NextDrive { setup, judge: wanted.judge(), files, answer })))
            }
            Err(error) => {
                answer.give(Answer::Refused(format!("{error:#}")));
                Ok(None)
            }
        }
    }

    /// Everything that another drive needs.
    ///
    /// # Errors
    /// The drive cannot begin: this one goes on.
    fn prepare(&self, wanted: &Purpose) -> Result<(DriveSetup, OpenFiles)> {
        if let Purpose::Drive(drive) = wanted {
            scenario::require_choice(&drive.scenario, &self.plan.choices()?)?;
        }
        Ok((self.plan.setup(wanted)?, self.files.open(self.number + 1)?))
    }

    /// Takes a pressed stop. The requests that were made before it are superseded. A stop that would change
    /// nothing is acknowledged, and neither stored nor recorded.
    fn take_stop(&mut self) -> Result<()> {
        let Some(press) = self.gateway.stop_latch().pending() else { return Ok(()) };
        self.gateway.refuse_waiting();
        let (changes_nothing, now) = (self.drive.is_at_rest_by_stop(), self.drive.world().now());
        if let Some(console) = &mut self.observers.console {
            console.publisher.set_stops_taken(press);
            if changes_nothing {
                console.publisher.on_idle_turn(now);
            }
        }
        if !changes_nothing {
            self.request(OperatorRequest::Stop(StopCause::Operator))?;
        }
        self.gateway.stop_latch().acknowledge(press);
        Ok(())
    }

    /// Passes a request to the pilot before the next tick, and stores it.
    fn request(&mut self, request: OperatorRequest) -> Result<()> {
        if let Some(store) = &mut self.store {
            store.add(self.drive.world().tick(), request)?;
        }
        if let Some(drill) = &mut self.drill {
            drill.on_request(&request);
        }
        self.drive.request(request, &mut self.observers);
        self.first_selection = self.first_selection.after_request(&request, &self.observers.first_selection);
        self.first_selection = self.first_selection.after_steps(&mut self.observers.first_selection);
        let (law, now) = (self.drive.law_id(), self.drive.world().now());
        if let Some(console) = &mut self.observers.console {
            console.law = law;
            console.publisher.set_law(law, now);
        }
        Ok(())
    }

    /// Whether the time of the world stands still.
    fn stands_still(&self) -> bool {
        self.is_paused || self.first_selection.waits(&self.observers.first_selection)
    }

    fn publish_state(&mut self, pace: f64) {
        let (state, now) = (self.state(pace), self.drive.world().now());
        let camera = self.drive.world().camera_pose();
        if let Some(console) = &mut self.observers.console {
            console.publisher.set_camera(camera.tilt, camera.position.z);
            // In a drill, the person finds the boat.
            let boat = self.observers.first_selection.boat().filter(|_| self.drill.is_none());
            console.publisher.set_boat(boat);
            console.publisher.set_drill(self.drill.as_ref().map(Drill::state));
            console.publisher.set_drive(state, now);
        }
    }

    fn state(&self, pace: f64) -> DriveState {
        let (world, helm) = (self.drive.world(), self.drive.helm());
        let (pan, tilt) = world.camera_rates();
        DriveState {
            tick: world.tick(),
            time_s: world.now().as_secs_f64(),
            paused: self.stands_still(),
            waits: !self.is_paused && self.stands_still(),
            pace,
            achieved: [pan, tilt],
            speed_m_per_s: world.target_speed_m_per_s(),
            helm: match helm {
                _ if !world.is_steerable() => "nobody",
                Some(_) => "page",
                None => "helmsman",
            },
            in_picture: self.observers.is_in_picture,
        }
    }

    /// Publishes the last state and completes the recording and the stored drive.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(super) fn finish(mut self) -> Result<()> {
        self.publish_state(1.0);
        let (tick, hash) = (self.drive.world().tick(), self.observers.hash.hex());
        if let Some(recorder) = self.observers.recorder {
            recorder.finish()?;
        }
        self.store.map_or(Ok(()), |store| store.finish(tick, hash))
    }
}
