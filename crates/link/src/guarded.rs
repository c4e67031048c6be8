//! The link of the program to its guard: starts the guard, passes rates to it and its reports on, and starts
//! another one if it is gone.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::{LinkHistory, OpenSession};

use crate::dead_mans_switch::RequestedCommand;
use crate::guard::message::ToGuard;
use crate::report::LinkReport;

mod client;
mod process;
mod supervisor;
#[cfg(test)]
mod tests;

pub use client::Commands;
pub use process::GuardedLinkSettings;

use client::Client;
use process::Guard;
use supervisor::{FirstOpening, Supervisor};

/// The guard's program.
pub const GUARD_NAME: &str = "barrelman-guard";

/// The guarded link cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum GuardError {
    /// There is no guard.
    #[error(
        "this vehicle keeps its last rate when the program is gone, and its guard {} is not there: build both (`cargo build`), \
         install barrelman-guard beside barrelman, or name it (--guard FILE, link.guard); --without-guard (link.without_guard) \
         runs without it", path.display()
    )]
    Missing {
        /// Where the guard was looked for.
        path: PathBuf,
    },
    /// The guard cannot be started.
    #[error("the guard {} cannot be started", path.display())]
    Start {
        /// The guard's program.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The guard could not open the port. The text is that of the port's error.
    #[error("{0}")]
    Port(String),
    /// The guard has ended, or said nothing.
    #[error(
        "the guard {} has not opened the port ({reason}): is it the barrelman-guard of the same build as barrelman?",
        path.display()
    )]
    NoAnswer {
        /// The guard's program.
        path: PathBuf,
        /// What it did instead.
        reason: String,
    },
}

/// The guard's program: the one that is named, or the one beside this program.
///
/// # Errors
/// If it is not there.
pub fn find_guard(named: Option<&Path>) -> Result<PathBuf, GuardError> {
    let beside = || {
        let own = std::env::current_exe().unwrap_or_default();
        own.with_file_name(GUARD_NAME)
    };
    let path = named.map_or_else(beside, Path::to_path_buf);
    if path.is_file() { Ok(path) } else { Err(GuardError::Missing { path }) }
}

/// A link whose port is the guard's. Dropping it ends the link: zeros, stop, and the guard ends.
#[derive(Debug)]
pub struct GuardedLink<C: Commands = VehicleRates> {
    client: Arc<Client<C>>,
    thread: Option<JoinHandle<bool>>,
}

impl<C: Commands> GuardedLink<C> {
    /// Starts the guard, waits until it has tried to open the port, and starts the thread that reads what it
    /// reports. `report` takes the reports; it must not block, and returns whether there was room.
    ///
    /// # Errors
    /// If the guard cannot be started, or cannot open the port, unless the vehicle may come: that is
    /// reported, and the guard goes on trying. A port that is lost later is reopened, and a guard that is
    /// gone is replaced.
    pub fn open(
        settings: GuardedLinkSettings<impl OpenSession<Command = C>>,
        report: impl Fn(LinkReport) -> bool + Send + 'static,
    ) -> Result<Self, GuardError> {
        let client = Arc::new(Client::default());
        let path = settings.guard.clone();
        let start_error = |source| GuardError::Start { path: path.clone(), source };
        let guard = Guard::start(&settings, LinkHistory::default()).map_err(start_error)?;
        let (opened, first) = sync_channel(1);
        let shared = Arc::clone(&client);
        let supervisor = Supervisor {
            reader: settings.protocol.reports(settings.clock.now()),
            settings,
            client: shared,
            report,
            history: LinkHistory::default(),
            was_opened: false,
            opened: Some(opened),
        };
        let thread = std::thread::Builder::new()
            .name("link".to_owned())
            .spawn(move || supervisor.run(guard))
            .map_err(start_error)?;
        let link = Self { client, thread: Some(thread) };
        wait_until_open(&first, path).map(|()| link)
    }

    /// Requests a command (rates in the vehicle's own signs), and replaces the one requested before. A
    /// command that moves something is in force until `renew_by`: without a renewal by then, the guard rests
    /// the vehicle. Does not block.
    pub fn send(&self, command: C, renew_by: Option<Timestamp>) {
        let requested = RequestedCommand { command, renew_by };
        let mut state = self.client.state();
        let previous = std::mem::replace(&mut state.requested, requested);
        if previous != requested {
            // Without room, the next heartbeat sends it.
            state.send(&ToGuard::Request(requested));
        }
    }

    /// The operator takes the control of the vehicle back, if another client has taken it.
    pub fn take_control(&self) {
        let mut state = self.client.state();
        state.takes_control = true;
        state.pass_on_control();
    }

    /// Ends the link: zeros, stop, and the guard's end. Returns whether they were sent, or nothing ever was.
    pub fn close(mut self) -> bool {
        self.end()
    }

    fn end(&mut self) -> bool {
        let Some(thread) = self.thread.take() else { return true };
        {
            let mut state = self.client.state();
            state.is_closing = true;
            state.requested = RequestedCommand::REST;
            state.send(&ToGuard::Close);
        }
        // The thread bounds the time of its own closing.
        thread.join().unwrap_or(false)
    }
}

impl<C: Commands> Drop for GuardedLink<C> {
    fn drop(&mut self) {
        self.end();
    }
}

/// The thread of the link bounds the wait: it watches the guard.
fn wait_until_open(first: &Receiver<FirstOpening>, path: PathBuf) -> Result<(), GuardError> {
    match first.recv() {
        Ok(FirstOpening::Started) => Ok(()),
        Ok(FirstOpening::PortRefused(reason)) => Err(GuardError::Port(reason)),
        Ok(FirstOpening::GuardFailed(reason)) => Err(GuardError::NoAnswer { path, reason }),
        Err(_) => Err(GuardError::NoAnswer { path, reason: "the thread of the link is gone".to_owned() }),
    }
}
