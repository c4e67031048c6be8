//! One live run from the opening of its parts to their closing, in an order that never leaves the camera
//! turning.
//!
//! 1. The terminal thread catches signals. From here on no signal ends the program without zeros.
//! 2. The link, the recording, the annotated video, the video source, the console and the status line are
//!    opened.
//! 3. The loop runs until something ends it.
//! 4. The link is closed first: zeros and the vehicle's own stop. The other parts follow.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use anyhow::{Context as _, Result};
use barrelman_console_server::operator::Gateway;
use barrelman_console_server::{ConsoleSettings, VideoOutlet};
use barrelman_host::absence::AbsenceWatch;
use barrelman_host::clock::Clock;
use barrelman_link::{VehicleLock, VehicleRole};
use barrelman_link_http::HttpSettings;
use barrelman_pilot::Pilot;
use barrelman_vocab::{CameraRequest, OperatorRequest, PixelBox, Videos};

use super::calibration::LiveCalibration;
use super::event::{Event, EventQueue, wake_by};
use super::faults::FaultInjector;
use super::killed_together;
use super::open_link::{LinkedVehicle, open_link, take_lock};
use super::open_vessel::open_vessel;
pub use super::parts::Outputs;
use super::parts::{OpenParts, OpenRun, PartOpener, PartSettings};
use super::run_loop::{LiveStepObserver, RunEnd, RunLoop};
use super::sleep_inhibitor::SleepInhibitor;
use super::source::Source;
use super::supervision::ServiceManager;
use super::terminal::Terminal;
use crate::config::Configuration;
use crate::config::vessel::SIMULATED;
use crate::detector::DetectorSetup;
use crate::link::vessel_link::{Boat, VesselLink};
use crate::link::{Link, LinkUrl, VehicleLink};
use crate::secrets;
use crate::share::ShareSetup;
use crate::tak::TakSetup;
use crate::tracking_camera::TrackingCameraSetup;

/// Capacity of the event queue. The loop processes thousands of events a second; hundreds arrive.
const EVENT_QUEUE_CAPACITY: usize = 1024;

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
    /// The operator's selection in the first video frame. Without a selection, a simulated world selects its
    /// target.
    pub selection: Option<PixelBox>,
    /// Whether the operator selects, also in a simulated world.
    pub waits_for_selection: bool,
    /// Whether the camera may move from the start.
    pub engage: bool,
    /// The console; `None`: no console.
    pub console: Option<ConsoleSettings>,
    /// The tracking camera on a MAVLink link; `None`: there is none.
    pub tracking_camera: Option<TrackingCameraSetup>,
    /// Where events for TAK go; `None`: none are sent.
    pub tak: Option<TakSetup>,
    /// Where the annotated video is served; `None`: nowhere.
    pub share: Option<ShareSetup>,
    /// The operator's detector; `None`: there is none.
    pub detector: Option<DetectorSetup>,
    /// The calibration that the run is made for; `None`: an ordinary run.
    pub calibration: Option<LiveCalibration>,
    /// Deliberate faults of the program's own threads.
    pub fault_injector: FaultInjector,
    /// The clock.
    pub clock: Clock,
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
        let end = self.run_with((link, boat), gateway, events, queue, terminal.watches_keys())?;
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

    /// Opens the other parts of the run, runs the loop, and closes all parts.
    fn run_with(
        self,
        links: (Option<Link>, Option<Boat>),
        gateway: Arc<Gateway>,
        events: SyncSender<Event>,
        queue: Receiver<Event>,
        watches_keys: bool,
    ) -> Result<RunEnd> {
        let (configuration, clock, fault_injector) = (self.configuration, self.clock, &self.fault_injector);
        let is_headless = self.console.is_none();
        let opener = PartOpener { configuration, clock, fault_injector, events: &events, gateway: &gateway };
        let settings = PartSettings {
            sources: self.sources,
            link_url: self.link,
            outputs: self.outputs,
            console: self.console,
            tracking_camera: self.tracking_camera,
            tak: self.tak,
            share: self.share,
            detector: self.detector,
            selects_target: self.selection.is_none() && !self.waits_for_selection,
        };
        let OpenRun { parts, publisher, latest, tracked, worlds, outlets } = opener.open(links, settings)?;
        let (status, status_output) = opener.open_status(watches_keys)?;
        let manager = ServiceManager::of_this_process(events.clone())?;
        let calibration = self.calibration.as_ref();
        let calibration = calibration.map(|run| run.observer(Arc::clone(&gateway), events.clone()));
        let observers = observers(&parts, outlets, calibration);
        let queue = EventQueue { queue, clock, absence: AbsenceWatch::start(clock.now()) };
        let queue = fault_injector.events(clock, queue);
        let mut queue = match &manager {
            Some(manager) => manager.events(queue),
            None => queue,
        };
        let run_loop = RunLoop {
            pilot: self.pilot,
            profile: configuration.profile.clone(),
            events: &mut *queue,
            gateway,
            publisher,
            latest,
            tracked,
            second_field_of_view: configuration.second_video.as_ref().and_then(|second| second.field_of_view),
            link: parts.link.as_ref().map(|link| link as &dyn VehicleLink),
            boat: parts.boat.as_ref().map(|boat| boat as &dyn VesselLink),
            worlds,
            recorder: parts.recording.as_ref().map(|recording| observer(recording.recorder.input())),
            status,
            status_output: Box::new(status_output),
            ends_on_refused_selection: is_headless,
            observers,
        };
        let end = run_to_end(run_loop, &first_requests(self.selection, self.engage));
        // No event is processed from here on. A thread that waits for room in the queue would hold up the end.
        drop(queue);
        if let Some(manager) = &manager {
            manager.say_ending();
        }
        Ok(parts.close(end))
    }
}

/// Runs the loop. A panic in the pilot must not unwind past the link's shutdown.
fn run_to_end(run_loop: RunLoop<'_>, requests: &[OperatorRequest]) -> RunEnd {
    catch_unwind(AssertUnwindSafe(|| run_loop.run(requests)))
        .unwrap_or_else(|_| RunEnd::Failed("the pilot's thread panicked".to_owned()))
}

/// The observers of the loop's steps, beside the recorder.
fn observers<'a>(
    parts: &OpenParts,
    outlets: Option<Videos<VideoOutlet>>,
    calibration: Option<impl LiveStepObserver + 'a>,
) -> Vec<Box<dyn LiveStepObserver + 'a>> {
    let mut observers: Vec<Box<dyn LiveStepObserver + 'a>> = Vec::new();
    observers.extend(parts.overlay.as_ref().map(|overlay| observer(overlay.input())));
    observers.extend(parts.share.as_ref().map(|share| observer(share.input())));
    observers.extend(parts.detector.as_ref().map(|detector| observer(detector.input())));
    if let Some(outlets) = outlets {
        observers.push(Box::new(outlets.map(|_, outlet| outlet.pictures)));
    }
    observers.extend(calibration.map(observer));
    observers
}

fn observer<'a>(observer: impl LiveStepObserver + 'a) -> Box<dyn LiveStepObserver + 'a> {
    Box::new(observer)
}

/// The requests that the pilot receives before the first event.
fn first_requests(selection: Option<PixelBox>, engage: bool) -> Vec<OperatorRequest> {
    let select = selection.map(|bounds| CameraRequest::SelectNext(bounds).into());
    select.into_iter().chain(engage.then_some(CameraRequest::Engage.into())).collect()
}
