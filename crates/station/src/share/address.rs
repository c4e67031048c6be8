//! Where the annotated video is served: `rtsp://IP:PORT/PATH`.

use std::fmt;
use std::net::SocketAddr;

use anyhow::{Result, bail};
use barrelman_host::redaction::without_logins;

/// What every error about an address ends with.
const FORM: &str =
    "use rtsp://IP:PORT/PATH, as in rtsp://0.0.0.0:8554/boat (0.0.0.0: for other devices, too)";
/// Longest path, characters.
const MAX_PATH: usize = 128;

/// Where the annotated video is served.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShareAddress {
    /// The address that is listened on. The port is not 0.
    pub listen: SocketAddr,
    /// The path, with its first slash.
    pub path: String,
}

impl ShareAddress {
    /// Parses an address.
    ///
    /// # Errors
    /// If the scheme is another one, or IP address, port or path are missing; the message says what can be
    /// given.
    pub fn parse(text: &str) -> Result<Self> {
        let shown = without_logins(text);
        let rest = match text.split_once("://") {
            Some(("rtsp", rest)) => rest,
            Some(("rtsps", _)) => bail!("{shown:?}: the video is not encrypted; {FORM}"),
            _ => bail!("{shown:?} is no address of RTSP: {FORM}"),
        };
        if rest.contains('@') {
            bail!("{shown:?}: the login is not chosen here: it is the console's watch token; {FORM}");
        }
        let Some((listen, path)) = rest.split_once('/') else { bail!("{shown:?} names no path: {FORM}") };
        let Ok(listen) = listen.parse::<SocketAddr>() else {
            bail!("{shown:?} names no IP address and port: {FORM}")
        };
        if listen.port() == 0 {
            bail!("{shown:?}: the port is a number from 1 to 65535; {FORM}");
        }
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let is_name = |name: &str| !name.is_empty() && name.chars().all(is_plain);
        if path.len() > MAX_PATH || !path.split('/').all(is_name) {
            bail!("{shown:?}: a path consists of letters, digits and - _ . between slashes; {FORM}");
        }
        Ok(Self { listen, path: format!("/{path}") })
    }

    /// Whether only this machine can reach the address.
    pub const fn is_loopback(&self) -> bool {
        self.listen.ip().is_loopback()
    }
}

impl fmt::Display for ShareAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rtsp://{}{}", self.listen, self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_shown_as_they_were_given() {
        for (text, is_loopback) in [
            ("rtsp://127.0.0.1:8554/boat", true),
            ("rtsp://[::1]:8554/a/b-1", true),
            ("rtsp://0.0.0.0:554/live.h264", false),
            ("rtsp://[::]:8554/boat", false),
        ] {
            let address = ShareAddress::parse(text).unwrap();
            assert_eq!((address.to_string().as_str(), address.is_loopback()), (text, is_loopback));
        }
    }

    #[test]
    fn other_addresses_are_refused_with_what_can_be_given() {
        for (text, part) in [
            ("0.0.0.0:8554/boat", "no address of RTSP"),
            ("http://0.0.0.0:8554/boat", "no address of RTSP"),
            ("rtsps://0.0.0.0:8554/boat", "not encrypted"),
            ("rtsp://0.0.0.0:8554", "names no path"),
            ("rtsp://0.0.0.0:8554/", "letters, digits"),
            ("rtsp://0.0.0.0:8554//boat", "letters, digits"),
            ("rtsp://0.0.0.0:8554/boat?a=1", "letters, digits"),
            ("rtsp://computer:8554/boat", "no IP address and port"),
            ("rtsp://0.0.0.0/boat", "no IP address and port"),
            ("rtsp://0.0.0.0:0/boat", "1 to 65535"),
            ("rtsp://0.0.0.0:99999/boat", "no IP address and port"),
        ] {
            let error = ShareAddress::parse(text).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("rtsp://IP:PORT/PATH"), "{text}: {error}");
        }
        let error = ShareAddress::parse("rtsp://watch:secret@0.0.0.0:8554/boat").unwrap_err().to_string();
        assert!(error.contains("watch token") && !error.contains("secret"), "{error}");
    }
}
