//! Where the commands of a run go.

use barrelman_link::LinkUrl;
use barrelman_link::url::Endpoint;
use barrelman_pilot::CommandPath;

/// Where the commands of a run with this link go.
pub fn command_path(link: Option<&LinkUrl>) -> CommandPath {
    match link.map(|link| &link.endpoint) {
        None => CommandPath::DryRun,
        Some(Endpoint::SimulatedCamera) => CommandPath::Simulated,
        Some(_) => CommandPath::Link,
    }
}
