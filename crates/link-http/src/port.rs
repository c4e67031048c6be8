//! The port: the thread `http` with a connection for each lane, and what the link's thread sees of it.

use std::io;
use std::marker::PhantomData;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_link::mailbox::Mailbox;
use barrelman_link::port::PortError;
use barrelman_link::port_io::{PortIo, wait_for_port};
use barrelman_vocab::Timestamp;
use barrelman_wire::http::{HttpCall, Lane, Received, Request};
use tokio::sync::mpsc::{Sender, channel};
use tokio::sync::oneshot;

use crate::inbox::Inbox;
use crate::inquiry::{Inquiry, not_usable};
use crate::lane::Queued;
use crate::settings::HttpSettings;
use crate::{lane, socket};

/// Requests that wait in a lane: the session has one under way, and the next only after the time of the
/// first.
const LANE_CAPACITY: usize = 2;

/// Reaches a vehicle, so far that its calls can be sent.
pub(crate) trait Reach: Fn(&HttpSettings) -> Result<Inquiry, PortError> {}
impl<R: Fn(&HttpSettings) -> Result<Inquiry, PortError>> Reach for R {}

/// An open port. Dropping it closes all its connections.
#[derive(Debug)]
pub struct HttpPort {
    lanes: Vec<(Lane, Sender<Queued>)>,
    inbox: Arc<Inbox>,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl HttpPort {
    /// Reaches the vehicle and starts the thread, with a connection for each of the lanes.
    ///
    /// # Errors
    /// [`PortError`] names the address and the remedy.
    pub(crate) fn open(
        settings: &HttpSettings,
        reach: impl Reach,
        lanes: &[Lane],
    ) -> Result<Self, PortError> {
        let (runtime, connector) = reach(settings)?.into_parts();
        let fails = |error: io::Error| not_usable(settings, error.to_string());
        let inbox = Arc::new(Inbox::new().map_err(fails)?);
        let start = |lane: &Lane| {
            let (requests, queue) = channel(LANE_CAPACITY);
            let (connector, inbox) = (connector.clone(), Arc::clone(&inbox));
            match lane {
                Lane::Socket => drop(runtime.spawn(socket::serve(connector, queue, inbox))),
                _ => drop(runtime.spawn(lane::serve(connector, queue, inbox))),
            }
            (*lane, requests)
        };
        let lanes = lanes.iter().map(start).collect();
        let (end, ended) = oneshot::channel();
        let thread = std::thread::Builder::new()
            .name("http".to_owned())
            .spawn(move || {
                let _ = runtime.block_on(ended);
            })
            .map_err(fails)?;
        Ok(Self { lanes, inbox, end: Some(end), thread: Some(thread) })
    }

    fn send<C: HttpCall>(&self, request: &Request<C>) {
        let lane = self.lanes.iter().find(|(lane, _)| *lane == request.lane);
        if lane.is_none_or(|(_, requests)| requests.try_send(Queued::now(request)).is_err()) {
            // A lane that cannot take it within its time would send it too late.
            self.inbox.put(Received::NoAnswer { id: request.id });
        }
    }
}

impl Drop for HttpPort {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;

/// The program's clock and a port of HTTP, for the calls of a protocol.
pub(crate) struct HttpIo<C, R> {
    pub(crate) settings: HttpSettings,
    pub(crate) reach: R,
    pub(crate) clock: Clock,
    pub(crate) mailbox: Arc<Mailbox>,
    pub(crate) calls: PhantomData<fn(C)>,
}

impl<C: HttpCall, R: Reach> PortIo for HttpIo<C, R> {
    type Port = HttpPort;
    type Sent = Request<C>;
    type Received = Received;

    fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn open(&self) -> Result<HttpPort, PortError> {
        HttpPort::open(&self.settings, &self.reach, C::LANES)
    }

    fn send(&self, port: &mut HttpPort, request: &Request<C>) -> io::Result<()> {
        port.send(request);
        Ok(())
    }

    fn receive(&self, port: &mut HttpPort, each: &mut dyn FnMut(&Received)) -> io::Result<()> {
        port.inbox.take().iter().for_each(each);
        Ok(())
    }

    fn wait(&self, port: Option<&HttpPort>, wait: Duration) -> bool {
        wait_for_port(&self.mailbox, port.map(|port| &*port.inbox), wait)
    }

    fn sleep(&self, pause: Duration) {
        std::thread::sleep(pause);
    }
}
