//! Where events of Cursor on Target go: `udp://host:port`, `tcp://host:port` or `tls://host:port`.

use std::fmt;
use std::net::{SocketAddr, ToSocketAddrs as _};

use anyhow::{Context as _, Result, bail};
use barrelman_host::redaction::without_logins;

/// What every error about an address ends with.
const FORMS: &str = "use udp://HOST:PORT (a display, or a group as udp://239.2.3.1:6969), tcp://HOST:PORT or tls://HOST:PORT (a server)";

/// How events are carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// A datagram for each event, to one receiver or to a multicast group.
    Udp,
    /// A connection.
    Tcp,
    /// An encrypted connection.
    Tls,
}

/// An address of TAK.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TakAddress {
    /// How events are carried.
    pub transport: Transport,
    /// A name or an IP address, without brackets.
    host: String,
    /// Not 0.
    port: u16,
}

impl TakAddress {
    /// Parses an address. Nothing is looked up.
    ///
    /// # Errors
    /// If the scheme is another one, or host or port are missing; the message says what can be given.
    pub fn parse(text: &str) -> Result<Self> {
        let shown = without_logins(text);
        let Some((scheme, rest)) = text.split_once("://") else {
            bail!("{shown:?} is no address of TAK: {FORMS}");
        };
        let transport = match scheme {
            "udp" => Transport::Udp,
            "tcp" => Transport::Tcp,
            "tls" => Transport::Tls,
            "ssl" => bail!("{shown:?}: write tls:// in place of ssl://; {FORMS}"),
            _ => bail!("{shown:?} is no address of TAK: {FORMS}"),
        };
        let split = rest.rsplit_once(':').and_then(|(host, port)| Some((host_of(host)?, port)));
        let Some((host, port)) = split else { bail!("{shown:?} names no host and port: {FORMS}") };
        match port.parse() {
            Ok(port) if port > 0 => Ok(Self { transport, host: host.to_owned(), port }),
            _ => bail!("{shown:?}: the port is a number from 1 to 65535; {FORMS}"),
        }
    }

    /// A name or an IP address, without brackets.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// Looks the host up. May wait for a name server.
    ///
    /// # Errors
    /// If the name is not known.
    pub fn resolve(&self) -> Result<SocketAddr> {
        let found = (self.host.as_str(), self.port).to_socket_addrs();
        let first = found
            .map(|mut all| all.next())
            .and_then(|first| first.ok_or(std::io::ErrorKind::NotFound.into()));
        first.with_context(|| format!("the host of {self} is not known: give its IP address"))
    }
}

/// The host without the brackets of IPv6; `None`: it is none.
fn host_of(text: &str) -> Option<&str> {
    if let Some(literal) = text.strip_prefix('[') {
        return literal.strip_suffix(']').filter(|literal| literal.parse::<std::net::Ipv6Addr>().is_ok());
    }
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    (!text.is_empty() && text.chars().all(is_plain)).then_some(text)
}

impl fmt::Display for TakAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { transport, host, port } = self;
        let scheme = match transport {
            Transport::Udp => "udp",
            Transport::Tcp => "tcp",
            Transport::Tls => "tls",
        };
        if host.contains(':') {
            write!(f, "{scheme}://[{host}]:{port}")
        } else {
            write!(f, "{scheme}://{host}:{port}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_shown_as_they_were_given() {
        for text in
            ["udp://239.2.3.1:6969", "tcp://tak.example:8087", "tls://tak.example:8089", "udp://[::1]:4242"]
        {
            assert_eq!(TakAddress::parse(text).unwrap().to_string(), text);
        }
        let resolved = TakAddress::parse("udp://[::1]:4242").unwrap().resolve().unwrap();
        assert_eq!(resolved, "[::1]:4242".parse().unwrap());
    }

    #[test]
    fn other_addresses_are_refused_with_what_can_be_given() {
        for (text, part) in [
            ("239.2.3.1:6969", "no address of TAK"),
            ("http://tak.example:8080", "no address of TAK"),
            ("ssl://tak.example:8089", "write tls://"),
            ("udp://239.2.3.1", "no host and port"),
            ("udp://:6969", "no host and port"),
            ("udp://::1:6969", "no host and port"),
            ("udp://[tak]:6969", "no host and port"),
            ("tcp://tak.example/a:8087", "no host and port"),
            ("tcp://tak.example:0", "1 to 65535"),
            ("tcp://tak.example:80870", "1 to 65535"),
        ] {
            let error = TakAddress::parse(text).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("udp://HOST:PORT"), "{text}: {error}");
        }
        let error = TakAddress::parse("tcp://user:secret@tak.example:8087").unwrap_err().to_string();
        assert!(!error.contains("secret"), "{error}");
    }

    #[test]
    fn a_name_that_nobody_knows_is_refused() {
        let address = TakAddress::parse("tcp://tak.invalid:8087").unwrap();
        let error = format!("{:#}", address.resolve().unwrap_err());
        assert!(error.contains("the host of tcp://tak.invalid:8087 is not known"), "{error}");
    }
}
