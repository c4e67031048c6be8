//! The link to a port as the rest of the program uses it.

use std::sync::Arc;
use std::thread::JoinHandle;

use barrelman_host::clock::Clock;
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::ByteProtocol;

use super::dead_mans_switch::RequestedRates;
use super::mailbox::Mailbox;
use super::port_io::{MachineIo, PortIo as _};
use super::report::LinkReport;
use super::url::LinkUrl;
use super::worker::Worker;

/// A link to a port. Dropping the handle ends the link: zeros, stop, and the port is closed.
#[derive(Debug)]
pub struct LinkHandle {
    mailbox: Arc<Mailbox>,
    thread: Option<JoinHandle<()>>,
}

impl LinkHandle {
    /// Opens the port and starts the link thread. `report` takes the reports of the thread; it must not block, and returns
    /// whether there was room for the report.
    ///
    /// # Errors
    /// If the port cannot be opened now. The thread reopens a port that is lost later.
    pub fn open(
        url: &LinkUrl,
        protocol: ByteProtocol,
        clock: Clock,
        report: impl Fn(LinkReport) -> bool + Send + 'static,
    ) -> anyhow::Result<Self> {
        let mailbox = Arc::new(Mailbox::new()?);
        let io = MachineIo { endpoint: url.endpoint.clone(), clock, mailbox: Arc::clone(&mailbox) };
        let port = io.open()?;
        let worker = Worker {
            url: url.clone(),
            mailbox: Arc::clone(&mailbox),
            io,
            open_session: Box::new(move |now| protocol.open(now)),
            report,
        };
        let thread = std::thread::Builder::new().name("link".to_owned()).spawn(move || worker.run(port))?;
        Ok(Self { mailbox, thread: Some(thread) })
    }

    /// Requests rates, in the vehicle's own signs, and replaces the rates requested before. Rates that move the camera
    /// are in force until `renew_by`: without a renewal by then, the link rests the camera.
    pub fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.mailbox.request(RequestedRates { rates, renew_by });
    }

    /// Ends the link: zeros, half a second, stop. Returns whether they were sent.
    pub fn close(mut self) -> bool {
        self.end()
    }

    fn end(&mut self) -> bool {
        let Some(thread) = self.thread.take() else { return true };
        self.mailbox.close();
        // The thread bounds the time of its own closing, and catches its own panics.
        thread.join().is_ok() && self.mailbox.is_stop_sent()
    }
}

impl Drop for LinkHandle {
    fn drop(&mut self) {
        self.end();
    }
}
