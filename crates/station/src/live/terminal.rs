//! Keys, signals, and whether anybody still reads our output, on one thread.
//!
//! Signals become bytes in pipes, so that a second one can never skip the zeros: it only adds a byte. Where the
//! input is a terminal its keys come one by one, without echo; the terminal is put back as it was at the end.

use std::io::{IsTerminal as _, Read as _};
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Result;
use barrelman_vocab::{OperatorRequest, StopCause};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP};

use super::event::{Event, QuitCause};
use super::threads::{self, FaultInjector};
use barrelman_host::clock::Clock;

const SIGNALS: [(i32, &str); 5] = [
    (SIGINT, "SIGINT"),
    (SIGTERM, "SIGTERM"),
    (SIGHUP, "SIGHUP"),
    (SIGQUIT, "SIGQUIT"),
    (SIGTSTP, "SIGTSTP"),
];

/// From one look at the end flag to the next.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The thread that watches keys, signals and the output.
pub struct Terminal {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    _keys: Option<RawKeys>,
}

impl Terminal {
    /// Starts watching.
    ///
    /// # Errors
    /// If a signal cannot be caught.
    pub fn watch(events: SyncSender<Event>, clock: Clock, fault_injector: FaultInjector) -> Result<Self> {
        let mut pipes = Vec::new();
        for (signal, name) in SIGNALS {
            let (read, write) = UnixStream::pair()?;
            read.set_nonblocking(true)?;
            signal_hook::low_level::pipe::register(signal, write)?;
            pipes.push((read, name));
        }
        let keys = RawKeys::take();
        let watch_keys = keys.is_some();
        let ended = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&ended);
        let to_loop = events.clone();
        let thread = threads::spawn("terminal", events, move || {
            watch(&pipes, watch_keys, &to_loop, &end, || {
                fault_injector.apply_faults("terminal", clock.now())
            });
        })?;
        Ok(Self { ended, thread: Some(thread), _keys: keys })
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn watch(
    pipes: &[(UnixStream, &'static str)],
    watch_keys: bool,
    events: &SyncSender<Event>,
    ended: &AtomicBool,
    apply_faults: impl Fn(),
) {
    let (stdin, stdout) = (std::io::stdin(), std::io::stdout());
    let mut output_open = true;
    let mut input_open = watch_keys;
    while !ended.load(Ordering::Relaxed) {
        apply_faults();
        let mut fds: Vec<PollFd<'_>> =
            pipes.iter().map(|(pipe, _)| PollFd::new(pipe, PollFlags::IN)).collect();
        // No flag is asked for on the output: an error or a hang-up is always told.
        let stdout_fd = stdout.as_fd();
        fds.push(PollFd::from_borrowed_fd(stdout_fd, PollFlags::empty()));
        if input_open {
            fds.push(PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN));
        }
        let timeout = rustix::event::Timespec::try_from(POLL_INTERVAL).ok();
        if poll(&mut fds, timeout.as_ref()).is_err() {
            continue;
        }
        let flags: Vec<PollFlags> = fds.iter().map(PollFd::revents).collect();
        for ((pipe, name), flags) in pipes.iter().zip(&flags) {
            if flags.contains(PollFlags::IN) {
                let mut bytes = [0; 16];
                let _ = (&*pipe).read(&mut bytes);
                let _ = events.send(Event::Quit(QuitCause::Signal(name)));
            }
        }
        if output_open && flags[pipes.len()].intersects(PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL) {
            output_open = false;
            let _ = events.send(Event::Quit(QuitCause::OutputClosed));
        }
        if !output_open {
            // A closed output is told at every look: do not spin on it.
            std::thread::sleep(POLL_INTERVAL);
        }
        if input_open && flags.last().is_some_and(|flags| !flags.is_empty()) {
            let mut bytes = [0; 16];
            match rustix::io::read(stdin.as_fd(), &mut bytes) {
                Ok(0) | Err(_) => input_open = false,
                Ok(read) => bytes[..read].iter().filter_map(|key| meaning(*key)).for_each(|event| {
                    let _ = events.send(event);
                }),
            }
        }
    }
}

/// The keys; the help of `run` lists them.
fn meaning(key: u8) -> Option<Event> {
    match key {
        b'e' => Some(Event::Request(OperatorRequest::Engage)),
        b'd' => Some(Event::Request(OperatorRequest::Disengage)),
        b' ' => Some(Event::Request(OperatorRequest::Stop(StopCause::Operator))),
        b'q' => Some(Event::Quit(QuitCause::Key)),
        _ => None,
    }
}

/// A terminal whose keys come one by one; put back when dropped.
struct RawKeys {
    before: Termios,
}

impl RawKeys {
    fn take() -> Option<Self> {
        let stdin = std::io::stdin();
        if !stdin.is_terminal() {
            return None;
        }
        let before = tcgetattr(&stdin).ok()?;
        let mut keys = before.clone();
        keys.local_modes -= LocalModes::ICANON | LocalModes::ECHO;
        tcsetattr(&stdin, OptionalActions::Now, &keys).ok()?;
        Some(Self { before })
    }
}

impl Drop for RawKeys {
    fn drop(&mut self) {
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before);
    }
}
