//! The address of its video that a vehicle names: what may be opened of it.
//!
//! Who answers for the vehicle, or speaks in its name, chooses no file, no simulated world, no other machine
//! and no login. Only `rtsp://` and `rtsps://` are opened, on the host of the link, or on the host that the
//! configuration names (`link.video_host`). The vehicle's text is never looked up in the DNS.

use std::net::{IpAddr, ToSocketAddrs as _};

use barrelman_video::VideoUrl;

/// Longest address.
const MAX_BYTES: usize = 1024;

/// The hosts on which a vehicle may name its video, without brackets.
#[derive(Debug, Clone, Copy)]
pub struct PermittedHosts<'a> {
    /// The host of the link.
    pub link: &'a str,
    /// The host that the configuration names.
    pub configured: Option<&'a str>,
}

/// Why the address that a vehicle names is not opened. No message repeats the address.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamedVideoError {
    /// The address is too long, or holds what no address has.
    #[error("the vehicle names an address of its video that cannot be read")]
    Unreadable,
    /// The scheme.
    #[error("the vehicle names its video by the scheme {0:?}, and only rtsp and rtsps are opened")]
    Scheme(String),
    /// A login in the address.
    #[error("the vehicle names an address of its video with a login, and a vehicle chooses no login")]
    Login,
    /// Another host.
    #[error(
        "the vehicle names its video on the host {found:?}, which is not its own ({link}): if that is right, permit it by \
         link.video_host = {found:?} in the configuration"
    )]
    Host {
        /// The host that is named.
        found: String,
        /// The host of the link.
        link: String,
    },
    /// An option of this program.
    #[error("the vehicle names an address of its video with the option {0}=, which is this program's own")]
    Option(&'static str),
}

/// Checks the address that a vehicle names, and reads it.
///
/// # Errors
/// [`NamedVideoError`] says what is not opened.
pub fn named_video(text: &str, hosts: PermittedHosts<'_>) -> Result<VideoUrl, NamedVideoError> {
    named_video_with(text, hosts, &addresses_of)
}

fn named_video_with(
    text: &str,
    hosts: PermittedHosts<'_>,
    resolve: &dyn Fn(&str) -> Vec<IpAddr>,
) -> Result<VideoUrl, NamedVideoError> {
    let is_plain = text.len() <= MAX_BYTES && text.bytes().all(|byte| byte.is_ascii_graphic());
    let (scheme, rest) = text.split_once(':').filter(|_| is_plain).ok_or(NamedVideoError::Unreadable)?;
    if !["rtsp", "rtsps"].contains(&scheme) {
        let shown: String = scheme.chars().take(16).collect();
        return Err(NamedVideoError::Scheme(shown));
    }
    if !rest.starts_with("//") {
        return Err(NamedVideoError::Unreadable);
    }
    if text.contains('@') {
        return Err(NamedVideoError::Login);
    }
    if text.contains(['\\', '#']) {
        return Err(NamedVideoError::Unreadable);
    }
    if let Some(name) = VideoUrl::options_in(text).next() {
        return Err(NamedVideoError::Option(name));
    }
    let url = VideoUrl::parse_stream(text).map_err(|_| NamedVideoError::Unreadable)?;
    let (found, _) = url.server().ok_or(NamedVideoError::Unreadable)?;
    let is_permitted = is_same(&found, hosts.link, resolve)
        || hosts.configured.is_some_and(|configured| is_same(&found, configured, resolve));
    if !is_permitted {
        return Err(NamedVideoError::Host { found, link: hosts.link.to_owned() });
    }
    Ok(url)
}

/// Whether a host that a vehicle names is a host of the configuration. Only the configured one is looked up.
fn is_same(found: &str, configured: &str, resolve: &dyn Fn(&str) -> Vec<IpAddr>) -> bool {
    let address =
        |host: &str| host.trim_matches(['[', ']']).parse::<IpAddr>().ok().map(|ip| ip.to_canonical());
    let name = |host: &str| host.trim_end_matches('.').to_ascii_lowercase();
    match (address(found), address(configured)) {
        (Some(found), Some(configured)) => found == configured,
        (Some(found), None) => resolve(configured).into_iter().any(|ip| ip.to_canonical() == found),
        (None, None) => name(found) == name(configured),
        (None, Some(_)) => false,
    }
}

fn addresses_of(host: &str) -> Vec<IpAddr> {
    (host, 0).to_socket_addrs().map(|found| found.map(|address| address.ip()).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve(host: &str) -> Vec<IpAddr> {
        assert_eq!(host, "sigma.example", "only the configured host is looked up");
        vec!["192.0.2.7".parse().unwrap()]
    }

    #[track_caller]
    fn check(text: &str, link: &str, configured: Option<&str>, expected: Result<(), &str>) {
        let got = named_video_with(text, PermittedHosts { link, configured }, &resolve);
        match (got.map(|_| ()).map_err(|error| error.to_string()), expected) {
            (Ok(()), Ok(())) => {}
            (Err(error), Err(part)) => assert!(error.contains(part), "{text}: {error}"),
            (got, expected) => panic!("{text}: {got:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn a_vehicle_names_its_video_on_its_own_host_alone() {
        for (text, link) in [
            ("rtsp://192.0.2.7:8554/zoom", "192.0.2.7"),
            ("rtsps://192.0.2.7/zoom?profile=2", "192.0.2.7"),
            ("rtsp://SIGMA.example/zoom", "sigma.example."),
            ("rtsp://192.0.2.7/zoom", "sigma.example"),
            ("rtsp://[::ffff:192.0.2.7]/zoom", "192.0.2.7"),
            ("rtsp://[2001:db8:0::1]:8554/zoom", "2001:db8::1"),
        ] {
            check(text, link, None, Ok(()));
        }
        for text in [
            "rtsp://198.51.100.1/zoom",
            "rtsp://other.example/zoom",
            "rtsp://192.0.2.7.other.example/zoom",
            "rtsp://3221225991/zoom",
            "rtsp://0xc0000207/zoom",
            "rtsp://192.0.2.07/zoom",
            "rtsp://192%2e0.2.7/zoom",
            "rtsp://[2001:db8::2]/zoom",
        ] {
            check(text, "192.0.2.7", None, Err("link.video_host"));
        }
        check("rtsp://198.51.100.1/zoom", "192.0.2.7", Some("198.51.100.1"), Ok(()));
        check("rtsp://198.51.100.2/zoom", "192.0.2.7", Some("198.51.100.1"), Err("link.video_host"));
    }

    #[test]
    fn a_vehicle_chooses_no_scheme_no_login_and_no_option() {
        for (text, part) in [
            ("sim:arena1", "\"sim\""),
            ("SIM:arena1", "\"SIM\""),
            ("file:/etc/passwd", "\"file\""),
            ("file:///etc/passwd", "\"file\""),
            ("RTSP://192.0.2.7/x", "\"RTSP\""),
            ("http://192.0.2.7/x", "\"http\""),
            ("rtsp+unix://192.0.2.7/x", "only rtsp"),
            ("/etc/passwd", "cannot be read"),
            ("clip.mp4", "cannot be read"),
            ("", "cannot be read"),
            ("rtsp:clip.mp4", "cannot be read"),
            ("rtsp:///x", "cannot be read"),
            ("rtsp://192.0.2.7/a b", "cannot be read"),
            ("rtsp://192.0.2.7\n/x", "cannot be read"),
            ("rtsp://192.0.2.7:99999/x", "cannot be read"),
            ("rtsp://192.0.2.7\\.other.example/x", "cannot be read"),
            ("rtsp://192.0.2.7/x#y", "cannot be read"),
            ("rtsp://user:pw@192.0.2.7/x", "login"),
            ("rtsp://192.0.2.7@other.example/x", "login"),
            ("rtsp://192.0.2.7/x?fault=stall@1", "login"),
            ("rtsp://192.0.2.7/x?fault=stall%401", "fault="),
            ("rtsp://192.0.2.7/x?a=1&transport=udp", "transport="),
        ] {
            check(text, "192.0.2.7", None, Err(part));
        }
        let long = format!("rtsp://192.0.2.7/{}", "x".repeat(MAX_BYTES));
        check(&long, "192.0.2.7", None, Err("cannot be read"));
    }
}
