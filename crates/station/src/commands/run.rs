//! `barrelman run`: one live run. This file reads the arguments and reports the end; `live::session` is the run.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use barrelman_console_server::{AfterPicking, ConsoleSettings};
use barrelman_pilot::{CommandPath, Pilot, PilotSettings};

use super::draw_selection::{draw_selection, has_display};
use crate::cli::{CalibrateAxesArgs, RunArgs, UsageError};
use crate::config::{Configuration, ConsoleConfig, RecordingConfig, UnusableConfiguration};
use crate::link::url::Endpoint;
use crate::link::{LinkUrl, command_path, find_guard, vehicle_over_http, video_of_vehicle};
use crate::live::calibration::LiveCalibration;
use crate::live::faults::{FAULT_THREADS, FaultInjector};
use crate::live::recording_folder::{self, DiskReserve};
use crate::live::run_loop::RunEnd;
use crate::live::session::{Outputs, Session};
use crate::live::source::Source;
use crate::secrets::{self, TrustFiles};
use crate::source_url::SourceUrl;
use crate::tracking_camera::{self, TrackingCameraSetup};
use barrelman_experiments::calibration::{CalibrationRecorder, CalibrationResult};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultKind;
use barrelman_host::fault_lines::parse_fault_lines;
use barrelman_host::input;
use barrelman_host::output::OutputFile;
use barrelman_video::url::VideoSource;
use barrelman_vocab::Videos;
use barrelman_vocab::{Angle, PixelBox};
use barrelman_wire::mavlink::tracking_camera::{CameraDescription, VideoStream};

/// Runs the command.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run(args: &RunArgs, clock: Clock) -> Result<ExitCode> {
    run_with_outputs(args, |recording| open_outputs(args, recording), clock)
}

/// Runs the command with the outputs of `open`, instead of those that the arguments name.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run_with_outputs(
    args: &RunArgs,
    open: impl FnOnce(&RecordingConfig) -> Result<Outputs>,
    clock: Clock,
) -> Result<ExitCode> {
    let (mut configuration, latency_is_known) = effective_configuration(args)?;
    let mut link = configuration.link.as_deref().map(LinkUrl::parse).transpose()?;
    let http = vehicle_over_http(&configuration, link.as_ref())?;
    let mut named = None;
    if let (None, Some(http)) = (&configuration.video, &http) {
        let video = video_of_vehicle(http, configuration.link_video_host.as_deref())?;
        tracing::info!("the vehicle's video: {video}");
        configuration.video = Some(video.to_string());
        named = Some(video);
        // One vehicle, one certificate.
        if configuration.video_trust == TrustFiles::default() {
            configuration.video_trust = configuration.link_access.trust.clone();
        }
    }
    let Some(video) = &configuration.video else {
        let file = args.connection.config.as_ref();
        let file = file.map_or_else(|| "the configuration".to_owned(), |path| path.display().to_string());
        let remedy = "give --video rtsp://..., --video file:clip.mp4, --video sim:arena1, or video.url in";
        return Err(UsageError(format!("no video source: {remedy} {file}")).into());
    };
    let source = match named {
        Some(video) => secrets::named_source_url(video, &configuration.video_login)?,
        None => secrets::source_url(video, &configuration.video_login)?,
    };
    let uses_login =
        matches!(&source, SourceUrl::Video(url) if matches!(url.source, VideoSource::Rtsp { .. }));
    if args.connection.video_login_file.is_some() && !uses_login {
        return Err(
            UsageError(format!("--video-login-file is for rtsp:// alone: {source} uses no login")).into()
        );
    }
    let mut source = source;
    let fault_injector = injected_faults(args, link.as_mut(), &mut source)?;
    let source = Source::load(source, secrets::trust(&configuration.video_trust)?)?;
    let second_source = second_source(&configuration)?;
    if source.world().is_none()
        && link.as_ref().is_some_and(|link| link.endpoint == Endpoint::SimulatedCamera)
    {
        bail!("--link sim: moves the camera of a simulated world: give --video sim:SCENARIO with it");
    }
    if let Some(world) = source.world().filter(|_| !latency_is_known) {
        configuration.profile.video_latency = world.scenario().camera.latency();
    }
    let tracking_camera = tracking_camera(&configuration, &source, clock)?;
    let guard = needed_guard(&configuration, link.as_ref())?;
    let vessel_guard = needed_vessel_guard(&configuration)?;
    let console = (!args.headless).then(|| open_console(args, &configuration.console)).transpose()?;
    let pilot = build_pilot(&configuration, command_path(link.as_ref()))?;
    let selection = match args.select {
        None => drawn_selection(args, &source, console.as_ref())?,
        selection => selection,
    };
    // The last to be opened: making room for a recording removes older ones.
    let outputs = open(&configuration.recording)?;
    let session = Session {
        pilot,
        configuration: &configuration,
        sources: Videos { first: source, second: second_source },
        link,
        guard,
        vessel_guard,
        http,
        outputs,
        selection,
        waits_for_selection: args.hands_on,
        console,
        tracking_camera,
        engage: args.engage,
        calibration: None,
        fault_injector,
        clock,
    };
    Ok(match session.run()? {
        RunEnd::VideoEnded => {
            tracing::info!("the video has ended");
            ExitCode::SUCCESS
        }
        RunEnd::Requested(why) => {
            tracing::info!("stopped: {why}");
            ExitCode::SUCCESS
        }
        RunEnd::Failed(why) => {
            tracing::error!("{why}");
            ExitCode::FAILURE
        }
    })
}

/// The box that the operator draws in the first frame of a file, before anything is opened that moves or records. A file
/// with `--hands-on` plays on while the operator selects, as a stream does.
fn drawn_selection(
    args: &RunArgs,
    source: &Source,
    console: Option<&ConsoleSettings>,
) -> Result<Option<PixelBox>> {
    let (Source::Video(url, _), Some(console)) = (source, console) else { return Ok(None) };
    let is_asked_for = args.console.listen.is_some() || has_display();
    if source.is_live() || args.hands_on || !is_asked_for {
        return Ok(None);
    }
    let settings = console.duplicate().context("the page for the selection cannot be served")?;
    draw_selection(url, 0, settings, AfterPicking::Console, false).map(Some)
}

/// The guard's program, where the vehicle needs one: it keeps its last rate when this program is gone.
///
/// # Errors
/// If the guard is not there, and the operator has not said that the run does without it.
fn needed_guard(configuration: &Configuration, link: Option<&LinkUrl>) -> Result<Option<PathBuf>> {
    if command_path(link) != CommandPath::Link || !configuration.profile.keeps_last_rate() {
        return Ok(None);
    }
    if configuration.guard.is_omitted {
        tracing::warn!(
            "no guard: if this program is killed, crashes or hangs, the camera goes on turning at its last rate"
        );
        return Ok(None);
    }
    Ok(Some(find_guard(configuration.guard.program.as_deref())?))
}

/// The guard's program for the boat's port: whatever the boat does at the end of the program, the guard sends neutral.
///
/// # Errors
/// If the guard is not there, and the operator has not said that the run does without it.
fn needed_vessel_guard(configuration: &Configuration) -> Result<Option<PathBuf>> {
    match &configuration.vessel {
        Some(vessel) if vessel.settings().path == CommandPath::Link => {}
        _ => return Ok(None),
    }
    if configuration.guard.is_omitted {
        tracing::warn!(
            "no guard: if this program is killed, crashes or hangs, the boat goes on until its own time-out"
        );
        return Ok(None);
    }
    Ok(Some(find_guard(configuration.guard.program.as_deref())?))
}

/// The tracking camera on a MAVLink link, where one is asked for.
///
/// # Errors
/// If the address or the key of signed packets cannot be used.
fn tracking_camera(
    configuration: &Configuration,
    source: &Source,
    clock: Clock,
) -> Result<Option<TrackingCameraSetup>> {
    let config = &configuration.tracking_camera;
    let Some(url) = &config.url else { return Ok(None) };
    let camera = &configuration.profile.camera;
    let field_of_view = Angle::from_radians(2.0 * (0.5 / camera.focal_share).atan());
    let stream = source.stream_address().and_then(|address| {
        let stream = VideoStream::new(address, Some(field_of_view.degrees().round() as u16));
        if stream.is_none() {
            tracing::warn!("ground stations are not told of the video: its address is longer than 159 bytes");
        }
        stream
    });
    let number = |text: &str| text.parse().unwrap_or(0);
    Ok(Some(TrackingCameraSetup {
        endpoint: tracking_camera::endpoint(url).context("--mavlink, or tracking_camera.url")?,
        settings: config.settings,
        description: CameraDescription {
            model: configuration.profile.name.clone(),
            version: [
                number(env!("CARGO_PKG_VERSION_MAJOR")),
                number(env!("CARGO_PKG_VERSION_MINOR")),
                number(env!("CARGO_PKG_VERSION_PATCH")),
            ],
            stream,
        },
        signing: secrets::mavlink_signing(config.signing_key_file.as_deref(), clock)?,
        display_delay: config.display_delay,
    }))
}

/// The second video of a run, if there is one.
fn second_source(configuration: &Configuration) -> Result<Option<Source>> {
    let Some(second) = &configuration.second_video else { return Ok(None) };
    let url = secrets::second_source_url(&second.url, &configuration.video_login)?;
    if let SourceUrl::Simulated(url) = &url {
        bail!("{url} cannot be the second video: one world is simulated; give it as the first --video");
    }
    Source::load(url, secrets::trust(&configuration.video_trust)?).map(Some)
}

/// The kinds of faults that have an effect on a link.
const LINK_FAULTS: [FaultKind; 4] =
    [FaultKind::Stall, FaultKind::Drop, FaultKind::Disconnect, FaultKind::Panic];
/// The kinds of faults that have an effect on a source of video.
const VIDEO_FAULTS: [FaultKind; 7] = [
    FaultKind::Stall,
    FaultKind::Drop,
    FaultKind::Delay,
    FaultKind::Duplicate,
    FaultKind::Corrupt,
    FaultKind::Disconnect,
    FaultKind::Panic,
];

/// The faults of the command line and of the file of faults, each at its place.
fn injected_faults(
    args: &RunArgs,
    mut link: Option<&mut LinkUrl>,
    source: &mut SourceUrl,
) -> Result<FaultInjector> {
    let mut injector = FaultInjector::parse(&args.fault)?;
    if let Some(path) = &args.faults {
        let context = || format!("the file of faults {} is not usable", path.display());
        let text =
            String::from_utf8(input::read(path)?).context("it is not UTF-8 text").with_context(context)?;
        for placed in parse_fault_lines(&text).with_context(context)? {
            let Some(placed) = injector.add(placed).with_context(context)? else { continue };
            match (placed.place.as_str(), &mut link) {
                ("link", Some(link)) => link.faults.extend(placed.plan),
                ("link", None) => bail!("{}: there is no link: give --link", context()),
                ("video", _) => source.faults_mut().extend(placed.plan),
                (place, _) => bail!(
                    "{}: {place:?} is no place: use link, video, program, or one of the threads {FAULT_THREADS:?}",
                    context()
                ),
            }
        }
    }
    if let Some(link) = link {
        link.faults.require_effect("the link", &LINK_FAULTS)?;
    }
    source.faults_mut().require_effect("the video", &VIDEO_FAULTS)?;
    Ok(injector)
}

/// A calibration that was run: the configuration that was in force, and what was measured (`None`: nothing).
pub struct CalibrationRun {
    /// The configuration.
    pub configuration: Configuration,
    /// What was measured.
    pub result: Option<CalibrationResult>,
}

/// Runs the test motions of a calibration.
///
/// # Errors
/// If the configuration, the video or the link cannot be used, or the run failed.
pub fn calibrate(
    args: &CalibrateAxesArgs,
    record: Option<OutputFile>,
    clock: Clock,
) -> Result<CalibrationRun> {
    let mut file = args.connection.config_file()?;
    let override_key = |key: &mut Option<String>, value: &Option<String>| {
        if let Some(value) = value {
            *key = Some(value.clone());
        }
    };
    override_key(&mut file.link.url, &args.connection.link);
    override_key(&mut file.vehicle.profile, &args.profile);
    let latency_is_known = file.vehicle.video_latency_s.is_some();
    let mut configuration = Configuration::resolve(&file).context("the configuration is not usable")?;
    let Some(video) = &configuration.video else {
        return Err(UsageError(
            "no video source: give --video, or video.url in the configuration".to_owned(),
        )
        .into());
    };
    if configuration.second_video.is_some() {
        return Err(UsageError("a calibration turns one camera: omit the second video".to_owned()).into());
    }
    let Some(link) = configuration.link.as_deref().map(LinkUrl::parse).transpose()? else {
        return Err(UsageError("no link: give --link, or link.url in the configuration".to_owned()).into());
    };
    let source = secrets::source_url(video, &configuration.video_login)?;
    let source = Source::load(source, secrets::trust(&configuration.video_trust)?)?;
    if source.world().is_none() && link.endpoint == Endpoint::SimulatedCamera {
        bail!("--link sim: moves the camera of a simulated world: give --video sim:SCENARIO with it");
    }
    if let Some(world) = source.world().filter(|_| !latency_is_known) {
        configuration.profile.video_latency = world.scenario().camera.latency();
        let camera = &world.scenario().camera;
        // A calibrated lens has its own focal length.
        if configuration.profile.camera.lens.is_none() {
            configuration.profile.camera.focal_share = camera.optics.focal_px / f64::from(camera.frame.width);
        }
    }
    let http = vehicle_over_http(&configuration, Some(&link))?;
    let guard = needed_guard(&configuration, Some(&link))?;
    let calibration = LiveCalibration::new(configuration.profile.camera.focal_share);
    let session = Session {
        pilot: build_pilot(&configuration, command_path(Some(&link)))?,
        configuration: &configuration,
        sources: Videos::one(source),
        link: Some(link),
        guard,
        vessel_guard: None,
        http,
        outputs: Outputs { record, ..Outputs::default() },
        selection: None,
        waits_for_selection: true,
        console: None,
        tracking_camera: None,
        engage: false,
        calibration: Some(calibration.clone()),
        fault_injector: FaultInjector::default(),
        clock,
    };
    match session.run()? {
        RunEnd::Failed(why) => bail!("{why}"),
        RunEnd::Requested(_) | RunEnd::VideoEnded => {
            let result = calibration.with_recorder(CalibrationRecorder::result);
            Ok(CalibrationRun { configuration, result })
        }
    }
}

/// Opens the console's socket. A live run always asks for a token: any program of this machine could reach the socket.
fn open_console(args: &RunArgs, config: &ConsoleConfig) -> Result<ConsoleSettings> {
    let options = &args.console;
    let token_file = options.console_token_file.as_deref().or(config.token_file.as_deref());
    let console = ConsoleSettings::with_tokens(options.listen.or(config.listen), token_file)?;
    let on_lost = options.on_console_lost.unwrap_or(config.on_lost);
    let links_file = args.links_file.clone();
    Ok(ConsoleSettings { on_lost, links_file, host_names: config.hosts.clone(), ..console })
}

/// Opens the output files that the arguments name.
fn open_outputs(args: &RunArgs, recording: &RecordingConfig) -> Result<Outputs> {
    let open =
        |path: &Option<PathBuf>| path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose();
    let mut outputs = Outputs {
        record: open(&args.record)?,
        overlay: open(&args.overlay)?,
        foxglove: args.foxglove,
        ..Outputs::default()
    };
    if outputs.record.is_none() && recording.enabled && !args.no_record {
        match recording_folder::open_next(recording) {
            Ok(file) => {
                tracing::info!("recording to {}; --no-record switches this off", file.path().display());
                outputs.record = Some(file);
                outputs.reserve = Some(DiskReserve::new(&recording.folder, recording.reserve_gb));
            }
            // A recording that nobody asked for must not keep the boat from being followed.
            Err(error) => {
                tracing::error!("this run is not recorded: {error:#}");
                outputs.not_recorded = Some(format!("{error:#}"));
            }
        }
    }
    Ok(outputs)
}

/// The configuration of a run: the file, overridden by the command line. The flag tells whether the file states the
/// latency of the video.
fn effective_configuration(args: &RunArgs) -> Result<(Configuration, bool)> {
    let connection = &args.connection;
    let mut file = connection.config_file()?;
    let override_key = |key: &mut Option<String>, value: &Option<String>| {
        if let Some(value) = value {
            *key = Some(value.clone());
        }
    };
    override_key(&mut file.link.url, &connection.link);
    override_key(&mut file.vehicle.profile, &args.profile);
    override_key(&mut file.tracking_camera.url, &args.mavlink);
    override_key(&mut file.vessel.url, &args.vessel);
    override_key(&mut file.vessel.profile, &args.vessel_profile);
    file.vessel.guidance = args.guidance.or(file.vessel.guidance);
    if file.vessel.url.is_none() && (args.vessel_profile.is_some() || args.guidance.is_some()) {
        bail!(
            "--vessel-profile and --guidance are about a boat, and none is named: give its address (--vessel URL, or vessel.url of the configuration)"
        );
    }
    if args.guard.is_some() {
        file.link.guard.clone_from(&args.guard);
    }
    if args.without_guard {
        file.link.without_guard = Some(true);
    }
    file.tracker.name = args.tracker.or(file.tracker.name);
    let context = || {
        UnusableConfiguration(match &connection.config {
            Some(path) => format!("the configuration {}", path.display()),
            None => "the command line".to_owned(),
        })
    };
    let latency_is_known = file.vehicle.video_latency_s.is_some();
    let mut configuration = Configuration::resolve(&file).with_context(context)?;
    configuration.law = args.law.resolve(configuration.law)?;
    Ok((configuration, latency_is_known))
}

/// A pilot for a configuration, with its tracker, whose commands take this path.
///
/// # Errors
/// If the tracker's settings lie outside their ranges.
pub fn build_pilot(configuration: &Configuration, path: CommandPath) -> Result<Pilot> {
    let settings =
        PilotSettings { profile: configuration.profile.clone(), law: configuration.law.settings() };
    let pilot = Pilot::new(settings, configuration.tracker.build()?).keeping_frames().commanding(path);
    Ok(match &configuration.vessel {
        Some(vessel) => pilot.with_vessel(vessel.settings()),
        None => pilot,
    })
}
