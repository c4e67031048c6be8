//! Log lines on stderr, as text or JSON.
//!
//! A thread of its own writes the lines, and lines are dropped while stderr is blocked: a full stderr must
//! not delay the pilot. A panic becomes a log line without a backtrace: a backtrace takes a fifth of a
//! second, in which the camera would keep turning.

use std::io::{self, IsTerminal as _, Write, stderr};
use std::panic::PanicHookInfo;

use tracing::level_filters::LevelFilter;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use crate::cli::{LogFormat, LogLevel};

/// Starts logging; to be called once, at the program's start. Lines are written until the guard is dropped.
pub fn start(level: LogLevel, format: LogFormat) -> WorkerGuard {
    let filter = match level {
        LogLevel::Error => LevelFilter::ERROR,
        LogLevel::Warn => LevelFilter::WARN,
        LogLevel::Info => LevelFilter::INFO,
        LogLevel::Debug => LevelFilter::DEBUG,
        LogLevel::Trace => LevelFilter::TRACE,
    };
    let on_terminal = stderr().is_terminal();
    let (writer, guard) = NonBlockingBuilder::default().lossy(true).finish(LogOutput { on_terminal });
    // The RTSP library warns of each oddity of a server in many lines. What matters comes as the reason of a
    // loss. The drawing library warns of each line without length.
    let of_library = if filter > LevelFilter::INFO { filter } else { LevelFilter::ERROR.min(filter) };
    let targets =
        Targets::new().with_default(filter).with_targets([("retina", of_library), ("tiny_skia", of_library)]);
    let lines = tracing_subscriber::fmt::layer().with_writer(writer).with_ansi(on_terminal);
    let registry = tracing_subscriber::registry().with(targets);
    match format {
        LogFormat::Text => registry.with(lines.with_target(false).without_time()).init(),
        LogFormat::Json => registry.with(lines.json()).init(),
    }
    std::panic::set_hook(Box::new(log_panic));
    guard
}

fn log_panic(info: &PanicHookInfo<'_>) {
    let thread = std::thread::current().name().unwrap_or("unnamed").to_owned();
    let place = info.location().map_or_else(String::new, |at| format!(" at {}:{}", at.file(), at.line()));
    let message = info.payload_as_str().unwrap_or("no message");
    tracing::error!("the {thread} thread panicked{place}: {message}");
}

/// Standard error. On a terminal, each log line first erases the status line.
struct LogOutput {
    on_terminal: bool,
}

impl Write for LogOutput {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let mut out = stderr().lock();
        if self.on_terminal {
            out.write_all(b"\r\x1b[K")?;
        }
        out.write_all(line)?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        stderr().flush()
    }
}
