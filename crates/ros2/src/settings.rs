//! What the command line means: which console, with which token, under which name. Checked before anything is
//! opened.

use std::net::IpAddr;

use anyhow::{Context as _, Result, bail};
use barrelman_host::input;
use url::{Host, Url};

use crate::cli::Cli;

/// Where the console is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// A name or an IP address, without brackets.
    pub host: String,
    /// The TCP port.
    pub port: u16,
    /// Whether TLS is spoken. Without, the host is loopback.
    pub is_encrypted: bool,
}

impl Address {
    /// Reads the address of a console.
    ///
    /// # Errors
    /// If it is none, or would send the token over an unencrypted line.
    pub fn parse(text: &str) -> Result<Self> {
        let url = Url::parse(text).with_context(|| {
            format!("--console {text} is no address: give http://127.0.0.1:PORT or https://HOST:PORT")
        })?;
        let is_encrypted = match url.scheme() {
            "https" => true,
            "http" => false,
            _ => bail!("--console {text}: give an address that begins with http:// or https://"),
        };
        let has_more = !matches!(url.path(), "" | "/") || url.query().is_some() || url.fragment().is_some();
        if has_more || !url.username().is_empty() || url.password().is_some() {
            bail!(
                "--console names host and port alone: https://HOST:PORT; a token belongs into the file of \
                 --token-file"
            );
        }
        let Some(host) = url.host() else { bail!("--console {text} names no host") };
        if !is_encrypted && !is_loopback(&host) {
            bail!(
                "--console {text}: the token and the video would be readable on the network: give https:// \
                 and --ca, or tunnel to loopback (`ssh -L 8480:127.0.0.1:8480 HOST`)"
            );
        }
        let host = host.to_string().trim_matches(['[', ']']).to_owned();
        let port = url.port_or_known_default().context("--console names no port")?;
        Ok(Self { host, port, is_encrypted })
    }

    /// Host and port, as a request names them.
    pub fn authority(&self) -> String {
        if self.host.contains(':') {
            format!("[{}]:{}", self.host, self.port)
        } else {
            format!("{}:{}", self.host, self.port)
        }
    }
}

fn is_loopback(host: &Host<&str>) -> bool {
    match host {
        Host::Domain(name) => *name == "localhost",
        Host::Ipv4(address) => address.is_loopback(),
        Host::Ipv6(address) => address.is_loopback(),
    }
}

/// Namespace and name of the node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodePath {
    /// Begins with a slash.
    pub namespace: String,
    /// The last part.
    pub name: String,
}

impl NodePath {
    /// Reads `NAME`, or `NAMESPACE/NAME`.
    ///
    /// # Errors
    /// If ROS 2 permits no such name.
    pub fn parse(text: &str) -> Result<Self> {
        let parts: Vec<&str> = text.strip_prefix('/').unwrap_or(text).split('/').collect();
        let is_usable = |part: &&str| {
            part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                && !part.contains("__")
        };
        match parts.split_last() {
            Some((name, namespace)) if parts.iter().all(is_usable) => {
                Ok(Self { namespace: format!("/{}", namespace.join("/")), name: (*name).to_owned() })
            }
            _ => bail!(
                "--namespace {text} is no name of ROS 2: give parts of letters, digits and single \
                 underscores that begin with no digit, such as uav1/barrelman"
            ),
        }
    }

    /// The whole name without the leading slash.
    pub fn relative(&self) -> String {
        format!("{}/{}", self.namespace, self.name).trim_start_matches('/').to_owned()
    }

    /// The whole name.
    pub fn absolute(&self) -> String {
        format!("/{}", self.relative())
    }
}

/// What the program needs to begin.
pub struct Settings {
    /// Where the console is.
    pub address: Address,
    /// The token; `None`: the console asks for none.
    pub token: Option<String>,
    /// The certificate authorities, where the line is encrypted: a PEM file.
    pub authorities: Option<Vec<u8>>,
    /// The node.
    pub node: NodePath,
    /// The addresses by which DDS is spoken; empty: all.
    pub dds_addresses: Vec<IpAddr>,
}

impl Settings {
    /// Reads the files that the command line names.
    ///
    /// # Errors
    /// If a value or a file is not usable. No message repeats a token.
    pub fn read(cli: &Cli) -> Result<Self> {
        let address = Address::parse(&cli.console)?;
        let authorities = match (&cli.ca, address.is_encrypted) {
            (Some(path), true) => Some(input::read(path)?),
            (None, false) => None,
            (Some(_), false) => {
                bail!("--ca is for a console over https://, and --console is {}", cli.console)
            }
            (None, true) => bail!(
                "--console {}: give --ca FILE, the certificate authority of the console: download \
                 /authority.pem, and compare its SHA-256 with the one that barrelman prints",
                cli.console
            ),
        };
        let token = cli.token_file.as_deref().map(|path| {
            let text = String::from_utf8(input::read(path)?).context("it is not UTF-8 text");
            text.and_then(|text| token(&text)).with_context(|| format!("--token-file {}", path.display()))
        });
        Ok(Self {
            address,
            token: token.transpose()?,
            authorities,
            node: NodePath::parse(&cli.namespace)?,
            dds_addresses: cli.dds_address.clone(),
        })
    }
}

/// The token of a file.
fn token(text: &str) -> Result<String> {
    let token = text.lines().next().unwrap_or_default().trim();
    if token.is_empty() || !token.chars().all(|c| c.is_ascii_alphanumeric() || "-_.~".contains(c)) {
        bail!("the first line must be a token of the console: letters, digits and - _ . ~");
    }
    Ok(token.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Result<(&str, u16, bool), &str>) {
        let found = Address::parse(text);
        match expected {
            Ok((host, port, is_encrypted)) => {
                assert_eq!(found.unwrap(), Address { host: host.to_owned(), port, is_encrypted }, "{text}");
            }
            Err(says) => {
                let error = format!("{:#}", found.expect_err(text));
                assert!(error.contains(says), "{text}: {error}");
            }
        }
    }

    #[test]
    fn plain_http_is_for_loopback_alone() {
        check("http://127.0.0.1:8480", Ok(("127.0.0.1", 8480, false)));
        check("http://127.9.8.7:8480/", Ok(("127.9.8.7", 8480, false)));
        check("http://localhost:8480", Ok(("localhost", 8480, false)));
        check("http://[::1]:8480", Ok(("::1", 8480, false)));
        check("https://192.168.1.5:8480", Ok(("192.168.1.5", 8480, true)));
        check("https://boat.local", Ok(("boat.local", 443, true)));
        for host in [
            "192.168.1.5",
            "0.0.0.0",
            "[2001:db8::1]",
            "boat.local",
            "localhost.example",
            "127.0.0.1.example",
        ] {
            check(&format!("http://{host}:8480"), Err("readable on the network"));
        }
    }

    #[test]
    fn an_address_is_host_and_port_alone() {
        for text in ["https://h/path", "https://h/?a", "https://h/#token=a", "https://u@h", "https://:p@h"] {
            check(text, Err("a token belongs into the file"));
        }
        check("ws://127.0.0.1:8480", Err("begins with http:// or https://"));
        check("127.0.0.1:8480", Err("is no address"));
    }

    #[test]
    fn an_authority_names_host_and_port() {
        for (text, expected) in
            [("http://[::1]:8480", "[::1]:8480"), ("https://boat.local", "boat.local:443")]
        {
            assert_eq!(Address::parse(text).unwrap().authority(), expected);
        }
    }

    #[test]
    fn a_node_has_a_name_that_ros_permits() {
        for (text, namespace, name) in [
            ("barrelman", "/", "barrelman"),
            ("/barrelman", "/", "barrelman"),
            ("uav1/a/eye_2", "/uav1/a", "eye_2"),
        ] {
            let found = NodePath::parse(text).unwrap();
            assert_eq!((found.namespace.as_str(), found.name.as_str()), (namespace, name));
            assert_eq!(found.absolute(), format!("/{}", text.trim_start_matches('/')));
        }
        for text in ["", "/", "a/", "a//b", "1a", "a/2b", "a-b", "a__b", "ä", "~"] {
            assert!(NodePath::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_token_is_the_first_line() {
        assert_eq!(token("control-0123456789\nwatch-0123456789\n").unwrap(), "control-0123456789");
        for text in ["", "\n", "with space\n", "two\u{7}"] {
            let error = format!("{:#}", token(text).expect_err(text));
            assert!(!error.contains("with"), "{error}");
        }
    }
}
