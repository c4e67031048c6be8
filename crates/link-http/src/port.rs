//! The port: the thread `http` with a connection for each lane, and what the link's thread sees of it.

use std::io;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_link::mailbox::Mailbox;
use barrelman_link::port::PortError;
use barrelman_link::port_io::{PortIo, wait_for_port};
use barrelman_vocab::Timestamp;
use barrelman_wire::fotokite_sigma::Received;
use barrelman_wire::fotokite_sigma::call::{Lane, Request};
use tokio::sync::mpsc::{Sender, channel};
use tokio::sync::oneshot;
use tokio::time::Instant;

use crate::inbox::Inbox;
use crate::inquiry::Inquiry;
use crate::lane::Queued;
use crate::settings::HttpSettings;
use crate::{lane, socket};

/// Requests that wait in a lane: the session has one under way, and the next only after the time of the first.
const LANE_CAPACITY: usize = 2;

/// An open port. Dropping it closes all its connections.
#[derive(Debug)]
pub struct HttpPort {
    lanes: [Sender<Queued>; Lane::ALL.len()],
    inbox: Arc<Inbox>,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl HttpPort {
    /// Reaches the vehicle and starts the thread.
    ///
    /// # Errors
    /// [`PortError`] names the address and the remedy.
    pub fn open(settings: &HttpSettings) -> Result<Self, PortError> {
        let (runtime, connector, token) = Inquiry::open(settings)?.into_parts();
        let fails = |error: io::Error| PortError::NotUsable {
            address: settings.address.to_string(),
            reason: error.to_string(),
        };
        let inbox = Arc::new(Inbox::new().map_err(fails)?);
        let token: Arc<str> = token.into();
        let lanes = Lane::ALL.map(|lane| {
            let (requests, queue) = channel(LANE_CAPACITY);
            let (connector, token, inbox) = (connector.clone(), Arc::clone(&token), Arc::clone(&inbox));
            match lane {
                Lane::Socket => drop(runtime.spawn(socket::serve(connector, token, queue, inbox))),
                _ => drop(runtime.spawn(lane::serve(connector, token, queue, inbox))),
            }
            requests
        });
        let (end, ended) = oneshot::channel();
        let thread = std::thread::Builder::new()
            .name("http".to_owned())
            .spawn(move || {
                let _ = runtime.block_on(ended);
            })
            .map_err(fails)?;
        Ok(Self { lanes, inbox, end: Some(end), thread: Some(thread) })
    }

    fn send(&self, request: &Request) {
        let at = Lane::ALL.iter().position(|lane| *lane == request.lane).unwrap_or_default();
        let queued = Queued { request: request.clone(), handed_over_at: Instant::now() };
        if self.lanes[at].try_send(queued).is_err() {
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

/// The program's clock and a port of HTTP.
#[derive(Debug)]
pub(crate) struct HttpIo {
    pub(crate) settings: HttpSettings,
    pub(crate) clock: Clock,
    pub(crate) mailbox: Arc<Mailbox>,
}

impl PortIo for HttpIo {
    type Port = HttpPort;
    type Sent = Request;
    type Received = Received;

    fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn open(&self) -> Result<HttpPort, PortError> {
        HttpPort::open(&self.settings)
    }

    fn send(&self, port: &mut HttpPort, request: &Request) -> io::Result<()> {
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
