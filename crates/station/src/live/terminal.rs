//! Keys, signals, and the state of the standard output, on one thread.
//!
//! Signals become bytes in pipes. A second signal only adds a byte, so it cannot skip the zeros at the end of
//! a run. Where the input is a terminal, its keys arrive one by one and without echo; the settings of the
//! terminal are restored at the end.

use std::io::{IsTerminal as _, Read as _};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::operator::Gateway;
use barrelman_host::clock::Clock;
use barrelman_vocab::{CameraRequest, OperatorRequest, StopCause};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP};

use super::event::{Event, QuitCause};
use super::faults::{FaultInjector, TERMINAL};
use super::inbox::Inbox;
use super::threads;

const SIGNALS: [(i32, &str); 5] = [
    (SIGINT, "SIGINT"),
    (SIGTERM, "SIGTERM"),
    (SIGHUP, "SIGHUP"),
    (SIGQUIT, "SIGQUIT"),
    (SIGTSTP, "SIGTSTP"),
];

/// Longest wait for keys and signals: bounds the time until the thread notices its end.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// What the keys do, in words.
pub const KEYS: &str =
    "e engages, d disengages, s searches for a lost boat, space stops camera and boat, q quits";

/// The thread that watches keys, signals and the output.
pub struct Terminal {
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    raw: Option<RawTerminal>,
}

impl Terminal {
    /// Catches the signals, switches the terminal to single keys, and starts the thread.
    ///
    /// # Errors
    /// If a signal cannot be caught.
    pub fn watch(
        gateway: Arc<Gateway>,
        events: SyncSender<Event>,
        clock: Clock,
        fault_injector: FaultInjector,
    ) -> Result<Self> {
        let mut signals = Vec::new();
        for (signal, name) in SIGNALS {
            let (read, write) = UnixStream::pair()?;
            read.set_nonblocking(true)?;
            signal_hook::low_level::pipe::register(signal, write)?;
            signals.push(SignalPipe { read, name });
        }
        let raw = RawTerminal::enable();
        let watches_keys = raw.is_some();
        let is_ending = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&is_ending);
        let to_loop = events.clone();
        let thread = threads::spawn("terminal", events, move || {
            let (stdin, stdout) = (std::io::stdin(), std::io::stdout());
            let keys = watches_keys.then(|| stdin.as_fd());
            let watcher = TerminalPoll { signals: &signals, keys, output: Some(stdout.as_fd()) };
            let mut inputs = fault_injector.inbox(TERMINAL, clock, watcher);
            while !end.load(Ordering::Relaxed) {
                for input in inputs.next(POLL_INTERVAL).unwrap_or_default() {
                    match input {
                        TerminalInput::Request(request) => gateway.submit_logged(request),
                        TerminalInput::Quit(cause) => drop(to_loop.send(Event::Quit(cause))),
                    }
                }
            }
        })?;
        Ok(Self { is_ending, thread: Some(thread), raw })
    }

    /// Whether the standard input is a terminal, whose keys are read.
    pub const fn watches_keys(&self) -> bool {
        self.raw.is_some()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A pipe that receives one byte per signal.
struct SignalPipe {
    read: UnixStream,
    name: &'static str,
}

/// Reads keys and signals, and notices a closed output.
struct TerminalPoll<'a> {
    signals: &'a [SignalPipe],
    /// The input, until it ends.
    keys: Option<BorrowedFd<'a>>,
    /// The output, until its reader closes it.
    output: Option<BorrowedFd<'a>>,
}

impl Inbox<Vec<TerminalInput>> for TerminalPoll<'_> {
    fn next(&mut self, wait: Duration) -> Result<Vec<TerminalInput>, RecvTimeoutError> {
        let mut inputs = Vec::new();
        self.poll(wait, |input| inputs.push(input));
        Ok(inputs)
    }
}

impl TerminalPoll<'_> {
    /// Waits for keys, signals or a closed output, at most for `wait`, and passes on what came in.
    fn poll(&mut self, wait: Duration, mut on_input: impl FnMut(TerminalInput)) {
        let mut fds: Vec<PollFd<'_>> =
            self.signals.iter().map(|pipe| PollFd::new(&pipe.read, PollFlags::IN)).collect();
        // `poll` always reports errors and hang-ups; no other flag of the output is needed.
        let output = self.output.map(|output| PollFd::from_borrowed_fd(output, PollFlags::empty()));
        let output_index = output.map(|output| push(&mut fds, output));
        let keys = self.keys.map(|keys| PollFd::from_borrowed_fd(keys, PollFlags::IN));
        let keys_index = keys.map(|keys| push(&mut fds, keys));
        let timeout = rustix::event::Timespec::try_from(wait).ok();
        if poll(&mut fds, timeout.as_ref()).is_err() {
            return;
        }
        for (pipe, fd) in self.signals.iter().zip(&fds) {
            if fd.revents().contains(PollFlags::IN) {
                let mut bytes = [0; 16];
                let _ = (&pipe.read).read(&mut bytes);
                on_input(TerminalInput::Quit(QuitCause::Signal(pipe.name)));
            }
        }
        let closed = PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL;
        if output_index.is_some_and(|index| fds[index].revents().intersects(closed)) {
            self.output = None;
            on_input(TerminalInput::Quit(QuitCause::OutputClosed));
        }
        if let Some(keys) = self.keys
            && keys_index.is_some_and(|index| !fds[index].revents().is_empty())
        {
            let mut bytes = [0; 16];
            match rustix::io::read(keys, &mut bytes) {
                Ok(0) | Err(_) => self.keys = None,
                Ok(read) => bytes[..read].iter().filter_map(|key| key_input(*key)).for_each(on_input),
            }
        }
    }
}

/// Adds an element and returns its index.
fn push<T>(elements: &mut Vec<T>, element: T) -> usize {
    elements.push(element);
    elements.len() - 1
}

/// What comes in from the terminal or the system.
#[derive(Debug, Clone, Copy, PartialEq)]
enum TerminalInput {
    /// A key that stands for a request.
    Request(OperatorRequest),
    /// The program must end.
    Quit(QuitCause),
}

/// The meaning of a key. The help of `run` lists the keys.
fn key_input(key: u8) -> Option<TerminalInput> {
    match key {
        b'e' => Some(TerminalInput::Request(OperatorRequest::Camera(CameraRequest::Engage))),
        b'd' => Some(TerminalInput::Request(OperatorRequest::Camera(CameraRequest::Disengage))),
        b's' => Some(TerminalInput::Request(OperatorRequest::Camera(CameraRequest::Search))),
        b' ' => Some(TerminalInput::Request(OperatorRequest::Stop(StopCause::Operator))),
        b'q' => Some(TerminalInput::Quit(QuitCause::Key)),
        _ => None,
    }
}

/// A terminal whose keys arrive one by one, without echo. Dropping it restores the settings.
struct RawTerminal {
    before: Termios,
}

impl RawTerminal {
    /// Switches the standard input, where it is a terminal.
    fn enable() -> Option<Self> {
        let stdin = std::io::stdin();
        if !stdin.is_terminal() {
            return None;
        }
        let before = tcgetattr(&stdin).ok()?;
        let mut raw = before.clone();
        raw.local_modes -= LocalModes::ICANON | LocalModes::ECHO;
        tcsetattr(&stdin, OptionalActions::Now, &raw).ok()?;
        Some(Self { before })
    }
}

impl Drop for RawTerminal {
    fn drop(&mut self) {
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    /// The events of one call of `poll`, as text.
    fn events(watcher: &mut TerminalPoll<'_>) -> Vec<String> {
        let mut events = Vec::new();
        watcher.poll(Duration::ZERO, |input| events.push(format!("{input:?}")));
        events
    }

    fn pair() -> (UnixStream, UnixStream) {
        UnixStream::pair().unwrap()
    }

    #[test]
    fn each_key_has_one_meaning() {
        for (key, expected) in [
            (b'e', "Some(Request(Camera(Engage)))"),
            (b'd', "Some(Request(Camera(Disengage)))"),
            (b's', "Some(Request(Camera(Search)))"),
            (b' ', "Some(Request(Stop(Operator)))"),
            (b'q', "Some(Quit(Key))"),
            (b'E', "None"),
            (b'Q', "None"),
            (b'\n', "None"),
            (0x1b, "None"),
            (0, "None"),
            (0xff, "None"),
        ] {
            assert_eq!(format!("{:?}", key_input(key)), expected, "key {key:#x}");
        }
    }

    #[test]
    fn keys_arrive_in_the_order_typed_until_the_input_ends() {
        let ((mut typist, keys), (_reader, output)) = (pair(), pair());
        let mut watcher =
            TerminalPoll { signals: &[], keys: Some(keys.as_fd()), output: Some(output.as_fd()) };
        assert_eq!(events(&mut watcher), [""; 0]);
        typist.write_all(b"ex ").unwrap();
        assert_eq!(events(&mut watcher), ["Request(Camera(Engage))", "Request(Stop(Operator))"]);
        drop(typist);
        assert_eq!(events(&mut watcher), [""; 0]);
        assert!(watcher.keys.is_none(), "an input that has ended is not read again");
    }

    #[test]
    fn a_closed_output_ends_the_run_once() {
        let (reader, output) = pair();
        let mut watcher = TerminalPoll { signals: &[], keys: None, output: Some(output.as_fd()) };
        assert_eq!(events(&mut watcher), [""; 0]);
        drop(reader);
        assert_eq!(events(&mut watcher), ["Quit(OutputClosed)"]);
        assert_eq!(events(&mut watcher), [""; 0]);
    }

    #[test]
    fn a_signal_that_comes_again_quits_again() {
        let ((mut sender, read), (_reader, output)) = (pair(), pair());
        let signals = [SignalPipe { read, name: "SIGTERM" }];
        let mut watcher = TerminalPoll { signals: &signals, keys: None, output: Some(output.as_fd()) };
        for _ in 0..2 {
            sender.write_all(b"X").unwrap();
            assert_eq!(events(&mut watcher), ["Quit(Signal(\"SIGTERM\"))"]);
        }
        assert_eq!(events(&mut watcher), [""; 0]);
    }
}
