//! The guard's process, from its first message to its end.

use std::cell::{Cell, RefCell};
use std::io::{self, IsTerminal as _};
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::suspend::SuspendWatch;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Telemetry, VehicleRates, VesselOrder};
use barrelman_wire::{ByteProtocol, ByteSession, OpenSession};
use rustix::event::{PollFd, PollFlags};
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

use super::gate::{Gate, GuardedCommand};
use super::message::{FromGuard, GuardedVehicle, MessageCommand, Settings, ToGuard};
use super::pipe::{Pipe, PipeRead};
use super::pipe_io::PipeIo;
use crate::mailbox::Mailbox;
use crate::port::Port;
use crate::port_io::{MachineIo, poll_for};
use crate::report::LinkReport;
use crate::url::LinkUrl;
use crate::worker::Worker;

/// Longest wait for the first message.
const FIRST_MESSAGE: Duration = Duration::from_secs(5);
/// How long the guard goes on trying to reach a vehicle whose port is gone when the program ends.
const PERSISTENCE: Duration = Duration::from_secs(60);
/// Longest time for the one line that the guard may print.
const LINE_TIMEOUT: Duration = Duration::from_millis(100);

const USAGE: &str = "barrelman-guard is started by `barrelman run`: it owns the vehicle's port, and sends zeros and stop when the program is gone";

/// Runs the guard. Its standard input is its end of the pipe.
pub fn run() -> ExitCode {
    match guard() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            print_line(
                "barrelman-guard: zeros and stop could not be sent: the camera may still be turning. Stop it from the ground station itself",
            );
            ExitCode::FAILURE
        }
        Err(reason) => {
            print_line(&format!("barrelman-guard: {reason}"));
            ExitCode::from(2)
        }
    }
}

/// Returns whether zeros and stop were sent.
fn guard() -> Result<bool, String> {
    if io::stdin().is_terminal() {
        return Err(USAGE.to_owned());
    }
    // Out of the program's session and terminal: what ends the program there does not end the guard. A
    // process that leads its group already needs no other.
    let _ = rustix::process::setsid();
    let signalled = watch_signals().map_err(|error| format!("signals cannot be watched: {error}"))?;
    let pipe = io::stdin().as_fd().try_clone_to_owned().map_err(|error| error.to_string())?;
    let pipe = Arc::new(Pipe::from_fd(pipe));
    let settings = first_message(&pipe)?;
    let url = LinkUrl::parse(&settings.url).map_err(|error| error.to_string())?;
    let parts = Parts { pipe, url, signalled, settings: &settings };
    match settings.vehicle {
        GuardedVehicle::Camera { limits, protocol, framing } => {
            let baud = parts.url.baud();
            parts.serve(ByteProtocol { protocol, framing, baud }, limits)
        }
        GuardedVehicle::Vessel { limits, protocol } => parts.serve(protocol, VesselOrder::Commanded(limits)),
    }
}

/// What a guard has when it knows its vehicle.
struct Parts<'a> {
    pipe: Arc<Pipe>,
    url: LinkUrl,
    signalled: OwnedFd,
    settings: &'a Settings,
}

impl Parts<'_> {
    /// Serves the port until the program is gone. Returns whether zeros and stop were sent.
    fn serve<P: OpenSession>(self, protocol: P, limits: P::Command) -> Result<bool, String>
    where
        P::Command: GuardedCommand + MessageCommand,
    {
        let Self { pipe, url, signalled, settings } = self;
        let clock = Clock::started_at(settings.clock_start_ns);
        let mailbox = Arc::new(Mailbox::new().map_err(|error| error.to_string())?);
        pipe.send(&FromGuard::OpensPort.encode());
        let port = match Port::open(&url.endpoint) {
            Ok(port) => {
                pipe.send(&FromGuard::Opened.encode());
                Some(port)
            }
            Err(error) => {
                let (may_pass, reason) = (error.may_pass(), error.to_string());
                pipe.send(&FromGuard::NotOpened { may_pass, reason }.encode());
                None
            }
        };
        let reports = Arc::clone(&pipe);
        let worker: Worker<ByteSession<P::Command>, _, _> = Worker {
            persistence: PERSISTENCE,
            mailbox: Arc::clone(&mailbox),
            io: PipeIo {
                machine: MachineIo { endpoint: url.endpoint, clock, mailbox: Arc::clone(&mailbox) },
                pipe: Arc::clone(&pipe),
                gate: RefCell::new(Gate::new(limits, clock.now())),
                suspend: RefCell::new(SuspendWatch::start()),
                signalled,
                last_alive: Cell::new(clock.now()),
                is_connected: Cell::new(true),
            },
            history: settings.history,
            open_session: Arc::new(move |now| protocol.open(now)),
            report: move |report| message_of(report).is_none_or(|message| reports.send(&message.encode())),
        };
        worker.run(port, url.faults);
        let is_stop_sent = mailbox.is_stop_sent();
        pipe.send(&FromGuard::Ended { is_stop_sent }.encode());
        Ok(is_stop_sent)
    }
}

/// The message for a report. The program reads the vehicle's telemetry from the received bytes itself.
fn message_of(report: LinkReport) -> Option<FromGuard> {
    Some(match report {
        LinkReport::Telemetry(Telemetry { at, report: Report::Link(state) }) => FromGuard::State(state, at),
        // The guard has told its first opening itself.
        LinkReport::Telemetry(_) | LinkReport::GuardLost(_) | LinkReport::NotReached(_) => return None,
        LinkReport::Lost { reason, may_be_turning } => FromGuard::Lost { may_be_turning, reason },
        LinkReport::Control { is_anothers } => FromGuard::Control { is_anothers },
        LinkReport::HeldUp => FromGuard::HeldUp,
        LinkReport::Suspended(gap) => FromGuard::Suspended(gap),
        LinkReport::Stopped(evidence) => FromGuard::Stopped(evidence),
        LinkReport::Panicked => FromGuard::Panicked,
    })
}

/// A descriptor that is readable after a signal that asks to end. The guard then sends zeros and stop first.
fn watch_signals() -> io::Result<OwnedFd> {
    let (read, write) = UnixStream::pair()?;
    for signal in [SIGTERM, SIGINT, SIGHUP, SIGQUIT] {
        signal_hook::low_level::pipe::register(signal, write.try_clone()?)?;
    }
    Ok(read.into())
}

fn first_message(pipe: &Pipe) -> Result<Settings, String> {
    poll_for(&mut [PollFd::new(pipe, PollFlags::IN)], FIRST_MESSAGE);
    match pipe.read() {
        PipeRead::Message(packet) => match ToGuard::<VehicleRates>::decode(&packet) {
            Ok(ToGuard::Settings(settings)) => Ok(settings),
            Ok(_) => Err(USAGE.to_owned()),
            Err(error) => Err(error.to_string()),
        },
        PipeRead::Nothing | PipeRead::End => Err(USAGE.to_owned()),
    }
}

/// Prints a line on the standard error, if that does not block.
fn print_line(text: &str) {
    let stderr = io::stderr();
    let mut fds = [PollFd::new(&stderr, PollFlags::OUT)];
    poll_for(&mut fds, LINE_TIMEOUT);
    if fds[0].revents().contains(PollFlags::OUT) {
        let _ = rustix::io::write(&stderr, format!("{text}\n").as_bytes());
    }
}
