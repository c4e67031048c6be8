//! Addresses of links: `serial:/dev/ttyACM0?baud=115200`, `tcp://host:port`, `udp://host:port`, or `sim:` for
//! a simulated camera. The vehicle's profile says what is spoken there.

use std::fmt;
use std::path::PathBuf;

use barrelman_host::fault::{FaultPlan, FaultPlanError};
use barrelman_host::redaction::{has_stray_at, without_logins};

/// Default baud rate: that of all public clients.
pub const DEFAULT_BAUD: u32 = 115_200;

/// A link's address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkUrl {
    /// What is opened.
    pub endpoint: Endpoint,
    /// Deliberate faults of the link.
    pub faults: FaultPlan,
}

/// What is opened for a link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Endpoint {
    /// A serial port.
    Serial {
        /// The device.
        path: PathBuf,
        /// The baud rate.
        baud: u32,
    },
    /// A TCP connection to a pass-through server.
    Tcp {
        /// `host:port`.
        address: String,
    },
    /// Datagrams from and to this address.
    Udp {
        /// `host:port`.
        address: String,
    },
    /// The camera of the simulated world that the video comes from.
    SimulatedCamera,
    /// A vehicle that answers requests over HTTP.
    Http(HttpAddress),
}

/// A scheme of addresses of vehicles that answer requests over HTTP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HttpScheme {
    /// Without encryption.
    Http,
    /// With encryption.
    Https,
    /// A camera with ONVIF's services, without encryption.
    Onvif,
    /// The same with encryption.
    Onvifs,
}

impl HttpScheme {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Http, "http://"),
        (Self::Https, "https://"),
        (Self::Onvif, "onvif://"),
        (Self::Onvifs, "onvifs://"),
    ];

    /// Whether the connection is encrypted.
    pub const fn is_encrypted(self) -> bool {
        matches!(self, Self::Https | Self::Onvifs)
    }

    /// Whether it is that of ONVIF's cameras.
    pub const fn is_onvif(self) -> bool {
        matches!(self, Self::Onvif | Self::Onvifs)
    }

    /// The scheme of an address, and what follows it; `None`: another one.
    fn of(address: &str) -> Option<(Self, &str)> {
        Self::ALL.into_iter().find_map(|(scheme, start)| Some((scheme, address.strip_prefix(start)?)))
    }
}

impl fmt::Display for HttpScheme {
    /// As an address begins.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Self::ALL
            .into_iter()
            .find(|(scheme, _)| scheme == self)
            .map_or(Ok(()), |(_, start)| f.write_str(start))
    }
}

/// The path of ONVIF's first service, which the standard states.
const ONVIF_PATH: &str = "/onvif/device_service";

/// The base address of a vehicle that answers requests over HTTP.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HttpAddress {
    /// What is spoken there, and whether it is encrypted.
    pub scheme: HttpScheme,
    /// The host: a name or an address, without brackets.
    pub host: String,
    /// The port.
    pub port: u16,
    /// The path before those of the API, without a slash at its end.
    pub path: String,
}

impl HttpAddress {
    /// Parses the part after the scheme; `None`: it names no host.
    fn parse(scheme: HttpScheme, text: &str) -> Option<Self> {
        let (authority, path) = text.find('/').map_or((text, ""), |at| text.split_at(at));
        let (host, rest) = match authority.strip_prefix('[') {
            Some(literal) => literal.split_once(']')?,
            None => authority.split_at(authority.find(':').unwrap_or(authority.len())),
        };
        let port = match rest.strip_prefix(':') {
            Some(port) => port.parse().ok()?,
            None if rest.is_empty() => {
                if scheme.is_encrypted() {
                    443
                } else {
                    80
                }
            }
            None => return None,
        };
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | ':' | '/');
        let is_usable = !host.is_empty() && host.chars().chain(path.chars()).all(is_plain);
        let path = path.trim_end_matches('/');
        let path = if scheme.is_onvif() { path.strip_suffix(ONVIF_PATH).unwrap_or(path) } else { path };
        let is_path_usable = path.is_empty() || !scheme.is_onvif();
        (is_usable && is_path_usable).then(|| Self {
            scheme,
            host: host.to_owned(),
            port,
            path: path.to_owned(),
        })
    }

    /// `host:port`, as a request names it.
    pub fn authority(&self) -> String {
        if self.host.contains(':') {
            format!("[{}]:{}", self.host, self.port)
        } else {
            format!("{}:{}", self.host, self.port)
        }
    }
}

impl fmt::Display for HttpAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.scheme, self.authority(), self.path)
    }
}

/// An unusable address of a link.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LinkUrlError {
    /// The scheme is unknown.
    #[error(
        "{0:?} is not the address of a link: use serial:/dev/ttyACM0?baud=115200, tcp://host:port or udp://host:port, http://host:port/api, https://host/api or onvif://host, or sim: with --video sim:SCENARIO"
    )]
    UnknownScheme(String),
    /// The scheme is followed by no port.
    #[error(
        "the link {0:?} names no usable port or path: use serial:/dev/ttyACM0?baud=115200, tcp://host:port, udp://host:port, http://host:port/api or onvif://host"
    )]
    MissingPort(String),
    /// The address contains a login, but no link uses one.
    #[error("the link {0:?} has a login, but no link uses one: remove the part before the @")]
    Login(String),
    /// A part of a password would be read as the host or the port.
    #[error(
        "the link's address has an @ that is not the one before its host, and is not used: no link uses a login; remove it from the \
         address, and write an @ in a path as %40"
    )]
    StrayAt,
    /// An option is unknown, or its value is unusable.
    #[error(
        "the link's option {0:?} is unusable: a serial link has baud=9600 or baud=115200, and every link fault=KIND@SECONDS"
    )]
    Option(String),
    /// The faults are unusable.
    #[error(transparent)]
    Faults(#[from] FaultPlanError),
}

impl LinkUrl {
    /// Parses an address.
    ///
    /// # Errors
    /// [`LinkUrlError`] names the unusable part and the remedy.
    pub fn parse(text: &str) -> Result<Self, LinkUrlError> {
        // A device may have any name.
        if !text.starts_with("serial:") && has_stray_at(text) {
            return Err(LinkUrlError::StrayAt);
        }
        let (address, options) = text.split_once('?').unwrap_or((text, ""));
        let missing_port = || LinkUrlError::MissingPort(without_logins(text));
        let mut endpoint = if let Some(path) = address.strip_prefix("serial:") {
            if path.is_empty() {
                return Err(missing_port());
            }
            Endpoint::Serial { path: PathBuf::from(path), baud: DEFAULT_BAUD }
        } else if let Some((is_datagrams, address)) = network_address(address) {
            // A fault's time contains an @ too.
            if text.split("fault=").next().is_some_and(|text| text.contains('@')) {
                return Err(LinkUrlError::Login(without_logins(text)));
            }
            let (host, port) = address.rsplit_once(':').ok_or_else(missing_port)?;
            if host.is_empty() || port.parse::<u16>().is_err() {
                return Err(missing_port());
            }
            let address = address.to_owned();
            if is_datagrams { Endpoint::Udp { address } } else { Endpoint::Tcp { address } }
        } else if let Some((scheme, rest)) = HttpScheme::of(address) {
            if rest.split('/').next().is_some_and(|authority| authority.contains('@')) {
                return Err(LinkUrlError::Login(without_logins(text)));
            }
            Endpoint::Http(HttpAddress::parse(scheme, rest).ok_or_else(missing_port)?)
        } else if address == "sim:" {
            Endpoint::SimulatedCamera
        } else {
            return Err(LinkUrlError::UnknownScheme(without_logins(text)));
        };
        let mut faults = FaultPlan::default();
        for option in options.split('&').filter(|option| !option.is_empty()) {
            let unusable = || LinkUrlError::Option(option.to_owned());
            match (option.split_once('='), &mut endpoint) {
                (Some(("baud", value)), Endpoint::Serial { baud, .. }) => {
                    *baud = value.parse().ok().filter(|baud| *baud >= 1_200).ok_or_else(unusable)?;
                }
                (Some(("fault", plan)), _) => faults = FaultPlan::parse(plan)?,
                _ => return Err(unusable()),
            }
        }
        Ok(Self { endpoint, faults })
    }

    /// The address with its deliberate faults, as it is parsed.
    pub fn with_faults(&self) -> String {
        let separator = if matches!(self.endpoint, Endpoint::Serial { .. }) { '&' } else { '?' };
        if self.faults.is_empty() {
            self.to_string()
        } else {
            format!("{self}{separator}fault={}", self.faults)
        }
    }

    /// The baud rate. A network counts as a serial line with the default baud rate.
    pub fn baud(&self) -> u32 {
        match &self.endpoint {
            Endpoint::Serial { baud, .. } => *baud,
            Endpoint::Tcp { .. } | Endpoint::Udp { .. } | Endpoint::SimulatedCamera | Endpoint::Http(_) => {
                DEFAULT_BAUD
            }
        }
    }
}

/// Whether an address names a peer for datagrams, and its `host:port`; `None`: another scheme.
fn network_address(address: &str) -> Option<(bool, &str)> {
    let stream = address.strip_prefix("tcp://").map(|address| (false, address));
    stream.or_else(|| address.strip_prefix("udp://").map(|address| (true, address)))
}

impl fmt::Display for LinkUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.endpoint {
            Endpoint::Serial { path, baud } => write!(f, "serial:{}?baud={baud}", path.display()),
            Endpoint::Tcp { address } => write!(f, "tcp://{address}"),
            Endpoint::Udp { address } => write!(f, "udp://{address}"),
            Endpoint::SimulatedCamera => f.write_str("sim:"),
            Endpoint::Http(address) => address.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Result<&str, &str>) {
        match (LinkUrl::parse(text), expected) {
            (Ok(url), Ok(text)) => assert_eq!(url.to_string(), text),
            (Err(error), Err(part)) => assert!(error.to_string().contains(part), "{error}"),
            (got, expected) => panic!("{text}: {got:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn addresses_are_read_or_refused_with_the_remedy() {
        check("serial:/dev/ttyACM0", Ok("serial:/dev/ttyACM0?baud=115200"));
        check("serial:/dev/ttyACM0?baud=9600", Ok("serial:/dev/ttyACM0?baud=9600"));
        check("tcp://station.example:5000", Ok("tcp://station.example:5000"));
        check("tcp://[::1]:5000?fault=stall@3s", Ok("tcp://[::1]:5000"));
        check("udp://127.0.0.1:14550", Ok("udp://127.0.0.1:14550"));
        check("udp://127.0.0.1", Err("no usable port"));
        check("udp://127.0.0.1:1?baud=9600", Err("baud=9600"));
        check("http://sigma.example:3128/api", Ok("http://sigma.example:3128/api"));
        check("https://sigma.local/api/", Ok("https://sigma.local:443/api"));
        check("http://[::1]:80", Ok("http://[::1]:80"));
        check("onvif://camera.example", Ok("onvif://camera.example:80"));
        check("onvif://192.0.2.7:8000/onvif/device_service", Ok("onvif://192.0.2.7:8000"));
        check("onvifs://camera.example", Ok("onvifs://camera.example:443"));
        check("onvif://camera.example/elsewhere", Err("onvif://host"));
        check("onvif://user:password@host", Err("has a login"));
        check("https://", Err("no usable port"));
        check("http://host:port/api", Err("no usable port"));
        check("http://host/a b", Err("no usable port"));
        check("http://user:password@host/api", Err("has a login"));
        check("sim:", Ok("sim:"));
        check("sim:arena1", Err("use serial:"));
        check("serial:", Err("no usable port"));
        check("tcp://user:password@host:1", Err("tcp://***@host:1\" has a login"));
        check("tcp://host", Err("no usable port"));
        check("tcp://host:port", Err("no usable port"));
        check("/dev/ttyACM0", Err("use serial:"));
        check("serial:/dev/ttyACM0?baud=fast", Err("baud=fast"));
        check("tcp://host:1?baud=9600", Err("baud=9600"));
        check("serial:/dev/ttyACM0?fault=explode@3", Err("explode"));
    }

    #[test]
    fn no_error_repeats_a_password() {
        for text in [
            "tcp://user:secret@host:5000",
            "tcp://user:secret@host",
            "tcp://user:sec?ret@host:1",
            "tcp://user:5?ret@host:1",
            "tcp://user:se/cret@host:port",
            "http://user:secret@host:1",
            "tpc://user:secret@host:1",
        ] {
            let error = LinkUrl::parse(text).unwrap_err();
            assert!(!format!("{error} {error:?}").contains("ret"), "{error:?}");
        }
    }
}
