//! `barrelman run`: one live run. This file reads the arguments and reports the end; `live::session` is the
//! run.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use barrelman_console_server::{
    AfterPicking, ConsoleAddress, ConsoleSettings, Encryption, TokenDoor, TokensInForce,
};
use barrelman_pilot::{CommandPath, Pilot, PilotSettings};

use super::draw_selection::{draw_selection, has_display};
use super::tak_route::tak_route;
use crate::cli::RunArgs;
use crate::config::{Configuration, ConsoleConfig, RecordingConfig, UnusableConfiguration};
use crate::detector::DetectorSetup;
use crate::link::{LinkUrl, command_path, vehicle_over_http};
use crate::live::foxglove_server::FoxgloveEntrance;
use crate::live::recorder::Extras;
use crate::live::recording_folder::{self, DiskReserve};
use crate::live::run_loop::RunEnd;
use crate::live::session::{Outputs, Session};
use crate::live::source::Source;
use crate::secrets;
use crate::share::ShareSetup;
use crate::tak::TakSetup;
use crate::tracking_camera::{self, TrackingCameraSetup};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_vocab::Videos;
use barrelman_vocab::{Angle, PixelBox};
use barrelman_wire::mavlink::tracking_camera::{CameraDescription, VideoStream};

mod faults;
pub(super) mod guards;
pub(super) mod sources;

use faults::injected_faults;
use guards::{needed_guard, needed_vessel_guard};
use sources::{ensure_camera_has_world, first_source, second_source};

/// Runs the command.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run(args: &RunArgs, clock: Clock) -> Result<ExitCode> {
    run_with_outputs(args, |recording, foxglove| open_outputs(args, recording, foxglove), clock)
}

/// Runs the command with the outputs of `open`, instead of those that the arguments name.
///
/// # Errors
/// If the configuration, the video, the link or an output cannot be used.
pub fn run_with_outputs(
    args: &RunArgs,
    open: impl FnOnce(&RecordingConfig, Option<FoxgloveEntrance>) -> Result<Outputs>,
    clock: Clock,
) -> Result<ExitCode> {
    let (mut configuration, latency_is_known) = effective_configuration(args)?;
    let mut link = configuration.link.as_deref().map(LinkUrl::parse).transpose()?;
    let http = vehicle_over_http(&configuration, link.as_ref())?;
    let mut source = first_source(args, &mut configuration, http.as_ref())?;
    let fault_injector = injected_faults(args, link.as_mut(), &mut source)?;
    let source = Source::load(source, secrets::trust(&configuration.video_trust)?)?;
    let second_source = second_source(&configuration)?;
    ensure_camera_has_world(link.as_ref(), &source)?;
    if let Some(world) = source.world().filter(|_| !latency_is_known) {
        configuration.profile.video_latency = world.scenario().camera.latency();
    }
    let tracking_camera = tracking_camera(&configuration, &source, clock)?;
    let tak = tak(&configuration)?;
    let guard = needed_guard(&configuration, link.as_ref())?;
    let vessel_guard = needed_vessel_guard(&configuration)?;
    let console = (!args.headless).then(|| open_console(args, &configuration.console)).transpose()?;
    let share = share(&configuration, console.as_ref())?;
    let foxglove = foxglove(args, &configuration.console, console.as_ref(), clock)?;
    let detector = configuration.detector.as_ref().map(DetectorSetup::load).transpose();
    let detector = detector.context("--detector, or detector.model")?;
    let pilot = build_pilot(&configuration, command_path(link.as_ref()))?;
    let selection = match args.select {
        None => drawn_selection(args, &source, console.as_ref())?,
        selection => selection,
    };
    // The last to be opened: making room for a recording removes older ones.
    let outputs = open(&configuration.recording, foxglove)?;
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
        tak,
        share,
        detector,
        engage: args.engage,
        calibration: None,
        fault_injector,
        clock,
    };
    session.run().map(reported)
}

/// Reports the end of a run. Returns the exit code of the program.
fn reported(end: RunEnd) -> ExitCode {
    match end {
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
    }
}

/// The box that the operator draws in the first frame of a file, before anything is opened that moves or
/// records. A file with `--hands-on` plays on while the operator selects, as a stream does.
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

/// Where events for TAK go, where they are asked for.
///
/// # Errors
/// If the host is not known, or a file of TLS is not usable.
fn tak(configuration: &Configuration) -> Result<Option<TakSetup>> {
    let Some(address) = &configuration.tak.address else { return Ok(None) };
    Ok(Some(TakSetup {
        route: tak_route(address, &configuration.tak).context("--tak, or tak.address")?,
        address: address.clone(),
        callsign: configuration.tak.callsign.clone(),
        vehicle: configuration.profile.name.clone(),
    }))
}

/// The socket of the annotated video, where it is asked for.
///
/// # Errors
/// If the tokens cannot be read, or the address cannot be served.
fn share(configuration: &Configuration, console: Option<&ConsoleSettings>) -> Result<Option<ShareSetup>> {
    let Some(address) = &configuration.share else { return Ok(None) };
    let setup = ShareSetup::open(address.clone(), tokens(&configuration.console, console)?);
    setup.context("--share, or share.address").map(Some)
}

/// Where Foxglove reads, where that is asked for: off loopback through a door with the encryption of the
/// console.
///
/// # Errors
/// If there are no tokens for other devices, or the address cannot be served.
fn foxglove(
    args: &RunArgs,
    config: &ConsoleConfig,
    console: Option<&ConsoleSettings>,
    clock: Clock,
) -> Result<Option<FoxgloveEntrance>> {
    let Some(address) = args.foxglove else { return Ok(None) };
    let at = ConsoleAddress { listen: Some(address), ..args.console.address(config.address.clone()) };
    if address.ip().is_loopback() && at.encryption != Encryption::Always {
        return Ok(Some(FoxgloveEntrance::Loopback(address)));
    }
    let door = TokenDoor::open(at, tokens(config, console)?, clock);
    door.with_context(|| format!("--foxglove {address}")).map(|door| Some(FoxgloveEntrance::Door(door)))
}

/// The tokens that other devices show: the console's, or without a console those of the file, where one is
/// named.
///
/// # Errors
/// If they cannot be read.
fn tokens(config: &ConsoleConfig, console: Option<&ConsoleSettings>) -> Result<TokensInForce> {
    let kept = &config.tokens;
    Ok(match console {
        Some(console) => console.tokens.clone(),
        None if kept.file.is_some() => TokensInForce::new(Some(kept.take()?)),
        None => TokensInForce::default(),
    })
}

/// Opens the console's socket. A live run always asks for a token: any program of this machine could reach
/// the socket.
fn open_console(args: &RunArgs, config: &ConsoleConfig) -> Result<ConsoleSettings> {
    let options = &args.console;
    let tokens = options.kept_tokens(config.tokens.clone());
    let mut console = ConsoleSettings::with_tokens(options.address(config.address.clone()), tokens)?;
    console.map = options.open_map(config.map.as_deref())?;
    console.on_lost = options.on_console_lost.unwrap_or(config.on_lost);
    console.links_file.clone_from(&args.links_file);
    Ok(console)
}

/// Opens the output files that the arguments name.
fn open_outputs(
    args: &RunArgs,
    recording: &RecordingConfig,
    foxglove: Option<FoxgloveEntrance>,
) -> Result<Outputs> {
    let open =
        |path: &Option<PathBuf>| path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose();
    let makes_recording = recording.enabled && !args.no_record;
    if args.foxglove.is_some() && args.record.is_none() && !makes_recording {
        bail!("--foxglove shows what is recorded: give --record FILE.mcap, or set recording.enabled");
    }
    let live = foxglove.map(FoxgloveEntrance::serve).transpose()?;
    let mut outputs = Outputs {
        record: open(&args.record)?,
        overlay: open(&args.overlay)?,
        extras: Extras { live, ..Extras::default() },
        ..Outputs::default()
    };
    if outputs.record.is_none() && makes_recording {
        match recording_folder::open_next(recording) {
            Ok(file) => {
                tracing::info!("recording to {}; --no-record switches this off", file.path().display());
                outputs.record = Some(file);
                outputs.extras.reserve = Some(DiskReserve::new(&recording.folder, recording.reserve_gb));
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

/// What the command line names takes the place of what the file names.
pub(super) fn override_key<T: Clone>(key: &mut Option<T>, value: &Option<T>) {
    if let Some(value) = value {
        *key = Some(value.clone());
    }
}

/// The configuration of a run: the file, overridden by the command line. The flag tells whether the file
/// states the latency of the video.
fn effective_configuration(args: &RunArgs) -> Result<(Configuration, bool)> {
    let connection = &args.connection;
    let mut file = connection.config_file()?;
    override_key(&mut file.link.url, &connection.link);
    override_key(&mut file.vehicle.profile, &args.profile);
    override_key(&mut file.tracking_camera.url, &args.mavlink);
    override_key(&mut file.tak.address, &args.tak);
    override_key(&mut file.share.address, &args.share);
    override_key(&mut file.detector.model, &args.detector);
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
