//! The parts of a run: how they are opened, and in which order they are closed.

use std::io::{Write as _, stdout};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use anyhow::{Context as _, Result};
use barrelman_console_server::operator::Gateway;
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState, WorldState};
use barrelman_console_server::{
    ConsoleParts, ConsoleServer, ConsoleSettings, LeftMoving, SessionFacts, SessionTime, VideoOutlet,
};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_video::VideoHandle;
use barrelman_vocab::Videos;
use barrelman_vocab::telemetry::LinkState;

use super::event::{Event, report_panics};
use super::faults::FaultInjector;
use super::overlay_video::OverlayVideo;
use super::recorder::{Extras, Recorder};
use super::recording_folder::library;
use super::recording_start::recording_start;
use super::recording_sync::DiskSync;
use super::run_loop::RunEnd;
use super::sortie_text::SortieText;
use super::source::Source;
use super::status_line::StatusLine;
use super::status_writer::{LineStyle, StatusWriter};
use super::terminal::KEYS;
use super::tracked_video::{LatestFrame, TrackedVideo};
use super::video_sink::{LiveVideoSink, VideoReceivers};
use crate::config::Configuration;
use crate::detector::{DetectorSetup, DetectorThread};
use crate::link::vessel_link::Boat;
use crate::link::{Link, LinkUrl};
use crate::share::{ShareSetup, ShareThread};
use crate::simulated_source::{LiveWorld, WorldSwitch};
use crate::tak::{TakSetup, TakThread};
use crate::tracking_camera::{CameraParts, TrackingCameraSetup, TrackingCameraThread};

/// The files of a run, open.
#[derive(Default)]
pub struct Outputs {
    /// The recording.
    pub record: Option<OutputFile>,
    /// The annotated video.
    pub overlay: Option<OutputFile>,
    /// What not every recording has.
    pub extras: Extras,
    /// Why the recording that every run makes could not be opened.
    pub not_recorded: Option<String>,
}

/// The parts of a run that are not open yet, beside its links.
pub(super) struct PartSettings {
    /// The video sources.
    pub(super) sources: Videos<Source>,
    /// The address of the link, for the recording and the console.
    pub(super) link_url: Option<LinkUrl>,
    /// The output files.
    pub(super) outputs: Outputs,
    /// The console.
    pub(super) console: Option<ConsoleSettings>,
    /// The tracking camera on a MAVLink link.
    pub(super) tracking_camera: Option<TrackingCameraSetup>,
    /// Where events for TAK go.
    pub(super) tak: Option<TakSetup>,
    /// Where the annotated video is served.
    pub(super) share: Option<ShareSetup>,
    /// The operator's detector.
    pub(super) detector: Option<DetectorSetup>,
    /// Whether a simulated world selects its target.
    pub(super) selects_target: bool,
}

/// Opens the parts of a run: what all of them are given.
pub(super) struct PartOpener<'a> {
    pub(super) configuration: &'a Configuration,
    pub(super) clock: Clock,
    pub(super) fault_injector: &'a FaultInjector,
    pub(super) events: &'a SyncSender<Event>,
    pub(super) gateway: &'a Arc<Gateway>,
}

/// The open parts, and what connects them to the loop.
pub(super) struct OpenRun {
    pub(super) parts: OpenParts,
    pub(super) publisher: Publisher,
    pub(super) latest: Arc<LatestFrame>,
    pub(super) tracked: TrackedVideo,
    pub(super) worlds: Option<WorldSwitch>,
    /// Where the videos go for the pages; `None`: no console.
    pub(super) outlets: Option<Videos<VideoOutlet>>,
}

/// The open parts of a run that are closed explicitly.
pub(super) struct OpenParts {
    pub(super) link: Option<Link>,
    pub(super) boat: Option<Boat>,
    pub(super) recording: Option<Recording>,
    pub(super) overlay: Option<OverlayVideo>,
    pub(super) sources: Videos<VideoHandle>,
    pub(super) console: Option<ConsoleServer>,
    pub(super) tracking_camera: Option<TrackingCameraThread>,
    pub(super) tak: Option<TakThread>,
    pub(super) share: Option<ShareThread>,
    pub(super) detector: Option<DetectorThread>,
}

/// A recording and its file.
pub(super) struct Recording {
    pub(super) path: PathBuf,
    pub(super) recorder: Recorder,
}

impl PartOpener<'_> {
    /// Opens the parts.
    ///
    /// # Errors
    /// If a part cannot be opened. The parts opened before it are closed.
    pub(super) fn open(
        &self,
        (link, boat): (Option<Link>, Option<Boat>),
        settings: PartSettings,
    ) -> Result<OpenRun> {
        let PartSettings { sources, link_url, outputs, console, selects_target, .. } = settings;
        let PartSettings { tracking_camera, tak, share, detector, .. } = settings;
        let Outputs { record, overlay, extras, not_recorded } = outputs;
        let worlds = sources.first.world().map(LiveWorld::switch).transpose()?;
        let recording = recording_state(record.as_ref(), not_recorded);
        let mut publisher = self.publisher(link.is_some(), recording, worlds.as_ref());
        let facts = self.facts(&sources, link_url.as_ref(), worlds.as_ref());
        let is_recorded = record.is_some();
        let recording = match record {
            Some(file) => Some(self.begin_recording(file, extras, &sources, link_url.as_ref())?),
            None => None,
        };
        let overlay = overlay.map(|file| self.begin_overlay(file)).transpose()?;
        let latest = Arc::new(LatestFrame::default());
        let outlets = console.as_ref().map(|_| sources.as_ref().map(|number, _| VideoOutlet::new(number)));
        if sources.second.is_some() {
            publisher.add_second_video();
        }
        let tracked = TrackedVideo::default();
        let receivers = VideoReceivers {
            tracked: tracked.clone(),
            latest: Arc::clone(&latest),
            recorder: recording.as_ref().map(|recording| recording.recorder.input()),
            events: self.events.clone(),
            gateway: Arc::clone(self.gateway),
            selects_target,
        };
        let sources = sources.try_map(|number, source| {
            let outlet = outlets.as_ref().and_then(|outlets| outlets.get(number)).cloned();
            let sink = LiveVideoSink::new(number, receivers.clone(), outlet);
            source.start(self.configuration, is_recorded, self.clock, sink)
        })?;
        drop(receivers);
        let console = console
            .zip(outlets.clone())
            .map(|(settings, videos)| self.open_console(settings, videos, facts, &publisher))
            .transpose()?;
        let tracking_camera =
            tracking_camera.map(|setup| self.start_tracking_camera(setup, &publisher)).transpose()?;
        let tak = tak.map(|setup| self.start_tak(setup, &publisher)).transpose()?;
        let share = share.map(|setup| self.start_share(setup)).transpose()?;
        let detector = detector.map(|setup| self.start_detector(setup)).transpose()?;
        let parts = OpenParts {
            link,
            boat,
            recording,
            overlay,
            sources,
            console,
            tracking_camera,
            tak,
            share,
            detector,
        };
        Ok(OpenRun { parts, publisher, latest, tracked, worlds, outlets })
    }

    /// Says what the keys do, and starts the thread of the status line.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub(super) fn open_status(&self, watches_keys: bool) -> Result<(StatusLine, StatusWriter)> {
        if watches_keys {
            // The thread of the terminal notices a closed output.
            let _ = writeln!(stdout(), "keys on this terminal: {KEYS}");
        }
        let style = LineStyle::for_stdout();
        let (fault_injector, events) = (self.fault_injector.clone(), self.events.clone());
        let output = StatusWriter::start(stdout(), style, self.clock, fault_injector, events)?;
        Ok((StatusLine::new(style.interval()).naming_keys(watches_keys), output))
    }

    /// The publisher of the state, as the run begins.
    fn publisher(
        &self,
        has_link: bool,
        recording: RecordingState,
        worlds: Option<&WorldSwitch>,
    ) -> Publisher {
        let opening = LinkStatus::Link(LinkState::Opening);
        let link = if has_link { opening } else { LinkStatus::DryRun };
        let mut publisher = Publisher::new(&self.configuration.profile, link, recording);
        publisher.set_vessel_link(opening);
        if let Some(worlds) = worlds {
            let first = worlds.first();
            let world = WorldState { scenario: first.scenario.clone(), seed: first.seed, boat: None };
            publisher.set_world(world, self.clock.now());
        }
        publisher
    }

    /// What the pages say of the run.
    fn facts(
        &self,
        sources: &Videos<Source>,
        link_url: Option<&LinkUrl>,
        worlds: Option<&WorldSwitch>,
    ) -> SessionFacts {
        SessionFacts {
            command: "run",
            source: sources.first.address(),
            second_source: sources.second.as_ref().map(Source::address),
            link: link_url.map(ToString::to_string),
            vehicle: self.configuration.profile.name.clone(),
            scenarios: worlds.map(|worlds| worlds.choices().to_vec()).unwrap_or_default(),
        }
    }

    fn begin_recording(
        &self,
        file: OutputFile,
        extras: Extras,
        sources: &Videos<Source>,
        link_url: Option<&LinkUrl>,
    ) -> Result<Recording> {
        let start = recording_start(self.configuration, sources, link_url, self.clock)?;
        let path = file.path().to_owned();
        let context = format!("the recording {} cannot be written", path.display());
        let sync = file.sync()?.map(|sync| Box::new(sync) as Box<dyn DiskSync>);
        let extras = Extras { sync, ..extras };
        let recorder = Recorder::begin(
            file,
            &start,
            self.clock,
            self.fault_injector.clone(),
            self.events.clone(),
            extras,
            &self.configuration.profile,
        );
        Ok(Recording { path, recorder: recorder.context(context)? })
    }

    fn begin_overlay(&self, file: OutputFile) -> Result<OverlayVideo> {
        let region = self.configuration.profile.region;
        OverlayVideo::begin(file, region, self.clock, self.fault_injector.clone(), self.events.clone())
    }

    fn open_console(
        &self,
        settings: ConsoleSettings,
        videos: Videos<VideoOutlet>,
        facts: SessionFacts,
        publisher: &Publisher,
    ) -> Result<ConsoleServer> {
        let parts = ConsoleParts {
            facts,
            gateway: Arc::clone(self.gateway),
            snapshots: publisher.subscribe(),
            events: publisher.events(),
            videos,
            time: SessionTime::new(self.clock),
            library: library(&self.configuration.recording),
        };
        ConsoleServer::open(settings, parts, report_panics(self.events.clone()))
    }

    fn start_tracking_camera(
        &self,
        setup: TrackingCameraSetup,
        publisher: &Publisher,
    ) -> std::io::Result<TrackingCameraThread> {
        let gateway = Arc::clone(self.gateway);
        let parts = CameraParts { gateway, snapshots: publisher.subscribe(), clock: self.clock };
        TrackingCameraThread::start(setup, parts, self.events.clone())
    }

    fn start_tak(&self, setup: TakSetup, publisher: &Publisher) -> Result<TakThread> {
        let context = format!("--tak {}", setup.address);
        TakThread::start(setup, publisher.subscribe(), self.clock, self.events.clone()).context(context)
    }

    fn start_share(&self, setup: ShareSetup) -> Result<ShareThread> {
        let time = SessionTime::new(self.clock);
        ShareThread::start(setup, self.clock, time, self.events.clone()).context("--share")
    }

    fn start_detector(&self, setup: DetectorSetup) -> Result<DetectorThread> {
        DetectorThread::start(setup, self.clock, self.events.clone()).context("--detector")
    }
}

/// The state of the recording as the run begins.
fn recording_state(record: Option<&OutputFile>, not_recorded: Option<String>) -> RecordingState {
    match (record, not_recorded) {
        (Some(file), _) => RecordingState::On(file.path().display().to_string()),
        (None, Some(reason)) => RecordingState::Failed(reason),
        (None, None) => RecordingState::Off,
    }
}

impl OpenParts {
    /// Closes the link, and then the other parts. A link that could not send its last zeros makes the run a
    /// failed one.
    pub(super) fn close(self, end: RunEnd) -> RunEnd {
        // Both at once: neither waits for the other's end.
        let boat = self.boat.map(|boat| std::thread::spawn(move || boat.close()));
        let is_stop_sent = self.link.is_none_or(Link::close);
        let is_vessel_neutral = boat.is_none_or(|closing| closing.join().unwrap_or(false));
        for source in std::iter::once(self.sources.first).chain(self.sources.second) {
            if let Err(error) = source.stop() {
                tracing::warn!("{error}");
            }
        }
        if let Some(console) = self.console {
            console.end(LeftMoving { camera: !is_stop_sent, boat: !is_vessel_neutral });
        }
        drop((self.tracking_camera, self.tak, self.share, self.detector));
        if let Some(Recording { path, recorder }) = self.recording
            && let Some(sortie) = recorder.finish()
        {
            SortieText { sortie: &sortie, path: &path, is_cut: false }.print();
        }
        if let Some(Err(error)) = self.overlay.map(OverlayVideo::finish) {
            tracing::error!("{error:#}");
        }
        with_motion_left(end, is_vessel_neutral, is_stop_sent)
    }
}

/// The end of a run, with what could not be stopped.
fn with_motion_left(end: RunEnd, is_vessel_neutral: bool, is_camera_stopped: bool) -> RunEnd {
    let boat = "the last neutral commands could not be sent to the boat, as its link was down: the boat may still be under way. Stop it by its own remote control";
    let camera = "the last zeros and the vehicle's stop could not be sent, as the link was down: the camera may still be turning. Stop it from the ground station itself";
    let left = [(is_vessel_neutral, boat), (is_camera_stopped, camera)];
    let mut failures: Vec<&str> =
        left.iter().filter(|(is_stopped, _)| !is_stopped).map(|(_, text)| *text).collect();
    if failures.is_empty() {
        return end;
    }
    if let RunEnd::Failed(reason) = &end {
        failures.push(reason);
    }
    RunEnd::Failed(failures.join("; and "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failure(end: RunEnd) -> String {
        match end {
            RunEnd::Failed(reason) => reason,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn everything_that_may_still_move_is_said_and_why_the_run_failed() {
        assert_eq!(with_motion_left(RunEnd::VideoEnded, true, true), RunEnd::VideoEnded);
        let both = failure(with_motion_left(RunEnd::Failed("a thread panicked".to_owned()), false, false));
        for part in
            ["the boat may still be under way", "the camera may still be turning", "a thread panicked"]
        {
            assert!(both.contains(part), "{both}");
        }
        let camera = failure(with_motion_left(RunEnd::VideoEnded, true, false));
        assert!(camera.contains("camera") && !camera.contains("boat"), "{camera}");
    }
}
