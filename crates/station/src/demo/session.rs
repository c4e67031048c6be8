//! A session of the demo: one drive after the other, with the console, the terminal and the threads that they need.

use std::io::{Write as _, stdout};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::operator::{Answers, Gateway};
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState, VideoSourceState};
use barrelman_console_server::{
    ConsoleParts, ConsoleServer, ConsoleSettings, PictureSlot, SessionFacts, SessionTime, VideoRelay,
};
use barrelman_experiments::drive::{Drive, DriveSetup, DriveWriter};
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;

use super::live_drive::{DriveEnd, LiveDrive};
use super::observers::{ConsoleObserver, DriveObservers};
use super::recording;
use crate::config::RecordingConfig;
use crate::live::event::{report_panics, wake_by};
use crate::live::faults::FaultInjector;
use crate::live::recording_folder::library;
use crate::live::terminal::Terminal;

/// Capacity of the queue of events.
const EVENTS: usize = 64;

/// What a session needs.
pub struct DriveSession {
    /// The first drive. Each further drive has the next seed.
    pub setup: DriveSetup,
    /// The console.
    pub console: ConsoleSettings,
    /// The recording. A session that is recorded or stored has one drive.
    pub record: Option<OutputFile>,
    /// The stored drive.
    pub store: Option<OutputFile>,
    /// How long the session lasts at most.
    pub max_duration: Option<Duration>,
    /// The program's clock.
    pub clock: Clock,
}

impl DriveSession {
    /// Runs drives until the session is ended.
    ///
    /// # Errors
    /// If the world, a thread or the console cannot be started, or a file cannot be written.
    pub fn run(self) -> Result<DriveEnd> {
        let Self { setup, console, mut record, mut store, max_duration, clock } = self;
        let recording = record.as_ref().map(|file| file.path().display().to_string());
        let recording = recording.map_or(RecordingState::Off, RecordingState::On);
        let threads = RenderThreads::new()?;
        let (events, queue) = sync_channel(EVENTS);
        let gateway = Arc::new(Gateway::new(wake_by(events.clone())));
        let terminal =
            Terminal::watch(Arc::clone(&gateway), events.clone(), clock, FaultInjector::default())?;
        let mut publisher = Publisher::new(&setup.profile, LinkStatus::Simulated, recording);
        let (relay, pictures) = (Arc::new(VideoRelay::default()), Arc::new(PictureSlot::default()));
        let time = SessionTime::new(clock);
        let parts = ConsoleParts {
            facts: SessionFacts {
                command: "demo",
                source: setup.url.to_string(),
                link: Some("the simulated camera".to_owned()),
                vehicle: setup.profile.name.clone(),
            },
            gateway: Arc::clone(&gateway),
            snapshots: publisher.subscribe(),
            events: publisher.events(),
            relay: Arc::clone(&relay),
            pictures: Arc::clone(&pictures),
            time: time.clone(),
            library: library(&RecordingConfig::default()),
        };
        let server = ConsoleServer::open(console, parts, report_panics(events))?;
        print_keys(&setup)?;

        let until = max_duration.map(|duration| clock.now().plus(duration));
        let end = {
            let drive = Drive::new(&setup, &threads)?;
            publisher.begin_drive(drive.world().now());
            publisher.set_video(VideoSourceState::Up, drive.world().now());
            let console = ConsoleObserver {
                publisher: &mut publisher,
                pictures: &pictures,
                relay: &relay,
                answers: Answers::default(),
                law: drive.law_id(),
            };
            let mut live = LiveDrive {
                drive,
                observers: DriveObservers {
                    recorder: recording::begin(record.take(), &setup)?,
                    console: Some(console),
                    ..DriveObservers::default()
                },
                store: store.take().map(|file| DriveWriter::begin(file, &setup)).transpose()?,
                gateway: &gateway,
                setup: &setup,
                clock,
                time: time.clone(),
                is_paused: false,
                is_slow_told: false,
            };
            let end = live.run(&queue, until)?;
            live.finish()?;
            end
        };
        drop(server);
        drop(terminal);
        Ok(end)
    }
}

/// Prints what the keys do.
fn print_keys(setup: &DriveSetup) -> Result<()> {
    let mut out = stdout();
    let begin = if setup.hands_on { "draw a box around the boat, then engage; " } else { "" };
    writeln!(
        out,
        "{begin}arrow keys steer the boat, space stops camera and boat, e engages the camera; Ctrl-C quits"
    )?;
    Ok(out.flush()?)
}
