//! Which requests are answered at all: those for a name of this server, and from its own page or from no
//! page.
//!
//! A foreign web site can point its own name at this server's address (DNS rebinding), or make a browser send
//! requests here. Both show in the headers `Host`, `Origin` and `Sec-Fetch-Site`. An address in numbers
//! cannot be a foreign name, so that a server for other machines answers to its addresses, and to the names
//! of its configuration.

use std::net::IpAddr;

use super::origin::{Origin, Scheme};

/// The names that a server answers to.
#[derive(Debug, Clone)]
pub(super) struct Hosts {
    origin: Origin,
    names: Vec<String>,
}

/// The headers that are judged.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Provenance<'a> {
    pub(super) host: Option<&'a str>,
    pub(super) origin: Option<&'a str>,
    pub(super) fetch_site: Option<&'a str>,
    /// Whether the request opens the page itself: a link elsewhere may lead here.
    pub(super) opens_page: bool,
}

impl Hosts {
    /// The names of a server; `names`: further names, without port.
    pub(super) fn new(origin: Origin, names: Vec<String>) -> Self {
        Self { origin, names }
    }

    /// Why a request is refused; `None`: it is answered.
    pub(super) fn refusal(&self, request: Provenance<'_>) -> Option<&'static str> {
        let Some(host) = request.host else { return Some("the request names no host") };
        if !self.is_own(host) {
            return Some("this server answers to its own names only; add the name to console.hosts");
        }
        if let Some(origin) = request.origin {
            // A server without TLS may be behind a proxy with it. A page without TLS is never this server's
            // own where it has TLS.
            let plain = origin.strip_prefix("http://").filter(|_| self.origin.scheme == Scheme::Http);
            let authority = plain.or_else(|| origin.strip_prefix("https://"));
            if authority != Some(host) {
                return Some("requests of other web pages are refused");
            }
        }
        let is_foreign = request.fetch_site.is_some_and(|site| site != "same-origin" && site != "none");
        (is_foreign && !request.opens_page).then_some("requests of other web pages are refused")
    }

    fn is_own(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port.parse().ok()),
            _ => (host, Some(self.origin.scheme.usual_port())),
        };
        if port != Some(self.origin.address.port()) {
            return self.names.iter().any(|own| own.eq_ignore_ascii_case(host));
        }
        let numbers = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        match numbers {
            Ok(address) => address.is_loopback() || !self.origin.address.ip().is_loopback(),
            Err(_) => {
                name.eq_ignore_ascii_case("localhost")
                    || self.names.iter().any(|own| own.eq_ignore_ascii_case(name))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hosts(address: &str) -> Hosts {
        hosts_of(Scheme::Http, address)
    }

    fn hosts_of(scheme: Scheme, address: &str) -> Hosts {
        Hosts::new(Origin { scheme, address: address.parse().unwrap() }, vec!["boat.example".to_owned()])
    }

    #[test]
    fn a_server_answers_to_its_own_names_only() {
        for (address, host, is_answered) in [
            ("127.0.0.1:8480", "127.0.0.1:8480", true),
            ("127.0.0.1:8480", "localhost:8480", true),
            ("127.0.0.1:8480", "[::1]:8480", true),
            ("127.0.0.1:8480", "boat.example:8480", true),
            ("127.0.0.1:8480", "192.168.1.7:8480", false),
            ("127.0.0.1:8480", "127.0.0.1:8481", false),
            ("127.0.0.1:8480", "evil.example:8480", false),
            ("127.0.0.1:8480", "127.0.0.1", false),
            ("0.0.0.0:8480", "192.168.1.7:8480", true),
            ("0.0.0.0:8480", "[fe80::1]:8480", true),
            ("0.0.0.0:8480", "boat.example:8480", true),
            ("0.0.0.0:8480", "evil.example:8480", false),
            ("0.0.0.0:80", "192.168.1.7", true),
        ] {
            let request = Provenance { host: Some(host), ..Provenance::default() };
            assert_eq!(hosts(address).refusal(request).is_none(), is_answered, "{address} {host}");
        }
        assert!(hosts("127.0.0.1:1").refusal(Provenance::default()).is_some(), "no host");
    }

    #[test]
    fn a_server_with_tls_has_its_own_usual_port_and_no_page_without_tls() {
        let hosts = hosts_of(Scheme::Https, "0.0.0.0:443");
        for (host, origin, is_answered) in [
            ("192.168.1.7", Some("https://192.168.1.7"), true),
            ("192.168.1.7:443", None, true),
            ("192.168.1.7:80", None, false),
            ("192.168.1.7", Some("http://192.168.1.7"), false),
            ("192.168.1.7", Some("https://192.168.1.8"), false),
        ] {
            let request = Provenance { host: Some(host), origin, ..Provenance::default() };
            assert_eq!(hosts.refusal(request).is_none(), is_answered, "{host} {origin:?}");
        }
    }

    #[test]
    fn requests_of_foreign_pages_are_refused_off_loopback_too() {
        for address in ["127.0.0.1:8480", "0.0.0.0:8480"] {
            let own = Provenance { host: Some("127.0.0.1:8480"), ..Provenance::default() };
            for (request, is_answered) in [
                (Provenance { origin: Some("http://127.0.0.1:8480"), ..own }, true),
                (Provenance { origin: Some("http://evil.example"), ..own }, false),
                (Provenance { origin: Some("null"), ..own }, false),
                (Provenance { fetch_site: Some("same-origin"), ..own }, true),
                (Provenance { fetch_site: Some("none"), ..own }, true),
                (Provenance { fetch_site: Some("cross-site"), ..own }, false),
                (Provenance { fetch_site: Some("same-site"), ..own }, false),
                (Provenance { fetch_site: Some("cross-site"), opens_page: true, ..own }, true),
            ] {
                assert_eq!(hosts(address).refusal(request).is_none(), is_answered, "{request:?}");
            }
        }
    }

    #[test]
    fn a_host_that_only_looks_like_an_own_name_is_refused() {
        for host in [
            "",
            ":",
            ":8480",
            "[::1",
            "localhost",
            "localhost:",
            "localhost:8480:8480",
            "localhost:84800",
            "localhost.:8480",
            "localhost.evil.example:8480",
            "evil.example#localhost:8480",
            "127.0.0.1:8480@evil.example",
            "127.0.0.1.evil.example:8480",
            "127.1:8480",
            "2130706433:8480",
            "0.0.0.0:8480",
            "[::]:8480",
            "boat.example.evil.example:8480",
            "xboat.example:8480",
        ] {
            let request = Provenance { host: Some(host), ..Provenance::default() };
            assert!(hosts("127.0.0.1:8480").refusal(request).is_some(), "{host:?}");
        }
    }

    #[test]
    fn names_are_compared_without_regard_to_case() {
        for host in ["LOCALHOST:8480", "Boat.Example:8480", "boat.example"] {
            let request = Provenance { host: Some(host), ..Provenance::default() };
            assert_eq!(hosts("127.0.0.1:8480").refusal(request), None, "{host}");
        }
    }

    #[test]
    fn an_origin_is_the_scheme_and_the_host_and_nothing_else() {
        let own = Provenance { host: Some("127.0.0.1:8480"), ..Provenance::default() };
        for (origin, is_answered) in [
            ("http://127.0.0.1:8480", true),
            ("https://127.0.0.1:8480", true),
            ("http://127.0.0.1", false),
            ("http://127.0.0.1:8481", false),
            ("http://localhost:8480", false),
            ("http://127.0.0.1:8480.evil.example", false),
            ("http://127.0.0.1:8480/", false),
            ("http://evil.example@127.0.0.1:8480", false),
            ("file://127.0.0.1:8480", false),
            ("127.0.0.1:8480", false),
            ("", false),
        ] {
            let request = Provenance { origin: Some(origin), ..own };
            assert_eq!(hosts("127.0.0.1:8480").refusal(request).is_none(), is_answered, "{origin:?}");
        }
    }
}
