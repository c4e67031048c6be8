//! Progress of long work: a bar on a terminal, otherwise a log line from time to time.

use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Shortest time from one log line to the next.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Progress of one piece of work.
#[derive(Debug)]
pub struct Progress {
    unit: &'static str,
    total: u64,
    bar: Option<ProgressBar>,
    logged_at: Mutex<Instant>,
}

impl Progress {
    /// Progress of `total` parts; `unit` names the parts, in the plural.
    pub fn new(unit: &'static str, total: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(total);
            let style = "{msg} {wide_bar} {pos}/{len} {eta}";
            if let Ok(style) = ProgressStyle::with_template(style) {
                bar.set_style(style);
            }
            bar.with_message(unit)
        });
        Self { unit, total, bar, logged_at: Mutex::new(Instant::now()) }
    }

    /// Sets the number of parts that are done.
    pub fn set(&self, done: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None => {
                let mut logged_at = self.logged_at.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                if logged_at.elapsed() >= LINE_INTERVAL {
                    *logged_at = Instant::now();
                    tracing::info!("{}: {done} of {}", self.unit, self.total);
                }
            }
        }
    }

    /// Removes the bar at the end of the work.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
