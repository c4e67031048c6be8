//! `barrelman check` of where events for TAK go.

use super::check_result::{CheckResult, Verdict};
use crate::tak::{TakAddress, Transport, probe};

/// Checks whether events can be sent. No event is sent.
pub(super) fn check_tak(address: &TakAddress) -> CheckResult {
    let subject = format!("tak {address}");
    let to = match address.resolve() {
        Ok(to) => to,
        Err(error) => return CheckResult::new(subject, Verdict::Failed, format!("{error:#}")),
    };
    match (probe(address.transport, to), address.transport) {
        (Ok(own), Transport::Udp) => {
            let details = format!("there is a route, from {own}; whether anyone receives cannot be known");
            CheckResult::new(subject, Verdict::Ok, details)
        }
        (Ok(own), Transport::Tcp) => {
            CheckResult::new(subject, Verdict::Ok, format!("takes a connection from {own}"))
        }
        (Err(error), Transport::Udp) => {
            let details = format!("{error}: join the network of the displays, or add a route to {}", to.ip());
            CheckResult::new(subject, Verdict::Failed, details)
        }
        (Err(error), Transport::Tcp) => {
            let details =
                format!("{error}: is a server of TAK running there, and is the port its one without TLS?");
            CheckResult::new(subject, Verdict::Failed, details)
        }
    }
}
