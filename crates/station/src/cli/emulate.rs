//! The arguments of `emulate`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};

use super::values::parse_positive;

/// `emulate`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman emulate fotokite-pro --pty /tmp/fotokite")]
pub struct EmulateArgs {
    /// What to emulate.
    #[command(subcommand)]
    pub station: StationName,
}

/// The ground stations that can be emulated.
#[derive(Debug, Subcommand)]
pub enum StationName {
    /// The Fotokite Pro's serial ground station.
    FotokitePro(EmulateFotokiteProArgs),
}

/// `emulate fotokite-pro`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman emulate fotokite-pro --pty /tmp/fotokite --log station.jsonl
and in another terminal
  barrelman run --video file:clip.mp4 --select 600,300,80,60 --engage --link serial:/tmp/fotokite
With --world sim:arena1 it moves that world's camera and serves its video:
  barrelman run --video rtsp://127.0.0.1:8554/world --select 555,296,80,42 --engage --link serial:/tmp/fotokite")]
#[group(skip)]
#[command(group = ArgGroup::new("port").required(true).args(["pty", "listen"]))]
pub struct EmulateFotokiteProArgs {
    /// Make a pseudo-terminal and link it here. A link that a killed emulator left is replaced.
    #[arg(long, value_name = "PATH")]
    pub pty: Option<PathBuf>,
    /// Listen for the pass-through server's TCP connections here.
    #[arg(long, value_name = "ADDR", conflicts_with = "pty")]
    pub listen: Option<String>,
    /// Move the camera of this simulated world, and serve its video: sim:SCENARIO?seed=1&size=WxH. The world begins
    /// when somebody looks.
    #[arg(long, value_name = "SIM")]
    pub world: Option<String>,
    /// Where the world's video is served (RTSP, path /world).
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8554")]
    pub video_listen: SocketAddr,
    /// Log every line and state here, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Go wrong on purpose: KIND@SECONDS[+DURATION], several with commas, KIND being stall, drop, delay, duplicate,
    /// corrupt, disconnect or reboot. The times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// A rate ends by itself this long after the last command for its axis, in seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub rate_timeout: Option<f64>,
    /// Do not echo what the shell is sent.
    #[arg(long)]
    pub no_echo: bool,
    /// Overwrite a log that exists, and replace a symbolic link at the path of --pty.
    #[arg(long)]
    pub force: bool,
}
