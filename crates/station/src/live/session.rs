//! One live run from the opening of its parts to their closing, in an order that never leaves the camera turning.
//!
//! 1. The terminal thread catches signals. From here on no signal ends the program without zeros.
//! 2. The link, the recording, the annotated video, the video source, the console and the status line are opened.
//! 3. The loop runs until something ends it.
//! 4. The link is closed first: zeros and the vehicle's own stop. The other parts follow.

use std::io::{Write as _, stdout};
use std::net::SocketAddr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use anyhow::{Context as _, Result};
use barrelman_console_server::operator::Gateway;
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState, WorldState};
use barrelman_console_server::{
    ConsoleParts, ConsoleServer, ConsoleSettings, SessionFacts, SessionTime, VideoOutlet,
};
use barrelman_host::absence::AbsenceWatch;
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_host::output::OutputFile;
use barrelman_link::{VehicleLock, VehicleRole};
use barrelman_link_http::HttpSettings;
use barrelman_pilot::Pilot;
use barrelman_video::VideoHandle;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{CameraRequest, OperatorRequest, PixelBox, Videos};

use super::calibration::LiveCalibration;
use super::event::{Event, EventQueue, report_panics, wake_by};
use super::faults::FaultInjector;
use super::foxglove_server::FoxgloveServer;
use super::killed_together;
use super::open_link::{LinkedVehicle, open_link, take_lock};
use super::open_vessel::open_vessel;
use super::overlay_video::OverlayVideo;
use super::recorder::{Extras, Recorder};
use super::recording_folder::{DiskReserve, library};
use super::recording_start::recording_start;
use super::run_loop::{LiveStepObserver, RunEnd, RunLoop};
use super::sleep_inhibitor::SleepInhibitor;
use super::sortie_text::SortieText;
use super::source::Source;
use super::status_line::StatusLine;
use super::status_writer::{LineStyle, StatusWriter};
use super::supervision::ServiceManager;
use super::terminal::{KEYS, Terminal};
use super::tracked_video::TrackedVideo;
use super::video_sink::{LiveVideoSink, VideoReceivers};
use crate::config::Configuration;
use crate::config::vessel::SIMULATED;
use crate::link::vessel_link::{Boat, VesselLink};
use crate::link::{Link, LinkUrl, VehicleLink};
use crate::secrets;
use crate::simulated_source::LiveWorld;
use crate::tracking_camera::{CameraParts, TrackingCameraSetup, TrackingCameraThread};

/// Capacity of the event queue. The loop processes thousands of events a second; hundreds arrive.
const EVENT_QUEUE_CAPACITY: usize = 1024;

/// The files of a run, open.
#[derive(Debug, Default)]
pub struct Outputs {
    /// The recording.
    pub record: Option<OutputFile>,
    /// The annotated video.
    pub overlay: Option<OutputFile>,
    /// The free space that the recording leaves on its disk.
    pub reserve: Option<DiskReserve>,
    /// Who watches the recording while it is made.
    pub foxglove: Option<SocketAddr>,
    /// Why the recording that every run makes could not be opened.
    pub not_recorded: Option<String>,
}

/// Everything a run needs.
pub struct Session<'a> {
    /// The effective configuration.
    pub configuration: &'a Configuration,
    /// The pilot of that configuration.
    pub pilot: Pilot,
    /// The video sources.
    pub sources: Videos<Source>,
    /// The link; `None`: a dry run.
    pub link: Option<LinkUrl>,
    /// The guard's program, which serves the port of the link; `None`: a thread of this process does.
    pub guard: Option<PathBuf>,
    /// The guard's program, which serves the port of the boat; `None`: a thread of this process does.
    pub vessel_guard: Option<PathBuf>,
    /// How the vehicle is reached over HTTP; `None`: by bytes.
    pub http: Option<HttpSettings>,
    /// The output files.
    pub outputs: Outputs,
    /// The operator's selection in the first video frame. Without a selection, a simulated world selects its target.
    pub selection: Option<PixelBox>,
    /// Whether the operator selects, also in a simulated world.
    pub waits_for_selection: bool,
    /// Whether the camera may move from the start.
    pub engage: bool,
    /// The console; `None`: no console.
    pub console: Option<ConsoleSettings>,
    /// The tracking camera on a MAVLink link; `None`: there is none.
    pub tracking_camera: Option<TrackingCameraSetup>,
    /// The calibration that the run is made for; `None`: an ordinary run.
    pub calibration: Option<LiveCalibration>,
    /// Deliberate faults of the program's own threads.
    pub fault_injector: FaultInjector,
    /// The clock.
    pub clock: Clock,
}

/// The open parts of a run that are closed explicitly.
struct OpenParts {
    link: Option<Link>,
    boat: Option<Boat>,
    recording: Option<Recording>,
    overlay: Option<OverlayVideo>,
    sources: Videos<VideoHandle>,
    console: Option<ConsoleServer>,
    tracking_camera: Option<TrackingCameraThread>,
}

/// A recording and its file.
struct Recording {
    path: PathBuf,
    recorder: Recorder,
    /// Ends after the recording.
    _foxglove: Option<FoxgloveServer>,
}

impl Session<'_> {
    /// Opens the parts of the run, runs the loop, and closes the parts.
    ///
    /// # Errors
    /// If a part cannot be opened. The parts opened before it are closed.
    pub fn run(self) -> Result<RunEnd> {
        let (events, queue) = sync_channel(EVENT_QUEUE_CAPACITY);
        let gateway = Arc::new(Gateway::new(wake_by(events.clone())));
        let terminal =
            Terminal::watch(Arc::clone(&gateway), events.clone(), self.clock, self.fault_injector.clone())?;
        let key_file = self.configuration.signing_key_file.as_deref().filter(|_| self.link.is_some());
        // Held until the links are closed.
        let lock = self.link.as_ref().map(|url| take_lock(url, VehicleRole::Camera)).transpose()?.flatten();
        let vessel_lock = self.lock_of_vessel()?;
        let vehicle = LinkedVehicle {
            profile: &self.configuration.profile,
            framing: self.configuration.framing,
            guard: self.guard.clone(),
            lock: lock.clone(),
            signing: secrets::mavlink_signing(key_file, self.clock)?,
            http: self.http.clone(),
        };
        let link = open_link(self.link.as_ref(), self.sources.first.world(), vehicle, self.clock, &events)?;
        let boat = match &self.configuration.vessel {
            Some(vessel) => {
                let guard = (self.vessel_guard.clone(), vessel_lock.clone());
                Some(open_vessel(vessel, self.sources.first.world(), guard, self.clock, &events)?)
            }
            None => None,
        };
        if self.guard.is_some() || self.vessel_guard.is_some() {
            killed_together::warn();
        }
        let _awake = link.as_ref().filter(|link| link.reaches_vehicle()).and_then(|_| SleepInhibitor::hold());
        self.warn_without_selection();
        let end = self.run_with((link, boat), gateway, events, &queue, terminal.watches_keys())?;
        drop(terminal);
        drop((lock, vessel_lock));
        Ok(end)
    }

    /// The lock of the boat's address; `None`: there is no boat, or a simulated one.
    fn lock_of_vessel(&self) -> Result<Option<Arc<VehicleLock>>> {
        let vessel = self.configuration.vessel.as_ref();
        let Some(vessel) = vessel.filter(|vessel| vessel.url != SIMULATED) else { return Ok(None) };
        take_lock(&LinkUrl::parse(&vessel.url).context("vessel.url")?, VehicleRole::Boat)
    }

    fn warn_without_selection(&self) {
        if self.selection.is_some() || self.sources.first.world().is_some() || self.calibration.is_some() {
            return;
        }
        if self.console.is_some() {
            let meanwhile = if self.sources.first.is_live() {
                ""
            } else {
                "; the file plays on meanwhile. To draw the box in its first frame, give --listen 127.0.0.1:8480; \
                 --select X,Y,W,H repeats a selection"
            };
            tracing::info!("nothing is selected yet: draw a box around the boat on the console{meanwhile}");
        } else {
            tracing::warn!(
                "nothing is selected, so the camera will not move: give --select X,Y,W,H, the box around the boat in the first picture"
            );
        }
    }

    fn run_with(
        self,
        (link, boat): (Option<Link>, Option<Boat>),
        gateway: Arc<Gateway>,
        events: SyncSender<Event>,
        queue: &Receiver<Event>,
        watches_keys: bool,
    ) -> Result<RunEnd> {
        let Self {
            configuration,
            pilot,
            sources,
            link: link_url,
            outputs,
            clock,
            fault_injector,
            console,
            tracking_camera,
            calibration,
            ..
        } = self;
        let profile = &configuration.profile;
        let recording = match (&outputs.record, outputs.not_recorded) {
            (Some(file), _) => RecordingState::On(file.path().display().to_string()),
            (None, Some(reason)) => RecordingState::Failed(reason),
            (None, None) => RecordingState::Off,
        };
        let link_status = link.as_ref().map_or(LinkStatus::DryRun, |_| LinkStatus::Link(LinkState::Opening));
        let mut publisher = Publisher::new(profile, link_status, recording);
        publisher.set_vessel_link(LinkStatus::Link(LinkState::Opening));
        let address = sources.first.address();
        let second_address = sources.second.as_ref().map(Source::address);
        let worlds = sources.first.world().map(LiveWorld::switch).transpose()?;
        if let Some(worlds) = &worlds {
            let first = worlds.first();
            let world = WorldState { scenario: first.scenario.clone(), seed: first.seed, boat: None };
            publisher.set_world(world, clock.now());
        }
        let is_recorded = outputs.record.is_some();
        let recording = match outputs.record {
            Some(file) => {
                let start = recording_start(configuration, &sources, link_url.as_ref(), clock)?;
                let path = file.path().to_owned();
                let context = format!("the recording {} cannot be written", path.display());
                let server = outputs.foxglove.map(FoxgloveServer::start).transpose()?;
                let (foxglove, live) =
                    server.map_or((None, None), |(server, live)| (Some(server), Some(live)));
                let recorder = Recorder::begin(
                    file,
                    &start,
                    clock,
                    fault_injector.clone(),
                    events.clone(),
                    Extras { reserve: outputs.reserve, live },
                    profile,
                );
                Some(Recording { path, recorder: recorder.context(context)?, _foxglove: foxglove })
            }
            None => None,
        };
        let begin_overlay =
            |file| OverlayVideo::begin(file, profile.region, clock, fault_injector.clone(), events.clone());
        let overlay = outputs.overlay.map(begin_overlay).transpose()?;
        let latest = Arc::new(Latest::default());
        let outlets = console.as_ref().map(|_| sources.as_ref().map(|_, _| VideoOutlet::default()));
        if sources.second.is_some() {
            publisher.add_second_video();
        }
        let tracked = TrackedVideo::default();
        let receivers = VideoReceivers {
            tracked: tracked.clone(),
            latest: Arc::clone(&latest),
            recorder: recording.as_ref().map(|recording| recording.recorder.input()),
            events: events.clone(),
            gateway: Arc::clone(&gateway),
            selects_target: self.selection.is_none() && !self.waits_for_selection,
        };
        let sources = sources.try_map(|number, source| {
            let outlet = outlets.as_ref().and_then(|outlets| outlets.get(number)).cloned();
            let sink = LiveVideoSink::new(number, receivers.clone(), outlet);
            source.start(configuration, is_recorded, clock, sink)
        })?;
        drop(receivers);
        let is_headless = console.is_none();
        let facts = SessionFacts {
            command: "run",
            source: address,
            second_source: second_address,
            link: link_url.as_ref().map(ToString::to_string),
            vehicle: profile.name.clone(),
            scenarios: worlds.as_ref().map(|worlds| worlds.choices().to_vec()).unwrap_or_default(),
        };
        let open_console = |(settings, videos): (ConsoleSettings, Videos<VideoOutlet>)| {
            let parts = ConsoleParts {
                facts: facts.clone(),
                gateway: Arc::clone(&gateway),
                snapshots: publisher.subscribe(),
                events: publisher.events(),
                videos,
                time: SessionTime::new(clock),
                library: library(&configuration.recording),
            };
            ConsoleServer::open(settings, parts, report_panics(events.clone()))
        };
        let console = console.zip(outlets.clone()).map(open_console).transpose()?;
        let open_camera = |setup: TrackingCameraSetup| {
            let parts =
                CameraParts { gateway: Arc::clone(&gateway), snapshots: publisher.subscribe(), clock };
            TrackingCameraThread::start(setup, parts, events.clone())
        };
        let tracking_camera = tracking_camera.map(open_camera).transpose()?;
        let parts = OpenParts { link, boat, recording, overlay, sources, console, tracking_camera };
        if watches_keys {
            // The thread of the terminal notices a closed output.
            let _ = writeln!(stdout(), "keys on this terminal: {KEYS}");
        }
        let style = LineStyle::for_stdout();
        let status_output =
            StatusWriter::start(stdout(), style, clock, fault_injector.clone(), events.clone())?;
        let manager = ServiceManager::of_this_process(events.clone())?;
        let mut observers: Vec<Box<dyn LiveStepObserver + '_>> = Vec::new();
        observers.extend(parts.overlay.as_ref().map(|overlay| observer(overlay.input())));
        if let Some(outlets) = outlets {
            observers.push(Box::new(outlets.map(|_, outlet| outlet.pictures)));
        }
        if let Some(calibration) = &calibration {
            observers.push(observer(calibration.observer(Arc::clone(&gateway), events)));
        }
        let requests = first_requests(self.selection, self.engage);
        let queue = EventQueue { queue, clock, absence: AbsenceWatch::start(clock.now()) };
        let events = fault_injector.events(clock, queue);
        let mut events = match &manager {
            Some(manager) => manager.events(events),
            None => events,
        };
        let run_loop = RunLoop {
            pilot,
            profile: profile.clone(),
            events: &mut *events,
            gateway,
            publisher,
            latest,
            tracked,
            second_field_of_view: configuration.second_video.as_ref().and_then(|second| second.field_of_view),
            link: parts.link.as_ref().map(|link| link as &dyn VehicleLink),
            boat: parts.boat.as_ref().map(|boat| boat as &dyn VesselLink),
            worlds,
            recorder: parts.recording.as_ref().map(|recording| observer(recording.recorder.input())),
            status: StatusLine::new(style.interval()).naming_keys(watches_keys),
            status_output: Box::new(status_output),
            ends_on_refused_selection: is_headless,
            observers,
        };
        // A panic in the pilot must not unwind past the link's shutdown.
        let end = catch_unwind(AssertUnwindSafe(|| run_loop.run(&requests)))
            .unwrap_or_else(|_| RunEnd::Failed("the pilot's thread panicked".to_owned()));
        if let Some(manager) = &manager {
            manager.say_ending();
        }
        Ok(parts.close(end))
    }
}

fn observer<'a>(observer: impl LiveStepObserver + 'a) -> Box<dyn LiveStepObserver + 'a> {
    Box::new(observer)
}

/// The requests that the pilot receives before the first event.
fn first_requests(selection: Option<PixelBox>, engage: bool) -> Vec<OperatorRequest> {
    let select = selection.map(|bounds| CameraRequest::SelectNext(bounds).into());
    select.into_iter().chain(engage.then_some(CameraRequest::Engage.into())).collect()
}

impl OpenParts {
    /// Closes the link, and then the other parts. A link that could not send its last zeros makes the run a failed one.
    fn close(self, end: RunEnd) -> RunEnd {
        // Both at once: neither waits for the other's end.
        let boat = self.boat.map(|boat| std::thread::spawn(move || boat.close()));
        let is_stop_sent = self.link.is_none_or(Link::close);
        let is_vessel_neutral = boat.is_none_or(|closing| closing.join().unwrap_or(false));
        for source in std::iter::once(self.sources.first).chain(self.sources.second) {
            if let Err(error) = source.stop() {
                tracing::warn!("{error}");
            }
        }
        drop(self.console);
        drop(self.tracking_camera);
        if let Some(Recording { path, recorder, _foxglove }) = self.recording
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
