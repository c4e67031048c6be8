//! Reads addresses of video sources.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use barrelman_host::redaction::{has_stray_at, without_logins};
use barrelman_media_protocol::source::{DeviceSettings, RtspTransport, SourceAddress, SourceLogin};
use url::Url;

use super::error::VideoUrlError;
use super::login::Login;
use super::options::{self, Options, percent_decoded};
use super::{ENCRYPTED, MediaSource, VideoSource, VideoUrl};

const RTSP_FORM: &str = "rtsp://HOST[:PORT]/PATH";
const UDP_FORM: &str = "udp://0.0.0.0:5600, or udp://GROUP:PORT for a multicast group";
const NETWORK_FORM: &str = "SCHEME://HOST[:PORT]/PATH";

impl VideoUrl {
    /// Reads an address. Checks whether a file of that name exists, and opens nothing.
    ///
    /// # Errors
    /// An unknown scheme or an invalid option; the message says what to write instead.
    pub fn parse(text: &str) -> Result<Self, VideoUrlError> {
        if text.trim().is_empty() {
            return Err(VideoUrlError::Empty);
        }
        if text == "-" {
            return Ok(Self::of(VideoSource::Pipe("/dev/stdin".into()), Options::default()));
        }
        let scheme = scheme_of(text).map(str::to_ascii_lowercase);
        let after_scheme = scheme.as_ref().map_or("", |scheme| &text[scheme.len() + 1..]);
        match scheme.as_deref() {
            Some("file") => {
                return Self::parse_path(after_scheme.strip_prefix("//").unwrap_or(after_scheme));
            }
            Some("sim") => return Err(VideoUrlError::Simulated { url: text.to_owned() }),
            Some("gst") => return Self::parse_pipeline(text, after_scheme),
            Some("v4l2") => {
                return Self::parse_device(after_scheme.strip_prefix("//").unwrap_or(after_scheme));
            }
            _ => {}
        }
        if Path::new(text).exists() {
            return Self::parse_path(text);
        }
        match scheme.as_deref() {
            None => Self::parse_path(text),
            Some(_) if has_stray_at(text) => Err(VideoUrlError::StrayAt),
            Some("rtsp" | ENCRYPTED) => Self::parse_stream(text),
            Some("udp" | "rtp") => Self::parse_udp(text),
            Some("srt" | "rtmp" | "rtmps" | "http" | "https" | "whep") => Self::parse_network(text),
            Some(_) if starts_with_port(after_scheme) => {
                Err(VideoUrlError::NoScheme { url: without_logins(text) })
            }
            Some(_) => Err(VideoUrlError::UnknownScheme { url: without_logins(text) }),
        }
    }

    /// The names of this program's own options in the text of an address.
    pub fn options_in(text: &str) -> impl Iterator<Item = &'static str> + use<'_> {
        let query = text.split_once('?').map_or("", |(_, query)| query);
        query.split('&').filter_map(|option| {
            let name = option.split('=').next()?;
            options::RTSP.iter().find(|known| **known == name).copied()
        })
    }

    fn parse_path(path: &str) -> Result<Self, VideoUrlError> {
        if path.is_empty() {
            return Err(VideoUrlError::Empty);
        }
        if is_capture_device(path.split_once('?').map_or(path, |(before, _)| before)) {
            return Self::parse_device(path);
        }
        let mut options = Options::default();
        let mut file = path;
        if let Some((before, query)) = path.rsplit_once('?')
            && !Path::new(path).exists()
            && !before.is_empty()
            && Options::are_all_known(query, options::FILE)
        {
            options.take_from(query, options::FILE)?;
            file = before;
        }
        let path = PathBuf::from(file);
        let kind = std::fs::metadata(&path).ok().map(|metadata| metadata.file_type());
        let source = if kind.is_some_and(|kind| kind.is_fifo()) {
            VideoSource::Pipe(path)
        } else if kind.is_some_and(|kind| kind.is_char_device()) {
            return Err(VideoUrlError::OtherDevice { path: path.display().to_string() });
        } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("sdp")) {
            let text = path.display().to_string();
            VideoSource::Media(MediaSource { text, address: SourceAddress::Sdp(path) })
        } else {
            VideoSource::File(path)
        };
        Ok(Self::of(source, options))
    }

    /// Reads the address of a stream, `rtsp://` or `rtsps://`, whatever files exist.
    ///
    /// # Errors
    /// An unusable address or option.
    pub fn parse_stream(text: &str) -> Result<Self, VideoUrlError> {
        let (address, login, options) = parse_network_address(text, options::RTSP, RTSP_FORM)?;
        let transport = options.transport.unwrap_or(RtspTransport::Auto);
        Ok(Self::of(VideoSource::Rtsp { address, login, transport }, options))
    }

    fn parse_network(text: &str) -> Result<Self, VideoUrlError> {
        let (address, login, options) = parse_network_address(text, options::NETWORK, NETWORK_FORM)?;
        let shown = without_logins(address.as_str());
        let login = login.map(SourceLogin::from);
        let address = SourceAddress::Network { url: address.to_string(), login };
        Ok(Self::of(VideoSource::Media(MediaSource { text: shown, address }), options))
    }

    fn parse_udp(text: &str) -> Result<Self, VideoUrlError> {
        let malformed = |reason: &str| malformed(text, reason, UDP_FORM);
        let (address, query) = text.split_once('?').unwrap_or((text, ""));
        let mut options = Options::default();
        let rest = options.take_from(query, options::UDP)?;
        if !rest.is_empty() {
            return Err(malformed(&format!("{rest} is no option of it: codec and fault are")));
        }
        let (_, target) = address.split_once("://").ok_or_else(|| malformed("there is no //"))?;
        let target = target.trim_end_matches('/').trim_start_matches('@');
        let (host, port) = target.rsplit_once(':').ok_or_else(|| malformed("there is no port"))?;
        let port = port.parse().ok().filter(|port| *port > 0);
        let port = port.ok_or_else(|| malformed("the port is no number from 1 to 65535"))?;
        let host = match host.trim_matches(['[', ']']) {
            "" => IpAddr::V4(Ipv4Addr::UNSPECIFIED),
            "localhost" => IpAddr::V4(Ipv4Addr::LOCALHOST),
            host => {
                host.parse().map_err(|_| malformed("the host is no address of this machine in numbers"))?
            }
        };
        let bind = SocketAddr::new(host, port);
        let address = SourceAddress::Udp { bind, format: options.codec };
        Ok(Self::of(VideoSource::Media(MediaSource { text: format!("udp://{bind}"), address }), options))
    }

    fn parse_device(text: &str) -> Result<Self, VideoUrlError> {
        let (path, query) = text.split_once('?').unwrap_or((text, ""));
        let mut options = Options::default();
        let rest = options.take_from(query, options::DEVICE)?;
        if !rest.is_empty() || path.is_empty() {
            let form = "v4l2:/dev/video0?size=1280x720&fps=30&format=mjpeg";
            return Err(malformed(text, "it is no device, or an option is unknown", form));
        }
        let settings = DeviceSettings {
            path: path.into(),
            size: options.size,
            fps: options.fps.take(),
            format: options.format,
        };
        let address = SourceAddress::Device(settings);
        Ok(Self::of(VideoSource::Media(MediaSource { text: path.to_owned(), address }), options))
    }

    fn parse_pipeline(text: &str, pipeline: &str) -> Result<Self, VideoUrlError> {
        if pipeline.trim().is_empty() {
            return Err(malformed(
                text,
                "there is no pipeline",
                "gst:videotestsrc ! video/x-raw,width=640,height=360",
            ));
        }
        let address = SourceAddress::Pipeline(pipeline.to_owned());
        let source = MediaSource { text: without_logins(text), address };
        Ok(Self::of(VideoSource::Media(source), Options::default()))
    }

    fn of(source: VideoSource, options: Options) -> Self {
        Self { fps: options.fps, faults: options.faults, ..Self::from_source(source) }
    }
}

/// Whether a path names a capture device: `/dev/video0`, or a link to it. udev makes links with stable names
/// in `/dev/v4l/by-id`, as long as the device is connected.
fn is_capture_device(path: &str) -> bool {
    /// The major number of capture devices (Linux, `Documentation/admin-guide/devices.txt`).
    const VIDEO4LINUX: u32 = 81;
    let is_named_so = |path: &Path| {
        let name = path.to_string_lossy();
        name.starts_with("/dev/video") || name.starts_with("/dev/v4l/")
    };
    let path = Path::new(path);
    let has_number = std::fs::metadata(path).is_ok_and(|metadata| {
        metadata.file_type().is_char_device() && rustix::fs::major(metadata.rdev()) == VIDEO4LINUX
    });
    has_number || is_named_so(path) || std::fs::read_link(path).is_ok_and(|target| is_named_so(&target))
}

/// Reads an address with a host: the address without login and without this program's options, the login, the
/// options.
fn parse_network_address(
    text: &str,
    known: &[&'static str],
    form: &'static str,
) -> Result<(Url, Option<Login>, Options), VideoUrlError> {
    if has_stray_at(text) {
        return Err(VideoUrlError::StrayAt);
    }
    let mut address = Url::parse(text).map_err(|error| malformed(text, &error.to_string(), form))?;
    if address.host_str().is_none_or(str::is_empty) {
        return Err(malformed(text, "there is no host", form));
    }
    let mut options = Options::default();
    if let Some(query) = address.query().map(str::to_owned) {
        let rest = options.take_from(&query, known)?;
        address.set_query(Some(rest.as_str()).filter(|query| !query.is_empty()));
    }
    let is_encrypted = matches!(address.scheme(), ENCRYPTED | "https" | "rtmps");
    let login = (!address.username().is_empty()).then(|| Login {
        user: percent_decoded(address.username()),
        password: percent_decoded(address.password().unwrap_or_default()),
        permits_basic: is_encrypted,
    });
    // Removing the user and the password succeeds for an address with a host.
    let _ = address.set_username("");
    let _ = address.set_password(None);
    Ok((address, login, options))
}

fn malformed(text: &str, reason: &str, form: &'static str) -> VideoUrlError {
    VideoUrlError::Malformed { url: without_logins(text), reason: reason.to_owned(), form }
}

/// The scheme of an address: letters, digits, `+-.` before the first colon. A single letter is a Windows
/// drive.
fn scheme_of(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once(':')?;
    let is_scheme = scheme.len() > 1
        && scheme.starts_with(|first: char| first.is_ascii_alphanumeric())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    is_scheme.then_some(scheme)
}

/// Whether a text begins with a port, as behind the host of an address without a scheme.
fn starts_with_port(text: &str) -> bool {
    let port = text.split(['/', '?']).next().unwrap_or_default();
    port.parse::<u16>().is_ok()
}
