//! A link to a port by a thread of this process.

use std::io;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_vocab::{LinkCommand, Timestamp, VehicleRates};
use barrelman_wire::{ByteSession, LinkHistory, OpenSession, Session};

use crate::dead_mans_switch::RequestedCommand;
use crate::mailbox::Mailbox;
use crate::port::PortError;
use crate::port_io::{MachineIo, PortIo};
use crate::report::LinkReport;
use crate::url::LinkUrl;
use crate::worker::Worker;

/// A link cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The port cannot be opened.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The system has no more threads or file descriptors.
    #[error("the link's thread cannot be started")]
    System(#[from] io::Error),
}

/// A worker at a port that carries bytes.
type ByteWorker<C, R> = Worker<ByteSession<C>, MachineIo<C>, R>;

/// A link to a port. Dropping the handle ends the link: zeros, stop, and the port is closed.
#[derive(Debug)]
pub struct LinkHandle<C: LinkCommand = VehicleRates> {
    mailbox: Arc<Mailbox<C>>,
    thread: Option<JoinHandle<()>>,
}

impl<C: LinkCommand> LinkHandle<C> {
    /// Opens the port and starts the link thread. `report` takes the reports of the thread; it must not
    /// block, and returns whether there was room for the report.
    ///
    /// # Errors
    /// If the port cannot be opened, unless the vehicle may come ([`PortError::may_pass`]): that is reported,
    /// and the thread goes on trying, as it does with a port that is lost later.
    pub fn open(
        url: &LinkUrl,
        protocol: impl OpenSession<Command = C>,
        clock: Clock,
        report: impl Fn(LinkReport) -> bool + Send + 'static,
    ) -> Result<Self, LinkError> {
        let worker = Self::worker(url, protocol, clock, report)?;
        let port = match worker.io.open() {
            Ok(port) => Some(port),
            Err(error) if error.may_pass() => {
                (worker.report)(LinkReport::NotReached(error.to_string()));
                None
            }
            Err(error) => return Err(error.into()),
        };
        Ok(Self::start(worker, port, url.faults.clone())?)
    }

    /// Stops a vehicle that a link before may have left moving: zeros and stop, once.
    ///
    /// # Errors
    /// If the port cannot be opened.
    pub fn stop(
        url: &LinkUrl,
        protocol: impl OpenSession<Command = C>,
        clock: Clock,
        history: LinkHistory,
    ) -> Result<bool, LinkError> {
        let worker = Self::worker(url, protocol, clock, |_| true)?;
        let port = worker.io.open()?;
        Ok(Self::start(Worker { history, ..worker }, Some(port), url.faults.clone())?.close())
    }

    fn worker<R: Fn(LinkReport) -> bool>(
        url: &LinkUrl,
        protocol: impl OpenSession<Command = C>,
        clock: Clock,
        report: R,
    ) -> io::Result<ByteWorker<C, R>> {
        let mailbox = Arc::new(Mailbox::new()?);
        let io = MachineIo { endpoint: url.endpoint.clone(), clock, mailbox: Arc::clone(&mailbox) };
        Ok(Worker {
            persistence: Duration::ZERO,
            mailbox: Arc::clone(&mailbox),
            io,
            history: LinkHistory::default(),
            open_session: Arc::new(move |now| protocol.open(now)),
            report,
        })
    }

    /// Starts the thread of a worker on its port (`None`: it opens the port), which has these deliberate
    /// faults, if there are any: for vehicles of any packets.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn start<S, I, R>(
        worker: Worker<S, I, R>,
        port: Option<I::Port>,
        faults: FaultPlan,
    ) -> io::Result<Self>
    where
        S: Session<Command = C> + ?Sized + 'static,
        I: PortIo<Sent = S::Sent, Received = S::Received> + Send + 'static,
        I::Port: Send,
        R: Fn(LinkReport) -> bool + Send + 'static,
    {
        let mailbox = Arc::clone(&worker.mailbox);
        let work = move || worker.run(port, faults);
        let thread = std::thread::Builder::new().name("link".to_owned()).spawn(work)?;
        Ok(Self { mailbox, thread: Some(thread) })
    }

    /// Requests a command (rates in the vehicle's own signs), and replaces the one requested before. A
    /// command that moves something is in force until `renew_by`: without a renewal by then, the link rests
    /// the vehicle.
    pub fn send(&self, command: C, renew_by: Option<Timestamp>) {
        self.mailbox.request(RequestedCommand { command, renew_by });
    }

    /// The operator takes the control of the vehicle back, if another client has taken it.
    pub fn take_control(&self) {
        self.mailbox.take_control();
    }

    /// Ends the link: zeros, half a second, stop. Returns whether they were sent, or nothing ever was.
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

impl<C: LinkCommand> Drop for LinkHandle<C> {
    fn drop(&mut self) {
        self.end();
    }
}
