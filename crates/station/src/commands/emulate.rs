//! `barrelman emulate`: an emulated vehicle.

use std::io::{Write as _, stdout};
use std::net::SocketAddr;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};

use barrelman_vocab::VehicleProfile;

use crate::cli::{
    EmulateArgs, EmulateFotokiteProArgs, EmulateGimbalArgs, EmulatorOptions, HabitsName, StationName,
};
use crate::emulator::emulated_port::EmulatedPort;
use crate::emulator::emulated_vehicle::EmulatedVehicle;
use crate::emulator::emulation_loop::Emulator;
use crate::emulator::fotokite_pro::{FotokitePro, GroundStationSettings};
use crate::emulator::log::StationLog;
use crate::emulator::mavlink_gimbal::{GimbalManagerSettings, Habits, MavlinkGimbal};
use crate::emulator::rtsp_server::RtspServer;
use crate::link::CameraLink;
use crate::simulated_source::{LiveWorld, spawn_world};
use crate::source_url::{SimulatedUrl, SourceUrl};
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_host::output;
use barrelman_video::VideoHandle;

/// The kinds of faults that the emulator has.
const EMULATOR_FAULTS: [FaultKind; 10] = [
    FaultKind::Stall,
    FaultKind::Drop,
    FaultKind::Delay,
    FaultKind::Duplicate,
    FaultKind::Corrupt,
    FaultKind::Disconnect,
    FaultKind::Reboot,
    FaultKind::Takeover,
    FaultKind::Silence,
    FaultKind::Cut,
];

/// Runs the command.
///
/// # Errors
/// If the world, the port or the log cannot be opened.
pub fn run(args: &EmulateArgs, clock: Clock) -> Result<ExitCode> {
    match &args.station {
        StationName::FotokitePro(args) => fotokite_pro(args, clock),
        StationName::Gimbal(args) => gimbal(args, clock),
    }
}

fn fotokite_pro(args: &EmulateFotokiteProArgs, clock: Clock) -> Result<ExitCode> {
    let port = match (&args.pty, &args.listen) {
        (Some(path), _) => EmulatedPort::pty(path, args.emulator.force)?,
        (None, Some(address)) => EmulatedPort::listen(address)?,
        (None, None) => bail!("no port: give --pty PATH or --listen ADDR"),
    };
    let settings = GroundStationSettings {
        echo: !args.no_echo,
        rate_timeout: args.rate_timeout.map(Duration::from_secs_f64),
        stop_keeps_rates: args.stop_keeps_rates,
    };
    emulate(FotokitePro::new(settings, clock.now()), port, &args.emulator, clock)
}

fn gimbal(args: &EmulateGimbalArgs, clock: Clock) -> Result<ExitCode> {
    let port = match args.listen.split_once("://") {
        Some(("udp", address)) => EmulatedPort::datagrams(address)?,
        Some(("tcp", address)) => EmulatedPort::listen(address)?,
        _ => bail!("--listen {}: give udp://host:port or tcp://host:port", args.listen),
    };
    let settings = GimbalManagerSettings {
        habits: match args.habits {
            HabitsName::Ardupilot => Habits::ArduPilot,
            HabitsName::Px4 => Habits::Px4,
        },
        withholds_information: args.withhold_information,
        denies_claims: args.deny_claims,
        dropped_claims: args.drop_claims,
    };
    emulate(MavlinkGimbal::new(settings, clock.now()), port, &args.emulator, clock)
}

/// Runs the emulator of a vehicle at a port.
fn emulate<V: EmulatedVehicle>(
    vehicle: V,
    port: EmulatedPort,
    options: &EmulatorOptions,
    clock: Clock,
) -> Result<ExitCode> {
    let world = |world: &str| ServedWorld::new(world, options.video_listen, vehicle.profile());
    let mut world = options.world.as_deref().map(world).transpose()?;
    if port.is_public() {
        tracing::warn!("other machines can move the emulated camera: the port asks for no password");
    }
    if world.is_some() && !options.video_listen.ip().is_loopback() {
        tracing::warn!("other machines can see the world's video at {}", options.video_listen);
    }
    let log = options.log.as_ref().map(|path| output::create(path, options.force)).transpose()?;
    let faults = FaultPlan::parse(options.fault.as_deref().unwrap_or_default())?;
    faults.require_effect("the emulator", &EMULATOR_FAULTS)?;
    let ended = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&ended))?;
    }
    let mut emulator = Emulator::new(port, vehicle, StationLog::new(log, clock), faults, clock);
    if let Some(world) = &world {
        writeln!(
            stdout(),
            "the world's video is at {}; the world starts with the first viewer",
            world.server.url()
        )?;
        emulator = emulator.with_world(world.link.clone());
    }
    // Scripts wait for this line before they connect.
    writeln!(stdout(), "an emulated {} answers at {}", V::NAME, emulator.url())?;
    stdout().flush()?;
    let mut failure = None;
    emulator.run(|| {
        let is_over = world.as_mut().is_some_and(|world| {
            world.update(clock).unwrap_or_else(|error| {
                failure = Some(error);
                true
            })
        });
        is_over || ended.load(Ordering::Relaxed)
    })?;
    failure.map_or(Ok(ExitCode::SUCCESS), Err)
}

/// A simulated world with a server of its video.
struct ServedWorld {
    server: RtspServer,
    link: CameraLink,
    url: SimulatedUrl,
    /// The world, until the first viewer starts it.
    waiting: Option<LiveWorld>,
    running: Option<VideoHandle>,
}

impl ServedWorld {
    fn new(url: &str, listen: SocketAddr, profile: &VehicleProfile) -> Result<Self> {
        let url = match SourceUrl::parse(url)? {
            SourceUrl::Simulated(url) => url,
            SourceUrl::Video(url) => {
                bail!("--world takes a simulated world, as in sim:arena1; {url} is a video")
            }
        };
        let world = LiveWorld::load(&url.world)?.with_profile(profile).with_encoding(true);
        let link = world.link();
        Ok(Self { server: RtspServer::start(listen)?, link, url, waiting: Some(world), running: None })
    }

    /// Starts the world once there is a viewer. Returns whether the world has ended.
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
