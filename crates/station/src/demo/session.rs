//! A session of the demo: one drive after the other, with the console, the terminal and the threads that they
//! need.

use std::io::{Write as _, stdout};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::operator::{Answer, AnswerSlot, Answers, Gateway};
use barrelman_console_server::snapshot::{
    LinkStatus, Publisher, RecordingState, VideoSourceState, WorldState,
};
use barrelman_console_server::{
    ConsoleParts, ConsoleServer, ConsoleSettings, LeftMoving, SessionFacts, SessionTime, VideoOutlet,
};
use barrelman_experiments::drill::DrillJudge;
use barrelman_experiments::drive::{Drive, DriveSetup, DriveWriter};
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_host::clock::Clock;

use super::drill::Drill;
use super::drive_files::{DriveFiles, OpenFiles};
use super::drive_plan::DrivePlan;
use super::first_selection::FirstSelection;
use super::live_drive::{DriveEnd, LiveDrive, Next, NextDrive};
use super::observers::{ConsoleObserver, DriveObservers};
use super::recording;
use crate::config::RecordingConfig;
use crate::live::event::{Event, report_panics, wake_by};
use crate::live::faults::FaultInjector;
use crate::live::recording_folder::library;
use crate::live::terminal::Terminal;
use crate::share::{ShareSetup, ShareThread};
use barrelman_vocab::{Timestamp, VideoNumber, Videos};

/// Capacity of the queue of events.
const EVENTS: usize = 64;

/// What a session needs.
pub struct DriveSession {
    /// What the drives have in common.
    pub plan: DrivePlan,
    /// The names of the files of the drives.
    pub files: DriveFiles,
    /// The open files of the first drive.
    pub first_files: OpenFiles,
    /// The console.
    pub console: ConsoleSettings,
    /// Where the annotated video is served; `None`: nowhere.
    pub share: Option<ShareSetup>,
    /// How long the session lasts at most.
    pub max_duration: Option<Duration>,
    /// The program's clock.
    pub clock: Clock,
}

/// How a session ended.
#[derive(Debug)]
pub struct SessionEnd {
    /// The end of the last drive.
    pub end: DriveEnd,
    /// How many drives there were.
    pub drives: u32,
}

impl DriveSession {
    /// Runs drives until the session is ended. Only a request begins a new drive.
    ///
    /// # Errors
    /// If the world, a thread or the console cannot be started, or a file cannot be written.
    pub fn run(self) -> Result<SessionEnd> {
        let Self { plan, files, first_files, console, share, max_duration, clock } = self;
        let (setup, judge) = (plan.setup(&plan.first)?, plan.first.judge());
        let threads = RenderThreads::new()?;
        let (events, queue) = sync_channel(EVENTS);
        let gateway = Arc::new(Gateway::new(wake_by(events.clone())));
        let terminal =
            Terminal::watch(Arc::clone(&gateway), events.clone(), clock, FaultInjector::default())?;
        let time = SessionTime::new(clock);
        let start_share = |setup| ShareThread::start(setup, clock, time.clone(), events.clone());
        let share = share.map(start_share).transpose()?;
        let recording = recording_state(&first_files);
        let publisher = Publisher::new(&setup.profile, LinkStatus::Simulated, recording);
        let mut drives = Drives {
            plan: &plan,
            files: &files,
            gateway: &gateway,
            threads: &threads,
            clock,
            time,
            outlet: VideoOutlet::new(VideoNumber::First),
            share: share.as_ref(),
            publisher,
        };
        let parts = ConsoleParts {
            facts: SessionFacts {
                command: "demo",
                source: setup.url.to_string(),
                second_source: None,
                link: Some("the simulated camera".to_owned()),
                vehicle: setup.profile.name.clone(),
                scenarios: plan.choices()?,
            },
            gateway: Arc::clone(&gateway),
            snapshots: drives.publisher.subscribe(),
            events: drives.publisher.events(),
            videos: Videos::one(drives.outlet.clone()),
            time: drives.time.clone(),
            library: library(&RecordingConfig::default()),
        };
        let server = ConsoleServer::open(console, parts, report_panics(events))?;
        print_keys(&setup)?;

        let until = max_duration.map(|duration| clock.now().plus(duration));
        let end = drives.run((setup, judge), first_files, &queue, until);
        server.end(LeftMoving::default());
        drop(terminal);
        end
    }
}

/// What the drives of a session share.
struct Drives<'a> {
    plan: &'a DrivePlan,
    files: &'a DriveFiles,
    gateway: &'a Gateway,
    threads: &'a RenderThreads,
    clock: Clock,
    time: SessionTime,
    outlet: VideoOutlet,
    share: Option<&'a ShareThread>,
    publisher: Publisher,
}

impl Drives<'_> {
    /// Runs one drive after the other until the session is ended.
    fn run(
        &mut self,
        (mut setup, mut judge): (DriveSetup, Option<DrillJudge>),
        first_files: OpenFiles,
        queue: &Receiver<Event>,
        until: Option<Timestamp>,
    ) -> Result<SessionEnd> {
        let (mut number, mut open, mut answer) = (1, first_files, None::<AnswerSlot>);
        let end = loop {
            let drive = Drive::new(&setup, self.threads)?;
            let drive = if judge.is_some() { drive.with_log() } else { drive };
            let now = drive.world().now();
            self.time.set(now);
            self.publisher.set_recording(recording_state(&open), now);
            self.publish_begin(&setup, answer.take(), now);
            let console = ConsoleObserver {
                publisher: &mut self.publisher,
                pictures: &self.outlet.pictures,
                relay: &self.outlet.relay,
                answers: Answers::default(),
                law: drive.law_id(),
            };
            let mut live = LiveDrive {
                drive,
                observers: DriveObservers {
                    recorder: recording::begin(open.record, &setup)?,
                    console: Some(console),
                    share: self.share.map(ShareThread::input),
                    ..DriveObservers::default()
                },
                store: open.store.map(|file| DriveWriter::begin(file, &setup)).transpose()?,
                gateway: self.gateway,
                setup: &setup,
                plan: self.plan,
                files: self.files,
                number,
                clock: self.clock,
                time: self.time.clone(),
                is_paused: false,
                first_selection: first_selection(&setup, judge.is_some()),
                drill: judge.take().map(Drill::new),
                is_slow_told: false,
            };
            let next = live.run(queue, until)?;
            live.finish()?;
            match next {
                Next::End(end) => break end,
                Next::Drive(next) => {
                    let NextDrive { setup: next_setup, judge: next_judge, files, answer: slot } = *next;
                    (setup, judge, open, answer) = (next_setup, next_judge, files, Some(slot));
                    number += 1;
                    tracing::info!("new drive: {}", setup.url);
                }
            }
        };
        Ok(SessionEnd { end, drives: number })
    }

    /// Publishes that a drive begins, and answers the request for it. Nobody requested the first drive.
    fn publish_begin(&mut self, setup: &DriveSetup, answer: Option<AnswerSlot>, now: Timestamp) {
        self.publisher.begin_drive(&setup.profile, now);
        self.publisher.set_video(VideoNumber::First, VideoSourceState::Up, now);
        let world = WorldState { scenario: setup.url.scenario.clone(), seed: setup.url.seed, boat: None };
        match answer {
            None => self.publisher.set_world(world, now),
            Some(answer) => {
                // They were made for the world before.
                self.gateway.refuse_waiting();
                self.publisher.begin_world(world, now);
                answer.give(Answer::ACCEPTED);
            }
        }
    }
}

/// The selection with which a drive begins. The time of a drill goes on.
fn first_selection(setup: &DriveSetup, is_drill: bool) -> FirstSelection {
    if is_drill { FirstSelection::Over } else { FirstSelection::of(setup) }
}

/// The state of the recording of a drive with these files.
fn recording_state(files: &OpenFiles) -> RecordingState {
    let recording = files.record.as_ref().map(|file| file.path().display().to_string());
    recording.map_or(RecordingState::Off, RecordingState::On)
}

/// Prints what the keys do.
fn print_keys(setup: &DriveSetup) -> Result<()> {
    let mut out = stdout();
    let begin = if setup.hands_on {
        "the world waits until a box is drawn around the boat; then engage; "
    } else {
        ""
    };
    writeln!(
        out,
        "{begin}arrow keys steer the boat, space stops camera and boat, e engages the camera; Ctrl-C quits"
    )?;
    Ok(out.flush()?)
}
