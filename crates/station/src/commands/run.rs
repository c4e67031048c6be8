//! `barrelman run`: the real thing.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, bail};
use barrelman_pilot::{Pilot, PilotSettings};
use barrelman_trial::records::RecordingStart;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{EncodedUnit, OperatorRequest, PixelBox, Telemetry, VideoFrame};

use crate::cli::{RunArgs, UsageError};
use crate::config::{self, ConfigFile, Configuration};
use crate::link::url::Endpoint;
use crate::link::{Link, LinkHandle, LinkReport, LinkUrl};
use crate::live::event::Event;
use crate::live::overlay_video::OverlayVideo;
use crate::live::recorder::{Recorder, RecorderInput};
use crate::live::run_loop::{FrameObserver, RunEnd, RunLoop};
use crate::live::status::Status;
use crate::live::terminal::Terminal;
use crate::live::threads::FaultInjector;
use crate::secrets;
use crate::simulated_source::{self, LiveWorld};
use crate::source_url::{SimulatedUrl, SourceUrl};
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_host::output::OutputFile;
use barrelman_video::url::VideoSource;
use barrelman_video::{DecodeError, VideoSink, VideoState, VideoUrl};

/// Events that may wait for the loop. It takes thousands a second; hundreds come.
const EVENTS: usize = 1024;

/// Runs the command.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run(args: &RunArgs, clock: Clock) -> Result<ExitCode> {
    run_into(args, || Outputs::open(args), clock)
}

/// The files of a run, open.
#[derive(Debug, Default)]
pub struct Outputs {
    /// The recording.
    pub record: Option<OutputFile>,
    /// The annotated video.
    pub overlay: Option<OutputFile>,
}

impl Outputs {
    fn open(args: &RunArgs) -> Result<Self> {
        let open = |path: &Option<PathBuf>| {
            path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose()
        };
        Ok(Self { record: open(&args.record)?, overlay: open(&args.overlay)? })
    }
}

/// Runs the command with outputs that `open` gives, in place of those that the arguments name.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run_into(args: &RunArgs, open: impl FnOnce() -> Result<Outputs>, clock: Clock) -> Result<ExitCode> {
    let (mut configuration, latency_is_known) = effective(args)?;
    let Some(video) = &configuration.video else {
        let remedy = "give --video rtsp://..., --video file:clip.mp4, --video sim:arena1, or video.url in the configuration";
        return Err(UsageError(format!("no video source: {remedy}")).into());
    };
    let source = secrets::source_url(video, configuration.video_login.as_ref())?;
    let takes_login =
        matches!(&source, SourceUrl::Video(url) if matches!(url.source, VideoSource::Rtsp { .. }));
    if args.video_login_file.is_some() && !takes_login {
        return Err(
            UsageError(format!("--video-login-file is for rtsp:// alone: {source} takes no login")).into()
        );
    }
    let link = configuration.link.as_deref().map(LinkUrl::parse).transpose()?;
    let source = Source::load(source)?;
    if source.world().is_none() && link.as_ref().is_some_and(|link| link.endpoint == Endpoint::World) {
        bail!("--link sim: moves the camera of a simulated world: give --video sim:SCENARIO with it");
    }
    if let Some(world) = source.world().filter(|_| !latency_is_known) {
        configuration.profile.video_latency = world.scenario().camera.latency();
    }
    let outputs = open()?;
    let end = live(args, &configuration, source, link, outputs, clock)?;
    Ok(match end {
        RunEnd::VideoEnded => {
            tracing::info!("the video has ended");
            ExitCode::SUCCESS
        }
        RunEnd::Asked(why) => {
            tracing::info!("stopped: {why}");
            ExitCode::SUCCESS
        }
        RunEnd::Failed(why) => {
            tracing::error!("{why}");
            ExitCode::FAILURE
        }
    })
}

/// The video source, and the simulated world where the source is one.
enum Source {
    Video(VideoUrl),
    Simulated(SimulatedUrl, Box<LiveWorld>),
}

impl Source {
    fn load(url: SourceUrl) -> Result<Self> {
        Ok(match url {
            SourceUrl::Video(url) => Self::Video(url),
            SourceUrl::Simulated(url) => {
                let world = Box::new(LiveWorld::load(&url.world)?);
                Self::Simulated(url, world)
            }
        })
    }

    fn world(&self) -> Option<&LiveWorld> {
        match self {
            Self::Video(_) => None,
            Self::Simulated(_, world) => Some(world),
        }
    }

    /// The address without a password, and whether the source is live.
    fn described(&self) -> (String, bool) {
        match self {
            Self::Video(url) => (url.to_string(), url.is_live()),
            Self::Simulated(url, _) => (url.to_string(), true),
        }
    }
}

/// The configuration of a run: the file, and over it what the command line says; and whether it says how late the
/// video comes.
fn effective(args: &RunArgs) -> Result<(Configuration, bool)> {
    let mut file = match &args.config {
        Some(path) => config::read(path)?,
        None => ConfigFile::default(),
    };
    let over = |key: &mut Option<String>, value: &Option<String>| {
        if let Some(value) = value {
            *key = Some(value.clone());
        }
    };
    over(&mut file.video.url, &args.video);
    over(&mut file.link.url, &args.link);
    over(&mut file.vehicle.profile, &args.profile);
    if let Some(path) = &args.video_login_file {
        (file.video.login_file, file.video.login_env) = (Some(path.clone()), None);
    }
    file.tracker.name = args.tracker.or(file.tracker.name);
    let context = || match &args.config {
        Some(path) => format!("the configuration {} is not usable", path.display()),
        None => "the command line is not usable".to_owned(),
    };
    let latency_is_known = file.vehicle.video_latency_s.is_some();
    let mut configuration = Configuration::resolve(&file).with_context(context)?;
    configuration.law = args.law.resolve(configuration.law)?;
    Ok((configuration, latency_is_known))
}

/// A pilot for a configuration, with its tracker.
///
/// # Errors
/// If the tracker's settings lie outside their ranges.
pub fn build_pilot(configuration: &Configuration) -> Result<Pilot> {
    let settings =
        PilotSettings { profile: configuration.profile.clone(), law: configuration.law.settings() };
    Ok(Pilot::new(settings, configuration.tracker.tracker()?))
}

fn live(
    args: &RunArgs,
    configuration: &Configuration,
    source: Source,
    link_url: Option<LinkUrl>,
    outputs: Outputs,
    clock: Clock,
) -> Result<RunEnd> {
    let fault_injector = FaultInjector::parse(&args.fault)?;
    let (events, queue) = sync_channel(EVENTS);
    let pilot = build_pilot(configuration)?;
    // Signals are caught before the port is opened: from here on nothing ends the program without zeros.
    let terminal = Terminal::watch(events.clone(), clock, fault_injector.clone())?;
    let link = match (&link_url, source.world()) {
        (Some(url), Some(world)) if url.endpoint == Endpoint::World => {
            let link = world.link();
            link.set_faults(url.faults.clone());
            let up = Telemetry { at: clock.now(), report: Report::Link(LinkState::Up) };
            events.send(Event::Link(LinkReport::Telemetry(up)))?;
            let to_loop = events.clone();
            link.on_tilt_report(move |tilt| {
                let report = Telemetry { at: clock.now(), report: Report::CameraTilt(tilt) };
                // The world never waits for a loop that is held up.
                let _ = to_loop.try_send(Event::Link(LinkReport::Telemetry(report)));
            });
            Some(Link::World(link))
        }
        (Some(url), _) => {
            let to_loop = events.clone();
            let report = move |report| {
                // The link never waits for a loop that is held up: a report that finds no room is left out. Its last
                // report comes after its last will, and may wait. Of a loop that is gone nobody misses one.
                match report {
                    LinkReport::Panicked => drop(to_loop.send(Event::Link(report))),
                    _ => drop(to_loop.try_send(Event::Link(report))),
                }
            };
            let link = LinkHandle::open(url, configuration.framing, clock, report)
                .context("the link cannot be used")?;
            Some(Link::Port(link))
        }
        (None, _) => {
            tracing::warn!("no link: this is a dry run that sends nothing");
            None
        }
    };
    if args.select.is_none() && source.world().is_none() {
        tracing::warn!(
            "nothing is selected, so the camera will not move: give --select X,Y,W,H, the box around the boat in the first picture"
        );
    }
    let is_recorded = outputs.record.is_some();
    let recorder = match outputs.record {
        Some(file) => {
            let start = recording_start(configuration, &source, link_url.as_ref(), clock)?;
            Some(Recorder::begin(file, &start, clock, fault_injector.clone(), events.clone())?)
        }
        None => None,
    };
    let overlay = match outputs.overlay {
        Some(file) => {
            let shares = configuration.profile.region;
            Some(OverlayVideo::begin(file, shares, clock, fault_injector.clone(), events.clone())?)
        }
        None => None,
    };
    let latest = Arc::new(Latest::default());
    let recording = recorder.as_ref().map(Recorder::input);
    let sink = Sink {
        latest: Arc::clone(&latest),
        recording: recording.clone(),
        events: events.clone(),
        damaged: 0,
        selects: args.select.is_none(),
    };
    let source = match source {
        // What is recorded is what the pilot saw: a replay can only decode it again.
        Source::Simulated(url, world) => {
            let world = (*world).with_profile(&configuration.profile).with_encoding(is_recorded);
            simulated_source::spawn_world(world, &url, clock, sink)?
        }
        Source::Video(url) => barrelman_video::spawn(url, clock, sink)?,
    };
    let link_state = link.as_ref().map(|_| LinkState::Opening);
    let status = Status::start(link_state, clock, fault_injector.clone(), events.clone())?;
    drop(events);

    let mut requests = Vec::new();
    requests.extend(args.select.map(OperatorRequest::Select));
    requests.extend(args.engage.then_some(OperatorRequest::Engage));
    let run_loop = RunLoop {
        pilot,
        profile: configuration.profile.clone(),
        clock,
        latest,
        link: link.as_ref(),
        recorder: recording,
        status,
        selects_once: true,
        observer: overlay.as_ref().map(|overlay| Box::new(overlay.input()) as Box<dyn FrameObserver>),
        fault_injector,
    };
    // A panic in the pilot must not take the road of unwinding, where the link would wait for its turn.
    let mut end = catch_unwind(AssertUnwindSafe(|| run_loop.run(&queue, &requests)))
        .unwrap_or_else(|_| RunEnd::Failed("the pilot's thread panicked".to_owned()));

    // The zeros first, then everything else, and the vehicle's own stop meanwhile.
    let said = link.map(Link::close);
    if said == Some(false) {
        end = RunEnd::Failed(
            "the last zeros and the vehicle's stop could not be sent, as the link was down: the camera may still be turning. Stop it from the ground station itself".to_owned(),
        );
    }
    if let Err(error) = source.stop() {
        tracing::warn!("{error}");
    }
    if let Some(recorder) = recorder {
        recorder.finish();
    }
    if let Some(Err(error)) = overlay.map(OverlayVideo::finish) {
        tracing::error!("{error:#}");
    }
    drop(terminal);
    Ok(end)
}

fn recording_start(
    configuration: &Configuration,
    source: &Source,
    link: Option<&LinkUrl>,
    clock: Clock,
) -> Result<RecordingStart> {
    let since_start = Duration::from_nanos(clock.now().as_nanos());
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().saturating_sub(since_start);
    // The configuration is stored without passwords: a recording is handed on.
    let mut stored = configuration.clone();
    let (video, live_video) = source.described();
    stored.video = Some(video.clone());
    Ok(RecordingStart {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        monotonic_ns: clock.start_on_monotonic_ns(),
        unix_ns: u64::try_from(unix.as_nanos()).unwrap_or(u64::MAX),
        configuration: stored.to_toml()?,
        video,
        link: link.map(ToString::to_string).unwrap_or_default(),
        live_video,
        behaviour: configuration.law.behaviour_with(configuration.tracker.name),
    })
}

/// Takes what the video thread delivers.
struct Sink {
    latest: Arc<Latest<VideoFrame>>,
    recording: Option<RecorderInput>,
    events: SyncSender<Event>,
    damaged: u64,
    /// Whether nobody has selected anything: a simulated world then says where its target is.
    selects: bool,
}

impl VideoSink for Sink {
    fn unit(&mut self, unit: &EncodedUnit) {
        if let Some(recording) = &self.recording {
            recording.unit(unit);
        }
    }

    fn frame(&mut self, frame: VideoFrame) {
        if self.latest.put(frame) {
            let _ = self.events.send(Event::Frame);
        }
    }

    fn target(&mut self, target: PixelBox) {
        if self.selects {
            tracing::info!("no --select: the simulated world says where the boat is, {target}");
            let _ = self.events.send(Event::Request(OperatorRequest::Select(target)));
        }
    }

    fn state(&mut self, state: VideoState) {
        let _ = self.events.send(Event::Video(state));
    }

    fn damaged(&mut self, error: &DecodeError) {
        self.damaged += 1;
        if self.damaged == 1 {
            tracing::warn!("damaged video: {error}; further damage is counted");
        }
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        if self.damaged > 1 {
            tracing::warn!("{} damaged pictures in all", self.damaged);
        }
        // The sink dies with its thread: unwinding means that the thread panics.
        if std::thread::panicking() {
            let _ = self.events.send(Event::ThreadPanicked { thread: "video".to_owned() });
        }
    }
}
