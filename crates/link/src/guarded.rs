//! The link of the program to its guard: starts the guard, passes rates to it and its reports on, and starts another one if
//! it is gone.

use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};
use barrelman_wire::{ByteProtocol, LinkHistory, OpenSession, ReportReader};
use rustix::event::{PollFd, PollFlags};

use crate::dead_mans_switch::RequestedCommand;
use crate::guard::gate::{GuardedCommand, HEARTBEAT};
use crate::guard::message::{FromGuard, GuardedVehicle, MessageCommand, Settings, ToGuard};
use crate::guard::pipe::{Pipe, PipeRead};
use crate::guard::watch::{
    GuardWatch, HUNG_AT_START, HUNG_WHILE_OPENING, HUNG_WHILE_REOPENING, LOOK_INTERVAL,
};
use crate::handle::LinkHandle;
use crate::port_io::poll_for;
use crate::report::LinkReport;
use crate::url::LinkUrl;
use crate::vehicle_lock::VehicleLock;

/// The guard's program.
pub const GUARD_NAME: &str = "barrelman-guard";
/// Longest wait for the end of a guard that was killed. One that does not end is left to the system: the next guard
/// cannot open a port before it is gone.
const REAPING_TIMEOUT: Duration = Duration::from_millis(50);
const REAPING_INTERVAL: Duration = Duration::from_millis(2);
/// Pause before a guard that could not be started is started again.
const RESTART_PAUSE: Duration = Duration::from_millis(500);
/// Longest wait for the end of the guard when the link is closed. The guard itself goes on after that.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(7);

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

/// What a guarded link needs.
#[derive(Debug, Clone)]
pub struct GuardedLinkSettings<P = ByteProtocol> {
    /// The guard's program.
    pub guard: PathBuf,
    /// The address of the vehicle.
    pub url: LinkUrl,
    /// What is spoken there.
    pub protocol: P,
    /// What the guard has to know of the vehicle.
    pub vehicle: GuardedVehicle,
    /// The lock of the vehicle, which the guard holds, too, until it has sent its zeros; `None`: without a lock.
    pub lock: Option<Arc<VehicleLock>>,
    /// The program's clock.
    pub clock: Clock,
}

/// The commands that a guarded link carries.
pub trait Commands: GuardedCommand + MessageCommand {}

impl<C: GuardedCommand + MessageCommand> Commands for C {}

/// A link whose port is the guard's. Dropping it ends the link: zeros, stop, and the guard ends.
#[derive(Debug)]
pub struct GuardedLink<C: Commands = VehicleRates> {
    client: Arc<Client<C>>,
    thread: Option<JoinHandle<bool>>,
}

/// What the run loop and the thread share.
#[derive(Debug, Default)]
struct Client<C>(Mutex<ClientState<C>>);

#[derive(Debug, Default)]
struct ClientState<C> {
    pipe: Option<Arc<Pipe>>,
    requested: RequestedCommand<C>,
    /// Whether the operator takes the control back, and the guard was not told so yet.
    takes_control: bool,
    /// Whether another client has the control, as the guard said last, and the operator has not taken it back since.
    is_anothers: bool,
    is_closing: bool,
}

impl<C: Commands> ClientState<C> {
    /// Sends a message, if there is a guard with room for it, and returns whether it was sent. The lock of the state is held
    /// meanwhile, so that the last command that was requested is the last one that is sent. Does not block.
    fn send(&self, message: &ToGuard<C>) -> bool {
        self.pipe.as_ref().is_some_and(|pipe| pipe.send(&message.encode()))
    }

    /// Tells the guard that the operator takes the control back, if that is still to be told.
    fn pass_on_control(&mut self) {
        if self.takes_control && self.send(&ToGuard::TakeControl) {
            (self.takes_control, self.is_anothers) = (false, false);
        }
    }
}

impl<C: Commands> Client<C> {
    fn state(&self) -> MutexGuard<'_, ClientState<C>> {
        // Plain data, whole at any time: a panic elsewhere must not silence the link.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<C: Commands> GuardedLink<C> {
    /// Starts the guard, waits until it has opened the port, and starts the thread that reads what it reports. `report`
    /// takes the reports; it must not block, and returns whether there was room.
    ///
    /// # Errors
    /// If the guard cannot be started, or cannot open the port now. A port that is lost later is reopened, and a guard that
    /// is gone is replaced.
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
            reader: settings.protocol.reports(),
            settings,
            client: shared,
            report,
            history: LinkHistory::default(),
            opened: Some(opened),
        };
        let thread = std::thread::Builder::new()
            .name("link".to_owned())
            .spawn(move || supervisor.run(guard))
            .map_err(start_error)?;
        let link = Self { client, thread: Some(thread) };
        wait_until_open(&first, path).map(|()| link)
    }

    /// Requests a command (rates in the vehicle's own signs), and replaces the one requested before. A command that moves
    /// something is in force until `renew_by`: without a renewal by then, the guard rests the vehicle. Does not block.
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

    /// Ends the link: zeros, stop, and the guard's end. Returns whether they were sent.
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

/// What became of the first opening of the port.
enum FirstOpening {
    Opened,
    /// The port's error.
    PortRefused(String),
    /// The guard is gone, or hangs.
    GuardFailed(String),
}

/// The thread of the link bounds the wait: it watches the guard.
fn wait_until_open(first: &Receiver<FirstOpening>, path: PathBuf) -> Result<(), GuardError> {
    match first.recv() {
        Ok(FirstOpening::Opened) => Ok(()),
        Ok(FirstOpening::PortRefused(reason)) => Err(GuardError::Port(reason)),
        Ok(FirstOpening::GuardFailed(reason)) => Err(GuardError::NoAnswer { path, reason }),
        Err(_) => Err(GuardError::NoAnswer { path, reason: "the thread of the link is gone".to_owned() }),
    }
}

/// A guard's process and its pipe.
struct Guard {
    child: Child,
    pipe: Arc<Pipe>,
}

impl Guard {
    /// Starts a guard. `history`: what a guard before it has left.
    fn start<P>(settings: &GuardedLinkSettings<P>, history: LinkHistory) -> io::Result<Self> {
        let (pipe, other): (Pipe, OwnedFd) = Pipe::pair()?;
        let first: ToGuard = ToGuard::Settings(Settings {
            clock_start_ns: settings.clock.start_on_monotonic_ns(),
            vehicle: settings.vehicle,
            history,
            url: settings.url.with_faults(),
        });
        pipe.send(&first.encode());
        let held = match &settings.lock {
            Some(lock) => Stdio::from(lock.share()?),
            None => Stdio::null(),
        };
        let child = Command::new(&settings.guard).stdin(Stdio::from(other)).stdout(held).spawn()?;
        Ok(Self { child, pipe: Arc::new(pipe) })
    }

    /// Ends a guard that is gone, hung, or has ended by itself. A stopped process ends by the kill, too, and leaves its port.
    fn reap(mut self) {
        let _ = self.child.kill();
        let killed_at = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && killed_at.elapsed() < REAPING_TIMEOUT {
            std::thread::sleep(REAPING_INTERVAL);
        }
    }
}

/// Why a guard is no longer served.
enum GuardEnd {
    /// It has ended, and zeros and stop were sent, or not.
    Ended { is_stop_sent: bool },
    /// The first guard could not open the port: nothing was sent, and there is nothing to stop.
    NeverOpened,
    /// It is gone, or hung.
    Gone(String),
    /// The link is closing, and the guard takes too long. It goes on by itself.
    TooLong,
}

/// The thread `link` of a guarded link.
struct Supervisor<P: OpenSession, R> {
    settings: GuardedLinkSettings<P>,
    client: Arc<Client<P::Command>>,
    report: R,
    reader: ReportReader,
    /// What the guard before has left.
    history: LinkHistory,
    /// Takes whether the first guard has opened the port.
    opened: Option<SyncSender<FirstOpening>>,
}

impl<P: OpenSession, R: Fn(LinkReport) -> bool> Supervisor<P, R>
where
    P::Command: Commands,
{
    /// Serves one guard after the other until the link is closed. Returns whether zeros and stop were sent.
    fn run(mut self, first: Guard) -> bool {
        let mut guard = Some(first);
        let mut attempts_to_close = 0;
        loop {
            let Some(served) = guard.take().or_else(|| Guard::start(&self.settings, self.history).ok())
            else {
                self.stop_without_guard();
                if self.client.state().is_closing {
                    return false;
                }
                std::thread::sleep(RESTART_PAUSE);
                continue;
            };
            self.client.state().pipe = Some(Arc::clone(&served.pipe));
            if self.client.state().is_closing {
                attempts_to_close += 1;
                served.pipe.send(&ToGuard::<P::Command>::Close.encode());
            }
            let end = self.serve(&served);
            let is_stop_sent = matches!(end, GuardEnd::Ended { is_stop_sent: true });
            let is_anothers = self.client.state().is_anothers;
            self.history = LinkHistory::after(is_stop_sent, is_anothers, self.reader.vehicle());
            self.client.state().pipe = None;
            let is_closing = self.client.state().is_closing;
            let reason = match end {
                // A first guard that fails before it has opened the port is told to who starts the run.
                GuardEnd::Gone(reason) if self.opened.is_some() => {
                    self.answer_opening(FirstOpening::GuardFailed(reason));
                    served.reap();
                    return false;
                }
                GuardEnd::TooLong => return false,
                GuardEnd::NeverOpened => {
                    served.reap();
                    return false;
                }
                GuardEnd::Ended { is_stop_sent } if is_closing => {
                    served.reap();
                    return is_stop_sent;
                }
                GuardEnd::Ended { .. } => "it has ended".to_owned(),
                GuardEnd::Gone(reason) => reason,
            };
            served.reap();
            if attempts_to_close > 1 {
                return false;
            }
            (self.report)(LinkReport::GuardLost(reason));
            self.report_state(LinkState::Opening, self.settings.clock.now());
        }
    }

    /// Serves a guard until its end.
    fn serve(&mut self, guard: &Guard) -> GuardEnd {
        let patience = if self.opened.is_some() { HUNG_WHILE_OPENING } else { HUNG_WHILE_REOPENING };
        let mut watch = GuardWatch::start(patience, self.settings.clock.now());
        let mut last_sent = Instant::now();
        let mut closing_since = None;
        loop {
            poll_for(&mut [PollFd::new(&*guard.pipe, PollFlags::IN)], LOOK_INTERVAL);
            loop {
                match guard.pipe.read() {
                    PipeRead::Nothing => break,
                    PipeRead::End => return GuardEnd::Gone("it is gone".to_owned()),
                    PipeRead::Message(packet) => {
                        watch.heard();
                        match FromGuard::decode(&packet) {
                            Ok(FromGuard::OpensPort) => watch.heard_opening(),
                            Ok(FromGuard::Ended { is_stop_sent }) => return GuardEnd::Ended { is_stop_sent },
                            Ok(FromGuard::NotOpened(reason)) if self.opened.is_some() => {
                                self.answer_opening(FirstOpening::PortRefused(reason));
                                return GuardEnd::NeverOpened;
                            }
                            Ok(message) => self.on_message(message),
                            Err(_) => return GuardEnd::Gone("it says what cannot be read".to_owned()),
                        }
                    }
                }
            }
            let is_closing = {
                let mut state = self.client.state();
                if !state.is_closing {
                    state.pass_on_control();
                    if last_sent.elapsed() >= HEARTBEAT {
                        last_sent = Instant::now();
                        state.send(&ToGuard::Request(state.requested));
                    }
                }
                state.is_closing
            };
            if is_closing {
                let since = *closing_since.get_or_insert_with(Instant::now);
                if since.elapsed() > CLOSING_TIMEOUT {
                    return GuardEnd::TooLong;
                }
            }
            if watch.hangs(self.settings.clock.now()) {
                return GuardEnd::Gone(if watch.is_starting() {
                    format!("it has said nothing for {} s", HUNG_AT_START.as_secs())
                } else {
                    "it hangs".to_owned()
                });
            }
        }
    }

    fn on_message(&mut self, message: FromGuard) {
        match message {
            FromGuard::Opened => self.answer_opening(FirstOpening::Opened),
            FromGuard::State(state, at) => self.report_state(state, at),
            FromGuard::Received(at, bytes) => {
                let report = &self.report;
                self.reader.read(&bytes, |content| {
                    report(LinkReport::Telemetry(Telemetry { at, report: content }));
                });
            }
            FromGuard::Control { is_anothers } => self.client.state().is_anothers = is_anothers,
            FromGuard::Lost { may_be_turning, reason } => {
                (self.report)(LinkReport::Lost { reason, may_be_turning });
            }
            FromGuard::HeldUp => drop((self.report)(LinkReport::HeldUp)),
            FromGuard::Suspended(gap) => drop((self.report)(LinkReport::Suspended(gap))),
            FromGuard::Stopped(evidence) => drop((self.report)(LinkReport::Stopped(evidence))),
            FromGuard::Panicked => drop((self.report)(LinkReport::Panicked)),
            // A later guard goes on trying; its state says so.
            FromGuard::NotOpened(_) | FromGuard::Alive | FromGuard::OpensPort | FromGuard::Ended { .. } => {}
        }
    }

    fn answer_opening(&mut self, answer: FirstOpening) {
        if let Some(opened) = self.opened.take() {
            // Without a receiver, the opening was given up.
            let _ = opened.send(answer);
        }
    }

    fn report_state(&mut self, state: LinkState, at: Timestamp) {
        if state == LinkState::Opening {
            // The pilot forgets what a vehicle said on a port before. A reader reports changes only, and has
            // to report it again.
            let mut reader = self.settings.protocol.reports();
            if let Some(vehicle) = self.reader.vehicle() {
                reader.name(vehicle);
            }
            self.reader = reader;
        }
        let telemetry = Telemetry { at, report: Report::Link(state) };
        // A state must not be lost: the pilot goes by it.
        while !(self.report)(LinkReport::Telemetry(telemetry)) && !self.client.state().is_closing {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// No guard can be started: zeros and stop come from this process, once.
    fn stop_without_guard(&self) {
        let url = LinkUrl { faults: self.settings.url.faults.clone(), ..self.settings.url.clone() };
        // Without a port there is nothing to do but to try again.
        let history = LinkHistory::after(false, self.history.is_anothers, self.history.vehicle);
        let _ = LinkHandle::stop(&url, self.settings.protocol, self.settings.clock, history);
    }
}
