//! Writes status lines on a thread of its own.
//!
//! An output without a reader, or a terminal held with Ctrl-S, must not block the pilot. A line that cannot
//! be written in time is dropped; the next line replaces it.

use std::io::{IsTerminal as _, Write, stdout};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;

use super::event::Event;
use super::faults::{FaultInjector, STATUS};
use super::inbox::{FOREVER, Inbox};
use super::status_line::StatusOutput;
use super::threads;

/// Interval between lines on a terminal.
const TERMINAL_INTERVAL: Duration = Duration::from_millis(200);
/// Interval between lines on any other output.
const PLAIN_INTERVAL: Duration = Duration::from_secs(5);
/// How long the end of the run waits for the last line.
const LAST_LINE_TIMEOUT: Duration = Duration::from_millis(200);

/// How status lines follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Each line overwrites the one before, and is cut to the width of the terminal: the rest of a longer one
    /// would stay.
    Overwritten {
        /// The width of the terminal, characters; `None`: asked for at each line.
        columns: Option<usize>,
    },
    /// Each line is a line of text.
    Plain,
}

impl LineStyle {
    /// The style for the standard output.
    pub fn for_stdout() -> Self {
        if stdout().is_terminal() { Self::Overwritten { columns: None } } else { Self::Plain }
    }

    /// Interval between two lines.
    pub const fn interval(self) -> Duration {
        match self {
            Self::Overwritten { .. } => TERMINAL_INTERVAL,
            Self::Plain => PLAIN_INTERVAL,
        }
    }
}

/// The thread that writes status lines.
#[derive(Debug)]
pub struct StatusWriter {
    lines: Option<SyncSender<String>>,
    thread: Option<JoinHandle<()>>,
}

impl StatusWriter {
    /// Starts the thread.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn start(
        output: impl Write + Send + 'static,
        style: LineStyle,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
    ) -> std::io::Result<Self> {
        let (lines, queue) = sync_channel(1);
        let thread = threads::spawn("status", events, move || {
            write_lines(&mut *fault_injector.inbox(STATUS, clock, queue), output, style);
        })?;
        Ok(Self { lines: Some(lines), thread: Some(thread) })
    }
}

impl StatusOutput for StatusWriter {
    fn show(&self, line: String) {
        if let Some(lines) = &self.lines {
            // The queue is full while the line before is not written yet: this line is dropped.
            let _ = lines.try_send(line);
        }
    }
}

impl Drop for StatusWriter {
    fn drop(&mut self) {
        self.lines = None;
        // The program ends without a thread that cannot finish its last line.
        let deadline = Instant::now() + LAST_LINE_TIMEOUT;
        while self.thread.as_ref().is_some_and(|thread| !thread.is_finished()) && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// The width of the terminal of the standard output; `None` where the output is none, or does not say.
fn terminal_columns() -> Option<usize> {
    let size = rustix::termios::tcgetwinsize(stdout()).ok()?;
    (size.ws_col > 0).then_some(usize::from(size.ws_col))
}

/// A line that leaves the last column of a terminal free; a longer one ends with an ellipsis.
fn cut_to(line: String, columns: Option<usize>) -> String {
    match columns {
        Some(columns) if line.chars().count() >= columns => {
            line.chars().take(columns.saturating_sub(2)).chain(['\u{2026}']).collect()
        }
        _ => line,
    }
}

fn write_lines(queue: &mut dyn Inbox<String>, mut output: impl Write, style: LineStyle) {
    let mut is_line_open = false;
    while let Ok(line) = queue.next(FOREVER) {
        // The terminal thread reports a closed output; here a line that cannot be written is ignored.
        let _ = match style {
            LineStyle::Overwritten { columns } => {
                is_line_open = true;
                let line = cut_to(line, columns.or_else(terminal_columns));
                write!(output, "\r\x1b[K{line}").and_then(|()| output.flush())
            }
            LineStyle::Plain => writeln!(output, "{line}"),
        };
    }
    if is_line_open {
        let _ = writeln!(output);
    }
}
