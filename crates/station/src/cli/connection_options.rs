//! The options that name the configuration, the video and the link, for `run` and `check`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::config::{self, ConfigFile};

/// The options that name the configuration, the video and the link. The help is that of `run`.
#[derive(Debug, Default, Args)]
pub struct ConnectionOptions {
    /// Configuration file (TOML). Options on the command line override it.
    pub config: Option<PathBuf>,
    /// The video source: rtsp://..., file:clip.mp4, a folder of pictures, or a simulated world
    /// (sim:SCENARIO?seed=1&size=WxH).
    #[arg(long, value_name = "URL")]
    pub video: Option<String>,
    /// File whose first line is user:password of the camera at rtsp://..., to keep both off the command line.
    #[arg(long, value_name = "FILE")]
    pub video_login_file: Option<PathBuf>,
    /// The vehicle's link: serial:/dev/ttyACM0?baud=115200, tcp://host:port, udp://host:port, or sim: for the
    /// simulated world's camera. Without a link: a dry run.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
}

impl ConnectionOptions {
    /// The configuration file with the login of the command line; without a file, an empty one.
    ///
    /// # Errors
    /// If the file cannot be read or parsed.
    pub fn config_file(&self) -> Result<ConfigFile> {
        let mut file = match &self.config {
            Some(path) => config::read(path)?,
            None => ConfigFile::default(),
        };
        if let Some(path) = &self.video_login_file {
            (file.video.login_file, file.video.login_env) = (Some(path.clone()), None);
        }
        Ok(file)
    }
}
