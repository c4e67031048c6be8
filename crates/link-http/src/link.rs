//! A link to a vehicle that answers requests over HTTP.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::handle::LinkError;
use barrelman_link::port_io::PortIo as _;
use barrelman_link::{LinkHandle, LinkReport, Mailbox, Worker};
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::fotokite_sigma::FotokiteSigmaSession;
use barrelman_wire::http::{HttpCall, Received, Request};
use barrelman_wire::onvif::OnvifSession;
use barrelman_wire::{LinkHistory, Session};

use crate::port::{HttpIo, Reach};
use crate::settings::{HttpProtocol, HttpSettings, SigmaAccess};
use crate::{fotokite_sigma, onvif};

/// Opens the link: the vehicle is reached, and the threads `link` and `http` are started. `report` takes the
/// reports; it must not block, and returns whether there was room.
///
/// # Errors
/// If the vehicle cannot be reached now, or an API key is refused. The thread reaches for a vehicle that is
/// lost later.
pub fn open_link(
    settings: HttpSettings,
    faults: FaultPlan,
    clock: Clock,
    report: impl Fn(LinkReport) -> bool + Send + 'static,
) -> Result<LinkHandle, LinkError> {
    match settings.protocol.clone() {
        HttpProtocol::FotokiteSigma(SigmaAccess { credential, stream, full_zoom }) => {
            let reach = move |settings: &HttpSettings| fotokite_sigma::reach(settings, &credential);
            let opener = move |now| Box::new(FotokiteSigmaSession::open(stream.clone(), full_zoom, now));
            open(settings, reach, Arc::new(opener), faults, clock, report)
        }
        HttpProtocol::Onvif(onvif) => {
            let seed = onvif::seed()?;
            let count = AtomicU64::new(0);
            let to_reach = onvif.clone();
            let reach = move |settings: &HttpSettings| onvif::reach(settings, &to_reach);
            let opener = move |now| {
                let seed = with_count(seed, count.fetch_add(1, Ordering::Relaxed));
                Box::new(OnvifSession::open(&onvif, seed, now))
            };
            open(settings, reach, Arc::new(opener), faults, clock, report)
        }
    }
}

/// Opens the link of a protocol.
fn open<S, C: HttpCall>(
    settings: HttpSettings,
    reach: impl Reach + Send + 'static,
    open_session: Arc<dyn Fn(Timestamp) -> Box<S> + Send + Sync>,
    faults: FaultPlan,
    clock: Clock,
    report: impl Fn(LinkReport) -> bool + Send + 'static,
) -> Result<LinkHandle, LinkError>
where
    S: Session<Sent = Request<C>, Received = Received, Command = VehicleRates> + 'static,
{
    let mailbox = Arc::new(Mailbox::new()?);
    let io = HttpIo { settings, reach, clock, mailbox: Arc::clone(&mailbox), calls: PhantomData };
    let port = io.open()?;
    let worker: Worker<S, _, _> = Worker {
        persistence: Duration::ZERO,
        mailbox,
        io,
        history: LinkHistory::default(),
        open_session,
        report,
    };
    Ok(LinkHandle::start(worker, Some(port), faults)?)
}

/// The seed of the session of this number.
fn with_count(mut seed: [u8; 16], count: u64) -> [u8; 16] {
    for (byte, changed) in seed.iter_mut().zip(count.to_le_bytes()) {
        *byte ^= changed;
    }
    seed
}
