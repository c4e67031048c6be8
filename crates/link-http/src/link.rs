//! A link to a vehicle that answers requests over HTTP.

use std::sync::Arc;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::handle::LinkError;
use barrelman_link::port_io::PortIo as _;
use barrelman_link::{LinkHandle, LinkReport, Mailbox, Worker};
use barrelman_wire::LinkHistory;
use barrelman_wire::fotokite_sigma::FotokiteSigmaSession;

use crate::port::HttpIo;
use crate::settings::HttpSettings;

/// Opens the link: the vehicle is reached, and the threads `link` and `http` are started. `report` takes the reports; it must
/// not block, and returns whether there was room.
///
/// # Errors
/// If the vehicle cannot be reached now, or an API key is refused. The thread reaches for a vehicle that is lost later.
pub fn open_link(
    settings: HttpSettings,
    faults: FaultPlan,
    clock: Clock,
    report: impl Fn(LinkReport) -> bool + Send + 'static,
) -> Result<LinkHandle, LinkError> {
    let mailbox = Arc::new(Mailbox::new()?);
    let io = HttpIo { settings, clock, mailbox: Arc::clone(&mailbox) };
    let port = io.open()?;
    let worker: Worker<FotokiteSigmaSession, _, _> = Worker {
        persistence: Duration::ZERO,
        mailbox,
        io,
        history: LinkHistory::default(),
        open_session: Arc::new(|now| Box::new(FotokiteSigmaSession::open(now))),
        report,
    };
    Ok(LinkHandle::start(worker, Some(port), faults)?)
}
