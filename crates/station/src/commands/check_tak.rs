//! `barrelman check` of where events for TAK go.

use super::check_result::{CheckResult, Verdict};
use super::tak_route::tak_route;
use crate::config::TakConfig;
use crate::tak::{TakAddress, TakRoute, Transport, probe};

/// Checks whether events can be sent. No event is sent.
pub(super) fn check_tak(address: &TakAddress, config: &TakConfig) -> CheckResult {
    let subject = format!("tak {address}");
    let route = match tak_route(address, config) {
        Ok(route) => route,
        Err(error) => return CheckResult::new(subject, Verdict::Failed, format!("{error:#}")),
    };
    let failed = match probe(&route) {
        Ok(own) => {
            let details = match address.transport {
                Transport::Udp => {
                    format!("there is a route, from {own}; whether anyone receives cannot be known")
                }
                Transport::Tcp => format!("takes a connection from {own}"),
                Transport::Tls => {
                    format!("takes a connection from {own}, encrypted; its certificate is accepted")
                }
            };
            return CheckResult::new(subject, Verdict::Ok, details);
        }
        Err(error) => error,
    };
    let remedy = match (address.transport, route) {
        (Transport::Udp, TakRoute::Udp(to) | TakRoute::Tcp(to, _)) => {
            format!("join the network of the displays, or add a route to {}", to.ip())
        }
        (Transport::Tcp, _) => {
            "is a server of TAK running there, and is the port its one without TLS?".to_owned()
        }
        (Transport::Tls, _) => {
            "is the port the server's one with TLS, is its certificate for this name and signed by an authority of \
             tak.ca_file, and does it accept tak.client_certificate?"
                .to_owned()
        }
    };
    CheckResult::new(subject, Verdict::Failed, format!("{failed}: {remedy}"))
}
