//! The arguments of `emulate`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand, ValueEnum};

use super::values::{parse_listen, parse_percent, parse_positive};

/// `emulate`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman emulate fotokite-pro --pty /tmp/fotokite")]
pub struct EmulateArgs {
    /// The ground station.
    #[command(subcommand)]
    pub station: StationName,
}

/// The ground stations that can be emulated.
#[derive(Debug, Subcommand)]
pub enum StationName {
    /// The Fotokite Pro's serial ground station.
    FotokitePro(EmulateFotokiteProArgs),
    /// The Fotokite Sigma's web API.
    FotokiteSigma(EmulateFotokiteSigmaArgs),
    /// An autopilot with a MAVLink gimbal.
    Gimbal(EmulateGimbalArgs),
    /// A PTZ camera with ONVIF's services.
    Onvif(EmulateOnvifArgs),
    /// A boat: that of the paper's laboratory, or one with an ArduPilot autopilot.
    Vessel(EmulateVesselArgs),
}

/// The boats that can be emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BoatName {
    /// A receiver of the laboratory's datagrams.
    LabUdp,
    /// An ArduPilot autopilot (MAVLink), in MANUAL and armed at the start.
    MavlinkRover,
}

/// `emulate vessel`.
#[derive(Debug, Args)]
#[command(after_help = "Example, with the boat of a simulated world:
  barrelman emulate vessel --world sim:rescue
and in another terminal
  barrelman run --video rtsp://127.0.0.1:8554/world \\
    --vessel udp://127.0.0.1:5007 --vessel-profile lab-udp --hands-on")]
pub struct EmulateVesselArgs {
    /// The boat.
    #[arg(long, value_enum, value_name = "NAME", default_value = "lab-udp")]
    pub boat: BoatName,
    /// Take datagrams at this address (UDP); default: 127.0.0.1:5007, and 127.0.0.1:14570 for a MAVLink boat.
    #[arg(long, value_name = "ADDR", value_parser = parse_listen)]
    pub listen: Option<SocketAddr>,
    /// MAVLink: the boat is not armed.
    #[arg(long)]
    pub disarmed: bool,
    /// MAVLink: the remote control's switch chooses MANUAL after this time, seconds; HOLD where the boat is
    /// in MANUAL.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub sticks_after: Option<f64>,
    /// Laboratory: keep the last command for ever, as the laboratory's receiver does; otherwise the boat is
    /// neutral half a second after the last datagram.
    #[arg(long)]
    pub keep_last: bool,
    /// The simulated world, if there is one.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Log every datagram and every change of the command to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Overwrite an existing log.
    #[arg(long)]
    pub force: bool,
}

/// `emulate fotokite-sigma`.
#[derive(Debug, Args)]
#[command(after_help = "Example, a closed loop with a simulated world:
  barrelman emulate fotokite-sigma --world sim:arena1
and in another terminal
  echo emulated > token && chmod 600 token
  barrelman run --profile fotokite-sigma --link http://127.0.0.1:3128/api \\
    --link-token-file token")]
pub struct EmulateFotokiteSigmaArgs {
    /// Listen on this address (HTTP).
    #[arg(long, value_name = "ADDR", value_parser = parse_listen, default_value = "127.0.0.1:3128")]
    pub listen: SocketAddr,
    /// The token that permits reading and control. The token `TEXT-read` permits reading alone, and the API
    /// key `TEXT-key` is exchanged for the token.
    #[arg(long, value_name = "TEXT", default_value = "emulated")]
    pub token: String,
    /// Offer no WebSocket: its path is not found.
    #[arg(long)]
    pub no_websocket: bool,
    /// The simulated world, if there is one.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Log every request and every change of the rates to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Inject faults: KIND@SECONDS[+DURATION], several with commas. KIND: takeover (another client has the
    /// control), reboot (status 503, and the control is forgotten), hang (requests wait until the end of the
    /// fault), silence (requests are carried out and not answered), delay (answers come 0.4 s late), corrupt
    /// (answers are damaged) or expire (the tokens have expired). Times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// Overwrite an existing log.
    #[arg(long)]
    pub force: bool,
}

/// `emulate onvif`.
#[derive(Debug, Args)]
#[command(after_help = "Example, with the camera of a simulated world:
  echo admin:emulated > login && chmod 600 login
  barrelman emulate onvif --login-file login --world sim:rescue
and in another terminal
  barrelman run --profile onvif-ptz --link onvif://127.0.0.1:8000 \\
    --link-login-file login")]
pub struct EmulateOnvifArgs {
    /// Listen on this address (HTTP).
    #[arg(long, value_name = "ADDR", value_parser = parse_listen, default_value = "127.0.0.1:8000")]
    pub listen: SocketAddr,
    /// File whose first line is the user:password that the camera asks for; default: it asks for none.
    #[arg(long, value_name = "FILE")]
    pub login_file: Option<PathBuf>,
    /// Ask for HTTP's digest, as profile T does; default: the digest in the message (WS-Security).
    #[arg(long, requires = "login_file")]
    pub http_digest: bool,
    /// Know GetCapabilities and not GetServices, as old cameras do.
    #[arg(long)]
    pub old: bool,
    /// Tell no position.
    #[arg(long)]
    pub no_position: bool,
    /// State no zoom.
    #[arg(long)]
    pub no_zoom: bool,
    /// Turn in proportion to the speed, 1 rad/s at the speed 1; default: with a dead zone, and faster at
    /// higher speeds.
    #[arg(long)]
    pub linear: bool,
    /// The least and the largest time-out of a motion, seconds.
    #[arg(long, value_name = "MIN,MAX", value_delimiter = ',', num_args = 2, default_value = "0.1,60")]
    pub timeouts: Vec<f64>,
    /// End no motion by its time-out.
    #[arg(long)]
    pub ignore_timeouts: bool,
    /// Answer Stop, and go on.
    #[arg(long)]
    pub ignore_stops: bool,
    /// The camera's clock is ahead by this many seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 0)]
    pub clock_ahead: i64,
    /// The simulated world, if there is one.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Log every request and every change of the rates to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Inject faults: KIND@SECONDS[+DURATION], several with commas. KIND: reboot (status 503, and the motion
    /// ends), hang (requests wait until the end of the fault), silence (requests are carried out and not
    /// answered), delay (answers come 0.4 s late), corrupt (answers are damaged) or expire (the login is
    /// refused). Times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// Overwrite an existing log.
    #[arg(long)]
    pub force: bool,
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
    /// Create a pseudo-terminal with a symbolic link at this path. A link that a killed emulator left is
    /// replaced.
    #[arg(long, value_name = "PATH")]
    pub pty: Option<PathBuf>,
    /// Listen on this address, as the pass-through server does (TCP).
    #[arg(long, value_name = "ADDR", conflicts_with = "pty")]
    pub listen: Option<String>,
    /// The simulated world, if there is one.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Log every line and state to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Inject faults: KIND@SECONDS[+DURATION], several with commas. KIND: stall, drop, delay, duplicate,
    /// corrupt, disconnect, reboot, takeover, silence or cut. Times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// End a rate this long after the last command for its axis, seconds; default: never.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub rate_timeout: Option<f64>,
    /// Keep the rates in force after `stop`: the worst that a real ground station may do.
    #[arg(long)]
    pub stop_keeps_rates: bool,
    /// Do not echo the shell's input.
    #[arg(long)]
    pub no_echo: bool,
    /// Overwrite an existing log, and replace a symbolic link at the path of --pty.
    #[arg(long)]
    pub force: bool,
}

/// `emulate gimbal`.
#[derive(Debug, Args)]
#[command(after_help = "Example, a closed loop with a simulated world:
  barrelman emulate gimbal --world sim:arena1
and in another terminal
  barrelman run --video rtsp://127.0.0.1:8554/world \\
    --profile mavlink-gimbal --link udp://127.0.0.1:14560")]
pub struct EmulateGimbalArgs {
    /// Take packets at this address: udp://host:port or tcp://host:port.
    #[arg(long, value_name = "URL", default_value = "udp://127.0.0.1:14560")]
    pub listen: String,
    /// Create a pseudo-terminal with a symbolic link at this path, instead of an address.
    #[arg(long, value_name = "PATH", conflicts_with = "listen")]
    pub pty: Option<PathBuf>,
    /// Whose habits: ardupilot obeys everybody and keeps a rate for ever, px4 obeys the primary control
    /// alone.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub habits: HabitsName,
    /// Do not answer requests for the gimbal's information.
    #[arg(long)]
    pub withhold_information: bool,
    /// Never say who has the control. With --withhold-information: an autopilot without a gimbal.
    #[arg(long)]
    pub withhold_status: bool,
    /// Deny every claim of the control.
    #[arg(long)]
    pub deny_claims: bool,
    /// Lose this number of claims.
    #[arg(long, value_name = "N", default_value_t)]
    pub drop_claims: u32,
    /// What the camera at component 100 says of itself: that it zooms, that it does not (fixed), or nothing
    /// (silent).
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    pub camera: CameraKindName,
    /// Lose this share of the packets in both directions, percent.
    #[arg(long, value_name = "PERCENT", default_value_t, value_parser = parse_percent)]
    pub loss: f64,
    /// File whose first line is the key of signed packets: 64 hexadecimal digits, or a passphrase.
    #[arg(long, value_name = "FILE")]
    pub signing_key_file: Option<PathBuf>,
    /// The simulated world, if there is one.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Log every message and every change of the rates to this file, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Inject faults: KIND@SECONDS[+DURATION], several with commas. KIND: stall, drop, delay, duplicate,
    /// corrupt, disconnect, reboot, takeover (another commander claims the control), silence or cut. Times
    /// count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// Overwrite an existing log, and replace a symbolic link at the path of --pty.
    #[arg(long)]
    pub force: bool,
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

/// What the camera of an emulated gimbal says of itself.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum CameraKindName {
    /// That it zooms.
    #[default]
    Zooming,
    /// That it does not.
    Fixed,
    /// Nothing.
    Silent,
}

/// The simulated world whose camera an emulated vehicle moves.
#[derive(Debug, Args)]
#[group(skip)]
pub struct WorldArgs {
    /// Move the camera of this simulated world, and serve its video: sim:SCENARIO?seed=1&size=WxH. The world
    /// starts with the first viewer.
    #[arg(long, value_name = "SIM")]
    pub world: Option<String>,
    /// Address of the world's video (RTSP, path /world).
    #[arg(long, value_name = "ADDR", value_parser = parse_listen, default_value = "127.0.0.1:8554")]
    pub video_listen: SocketAddr,
}
