//! The address of a video source, as the user writes it.
//!
//! | address | source | read by |
//! |---|---|---|
//! | a path, `file:clip.mp4` | a file, a folder of pictures | built-in engine; other kinds of files: GStreamer |
//! | `-`, the path of a named pipe | Y4M (built-in), or what GStreamer recognises | both |
//! | `rtsp://`, `rtsps://` | a camera or server | built-in engine (H.264 over TCP); otherwise GStreamer |
//! | `udp://0.0.0.0:5600`, `rtp://` | RTP or MPEG-TS packets that are sent here | GStreamer |
//! | `stream.sdp` | RTP streams that the file describes | GStreamer |
//! | `/dev/video0`, `v4l2:/dev/video0` | a capture device | GStreamer |
//! | `srt://`, `rtmp://`, `http://`, `https://` | a server | GStreamer |
//! | `gst:PIPELINE` | a pipeline as for `gst-launch-1.0` | GStreamer |
//!
//! Options follow a question mark (`options.rs`). A file name may contain a question mark: the text after it
//! is read as options only if every option is known, and an existing file of exactly that name takes
//! precedence. A password is never printed.

mod error;
mod login;
mod options;
mod parse;

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_host::fault::FaultPlan;
use barrelman_host::redaction::without_logins;
use barrelman_media_protocol::source::{RtspTransport, SourceAddress, SourceLogin, SourceSettings};
use url::{Position, Url};

use super::feed::FeedSettings;
use super::sender_clock::TimingSettings;
use crate::codec::mode::DecodeMode;
use crate::engine::VideoEngine;

pub use error::VideoUrlError;
pub use login::{Login, LoginError};

/// A video source with its options.
#[derive(Clone, PartialEq)]
pub struct VideoUrl {
    /// The source.
    pub source: VideoSource,
    /// Pictures per second of a folder of pictures.
    pub fps: Option<f64>,
    /// Deliberate faults.
    pub faults: FaultPlan,
    /// How the times of a live stream are judged.
    pub timing: TimingSettings,
    /// The engine that reads and decodes.
    pub engine: VideoEngine,
    /// Where a relay takes what goes to a server that speaks TLS (`rtsps://`).
    relay: Option<SocketAddr>,
}

/// A file or a stream.
#[derive(Clone, PartialEq)]
pub enum VideoSource {
    /// A file, or a folder of pictures.
    File(PathBuf),
    /// A pipe that another program writes to.
    Pipe(PathBuf),
    /// A live stream over RTSP (RFC 2326), or over RTSP in TLS.
    Rtsp {
        /// The address without user and password.
        address: Url,
        /// The login, if any.
        login: Option<Login>,
        /// The way of the packets.
        transport: RtspTransport,
    },
    /// A live source that GStreamer alone reads.
    Media(MediaSource),
}

/// A source that GStreamer alone reads.
#[derive(Clone, PartialEq)]
pub struct MediaSource {
    /// The address without user and password.
    text: String,
    /// The address in the terms of `barrelman-media`.
    address: SourceAddress,
}

/// The scheme of RTSP in TLS, and its usual port.
const ENCRYPTED: &str = "rtsps";
const ENCRYPTED_PORT: u16 = 322;
/// The usual port of RTSP.
pub(super) const RTSP_PORT: u16 = 554;

impl VideoUrl {
    /// A file or a folder, without options.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self::from_source(VideoSource::File(path.into()))
    }

    fn from_source(source: VideoSource) -> Self {
        Self {
            source,
            fps: None,
            faults: FaultPlan::default(),
            timing: TimingSettings::default(),
            engine: VideoEngine::default(),
            relay: None,
        }
    }

    /// The source with this login.
    ///
    /// # Errors
    /// The source takes no login, or the address has one already.
    pub fn with_login(mut self, new: Login) -> Result<Self, VideoUrlError> {
        let url = self.to_string();
        match &mut self.source {
            VideoSource::Rtsp { login: Some(_), .. } => Err(VideoUrlError::LoginGivenTwice { url }),
            VideoSource::Rtsp { login, address, .. } => {
                let permits_basic = new.permits_basic || address.scheme() == ENCRYPTED;
                *login = Some(Login { permits_basic, ..new });
                Ok(self)
            }
            VideoSource::Media(MediaSource {
                address: SourceAddress::Network { login, url: text }, ..
            }) if text.starts_with("http") => {
                if login.is_some() {
                    return Err(VideoUrlError::LoginGivenTwice { url });
                }
                let permits_basic = new.permits_basic || text.starts_with("https:");
                *login = Some(Login { permits_basic, ..new }.into());
                Ok(self)
            }
            VideoSource::File(_) | VideoSource::Pipe(_) | VideoSource::Media(_) => {
                Err(VideoUrlError::LoginNotSupported { url })
            }
        }
    }

    /// The server of a stream: its host, without brackets, and its port; `None`: the source has no server
    /// that takes a login.
    pub fn server(&self) -> Option<(String, u16)> {
        match &self.source {
            VideoSource::Rtsp { address, .. } => {
                let usual = if address.scheme() == ENCRYPTED { ENCRYPTED_PORT } else { RTSP_PORT };
                Some((host_of(address)?, address.port().unwrap_or(usual)))
            }
            VideoSource::Media(MediaSource { address: SourceAddress::Network { url, .. }, .. }) => {
                let address = Url::parse(url).ok()?;
                Some((host_of(&address)?, address.port_or_known_default()?))
            }
            VideoSource::File(_) | VideoSource::Pipe(_) | VideoSource::Media(_) => None,
        }
    }

    /// The source, whose login may be sent as it is, without TLS (Basic).
    #[must_use]
    pub fn permitting_basic(mut self) -> Self {
        match &mut self.source {
            VideoSource::Rtsp { login: Some(login), .. } => login.permits_basic = true,
            VideoSource::Media(MediaSource {
                address: SourceAddress::Network { login: Some(login), .. },
                ..
            }) => login.permits_basic = true,
            _ => {}
        }
        self
    }

    /// The server that the stream comes from in TLS through a relay: host and port; `None`: the source needs
    /// no relay.
    pub fn tls_server(&self) -> Option<(String, u16)> {
        match &self.source {
            VideoSource::Rtsp { address, .. } if address.scheme() == ENCRYPTED => self.server(),
            _ => None,
        }
    }

    /// The source, through a relay that speaks TLS to its server.
    #[must_use]
    pub const fn through(mut self, relay: SocketAddr) -> Self {
        self.relay = Some(relay);
        self
    }

    /// The address that a stream is asked for at: its own, or the relay's; `None`: the stream needs a relay
    /// and has none.
    pub(super) fn reachable(&self, address: &Url) -> Option<Url> {
        if address.scheme() != ENCRYPTED {
            return Some(address.clone());
        }
        let relay = self.relay?;
        let rest = &address[Position::BeforePath..];
        Url::parse(&format!("rtsp://{relay}{rest}")).ok()
    }

    /// The live source as `barrelman-media` plays it; `None`: the source needs a relay and has none.
    pub(super) fn media_settings(&self) -> Option<SourceSettings> {
        let address = match &self.source {
            VideoSource::File(path) | VideoSource::Pipe(path) => SourceAddress::File(path.clone()),
            VideoSource::Rtsp { address, login, transport } => SourceAddress::Rtsp {
                url: self.reachable(address)?.to_string(),
                // What goes through a relay goes in its TCP connection.
                transport: if self.relay.is_some() { RtspTransport::Tcp } else { *transport },
                login: login.clone().map(SourceLogin::from),
            },
            VideoSource::Media(source) => source.address.clone(),
        };
        Some(SourceSettings { address, is_live: self.is_live() })
    }

    /// Whether the source is live: it sets the pace, and a network stream reconnects when it is lost.
    pub const fn is_live(&self) -> bool {
        !matches!(self.source, VideoSource::File(_))
    }

    /// The settings of the feed of this source.
    pub(super) fn feed_settings(&self) -> FeedSettings {
        let mode = if self.is_live() { DecodeMode::Live } else { DecodeMode::File };
        let (address, faults) = (self.to_string(), self.faults.clone());
        FeedSettings { address, faults, mode, engine: self.engine, timing: self.timing }
    }
}

fn host_of(address: &Url) -> Option<String> {
    Some(address.host_str()?.trim_matches(['[', ']']).to_owned())
}

impl From<Login> for SourceLogin {
    fn from(login: Login) -> Self {
        let Login { user, password, permits_basic } = login;
        Self { user, password, permits_basic }
    }
}

impl fmt::Display for VideoSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) | Self::Pipe(path) => write!(f, "{}", path.display()),
            Self::Rtsp { address, login: None, .. } => f.write_str(&without_logins(address.as_str())),
            Self::Rtsp { address, login: Some(_), .. } => write_with_login(address.as_str(), f),
            Self::Media(MediaSource { text, address: SourceAddress::Network { login: Some(_), .. } }) => {
                write_with_login(text, f)
            }
            Self::Media(source) => f.write_str(&source.text),
        }
    }
}

/// Writes an address with a mark in the place of its login.
fn write_with_login(address: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let (scheme, rest) = address.split_once("://").unwrap_or(("rtsp", address));
    write!(f, "{scheme}://***@{}", without_logins(rest))
}

impl fmt::Display for VideoUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.source)?;
        let mut mark = '?';
        if let VideoSource::Rtsp { address, .. } = &self.source
            && address.query().is_some()
        {
            mark = '&';
        }
        if let Some(fps) = self.fps {
            write!(f, "{mark}fps={fps}")?;
            mark = '&';
        }
        if !self.faults.is_empty() {
            write!(f, "{mark}fault={}", self.faults)?;
        }
        Ok(())
    }
}

impl fmt::Debug for VideoUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VideoUrl({self})")
    }
}

impl fmt::Debug for VideoSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VideoSource({self})")
    }
}

#[cfg(test)]
mod tests;
