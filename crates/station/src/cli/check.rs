//! The arguments of `check`.

use std::path::PathBuf;

use clap::Args;

/// `check`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman check barrelman.toml")]
pub struct CheckArgs {
    /// Configuration file (TOML).
    pub config: Option<PathBuf>,
    /// Check this video source.
    #[arg(long, value_name = "URL")]
    pub video: Option<String>,
    /// File whose first line is user:password of the camera at rtsp://...
    #[arg(long, value_name = "FILE")]
    pub video_login_file: Option<PathBuf>,
    /// Check this link.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
