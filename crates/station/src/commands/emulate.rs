//! `barrelman emulate`: an emulated vehicle.

use std::io::{Write as _, stdout};
use std::net::SocketAddr;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use barrelman_emulators::boat::{EmulatedBoat, Helm};
use barrelman_emulators::camera_link::CameraLink;
use barrelman_emulators::emulated_port::EmulatedPort;
use barrelman_emulators::emulated_vehicle::EmulatedVehicle;
use barrelman_emulators::emulation_loop::{EMULATOR_FAULTS, Emulator};
use barrelman_emulators::fotokite_pro::{FotokitePro, GroundStationSettings};
use barrelman_emulators::fotokite_sigma::{
    EmulatedSigma, EmulatedSigmaSettings, SIGMA_FAULTS, SigmaSettings,
};
use barrelman_emulators::log::StationLog;
use barrelman_emulators::mavlink_gimbal::{CameraKind, GimbalManagerSettings, Habits, MavlinkGimbal};
use barrelman_emulators::onvif::{
    CameraFaults, CameraSettings, EmulatedCamera, EmulatedCameraSettings, FullSpeeds, ONVIF_FAULTS,
    example_speeds,
};
use barrelman_emulators::rtsp_server::RtspServer;
use barrelman_emulators::simulated_boat::SimulatedBoat;

use crate::cli::{
    BoatName, CameraKindName, EmulateArgs, EmulateFotokiteProArgs, EmulateFotokiteSigmaArgs,
    EmulateGimbalArgs, EmulateOnvifArgs, EmulateVesselArgs, HabitsName, StationName, WorldArgs,
};
use crate::interruption::flag_of_signals;
use crate::secrets;
use crate::simulated_source::{LiveWorld, spawn_world};
use crate::source_url::{SimulatedUrl, SourceUrl};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_host::output;
use barrelman_video::VideoHandle;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};
use barrelman_vocab::{AngularRate, Timestamp, VehicleProfile};
use jiff::SignedDuration;

/// Runs the command.
///
/// # Errors
/// If the world, the port or the log cannot be opened.
pub fn run(args: &EmulateArgs, clock: Clock) -> Result<ExitCode> {
    match &args.station {
        StationName::FotokitePro(args) => fotokite_pro(args, clock),
        StationName::FotokiteSigma(args) => fotokite_sigma(args, clock),
        StationName::Gimbal(args) => gimbal(args, clock),
        StationName::Onvif(args) => onvif(args, clock),
        StationName::Vessel(args) => vessel(args, clock),
    }
}

fn fotokite_pro(args: &EmulateFotokiteProArgs, clock: Clock) -> Result<ExitCode> {
    let world = ServedWorld::open(&args.world, &VehicleProfile::fotokite_pro())?;
    let port = match (&args.pty, &args.listen) {
        (Some(path), _) => EmulatedPort::pty(path, args.force)?,
        (None, Some(address)) => EmulatedPort::listen(address)?,
        (None, None) => bail!("no port: give --pty PATH or --listen ADDR"),
    };
    let settings = GroundStationSettings {
        echo: !args.no_echo,
        rate_timeout: args.rate_timeout.map(Duration::from_secs_f64),
        stop_keeps_rates: args.stop_keeps_rates,
    };
    let emulation = Emulation {
        world,
        log: args.log.as_deref(),
        force: args.force,
        fault: args.fault.as_deref(),
        loss_share: 0.0,
    };
    emulate(FotokitePro::new(settings, clock.now()), port, emulation, clock)
}

fn gimbal(args: &EmulateGimbalArgs, clock: Clock) -> Result<ExitCode> {
    let world = ServedWorld::open(&args.world, &VehicleProfile::mavlink_gimbal())?;
    let port = match (&args.pty, args.listen.split_once("://")) {
        (Some(path), _) => EmulatedPort::pty(path, args.force)?,
        (None, Some(("udp", address))) => EmulatedPort::datagrams(address)?,
        (None, Some(("tcp", address))) => EmulatedPort::listen(address)?,
        (None, _) => bail!("--listen {}: give udp://host:port or tcp://host:port", args.listen),
    };
    let settings = GimbalManagerSettings {
        habits: match args.habits {
            HabitsName::Ardupilot => Habits::ArduPilot,
            HabitsName::Px4 => Habits::Px4,
        },
        withholds_information: args.withhold_information,
        withholds_status: args.withhold_status,
        denies_claims: args.deny_claims,
        dropped_claims: args.drop_claims,
        camera: match args.camera {
            CameraKindName::Zooming => CameraKind::Zooming,
            CameraKindName::Fixed => CameraKind::Fixed,
            CameraKindName::Silent => CameraKind::Silent,
        },
        signing: secrets::mavlink_signing(args.signing_key_file.as_deref(), clock)?,
        ..GimbalManagerSettings::default()
    };
    let video = world.as_ref().map(|world| world.server.url());
    let emulation = Emulation {
        world,
        log: args.log.as_deref(),
        force: args.force,
        fault: args.fault.as_deref(),
        loss_share: args.loss / 100.0,
    };
    emulate(MavlinkGimbal::new(settings, video, clock.now()), port, emulation, clock)
}

fn vessel(args: &EmulateVesselArgs, clock: Clock) -> Result<ExitCode> {
    // The camera of the world stays at rest.
    let world = ServedWorld::open(&args.world, &VehicleProfile::fotokite_pro())?;
    let log = args.log.as_ref().map(|path| output::create(path, args.force)).transpose()?;
    let ended = flag_of_signals()?;
    let boat = world.as_ref().map(|world| world.boat.clone());
    let (port, helm) = match args.boat {
        BoatName::LabUdp => (5007, Helm::laboratory(args.keep_last)),
        BoatName::MavlinkRover => {
            let sticks_at = args.sticks_after.map(|after| clock.now().plus(Duration::from_secs_f64(after)));
            (14570, Helm::rover(!args.disarmed, sticks_at, clock.now()))
        }
    };
    let address = args.listen.unwrap_or(SocketAddr::from(([127, 0, 0, 1], port)));
    let mut vessel = EmulatedBoat::open(address, helm, boat, log, clock)?;
    if vessel.is_public() {
        tracing::warn!("other machines can steer the emulated boat: the port asks for no password");
    }
    let answers = format!("an emulated boat takes datagrams at {}", vessel.url()?);
    serve(&answers, world, &ended, clock, |is_over| vessel.run(is_over))
}

/// What surrounds an emulated vehicle at a port.
struct Emulation<'a> {
    world: Option<ServedWorld>,
    log: Option<&'a Path>,
    /// Whether an existing log is overwritten.
    force: bool,
    fault: Option<&'a str>,
    /// Share of the packets that get lost.
    loss_share: f64,
}

/// Runs the emulator of a vehicle at a port.
fn emulate<V: EmulatedVehicle>(
    vehicle: V,
    port: EmulatedPort,
    emulation: Emulation<'_>,
    clock: Clock,
) -> Result<ExitCode> {
    let Emulation { world, log, force, fault, loss_share } = emulation;
    if port.is_public() {
        tracing::warn!("other machines can move the emulated camera: the port asks for no password");
    }
    let log = log.map(|path| output::create(path, force)).transpose()?;
    let faults = FaultPlan::parse(fault.unwrap_or_default())?;
    faults.require_effect("the emulator", &EMULATOR_FAULTS)?;
    let ended = flag_of_signals()?;
    let mut emulator =
        Emulator::new(port, vehicle, StationLog::new(log, clock), faults, clock).with_loss(loss_share);
    if let Some(world) = &world {
        emulator = emulator.with_world(world.link.clone());
    }
    let answers = format!("an emulated {} answers at {}", V::NAME, emulator.url());
    serve(&answers, world, &ended, clock, |is_over| emulator.run(is_over))
}

fn fotokite_sigma(args: &EmulateFotokiteSigmaArgs, clock: Clock) -> Result<ExitCode> {
    let world = ServedWorld::open(&args.world, &VehicleProfile::fotokite_sigma())?;
    let log = args.log.as_ref().map(|path| output::create(path, args.force)).transpose()?;
    let faults = FaultPlan::parse(args.fault.as_deref().unwrap_or_default())?;
    faults.require_effect("the emulator", &SIGMA_FAULTS)?;
    let example = SigmaSettings::example();
    let sigma = SigmaSettings {
        token: args.token.clone(),
        read_token: format!("{}-read", args.token),
        api_key: format!("{}-key", args.token),
        rtsp_url: world.as_ref().map(|world| world.server.url()),
        field_of_view_deg: world.as_ref().map_or(example.field_of_view_deg, |world| world.field_of_view_deg),
        ..example
    };
    let ended = flag_of_signals()?;
    let settings = EmulatedSigmaSettings {
        sigma,
        has_websocket: !args.no_websocket,
        world: world.as_ref().map(|world| world.link.clone()),
        faults,
        log,
        clock,
    };
    let emulator = EmulatedSigma::start(args.listen, settings)?;
    if emulator.is_public() {
        tracing::warn!("other machines can move the emulated camera: the token is on the command line");
    }
    let answers = format!("an emulated Fotokite Sigma answers at {}", emulator.url());
    serve(&answers, world, &ended, clock, |is_over| emulator.run(is_over))
}

fn onvif(args: &EmulateOnvifArgs, clock: Clock) -> Result<ExitCode> {
    let world = ServedWorld::open(&args.world, &VehicleProfile::onvif_ptz())?;
    let log = args.log.as_ref().map(|path| output::create(path, args.force)).transpose()?;
    let faults = FaultPlan::parse(args.fault.as_deref().unwrap_or_default())?;
    faults.require_effect("the emulator", &ONVIF_FAULTS)?;
    let &[least, most] = args.timeouts.as_slice() else { bail!("--timeouts takes two numbers") };
    let seconds = |value: f64| Duration::try_from_secs_f64(value).context("--timeouts is unusable");
    let example = CameraSettings::example();
    let camera = CameraSettings {
        login: args.login_file.as_deref().map(secrets::camera_login).transpose()?,
        video: world.as_ref().map_or(example.video, |world| world.server.url()),
        timeouts: (seconds(least)?, seconds(most)?),
        full: FullSpeeds { zoom: example.full.zoom.filter(|_| !args.no_zoom), ..example.full },
        tells_position: !args.no_position,
        knows_services: !args.old,
        clock: jiff::Timestamp::now()
            .checked_sub(SignedDuration::try_from(clock.now().since(Timestamp::ZERO))?)?,
        ..example
    };
    let linear = SpeedCurve::linear(AngularRate::from_radians_per_second(1.0));
    let settings = EmulatedCameraSettings {
        camera,
        habits: CameraFaults {
            ignores_timeouts: args.ignore_timeouts,
            ignores_stops: args.ignore_stops,
            clock_ahead_s: args.clock_ahead,
            ..CameraFaults::default()
        },
        speeds: if args.linear { AxisSpeeds { pan: linear.clone(), tilt: linear } } else { example_speeds() },
        wants_http_digest: args.http_digest,
        world: world.as_ref().map(|world| world.link.clone()),
        faults,
        log,
        clock,
    };
    let ended = flag_of_signals()?;
    let emulator = EmulatedCamera::start(args.listen, settings)?;
    if emulator.is_public() {
        tracing::warn!("other machines can move the emulated camera");
    }
    let answers = format!("an emulated ONVIF camera answers at {}", emulator.url());
    serve(&answers, world, &ended, clock, |is_over| emulator.run(is_over))
}

/// Says where the emulator answers, and runs the emulator until a signal asks to end or its world fails.
fn serve(
    answers: &str,
    mut world: Option<ServedWorld>,
    ended: &AtomicBool,
    clock: Clock,
    run: impl FnOnce(&mut dyn FnMut() -> bool) -> Result<()>,
) -> Result<ExitCode> {
    if let Some(world) = &world {
        writeln!(
            stdout(),
            "the world's video is at {}; the world starts with the first viewer",
            world.server.url()
        )?;
    }
    // Scripts wait for this line before they connect.
    writeln!(stdout(), "{answers}")?;
    stdout().flush()?;
    let mut failure = None;
    run(&mut || {
        let has_world_failed = world.as_mut().is_some_and(|world| {
            world.update(clock).unwrap_or_else(|error| {
                failure = Some(error);
                true
            })
        });
        has_world_failed || ended.load(Ordering::Relaxed)
    })?;
    failure.map_or(Ok(ExitCode::SUCCESS), Err)
}

/// A simulated world with a server of its video.
struct ServedWorld {
    server: RtspServer,
    link: CameraLink,
    boat: SimulatedBoat,
    /// Horizontal field of view, degrees.
    field_of_view_deg: f64,
    url: SimulatedUrl,
    /// The world, until the first viewer starts it.
    waiting: Option<LiveWorld>,
    running: Option<VideoHandle>,
}

impl ServedWorld {
    /// The world of the command line, if there is one.
    fn open(args: &WorldArgs, profile: &VehicleProfile) -> Result<Option<Self>> {
        let Some(url) = args.world.as_deref() else { return Ok(None) };
        let url = match SourceUrl::parse(url)? {
            SourceUrl::Simulated(url) => url,
            SourceUrl::Video(url) => {
                bail!("--world takes a simulated world, as in sim:arena1; {url} is a video")
            }
        };
        let world = LiveWorld::load(&url.world)?.with_encoding(true);
        // The zoom of the emulated camera is the world's.
        let zoom = world.scenario().mount.zoom;
        let world = world.with_profile(&VehicleProfile { zoom, ..profile.clone() });
        let camera = &world.scenario().camera;
        let half_width = f64::from(camera.frame.width) / 2.0;
        let field_of_view_deg = 2.0 * (half_width / camera.optics.focal_px).atan().to_degrees();
        let (link, boat) = (world.link(), world.boat());
        if !args.video_listen.ip().is_loopback() {
            tracing::warn!("other machines can see the world's video at {}", args.video_listen);
        }
        let server = RtspServer::start(args.video_listen)?;
        Ok(Some(Self { server, link, boat, field_of_view_deg, url, waiting: Some(world), running: None }))
    }

    /// Starts the world once there is a viewer. Returns whether the world has failed: it has no end.
    fn update(&mut self, clock: Clock) -> Result<bool> {
        if self.server.is_wanted()
            && let Some(world) = self.waiting.take()
        {
            tracing::info!("first viewer: the world starts");
            self.running = Some(spawn_world(world, &self.url, clock, self.server.sink())?);
        }
        Ok(self.running.as_ref().is_some_and(VideoHandle::is_finished))
    }
}
