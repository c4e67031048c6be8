//! The arguments of `check`.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_wire::onvif::discovery::MULTICAST;
use clap::Args;

use super::connection_options::ConnectionOptions;

/// `check`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman check --video file:clip.mp4\n  barrelman check barrelman.toml\n  barrelman check --profile mavlink-gimbal --link udp://127.0.0.1:14550",
    mut_arg("config", |arg| arg.help("Configuration file (TOML)")),
    mut_arg("video", |arg| arg.help("Check this video source")),
    mut_arg("video_login_file", |arg| arg.help("File whose first line is user:password of the camera at rtsp://...")),
    mut_arg("link", |arg| arg.help("Check this link"))
)]
pub struct CheckArgs {
    /// What is checked.
    #[command(flatten)]
    pub connection: ConnectionOptions,
    /// The vehicle's profile; default: the configuration's, or fotokite-pro.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Check where events for TAK go: udp://host:port or tcp://host:port.
    #[arg(long, value_name = "URL")]
    pub tak: Option<String>,
    /// Check where the annotated video is served: rtsp://IP:PORT/PATH.
    #[arg(long, value_name = "URL")]
    pub share: Option<String>,
    /// Ask the network for ONVIF cameras (WS-Discovery), at this address of a camera or of a group.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = MULTICAST)]
    pub discover: Option<SocketAddr>,
    /// Check this model of a detector, and detector.toml beside it.
    #[arg(long, value_name = "FILE")]
    pub detector: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  barrelman doctor\n  barrelman doctor --json")]
pub struct DoctorArgs {
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
