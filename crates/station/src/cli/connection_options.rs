//! The options that name the configuration, the video and the link, for `run` and `check`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::usage_error::UsageError;
use crate::config::{self, ConfigFile};

/// The options that name the configuration, the video and the link. The help is that of `run`.
#[derive(Debug, Default, Args)]
pub struct ConnectionOptions {
    /// Configuration file (TOML). Options on the command line override it.
    pub config: Option<PathBuf>,
    /// The video source: rtsp://..., rtsps://..., file:clip.mp4, a folder of pictures, or a simulated world
    /// (sim:SCENARIO?seed=1&size=WxH). Given twice: the second is another camera on the same vehicle.
    #[arg(long, value_name = "URL")]
    pub video: Vec<String>,
    /// File whose first line is user:password of the camera at rtsp://..., to keep both off the command line.
    #[arg(long, value_name = "FILE")]
    pub video_login_file: Option<PathBuf>,
    /// SHA-256 fingerprint of the certificate of a camera at rtsps://: no other certificate is accepted.
    #[arg(long, value_name = "HEX", conflicts_with = "video_ca_file")]
    pub video_certificate_sha256: Option<String>,
    /// File of authorities (PEM) that sign the certificate of a camera at rtsps://; default: the well-known
    /// ones.
    #[arg(long, value_name = "FILE")]
    pub video_ca_file: Option<PathBuf>,
    /// The vehicle's link: serial:/dev/ttyACM0?baud=115200, tcp://host:port, udp://host:port (Fotokite Pro,
    /// MAVLink gimbal), http://host:port/api or https://host/api (Fotokite Sigma), onvif://host or
    /// onvifs://host (ONVIF), or sim: for the simulated world's camera. Without a link: a dry run.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// File whose first line is the access token of a vehicle at http:// or https://, or `api-key ` and an
    /// API key.
    #[arg(long, value_name = "FILE")]
    pub link_token_file: Option<PathBuf>,
    /// File whose first line is user:password of a camera at onvif:// or onvifs://.
    #[arg(long, value_name = "FILE")]
    pub link_login_file: Option<PathBuf>,
    /// SHA-256 fingerprint of the certificate of a vehicle at https:// or onvifs://: no other certificate is
    /// accepted.
    #[arg(long, value_name = "HEX", conflicts_with = "link_ca_file")]
    pub link_certificate_sha256: Option<String>,
    /// File of authorities (PEM) that sign the certificate of a vehicle at https:// or onvifs://; default:
    /// the well-known ones.
    #[arg(long, value_name = "FILE")]
    pub link_ca_file: Option<PathBuf>,
    /// File whose first line is the key of a MAVLink vehicle that signs its packets: 64 hexadecimal digits,
    /// or a passphrase.
    #[arg(long, value_name = "FILE")]
    pub link_signing_key_file: Option<PathBuf>,
}

impl ConnectionOptions {
    /// The configuration file with the login and the link's secrets of the command line; without a file, an
    /// empty one.
    ///
    /// # Errors
    /// If the file cannot be read or parsed.
    pub fn config_file(&self) -> Result<ConfigFile> {
        let mut file = match &self.config {
            Some(path) => config::read(path)?,
            None => ConfigFile::default(),
        };
        match self.video.as_slice() {
            [] => {}
            [_, _, third, ..] => {
                return Err(UsageError(format!(
                    "--video is given {} times: there is room for two videos; omit {third}",
                    self.video.len()
                ))
                .into());
            }
            [video, others @ ..] => {
                (file.video.url, file.video.second_url) = (Some(video.clone()), others.first().cloned());
                // That of another camera.
                file.video.second_field_of_view_deg = None;
            }
        }
        if let Some(path) = &self.video_login_file {
            (file.video.login_file, file.video.login_env) = (Some(path.clone()), None);
        }
        if self.video_certificate_sha256.is_some() || self.video_ca_file.is_some() {
            file.video.certificate_sha256.clone_from(&self.video_certificate_sha256);
            file.video.ca_file.clone_from(&self.video_ca_file);
        }
        if self.link_token_file.is_some() {
            file.link.token_file.clone_from(&self.link_token_file);
        }
        if self.link_login_file.is_some() {
            file.link.login_file.clone_from(&self.link_login_file);
        }
        if self.link_signing_key_file.is_some() {
            file.link.signing_key_file.clone_from(&self.link_signing_key_file);
        }
        if self.link_certificate_sha256.is_some() || self.link_ca_file.is_some() {
            file.link.certificate_sha256.clone_from(&self.link_certificate_sha256);
            file.link.ca_file.clone_from(&self.link_ca_file);
        }
        Ok(file)
    }
}
