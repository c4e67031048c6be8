//! The address of a video source, as the user writes it: `rtsp://...`, `rtsps://...`, `file:clip.mp4`, or a path.
//!
//! Options follow a question mark: `?fps=30` (pictures per second of a folder) and `?fault=stall@12.5s,drop@3+2`
//! (deliberate faults). A file name may contain a question mark: the text after it is read as options only if every
//! option is known, and an existing file of exactly that name takes precedence. A password is never printed.

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use url::{Position, Url};

use super::feed::FeedSettings;
use super::sender_clock::TimingSettings;
use crate::codec::decoder::DecodeMode;
use barrelman_host::fault::{FaultPlan, FaultPlanError};
use barrelman_host::redaction::{has_stray_at, without_logins};

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
    /// Where a relay takes what goes to a server that speaks TLS (`rtsps://`).
    relay: Option<SocketAddr>,
}

/// A file or a stream.
#[derive(Clone, PartialEq)]
pub enum VideoSource {
    /// A file, or a folder of pictures.
    File(PathBuf),
    /// A live stream over RTSP (RFC 2326), or over RTSP in TLS.
    Rtsp {
        /// The address without user and password.
        address: Url,
        /// The login, if any.
        login: Option<Login>,
    },
}

/// User and password of an RTSP camera. Their values are not printed.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    /// The user's name.
    pub user: String,
    /// The password.
    pub password: String,
    /// Whether the password may be sent as it is (Basic): in TLS, or where the configuration permits it.
    pub permits_basic: bool,
}

impl Login {
    /// Reads `user:password`. The password may be empty and may contain colons.
    ///
    /// # Errors
    /// A text without a user or without a colon. The message does not repeat the text.
    pub fn parse(text: &str) -> Result<Self, LoginError> {
        let (user, password) = text.split_once(':').filter(|(user, _)| !user.is_empty()).ok_or(LoginError)?;
        Ok(Self { user: user.to_owned(), password: password.to_owned(), permits_basic: false })
    }
}

/// A text that is not a login.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("there is no login: write user:password")]
pub struct LoginError;

/// An address that cannot be used. The messages say what to do instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VideoUrlError {
    /// The address is empty.
    #[error("no video source given: write a file name or rtsp://HOST/PATH")]
    Empty,
    /// The scheme is known and not supported.
    #[error("`{url}`: {what} not read by this build. {remedy}")]
    Unsupported {
        /// The text of the user, without a password.
        url: String,
        /// The kind of source, with a verb.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The scheme is unknown.
    #[error("`{url}` begins with an unknown scheme: use a file name, file:PATH or rtsp://HOST/PATH")]
    UnknownScheme {
        /// The text of the user, without a password.
        url: String,
    },
    /// The address cannot be parsed.
    #[error("`{url}` is not an address ({reason}): write rtsp://HOST[:PORT]/PATH")]
    Malformed {
        /// The text of the user, without a password.
        url: String,
        /// What is wrong.
        reason: String,
    },
    /// A part of a password would be read as the host or the port.
    #[error(
        "the address of the video has an @ that is not the one before its host, and is not used: in a user's name, a password and \
         a path, write @ as %40, / as %2F, ? as %3F, # as %23, : as %3A and % as %25; or leave the login out of the address and give \
         --video-login-file FILE (video.login_file), a file with user:password as it is"
    )]
    StrayAt,
    /// A login was given for a source without one.
    #[error("{url} takes no login: only rtsp:// does")]
    LoginNotSupported {
        /// The source.
        url: String,
    },
    /// A login was given in the address and beside it.
    #[error("the login of {url} is given twice: leave it out of the address")]
    LoginGivenTwice {
        /// The source, without the login.
        url: String,
    },
    /// The frame rate is not a number, or out of its range.
    #[error("fps={0} is not a number of pictures per second: write e.g. ?fps=30 (more than 0, at most 1000)")]
    InvalidFps(String),
    /// A simulated world, where only a recording or a stream can be used.
    #[error(
        "{url} is a simulated world, which goes by the clock, and no recording: use `barrelman run --video {url}`"
    )]
    Simulated {
        /// The address as written.
        url: String,
    },
    /// The plan of faults cannot be parsed.
    #[error(transparent)]
    Fault(#[from] FaultPlanError),
}

const SERVE_CAMERA: &str = "Serve the camera over RTSP, e.g. with MediaMTX and \
    `ffmpeg -f v4l2 -i /dev/video0 -c:v libx264 -tune zerolatency -pix_fmt yuv420p \
    -f rtsp rtsp://127.0.0.1:8554/camera`, and use that address";
const SERVE_STREAM: &str = "Serve it over RTSP, e.g. with MediaMTX and \
    `ffmpeg -i URL -c:v libx264 -tune zerolatency -pix_fmt yuv420p -f rtsp rtsp://127.0.0.1:8554/camera`, \
    and use that address";

impl VideoUrl {
    /// Reads an address. Checks whether a file of that name exists, and opens nothing.
    ///
    /// # Errors
    /// An unknown scheme or an invalid option; the message says what to write instead.
    pub fn parse(text: &str) -> Result<Self, VideoUrlError> {
        if text.trim().is_empty() {
            return Err(VideoUrlError::Empty);
        }
        if let Some(path) = text.strip_prefix("file://").or_else(|| text.strip_prefix("file:")) {
            return Self::parse_path(path);
        }
        if text.starts_with("sim:") {
            return Err(VideoUrlError::Simulated { url: text.to_owned() });
        }
        if Path::new(text).exists() {
            return Ok(Self::file(text));
        }
        match scheme_of(text) {
            None => Self::parse_path(text),
            Some(_) if has_stray_at(text) => Err(VideoUrlError::StrayAt),
            Some("rtsp" | ENCRYPTED) => Self::parse_stream(text),
            Some(scheme) => Err(unsupported(scheme, text)),
        }
    }

    /// A file or a folder, without options.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self {
            source: VideoSource::File(path.into()),
            fps: None,
            faults: FaultPlan::default(),
            timing: TimingSettings::default(),
            relay: None,
        }
    }

    /// The source with this login.
    ///
    /// # Errors
    /// The source is not RTSP, or the address has a login already.
    pub fn with_login(mut self, new: Login) -> Result<Self, VideoUrlError> {
        let url = self.to_string();
        match &mut self.source {
            VideoSource::Rtsp { login: Some(_), .. } => Err(VideoUrlError::LoginGivenTwice { url }),
            VideoSource::Rtsp { login, address } => {
                let permits_basic = new.permits_basic || address.scheme() == ENCRYPTED;
                *login = Some(Login { permits_basic, ..new });
                Ok(self)
            }
            VideoSource::File(_) => Err(VideoUrlError::LoginNotSupported { url }),
        }
    }

    /// The server of a stream: its host, without brackets, and its port; `None`: the source is no stream.
    pub fn server(&self) -> Option<(String, u16)> {
        match &self.source {
            VideoSource::Rtsp { address, .. } => {
                let host = address.host_str()?.trim_matches(['[', ']']).to_owned();
                let usual = if address.scheme() == ENCRYPTED { ENCRYPTED_PORT } else { RTSP_PORT };
                Some((host, address.port().unwrap_or(usual)))
            }
            VideoSource::File(_) => None,
        }
    }

    /// The names of this program's own options in the text of an address.
    pub fn options_in(text: &str) -> impl Iterator<Item = &'static str> + use<'_> {
        let query = text.split_once('?').map_or("", |(_, query)| query);
        query.split('&').filter_map(|option| {
            KNOWN_OPTIONS
                .into_iter()
                .find(|name| option.starts_with(name))
                .map(|name| name.trim_end_matches('='))
        })
    }

    /// The source, whose login may be sent as it is, without TLS (Basic).
    #[must_use]
    pub const fn permitting_basic(mut self) -> Self {
        if let VideoSource::Rtsp { login: Some(login), .. } = &mut self.source {
            login.permits_basic = true;
        }
        self
    }

    /// The server that the stream comes from in TLS: host and port; `None`: the source needs no TLS.
    pub fn tls_server(&self) -> Option<(String, u16)> {
        match &self.source {
            VideoSource::Rtsp { address, .. } if address.scheme() == ENCRYPTED => self.server(),
            VideoSource::Rtsp { .. } | VideoSource::File(_) => None,
        }
    }

    /// The source, through a relay that speaks TLS to its server.
    #[must_use]
    pub const fn through(mut self, relay: SocketAddr) -> Self {
        self.relay = Some(relay);
        self
    }

    /// The address that a stream is asked for at: its own, or the relay's; `None`: the stream needs a relay and has none.
    pub(super) fn reachable(&self, address: &Url) -> Option<Url> {
        if address.scheme() != ENCRYPTED {
            return Some(address.clone());
        }
        let relay = self.relay?;
        let rest = &address[Position::BeforePath..];
        Url::parse(&format!("rtsp://{relay}{rest}")).ok()
    }

    /// Whether the source is a live stream, which sets the pace and reconnects when it is lost.
    pub const fn is_live(&self) -> bool {
        matches!(self.source, VideoSource::Rtsp { .. })
    }

    /// The settings of the feed of this source.
    pub(super) fn feed_settings(&self) -> FeedSettings {
        let mode = if self.is_live() { DecodeMode::Live } else { DecodeMode::File };
        FeedSettings { address: self.to_string(), faults: self.faults.clone(), mode, timing: self.timing }
    }

    fn parse_path(path: &str) -> Result<Self, VideoUrlError> {
        let mut url = Self::file(path);
        if path.is_empty() {
            return Err(VideoUrlError::Empty);
        }
        if let Some((before, options)) = path.rsplit_once('?')
            && !Path::new(path).exists()
            && !before.is_empty()
            && options.split('&').all(|option| KNOWN_OPTIONS.iter().any(|name| option.starts_with(name)))
        {
            url = Self::file(before);
            for option in options.split('&') {
                url.set_option(option)?;
            }
        }
        Ok(url)
    }

    /// Reads the address of a stream, `rtsp://` or `rtsps://`, whatever files exist.
    ///
    /// # Errors
    /// An unusable address or option.
    pub fn parse_stream(text: &str) -> Result<Self, VideoUrlError> {
        if has_stray_at(text) {
            return Err(VideoUrlError::StrayAt);
        }
        let malformed = |reason: String| VideoUrlError::Malformed { url: without_logins(text), reason };
        let mut address = Url::parse(text).map_err(|error| malformed(error.to_string()))?;
        if address.host_str().is_none_or(str::is_empty) {
            return Err(malformed("there is no host".to_owned()));
        }
        let mut url = Self::file("");
        // The camera has options of its own: only this program's options are removed.
        if let Some(query) = address.query().map(str::to_owned) {
            let is_known = |option: &&str| KNOWN_OPTIONS.iter().any(|name| option.starts_with(name));
            for option in query.split('&').filter(is_known) {
                url.set_option(option)?;
            }
            let other: Vec<_> = query.split('&').filter(|option| !is_known(option)).collect();
            address.set_query(Some(other.join("&").as_str()).filter(|query| !query.is_empty()));
        }
        let login = (!address.username().is_empty()).then(|| Login {
            user: percent_decoded(address.username()),
            password: percent_decoded(address.password().unwrap_or_default()),
            permits_basic: address.scheme() == ENCRYPTED,
        });
        // Removing the user and the password succeeds for an address with a host.
        let _ = address.set_username("");
        let _ = address.set_password(None);
        url.source = VideoSource::Rtsp { address, login };
        Ok(url)
    }

    fn set_option(&mut self, option: &str) -> Result<(), VideoUrlError> {
        if let Some(fps) = option.strip_prefix("fps=") {
            let number: f64 = fps.parse().map_err(|_| VideoUrlError::InvalidFps(fps.to_owned()))?;
            if !(number > 0.0 && number <= 1000.0) {
                return Err(VideoUrlError::InvalidFps(fps.to_owned()));
            }
            self.fps = Some(number);
        } else if let Some(faults) = option.strip_prefix("fault=") {
            self.faults = FaultPlan::parse(&percent_decoded(faults))?;
        }
        Ok(())
    }
}

const KNOWN_OPTIONS: [&str; 2] = ["fps=", "fault="];

/// The scheme of RTSP in TLS, and its usual port.
const ENCRYPTED: &str = "rtsps";
const ENCRYPTED_PORT: u16 = 322;
/// The usual port of RTSP.
pub(super) const RTSP_PORT: u16 = 554;

/// The scheme of an address: letters, digits, `+-.` before the first colon. A single letter is a Windows drive.
fn scheme_of(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once(':')?;
    let is_scheme = scheme.len() > 1
        && scheme.starts_with(|first: char| first.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    is_scheme.then_some(scheme)
}

fn unsupported(scheme: &str, text: &str) -> VideoUrlError {
    let url = without_logins(text);
    let (what, remedy) = match scheme {
        "v4l2" => ("USB and other V4L2 cameras are", SERVE_CAMERA),
        "udp" | "rtp" | "srt" | "tcp" | "rtmp" => ("this kind of stream is", SERVE_STREAM),
        "http" | "https" => ("video over HTTP is", SERVE_STREAM),
        _ => return VideoUrlError::UnknownScheme { url },
    };
    VideoUrlError::Unsupported { url, what, remedy }
}

fn percent_decoded(text: &str) -> String {
    percent_encoding::percent_decode_str(text).decode_utf8_lossy().into_owned()
}

impl fmt::Display for VideoSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Rtsp { address, login: None } => write!(f, "{address}"),
            Self::Rtsp { address, login: Some(_) } => {
                let address = address.as_str();
                let (scheme, rest) = address.split_once("://").unwrap_or(("rtsp", address));
                write!(f, "{scheme}://***@{rest}")
            }
        }
    }
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

impl fmt::Debug for Login {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Login(***)")
    }
}

#[cfg(test)]
mod tests;
