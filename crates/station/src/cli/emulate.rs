//! The arguments of `emulate`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand, ValueEnum};

use super::values::parse_positive;

/// `emulate`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman emulate fotokite-pro --pty /tmp/fotokite")]
pub struct EmulateArgs {
    /// The vehicle.
    #[command(subcommand)]
    pub station: StationName,
}

/// The vehicles that can be emulated.
#[derive(Debug, Subcommand)]
pub enum StationName {
    /// The Fotokite Pro's serial ground station.
    FotokitePro(EmulateFotokiteProArgs),
    /// An autopilot with a MAVLink gimbal.
    Gimbal(EmulateGimbalArgs),
}

/// `emulate fotokite-pro`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman emulate fotokite-pro --pty /tmp/fotokite --log station.jsonl
and in another terminal
  barrelman run --video file:clip.mp4 --select 293,138,48,23 --engage \\
    --link serial:/tmp/fotokite

With --world the emulator moves the camera of a simulated world and serves its
video:
  barrelman emulate fotokite-pro --pty /tmp/fotokite --world sim:arena1
and in another terminal
  barrelman run --video rtsp://127.0.0.1:8554/world \\
    --link serial:/tmp/fotokite")]
#[group(skip)]
#[command(group = ArgGroup::new("port").required(true).args(["pty", "listen"]))]
pub struct EmulateFotokiteProArgs {
    /// Create a pseudo-terminal with a symbolic link at this path. A link that a killed emulator left is replaced.
    #[arg(long, value_name = "PATH")]
    pub pty: Option<PathBuf>,
    /// Listen on this address, as the pass-through server does (TCP).
    #[arg(long, value_name = "ADDR", conflicts_with = "pty")]
    pub listen: Option<String>,
    /// World, log and faults.
    #[command(flatten)]
    pub emulator: EmulatorOptions,
    /// End a rate this long after the last command for its axis, seconds; default: never.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub rate_timeout: Option<f64>,
    /// Keep the rates in force after `stop`: the worst that a real ground station may do.
    #[arg(long)]
    pub stop_keeps_rates: bool,
    /// Do not echo the shell's input.
    #[arg(long)]
    pub no_echo: bool,
}

/// The options of every emulator.
#[derive(Debug, Args)]
pub struct EmulatorOptions {
    /// Move the camera of this simulated world, and serve its video: sim:SCENARIO?seed=1&size=WxH. The world starts with
    /// the first viewer.
    #[arg(long, value_name = "SIM")]
    pub world: Option<String>,
    /// Address of the world's video (RTSP, path /world).
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8554")]
    pub video_listen: SocketAddr,
    /// Log every line and state to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Inject faults: KIND@SECONDS[+DURATION], several with commas. KIND: stall, drop, delay, duplicate, corrupt,
    /// disconnect, reboot, takeover, silence or cut. Times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// Overwrite an existing log, and replace a symbolic link at the path of --pty.
    #[arg(long)]
    pub force: bool,
}

/// `emulate gimbal`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman emulate gimbal --world sim:arena1
and in another terminal
  barrelman run --video rtsp://127.0.0.1:8554/world \\
    --profile mavlink-gimbal --link udp://127.0.0.1:14560")]
pub struct EmulateGimbalArgs {
    /// Take packets at this address: udp://host:port or tcp://host:port.
    #[arg(long, value_name = "URL", default_value = "udp://127.0.0.1:14560")]
    pub listen: String,
    /// Whose habits: ardupilot obeys everybody and keeps a rate for ever, px4 obeys the primary control alone.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub habits: HabitsName,
    /// Do not answer requests for the gimbal's information.
    #[arg(long)]
    pub withhold_information: bool,
    /// Deny every claim of the control.
    #[arg(long)]
    pub deny_claims: bool,
    /// Lose this number of claims.
    #[arg(long, value_name = "N", default_value_t)]
    pub drop_claims: u32,
    /// World, log and faults.
    #[command(flatten)]
    pub emulator: EmulatorOptions,
}

/// Whose habits an emulated gimbal manager has.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum HabitsName {
    /// ArduPilot's.
    #[default]
    Ardupilot,
    /// PX4's.
    Px4,
}
